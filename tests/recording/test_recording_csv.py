"""Text tables as loggers, spreadsheets and NumPy write them, and what cannot be read as one."""

import gzip

import numpy as np
import pytest

from allanfit.recording import RecordingError, load, read_in_blocks

NAMES = ("gyro_x", "gyro_y", "gyro_z")
HEADER = ",".join(f"{name} [deg/s]" for name in NAMES)


def lines(noise: np.ndarray, separator: str = ",", decimal: str = ".") -> str:
    return "".join(
        separator.join(str(value).replace(".", decimal) for value in row) + "\n" for row in noise
    )


def check(path, noise, *, unit="deg/s", names=NAMES) -> None:
    """The file holds `noise`, whatever its dress, and nothing is found wrong with it."""
    recording = load(path, rate_hz=100.0)
    assert tuple(channel.name for channel in recording.channels) == names
    assert recording.findings == ()
    for channel, expected in zip(recording.channels, noise.T, strict=True):
        assert channel.unit == unit
        assert channel.findings == ()
        assert channel.stretches == ((0, len(noise)),)
        np.testing.assert_allclose(channel.samples, expected * np.pi / 180, rtol=1e-14)


def dressed(noise: np.ndarray) -> dict[str, str | bytes]:
    """The same table in every dress that is read."""
    plain = f"{HEADER}\n{lines(noise)}"
    bare = HEADER.replace(",", "  ")
    return {
        "plain.csv": plain,
        "windows.csv": plain.replace("\n", "\r\n"),
        "old_mac.csv": plain.replace("\n", "\r"),
        "byte_order_mark.csv": "\ufeff" + plain,
        "powershell.csv": plain.replace("\n", "\r\n").encode("utf-16"),
        "unicode_text.txt": ("\ufeff" + plain.replace(",", "\t")).encode("utf-16-be"),
        "wide.csv.gz": gzip.compress(plain.encode("utf-16")),
        "capital.CSV": plain,
        "parentheses.csv": plain.replace("[", "(").replace("]", ")"),
        "no_blank.csv": plain.replace(" [", "["),
        "semicolons.csv": f"{HEADER.replace(',', ';')}\n{lines(noise, ';')}",
        "decimal_commas.csv": f"{HEADER.replace(',', ';')}\n{lines(noise, ';', ',')}",
        "tabs.txt": HEADER.replace(",", "\t") + "\n" + lines(noise, "\t"),
        "tabs.tsv": HEADER.replace(",", "\t") + "\n" + lines(noise, "\t"),
        "tabs_decimal_commas.txt": HEADER.replace(",", "\t") + "\n" + lines(noise, "\t", ","),
        "blanks.txt": f"{bare}\n{lines(noise, '   ')}",
        "indented.txt": f"  {bare}\n" + lines(noise, "  ").replace("\n", "\n   ").rstrip(" "),
        "quoted.csv": '"'
        + HEADER.replace(",", '","')
        + '"\n'
        + lines(noise, '","').replace("\n", '"\n"').rstrip('"').join(['"', ""]),
        "padded.csv": f"{HEADER}\n{lines(noise, '  , ')}",
        "comments.csv": f"# made today\n# at rest\n{plain}# the end\n",
        "percent_signs.csv": f"% made today\n{plain}  % at rest, warm\n{lines(noise)}% end\n",
        "percent_signs.txt": f"% {bare}\n{lines(noise, ' ')}% at rest\n{lines(noise, '  ')}",
        "commented_header.txt": f"# {bare}\n{lines(noise, ' ')}",
        "separator_at_end.csv": plain.replace("\n", ",\n"),
        "separator_below_header.csv": f"{HEADER}\n" + lines(noise).replace("\n", ",\n"),
        "blank_lines.csv": plain.replace("\n", "\n\n"),
        "no_last_newline.csv": plain.rstrip(),
        "zipped.csv.gz": gzip.compress(plain.encode()),
        "ZIPPED.CSV.GZ": gzip.compress(plain.encode()),
        "zipped.txt.gz": gzip.compress(plain.encode()),
    }


@pytest.mark.parametrize("name", list(dressed(np.zeros((1, 3)))))
def test_every_dress_of_a_table(name, write, noise):
    check(write(name, dressed(noise)[name]), np.tile(noise, (1 + name.startswith("percent"), 1)))


UNITS = "[deg/s],[deg/s],[deg/s]\n"


@pytest.mark.parametrize(
    ("above", "skipped"),
    [
        (f"Still test of unit 7\n{HEADER}\n", "1 line, the first 'Still test of unit 7'"),
        (f"Test, of 3 units; loud\n{HEADER}\n", "1 line, the first 'Test of 3 units; loud'"),
        (f"Operator,JM,\nRate,100,\n,,\n{HEADER}\n", "2 lines, the first 'Operator JM'"),
        (f"{','.join(NAMES)}\n{UNITS}", None),
        (f"{UNITS}{','.join(NAMES)}\n", None),
        (f"{HEADER}\n-,,°/s\n", None),
        (f"Unit 7,,\n{','.join(NAMES)}\n{UNITS.replace('[', '').replace(']', '')}", "1 line"),
        (f"Date,2026-11-22,\n# noted\n{HEADER}\n", "1 line, the first 'Date 2026-11-22'"),
    ],
)
def test_titles_and_units_about_the_header(above, skipped, write, noise):
    path = write("lab.csv", above + lines(noise))
    recording = load(path, rate_hz=100.0)
    assert [channel.name for channel in recording.channels] == list(NAMES)
    assert [channel.unit for channel in recording.channels] == ["deg/s"] * 3
    for channel, expected in zip(recording.channels, noise.T, strict=True):
        np.testing.assert_allclose(channel.samples, expected * np.pi / 180, rtol=1e-14)
    told = "".join(recording.findings)
    assert told.startswith(f"Skipped above the header: {skipped}" if skipped else "")
    assert len(recording.findings) == (skipped is not None)
    assert read_in_blocks(path, rate_hz=100.0).findings == recording.findings


def test_decimal_commas_in_titles_are_none_of_the_table(write, noise):
    text = f"Range;2,5\n{HEADER.replace(',', ';')}\n{lines(noise, ';')}"
    recording = load(write("lab.csv", text), rate_hz=100.0)
    np.testing.assert_allclose(recording.channels[2].samples, noise[:, 2] * np.pi / 180, rtol=1e-14)


def test_whole_numbers_beside_decimals_are_no_thousands(write):
    """Three decimals with zeros left away, as `%g` prints them."""
    values = np.random.default_rng(2).integers(-9000, 9000, 2000) / 1000
    text = "gyro_x [deg/s]\n" + "".join(f"{value:g}\n" for value in values)
    recording = load(write("short.csv", text), rate_hz=100.0)
    np.testing.assert_allclose(recording.channels[0].samples, values * np.pi / 180, rtol=1e-14)


def test_degree_sign_in_latin_1(write, noise):
    text = f"{HEADER}\n{lines(noise)}".replace("deg", "°").encode("latin-1")
    check(write("sign.csv", text), noise, unit="°/s")


def test_without_a_header_channels_are_numbered(write, noise):
    recording = load(write("bare.csv", lines(noise)), rate_hz=100.0, unit="deg/s")
    assert [channel.name for channel in recording.channels] == [
        "channel_1",
        "channel_2",
        "channel_3",
    ]
    assert recording.channels[0].samples.size == 400
    single = load(write("single.txt", lines(noise[:, :1])), rate_hz=100.0, unit="deg/s")
    assert single.channels[0].name == "data"


def test_a_single_column_with_a_unit(write, noise):
    path = write("single.csv", "gyro_x [deg/s]\n" + lines(noise[:, :1]))
    check(path, noise[:, :1], names=("gyro_x",))


def test_missing_values_are_not_numbers_and_said(write, noise):
    text = f"{HEADER}\n{lines(noise)}nan,NA,1.0\n,inf,2.0\n{lines(noise)}"
    recording = load(write("holes.csv", text), rate_hz=100.0)
    x, y, z = recording.channels
    assert x.stretches == y.stretches == ((0, 400), (402, 802))
    assert x.findings == (
        "Left out as missing or not finite: 2 samples (0.02 s); the longest stretch between has "
        "4 s.",
    )
    assert (z.stretches, z.findings) == (((0, 802),), ())


@pytest.mark.parametrize("columns", [1, 3])
def test_a_value_that_a_spreadsheet_lacks_begins_no_comment(columns, write, noise):
    table = noise[:, :columns]
    gap = ",".join(["#N/A"] * columns)
    text = f"{lines(table)}{gap}\n{gap}\n# a note\n{lines(table)}"
    path = write("spreadsheet.csv", text)
    assert all(
        channel.stretches == ((0, 400), (402, 802))
        for channel in load(path, rate_hz=100.0, unit="deg/s").channels
    )


def test_a_last_line_cut_short_is_missing_values(write, noise):
    recording = load(write("cut.csv", f"{HEADER}\n{lines(noise)}0.5,0"), rate_hz=100.0)
    assert recording.channels[2].stretches == ((0, 400),)
    assert recording.findings == (
        "The last line has 2 fields of 3: the file was cut off there, and what is missing is left "
        "out.",
    )
    assert "missing or not finite: 1 sample (" in recording.channels[2].findings[0]


def test_a_column_of_words_is_left_out_and_said(write, noise):
    text = f"{HEADER},status\n" + lines(noise).replace("\n", ",OK\n")
    recording = load(write("words.csv", text), rate_hz=100.0)
    assert len(recording.channels) == 3
    assert recording.findings == ("The column status holds text and is left out.",)


def test_a_column_without_any_value_is_left_out_and_said(write, noise):
    text = f"{HEADER},spare\n" + lines(noise).replace("\n", ",\n")
    recording = load(write("spare.csv", text), rate_hz=100.0)
    assert len(recording.channels) == 3
    assert recording.findings[-1].startswith("The channel spare is left out: it has 0 usable")


def test_a_nameless_index_column_is_left_out_and_said(write, noise):
    rows = [f"{k},{line}" for k, line in enumerate(lines(noise).splitlines())]
    recording = load(write("index.csv", f",{HEADER}\n" + "\n".join(rows)), rate_hz=100.0)
    assert [channel.name for channel in recording.channels] == list(NAMES)
    assert recording.findings[-1] == (
        "The channel channel_1 is left out: it changes the same way at every sample, as a counter "
        "or time stamps do, or an angle or a velocity that was summed up."
    )


@pytest.mark.parametrize(
    ("file", "step", "found"),
    [
        ("clock.csv", "0.01", True),
        ("clock.txt", "0.01", True),
        ("clock.csv", "10", True),  # in ms
        ("note.csv", "0.01", True),  # below a comment that names no columns
        ("thirds.csv", "0.0033333", True),
        ("counter.csv", "1", False),
        ("huge.csv", "1e307", False),
        ("none.csv", "nan", False),
        ("alone.csv", None, False),
    ],
)
def test_a_first_column_without_a_name_that_rises_evenly_is_a_clock(
    file, step, found, write, noise
):
    mark = "," if file.endswith(".csv") else " "
    rows = zip(lines(noise, mark).splitlines(), range(len(noise)), strict=True)
    before = (lambda _: "") if step is None else lambda k: f"{k * float(step):.6g}{mark}"
    note = "# at rest\n" if file == "note.csv" else ""
    path = write(file, note + "".join(f"{before(k)}{row}\n" for row, k in rows))
    if not found:
        with pytest.raises(RecordingError, match="tells no sampling rate"):
            load(path)
        return
    recording = load(path, unit="deg/s")
    assert recording.rate_hz == pytest.approx(100 if float(step) != 0.0033333 else 300, rel=1e-4)
    assert [each.name for each in recording.channels] == ["channel_2", "channel_3", "channel_4"]
    told = "The first column has no name and rises evenly: it is taken for time stamps."
    assert told in recording.findings
    assert told in read_in_blocks(path, unit="deg/s").findings


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "bad.csv is empty"),
        ("\n \n", "bad.csv is empty"),
        (HEADER, "holds no table of numbers"),
        ("# only\n# comments\n", "holds no table of numbers"),
        ("<html>\n<p>not found</p>\n</html>\n", "holds no table of numbers"),
        ("word " * 50_000, "has lines of more than 64 kB: write one sample"),
        (bytes(range(256)) * 20, "is not plain text: a spreadsheet has to be saved as CSV"),
        (f"{HEADER}\n1,2,3\n".encode("utf-16-le"), "is not plain text"),
        (
            f"{HEADER}\n1,2,3\n4,5,6\n7".encode() + b"\0" * 512 + b",8\n",
            "behind the line '4,5,6' it is damaged, and holds bytes of zero",
        ),
        (f"1,2,3\n{HEADER}\n1,2\n3,4\n", "2 lines stand above the numbers, the first '1 2 3', and"),
        (f"{HEADER}\nw,w,w\n1,2,3\n", "two columns named w: rename one"),
        ("Logger v3\n1,2,3\n", "line 1: 'Logger v3' has 1 fields and the numbers below it 3"),
        ("x,y\n0,5,0,6\n", r"for decimal commas, put semicolons between the columns"),
        ("x y\n0,5 0,6\n", "line 2: '0,5 0,6' mixes commas and blanks: write decimal points"),
        ("1.0,2.0,OK\n1.0,2.0,OK\n", "line 1: .* mixes numbers and text: give the file a header"),
        ("gyro_x,gyro_x\n1,2\n", "two columns named gyro_x: rename one"),
        ("x,y\n1,2\n1,abc\n1,2\n", "line 3, column y: 'abc' is not a number"),
        ("x;y\n1,5;2,5\n1,5;abc\n", "line 3, column y: 'abc' is not a number"),
        ("x,y\nbad,1\n" + "1,2\n" * 9, "line 2, column x: 'bad' is not a number"),
        ("x,y\n1,2\n1,2,3\n", "line 3 has 3 fields, and the first line of numbers has 2"),
        ('x,y\n1,2\n"1,2\n', "not closed|not a number"),
    ],
)
def test_what_is_no_table_says_where_and_what_to_do(text, message, write):
    with pytest.raises(RecordingError, match=message):
        load(write("bad.csv", text), rate_hz=100.0)


@pytest.mark.parametrize("between", ["\n", "\n\n", "# note\n", "  # note\n\n"])
@pytest.mark.parametrize(
    ("bad", "message"),
    [
        ("1,abc", "column y: 'abc' is not a number"),
        ("1,2,3", "has 3 fields"),
        ("1", "has 1 field"),
    ],
)
def test_lines_are_counted_with_blank_ones_and_comments(between, bad, message, write, noise):
    # Of a length that makes several blocks, of which some begin with a blank line.
    rows = [f"{x},{y}\n{between}" for x, y in np.tile(noise[:, :2], (50, 1))]
    read = (load, lambda path, **kw: list(read_in_blocks(path, block_samples=1024, **kw)))
    for each in read:
        each(write("a.csv", "x,y\n" + "".join(rows)), rate_hz=100.0)
    above = "x,y\n" + "".join(rows[:15_000])
    path = write("a.csv", above + f"{bad}\n" + "".join(rows[15_000:]))
    for each in read:
        line = above.count("\n") + 1
        with pytest.raises(RecordingError, match=rf"a\.csv, line {line}\b.*{message}"):
            each(path, rate_hz=100.0)


@pytest.mark.parametrize("end", ["\n" * 9, "# end\n" * 9, "0.5\n" + "\n" * 9])
def test_lines_below_the_numbers(end, write, noise):
    path = write("a.csv", f"{HEADER}\n" + 50 * lines(noise) + end)
    found = read_in_blocks(path, rate_hz=100.0, block_samples=1024)
    list(found)
    said = [each for each in load(path, rate_hz=100.0).findings if "last line" in each]
    assert [each for each in found.findings if "last line" in each] == said
    assert len(said) == end.startswith("0.5")


@pytest.mark.parametrize("damage", [lambda data: data[:-200], lambda data: b"1,2\n" * 400])
def test_damaged_gzip(damage, write, noise):
    data = gzip.compress(f"{HEADER}\n{lines(noise)}".encode())
    with pytest.raises(RecordingError, match=r"bad\.csv\.gz is not a complete gzip file"):
        load(write("bad.csv.gz", damage(data)), rate_hz=100.0)


def test_units_behind_commas_between_semicolons(write):
    noise = np.random.default_rng(1).standard_normal(400)
    rows = "".join(f"{10 * k};{value:.5f}\n" for k, value in enumerate(noise))
    recording = load(write("a.csv", f"Time,ms;Gx, dps\n{rows}"))
    assert recording.rate_hz == pytest.approx(100)
    assert [(each.name, each.unit) for each in recording.channels] == [("Gx, dps", "deg/s")]
