"""What `allanfit fit --list` says."""

from collections.abc import Sequence

from ..formatting import printable
from ..recording import Topic


def contents_text(topics: Sequence[Topic]) -> str:
    """One paragraph a topic: name and type, how much of it there is, and its channels."""
    return "\n".join(_paragraph(topic) for topic in topics)


def _paragraph(topic: Topic) -> str:
    rate = "rate unknown" if topic.rate_hz is None else f"{topic.rate_hz:.6g} Hz"
    noun = "message" if topic.kind else "sample"
    amount = f"{topic.samples} {noun}{'s' * (topic.samples != 1)}"
    named = (printable(topic.name), printable(topic.kind), amount, rate)
    head = ", ".join(part for part in named if part)
    units = [(printable(name), printable(unit)) for name, unit in topic.units.items()]
    width = max((len(name) for name, _ in units), default=0)
    channels = [f"  {name:<{width}}  {unit or '-'}" for name, unit in units]
    return "\n".join((head, *(channels or ["  not of a type that is read"])))
