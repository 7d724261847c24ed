"""Data sheets as YAML: a section a kind of sensor or channel, a line a number."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, get_args

from ..coefficient_units import UNITS
from ..mapping_file import read_mapping
from ..recording import Channel
from ._phrase import DatasheetError, parse_phrase, units_of
from ._words import SENSES, Bound, Line, Sense, meanings_of, nearest, sense_of

_HINT = "sections such as `gyro: {angle random walk: 0.15 deg/sqrt(h)}`"
_ABOUT = ("sensor", "source")
_BOUNDS: tuple[Bound, ...] = get_args(Bound)
# Words as much alike as this are the same words misspelt; from the lesser on they may be meant.
_MISSPELT, _SIMILAR = 0.88, 0.75


class LeftOut(NamedTuple):
    """A line of a data sheet that is not about the noise of a sensor at rest."""

    section: str
    sentence: str


@dataclass(frozen=True)
class Datasheet:
    """What a maker states of a sensor."""

    file: str
    sensor: str
    """Its name, or none."""
    source: str
    """Where the numbers come from, or nothing."""
    lines: tuple[Line, ...]
    left_out: tuple[LeftOut, ...] = ()

    def left_out_of(self, name: str, kind: str) -> list[str]:
        """A sentence for each line about a channel, or its kind, that is left out."""
        return [each.sentence for each in self.left_out if each.section in (name, kind)]

    def of(self, name: str, kind: str) -> tuple[Line, ...]:
        """The lines about a channel: those under its name, or else those about its kind."""
        named = tuple(line for line in self.lines if line.section == name)
        return named or tuple(line for line in self.lines if line.section == kind)

    def check(self, recording: str, channels: Sequence[Channel]) -> None:
        """Find out before a fit whether the data sheet goes with the channels of a recording.

        **Raises** `DatasheetError` if it names a channel that the recording lacks, in units of
        another kind than the channel's, or says nothing about any channel.
        """
        named = {channel.name: channel for channel in channels}
        for line in self.lines:
            if line.section not in (*named, *UNITS):
                raise DatasheetError(
                    f"{self.file} is about {line.section!r}, which {recording} has not; it "
                    f"has {', '.join(named)}, and a section may be gyro or accelerometer."
                )
            self._check_kind(line, named.get(line.section))
        if not any(self.of(each.name, each.kind) for each in channels):
            raise DatasheetError(
                f"{self.file} says nothing about {', '.join(named)} of {recording}: give "
                "the unit of the recording with --unit, or name a section like the channel."
            )

    def _check_kind(self, line: Line, channel: Channel | None) -> None:
        if channel is not None and channel.kind != line.kind:
            raise DatasheetError(
                f"In {self.file}, {line.words} of {line.section} is in {line.unit}, which is not "
                f"of a channel in {channel.unit or 'no unit'}; give the channel's unit with --unit."
            )


def read_datasheet(path: str | Path) -> Datasheet:
    """The data sheet in a YAML file.

        sensor: ADIS16405
        source: data sheet
        gyro:
          noise density: 0.05 °/s/√Hz
          in-run bias stability: {typical: 0.007 °/s}
        accelerometer:
          velocity random walk: {max: 0.2 m/s/√hr}

    A section is `gyro`, `accelerometer` or a channel's name. A line is a number with its unit,
    typical unless it says `max` or `< 0.05 °/s/√Hz`; `as` overrides how the words are read, as in
    `{typical: 4 mdps/√Hz, as: coefficient}`. What is not about the noise of a sensor at rest, such
    as a bandwidth, is left out, and `left_out` has a sentence for it.

    **Raises** `DatasheetError` if the file is missing or something in it is not understood.
    """
    path = Path(path)
    return datasheet_from(read_mapping(path, "data sheet", _HINT, DatasheetError), path.name)


def is_datasheet(document: Mapping[str, Any]) -> bool:
    """Whether a file of coefficients is a data sheet: it has sections, whose lines have units."""
    sections = any(isinstance(value, Mapping) for value in document.values())
    return sections and not {"unit", "effects"} & set(document)


def datasheet_from(document: Mapping[str, Any], file: str) -> Datasheet:
    """The data sheet of a mapping; `file` is for messages.

    **Raises** `DatasheetError` if something in it is not understood.
    """
    lines: list[Line] = []
    left_out: list[LeftOut] = []
    for section, content in document.items():
        if section in _ABOUT:
            continue
        if not isinstance(content, Mapping) or not content:
            raise DatasheetError(f"{section!r} in {file} has no lines; give {_HINT}.")
        for words, stated in content.items():
            place = f"In {file}, {words} of {section}"
            sense = sense_of(str(words))
            if sense is None:
                left_out.append(LeftOut(str(section), _left_out(str(words), place)))
            else:
                lines += _lines(str(section), str(words), sense, stated, place)
        kinds = {line.kind: line.unit for line in lines if line.section == str(section)}
        if len(kinds) > 1:
            raise DatasheetError(
                f"{section!r} in {file} mixes {' and '.join(kinds.values())}; give a gyro and an "
                "accelerometer a section each."
            )
    if left_out and not lines:
        known = ", ".join(word for word in SENSES if len(word) > 3)
        raise DatasheetError(
            f"{file} says nothing of the noise of a sensor at rest in words that are known; write "
            f"a symbol or one of {known}."
        )
    if not lines:
        raise DatasheetError(f"{file} holds no data sheet; give {_HINT}.")
    sensor, source = (str(document.get(key) or "") for key in _ABOUT)
    return Datasheet(file, sensor, source, tuple(lines), tuple(left_out))


def left_out_of(path: str | Path) -> tuple[str, ...]:
    """A sentence for each line that is left out of a file, if it is a data sheet at all."""
    path = Path(path)
    if path.suffix.lower() not in (".yaml", ".yml", ".json"):
        return ()
    try:
        document = read_mapping(path, "data sheet", _HINT, DatasheetError)
        sheet = datasheet_from(document, path.name) if is_datasheet(document) else None
    except DatasheetError:
        return ()
    return () if sheet is None else tuple(each.sentence for each in sheet.left_out)


def _left_out(words: str, place: str) -> str:
    """Why a line is left out.

    **Raises** `DatasheetError` if it looks like a misspelt one that would be read.
    """
    known, alike = nearest(words)
    if alike >= _MISSPELT:
        raise DatasheetError(f"{place} is not understood; if it means {known}, write so.")
    meant = f"; if it means {known}, write so" if alike >= _SIMILAR else ""
    return f"{place} is left out: it is not known as noise of a sensor at rest{meant}."


def _lines(section: str, words: str, sense: Sense, stated: Any, place: str) -> Iterator[Line]:
    named = isinstance(stated, Mapping)
    given = dict(stated) if named else {"typical": stated}
    sense = _overridden(sense, given.pop("as", sense.meaning), place)
    unknown = sorted(str(key) for key in set(given) - set(_BOUNDS))
    if unknown and unknown[0][:1].isdigit():
        raise DatasheetError(f"{place} has a comma in its number: write a decimal point.")
    if unknown or not given:
        raise DatasheetError(
            f"{place} has {unknown[0] if unknown else 'no number'}; give typical or max, and as."
        )
    for bound in _BOUNDS:
        if bound in given:
            own = bound if named else None
            yield _line(section, words, sense, own, given[bound], place)


def _example(section: str, sense: Sense) -> str:
    """A unit for a line of this kind, for a message."""
    kind = "accelerometer" if section == "accelerometer" else "gyro"
    if sense.meaning == "one_sided_density":
        return {"gyro": "deg/s/sqrt(Hz)", "accelerometer": "ug/sqrt(Hz)"}[kind]
    return UNITS[kind][sense.symbol].field[0]


def _overridden(sense: Sense, meaning: Any, place: str) -> Sense:
    for known in meanings_of(sense.symbol):
        if meaning == known:
            return Sense(sense.symbol, known)
    raise DatasheetError(
        f"{place} cannot be read as {meaning!r}; as is {' or '.join(meanings_of(sense.symbol))}."
    )


def _line(
    section: str, words: str, sense: Sense, bound: Bound | None, phrase: Any, place: str
) -> Line:
    """One line; where no bound is named, `< 7 deg/hr` is a largest value."""
    try:
        quantity = parse_phrase(phrase, _example(section, sense))
    except DatasheetError as error:
        raise DatasheetError(f"{place}: {error}.") from error
    measured = quantity.measured
    kind = section if section in UNITS else measured.kind
    if (measured.kind, measured.symbol) != (kind, sense.symbol):
        raise DatasheetError(
            f"{place} cannot be in {quantity.unit}; give it in {units_of(kind, sense.symbol)} or "
            "the like."
        )
    return Line(
        section,
        words,
        sense.symbol,
        sense.meaning,
        kind,
        bound or ("max" if quantity.bounded else "typical"),
        quantity.number,
        quantity.unit,
        measured.factor,
    )
