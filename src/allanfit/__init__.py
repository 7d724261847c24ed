"""allanfit identifies the noise of inertial sensors from still recordings."""

# First, since all else takes a second to load, in which Ctrl-C is told in one line.
from . import _interrupt as _interrupt

# isort: split
from importlib.metadata import version as _version

from . import calibrate as calibrate
from .curves import LongAllanVariance as LongAllanVariance
from .curves import allan_variance as allan_variance
from .curves import cluster_sizes as cluster_sizes
from .curves import psd as psd
from .curves import slope_reading as slope_reading
from .datasheet import Datasheet as Datasheet
from .datasheet import read_datasheet as read_datasheet
from .explain import Explanation as Explanation
from .explain import explain as explain
from .file_curves import FileCurves as FileCurves
from .file_curves import curves_of_file as curves_of_file
from .identify import Fit as Fit
from .identify import Influence as Influence
from .identify import fit as fit
from .identify import fit_file as fit_file
from .identify import fit_many as fit_many
from .identify import influence as influence
from .identify import sample as sample
from .plan import Plan as Plan
from .plan import plan as plan
from .recording import Recording as Recording
from .recording import RecordingError as RecordingError
from .recording import load as load
from .recording import recording_of as recording_of
from .simulate import simulate as simulate
from .temperature import TemperatureEffect as TemperatureEffect
from .temperature import temperature_sensitivity as temperature_sensitivity

__version__ = _version("allanfit")
