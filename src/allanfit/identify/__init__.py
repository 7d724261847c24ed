"""From curves to coefficients: least squares, posterior, and whether the model fits.

Start with `fit` for one sensor, `fit_many` for a batch, `sample` for emcee's posterior.
"""

from ._estimate import Estimate as Estimate
from ._file_fit import fit_file as fit_file
from ._fit import Fit as Fit
from ._fit import fit_series as fit_series
from ._influence import Influence as Influence
from ._influence import influence as influence
from ._many import fit_many as fit_many
from ._recording_fit import ChannelFit as ChannelFit
from ._recording_fit import RecordingFit as RecordingFit
from ._recording_fit import fit as fit
from ._recording_fit import fit_recording as fit_recording
from ._sample import Posterior as Posterior
from ._sample import sample as sample
