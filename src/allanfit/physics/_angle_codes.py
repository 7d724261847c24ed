"""Errors of an angle that is rounded to codes wider than its move between samples."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

# Of the error's Fourier series in the angle, terms beyond are white whatever the move.
_MOST_TERMS = 24
# A term whose neighbours are less alike than this is white.
_ALIKE = 1e-4


class AngleCodes(NamedTuple):
    """How an angle moves among the codes that it is rounded to.

    An angle that goes through whole codes between samples has white errors, as `QuantizationNoise`
    has them. One that moves less keeps some of its error from sample to sample.
    """

    #: Standard deviation of the angle's move in a sample, by white noise, in codes.
    move: float
    #: Mean moves in a sample, in codes, at as many equal parts of the record's time.
    rates: tuple[float, ...]

    def correlation(self, lags: Int[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
        """Of the errors of an angle, that many samples apart.

        With the angle anywhere in a code its error is a Fourier series, whose terms are known to
        be alike by the characteristic function of the angle's move (Widrow and Kollár 2008, 4):
        sum over k of 6/(pi k)^2 exp(-2 (pi k s)^2 n) cos(2 pi k r n).
        """
        white, alike = self._terms()
        found = np.where(lags == 0, white, 0.0)
        for k, (share, kept) in enumerate(alike, 1):
            turns = [np.cos(2 * np.pi * k * rate * lags) for rate in self.rates]
            found += share * kept**lags * np.mean(turns, axis=0)
        return found

    def density_ratio(self, frequency: Float[np.ndarray, "*shape"]) -> Float[np.ndarray, "*shape"]:
        """The density of the errors over that of white ones; of cycles per sample.

        Each term of the series is a first-order process, turned by the mean move.
        """
        white, alike = self._terms()
        found = np.full(frequency.shape, white)
        for k, (share, kept) in enumerate(alike, 1):
            for rate in self.rates:
                for turned in (frequency - k * rate, frequency + k * rate):
                    width = 1 + kept**2 - 2 * kept * np.cos(2 * np.pi * turned)
                    found += share * (1 - kept**2) / width / (2 * len(self.rates))
        return found

    def _terms(self) -> tuple[float, list[tuple[float, float]]]:
        """What is white, and of the other terms their shares and how alike neighbours are."""
        alike = []
        for k in range(1, _MOST_TERMS + 1):
            kept = float(np.exp(-2 * (np.pi * k * self.move) ** 2))
            if kept < _ALIKE:
                break
            alike.append((6 / (np.pi * k) ** 2, kept))
        return 1.0 - sum(share for share, _ in alike), alike
