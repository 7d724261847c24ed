"""The five terms and effects beside them, fitted to a binned spectrum together.

A structure is a choice of effects: at most one that shapes the spectrum, and some noises that add
to it. Everything is for a sampling interval of one: times in samples, frequencies in cycles per
sample. The expected density is

    bump(f) notches(f) (H(f) (N + B + K) + Q + foreign + added noises),

with the filter H in front of the converter, whose angle quantization it does not see; aliases of
what passes are in it. A part of N may be a floor, which comes in behind the filter. A filter behind
the converter passes H(f) Q instead, and one that comes last the added noises as well. `foreign` is
white noise of known size that does not belong to N, and that no filter sees.
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import scipy.special
from jaxtyping import Array, Bool, Float

from ...physics import (
    MOST_POLES,
    DriftingLine,
    GaussMarkov,
    LowPass,
    PowerLaw,
    Resonance,
    Sampling,
    lowest_cutoff,
)
from ._ordinates import Bins

#: Noises that a structure may add, and what may shape it, by name.
ADDED = {effect.name: effect for effect in (GaussMarkov, Resonance, PowerLaw, DriftingLine)}
#: In front of the converter, which takes values or averages, so that what passes folds; or behind
#: it, in the sensor's processor.
FREE_FILTERS = ("low_pass", "averaged_low_pass", "digital_low_pass")
#: Behind it too, of poles alone. Without a droop it is a single pole, as in front of it.
RECURSIVE = "recursive_low_pass"
#: All of these, of two poles: of order two with a droop, and so of two free numbers as well.
_TWO_POLES, _DROOPING = "two_pole_", "drooping_"
TWO_POLES = tuple(_TWO_POLES + name for name in (*FREE_FILTERS, RECURSIVE))
#: The same, of any order.
DROOPING = tuple(_DROOPING + name for name in (*FREE_FILTERS, RECURSIVE))
#: What droops.
DROOPS = (*TWO_POLES, *DROOPING)
#: Behind it, of whole numbers of samples and times, or in front of it, as it samples much faster:
#: their two numbers are looked up, not fitted.
RUNNING_MEAN, OVERSAMPLED = "running_mean", "oversampled_mean"
MEANS = (RUNNING_MEAN, OVERSAMPLED)
#: Behind it too, with an edge as steep as a long response makes it.
WINDOWED = "windowed_low_pass"
#: Behind it and in front of it, elliptic filters of such orders; one program serves all orders.
EQUIRIPPLE, ANALOGUE_EQUIRIPPLE = "equiripple", "analogue_equiripple"
RIPPLED = tuple(
    f"{kind}_{order}"
    for kind in (EQUIRIPPLE, ANALOGUE_EQUIRIPPLE)
    for order in range(2, MOST_POLES + 1)
)
#: What has no zeros but at half the rate.
OF_POLES = (*FREE_FILTERS, RECURSIVE, *DROOPS)
#: What has no name: a bump about one frequency, a lack toward zero, or a narrow one, of which a
#: structure may have several beside what else shapes it.
HIGH_PASS = "high_pass"
FLAT = "flat_bump"
NOTCH = "notch"
#: Or what each sample repeats of one before.
ECHO = "echo"
UNNAMED = ("bump", HIGH_PASS, FLAT, ECHO)
EQUIRIPPLES = (EQUIRIPPLE, ANALOGUE_EQUIRIPPLE)
FILTERS = (*FREE_FILTERS, RECURSIVE, *DROOPS, *MEANS, WINDOWED, *EQUIRIPPLES, *RIPPLED)
#: Noises of one narrow band.
NARROW = ("resonance", "drifting_line")
#: In dB. Inverse Chebyshev filters have none: their corner is far beyond the edge of a pass band
#: that has next to none.
RIPPLE = (1e-12, 3.0)
#: Less is not told from nothing.
LEFT = (1e-6, 1.0)
TERMS = 4
#: Which of them is N.
WHITE = 1
# Of each effect: its size, and two numbers that say its shape, the second idle for some.
EACH = 3
#: Of what shapes the spectrum how it droops, or has ripple, in place of a size; and its floor.
SHAPING = EACH + 1
SHAPE = slice(TERMS, TERMS + SHAPING)
FLOOR = -60.0
# Behind a filter; more of the white noise is no floor but most of it.
_HIGHEST_FLOOR = 0.9


class Kinds(NamedTuple):
    """What a structure holds.

    Its parameters are the log powers of Q, N, B, K, then four numbers of what shapes the spectrum,
    three of each notch, and three of each added noise.
    """

    #: One of `FILTERS`, of `UNNAMED`, or none.
    shaping: str | None = None
    #: Names of the added noises, in the order of their parameters.
    added: tuple[str, ...] = ()
    #: Whether the filter comes last, so that added noises pass it as well.
    last: bool = False
    #: Whether white noise comes in behind the filter.
    floored: bool = False
    #: How many notches there are.
    notches: int = 0

    @property
    def first_notch(self) -> int:
        """Where the parameters of the first notch begin."""
        return TERMS + SHAPING * (self.shaping is not None)

    @property
    def first_slot(self) -> int:
        """Where the parameters of the first added noise begin."""
        return self.first_notch + EACH * self.notches

    @property
    def names(self) -> tuple[str, ...]:
        """All effects by the names of the catalogue, what shapes first, then notches."""
        shapes = () if self.shaping is None else ("low_pass" if self.filtering else "bump",)
        return shapes + ("bump",) * self.notches + self.added

    @property
    def filtering(self) -> bool:
        """Whether it holds a low-pass filter of either kind."""
        return self.shaping in FILTERS

    @property
    def angle_filtered(self) -> bool:
        """Whether quantization comes before the filter, as in a converter before a processor."""
        behind = ("digital_low_pass", RECURSIVE, RUNNING_MEAN, WINDOWED, EQUIRIPPLE)
        return without_droop(self.shaping or "") in behind


class Data(NamedTuple):
    """A binned spectrum beside what is known of it before the fit."""

    bins: Bins
    #: Samples of the longest stretch.
    samples: float | Float[Array, ""]
    #: White density that is not N [u^2].
    foreign: float | Float[Array, ""]
    #: Mean samples for each fresh value where they are repeated at random; 1 if they are not.
    repeat: float
    #: Which of Q, N, B, K the structure has.
    terms: Bool[np.ndarray, " terms"] | Bool[Array, " terms"]
    #: One if samples are averages over their interval, else zero.
    averaging: float = 0.0

    @property
    def sampling(self) -> Sampling:
        return "averaged" if self.averaging else "point"


def without_droop(shaping: str) -> str:
    """The filter of the same place that does not droop, of any ripple; anything else as it is."""
    if shaping in RIPPLED:
        return shaping.rpartition("_")[0]
    return shaping.removeprefix(_DROOPING).removeprefix(_TWO_POLES)


def with_order(shaping: str, fours: Any) -> Any:
    """Free parameters of a filter, of some starts, and the order of one that has ripple."""
    if shaping not in RIPPLED:
        return fours
    return np.pad(fours, ((0, 0), (0, 1)), constant_values=poles(shaping))


def poles(shaping: str) -> float:
    """The order of a filter that has ripple."""
    return float(shaping.rpartition("_")[2])


def ripple_of(three: Any) -> Float[Array, "..."]:
    """Of a filter that has any, in dB."""
    return between(three[0], *RIPPLE)


def droop_of(three: Any) -> Float[Array, "..."]:
    """From -3, a high peak, to 1, a single pole; 0 at 0."""
    return 1 - 4 * jax.nn.sigmoid(-three[0] - jnp.log(3))


def left_of(three: Any) -> Float[Array, "..."]:
    """The part of the power that a notch leaves at its middle."""
    return between(three[0], *LEFT)


def part_of(three: Any) -> Float[Array, "..."]:
    """The part of an earlier sample that an echo adds, of either sign."""
    return jnp.tanh(three[0])


def floor_of(four: Any) -> Float[Array, "..."]:
    """White noise that comes in behind a filter, over all that there is at zero frequency [dB]."""
    return 10 / np.log(10) * (jax.nn.log_sigmoid(four[EACH]) + np.log(_HIGHEST_FLOOR))


def free_floor(part: float) -> float:
    """The free parameter of a floor that is such a part of the white power."""
    return float(scipy.special.logit(min(part / _HIGHEST_FLOOR, 0.99)))


def sieve(shaping: str, four: Any, samples: Any) -> LowPass:
    """A filter from its four free parameters, the first of which says how it droops if it does."""
    kind = without_droop(shaping)
    floor = None if kind in MEANS else floor_of(four)
    if kind in EQUIRIPPLES:
        cutoff, attenuation = shape_of(kind, four, samples)
        order = four[SHAPING] if shaping == kind else jnp.asarray(poles(shaping))
        return LowPass(
            cutoff,
            order,
            ripple=ripple_of(four),
            attenuation=attenuation,
            floor=floor,
            digital=kind == EQUIRIPPLE,
        )
    return LowPass(
        *shape_of(kind, four, samples),
        # A droop of nothing too: one program serves filters that droop and those that do not.
        droop=None if kind in (*MEANS, WINDOWED) else droop_of(four),
        floor=floor,
        digital=kind == "digital_low_pass",
        averaged=kind == "averaged_low_pass",
        recursive=kind == RECURSIVE,
        running_mean=kind in MEANS,
        oversampled=kind == OVERSAMPLED,
        windowed=kind == WINDOWED,
    )


def bounds(name: str, samples: Any) -> tuple[tuple[Any, Any], tuple[Any, Any]]:
    """Where the shape of an effect is looked for, in samples and cycles per sample."""
    return {
        # Slower than a sixth of the record it is a random walk or a ramp.
        "gauss_markov": ((0.2, samples / 6), (0.5, 2.0)),
        # With less quality it is two relaxations.
        "resonance": ((2 / samples, 0.499), (0.5, 3000.0)),
        "power_law": ((0.15, 2.95), (0.5, 2.0)),
        # The width is relative: what wanders by more than a tenth of its frequency is no line.
        "drifting_line": ((2 / samples, 0.499), (0.3 / samples, 0.1)),
        "low_pass": ((0.003, 3.0), (0.7, 8.0)),
        "averaged_low_pass": ((0.003, 3.0), (0.7, 8.0)),
        "digital_low_pass": ((0.003, 0.49), (0.7, 8.0)),
        RECURSIVE: ((0.003, 0.49), (0.7, 8.0)),
        RUNNING_MEAN: ((0.003, 0.49), (0.7, 8.0)),
        OVERSAMPLED: ((0.003, 0.49), (0.7, 8.0)),
        # Of fewer samples it is much like the others.
        WINDOWED: ((0.01, 0.49), (8.0, 500.0)),
        # The attenuation.
        EQUIRIPPLE: ((0.01, 0.49), (15.0, 150.0)),
        ANALOGUE_EQUIRIPPLE: ((0.01, 1.0), (15.0, 150.0)),
        "bump": ((2 / samples, 0.5), (0.03, 3.0)),
        # Flanks are seen where they are some bins apart, of which 48 make a decade.
        FLAT: ((2 / samples, 0.5), (0.1, 3.0)),
        NOTCH: ((2 / samples, 0.499), (0.003, 1.0)),
        HIGH_PASS: ((0.5 / samples, 0.3), (0.05, 0.9)),
        # From one ripple to as many as bins tell apart.
        ECHO: ((0.01, 0.5), (0.5, 2.0)),
    }[without_droop(name)]


def between(u: Any, low: Any, high: Any) -> Float[Array, "..."]:
    """A number between two positive ones, from any real one: logistic in the logarithm."""
    return jnp.exp(jnp.log(low) + (jnp.log(high) - jnp.log(low)) * jax.nn.sigmoid(u))


def free(value: float, low: float, high: float) -> float:
    """The inverse of `between`, on the host."""
    part = np.clip((np.log(value) - np.log(low)) / (np.log(high) - np.log(low)), 1e-3, 1 - 1e-3)
    return float(np.log(part / (1 - part)))


def free_filter(
    kind: str, cutoff: float, order: float, samples: Any, droop: float = 0.0
) -> list[float]:
    """The free parameters of a filter, `droop` being a free one already."""
    first, second = bounds(kind, samples)
    return [droop, free(cutoff, *first), free(order, *second)]


def shape_of(
    name: str, three: Any, samples: Any
) -> tuple[Float[Array, "..."], Float[Array, "..."]]:
    """The two shape parameters of an effect from its three free ones.

    Of a filter a cut-off frequency and an order, or the attenuation of one that has ripple.
    """
    first, second = bounds(name, samples)
    place, breadth = between(three[1], *first), between(three[2], *second)
    if name == WINDOWED:
        place = jnp.maximum(place, lowest_cutoff(breadth))
    return place, breadth


def active(kinds: Kinds, terms: Any) -> Bool[np.ndarray, " parameters"]:
    """Which parameters are not idle."""
    flags = []
    if kinds.filtering:
        # A filter has no size.
        flags += [kinds.shaping in (*DROOPS, *RIPPLED), kinds.shaping not in MEANS]
        flags += [kinds.shaping not in (*MEANS, *TWO_POLES), kinds.floored]
    elif kinds.shaping is not None:
        flags += [True, True, kinds.shaping != ECHO, False]
    flags += [True] * (EACH * kinds.notches)
    for name in kinds.added:
        # Some noises have one number for their shape.
        flags += [True, True, name not in ("gauss_markov", "power_law")]
    return np.concatenate([np.asarray(terms), np.asarray(flags, bool)])
