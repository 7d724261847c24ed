"""What was found out about a recording: its JSON, sentence by sentence and number by number."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import jax
import numpy as np
from jaxtyping import Float

from ..formatting import p_value
from ..identify import ChannelFit, Fit
from ..identify._fit_document import (
    channel_header,
    coefficients_document,
    finite,
    recording_document,
)
from ..identify._recording_fit import LEFT_OUT
from ..physics import EFFECTS, parameter_unit, unit_power
from ..recording import Channel, Recording
from ._curves import explained_curves
from ._effect import Effect
from ._held_out import HeldOut
from ._misfit import MISFIT
from ._mismatch import Located, Mismatch, located, once
from ._state import Investigation
from ._words import effect_sentence, family_sentence, without_pointer
from .lines._harmonics import Family, Line, families
from .simulation._compare import compared
from .simulation._document import simulation_curves, simulation_document
from .simulation._references import Reference, terms_of
from .simulation._unit import unit_advice
from .spectrum._structure import NARROW

SCHEMA = "allanfit.explain/1"
# Chance of a false alarm in a recording with nothing left out.
_FALSE_ALARM = 0.01


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
    #: What was found out about that, if it is a recording.
    simulated: "ChannelExplanation | None" = None

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
                values[1] *= effect.held
                deviations[1] *= effect.held
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
        """Whether the better model does not fit either; none describes what codes make."""
        chance = self.p_value_after
        return chance is not None and chance < MISFIT and not self.state.in_codes

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
        curves = explained_curves(fit, self.best, self.state, list(self.effects), factor)
        reference, own, simulation = self.reference, self.simulated, None
        mismatch = [each.entry for each in self.located]
        if reference is not None:
            mismatch = self.compared_with(reference, own.located if own else [])
            simulation = simulation_document(reference, own and own.best, channel)
            for kind, each in simulation_curves(reference, own and own.before, fit, factor).items():
                curves[kind]["simulation"] = each
        return {
            **channel_header(channel, fit),
            "verdict": self.verdict,
            "false_alarm_probability": self.false_alarm_probability,
            "mismatch": once(mismatch),
            "simulation": simulation,
            "effects": shown,
            "coefficients_before": plain,
            "coefficients_after": plain
            if self.after is None
            else coefficients_document(self.after, channel),
            "improvement": self._improvement(),
            "witnesses": self.state.witnesses,
            "advice": list(self.advice),
            "findings": list(self.findings),
            "curves": curves,
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
            resolved=np.asarray(self.best.estimate.resolved),
            doubtful=self.misfit,
        )

    @property
    def advice(self) -> tuple[str, ...]:
        """What to do next, a sentence each."""
        said = []
        if self.reference is not None:
            said += unit_advice(self.terms, self.reference, self.channel)
        for effect in self.effects:
            for rival, chance in effect.alternatives.items():
                if chance > 0.05:
                    said.append(
                        f"To tell {_plain(effect.name)} from {_plain(rival)}: "
                        f"{effect.told_apart(rival)}."
                    )
        said += [family_sentence(family) for family in self._families]
        if self.state.in_codes:
            said.append(
                "The noise hides within a code: Q, N, B and K are limits, as much as a code can "
                "hide. Log more digits, or set a smaller range, and record again."
            )
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
            bumps, unknown = [e for e in self.effects if e.name == "bump"], self.state.unknown
            nowhere = bool(bumps) and len(bumps) == sum(each.bandless for each in unknown)
            if unknown and all(each.times for each in unknown):
                said.append(
                    "Look up what ran or moved at these times, or record again in a quiet hour: "
                    "what is gone then is not the sensor's."
                )
            else:
                moves = "it changes" if nowhere else "the band moves"
                said.append(
                    "Record again with another rate, filter setting or mounting, and see whether "
                    f"{moves}: that tells electronics from mechanics."
                )
        return tuple(dict.fromkeys(said))

    @property
    def findings(self) -> tuple[str, ...]:
        """What is amiss with the recording or its fit, a sentence each.

        What a fit says that leaves something out, such as of the end of the spectrum, is a guess at
        what is known here.
        """
        if self.effects and bool(self.before.converged):
            found = self.channel.findings
        else:
            found = ChannelFit(self.channel, self.before, None).findings
        if self.verdict == "consistent":
            # A look at one test, where the verdict is of all of them together.
            alone = _goodness_alone(float(self.before.goodness_of_fit))
            found = [alone if sentence == LEFT_OUT else sentence for sentence in found]
        return tuple(without_pointer(sentence) for sentence in found)

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
            "p_value_before": finite(self.before.goodness_of_fit),
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
        with jax.enable_x64(True):
            return recording_document(SCHEMA, self.recording, self.channels)

    def _repr_html_(self) -> str:
        """Verdicts, effects and coefficients, for a notebook."""
        # Formatting comes after explaining, and is not loaded with it.
        from ..report import explanation_html

        return explanation_html(self.to_dict())


def _goodness_alone(goodness: float) -> str:
    """What a small p-value of the fit says where nothing that is left out stands out."""
    return (
        f"The five-term model alone fits with {p_value(goodness)}, which is low for one test, and "
        "no more than chance makes in as many as are made here: a longer recording tells whether "
        "something is left out."
    )


def _plain(name: str) -> str:
    return name.replace("gauss_markov", "Gauss-Markov").replace("_", " ")
