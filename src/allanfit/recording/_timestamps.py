"""What time stamps say: the rate, gaps, and how far they can be trusted.

A sensor samples evenly; its stamps often do not. Transport delivers samples in bursts, a busy
computer stamps them late, a coarse clock repeats itself. A late sample is told from a lost one by
what follows: after a delay later stamps catch up with the even grid, after a gap none ever does.
Wrong stamps, which those before and after contradict, are mended first.

Single losses are counted where stamps are rounded to at most half an interval. Rounded to more, a
step with a loss may be as short as one without, and some are missed. Rounded to nearly an interval,
most steps are alike and the others look like losses.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Num

from ._interval import fresh, typical_interval
from ._lateness import CATCH_UP, GAP, SHORTEST_STRETCH, about_wrong, lost_time, mended, reach
from ._recording import RecordingError
from ._wording import count, percent

OF_DAY = "ns of the day"
"""The unit of stamps that begin again at midnight."""

_SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_LONGER = {"min": 60.0, "minutes": 60.0, "h": 3600.0, "hours": 3600.0, "days": 86_400.0}
_SPELLINGS = {"sec": "s", "secs": "s", "seconds": "s", "msec": "ms", "usec": "us", "nsec": "ns"}
_WHOSE = "elapsed|epoch|unix|utc|gps|ros|system|sys|host|device|dev|sensor|sample|header|log"
_NAME = re.compile(
    rf"(?:(?:(?:{_WHOSE})[_ ]?)?time(?:[_ ]?stamps?)?(?:[_ ]?elapsed)?"
    r"|stamps?|t|ts|elapsed|epoch|(?:gps[_ ]?)?tow|zeit)"
    r"(?:(?:_|, *)(s|secs?|seconds)|(?:_|, *)?(ms|us|ns|msec|usec|nsec))?",
    re.IGNORECASE,
)
# Loggers that count give the unit as the name.
_COUNTS = {
    **{"millis": "ms", "msec": "ms", "milliseconds": "ms", "micros": "us", "usec": "us"},
    **{"microseconds": "us", "nanos": "ns", "nsec": "ns", "nanoseconds": "ns"},
    **{"seconds_elapsed": "s", "seconds": "s", "secs": "s"},
}
# What a message of ROS is called by: its own stamp, and not when it arrived.
_OWN_STAMP = "header.stamp"

_DAY_NS = 86_400e9
# Days since 1900 in spreadsheets, since the year 0 in MATLAB; as s, such stamps of sensors that
# are read in more than 4 s would be less than 50 us apart.
_DAYS = ((3e4, 8e4), (7e5, 8e5))
_SHORT_FOR_S = 5e-5
# Intervals that a unit may give to stamps since 1970, and up to which nobody asks whether they are
# in s: the next unit would make them a thousand times as short.
_FASTEST_S, _SLOWEST_S, _USUAL_S = 1e-5, 100.0, 0.15
_WRAP = 2.0**32

# Of more stamps that are wrong, nothing is to be had.
_MOST_WRONG = 0.1


@dataclass(frozen=True)
class Clock:
    """The time axis of a recording."""

    rate_hz: float
    """Samples a second, losses allowed for."""
    breaks: tuple[int, ...]
    """Index of the first sample after each gap."""
    findings: tuple[str, ...]
    """Gaps, repeats, jitter, doubts about the unit or the given rate."""
    lost: float = 0.0
    """Share of the samples that were lost, where some were a few at a time; no long gaps."""
    losses: tuple[tuple[int, int], ...] = ()
    """Index of the first sample after each of these losses, and how many were lost."""
    gaps: tuple[tuple[int, float, int], ...] = ()
    """Index of the last sample before each gap, its length [s], and about how many are missing."""
    lost_deviation: float = 0.0
    """Standard deviation of the logarithm of `lost`, by chance."""
    unit: str = ""
    """What the stamps count, one of s, ms, us and ns, where there are any."""
    wrong: tuple[int, ...] = ()
    """Index of each sample with a wrong stamp."""
    off_s: float = 0.0
    """By how much the first of these is off."""
    known: int = 0
    """So many samples, from the first on, are told of; 0 without stamps."""


def is_time(name: str, unit: str = "") -> bool:
    """Whether a column holds times, by its name or by its unit."""
    return _has_name_of_time(name) or _plain_unit(unit) in _SECONDS or unit == OF_DAY


def time_columns(columns: Iterable[str], units: Mapping[str, str]) -> list[str]:
    """Those that hold times; the likeliest time stamps, which are called so, come first."""
    times = [name for name in columns if is_time(name, units.get(name, ""))]
    return sorted(
        times, key=lambda name: (not _has_name_of_time(name), not name.endswith(_OWN_STAMP))
    )


def _has_name_of_time(name: str) -> bool:
    return _NAME.fullmatch(_last(name)) is not None or _last(name).lower() in _COUNTS


def _last(name: str) -> str:
    """The name of a field within its message or structure; a `T` there is a temperature."""
    field = re.split("[./]", name)[-1]
    return field if len(field) > 1 else name


def _plain_unit(unit: str) -> str:
    plain = unit.strip().replace("µ", "u").replace("μ", "u").lower()
    return _SPELLINGS.get(plain, plain)


def read_clock(
    stamps: Num[np.ndarray, " samples"],
    name: str,
    unit: str,
    given_hz: float | None,
    known: int | None = None,
) -> Clock:
    """The time axis told by `stamps`, called `name`, in `unit` (empty when unknown).

    `given_hz` is the rate known from elsewhere: it helps to infer the unit and is compared.
    Of the samples from about `known` on nothing is said: it takes those that follow them.

    **Raises** `RecordingError` when no rate can be had from the stamps.
    """
    if stamps.size < 2 * SHORTEST_STRETCH:
        raise _unusable(f"there are only {stamps.size}")
    if unit == OF_DAY:
        stamps, unit = _over_midnight(stamps), "ns"
    ticks, findings = _from_first(stamps)
    ticks, wrapped = _over_wraps(ticks)
    findings += wrapped
    counted, tick, doubt = _tick(name, unit, stamps, typical_interval(ticks), given_hz)
    read = ticks * tick
    backward = int(np.count_nonzero(np.diff(read) < 0))
    if backward > _MOST_WRONG * read.size:
        raise _unusable(f"{backward} of {read.size} are earlier than the one before")
    interval = typical_interval(read)
    if interval <= 0:
        raise _unusable("they do not increase")
    time, off = mended(read, interval)
    wrong = np.flatnonzero(off)
    if wrong.size > _MOST_WRONG * read.size:
        raise _unusable(f"{wrong.size} of {read.size} do not fit those before and after")
    if wrong.size:
        # The first stamp may be one of them.
        read, time = read - time[0], time - time[0]
        interval = typical_interval(time)
    steps = np.diff(time)
    new = fresh(time)
    # Samples of one stamp, and those of which one has caught up.
    burst = int(np.median(np.diff(new))) if new.size else 0
    window = max(reach(time.size), 2 * burst)
    # Samples that are told of, and steps.
    end = read.size if known is None or known >= read.size else min(known, read.size - window)
    if end < read.size and off[end]:
        # Wrong stamps in a row are left to the next together, with one before them.
        end = int(np.flatnonzero(~off[:end])[-1])
    told = min(end, steps.size)
    backward = int(np.count_nonzero(steps[:told] < 0))
    # Single losses can be told only where most steps are as long as they should be.
    regular = np.mean(np.abs(steps - interval) < 0.25 * interval) > 0.5
    # Where the clock was set back it goes on, so that lost time is counted on either side.
    set_back = np.flatnonzero(steps < -GAP * interval)
    steps[set_back] = interval
    onward = np.concatenate([[0.0], np.cumsum(steps)]) if set_back.size else time
    # Nothing follows the last few that could tell whether they are late.
    first, last = 0, steps.size - max(SHORTEST_STRETCH, burst)
    if new.size:
        # Where a coarse clock goes on, its stamps are as fresh.
        first, last = int(new[0]), int(new[new <= last][-1])
    # Once the losses are known, the mean interval is sharper than the typical one.
    for _ in range(2):
        lost = lost_time(onward, interval, window)
        # Too few samples are left to catch up: a late last packet is no gap.
        lost[-max(SHORTEST_STRETCH, burst) :] = 0.0
        lost[lost < (0.5 if regular else GAP) * interval] = 0.0
        # A few are whole samples; of what follows them the earliest stamp is earlier than it should
        # be by all that stamps scatter.
        lost = np.where(lost < GAP * interval, np.round(lost / interval) * interval, lost)
        interval = float((onward[last] - onward[first] - lost[first:last].sum()) / (last - first))
        if not interval > 0:
            raise _unusable("they do not increase")
    set_back = set_back[set_back < told]
    wrong = wrong[wrong < end]
    gaps = np.flatnonzero(lost[:told] >= GAP * interval)
    few = np.flatnonzero((lost[:told] > 0) & (lost[:told] < GAP * interval))
    counts = np.round(lost[:told] / interval).astype(int)
    dropped = int(counts[few].sum())
    # More digits than stamps carry would only be the rounding of the sum.
    rate_hz = float(f"{1 / interval:.9g}")
    off_s = float(read[wrong[0]] - time[wrong[0]]) if wrong.size else 0.0
    findings += doubt
    findings += about_wrong(wrong.tolist(), off_s)
    findings += _about_gaps(time, steps, gaps, lost, interval)
    if dropped:
        findings += (
            "Missing by the time stamps, a few at a time: "
            f"{count(dropped, 'sample')} ({percent(dropped / told)}). The rate allows for "
            "them, and the others are taken as consecutive.",
        )
    findings += _about_order(backward, set_back.size)
    # Of a coarse clock, within a sample at either end, and a step of the clock where it breaks.
    unsure = (1 + burst * (gaps.size + set_back.size)) / (last - first) if burst else 0.0
    findings += _about_jitter(steps - lost, interval, unsure)
    findings += _about_rate(rate_hz, given_hz)
    breaks = np.union1d(gaps, set_back) + 1
    # Where single samples are lost, so are the longer runs: no more than a pause is.
    together = counts[(counts > 0) & (counts < CATCH_UP)] if dropped else counts[:0]
    brief = int(together.sum())
    # What is lost together is lost by one chance: a sum of sizes, as many as chance has it, has the
    # variance of the sum of their squares.
    deviation = float(np.sqrt(np.sum(together**2))) / max(brief, 1)
    lost_share = brief / (told + brief)
    losses = tuple(zip((few + 1).tolist(), counts[few].tolist(), strict=True))
    return Clock(
        rate_hz=rate_hz,
        breaks=tuple(breaks.tolist()),
        findings=findings,
        lost=lost_share,
        losses=losses,
        gaps=tuple(zip(gaps.tolist(), steps[gaps].tolist(), counts[gaps].tolist(), strict=True)),
        lost_deviation=deviation,
        unit=counted,
        wrong=tuple(wrong.tolist()),
        off_s=off_s,
        known=end,
    )


def _unusable(reason: str) -> RecordingError:
    return RecordingError(f"The time stamps cannot be used: {reason}.")


def _over_midnight(stamps: Num[np.ndarray, " samples"]) -> Float64[np.ndarray, " samples"]:
    """Times of the day in ns as a time that goes on at midnight."""
    time = stamps.astype(np.float64)
    present = np.isfinite(time)
    # A day has no more digits than a float, and what goes back by less is no new day.
    new_day = np.diff(time[present]) < -0.5 * _DAY_NS
    time[present] += _DAY_NS * np.concatenate([[0], np.cumsum(new_day)])[: np.sum(present)]
    return time


def _from_first(
    stamps: Num[np.ndarray, " samples"],
) -> tuple[Float64[np.ndarray, " samples"], tuple[str, ...]]:
    """Stamps counted from the first one, and a finding when some are missing."""
    if np.issubdtype(stamps.dtype, np.integer):
        # As integers: nanoseconds since 1970 have more digits than a float.
        return (stamps.astype(np.int64) - np.int64(stamps[0])).astype(np.float64), ()
    time = stamps.astype(np.float64)
    finite = np.isfinite(time)
    present = np.flatnonzero(finite)
    if present.size == time.size:
        return time - time[0], ()
    if present.size < 0.9 * time.size:
        raise _unusable(f"{time.size - present.size} of {time.size} are missing or not finite")
    # Beyond the first and the last that are present, on at the usual interval.
    interval = typical_interval(time[present])
    at = np.arange(time.size)
    before, after = at - present[0], at - present[-1]
    time = np.interp(at, present, time[present])
    time += interval * (np.minimum(before, 0) + np.maximum(after, 0))
    return time - time[0], (f"Time stamps missing or not finite: {time.size - present.size}.",)


def _over_wraps(
    ticks: Float64[np.ndarray, " samples"],
) -> tuple[Float64[np.ndarray, " samples"], tuple[str, ...]]:
    """Stamps of a counter of 32 bits, which begins again: as `micros` does after 71.6 min."""
    steps = np.diff(ticks)
    onward = steps + _WRAP
    wraps = (steps < 0) & (onward > 0) & (onward < 1e-3 * _WRAP)
    if not wraps.any():
        return ticks, ()
    ticks = ticks + _WRAP * np.concatenate([[0], np.cumsum(wraps)])
    times = count(int(wraps.sum()), "time")
    return ticks, (f"The time stamps count to 2^32 and begin again {times}; they are continued.",)


def _tick(
    name: str,
    unit: str,
    stamps: Num[np.ndarray, " samples"],
    interval: float,
    given_hz: float | None,
) -> tuple[str, float, tuple[str, ...]]:
    """The unit of the stamps, seconds in one, and a finding when that had to be inferred."""
    suffix = _NAME.fullmatch(_last(name))
    in_name = _COUNTS.get(_last(name).lower(), (suffix and (suffix[1] or suffix[2])) or "")
    stated = _plain_unit(unit or in_name)
    if stated in _LONGER:
        return "", _LONGER[stated], ()
    if stated:
        if stated not in _SECONDS:
            raise _unusable(f"their unit '{unit}' is none of h, min, s, ms, us and ns")
        return stated, _SECONDS[stated], ()
    middle = float(np.nanmedian(stamps))
    if 0 < interval < _SHORT_FOR_S and any(low <= middle <= high for low, high in _DAYS):
        finding = (
            "The time stamps are taken to be in days, as spreadsheets count them: they are about "
            f"{middle:.8g}, and {interval:.4g} apart."
        )
        return "", 86_400.0, (finding,)
    # Inertial sensors are sampled between 1 Hz and 1 kHz, give or take.
    inferred = "s" if interval < 1 else "ms" if interval < 1e3 else "us" if interval < 1e6 else "ns"
    sure = interval < _USUAL_S
    for candidate, seconds in _SECONDS.items():
        # Since 1970, in this century.
        dated = 1e9 < middle * seconds < 4e9 and _FASTEST_S < interval * seconds < _SLOWEST_S
        agrees = given_hz is not None and abs(interval * seconds * given_hz - 1) < 0.05
        if dated or agrees:
            inferred, sure = candidate, True
        if agrees:
            break
    if inferred == "s" and sure:
        return "s", 1.0, ()
    finding = (
        f"The time stamps are taken to be in {inferred}, since their typical interval is "
        f"{interval:.4g}: write the unit in the header, as in `{name} [{inferred}]`."
    )
    return inferred, _SECONDS[inferred], (finding,)


def _about_gaps(
    time: Float64[np.ndarray, " samples"],
    steps: Float64[np.ndarray, " steps"],
    gaps: np.ndarray,
    lost: Float64[np.ndarray, " steps"],
    interval: float,
) -> tuple[str, ...]:
    if gaps.size == 0:
        return ()
    longest = gaps[np.argmax(steps[gaps])]
    missing = round(float(lost[gaps].sum() / interval))
    where = f"{steps[longest]:.4g} s at {time[longest]:.6g} s"
    what = (
        f"The time stamps have a gap of {where}"
        if gaps.size == 1
        else f"The time stamps have {gaps.size} gaps, {steps[gaps].sum():.4g} s in all, the "
        f"longest {where}"
    )
    return (f"{what}: about {missing} samples are missing there, and nothing is put in place.",)


def _about_order(backward: int, set_back: int) -> tuple[str, ...]:
    if backward == 0:
        return ()
    cut = f", far enough to cut the recording there {count(set_back, 'time')}" if set_back else ""
    return (f"The time stamps step backward {count(backward, 'time')}{cut}.",)


def _about_jitter(
    steps: Float64[np.ndarray, " steps"], interval: float, unsure: float
) -> tuple[str, ...]:
    repeats = np.count_nonzero(steps == 0) / steps.size
    low, high = np.quantile(steps, [0.01, 0.99])
    if repeats < 0.01 and high - low < 0.5 * interval:
        return ()
    repeated = f"{percent(repeats)} repeat the one before, " if repeats >= 0.01 else ""
    around = f"{1e3 * interval:.4g} ms"
    spread = f"intervals range from {1e3 * low:.4g} to {1e3 * high:.4g} ms around {around}"
    if repeats > 0.5:
        # Most intervals are none.
        ends = np.quantile(steps[steps != 0], [0.01, 0.99])
        later = " to ".join(dict.fromkeys(f"{1e3 * end:.4g}" for end in ends))
        spread = f"the others are {later} ms later, and the mean interval is {around}"
    return (
        f"The time stamps are uneven: {repeated}{spread}; the samples are taken as evenly spaced."
        + (f" The rate is known to within {percent(unsure)}." if unsure else ""),
    )


def _about_rate(rate_hz: float, given_hz: float | None) -> tuple[str, ...]:
    if given_hz is None or abs(given_hz / rate_hz - 1) < 0.03:
        return ()
    ratio = given_hz / rate_hz
    hint = "check which is right."
    if abs(given_hz * rate_hz - 1) < 0.03:
        hint = "is it the sampling interval in s, not the rate?"
    for power in (1e-9, 1e-6, 1e-3, 1e3, 1e6, 1e9):
        if abs(ratio / power - 1) < 0.03:
            hint = f"it is off by a factor of {max(power, 1 / power):g}, is a unit mistaken?"
    return (
        f"The rate of {given_hz:.6g} Hz, which is used, disagrees with the time stamps, which say "
        f"{rate_hz:.6g} Hz: {hint}",
    )
