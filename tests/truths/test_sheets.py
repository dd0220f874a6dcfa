"""Sheets: what LinuxCNC's interpreter does of a program, and what shapely leaves of the steel.

The plates are drawn here by hand, their programs posted and run by rs274; the kerf is swept along
its canonical moves by shapely. What falls out of the sheet has to be the plate.
"""

import re
from math import hypot
from pathlib import Path

import pytest
import shapely
from shapely.affinity import rotate, scale, translate
from shapely.geometry.base import BaseGeometry

from beamcam import readers
from beamcam.machine import Machine, load
from beamcam.machine.overlay import with_torch
from beamcam.pipeline import post
from tests.conftest import SAMPLES
from tests.rs274 import INI, interpreted, needs_rs274
from tests.swept_band import strokes_of

KERF = 1.5  #: of the plasma table on 6 mm
#: Without its line to mark, which takes a second spindle.
GUSSET = (SAMPLES / "dstv" / "gusset.nc1").read_text().partition("KO")[0] + "EN\n"


def disc(x: float, y: float, diameter: float) -> BaseGeometry:
    return shapely.Point(x, y).buffer(diameter / 2, quad_segs=64)


def gusset() -> BaseGeometry:
    """By its file: 260 x 180, a corner of radius 20, a slanted one, a square, two holes, a slot.

    The slot is 14 wide and begins at 220, 40; its other centre is 20 on at 30 degrees: 17.32, 10.
    """
    sharp = shapely.Polygon([(0, 0), (260, 0), (260, 80), (240, 100), (180, 180), (0, 180)])
    round_one = disc(240, 80, 40).intersection(shapely.box(240, 80, 260, 100))
    slot = shapely.LineString([(220, 40), (237.3205, 50)]).buffer(7, quad_segs=64)
    holes = [shapely.box(100, 60, 150, 110), disc(40, 40, 18), disc(40, 140, 18), slot]
    return shapely.union(sharp, round_one).difference(shapely.union_all(holes))


def posted(text: str, name: str, machine: Machine, path: Path) -> str:
    """The program of a file's parts, also at `path`."""
    program = post(readers.read(text.encode(), name).parts[:1], machine).text
    path.write_text(program)
    return program


def fallen(program: Path, kerf: float) -> list[BaseGeometry]:
    """What falls out of the sheet, the largest first."""
    strokes = strokes_of(program)
    band = shapely.union_all(shapely.buffer(strokes, kerf / 2, quad_segs=64))
    x0, y0, x1, y1 = band.bounds
    sheet = shapely.box(x0 - 50, y0 - 50, x1 + 50, y1 + 50)
    loose = [
        piece
        for piece in shapely.get_parts(shapely.difference(sheet, band)).tolist()
        if not piece.intersects(sheet.exterior)
    ]
    return sorted(loose, key=lambda piece: -piece.area)


def differs(made: BaseGeometry, wanted: BaseGeometry) -> float:
    """Area of what one has and the other has not, by the length of the edge: mm."""
    return float(shapely.symmetric_difference(made, wanted).area / wanted.length)


@needs_rs274
@pytest.mark.parametrize("by", ["offset", "machine"])
def test_what_falls_out_of_the_sheet(by: str, tmp_path: Path) -> None:
    """Either way of keeping off leaves the plate; the interpreter does G41.1 by itself."""
    path = tmp_path / "gusset.ngc"
    posted(GUSSET, "gusset.nc1", with_torch(load("plate-linuxcnc"), kerf_by=by), path)
    assert differs(fallen(path, KERF)[0], translate(gusset(), 10, 10)) < 0.01


@needs_rs274
def test_the_side_and_the_way_round(tmp_path: Path) -> None:
    """The hole of 18 at 40, 40 is cut about 50, 50 with a radius of 9 - 0.75, counter-clockwise.

    The outline goes 0.75 outside of 10 to 270 and 10 to 190, clockwise: the plate to the right.
    """
    path = tmp_path / "gusset.ngc"
    posted(GUSSET, "gusset.nc1", load("plate-linuxcnc"), path)
    said = interpreted(path, ini=INI)
    assert said.returncode == 0, said.stderr
    arcs = [
        [float(v) for v in found.split(",")]
        for found in re.findall(r"ARC_FEED\(([^)]*)\)", said.stdout)
    ]
    about = [a for a in arcs if hypot(a[2] - 50, a[3] - 50) < 0.001]
    assert len(about) >= 2
    for x, y, cx, cy, turns, *_ in about:
        assert hypot(x - cx, y - cy) == pytest.approx(8.25, abs=0.001)
        assert turns > 0
    outline = max(strokes_of(path), key=lambda s: s.length)
    assert outline.bounds[2:] == pytest.approx((270.75, 190.75), abs=0.001)
    ring = shapely.LinearRing(outline.coords)
    assert not ring.is_ccw


@needs_rs274
@pytest.mark.parametrize(("mirror", "turn"), [("x", 0), ("y", 0), ("none", 90), ("x", 30)])
def test_mirrored_and_turned(mirror: str, turn: float, tmp_path: Path) -> None:
    """Mirrored left for right or top for bottom first, then turned to the left; then laid at 10."""
    path = tmp_path / "gusset.ngc"
    table = with_torch(load("plate-linuxcnc"), mirror=mirror, rotate=float(turn))
    posted(GUSSET, "gusset.nc1", table, path)
    wanted = scale(gusset(), -1 if mirror == "x" else 1, -1 if mirror == "y" else 1, origin=(0, 0))
    wanted = rotate(wanted, turn, origin=(0, 0))
    x0, y0, *_ = wanted.bounds
    wanted = translate(wanted, 10 - x0, 10 - y0)
    assert differs(fallen(path, KERF)[0], wanted) < 0.01


@needs_rs274
def test_copies(tmp_path: Path) -> None:
    """Two along X and two along Y, 10 apart: 270 and 190 from one to the next."""
    path = tmp_path / "gusset.ngc"
    table = with_torch(load("plate-linuxcnc"), copies=(2, 2), spacing=10.0)
    posted(GUSSET, "gusset.nc1", table, path)
    plates = [piece for piece in fallen(path, KERF) if piece.area > 10000]
    wanted = [translate(gusset(), 10 + 270 * k, 10 + 190 * n) for k in (0, 1) for n in (0, 1)]
    assert len(plates) == 4
    for one in wanted:
        assert min(differs(plate, one) for plate in plates) < 0.01


def test_arcs_of_the_other_controller(tmp_path: Path) -> None:
    """CODESYS under G99: I and J count from the start; G02 clockwise, G03 counter-clockwise."""
    program = posted(GUSSET, "gusset.nc1", load("plate-codesys"), tmp_path / "g.gcode")
    assert "G99" in program
    at = (0.0, 0.0)
    hole = outline = 0
    for line in program.splitlines():
        words = {w[0]: float(w[1:]) for w in line.split() if re.fullmatch(r"[XYIJ]-?[\d.]+", w)}
        if "I" in words:
            centre = at[0] + words["I"], at[1] + words["J"]
            end = words["X"], words["Y"]
            assert hypot(*(a - b for a, b in zip(at, centre, strict=True))) == pytest.approx(
                hypot(*(a - b for a, b in zip(end, centre, strict=True))), abs=0.002
            )
            if hypot(centre[0] - 50, centre[1] - 50) < 0.002:
                assert "G03" in line
                hole += 1
            if hypot(centre[0] - 250, centre[1] - 90) < 0.002:
                # The corner of radius 20, 0.75 outside, from its upper end to the right.
                assert "G02" in line
                assert end == pytest.approx((270.75, 90), abs=0.002)
                outline += 1
        if "X" in words:
            at = words["X"], words["Y"]
    assert hole >= 2
    assert outline == 1


#: Machine, sample: a feed of the program, from the chart's mm/min: plasma on 6 mm 2300; 2100 / 60;
#: oxyfuel on 20 mm 430; a saw of 2500 / 60; drills of 22 on S355 of 90.43 / 60.
FEEDS = [
    ("plate-linuxcnc", "gusset", r"F2300\b"), ("plate-codesys", "gusset", r"F35\b"),
    ("plate-oxyfuel", "gusset", r"F620\b"), ("beamline", "beam", r"F41\.667\b"),
    ("beamline", "beam", r"F1\.507\b"), ("beamline", "beam", r"M03 K362\b"),
    ("beamline-pusher", "beam", r"F1\.333\b"),
]  # fmt: skip


@pytest.mark.parametrize(("machine", "sample", "word"), FEEDS)
def test_feeds_in_the_units_of_the_controller(machine: str, sample: str, word: str) -> None:
    text = (SAMPLES / "dstv" / f"{sample}.nc1").read_text()
    program = post(readers.read(text.encode(), f"{sample}.nc1").parts[:1], load(machine)).text
    assert re.search(word, program)


#: The shield of the laser: where each stretch ends and the steps to there, 0.01 mm each. 8 mm of
#: acrylic are cut at 240 mm/min, 4 mm/s; off, the head goes 80 mm/s.
SHIELD = [
    (5, 5, 0, 500, 500), (7, 8, 1, 200, 300), (7, 12, 1, 0, 400), (6, 13, 1, -100, 100),
    (4, 13, 1, -200, 0), (3, 12, 1, -100, -100), (3, 8, 1, 0, -400), (5, 5, 1, 200, -300),
    (0, 0, 0, -500, -500),
]  # fmt: skip


def shield(style: str) -> list[list[str]]:
    part = readers.read((SAMPLES / "json" / "shield-small.json").read_bytes(), "s.json").parts
    rows = post(part, load("laser-stepper"), style=style).text.splitlines()
    return [row.split(",") for row in rows if row[0] in "-0123456789"]


def test_the_velocities_of_the_laser() -> None:
    rows = [[float(n) for n in row] for row in shield(".csv")]
    assert [(r[0], r[1], r[4], r[5], r[6]) for r in rows] == SHIELD
    for row, (*_, on, dx, dy) in zip(rows, SHIELD, strict=True):
        way, speed = hypot(dx, dy), 4.0 if on else 80.0
        assert (row[2], row[3]) == pytest.approx((speed * dx / way, speed * dy / way), abs=1e-3)
        # 200 steps a turn of 2 mm: 100 steps a mm
        assert (row[7], row[8]) == pytest.approx((abs(row[2]) * 100, abs(row[3]) * 100), abs=0.01)


def test_the_steps_of_the_laser() -> None:
    """00 01 10 11 is forwards, the other way round back; the corners are met to half a step."""
    order = ["00", "01", "10", "11"]
    at, last, corners = [0, 0], ["00", "00"], [(0, 0)]
    for row in shield(".steps"):
        for axis in (0, 1):
            turned = (order.index(row[1 + axis]) - order.index(last[axis])) % 4
            assert turned in (0, 1, 3)
            at[axis] += {0: 0, 1: 1, 3: -1}[turned]
            last[axis] = row[1 + axis]
        corners.append((at[0], at[1]))
    assert corners[-1] == (0, 0)
    assert {(100 * x, 100 * y) for x, y, *_ in SHIELD} <= set(corners)
