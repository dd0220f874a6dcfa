"""Random drawings: a plan cuts what is drawn, measured from outside, or says rightly why not."""

from math import cos, pi, sin
from pathlib import Path
from random import Random

import numpy as np
import pytest
import shapely
from hypothesis import example, given, settings
from hypothesis import strategies as st

from beamcam.emitters import cutting
from beamcam.errors import PlanError
from beamcam.geometry.conics import arc_through
from beamcam.geometry.curves import BSpline, Curve
from beamcam.model.part import Part
from beamcam.motion.sheet import sheet_program
from beamcam.planning.contours import running_back
from beamcam.planning.sheet import plan_sheet
from tests.conftest import examples
from tests.rings import polygon_of
from tests.swept_band import Drawn, Measured, strokes_of
from tests.unit.sheets.parts import circle, contour, drawing, lines, table

KERF = 1.5  #: of plate-linuxcnc on 6 mm
INTO = 0.03
#: Chords that stand for contours lie so near to them.
CHORD = 0.003

#: What a contour is refused for; each is shown to be true.
CROSSING = {"plan-crossing", "plan-crossings", "plan-shared-edge"}
DOUBLED = {"plan-doubles-back-kerf"}
NARROW = {"plan-kerf", "plan-narrow", "plan-near"}
BY_MACHINE = {"plan-kerf-machine", "plan-kerf-lead"}


def star(random: Random, x: float, y: float, size: float) -> tuple[Curve, ...]:
    """A polygon, some of its sides as short as the kerf and shorter, or arcs."""
    count = random.randint(3, 10)
    corners = []
    for k in range(count):
        turn = 2 * pi * (k + random.uniform(-0.3, 0.3)) / count
        reach = size * random.uniform(0.35, 1)
        corners.append((x + reach * cos(turn), y + reach * sin(turn)))
        if random.random() < 0.3:  # a short side
            short, turn = random.uniform(0.05, 2.0), random.uniform(0, 2 * pi)
            px, py = corners[-1]
            corners.append((px + short * cos(turn), py + short * sin(turn)))
    sides = list(lines(*corners))
    for k, side in enumerate(sides):
        if random.random() < 0.2:
            bulge = random.choice((-1, 1)) * side.length * random.uniform(0.6, 4)
            sides[k] = arc_through(side.start, side.end, bulge)
    return tuple(sides)


def free(random: Random, x: float, y: float, size: float) -> tuple[Curve, ...]:
    """A closed cubic spline."""
    count = random.randint(4, 8)
    control = []
    for k in range(count):
        turn, reach = 2 * pi * k / count, size * random.uniform(0.4, 1.1)
        control.append((x + reach * cos(turn), y + reach * sin(turn)))
    control += control[:3]
    knots = tuple(float(k) for k in range(len(control) + 4))
    return (BSpline(3, tuple(control), knots),)


def shape_of(random: Random, x: float, y: float, size: float) -> tuple[Curve, ...]:
    kind = random.choice(("star", "star", "free", "circle", "slot"))
    if kind == "circle":
        return circle(x, y, 2 * size * random.uniform(0.3, 1))
    if kind == "free":
        return free(random, x, y, size)
    if kind == "slot":
        half, width = size * random.uniform(0.5, 1), random.uniform(0.6, 5.0)
        return lines((x - half, y), (x + half, y), (x + half, y + width), (x - half, y + width))
    return star(random, x, y, size)


def sheet_of(random: Random) -> list[tuple[Curve, ...]]:
    """Contours beside and inside one another, some of which touch or cross."""
    found = []
    for k in range(random.randint(1, 3)):
        x, size = 40.0 * k + random.choice((0.0, 0.0, -2.5)), random.uniform(4, 19)
        found.append(shape_of(random, x, 0.0, size))
        if random.random() < 0.5:
            inner = size * random.uniform(0.1, 0.6)
            found.append(shape_of(random, x + random.uniform(-2, 2), 0.0, inner))
    return found


def polygon(curves: tuple[Curve, ...]) -> shapely.Polygon:
    steps = 400 if len(curves) == 1 else 64
    return shapely.Polygon(polygon_of(curves, steps))


def part_of(sheet: list[tuple[Curve, ...]]) -> Part:
    return drawing(*(contour(curves, line=k) for k, curves in enumerate(sheet)))


def crosses(rings: list[shapely.Polygon]) -> bool:
    """Whether rings cross, touch or lie on one another or themselves within some hundredths."""
    edges = [ring.exterior for ring in rings]
    return any(not ring.is_valid or lies_on_itself(ring) for ring in rings) or any(
        a.distance(b) < 0.03 for k, a in enumerate(edges) for b in edges[:k]
    )


def lies_on_itself(ring: shapely.Polygon, half: float = 0.002) -> bool:
    """Whether a ring has a spike or a slot of at most twice `half`; else of a few thousandths."""
    return any(
        abs(ring.buffer(d, join_style="mitre").buffer(-d, join_style="mitre").length - ring.length)
        > 0.01
        for d in (half, -half)
    )


def has_narrow_places(rings: list[shapely.Polygon], kerf: float) -> bool:
    """Whether a disc as wide as the kerf does not reach all contours from the waste."""
    part = shapely.Polygon()
    for ring in rings:
        part = part.symmetric_difference(ring)
    around = shapely.box(*shapely.total_bounds(rings)).buffer(5 * kerf)
    middles = around.difference(part).buffer(-kerf / 2 + 0.01, quad_segs=32)
    reached = middles.buffer(kerf / 2 + 0.02, quad_segs=32)
    return not reached.covers(part.boundary)


@pytest.mark.parametrize("kerf_by", ["offset", "machine"])
@settings(max_examples=examples(25), deadline=None)
@given(seed=st.integers(0, 10**6))
@example(seed=158)
def test_what_is_cut_is_right_and_what_is_refused_is_wrong(
    tmp_path_factory: pytest.TempPathFactory, kerf_by: str, seed: int
) -> None:
    sheet = sheet_of(Random(seed))
    rings = [polygon(curves) for curves in sheet]
    machine = table(kerf_by=kerf_by, **({"lead": "line"} if kerf_by == "machine" else {}))
    try:
        plan = plan_sheet((part_of(sheet),), machine)
    except PlanError as refused:
        codes = {said.code for said in refused.diagnostics}
        assert codes <= CROSSING | DOUBLED | NARROW | BY_MACHINE
        if codes & CROSSING:
            assert crosses(rings)
        if codes & DOUBLED:
            assert machine.torch is not None
            half = running_back.NEEDLE * machine.torch.tolerance / 2
            assert any(lies_on_itself(ring, half + 0.001) for ring in rings)
        if codes & NARROW:
            assert crosses(rings) or has_narrow_places(rings, KERF)
        if kerf_by == "offset":
            assert not codes & BY_MACHINE
        return
    path: Path = tmp_path_factory.getbasetemp() / f"law-{kerf_by}.ngc"
    path.write_text(cutting.emit(sheet_program(plan, machine, "LAW"), machine))
    moved = [shapely.transform(ring, lambda p: p + np.array(plan.shift)) for ring in rings]
    moved = [ring if ring.is_valid else shapely.make_valid(ring).buffer(0.0) for ring in moved]
    assert list(Measured(strokes_of(path), Drawn(moved, []), KERF).faults(INTO + CHORD)) == []
