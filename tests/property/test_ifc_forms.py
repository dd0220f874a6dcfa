"""Forms that are no rolled section: joggled plates, I sections of two flanges, kinks, shims."""

from math import acos, cos, hypot, radians, sin
from random import Random

import pytest

from beamcam.errors import Severity
from beamcam.model.part import Contour, Hole, Part
from beamcam.readers import Reading
from beamcam.readers.ifc import Options, read
from tests.conftest import sampled
from tests.property.ifc_cuts import SIZES, Bar, Box, Round, model_of
from tests.property.ifc_kernel import kernel_volume, meshed, same
from tests.unit.readers.ifc.models import Small

CHECKED = Options(kernel=True)
SEEDS = range(8)


def checked(m: Small) -> Reading:
    return read(m.data, "m.ifc", options=CHECKED)


def outline_area(part: Part) -> float:
    """mm2 within the outline of a special section, its arcs included."""
    total = 0.0
    points = part.section
    for a, b in zip(points, (*points[1:], points[0]), strict=True):
        total += (a.z * b.y - b.z * a.y) / 2
        if a.radius:
            r, chord = abs(a.radius), hypot(b.y - a.y, b.z - a.z)
            turn = acos(1 - chord * chord / (2 * r * r))
            cap = r * r / 2 * (turn - sin(turn))
            total += -cap if a.radius > 0 else cap
    return abs(total)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_joggled_plate_has_its_outline_or_is_refused(seed: int) -> None:
    random = Random(seed)
    t, step = random.uniform(5, 20), random.uniform(4, 40)
    a, run, b = random.uniform(30, 80), random.uniform(5, 60), random.uniform(30, 80)
    low = [(0.0, 0.0), (a, 0.0), (a + run, step), (a + run + b, step)]
    high = [(x, y + t) for x, y in reversed(low)]
    m = Small()
    body = m.extruded(m.polygon(*low, *high), random.uniform(60, 300))
    m.element(body, random.choice(("IFCBEAM", "IFCPLATE")), name=f"PL{t:.0f}*80")
    found = checked(m)
    if not found.parts:
        assert found.refused
        return
    (part,) = found.parts
    assert part.profile.code == "SO"
    true = kernel_volume(m.data)
    assert true is not None
    assert same(true, outline_area(part) * part.length / 1e3)


@pytest.mark.parametrize("seed", SEEDS)
def test_an_i_section_of_two_flanges_has_its_outline(seed: int) -> None:
    random = Random(seed)
    h, web = random.uniform(200, 500), random.uniform(6, 15)
    sizes = [(random.uniform(100, 300), random.uniform(8, 25)) for _ in range(2)]
    radii = [random.choice((0.0, 8.0, 15.0)) for _ in range(2)]
    (b0, t0), (b1, t1) = sizes
    m = Small()
    profile = m.add(
        f"IFCASYMMETRICISHAPEPROFILEDEF(.AREA.,$,{m.flat},{b0},{h},{web},{t0},{radii[0]},{b1},{t1},"
        f"{radii[1]},$,$,$,$)"
    )
    m.element(m.extruded(profile, 3000.0))
    found = checked(m)
    assert not found.refused, found.diagnostics
    (part,) = found.parts
    assert part.profile.code == "SO"
    assert (part.profile.height, part.profile.width) == pytest.approx((h, max(b0, b1)))
    true = kernel_volume(m.data)
    assert true is not None
    assert same(true, outline_area(part) * 3.0)


@pytest.mark.parametrize("seed", range(3))
def test_so_has_its_mesh(seed: int) -> None:
    """Of any special section that is the same all along."""
    random = Random(seed)
    a, b, t = random.uniform(60, 200), random.uniform(60, 200), random.uniform(3, 12)
    ring = [(0.0, 0.0), (a, 0.0), (a, b / 2), (a - t, b / 2), (a - t, t), (t, t), (t, b), (0.0, b)]
    m = Small()
    m.element(m.extruded(m.polygon(*ring), 2000.0))
    found = read(meshed(m.data), "m.ifc", options=CHECKED)
    (part,) = found.parts
    assert [d for d in found.diagnostics if d.severity is not Severity.NOTE] == []
    assert part.profile.code == "SO"
    true = kernel_volume(m.data)
    assert true is not None
    assert same(true, outline_area(part) * 2.0)


@pytest.mark.parametrize("mesh", [False, True])
def test_a_round_bar_with_a_flat_is_no_plate(mesh: bool) -> None:
    bar = Bar("RU", 2000.0, SIZES["RU"])
    data = model_of(bar, [Box((-9.0, 45.0, -9.0), (100.0, 99.0, 99.0))])
    found = read(meshed(data) if mesh else data, "m.ifc", options=CHECKED)
    assert found.refused
    assert found.parts == ()


@pytest.mark.parametrize("kernel", [False, True])
def test_a_hole_to_the_middle_of_a_round_bar_is_none_through_it(kernel: bool) -> None:
    bar = Bar("RU", 900.0, SIZES["RU"])
    data = model_of(bar, [Round((400.0, 30.0, 30.0), 2, 14.0, 80.0)])
    found = read(data, "m.ifc", options=Options(kernel=kernel))
    assert found.parts == ()
    assert any("a blind hole in a solid round" in d.message for d in found.diagnostics)


@pytest.mark.parametrize("seed", sampled(SEEDS, 3))
def test_a_kinked_bar_is_never_read_as_a_straight_one(seed: int) -> None:
    random = Random(seed)
    turn = radians(random.uniform(4, 60))
    x, y = cos(turn), sin(turn)
    m = Small()
    profiles = m.ipe300(), m.box(20, 90)
    profile = random.choice(profiles)
    far = m.step.axes((990, 0, 0), (x, y, 0), (-y, x, 0))
    pieces = m.extruded(profile, 1000.0), m.extruded(profile, random.uniform(500, 1500), far)
    m.element(m.add(f"IFCBOOLEANRESULT(.UNION.,{pieces[0]},{pieces[1]})"))
    found = checked(m)
    assert found.parts == ()
    (said,) = [d for d in found.diagnostics if d.severity is Severity.ERROR]
    assert said.code in ("ifc-kinked", "ifc-unexplained", "ifc-section", "ifc-geometry")


@pytest.mark.parametrize("seed", SEEDS)
def test_bolts_drill_steel_and_nothing_else(seed: int) -> None:
    from shapely import Point, Polygon

    random = Random(seed)
    long, wide = random.uniform(150, 400), random.uniform(60, 200)
    m = Small()
    shim = m.extruded(m.box(long, wide), 6.0, m.step.axes((0, 0, 0), (0, 0, 1), (1, 0, 0)))
    x = random.uniform(-0.3, 0.3) * long
    slot = m.extruded(m.box(24, wide), 30.0, m.step.axes((x, wide / 2, -9), (0, 0, 1), (1, 0, 0)))
    m.element(m.minus(shim, slot), "IFCPLATE")
    for _ in range(6):
        at = (random.uniform(-0.5, 0.5) * long, random.uniform(-0.5, 0.5) * wide, -20)
        m.bolt(at, (0, 0, 1), 20.0, 60.0)
    (part,) = checked(m).parts
    (outline,) = (f for f in part.features if isinstance(f, Contour))
    steel = Polygon([c.start for c in outline.curves]).buffer(1e-6)
    for hole in (f for f in part.features if isinstance(f, Hole)):
        assert steel.covers(Point(hole.x, hole.y).buffer(hole.diameter / 2))
