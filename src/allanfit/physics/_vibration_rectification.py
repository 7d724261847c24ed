"""Vibration rectification: vibration that shifts the bias."""

from typing import ClassVar

from jaxtyping import Array, Float, PRNGKeyArray

from ._effect import SIGNED, AbstractEffect, Parameter
from ._filtering import running_mean
from ._term import Sampling


class VibrationRectification(AbstractEffect):
    """The bias shifts by `coefficient` [1/u] times the mean square of the vibration [u^2].

    The vibration is what differs from the running mean over a second, its mean square is over a
    second too (IEEE Std 1293, vibration rectification error).
    """

    coefficient: Float[Array, ""]
    name: ClassVar[str] = "vibration_rectification"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("coefficient", "1/u", range=SIGNED),)
    what: ClassVar[str] = "a bias that shifts with vibration (vibration rectification)"
    origin: ClassVar[str] = "a scale that is not linear, or clipping within the sensor"

    def apply(
        self, key: PRNGKeyArray, samples: Float[Array, " samples"], dt: float, sampling: Sampling
    ) -> Float[Array, " samples"]:
        """Samples and the shift added; nothing is drawn."""
        fast = samples - running_mean(samples, dt)
        return samples + self.coefficient * running_mean(fast**2, dt)
