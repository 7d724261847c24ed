"""What `allanfit fit --list` says."""

from collections.abc import Sequence

from ..recording import Topic


def contents_text(topics: Sequence[Topic]) -> str:
    """One paragraph a topic: name and type, how much of it there is, and its channels."""
    return "\n".join(_paragraph(topic) for topic in topics)


def _paragraph(topic: Topic) -> str:
    rate = "rate unknown" if topic.rate_hz is None else f"{topic.rate_hz:.6g} Hz"
    noun = "message" if topic.kind else "sample"
    amount = f"{topic.samples} {noun}{'s' * (topic.samples != 1)}"
    head = ", ".join(part for part in (topic.name, topic.kind, amount, rate) if part)
    width = max(map(len, topic.units), default=0)
    channels = [f"  {name:<{width}}  {unit or '-'}" for name, unit in topic.units.items()]
    return "\n".join((head, *(channels or ["  not of a type that is read"])))
