"""Linear state-space models driven by white noise, in continuous and in discrete time.

A part is one physical term; a system is a stack of parts. Nothing here knows what a part stands
for, so that a further effect needs one more part and nothing else.

    x' = F x + G w,    E[w(t) w(s)^T] = Qc delta(t - s),    y = H x + v,    E[v v] = Rc delta

Qc and Rc are two-sided spectral densities, as in the textbooks of filtering: white noise of
coefficient N, whose one-sided density is 2 N^2, has Rc = N^2.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag, expm


class State(NamedTuple):
    """One component of the state."""

    name: str
    unit: str
    initial_variance: float | None
    """At the start of the filter; None where the fit cannot know it."""


def _empty(rows: int, columns: int) -> np.ndarray:
    return np.zeros((rows, columns))


@dataclass(frozen=True)
class Part:
    """What one term adds to a channel; n states and m noises, both possibly none."""

    term: str
    states: tuple[State, ...] = ()
    F: np.ndarray = field(default_factory=lambda: _empty(0, 0))
    """Shape (n, n)."""
    G: np.ndarray = field(default_factory=lambda: _empty(0, 0))
    """Shape (n, m)."""
    Qc: np.ndarray = field(default_factory=lambda: _empty(0, 0))
    """Shape (m, m)."""
    H: np.ndarray = field(default_factory=lambda: _empty(1, 0))
    """Shape (1, n)."""
    Rc: float = 0.0
    """Two-sided density of white measurement noise [u^2/Hz]."""


@dataclass(frozen=True)
class System:
    """Channels by terms: each channel is one row of H, and has states of its own."""

    states: tuple[State, ...]
    F: np.ndarray
    G: np.ndarray
    Qc: np.ndarray
    H: np.ndarray
    Rc: np.ndarray


class DiscreteSystem(NamedTuple):
    """x_(k+1) = Phi x_k + w_k, y_k = H x_k + v_k, with covariances Qd and Rd."""

    Phi: np.ndarray
    Qd: np.ndarray
    H: np.ndarray
    Rd: np.ndarray


def stack(channels: Sequence[Sequence[Part]]) -> System:
    """The system of some channels, each the sum of its parts."""
    parts = [part for channel in channels for part in channel]
    rows = [np.hstack([_empty(1, 0), *(part.H for part in channel)]) for channel in channels]
    return System(
        states=tuple(state for part in parts for state in part.states),
        F=_diagonal(part.F for part in parts),
        G=_diagonal(part.G for part in parts),
        Qc=_diagonal(part.Qc for part in parts),
        H=_diagonal(rows),
        Rc=np.diag([sum(part.Rc for part in channel) for channel in channels]),
    )


def discretise(system: System, dt: float) -> DiscreteSystem:
    """The exact equivalent at steps of `dt` seconds (Van Loan 1978, IEEE Trans. AC 23:395)."""
    n = len(system.F)
    drive = system.G @ system.Qc @ system.G.T
    exponential = expm(np.block([[-system.F, drive], [_empty(n, n), system.F.T]]) * dt)
    transition = exponential[n:, n:].T
    covariance = transition @ exponential[:n, n:]
    return DiscreteSystem(transition, (covariance + covariance.T) / 2, system.H, system.Rc / dt)


def _diagonal(blocks: Iterable[np.ndarray]) -> np.ndarray:
    return np.asarray(block_diag(_empty(0, 0), *blocks))
