"""N of a sensor whose values are repeated in the log, as a filter meets it."""

from dataclasses import replace

from ..formatting import significant
from ..physics import LowPass, SampleHold, held_factor
from ._read import FitChannel, FitFile


def at_low_frequency(fit: FitFile) -> tuple[FitFile, list[str]]:
    """The fit with N of held values as they reach a filter, and a sentence for each such channel.

    Explain tells N of the fresh values at the rate of the log.
    """
    channels, said = [], []
    for channel in fit.channels:
        held = [effect for effect in channel.effects if isinstance(effect, SampleHold)]
        if held:
            before = next((each for each in channel.effects if isinstance(each, LowPass)), None)
            repeat = float(held[0].repeat)
            factor = held_factor(repeat, held[0].regular, before, channel.rate_hz)
            channels.append(_louder(channel, factor))
            said.append(
                f"N of {channel.name} is {significant(factor)} times that of the fresh values at "
                "the rate of the log, which are repeated: it is N at low frequency, which filters "
                "meet."
            )
        else:
            channels.append(channel)
    return replace(fit, channels=channels), said


def _louder(channel: FitChannel, factor: float) -> FitChannel:
    white = channel.coefficients["N"]
    louder = {"N": white.times(factor, white.unit)}
    return replace(channel, coefficients=channel.coefficients | louder)
