"""A fit's numbers in the form that filters and simulators take.

Start with `export`, which turns a fit's JSON into the text of another program's file. For a
filter of one's own, `realise` gives the parts of a state-space model, `stack` puts parts of any
origin together, and `discretise` gives its matrices at a time step.
"""

from ._effect_parts import gauss_markov as gauss_markov
from ._errors import ExportError as ExportError
from ._export import FORMATS as FORMATS
from ._export import export as export
from ._exported import Exported as Exported
from ._gauss_markov import Approximation as Approximation
from ._gauss_markov import Relaxation as Relaxation
from ._gauss_markov import fit_relaxations as fit_relaxations
from ._options import Options as Options
from ._options import parse_walk as parse_walk
from ._parts import Realised as Realised
from ._parts import realise as realise
from ._read import FitChannel as FitChannel
from ._read import FitFile as FitFile
from ._read import read_fit as read_fit
from ._state_space import DiscreteSystem as DiscreteSystem
from ._state_space import Part as Part
from ._state_space import State as State
from ._state_space import System as System
from ._state_space import discretise as discretise
from ._state_space import stack as stack
