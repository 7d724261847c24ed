"""Single samples that are wrong, among noise that is not white: errors in transmission.

Behind a filter, a record made white shows one wrong sample as many, for its inverse rings. What all
other samples leave open about one is little there. A sample less what they expect, by the inverse
of the covariance, is the matched filter of such an error; in white noise it is the sample itself.
"""

from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.fft import irfft
from scipy.ndimage import maximum_filter1d
from scipy.sparse.linalg import LinearOperator, cg
from scipy.stats import binom, chi2, norm

from ...recording._spikes import deviation
from .._refit import rebin, refit
from .._state import Investigation, between_even_ends
from ..spectrum._ordinates import amplitudes
from ..spectrum._whiten import END, KERNEL, kernel_density, level, mode_frequency, precision, shaped

# A white record shows a wrong sample in one place if it keeps so much of its height.
_WHITE = 0.9
# What others say of one may come from slow noise for such a part.
_DRIFTS = 0.4
# Of what stands out this near together, the highest is the one that is wrong, or the first of them;
# slower noise is no matter of single samples. Where quantization rules, an error is seen in the sum
# of some samples: there as near as its response is this high, but no further than so many samples.
_NEAR, _HIGH, _FARTHEST = 16, 0.003, 128
# What is lower than the highest by more than this may be its echo.
_ECHO = 0.5
# The lower wrong samples stand out once the spectrum is known without the higher ones. Most records
# need three passes of six rounds; without an end two places might change about.
_PASSES, _ROUNDS = 6, 30
# A loss is told within such a part of as near as errors are told from one another.
_BESIDE = 4
# Solved so exactly, errors of what others expect are far below the noise.
_EXACT, _MOST_STEPS = 1e-5, 200
# So many times as far from one another as they are told apart errors are near together still, and
# the chance of so many near together from which on they are no single samples.
_CLOSE, _TOGETHER = 4, 1e-6


class Others:
    """What all other samples say of each, by the spectrum that is left."""

    def __init__(self, state: Investigation, sizes: list[int] | None = None) -> None:
        """By stretches of such `sizes`, or as long as they are."""
        expected = level(state.left, state.variance)
        self._sizes = sizes or [stop - start for start, stop in state.long_pieces]
        self._weights = [precision(size, state.left, expected) for size in self._sizes]
        every = np.concatenate(self._weights)
        exact = float(np.sqrt(np.mean(every)))
        #: Whether a record made white shows an error in one sample, and they say nothing of one.
        self.white = float(np.mean(np.sqrt(every))) > _WHITE * exact
        #: The standard deviation of what they `contradict` of the noise itself [1/u]: more than
        #: expected at the edge of a filter that is not found yet, where the spectrum is smoothed.
        self.spread = exact
        if sizes is None:
            contradicted = self.contradict(state.calm[state.looked_at])
            self.spread = max(exact, deviation(contradicted))
        #: How tall an error of one unit is over what they leave open [1/u].
        self.height = exact**2 / self.spread
        #: Samples within which one is told from another.
        self.near = _NEAR
        if self._drifts():
            response = np.asarray(irfft(1 / kernel_density(state.left, expected), KERNEL))
            high = np.abs(response[:_FARTHEST]) > _HIGH * response[0]
            self.near = max(_NEAR, int(np.flatnonzero(high)[-1]) + 1)
        #: Whether they are not to be asked which samples are wrong: where quantization rules, they
        #: contradict each drift and step as well.
        self.silent = self.white or self._drifts()

    @property
    def slowest(self) -> float:
        """Slower than this [cycles per sample] noise is no matter of single samples."""
        return 1 / (2 * self.near)

    def _drifts(self) -> bool:
        """Whether what they say of one comes from slow noise."""
        slow = [
            float(np.sum(weights[mode_frequency(weights.size) < self.slowest]))
            for weights in self._weights
        ]
        return sum(slow) > _DRIFTS * float(sum(map(np.sum, self._weights)))

    def contradict(
        self, values: Float[np.ndarray, " looked_at"], *, slowest: float = 0.0
    ) -> Float[np.ndarray, " looked_at"]:
        """How far each is from what they expect, times the mean of their weights [1/u].

        From the frequency `slowest` on [cycles per sample].
        """
        fast = [np.where(mode_frequency(w.size) < slowest, 0.0, w) for w in self._weights]
        return self._shaped(values, fast)

    def _shaped(
        self, values: Float[np.ndarray, " looked_at"], gains: list[Float[np.ndarray, " _"]]
    ) -> Float[np.ndarray, " looked_at"]:
        """The modes of each stretch times `gains` of its own."""
        pieces = np.split(values, np.cumsum(self._sizes)[:-1])
        return np.concatenate([shaped(*each) for each in zip(pieces, gains, strict=True)])

    def ring_on(
        self, values: Float[np.ndarray, " looked_at"], at: Int[np.ndarray, " at"]
    ) -> Bool[np.ndarray, " at"]:
        """Whether `values` without the errors `at` some samples are loud behind these, as a knock.

        How loud they are by chance is known for normal noise.
        """
        white = self._shaped(values, [np.sqrt(weights) for weights in self._weights])
        energy = np.concatenate([[0.0], np.cumsum(white**2)])
        last = np.minimum(at + _CLOSE * self.near, white.size)
        return chi2.logsf(energy[last] - energy[at], last - at) < np.log(_TOGETHER)

    def expect(
        self, values: Float[np.ndarray, " looked_at"], wrong: Int[np.ndarray, " wrong"]
    ) -> Float[np.ndarray, " wrong"]:
        """The likeliest values of those that are `wrong`, whatever they are."""
        if wrong.size == 0:
            return np.zeros(0)
        start = values.copy()
        start[wrong] = np.median(values)
        need = -self.contradict(start)[wrong]
        among = _Among(self, wrong, values.size)
        return start[wrong] + cg(among, need, rtol=_EXACT, maxiter=_MOST_STEPS)[0]

    def filled(
        self, state: Investigation, wrong: Bool[np.ndarray, " looked_at"]
    ) -> Float[np.ndarray, " samples"]:
        """All values, with what others expect in place of those that are `wrong`."""
        calm = state.calm[state.looked_at]
        values = state.values.copy()
        values[state.looked_at[wrong]] += self.expect(calm, np.flatnonzero(wrong)) - calm[wrong]
        return values

    def steps_gain(
        self,
        values: Float[np.ndarray, " looked_at"],
        at: Int[np.ndarray, " at"],
        errors: Float[np.ndarray, " at"],
    ) -> Float[np.ndarray, " at"]:
        """What a step beside a sample gains over its error, in twice the log-likelihood.

        At half the sampling rate a step is like an error of half its size. Slow drifts tell
        nothing. The `values` are without the errors.
        """
        slowest = self.slowest
        fast = [np.where(mode_frequency(w.size) < slowest, 0.0, w) for w in self._weights]
        swing = [4 * np.sin(np.pi * np.maximum(mode_frequency(w.size), slowest)) ** 2 for w in fast]
        spike = float(np.mean(np.concatenate(fast)))
        step = np.mean(np.concatenate([w / each for w, each in zip(fast, swing, strict=True)]))
        # A step is the sum of errors from its place on. That of the error itself is symmetric.
        summed = np.cumsum(self.contradict(values, slowest=slowest))
        after, before = summed[at], summed[at - 1]
        own = errors * spike / 2
        by_step = np.maximum(np.abs(after + own), np.abs(before - own))
        return by_step**2 / step - errors**2 * spike


class _Among(LinearOperator):
    """The rows and columns of wrong samples of the inverse of the covariance."""

    def __init__(self, others: Others, wrong: Int[np.ndarray, " wrong"], samples: int) -> None:
        super().__init__(float, (wrong.size, wrong.size))
        self._others, self._wrong, self._samples = others, wrong, samples

    def _matvec(self, x: Float[np.ndarray, " wrong"]) -> Float[np.ndarray, " wrong"]:
        moved = np.zeros(self._samples)
        moved[self._wrong] = x
        return self._others.contradict(moved)[self._wrong]


def behind_filter(
    state: Investigation, known: Bool[np.ndarray, " looked_at"]
) -> tuple[Bool[np.ndarray, " looked_at"], Float[np.ndarray, " samples"]] | None:
    """Samples that are `known` to be wrong and all that others contradict, and values without.

    Where noise is white there is nothing to tell, for it hides no error by itself.
    """
    # How white the noise is shows without the errors, which are white.
    trial = replace(state)
    calm = state.calm[state.looked_at]
    reach = clear_of_noise(state, calm.size)
    others = Others(trial)
    wrong, refused = known.copy(), _no_witness(state, others.near // _BESIDE)
    for _ in range(_PASSES):
        before = wrong
        wrong = _stand_out(others, calm, known, wrong, refused, reach)
        if wrong.any():
            trial.values = others.filled(state, wrong)
            read_again(trial)
            refit(trial)
            others = Others(trial)
        # What was put in place of the last ones knows of them.
        if np.array_equal(wrong, before):
            break
    return None if others.silent else (wrong, trial.values)


def clear_of_noise(state: Investigation, samples: int) -> float:
    """Standard deviations that none of so many samples of noise is likely to reach."""
    return float(norm.isf(state.alarm / 2 / samples))


def _stand_out(
    others: Others,
    calm: Float[np.ndarray, " looked_at"],
    known: Bool[np.ndarray, " looked_at"],
    wrong: Bool[np.ndarray, " looked_at"],
    refused: Bool[np.ndarray, " looked_at"],
    reach: float,
) -> Bool[np.ndarray, " looked_at"]:
    """The `wrong` samples and all that others contradict beside them, the highest first.

    What turns out to be none is `refused` from then on.
    """
    wrong, filled = wrong.copy(), calm.copy()
    for _ in range(_ROUNDS):
        at = np.flatnonzero(wrong)
        filled[at] = others.expect(calm, at)
        high = np.abs(others.contradict(filled)) / others.spread
        peaks = (high == maximum_filter1d(high, 2 * others.near + 1)) & ~refused
        more = peaks & (high > max(reach, _ECHO * np.max(high, where=peaks, initial=0.0)))
        if not more.any():
            break
        refused |= _together(wrong | more, others.near) & ~known
        wrong = (wrong | more) & ~refused
    at = np.flatnonzero(wrong & ~known)
    errors = calm[at] - filled[at]
    gain = others.steps_gain(filled, at, errors)
    refused[at[others.ring_on(filled, at)]] = True
    # One by one where it is clear, and else all together.
    clear = gain > reach**2
    refused[at[clear | (np.sum(gain[~clear]) > 0)]] = True
    wrong[at[np.abs(errors) * others.height < reach]] = False
    return wrong & (known | ~refused)


def _no_witness(state: Investigation, near: int) -> Bool[np.ndarray, " looked_at"]:
    """Where others say nothing: at the ends, which are not made white, and beside a loss.

    Others are neighbours in the log, and not in time there.
    """
    sizes = [stop - start for start, stop in state.long_pieces]
    from_ends = [np.minimum(np.arange(size), np.arange(size)[::-1]) for size in sizes]
    apart = np.zeros(state.values.size, bool)
    for after in np.flatnonzero(np.diff(state.place) > 1) + 1:
        apart[max(after - near, 0) : after + near] = True
    return (np.concatenate(from_ends) < END) | apart[state.looked_at]


def _together(wrong: Bool[np.ndarray, " looked_at"], reach: int) -> Bool[np.ndarray, " looked_at"]:
    """Those that are close together, if more are than would be by chance: a knock."""
    at = np.flatnonzero(wrong)
    gaps = np.concatenate([[np.inf], np.diff(at), [np.inf]])
    reach *= _CLOSE
    near = np.minimum(gaps[:-1], gaps[1:]) <= reach
    chance = 1 - (1 - at.size / wrong.size) ** (2 * reach)
    together = np.zeros(wrong.size, bool)
    together[at[near]] = binom.sf(near.sum() - 1, at.size, chance) < _TOGETHER
    return together


def read_again(state: Investigation) -> None:
    """The spectrum of the values as they are now."""
    parts = between_even_ends(state.values, state.pieces, np.exp(state.model.theta[:2]))
    state.spectrum = state.spectrum._replace(amplitude=amplitudes(parts))
    rebin(state)
