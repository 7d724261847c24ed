"""allanfit identifies the noise of inertial sensors from still recordings."""

from importlib.metadata import version as _version

from .curves import allan_variance as allan_variance
from .curves import cluster_sizes as cluster_sizes
from .curves import psd as psd
from .identify import Fit as Fit
from .identify import fit as fit
from .identify import fit_many as fit_many
from .identify import sample as sample
from .recording import Recording as Recording
from .recording import RecordingError as RecordingError
from .recording import load as load
from .simulate import simulate as simulate

__version__ = _version("allanfit")
