"""Text, binary, damaged and foreign files."""

import re
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam import readers
from beamcam.readers import dxf
from beamcam.readers.dxf.load import looks_like
from tests.conftest import examples, rules_of
from tests.dxf_text import codes, curves_of, drawing, length_of, line, polyline, spline, tags
from tests.dxf_text import section as a_section

SAMPLES = Path(__file__).parents[4] / "samples"
GOOD = sorted((SAMPLES / "dxf").glob("*.dxf"))
BAD = sorted((SAMPLES / "bad" / "dxf").glob("*.dxf"))


@pytest.mark.parametrize("path", BAD, ids=lambda path: path.stem)
def test_each_bad_sample_is_refused_with_its_code(path: Path) -> None:
    reading = readers.read(path.read_bytes(), path.name)
    assert reading.refused
    assert path.stem in [d.code for d in reading.diagnostics]


def test_there_is_a_bad_sample_for_each_error() -> None:
    from beamcam.errors import Severity

    errors = {rule.code for rule in rules_of(dxf.rules) if rule.severity is Severity.ERROR}
    assert errors - {path.stem for path in BAD} == set()


@pytest.mark.parametrize("path", GOOD, ids=lambda path: path.stem)
def test_each_good_sample_is_read(path: Path) -> None:
    reading = readers.read(path.read_bytes(), path.name)
    assert (reading.format, reading.refused, len(reading.parts)) == ("dxf", False, 1)
    (part,) = reading.parts
    assert part.mark == path.stem
    assert (part.profile.code, part.profile.web_thickness) == ("B", None)
    assert all(c.face == "v" and c.source.where and c.colour for c in part.contours)


def test_the_binary_plate_is_the_plate() -> None:
    text, binary = (SAMPLES / "dxf" / name for name in ("plate.dxf", "plate-binary.dxf"))
    assert curves_of(text.read_bytes()) == curves_of(binary.read_bytes())


def test_what_looks_like_dxf() -> None:
    assert all(looks_like(path.read_bytes()) for path in GOOD)
    assert looks_like(b"999\nmade by me\n  0\r\nSECTION\r\n")
    assert not looks_like(b"ST\n  0\n")
    assert not looks_like(b"<svg/>")
    unnamed = readers.read(GOOD[0].read_bytes(), "drawing")
    assert unnamed.format == "dxf"


def test_entities_without_handles_are_named_by_number() -> None:
    two = "".join(tags((0, "LINE"), (8, "0"), (10, 0), (20, y), (11, 1), (21, y)) for y in (0, 1))
    (part,) = dxf.read(drawing(two, version="AC1009"), "a.dxf").parts
    assert [c.source.where for c in part.contours] == ["LINE 1", "LINE 2"]


def test_a_missing_eof_is_said_and_a_cut_file_refused() -> None:
    whole = drawing(line(0, 0, 10, 0))
    no_eof = whole[: whole.rindex(b"0\nEOF")]
    assert codes(no_eof) == ["dxf-no-eof", "dxf-recovered"]
    assert length_of(no_eof) == 10
    cut = whole[: whole.rindex(b"11\n10")]
    reading = dxf.read(cut, "a.dxf")
    assert [d.code for d in reading.diagnostics] == ["dxf-truncated"]
    assert reading.parts == ()
    binary = (SAMPLES / "dxf" / "plate-binary.dxf").read_bytes()
    assert codes(binary[:-200]) == ["dxf-truncated"]


def test_a_damaged_file_is_repaired_and_said() -> None:
    # A stray ENDSEC behind the entities, as a real writer leaves it.
    damaged = drawing(line(0, 0, 10, 0)).replace(
        b"0\nENDSEC\n0\nEOF", b"0\nENDSEC\n0\nENDSEC\n0\nEOF"
    )
    assert length_of(damaged) == 10
    assert codes(damaged) in ([], ["dxf-recovered"])
    no_y = a_section("ENTITIES", tags((0, "LINE"), (8, "0"), (10, 0), (11, 5), (21, 0)))
    reading = dxf.read((no_y + tags((0, "EOF"))).encode(), "a.dxf")
    assert "dxf-recovered" in [d.code for d in reading.diagnostics]


def test_an_empty_model_space_is_refused() -> None:
    assert codes(drawing("")) == ["drawing-empty"]


def test_texts_in_old_code_pages_do_no_harm() -> None:
    data = drawing(line(0, 0, 10, 0, layer="Ätz"), version="AC1009")
    for encoding in ("cp1252", "utf-8"):
        assert length_of(data.decode().encode(encoding)) == 10


def test_nothing_is_printed(capfd: pytest.CaptureFixture[str]) -> None:
    import logging

    root = logging.getLogger()
    held, root.handlers = root.handlers, []  # the test runner's own
    try:
        dxf.read(drawing(line(0, 0, 1, 0) + line(0, 0, 0, 1)), "a.dxf")  # one handle for two
    finally:
        root.handlers = held
    assert capfd.readouterr() == ("", "")


def test_options_reach_the_readers_that_take_them() -> None:
    data = drawing(line(0, 0, 10, 0))
    assert readers.read(data, "a.dxf", units="in", width=None).parts[0].length == 254
    assert readers.read(data, "a.dxf", width=3, layers=None).parts[0].length == 10
    plate = (SAMPLES / "dstv" / "plate.nc1").read_bytes()
    assert not readers.read(plate, "plate.nc1", units="in").refused


places = st.tuples(*[st.integers(-900, 900).map(lambda n: n / 8)] * 2)


@settings(max_examples=examples(40), deadline=None)
@given(
    rows=st.lists(
        st.tuples(places, st.sampled_from([0.0, 0.5, -1.0])),
        min_size=2,
        max_size=6,
        unique_by=lambda row: row[0],
    ),
    closed=st.booleans(),
    control=st.lists(places, min_size=4, max_size=6, unique=True),
    version=st.sampled_from(["AC1009", "AC1015", "AC1027"]),
    ends=st.sampled_from(["\n", "\r\n"]),
)
def test_polylines_and_splines_without_subclass_markers_are_read(
    rows: list[tuple[tuple[float, float], float]],
    closed: bool,
    control: list[tuple[float, float]],
    version: str,
    ends: str,
) -> None:
    """As if the markers were there, and told; those of other entities stay."""
    n = len(control)
    knots = [0.0] * 4 + [float(k) for k in range(1, n - 3)] + [n - 3.0] * 4
    shapes = polyline([(x, y, bulge) for (x, y), bulge in rows], closed) + spline(control, knots)
    bare = re.sub(r"100\nAcDb\w+\n", "", shapes).replace("8\n0\n", "8\nCUT\n62\n1\n")
    marked = shapes.replace("8\n0\n", "8\nCUT\n62\n1\n")
    other = line(-500, -500, -400, -500)
    whole, without = (drawing(other + some, version=version) for some in (marked, bare))
    without = without.replace(b"\n", ends.encode())
    assert curves_of(without) == curves_of(whole)
    assert sorted(codes(without)) == sorted([*codes(whole), "dxf-subclasses"])
    (part,) = dxf.read(without, "a.dxf").parts
    assert {(c.layer, c.colour) for c in part.contours} == {("0", "#ffffff"), ("CUT", "#ff0000")}


def test_brackets_of_an_entity_without_markers_stay_together() -> None:
    reactors = ((102, "{ACAD_REACTORS"), (330, "1F"), (102, "}"), (330, "2"))
    bare = tags((0, "LWPOLYLINE"), (5, "A"), *reactors, (8, "0"), (90, 2), (70, 0),
                (10, 0), (20, 0), (10, 5), (20, 0))  # fmt: skip
    assert length_of(drawing(bare)) == 5
    assert codes(drawing(bare)) == ["dxf-subclasses"]
