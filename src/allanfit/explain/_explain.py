"""`explain`: what the five terms leave out of a recording, named, modelled and proven."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from jaxtyping import Float

from ..curves import unit_scale
from ..identify import ChannelFit, Fit, fit_series
from ..identify._recording_fit import channel_header, coefficients_document, recording_document
from ..physics import EFFECTS, Sampling, parameter_unit, unit_power
from ..recording import Channel, Recording, RecordingError
from ..temperature import believable, beside
from ._after import fit_after
from ._averaged import averaged
from ._clock import held_factor
from ._compare import compared
from ._curves import explained_curves
from ._effect import Effect
from ._effects import effects_of
from ._harmonics import Family, Line, families
from ._held_out import HeldOut, held_out
from ._investigate import ALARM, investigate
from ._misfit import MISFIT, goodness
from ._mismatch import Located, Mismatch, located
from ._posterior import sample_structure
from ._references import Reference, references, terms_of
from ._state import Investigation
from ._structure import NARROW
from ._words import effect_sentence, family_sentence

SCHEMA = "allanfit.explain/1"
# Chance of a false alarm in a recording with nothing left out.
_FALSE_ALARM = 0.01
# Of what is named in the spectrum of a better model that does not fit about half is not there.
_DOUBTED = 0.5
# Samples of the longest stretch, at least: of fewer no spectrum of its own can be made white.
_SHORTEST = 64
# What values and time stamps tell, whatever the model of the noise is.
_OF_VALUES = ("output_rounding", "sample_hold", "dropped_samples", "saturation", "disturbance")


@dataclass(frozen=True)
class ChannelExplanation:
    """What was found out about one channel."""

    channel: Channel
    before: Fit
    after: Fit | None
    state: Investigation
    effects: tuple[Effect, ...]
    held_out: HeldOut | None
    p_value_after: float | None
    #: Whether that leaves out the bands of lines that wander.
    lines_apart: bool = False
    reference: Reference | None = None
    #: Where the simulation that it is compared with differs from its own five terms.
    simulated: tuple[Located, ...] = ()

    @property
    def located(self) -> list[Located]:
        """Where the channel differs from its five terms, an entry an effect."""
        dt = self.state.stride / float(self.before.rate_hz)
        return located(self.state, self.effects, dt)

    @property
    def terms(self) -> tuple[Float[np.ndarray, " terms"], Float[np.ndarray, " terms"]]:
        """Q, N, B, K, R beside the effects as they show at low frequency, and deviations, in SI.

        Of held values N is that of the fresh ones, and shows larger.
        """
        values, deviations = terms_of(self.best)
        for effect in self.effects:
            if effect.name == "sample_hold":
                factor = held_factor(effect.value("repeat"), "regular" in effect.parameters)
                values[1] *= factor
                deviations[1] *= factor
        return values, deviations

    @property
    def best(self) -> Fit:
        """The fit with what was left out in the model, if anything was."""
        return self.after or self.before

    @property
    def seconds(self) -> float:
        """How long the recording takes."""
        dt = self.state.stride / float(self.before.rate_hz)
        return float(self.state.moment(self.state.values.size) * dt)

    @property
    def verdict(self) -> str:
        """`consistent`, `explained` or `unexplained`."""
        if not self.effects:
            return "consistent"
        if self.state.unexplained is not None or any(e.name == "bump" for e in self.effects):
            return "unexplained"
        return "unexplained" if self.misfit else "explained"

    @property
    def misfit(self) -> bool:
        """Whether the better model does not fit either."""
        return self.p_value_after is not None and self.p_value_after < MISFIT

    @property
    def false_alarm_probability(self) -> float:
        """Chance that a recording with nothing left out looks as odd as this one.

        That of the oddest of all tests, for as many of them as share the chance of an alarm.
        """
        return float(min(1.0, _FALSE_ALARM / self.state.alarm * math.exp(self.state.nearest)))

    def to_dict(self) -> dict[str, Any]:
        """This channel's entry in the explain JSON, in the unit that the user gave."""
        channel, fit, factor = self.channel, self.before, self.channel.factor
        plain = coefficients_document(fit, channel)
        shown = [self._effect(effect) for effect in self.effects]
        found = self.located
        return {
            **channel_header(channel, fit),
            "verdict": self.verdict,
            "false_alarm_probability": self.false_alarm_probability,
            "mismatch": [each.entry for each in found]
            if self.reference is None
            else self.compared_with(self.reference, self.simulated),
            "compared_with_simulation": self.reference is not None,
            "effects": shown,
            "coefficients_before": plain,
            "coefficients_after": plain
            if self.after is None
            else coefficients_document(self.after, channel),
            "improvement": self._improvement(),
            "witnesses": self.state.witnesses,
            "advice": list(self.advice),
            "findings": list(self.findings),
            "curves": explained_curves(fit, self.best, self.state, list(self.effects), factor),
        }

    def compared_with(self, reference: Reference, simulated: Sequence[Located]) -> list[Mismatch]:
        """Where the channel differs from a simulation, which has such effects of its own."""
        return compared(
            self.before,
            self.terms,
            reference,
            self.located,
            simulated,
            self.seconds,
            self._unit,
            doubtful=self.misfit,
        )

    @property
    def advice(self) -> tuple[str, ...]:
        """What to do next, a sentence each."""
        said = []
        for effect in self.effects:
            for rival, chance in effect.alternatives.items():
                if chance > 0.05:
                    said.append(
                        f"To tell {_plain(effect.name)} from {_plain(rival)}: "
                        f"{effect.told_apart(rival)}."
                    )
        said += [family_sentence(family) for family in self._families]
        if self.misfit:
            said.append(
                "The better model does not fit either: something is left out or wrongly named, and "
                "its effects, and N, B and K after naming, are doubtful."
            )
        elif self.lines_apart:
            said.append(
                "The line does not wander as the model has it, normally distributed: its power and "
                "band hold, the shape of its peak does not, and the p-value is of all beside it."
            )
        if self.verdict == "unexplained":
            said.append(
                "Record again with another rate, filter setting or mounting, and see whether the "
                "band moves: that tells electronics from mechanics."
            )
        return tuple(dict.fromkeys(said))

    @property
    def findings(self) -> tuple[str, ...]:
        """What is amiss with the recording or its fit, a sentence each.

        What a fit says that leaves something out, such as of the end of the spectrum, is a guess at
        what is known here.
        """
        if self.effects and bool(self.before.converged):
            return tuple(self.channel.findings)
        return ChannelFit(self.channel, self.before, None).findings

    @property
    def _families(self) -> list[Family]:
        lines = []
        for effect in self.effects:
            if effect.name in ("sinusoid", *NARROW):
                spread = float(np.std(effect.parameters["frequency"]))
                lines.append(Line(effect.value("frequency"), spread))
        return families(lines, float(self.before.rate_hz) / self.state.stride / 2)

    def _effect(self, effect: Effect) -> dict[str, Any]:
        parameters = {
            name: self._parameter(effect, name, draws) for name, draws in effect.parameters.items()
        }
        for name, values in effect.lists.items():
            unit, factor = self._unit(effect, name)
            told = (np.asarray(values) / factor).tolist()
            parameters[name] = {"value": told, "unit": unit, "intervals": {}}
        return {
            "name": effect.name,
            "probability": effect.probability,
            "alternatives": [
                {"name": rival, "probability": chance, "told_apart_by": effect.told_apart(rival)}
                for rival, chance in sorted(effect.alternatives.items(), key=lambda item: -item[1])
            ],
            "parameters": parameters,
            "sentence": effect_sentence(effect, parameters),
        }

    def _parameter(
        self, effect: Effect, name: str, draws: Float[np.ndarray, " _"]
    ) -> dict[str, Any]:
        unit, factor = self._unit(effect, name)
        values = draws / factor

        def interval(probability: float) -> list[float]:
            tail = (1 - probability) / 2
            return [float(each) for each in np.quantile(values, [tail, 1 - tail])]

        exact = bool(np.ptp(values) == 0)
        return {
            "value": effect.value(name) / factor,
            "unit": unit,
            "intervals": {} if exact else {"0.68": interval(0.68), "0.95": interval(0.95)},
        }

    def _unit(self, effect: Effect, name: str) -> tuple[str, float]:
        """The unit that a parameter is told in, and one such unit in SI and seconds."""
        parameter = next(each for each in EFFECTS[effect.name].parameters if each.name == name)
        size = self.channel.factor ** unit_power(parameter)
        return parameter_unit(parameter, self.channel.unit), size

    def _improvement(self) -> dict[str, Any] | None:
        if self.held_out is None:
            return None
        return {
            "held_out_log_score": {
                "before": self.held_out.before,
                "after": self.held_out.after,
                "difference": self.held_out.difference,
                "standard_error": self.held_out.standard_error,
            },
            "p_value_before": _finite(self.before.goodness_of_fit),
            "p_value_after": self.p_value_after,
        }


@dataclass(frozen=True)
class Explanation:
    """What was found out about all channels of a recording."""

    recording: Recording
    channels: tuple[ChannelExplanation, ...]

    def __getitem__(self, name: str) -> ChannelExplanation:
        """The channel of that name; `KeyError` if there is none."""
        return {channel.channel.name: channel for channel in self.channels}[name]

    def to_dict(self) -> dict[str, Any]:
        """The explain JSON, schema allanfit.explain/1."""
        return recording_document(SCHEMA, self.recording, self.channels)

    def _repr_html_(self) -> str:
        """Verdicts, effects and coefficients, for a notebook."""
        # Formatting comes after explaining, and is not loaded with it.
        from ..report import explanation_html

        return explanation_html(self.to_dict())


def explain_recording(
    recording: Recording,
    *,
    simulation: Path | str | Recording | None = None,
    sampling: Sampling = "point",
    posterior: bool = True,
    seed: int = 0,
    announce: Callable[[str], None] = lambda channel: None,
    done: Callable[[], None] = lambda: None,
) -> Explanation:
    """Locate what the five terms leave out of each channel, name it, model it and prove it.

    **Arguments:**

    - `recording`: from `allanfit.load`.
    - `simulation`: a recording made by the user's simulator, or a file of one or of coefficients;
      mismatches are then those between recording and simulation.
    - `sampling`, `seed`: as in `allanfit.fit`.
    - `posterior`: without it the chains are a quarter as long, and intervals rough.
    - `announce`, `done`: called with each channel's name before its turn, and after it.

    **Raises:** `ValueError` for a simulation that cannot be compared; `RecordingError` where gaps
    leave no stretch of 64 samples.
    """
    compared_with = references(simulation, recording, sampling)
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
                explained = replace(explained, simulated=tuple(own.located))
            explained = replace(explained, reference=reference)
        found.append(explained)
        done()
    return Explanation(recording, tuple(found))


explain = explain_recording


def _explain_channel(
    channel: Channel,
    recording: Recording,
    sampling: Sampling,
    alarm: float,
    posterior: bool,
    seed: int,
) -> ChannelExplanation:
    fit = fit_series(
        channel.samples,
        recording.rate_hz,
        sampling=sampling,
        seed=seed,
        stretches=channel.stretches,
    )
    longest = max(stop - start for start, stop in channel.stretches)
    if longest < _SHORTEST:
        raise RecordingError(
            f"channel {channel.name!r} has no stretch of more than {longest} samples between gaps: "
            f"explain needs one of {_SHORTEST}; record without gaps, or use fit"
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
        seed=seed,
    )
    if not state.findings and state.unexplained is None:
        return ChannelExplanation(channel, fit, None, state, (), None, None)
    draws = sample_structure(state.model, state.data, seed, quick=not posterior)
    if draws.likeliest is not None:
        state.model = draws.likeliest
    effects = tuple(
        replace(effect, felt=bool(drivers))
        for effect in effects_of(state, draws, state.stride * dt, seed)
    )
    after = fit_after(fit, state, averaged(state, draws, seed, quick=not posterior), seed)
    moved = state.all_moved
    score = held_out(
        state.spectrum,
        moved,
        state.edges,
        state.model,
        state.data,
        state.first_data,
        state.variance,
        seed,
    ).joined(state.gains.values())
    fits = goodness(state, moved.shape[1])
    found = ChannelExplanation(
        channel, fit, after, state, effects, score, _finite(fits.p_value), fits.apart
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


def _plain(name: str) -> str:
    return name.replace("gauss_markov", "Gauss-Markov").replace("_", " ")


def _finite(value: Any) -> float | None:
    return float(value) if math.isfinite(float(value)) else None
