"""Coefficients as YAML, which `allanfit simulate` and `allanfit plan` read back."""

from ..physics import parameter_unit, parameter_values
from ._doubts import doubts
from ._exported import Exported
from ._options import Options
from ._read import Coefficient, FitChannel, FitFile
from ._yaml_text import comment, number, text


def coefficients_yaml(fit: FitFile, options: Options) -> Exported:
    """Every coefficient of every channel with its intervals, resolved or not, to the last digit."""
    doubtful = doubts(fit, fit.channels)
    lines = [
        *comment(f"Noise coefficients of {fit.recording}, written by allanfit."),
        *comment("Simulate with: allanfit simulate FILE --duration S --rate HZ --output FILE"),
        *comment(
            "Continuous time. One-sided densities: 2 N^2, B^2/(pi f), K^2/(2 pi^2 f^2). A term "
            "that is not resolved is not simulated."
        ),
        *(line for doubt in doubtful for line in comment(doubt)),
        f"recording: {text(fit.recording)}",
        "channels:",
    ]
    for channel in fit.channels:
        lines += _channel_lines(channel)
    return Exported("\n".join(lines) + "\n", doubtful)


def _channel_lines(channel: FitChannel) -> list[str]:
    lines = [
        f"- channel: {text(channel.name)}",
        f"  unit: {text(channel.unit)}",
        f"  rate_hz: {number(channel.rate_hz)}",
        f"  samples: {channel.samples}",
        f"  sampling: {channel.sampling}",
        f"  mean: {number(channel.mean)}",
        "  coefficients:",
    ]
    for term in channel.coefficients.values():
        lines += _term_lines(term)
    return lines + _effect_lines(channel)


def _effect_lines(channel: FitChannel) -> list[str]:
    """Each effect with its parameters, as `allanfit simulate` reads them."""
    lines = ["  effects:"] if channel.effects else []
    for effect in channel.effects:
        values = parameter_values(effect)
        lines.append(f"  - name: {effect.name}")
        lines += [
            f"    {each.name}: {_numbers(values[each.name].tolist())}"
            f"  # {parameter_unit(each, channel.unit)}".removesuffix("  # ")
            for each in effect.parameters
            if each.name in values
        ]
    return lines


def _numbers(value: float | list) -> str:
    if isinstance(value, list):
        return f"[{', '.join(_numbers(each) for each in value)}]"
    return number(value)


def _term_lines(term: Coefficient) -> list[str]:
    limit = "null" if term.upper_limit_95 is None else number(term.upper_limit_95)
    intervals = ", ".join(
        f"{text(probability)}: [{number(low)}, {number(high)}]"
        for probability, (low, high) in term.intervals.items()
    )
    return [
        f"    {term.symbol}:",
        f"      name: {text(term.name)}",
        f"      unit: {text(term.unit)}",
        f"      value: {number(term.value)}",
        f"      resolved: {'true' if term.resolved else 'false'}",
        f"      upper_limit_95: {limit}",
        f"      intervals: {{{intervals}}}",
    ]
