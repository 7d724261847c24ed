"""What makes a sensor noisy: one file a term or an effect, and the model that adds the terms.

Start with `standard_model`, the five terms of IEEE Std 952; `EFFECTS` are what else may be there.
"""

from ._bias_instability import ALLAN_FLOOR as ALLAN_FLOOR
from ._bias_instability import BiasInstability as BiasInstability
from ._bump import Bump as Bump
from ._catalogue import EFFECTS as EFFECTS
from ._catalogue import effect_from as effect_from
from ._catalogue import field_of as field_of
from ._disturbance import Disturbance as Disturbance
from ._drifting_line import DriftingLine as DriftingLine
from ._dropped_samples import DroppedSamples as DroppedSamples
from ._effect import SIGNED as SIGNED
from ._effect import ZERO_OR_MORE as ZERO_OR_MORE
from ._effect import AbstractAddedNoise as AbstractAddedNoise
from ._effect import AbstractEffect as AbstractEffect
from ._effect import AbstractFilter as AbstractFilter
from ._effect import AbstractMean as AbstractMean
from ._effect import Parameter as Parameter
from ._effect import Range as Range
from ._effect_units import parameter_unit as parameter_unit
from ._effect_units import parameter_values as parameter_values
from ._effect_units import scaled as scaled
from ._effect_units import unit_power as unit_power
from ._gauss_markov import GaussMarkov as GaussMarkov
from ._low_pass import LowPass as LowPass
from ._low_pass import lowest_cutoff as lowest_cutoff
from ._low_pass import running_mean_gain as running_mean_gain
from ._model import STANDARD_TERMS as STANDARD_TERMS
from ._model import SYMBOLS as SYMBOLS
from ._model import NoiseModel as NoiseModel
from ._model import standard_model as standard_model
from ._outliers import Outliers as Outliers
from ._output_rounding import OutputRounding as OutputRounding
from ._power_law import PowerLaw as PowerLaw
from ._quantization import QuantizationNoise as QuantizationNoise
from ._random_telegraph import RandomTelegraph as RandomTelegraph
from ._rate_ramp import RateRamp as RateRamp
from ._rate_random_walk import RateRandomWalk as RateRandomWalk
from ._recording import draw_recording as draw_recording
from ._resonance import Resonance as Resonance
from ._sample_hold import SampleHold as SampleHold
from ._sample_hold import held_factor as held_factor
from ._saturation import Saturation as Saturation
from ._sinusoid import Sinusoid as Sinusoid
from ._step import Step as Step
from ._temperature import Temperature as Temperature
from ._term import AbstractNoiseTerm as AbstractNoiseTerm
from ._term import Names as Names
from ._term import Sampling as Sampling
from ._term import check_sampling as check_sampling
from ._term import coefficient_unit as coefficient_unit
from ._variance_modulation import VarianceModulation as VarianceModulation
from ._vibration_rectification import VibrationRectification as VibrationRectification
from ._warm_up import WarmUp as WarmUp
from ._white_noise import WhiteNoise as WhiteNoise
