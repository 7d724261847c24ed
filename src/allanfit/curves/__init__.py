"""The two curves of a record, what the model expects of them, and how they vary together.

Start with `allan_variance` and `psd`.
"""

from ._allan import allan_variance as allan_variance
from ._cluster_sizes import cluster_sizes as cluster_sizes
from ._covariance import JointCovariance as JointCovariance
from ._covariance import allan_variance_deviation as allan_variance_deviation
from ._covariance import joint_covariance as joint_covariance
from ._design import Design as Design
from ._design import design as design
from ._design import mode_variances as mode_variances
from ._design import unit_scale as unit_scale
from ._ends import ends_matter as ends_matter
from ._ends import even_ends as even_ends
from ._input import as_series as as_series
from ._long import LongAllanVariance as LongAllanVariance
from ._long_statistics import LongStatistics as LongStatistics
from ._psd import Spectrum as Spectrum
from ._psd import psd as psd
from ._slope_reading import octaves as octaves
from ._slope_reading import read_slopes as read_slopes
from ._slope_reading import slope_reading as slope_reading
from ._spectrum import cosine_coefficients as cosine_coefficients
from ._spectrum import slow_part as slow_part
from ._statistics import Statistics as Statistics
from ._statistics import statistics as statistics
from ._statistics import statistics_on_host as statistics_on_host
