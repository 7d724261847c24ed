"""A recording's answer beside what was said of it, and a share of such rows with its bar."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from scipy.stats import beta


@dataclass(frozen=True)
class Row:
    """One recording: what is so, and what was said."""

    truth: dict
    said: dict
    """The channel's entry in `explain`, or {} where the tool failed."""
    seconds: float

    @property
    def effects(self) -> list[dict]:
        return self.truth["effects"]

    @property
    def only(self) -> dict | None:
        """The cause, where it is one and in the catalogue."""
        alone = len(self.effects) == 1 and not self.effects[0]["outside"]
        return self.effects[0] if alone else None

    @property
    def outside(self) -> bool:
        return any(effect["outside"] for effect in self.effects)

    @property
    def verdict(self) -> str:
        return self.said.get("verdict", "failed")

    @property
    def alarm(self) -> bool:
        return self.verdict not in ("consistent", "failed")

    @property
    def named(self) -> list[str]:
        return [effect["name"] for effect in self.said.get("effects", [])]

    def names(self, effect: dict) -> bool:
        return bool(set(effect["accepted"]) & set(self.named))

    @property
    def gain(self) -> float | None:
        score = (self.said.get("improvement") or {}).get("held_out_log_score") or {}
        return score.get("difference")


@dataclass(frozen=True)
class Figure:
    """A share of recordings, and what it should be."""

    name: str
    hits: int
    total: int
    target: str = ""

    @property
    def share(self) -> float:
        return self.hits / self.total if self.total else float("nan")

    @property
    def bar(self) -> tuple[float, float]:
        """Clopper and Pearson's 95 % interval."""
        k, n = self.hits, self.total
        low = beta.ppf(0.025, k, n - k + 1) if k else 0.0
        high = beta.ppf(0.975, k + 1, n - k) if k < n else 1.0
        return float(low), float(high)

    @property
    def met(self) -> bool | None:
        return judge(self.share, self.target) if self.total else None


def judge(value: float, target: str) -> bool | None:
    """Whether a value meets `<= x`, `>= x` or `x to y`; None without a target."""
    if not target:
        return None
    if " to " in target:
        low, high = map(float, target.split(" to "))
        return low <= value <= high
    sign, limit = target.split()
    return value <= float(limit) if sign == "<=" else value >= float(limit)


def share(
    name: str, rows: Iterable[Row], test: Callable[[Row], bool | None], target: str = ""
) -> Figure:
    """Of the rows for which the test has an answer, those for which it is yes."""
    answers = [a for a in map(test, rows) if a is not None]
    return Figure(name, sum(answers), len(answers), target)
