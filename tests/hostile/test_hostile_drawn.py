"""Files drawn at random: readers refuse in a sentence or read what was written, and never else."""

import gzip
import re

import numpy as np
import pytest
from bad_recordings import WORDS, npy, npz
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from allanfit.coefficients import CoefficientsError, read_coefficients
from allanfit.recording import RecordingError, load
from allanfit.recording._units import parse_unit

DRAWN = settings(
    max_examples=60,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
GOOD = {
    "a.csv": ("time_s,gyro_x [deg/s]\n" + "".join(f"{k / 100},{v}\n" for k, v in enumerate(WORDS))),
    "a.txt": "".join(f"{v} {2 * v}\n" for v in WORDS),
    "a.npy": npy(WORDS),
    "a.npz": npz(gyro_x=WORDS, rate_hz=100.0, units='{"gyro_x": "deg/s"}'),
    "a.csv.gz": gzip.compress(b"x\n" + b"".join(b"%f\n" % v for v in WORDS)),
    "a.yaml": "unit: deg/s\nN: 5.0e-3\neffects:\n- {name: sinusoid, amplitude: 1, frequency: 2}\n",
}
SUFFIXES = sorted(GOOD)


def good(name: str) -> bytes:
    content = GOOD[name]
    return content if isinstance(content, bytes) else content.encode()


def check_sentence(message: str, longest: int) -> None:
    assert re.search(r"[.!?]$", message), message
    assert len(message) < longest


def read(path) -> None:
    """Read what may be anything; a refusal is a sentence."""
    try:
        if path.suffix == ".yaml":
            read_coefficients(path)
        else:
            load(path, rate_hz=100.0)
    except (RecordingError, CoefficientsError) as error:
        check_sentence(str(error), 2000)


@pytest.mark.parametrize("name", SUFFIXES)
@DRAWN
@given(content=st.binary(max_size=600))
def test_any_bytes(name, content, tmp_path):
    path = tmp_path / name
    path.write_bytes(content)
    read(path)


@pytest.mark.parametrize("name", SUFFIXES)
@DRAWN
@given(data=st.data())
def test_good_files_with_a_piece_put_in_cut_out_or_doubled(name, data, tmp_path):
    content = good(name)
    at = data.draw(st.integers(0, len(content)))
    to = data.draw(st.integers(at, min(len(content), at + 40)))
    piece = data.draw(st.one_of(st.binary(max_size=8), st.text('0123456789,;.-+eE#"\n\t[](){}')))
    middle = piece if isinstance(piece, bytes) else piece.encode()
    path = tmp_path / name
    path.write_bytes(content[:at] + middle * data.draw(st.integers(1, 3)) + content[to:])
    read(path)


@DRAWN
@given(name=st.text(max_size=60))
def test_any_unit(name):
    try:
        unit = parse_unit(name)
    except RecordingError as error:
        check_sentence(str(error), 400)
    else:
        assert np.isfinite(unit.factor)
        assert unit.factor > 0


@DRAWN
@given(
    separator=st.sampled_from([",", ";", "\t", " "]),
    point=st.sampled_from([".", ","]),
    end=st.sampled_from(["\n", "\r\n", "\r"]),
    mark=st.sampled_from([b"", b"\xef\xbb\xbf"]),
    quoted=st.booleans(),
    header=st.sampled_from(["", "named", "units", "comment"]),
    padding=st.sampled_from(["", " ", "  "]),
    last=st.booleans(),
    form=st.sampled_from(["r", ".6f", ".9e", "+.7g"]),
    blank=st.booleans(),
    seed=st.integers(0, 2**16),
)
def test_tables_written_in_odd_ways_give_the_same_numbers(
    separator, point, end, mark, quoted, header, padding, last, form, blank, seed, tmp_path
):
    # Decimal commas need another separator that is no blank, and are refused without.
    if separator in ", ":
        point = "."
    quoted = quoted and separator != " "
    values = np.random.default_rng(seed).standard_normal((300, 2)).round(6)
    names = {"named": ["gyro_x", "gyro_y"], "units": ["a [deg/s]", "b [deg/s]"]}.get(header)

    def number(value: float) -> str:
        text = repr(float(value)) if form == "r" else format(value, form)
        return f'"{text.replace(".", point)}"' if quoted else text.replace(".", point)

    space = "" if quoted else padding
    rows = [(space + separator + space).join(map(number, row)) for row in values]
    if names:
        rows.insert(0, separator.join(names))
    if header == "comment":
        rows.insert(0, "# made by hand")
    if blank:
        rows.insert(100, "")
    path = tmp_path / "a.csv"
    path.write_bytes(mark + (end.join(rows) + (end if last else "")).encode())
    found = load(path, rate_hz=100.0)
    read_back = np.stack([each.samples / each.factor for each in found.channels], axis=1)
    np.testing.assert_allclose(read_back, values, rtol=0, atol=1.1e-6)
