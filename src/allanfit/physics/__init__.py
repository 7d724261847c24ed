"""What makes a sensor noisy: one file a term, and the model that adds them.

Start with `standard_model`, the five terms of IEEE Std 952.
"""

from ._bias_instability import BiasInstability as BiasInstability
from ._model import STANDARD_TERMS as STANDARD_TERMS
from ._model import SYMBOLS as SYMBOLS
from ._model import NoiseModel as NoiseModel
from ._model import standard_model as standard_model
from ._quantization import QuantizationNoise as QuantizationNoise
from ._rate_ramp import RateRamp as RateRamp
from ._rate_random_walk import RateRandomWalk as RateRandomWalk
from ._term import AbstractNoiseTerm as AbstractNoiseTerm
from ._term import Names as Names
from ._term import Sampling as Sampling
from ._term import coefficient_unit as coefficient_unit
from ._white_noise import WhiteNoise as WhiteNoise
