"""Matrices of a bias-state filter, in continuous and in discrete time, as JSON."""

import json
import re
from collections.abc import Sequence
from typing import Any

from ..formatting import printable
from ._doubts import doubts
from ._effect_parts import STATES, effect_entries, left_out
from ._errors import ExportError
from ._exported import Exported
from ._options import LIMIT, Options
from ._parts import Realised, realise
from ._read import FitChannel, FitFile
from ._state_space import System, discretise, stack

SCHEMA = "allanfit.kalman/1"

_CONVENTIONS = [
    "u is the unit of the channel; times are in seconds.",
    "Continuous time: x' = F x + G w, y = H x + v. Qc and Rc are two-sided densities, those of "
    "E[w(t) w(s)^T] = Qc delta(t - s): white noise N [u/sqrt(Hz)] has Rc = N^2 and the one-sided "
    "density 2 N^2.",
    "Discrete time, steps of dt_s: x[k+1] = Phi x[k] + w[k], y[k] = H x[k] + v[k]; Qd and Rd are "
    "covariances of w[k] and v[k]: white noise has Rd = N^2/dt_s.",
    "y is the error of the sensor: its output less the true input.",
    "initial_variance is that of a state at the start; null where a fit of one recording cannot "
    "know it: set the variance of the offset from one switching-on to the next.",
]
_UNITS = {
    "continuous": {
        "F": "1/s, times the unit of the row's state over that of the column's",
        "G": "1, into the derivative of the state",
        "Qc": "(unit of the state/s)^2/Hz, two-sided",
        "H": "u over the unit of the state",
        "Rc": "u^2/Hz, two-sided",
    },
    "discrete": {
        "Phi": "the unit of the row's state over that of the column's",
        "Qd": "product of the units of the two states",
        "H": "u over the unit of the state",
        "Rd": "u^2",
    },
}


def kalman(fit: FitFile, options: Options) -> Exported:
    """State-space models of each channel, and of all together where there are several.

    **Raises:** `ExportError` if flicker cannot be realised in the band, or channels of one kind
    differ in unit, so that their stack would mix units.
    """
    if options.walk not in (None, LIMIT):
        raise ExportError(
            "A walk that stands for B has no place beside B's own states: leave --walk out, or "
            "give --walk limit for a K that is not resolved."
        )
    _refuse_mixed_units(fit.channels)
    realised = [
        realise(channel, options.band_s, walk_limit=options.walk == LIMIT)
        for channel in fit.channels
    ]
    rates = {channel.rate_hz for channel in fit.channels}
    warnings = [*doubts(fit, fit.channels), *_warnings(fit.channels, options, len(rates))]
    document = {
        "schema": SCHEMA,
        "recording": fit.recording,
        "warnings": [printable(each) for each in warnings],
        "conventions": _CONVENTIONS,
        "units": _UNITS,
        "channels": [
            _channel_entry(channel, each)
            for channel, each in zip(fit.channels, realised, strict=True)
        ],
    }
    if len(fit.channels) > 1 and len(rates) == 1:
        document["stacked"] = _stacked_entry(fit.channels, realised)
    return Exported(_compact(document), warnings)


def _stacked_entry(channels: Sequence[FitChannel], realised: Sequence[Realised]) -> dict[str, Any]:
    """All channels at once: H has a row for each."""
    entry = _system_entry(stack([each.parts for each in realised]), channels[0].dt)
    owners = [
        channel.name
        for channel, each in zip(channels, realised, strict=True)
        for part in each.parts
        for _ in part.states
    ]
    for state, owner in zip(entry["states"], owners, strict=True):
        state["name"] = f"{owner}.{state['name']}"
    return {
        "channels": [channel.name for channel in channels],
        "units": [channel.unit for channel in channels],
        **entry,
    }


def _refuse_mixed_units(channels: Sequence[FitChannel]) -> None:
    first: dict[str, FitChannel] = {}
    for channel in channels:
        other = first.setdefault(channel.kind, channel)
        if other.kind != "other" and other.unit != channel.unit:
            raise ExportError(
                f"{other.name} is in {other.unit} and {channel.name} in {channel.unit}: fit both "
                "in one unit, or export one at a time with --channel."
            )


def _channel_entry(channel: FitChannel, realised: Realised) -> dict[str, Any]:
    coefficients = {
        symbol: {**term.to_dict(), "how": realised.how[symbol]}
        for symbol, term in channel.coefficients.items()
    }
    entry = {
        "channel": channel.name,
        "unit": channel.unit,
        "rate_hz": channel.rate_hz,
        "coefficients": coefficients,
        **_system_entry(stack([realised.parts]), channel.dt),
    }
    if channel.effects:
        entry["effects"] = effect_entries(channel, realised.effects)
    if realised.flicker is not None:
        entry["flicker"] = {
            "states": len(realised.flicker.relaxations),
            "band_s": list(realised.flicker.band_s),
            "worst_error_of_allan_deviation": realised.flicker.worst_error,
            "relaxation_times_s": [each.time_s for each in realised.flicker.relaxations],
            "variances": [each.variance for each in realised.flicker.relaxations],
        }
    return entry


def _system_entry(system: System, dt: float) -> dict[str, Any]:
    discrete = discretise(system, dt)
    return {
        "states": [state._asdict() for state in system.states],
        "continuous": {
            "F": system.F.tolist(),
            "G": system.G.tolist(),
            "Qc": system.Qc.tolist(),
            "H": system.H.tolist(),
            "Rc": system.Rc.tolist(),
        },
        "discrete": {
            "dt_s": dt,
            **{name: matrix.tolist() for name, matrix in discrete._asdict().items()},
        },
    }


def _warnings(channels: Sequence[FitChannel], options: Options, rates: int) -> list[str]:
    notes = []
    if rates > 1:
        notes.append("The channels differ in rate, so that there is no stack of all of them.")
    for channel in channels:
        bias, walk = channel.coefficients["B"], channel.coefficients["K"]
        if not walk.resolved and options.walk is None:
            notes.append(
                f"K of {channel.name} is not resolved: its bias is a constant without drive; "
                "--walk limit drives it at the 95 % upper limit."
            )
        if not bias.resolved:
            notes.append(f"B of {channel.name} is not resolved: there are no flicker states.")
        if channel.coefficients["Q"].resolved:
            notes.append(
                f"Q of {channel.name} is not in the matrices: it is noise of the integrated signal."
            )
    return [*notes, *left_out(channels, "A filter of these matrices", STATES)]


def _compact(document: dict[str, Any]) -> str:
    """JSON with each row of a matrix on one line."""
    text = json.dumps(document, indent=1, allow_nan=False)
    return re.sub(r"\[\s+([^\[\]{}\"]*?)\s+\]", _one_line, text) + "\n"


def _one_line(match: re.Match[str]) -> str:
    return "[" + re.sub(r"\s+", " ", match[1]) + "]"
