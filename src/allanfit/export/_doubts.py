"""What is to be said of a channel that the model does not explain."""

from collections.abc import Iterable

from ._read import FitChannel, FitFile

_EXPLAIN_IT = "run `allanfit explain` on the recording and export its JSON"
_OTHERS = "choose other channels with --channel"


def doubts(fit: FitFile, channels: Iterable[FitChannel]) -> list[str]:
    """A sentence for each channel whose numbers describe it in part only."""
    # Where explain has looked already, there is no more to do.
    advice = "" if fit.explained else f"; {_EXPLAIN_IT}"
    return [
        f"The {_unexplained(channel)}: its numbers describe it in part only{advice}."
        for channel in channels
        if not channel.consistent
    ]


def no_white_noise(fit: FitFile, channel: FitChannel) -> str:
    """Why a channel without white noise cannot be exported, and what to do."""
    missing = f"N of {channel.name} is not resolved"
    if channel.consistent:
        return (
            f"{missing}, and a filter cannot do without: {_OTHERS}, or record at a higher rate or "
            "for longer."
        )
    advice = _OTHERS if fit.explained else f"{_EXPLAIN_IT}, or {_OTHERS}"
    return f"{missing}, and the {_unexplained(channel)}: {advice}."


def _unexplained(channel: FitChannel) -> str:
    named = " and what explain names" if channel.effects else ""
    return f"five terms{named} do not explain {channel.name}"
