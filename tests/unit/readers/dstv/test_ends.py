"""Header and contour that describe different ends: refused, or settled by --ends."""

from itertools import pairwise
from pathlib import Path

from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

import beamcam
from beamcam.errors import Severity, Source
from beamcam.geometry.curves import Line
from beamcam.model.description import end_lines
from beamcam.model.part import Contour, EndCuts, Part, Profile
from beamcam.readers.dstv import read
from beamcam.solid.part_solid import part_solid
from beamcam.writers.dstv import write
from tests.runs import batch, call, counts

S = Source("p.nc1", 1)
IPE = Profile("I", "IPE200", 200.0, 100.0, 8.5, 5.6, 0.0)


def drawn(cuts: EndCuts) -> Part:
    """A beam whose outlines of v, o and u are as these cuts leave them."""
    bare = Part("P1", IPE, 1000.0, S, grade="S235JR", cuts=cuts)
    outlines = []
    for face in "vou":
        (a, d), (b, c) = end_lines(bare, face)
        ring = [(round(x, 3), y) for x, y in (a, b, c, d, a)]
        sides = tuple(Line(p, q) for p, q in pairwise(ring))
        outlines.append(Contour(face, "outer", sides, S))
    return replace(bare, features=tuple(outlines))


def text(header: EndCuts, contour: EndCuts) -> bytes:
    """A file with this header over outlines of those cuts."""
    return write(replace(drawn(contour), cuts=header)).encode()


angles = st.sampled_from([-35.0, 0.0, 20.0, 45.0])


@given(angles, angles, angles, angles)
def test_what_counts_is_the_part_of_a_file_that_agrees(
    a: float, b: float, c: float, d: float
) -> None:
    """Cuts of the web by a and b, one end in the header and one in the outlines; of flanges too."""
    for is_web in (True, False):
        header, contour = (
            EndCuts(*pair) if is_web else EndCuts(0, 0, *pair) for pair in ((a, b), (c, d))
        )
        denied = [h for h, o in zip((a, b), (c, d), strict=True) if h and h != o]
        data = text(header, contour)
        codes = [x.code for x in read(data, "p.nc1").diagnostics if x.severity is Severity.ERROR]
        assert codes == ["dstv-cut-angle"] * len(denied)
        by_contour, by_header = (read(data, "p.nc1", ends=e) for e in ("contour", "header"))
        for reading in (by_contour, by_header):
            assert not reading.refused
            told = [x.code for x in reading.diagnostics].count("dstv-cut-settled")
            assert told == len(denied)
            assert reading.parts[0].ends_by == (
                "" if not denied else "contour" if reading is by_contour else "header"
            )
        # A header of 0 says nothing: what is drawn counts.
        meant = [h or o for h, o in zip((a, b), (c, d), strict=True)]
        of_header = EndCuts(*meant) if is_web else EndCuts(0, 0, *meant)
        for reading, cuts in ((by_contour, contour), (by_header, of_header)):
            found = part_solid(replace(reading.parts[0], cuts=cuts))
            wanted = part_solid(drawn(cuts))
            assert (found - wanted).volume() + (wanted - found).volume() < 50.0


def test_a_side_that_cannot_be_moved_leaves_the_file_refused() -> None:
    part = drawn(EndCuts())
    ring = [(0.0, 0.0), (1000.0, 0.0), (1000.0, 200.0), (500.0, 200.0), (480.0, 150.0),
            (0.0, 200.0), (0.0, 0.0)]  # fmt: skip
    leaning = Contour("v", "outer", tuple(Line(p, q) for p, q in pairwise(ring)), S)
    part = replace(part, cuts=EndCuts(web_start=20.0), features=(leaning,))
    assert read(write(part).encode(), "p.nc1", ends="header").refused
    assert not read(write(part).encode(), "p.nc1", ends="contour").refused


def test_the_option_the_configuration_and_the_head(tmp_path: Path) -> None:
    """The saw turns by what counts, and the head says it; so in a batch, a list and Python."""
    part, out = tmp_path / "p.nc1", tmp_path / "p.gcode"
    part.write_bytes(text(EndCuts(web_end=20.0), EndCuts(web_end=35.0)))
    post = ("post", part, "--machine", "beamline", "-o", out)
    refused = call(*post, status=1).stderr
    assert "or --ends contour or --ends header, which says what counts" in refused
    assert "note read-ways-out" in refused
    made = {}
    for ends in ("contour", "header"):
        said = call(*post, "--ends", ends, status=0).stderr
        assert f"the {ends} counts, as --ends says" in said
        made[ends] = out.read_text()
        assert f"ENDS BY THE {ends.upper()} OF THE FILE" in made[ends]
        assert call("verify", out, "--against", part, "--ends", ends).exit_code == 0
        parts = beamcam.read(part, ends=ends).parts  # type: ignore[arg-type]
        assert beamcam.post(parts, "beamline").text == made[ends]
    assert made["contour"] != made["header"]
    assert call("verify", out, "--against", part, "--ends", "contour").exit_code == 1
    own = tmp_path / "own.toml"
    own.write_text('ends = "contour"\n')
    call(*post, "--config", own, status=0)
    assert out.read_text() == made["contour"]
    asked = ("--machine", "beamline", "--config", own, "--ends", "header")
    done = batch(part, "-o", tmp_path / "out", *asked)
    assert counts(done)[0] == 1
    assert (tmp_path / "out" / "p.gcode").read_text() == made["header"]
    listed = call("list", part, "-o", tmp_path / "list.csv", *asked, status=0).stderr
    assert "dstv-cut-settled" in listed
    converted = tmp_path / "again.nc1"
    call("convert", part, "-o", converted, "--ends", "header", status=0)
    assert not read(converted.read_bytes(), "again.nc1").refused
