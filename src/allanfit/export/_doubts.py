"""What is to be said of a channel that the model does not explain."""

from collections.abc import Iterable

from ..formatting import listed
from ._read import FitChannel, FitFile

_EXPLAIN_IT = "run `allanfit explain` on the recording and export its JSON"
_OTHERS = "choose other channels with --channel"


def doubts(fit: FitFile, channels: Iterable[FitChannel]) -> list[str]:
    """A sentence for the channels whose numbers describe them in part only.

    Those with effects beside the five terms have one of their own.
    """
    # Where explain has looked already, there is no more to do.
    advice = "" if fit.explained else f"; {_EXPLAIN_IT}"
    doubtful = [channel for channel in channels if not channel.consistent]
    said = []
    for with_effects in (False, True):
        alike = [each for each in doubtful if bool(each.effects) == with_effects]
        if alike:
            what = "its numbers describe it" if len(alike) == 1 else "their numbers describe them"
            said.append(f"The {_unexplained(alike)}: {what} in part only{advice}.")
    return said


def no_white_noise(fit: FitFile, channel: FitChannel) -> str:
    """Why a channel without white noise cannot be exported, and what to do."""
    missing = f"N of {channel.name} is not resolved"
    if channel.consistent:
        return (
            f"{missing}, and a filter cannot do without: {_OTHERS}, or record at a higher rate or "
            "for longer."
        )
    advice = _OTHERS if fit.explained else f"{_EXPLAIN_IT}, or {_OTHERS}"
    return f"{missing}, and the {_unexplained([channel])}: {advice}."


def _unexplained(channels: list[FitChannel]) -> str:
    """Of channels that all have effects, or none."""
    named = " and what explain names" if channels[0].effects else ""
    return f"five terms{named} do not explain {listed(channel.name for channel in channels)}"
