"""Drawings of the unrolled surface of a round tube, read as that tube with --wrap."""

from math import pi
from pathlib import Path

import pytest

import beamcam
from beamcam.checks.coping import verify_coping
from beamcam.errors import errors_in
from beamcam.machine import load
from beamcam.model.part import Contour, Part
from beamcam.model.request import Request
from beamcam.pipeline import post
from beamcam.readers import Reading, read
from beamcam.readers.drawing import WRAP_NAME, WRAP_WIDE, tube_of
from beamcam.solid.opinion import solid_faults
from tests.conftest import SAMPLES
from tests.runs import call

SADDLE = SAMPLES / "dxf" / "saddle.dxf"
TUBE = load("tube-linuxcnc")
TURN = pi * 100.0


def svg(*paths: str, size: str = "600") -> bytes:
    lines = "".join(f'<path d="{path}" fill="none" stroke="black"/>' for path in paths)
    box = f'width="{size}mm" height="{size}mm" viewBox="0 0 {size} {size}"'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {box}>{lines}</svg>'.encode()


def wrapped(data: bytes, tube: str = "RO100x4", name: str = "t.svg") -> Reading:
    return read(data, name, wrap=tube)


def box(part: Part, kind: str) -> tuple[float, ...]:
    """The box of the contour of a kind."""
    (found,) = [f for f in part.features if isinstance(f, Contour) and f.kind == kind]
    boxes = [c.bbox for c in found.curves]
    return (
        *(min(b[k] for b in boxes) for k in (0, 1)),
        *(max(b[k] for b in boxes) for k in (2, 3)),
    )


#: An outline 400 long, and a triangle near its lower left corner; an SVG's y goes down.
UPRIGHT = (f"M20 500 h400 v-{TURN} h-400 z", "M50 480 h30 v-40 z")
#: The same seen with the paper turned: x goes down the page.
LYING = (f"M20 20 v400 h{TURN} v-400 z", "M40 50 v30 h40 z")


def test_an_outline_as_wide_as_the_tube_is_round_is_its_surface() -> None:
    reading = wrapped(svg(*UPRIGHT))
    (part,) = reading.parts
    assert [d.code for d in reading.diagnostics] == ["drawing-wrapped"]
    size = part.profile
    assert (size.code, size.name, size.height, size.flange_thickness) == (
        "RO", "CHS100*4", 100.0, 4.0
    )  # fmt: skip
    assert part.length == pytest.approx(400.0)
    assert box(part, "outer") == pytest.approx((0.0, 0.0, 400.0, TURN))
    assert box(part, "inner") == pytest.approx((30.0, 20.0, 60.0, 60.0))


def test_one_that_lies_across_is_turned_and_no_mirror_image() -> None:
    """The paper turned counter-clockwise makes of the one the other, so clockwise it is again."""
    reading = wrapped(svg(*LYING))
    (part,) = reading.parts
    assert "turned clockwise by 90 degrees" in reading.diagnostics[0].message
    assert part.length == pytest.approx(400.0)
    x0, u0, x1, u1 = box(part, "inner")
    assert (x1 - x0, u1 - u0) == pytest.approx((30.0, 40.0))
    (triangle,) = [f for f in part.features if isinstance(f, Contour) and f.kind == "inner"]
    ends = [curve.start for curve in triangle.curves]
    area = sum(
        a[0] * b[1] - b[0] * a[1] for a, b in zip(ends, [*ends[1:], ends[0]], strict=True)
    )  # fmt: skip
    (drawn,) = read(svg(*LYING), "t.svg").parts
    other = next(f for f in drawn.contours if len(f.curves) == 3)
    ends = [curve.start for curve in other.curves]
    assert area == pytest.approx(
        sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(ends, [*ends[1:], ends[0]], strict=True))
    )


def test_the_sample_is_posted_read_back_and_is_its_solid() -> None:
    (part,) = beamcam.read(SADDLE, wrap="RO88.9x5").parts
    text = post((part,), TUBE).text
    assert not errors_in(verify_coping(text, (part,), TUBE))
    told = {d.code for d in solid_faults(text, Request((part,), TUBE))}
    assert told <= {"solid-rounded", "solid-square"}
    assert text.count("M3 ") == 4


@pytest.mark.parametrize("tube", ["RO101x4", "CHS90x4"])
def test_another_circumference_is_refused(tube: str) -> None:
    (said,) = wrapped(svg(*UPRIGHT), tube).diagnostics
    assert (said.code, said["found"]) == (WRAP_WIDE.code, "400.00 x 314.16")
    assert "expected one" in said.message


def test_no_closed_line_is_refused() -> None:
    (said,) = wrapped(svg("M0 0 h400")).diagnostics
    assert (said.code, said["found"]) == (WRAP_WIDE.code, "0.00 x 0.00")


def test_what_is_no_tube_is_refused(tmp_path: Path) -> None:
    for name in ("RO100", "100x50", "100x0", "IPE200", "RO100x4x2", ""):
        assert tube_of(name) is None, name
    for name in ("RO168.3x8", "chs 168.3X8", "168.3*8", "PIPE168.3x8.0"):
        found = tube_of(name)
        assert found is not None
        assert (found.height, found.flange_thickness) == (168.3, 8.0)
    (said,) = wrapped(svg(*UPRIGHT), "RO100").diagnostics
    assert said.code == WRAP_NAME.code
    done = call("inspect", SADDLE, "--wrap", "RO88.9")
    assert (done.exit_code, "expected diameter x wall" in done.stderr) == (2, True)


def test_other_formats_are_as_they_are() -> None:
    path = SAMPLES / "coping" / "brace.nc1"
    assert read(path.read_bytes(), "b.nc1", wrap="RO88.9x5") == read(path.read_bytes(), "b.nc1")
