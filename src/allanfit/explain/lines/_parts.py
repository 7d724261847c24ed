"""Parts of one line, which has no textbook shape, put together."""

from dataclasses import replace

import numpy as np

from .._effect import Effect

# Bands that lie as close are parts of one line.
_BESIDE = 1.02
_SIZES = {"drifting_line": "amplitude", "resonance": "sigma"}


def merged(found: list[Effect]) -> list[Effect]:
    """Parts of one line, whose bands meet, as one effect: the larger names it."""
    kept: list[Effect] = []
    for effect in sorted(found, key=lambda each: -_size(each)):
        same = next((old for old in kept if _one_line(old, effect)), None)
        if same is None:
            kept.append(effect)
        elif same.name == effect.name:
            kept[kept.index(same)] = _joined(same, effect)
    return kept


def _size(effect: Effect) -> float:
    return effect.value(_SIZES[effect.name]) if effect.name in _SIZES else np.inf


def _one_line(one: Effect, two: Effect) -> bool:
    if one.name not in _SIZES or two.name not in _SIZES:
        return False
    if one.band_hz is None or two.band_hz is None:
        return False
    low = max(one.band_hz[0], two.band_hz[0])
    return low < _BESIDE * min(one.band_hz[1], two.band_hz[1])


def _joined(one: Effect, two: Effect) -> Effect:
    size = "amplitude" if one.name == "drifting_line" else "sigma"
    count = min(one.parameters[size].size, two.parameters[size].size)
    a, b = ({k: v[:count] for k, v in each.parameters.items()} for each in (one, two))
    first, second = a[size] ** 2, b[size] ** 2
    total = first + second
    mean = (first * a["frequency"] + second * b["frequency"]) / total
    values = {size: np.sqrt(total), "frequency": mean}
    if one.name == "drifting_line":
        spread = first * (a["width"] ** 2 + (a["frequency"] - mean) ** 2)
        spread += second * (b["width"] ** 2 + (b["frequency"] - mean) ** 2)
        values["width"] = np.sqrt(spread / total)
    else:
        values["quality_factor"] = np.minimum(a["quality_factor"], b["quality_factor"])
    assert one.band_hz is not None
    assert two.band_hz is not None
    band = (min(one.band_hz[0], two.band_hz[0]), max(one.band_hz[1], two.band_hz[1]))
    return replace(one, parameters=values, band_hz=band)
