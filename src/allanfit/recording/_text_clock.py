"""Clocks in text: times of the day, with a date or without."""

import re
from dataclasses import dataclass

import numpy as np
import polars as pl

from ._timestamps import OF_DAY

# The same patterns for Python and for polars.
_DATE = r"\d{4}[-/.]\d{1,2}[-/.]\d{1,2}|\d{1,2}[-/.]\d{1,2}[-/.](?:\d{4}|\d{2})"
_FIELD = (
    rf"^(?:(?P<date>{_DATE})[T, ]\s*)?"
    r"(?P<time>\d{1,2}:\d{2}:\d{2}(?:[.,]\d{1,9})?(?:\s*[AaPp][Mm])?)"
    r"\s*(?:Z|UTC|(?P<hours>[-+]\d{2}):?(?P<minutes>\d{2}))?$"
)
_WITHOUT_SECONDS = re.compile(rf"(?:(?:{_DATE})[T, ]\s*)?\d{{1,2}}:\d{{2}}(?:[.,]\d*)?")
_MINUTE = 60_000_000_000
_DAY = 1440 * _MINUTE


@dataclass(frozen=True)
class TextClock:
    """Which columns of text are the clock."""

    time: str
    """The column of the times, perhaps with dates."""
    date: str | None
    """The column of the dates, if they have their own."""
    form: str | None
    """How the dates are written; None where there are none, or month and day may be swapped."""
    half_days: bool
    """Whether times are AM or PM."""

    def read(self, frame: pl.DataFrame) -> tuple[np.ndarray, str]:
        """The stamps and their unit; what is no time is not finite."""
        text = pl.col(self.time).str.strip_chars()
        if self.date is not None:
            text = pl.concat_str(pl.col(self.date).str.strip_chars(), text, separator=" ")
        parts = frame.select(text.str.extract_groups(_FIELD)).to_series().struct.unnest()
        times = parts["time"].str.replace(",", ".", literal=True)
        form = "%I:%M:%S%.f%p" if self.half_days else "%H:%M:%S%.f"
        stamps = times.str.replace_all(" ", "").str.to_time(form, strict=False).to_physical()
        if self.form is None:
            return stamps.to_numpy(), OF_DAY
        dates = parts["date"].str.replace_all("[/.]", "-")
        days = dates.str.to_date(self.form, strict=False).to_physical().cast(pl.Int64)
        hours = parts["hours"].cast(pl.Int64).fill_null(0)
        minutes = parts["minutes"].cast(pl.Int64).fill_null(0)
        away = 60 * hours + hours.sign() * minutes
        return (stamps + days * _DAY - away * _MINUTE).to_numpy(), "ns"


def find_text_clock(first: dict[str, str]) -> TextClock | None:
    """The clock among columns of text, of which the `first` fields are given by name."""
    for name, field in first.items():
        if found := re.match(_FIELD, field):
            date, own = found["date"], None
            if date is None:
                dates = (key for key, text in first.items() if is_date(text))
                own = next(dates, None)
                date = None if own is None else first[own]
            half_days = found["time"][-1] in "mM"
            return TextClock(name, own, None if date is None else _form(date), half_days)
    return None


def _form(date: str) -> str | None:
    """How a date is written; None where month and day may be swapped."""
    if re.match(r"\d{4}", date):
        return "%Y-%m-%d"
    if "." not in date:
        return None
    return "%d-%m-%Y" if re.search(r"\d{4}$", date) else "%d-%m-%y"


def is_date(field: str) -> bool:
    """Whether a field is a date and nothing else."""
    return re.fullmatch(_DATE, field) is not None


def is_clock(field: str) -> bool:
    """Whether a field is a time of the day with its seconds, with a date or without."""
    return re.match(_FIELD, field) is not None


def lacks_seconds(field: str) -> bool:
    """Whether a field is a time of the day to the minute."""
    return _WITHOUT_SECONDS.fullmatch(field) is not None
