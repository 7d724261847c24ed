"""`explain`: what the five terms leave out of a recording, named, modelled and proven."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import jax
import numpy as np
from numpy.typing import ArrayLike
from threadpoolctl import threadpool_limits

from ..compilation import on_the_cpu
from ..curves import unit_scale
from ..formatting import finite
from ..identify import fit_series
from ..physics import Sampling
from ..recording import Channel, Recording, RecordingError, recording_of
from ..temperature import believable, beside
from ._after import fit_after
from ._effect import Effect
from ._effects import effects_of
from ._explanation import ChannelExplanation, Explanation
from ._held_out import held_out
from ._investigate import ALARM, investigate
from ._misfit import goodness
from .simulation._references import references
from .spectrum._averaged import averaged, of_either_sampling
from .spectrum._posterior import sample_structure
from .values._closed_up import closed_up

# Of what is named in the spectrum of a better model that does not fit about half is not there.
_DOUBTED = 0.5
# Samples of the longest stretch, at least: of fewer no spectrum of its own can be made white.
_SHORTEST = 64
# What values and time stamps tell, whatever the model of the noise is.
_OF_VALUES = ("output_rounding", "sample_hold", "dropped_samples", "saturation", "disturbance")


# Of threads for small matrices each waits for the others, for most of the time there is.
@threadpool_limits.wrap(limits=1, user_api="blas")
def explain_recording(
    recording: Recording | Mapping[str, ArrayLike] | ArrayLike,
    rate_hz: float | None = None,
    *,
    unit: str | None = None,
    simulation: Path | str | Recording | None = None,
    sampling: Sampling = "point",
    posterior: bool = True,
    seed: int = 0,
    announce: Callable[[str], None] = lambda channel: None,
    done: Callable[[], None] = lambda: None,
) -> Explanation:
    """Locate what the five terms leave out of each channel, name it, model it and prove it.

    **Arguments:**

    - `recording`: from `allanfit.load`, or of arrays by `allanfit.recording_of`.
    - `rate_hz`, `unit`: of arrays that are given in place of a recording; `recording_of` then
      makes one of them.
    - `simulation`: a recording made by the user's simulator, or a file of one or of coefficients;
      mismatches are then those between recording and simulation.
    - `sampling`, `seed`: as in `allanfit.fit`.
    - `posterior`: without it the chains are a quarter as long, and intervals rough.
    - `announce`, `done`: called with each channel's name before its turn, and after it.

    **Raises:** `TypeError` for what is no recording and has no rate; `ValueError` for a rate or a
    unit of a recording, which has its own, and for a simulation that cannot be compared;
    `RecordingError` where gaps leave a channel no stretch of 64 samples.
    """
    if isinstance(recording, Recording):
        if rate_hz is not None or unit is not None:
            raise ValueError(
                "a Recording knows its rate and unit; give them to allanfit.load or "
                "allanfit.recording_of instead"
            )
    elif rate_hz is None:
        raise TypeError(
            "explain takes a recording: read one with allanfit.load, or make one of arrays with "
            "allanfit.recording_of; or arrays with their rate_hz."
        )
    else:
        recording = recording_of(recording, rate_hz=rate_hz, unit=unit)
    # Steep filters leave powers that single precision cannot tell from nothing.
    with jax.enable_x64(True), on_the_cpu():
        compared_with = references(simulation, recording, sampling)
        drawn = [each.simulated for each in compared_with.values() if each.simulated]
        for channel, of in (*((each, recording) for each in recording.channels), *drawn):
            _check_stretches(closed_up(channel, of)[0])
        alarm = ALARM / len(recording.channels)
        found: list[ChannelExplanation] = []
        simulated: dict[int, ChannelExplanation] = {}
        for channel in recording.channels:
            announce(channel.name)
            explained = _explain_channel(channel, recording, sampling, alarm, posterior, seed)
            reference = compared_with.get(channel.name)
            if reference is not None:
                # One simulated channel may serve several of the recording.
                if reference.simulated is not None and id(reference) not in simulated:
                    own = _explain_channel(*reference.simulated, sampling, alarm, False, seed)
                    simulated[id(reference)] = own
                own = simulated.get(id(reference))
                if own is not None:
                    values, deviations = own.terms
                    reference = replace(reference, coefficients=values, deviations=deviations)
                    explained = replace(explained, simulated=own)
                explained = replace(explained, reference=reference)
            found.append(explained)
            done()
    return Explanation(recording, tuple(found))


explain = explain_recording


def _check_stretches(channel: Channel) -> None:
    longest = max(stop - start for start, stop in channel.stretches)
    if longest < _SHORTEST:
        raise RecordingError(
            f"channel {channel.name!r} has no stretch of more than {longest} samples between gaps: "
            f"explain needs one of {_SHORTEST}; record without gaps, or use fit"
        )


def _explain_channel(
    channel: Channel,
    recording: Recording,
    sampling: Sampling,
    alarm: float,
    posterior: bool,
    seed: int,
) -> ChannelExplanation:
    channel, recording = closed_up(channel, recording)
    fit = fit_series(
        channel.samples,
        recording.rate_hz,
        sampling=sampling,
        seed=seed,
        stretches=channel.stretches,
    )
    dt = 1 / recording.rate_hz
    values = np.array(list(map(float, fit.coefficients.values()))) / np.asarray(unit_scale(dt))
    drivers = {}
    thermometer = beside(channel, recording)
    if thermometer is not None and np.ptp(thermometer.samples) > 0:
        felt = believable(thermometer.samples, channel.stretches)
        drivers["temperature"] = felt[:, None]
    state = investigate(
        channel.samples,
        channel.stretches,
        sampling,
        values[:4] ** 2,
        alarm=alarm,
        drivers=drivers,
        lost=recording.lost,
        losses=recording.losses,
        lost_deviation=recording.lost_deviation,
        seed=seed,
    )
    if not state.findings and state.unexplained is None:
        return ChannelExplanation(channel, fit, None, state, (), None, None)
    draws = sample_structure(state.model, state.data, seed, quick=not posterior)
    if draws.likeliest is not None:
        state.model = draws.likeliest
    draws = of_either_sampling(state, draws, seed, quick=not posterior)
    effects = tuple(
        replace(effect, felt=bool(drivers))
        for effect in effects_of(state, draws, state.stride * dt, seed)
    )
    draws = averaged(state, draws, seed, quick=not posterior)
    after = fit_after(fit, state, draws, effects, seed)
    score = held_out(
        state.spectrum,
        state.moved,
        state.edges,
        state.model,
        state.data,
        state.first_data,
        state.variance,
        seed,
    ).joined(state.gains.values())
    fits = goodness(state, sum(moved.shape[1] for moved in state.moved))
    found = ChannelExplanation(
        channel, fit, after, state, effects, score, finite(fits.p_value), fits.apart
    )
    return replace(found, effects=_doubted(effects)) if found.misfit else found


def _doubted(effects: tuple[Effect, ...]) -> tuple[Effect, ...]:
    """The effects, those less sure that a model of the spectrum and the mean told."""

    def doubted(effect: Effect) -> Effect:
        if effect.name in _OF_VALUES:
            return effect
        rivals = {name: _DOUBTED * chance for name, chance in effect.alternatives.items()}
        return replace(effect, probability=_DOUBTED * effect.probability, alternatives=rivals)

    return tuple(map(doubted, effects))
