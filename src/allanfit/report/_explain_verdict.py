"""The answer of an explanation in sentences: does the model hold, and what is the evidence?"""

from collections.abc import Mapping
from typing import Any, NamedTuple

from ..formatting import Number, beside_error, p_value, significant, with_error
from ._explain_words import UNNAMED_SHAPES, counted, idle_parameters, words

_UNNAMED = "bump"  # describes what no effect of the catalogue explains
_SURE, _LIKELY = 0.9, 0.5  # of an effect; below, the sentence says "probably", and "perhaps"
_ONLY = "data"  # the channel of a file that names none
_AGREES = 0.01  # p-value, as for a fit
_NEARLY = 1e-4  # below, what is left out changes what is named
_EVEN = 0.05  # of log score: nobody tells it from nothing
_MANY = 100  # standard errors, beyond which their number says nothing
_FINE = 1.0  # nats: two digits of a smaller standard error say nothing


class Evidence(NamedTuple):
    """One measure of how well the recording is described, before and after."""

    what: str
    before: str
    after: str
    remark: str
    good: bool


def verdict_sentence(channel: Mapping[str, Any]) -> str:
    """Whether the five terms describe the recording, and what they leave out, in one sentence."""
    verdict = channel["verdict"]
    effects = [effect for effect in channel["effects"] if effect["name"] != _UNNAMED]
    if verdict == "consistent":
        return "The five-term model agrees with the recording: nothing left out is seen in it."
    if not effects:
        start = "The recording differs from the five-term model, and no effect of the catalogue"
        shown = [
            set(each["parameters"]) - set(idle_parameters(each)) for each in channel["effects"]
        ]
        if not channel["improvement"] or not any(shown):
            return f"{start} explains how."
        alike = (name for flag, name in UNNAMED_SHAPES.items() if all(flag in s for s in shown))
        shape = next(alike, "a smooth bump")
        return f"{start} explains how; {shape} stands for it in the better model."
    least = min(effect["probability"] for effect in effects)
    left_out = counted([words(effect["name"]) for effect in effects])
    says = "" if least >= _SURE else "probably " if least >= _LIKELY else "perhaps "
    start = f"The five-term model {says}leaves out {left_out}"
    if verdict == "unexplained":
        return f"{start}, and something more that no effect of the catalogue explains."
    with_them = f"{start}; with {'that' if len(effects) == 1 else 'them'} it"
    after = (channel["improvement"] or {}).get("p_value_after")
    if after is None or after >= _AGREES:
        return f"{with_them} describes the recording."
    if after >= _NEARLY:
        return f"{with_them} nearly describes the recording."
    return (
        f"{with_them} does not describe the recording yet: there is more, or a cause has another "
        "shape, and neither the names nor the numbers are certain."
    )


def chance_sentence(channel: Mapping[str, Any]) -> str:
    """How often noise of five terms alone would look as different as this."""
    chance = channel["false_alarm_probability"]
    if chance is None:
        return ""
    return (
        "A recording of five terms alone differs from them by as much with probability "
        f"{_bare(chance)}."
    )


def simulation_sentence(channel: Mapping[str, Any]) -> str:
    """Which simulation was compared with and what is wrong with it, "" where there was none."""
    simulation = channel.get("simulation")
    if not simulation:
        return ""
    file, name = simulation["recording"], simulation["channel"]
    which = f"Compared with {file if name == _ONLY else f'{name} of {file}'}"
    if simulation.get("assumed_unit"):
        which += f", which gives no unit and is taken to be in {simulation['assumed_unit']}"
    which += ": "
    causes = [entry for entry in channel["mismatch"] if entry.get("cause")]
    if not causes:
        return f"{which}the simulation agrees, no more differs than chance explains."
    off = sorted({entry["coefficient"] for entry in causes if entry.get("coefficient")})
    physics = [entry for entry in causes if entry["cause"] == "physics"]
    absent = {entry.get("absent_from") or "simulation" for entry in physics}
    parts = []
    if off:
        what = counted([each if len(each) == 1 else words(each) for each in off])
        parts.append(f"{what} of the simulation {'is' if len(off) == 1 else 'are'} off")
    if "simulation" in absent:
        parts.append("physics is absent from the simulation")
    if "recording" in absent:
        parts.append("the simulation has physics that the recording has not")
    if not absent:
        parts.append("no physics is seen to be absent")
    return f"{which}{', and '.join(parts)}."


def evidence_rows(channel: Mapping[str, Any]) -> list[Evidence]:
    """Held-out log score and p-value, [] where no better model was tried."""
    improvement = channel["improvement"]
    if not improvement:
        return []
    rows = []
    score = improvement.get("held_out_log_score")
    if score:
        difference, error = score["difference"], score["standard_error"]
        rows.append(
            Evidence(
                "log score of data held out of the fit",
                beside_error(score["before"], error and max(error, _FINE)),
                beside_error(score["after"], error and max(error, _FINE)),
                _gain(difference, error),
                difference is not None and difference > 2 * (error or 0.0),
            )
        )
    before, after = improvement.get("p_value_before"), improvement.get("p_value_after")
    if before is not None or after is not None:
        good = after is not None and after >= _AGREES
        rows.append(
            Evidence(
                "goodness of fit",
                probability(before),
                probability(after),
                "the better model agrees with the recording"
                if good
                else "the better model still differs from the recording",
                good,
            )
        )
    return rows


def _gain(difference: Number | None, error: Number | None) -> str:
    if difference is None:
        return "not known"
    if abs(difference) < _EVEN:
        return "as good as before"
    way = "better" if difference > 0 else "worse"
    fine = error is not None and 0 < error < _FINE
    size = beside_error(abs(difference), _FINE) if fine else with_error(abs(difference), error)
    shown = f"{way} by {size}"
    if not error:
        return shown
    times = abs(difference) / error
    many = f"over {_MANY}" if times > _MANY else significant(times, 2)
    return f"{shown}, {many} standard errors"


def probability(value: Number | None) -> str:
    """A p-value, "p undefined" where there is none."""
    return "p undefined" if value is None else p_value(value)


def _bare(value: Number) -> str:
    """A probability without its letter: "0.0004", "< 1e-12"."""
    return p_value(value).removeprefix("p = ").removeprefix("p ")
