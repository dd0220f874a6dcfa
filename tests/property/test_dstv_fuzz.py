"""Damaged files: the reader never raises, and no line gets lost."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.errors import Severity
from beamcam.model.part import Contour, EndPlane
from beamcam.readers.dstv import looks_like, read_with_account
from beamcam.readers.dstv.blocks import CODES, decode, split_lines
from tests.conftest import SAMPLES, examples

PATHS = sorted([*(SAMPLES / "dstv").glob("*.nc1"), *(SAMPLES / "bad" / "dstv").glob("*.nc1")])
FILES = [path.read_bytes() for path in PATHS]

SETTINGS = settings(max_examples=examples(500), deadline=None)
files = st.sampled_from(FILES)
places = st.floats(0, 1, exclude_max=True)


def assert_accounted_for(data: bytes) -> None:
    """Read `data` and see that each of its data lines is in the part or in a diagnostic."""
    looks_like(data)
    reading, account = read_with_account(data, "damaged.nc1")
    assert account.lost == []
    if not reading.parts:
        assert reading.refused
    # by a count of our own: what is neither a code nor a comment nor blank is data
    lines = [line.strip() for line in split_lines(decode(data)[0])]
    data_lines = {
        i
        for i, line in enumerate(lines, 1)
        if line and not line.startswith("**") and line.upper() not in CODES
    }
    assert data_lines <= {*account.taken, *account.reported}
    errors = [d for d in reading.diagnostics if d.severity is Severity.ERROR]
    assert all(d.source.line and d.source.line <= max(len(lines), 1) for d in errors)
    for part in reading.parts:
        for feature in part.features:
            if isinstance(feature, EndPlane | Contour):
                continue  # of several rows
            assert feature.source.line in account.taken


@SETTINGS
@given(files, st.lists(st.tuples(places, st.integers(0, 255)), min_size=1, max_size=8))
def test_bytes_changed(data, changes):
    damaged = bytearray(data)
    for place, value in changes:
        damaged[int(place * len(damaged))] = value
    assert_accounted_for(bytes(damaged))


@SETTINGS
@given(files, st.lists(places, min_size=1, max_size=5))
def test_lines_dropped(data, drops):
    lines = data.split(b"\n")
    for place in drops:
        if lines:
            del lines[int(place * len(lines))]
    assert_accounted_for(b"\n".join(lines))


@SETTINGS
@given(files, st.lists(st.tuples(places, places), min_size=1, max_size=5))
def test_lines_doubled_elsewhere(data, copies):
    lines = data.split(b"\n")
    for source, target in copies:
        lines.insert(int(target * len(lines)), lines[int(source * len(lines))])
    assert_accounted_for(b"\n".join(lines))


@SETTINGS
@given(files, places, st.sampled_from([b"", b"\r\n", b"\x1a", b"\x00", b"\nEN\n"]))
def test_cut_off(data, place, end):
    assert_accounted_for(data[: int(place * len(data))] + end)


@settings(max_examples=examples(100), deadline=None)
@given(st.binary(max_size=200))
def test_any_bytes(data):
    assert_accounted_for(data)


@settings(max_examples=examples(100), deadline=None)
@given(files, st.text("vouhstwgml+-.,0123456789eE_ nainf*:\t", max_size=60), st.integers(24, 40))
def test_a_row_of_any_signs(data, row, place):
    lines = data.split(b"\n")
    lines.insert(place, b"  " + row.encode())
    assert_accounted_for(b"\n".join(lines))


@pytest.mark.parametrize("count", [2000])
def test_thousands_of_blocks_and_comments(count):
    """Nothing in the reader recurses by the number of blocks, contours, planes or comments."""
    head = FILES[PATHS.index(SAMPLES / "dstv" / "plate.nc1")].split(b"AK\n")[0]
    square = b"  v 10.0 10.0\n 20.0 10.0\n 20.0 20.0\n 10.0 10.0\n"
    for block in (b"IK\n" + square, b"E1\n 0 0 0\n 100 0 0\n 0 100 0\n", b"** x\nSI\n"):
        assert_accounted_for(head + block * count + b"EN\n")
    rows = b"".join(
        b"  v %d.0 10.0\n %d.5 10.0\n %d.5 20.0\n %d.0 10.0\n" % ((i,) * 4) for i in range(count)
    )
    assert_accounted_for(head + b"IK\n" + rows + b"EN\n")
