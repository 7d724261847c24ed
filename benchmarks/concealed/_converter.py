"""Causes in converter and logger, which leave the spectrum alone and show in the values.

Their strength is that of a witness: how well one sees it who knows where to look. Those whose
values give them away at once are drawn strong only, not to pad the figures at the threshold.
"""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from scipy.stats import norm

from ._effect import Effect
from ._strength import deviation, five_terms, information, innovation


@dataclass(frozen=True)
class Outliers(Effect):
    """Normal errors of deviation `amplitude`, added to a fraction of the samples."""

    name: ClassVar[str] = "outliers"
    fraction: float
    amplitude: float

    @classmethod
    def draw(cls, rng, device):
        return cls(float(np.exp(rng.uniform(np.log(1e-4), np.log(3e-3)))), 1.0)

    def sized(self, size):
        return replace(self, amplitude=size)

    def bracket(self, device):
        return 0.1 * innovation(device), 1e3 * innovation(device)

    def converter(self, rng, device, x):
        hit = rng.random(x.size) < self.fraction
        return x + hit * self.amplitude * rng.standard_normal(x.size)

    def strength(self, device):
        """2 n KL(mixture || normal of the same variance), in white noise of `innovation`."""
        size = self.amplitude / innovation(device)
        wide, p = np.sqrt(1 + size**2), self.fraction
        reach = np.sinh(np.linspace(0, np.arcsinh(12 * wide), 4000))
        mixture = (1 - p) * norm.pdf(reach) + p * norm.pdf(reach, scale=wide)
        plain = norm.logpdf(reach, scale=np.sqrt(1 + p * size**2))
        # The tail of the mixture beyond double precision holds nothing.
        gain = mixture * (np.log(np.maximum(mixture, 1e-300)) - plain)
        return float(4 * device.samples * np.trapezoid(gain, reach))

    def scored(self, device):
        return {"fraction": self.fraction, "amplitude": self.amplitude}


@dataclass(frozen=True)
class OutputRounding(Effect):
    name: ClassVar[str] = "output_rounding"
    levels: ClassVar[tuple[int, ...]] = (100, 400)
    lsb: float

    @classmethod
    def draw(cls, rng, device):
        return cls(1.0)

    def sized(self, size):
        return replace(self, lsb=size)

    def bracket(self, device):
        return 1e-3 * deviation(device), 3 * deviation(device)

    def converter(self, rng, device, x):
        return np.round(x / self.lsb) * self.lsb

    def strength(self, device):
        """How much the rounding matters: n/2 <(lsb^2 dt/6 / S)^2>, as if N were known.

        Whoever looks at the codes sees far finer ones; finer ones change nothing.
        """
        frequency = (np.arange(200) + 0.5) / 400 * device.rate_hz
        added = self.lsb**2 * device.dt / 6
        return float(device.samples / 2 * np.mean((added / five_terms(device)(frequency)) ** 2))

    def scored(self, device):
        return {"lsb": self.lsb}


@dataclass(frozen=True)
class SampleHold(Effect):
    """Each entry repeats the last one with this chance: polled faster than converted."""

    name: ClassVar[str] = "sample_hold"
    levels: ClassVar[tuple[int, ...]] = (100, 400, 10_000)
    chance: float

    @classmethod
    def draw(cls, rng, device):
        return cls(0.5)

    def sized(self, size):
        return replace(self, chance=size / (1 + size))

    def bracket(self, device):
        return 1e-5, 4.0

    def hold(self, rng, device, index):
        fresh = rng.random(index.size) >= self.chance
        fresh[0] = True
        return np.maximum.accumulate(np.where(fresh, index, 0))

    def _density(self, device, frequency):
        """Of white noise of the samples' variance, held: correlation chance^k."""
        power = device.term("N") ** 2 / device.dt
        p, turn = self.chance, np.exp(-2j * np.pi * frequency * device.dt)
        held = 2 * device.dt * power * (1 - p**2) / abs(1 - p * turn) ** 2
        return five_terms(device)(frequency) - 2 * device.term("N") ** 2 + held

    def strength(self, device):
        """By the spectrum, for the white part; the repeats themselves are plainer."""
        return float(information(device, lambda f: self._density(device, f))[1].sum())

    def scored(self, device):
        return {"repeat": 1 / (1 - self.chance)}


@dataclass(frozen=True)
class DroppedSamples(Effect):
    """Entries lost and the log closed up; time stamps, which the log has, tell where."""

    name: ClassVar[str] = "dropped_samples"
    levels: ClassVar[tuple[int, ...]] = (400,)
    count: int

    @classmethod
    def draw(cls, rng, device):
        return cls(1)

    def sized(self, size):
        return replace(self, count=round(size))

    def bracket(self, device):
        return 10, 0.05 * device.samples

    def lost(self, device):
        return self.count

    def keep(self, rng, device, index):
        return np.delete(index, rng.choice(index.size - 2, self.count, replace=False) + 1)

    def strength(self, device):
        """Two a gap: each is far wider than the stamps' jitter."""
        return 2.0 * self.count

    def scored(self, device):
        return {"fraction": self.count / (device.samples + self.count)}


@dataclass(frozen=True)
class Saturation(Effect):
    """Rails at plus and minus `limit`."""

    name: ClassVar[str] = "saturation"
    limit: float

    @classmethod
    def draw(cls, rng, device):
        return cls(1.0)

    def sized(self, size):
        """Size is the inverse of the distance between the offset and the nearer rail."""
        return replace(self, limit=1 / size)

    def bracket(self, device):
        return 1 / (abs(device.offset) + 6 * deviation(device)), 1 / (
            abs(device.offset) + 0.5 * deviation(device)
        )

    def converter(self, rng, device, x):
        return np.clip(x, -self.limit, self.limit)

    def strength(self, device):
        """Two a sample on a rail: a handful of equal extremes gives it away."""
        rails = np.abs(np.array([-1, 1]) * self.limit - device.offset)
        normal = replace(device, coefficients={**device.coefficients, "Q": 0.0})
        # Of two angle errors, each uniform, the difference is triangular.
        error = np.linspace(-1, 1, 401) * np.sqrt(12) * device.term("Q") / device.dt
        chance = 1 - np.abs(np.linspace(-1, 1, 401))
        beyond = norm.sf((rails[:, None] - error) / deviation(normal))
        return float(2 * device.samples * np.average(beyond, axis=1, weights=chance).sum())

    def scored(self, device):
        return {"limit": self.limit}
