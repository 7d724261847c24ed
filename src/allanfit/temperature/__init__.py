"""Temperature beside the data: how far it moves a sensor, told apart from the sensor's own noise.

Start with `temperature_sensitivity`.
"""

from ._band import believable as believable
from ._channel import ChannelTemperature as ChannelTemperature
from ._channel import Treatment as Treatment
from ._channel import beside as beside
from ._channel import effect_beside as effect_beside
from ._channel import sentences as sentences
from ._channel import temperature_document as temperature_document
from ._sensitivity import TemperatureEffect as TemperatureEffect
from ._sensitivity import temperature_sensitivity as temperature_sensitivity
