"""Common cuts: parts a kerf apart keep their size, by the area that the beam leaves of a sheet."""

import random
import re
from math import cos, pi, sin

import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.checks.sheets.compare import verify_sheet
from beamcam.checks.sheets.required_layout import kerf_on, pulled_apart
from beamcam.errors import PlanError, Source
from beamcam.geometry.curves import Arc, Curve
from beamcam.machine import Machine, load
from beamcam.machine.overlay import with_torch
from beamcam.model.part import Part
from beamcam.model.plan import SheetPlan
from beamcam.model.request import Request
from beamcam.pipeline import Posted, post, read_back
from beamcam.planning.contours.outline import Shape
from beamcam.planning.contours.plate import apart
from beamcam.planning.contours.repeats import in_levels
from tests.conftest import examples, sampled
from tests.unit.sheets.parts import box, circle, contour, drawing, lines
from tests.unit.sheets.test_feeds import length, strokes

KERF = 1.2
SHEET = shapely.box(-50, -50, 3100, 1600)


def nested(**values: object) -> Machine:
    asked = {"common_cuts": True, **values}
    return with_torch(load("plate-linuxcnc"), thickness=3.0, **asked)  # type: ignore[arg-type]


def outline(kind: str, a: float, b: float) -> tuple[Curve, ...]:
    if kind == "box":
        return box(0, 0, a, b)
    if kind == "L":
        return lines((0, 0), (a, 0), (a, b / 2), (a / 2, b / 2), (a / 2, b), (0, b))
    if kind == "trapezoid":
        return lines((0, 0), (a, 0), (a, b), (a / 3, b))
    return lines(*[(a + a * cos(2 * pi * k / 6), a + a * sin(2 * pi * k / 6)) for k in range(6)])


def random_nest(seed: int) -> list[Part]:
    chance = random.Random(seed)
    found = []
    for number in range(chance.randint(2, 8)):
        kind = chance.choice(["box", "box", "box", "L", "trapezoid", "hexagon"])
        a, b = chance.choice([60.0, 80.0, 117.5]), chance.choice([50.0, 80.0])
        if kind == "hexagon":
            a = 40.0
        features = [contour(outline(kind, a, b), line=10 * number + 1)]
        if chance.random() < 0.5:
            features.append(contour(circle(a * 0.75, 15, 12), line=10 * number + 2))
        found.append(drawing(*features, thickness=3.0))
    return found


def drawn(part: Part, place: tuple[float, float]) -> shapely.Polygon:
    """A part at its place: its outline less its holes."""
    rings = [
        shapely.Polygon([c.point(k / 64) for c in one.curves for k in range(64)])
        for one in part.contours
    ]
    whole = max(rings, key=lambda ring: ring.area)
    for ring in rings:
        if ring is not whole:
            whole = whole.difference(ring)
    return shapely.affinity.translate(whole, *place)


def left_of_sheet(text: str) -> list[shapely.Polygon]:
    """What the beam leaves of the sheet, piece by piece."""
    ways = [[p for points, _ in stroke for p in points] for stroke in strokes(text)]
    band = shapely.union_all([shapely.LineString(w).buffer(KERF / 2, quad_segs=64) for w in ways])
    return list(shapely.get_parts(SHEET.difference(band)))


def parts_are_exact(posted: Posted) -> None:
    """Each part comes free, as it is drawn: neither smaller nor larger than rounding makes it."""
    assert isinstance(posted.plan, SheetPlan)
    pieces = left_of_sheet(posted.text)
    for piece in posted.plan.pieces:
        part = drawn(piece.part, piece.place)
        at = part.representative_point()
        (made,) = [p for p in pieces if p.contains(at)]
        # A round beam leaves a fillet in an inner corner of the part.
        rounded = part.buffer(KERF / 2, quad_segs=64).buffer(-KERF / 2, quad_segs=64)
        off = made.symmetric_difference(rounded)
        assert made.area == pytest.approx(rounded.area, rel=3e-4)
        assert off.buffer(-0.03).is_empty, off.bounds
        assert off.area <= 0.03 * part.length


@pytest.mark.parametrize("seed", sampled(range(50), 4))
def test_parts_of_random_nests_are_exact(seed: int) -> None:
    parts = random_nest(seed)
    posted = post(parts, nested())
    parts_are_exact(posted)
    apart = post(parts, with_torch(load("plate-linuxcnc"), thickness=3.0))
    cut, more = (
        sum(length(points) for stroke in strokes(one.text) for points, _ in stroke)
        for one in (posted, apart)
    )
    told = [d for d in posted.remarks if d.code == "plan-common-edge"]
    saved = sum(float(re.findall(r"others, ([\d.]+) mm", str(d))[0]) for d in told)
    leads = 12.0 * len(parts)  # what is left of a contour needs none
    assert saved - 1 <= more - cut <= saved + leads


def test_some_nests_share_edges() -> None:
    """Else nothing is proved."""
    told = [
        any(d.code == "plan-common-edge" for d in post(random_nest(seed), nested()).remarks)
        for seed in range(10)
    ]
    assert sum(told) >= 5


GRID = drawing(
    *(
        contour(box(c * (60 + KERF), r * (40 + KERF), 60, 40), line=10 * r + c + 1)
        for r in range(2)
        for c in range(3)
    ),
    contour(circle(30, 20, 15), line=50), thickness=3.0,
)  # fmt: skip


def test_what_is_left_of_a_contour_begins_in_an_open_kerf() -> None:
    """No stroke but a ring pierces on a part's edge, and the ring not on a shared one."""
    cut = shapely.Polygon()
    for stroke in strokes(post((GRID,), nested()).text):
        points = [p for some, _ in stroke for p in some]
        begin = shapely.Point(points[0])
        part_edges = shapely.union_all([drawn_ring(one).exterior for one in GRID.contours])
        if not cut.buffer(0.01).contains(begin):
            assert begin.distance(part_edges) > KERF
        cut = cut.union(shapely.LineString(points).buffer(KERF / 2))


def drawn_ring(one) -> shapely.Polygon:  # type: ignore[no-untyped-def]
    ring = shapely.Polygon([c.point(k / 64) for c in one.curves for k in range(64)])
    return shapely.affinity.translate(ring, 10, 10)


def blocks_of(text: str) -> list[str]:
    return re.findall(r"G0 X\S+ Y\S+\nM3 S1\n(?:.*\n)*?M5\n", text)


def test_mutants_of_common_cuts_are_refused() -> None:
    """A stroke dropped, doubled, in another place of the order, or moved by half a kerf."""
    machine = nested()
    text = post((GRID,), machine).text
    every = blocks_of(text)
    wrong = [text.replace(one, "") for one in every] + [text.replace(one, one * 2) for one in every]
    first = every[-1]
    wrong.append(text.replace(first, "").replace(every[0], first + every[0]))
    for one in every:
        moved = re.sub(r"X([\d.]+)", lambda m: f"X{float(m[1]) + KERF / 2:.4f}", one)
        wrong.append(text.replace(one, moved))
        moved = re.sub(r"Y([\d.]+)", lambda m: f"Y{float(m[1]) - KERF / 4:.4f}", one)
        wrong.append(text.replace(one, moved))
    # The runs before the ring that they begin on, and a ring begun on the edge that it shares.
    for k in range(2, len(every)):
        order = [*every[:1], every[k], *every[1:k], *every[k + 1 :]]
        wrong.append(text.replace("".join(every), "".join(order)))
    assert "".join(every) in text
    for mutant in wrong:
        if mutant != text:
            assert verify_sheet(mutant, (GRID,), machine), mutant
    assert len({*wrong}) >= 30


def test_runs_first_are_on_an_edge() -> None:
    machine = nested()
    text = post((GRID,), machine).text
    every = blocks_of(text)
    ring = next(k for k, one in enumerate(every) if "G3" in one and one.count("G1") > 3)
    order = [*every[:ring], *every[ring + 1 :], every[ring]]
    wrong = text.replace("".join(every), "".join(order))
    assert "verify-sheet-edge" in {d.code for d in verify_sheet(wrong, (GRID,), machine)}


@settings(max_examples=examples(15), deadline=None)
@given(columns=st.integers(1, 4), rows=st.integers(1, 3), width=st.sampled_from([30.0, 45.5]))
def test_copies_lie_a_kerf_apart(columns: int, rows: int, width: float) -> None:
    part = drawing(contour(box(0, 0, width, 40)), thickness=3.0)
    machine = nested(copies=(columns, rows))
    posted = post((part,), machine)
    pieces = [p for p in left_of_sheet(posted.text) if p.area < SHEET.area / 2]
    assert len(pieces) == columns * rows
    assert all(p.area == pytest.approx(width * 40, rel=1e-4) for p in pieces)
    assert not read_back(posted.text, Request((part,), machine))
    other = with_torch(machine, common_cuts=False)
    if columns * rows > 1:
        assert read_back(posted.text, Request((part,), other))


def test_without_a_kerf_they_touch() -> None:
    part = drawing(contour(box(0, 0, 40, 40)), thickness=3.0)
    machine = with_torch(load("laser-grbl"), thickness=3.0, common_cuts=True, copies=(3, 1))
    text = post((part,), machine).text
    assert max(float(x) for x in re.findall(r"X([\d.]+)", text)) == pytest.approx(120 + 2)


def touching(seed: int) -> tuple[Part, list[shapely.Polygon]]:
    """A drawing of parts that touch: rows of boxes, some with holes or a side in two lines."""
    chance = random.Random(seed)
    features, found = [], []
    y = 0.0
    for row in range(chance.randint(1, 3)):
        x, height = 0.0, chance.choice([30.0, 45.0])
        for column in range(chance.randint(1, 4)):
            width = chance.choice([40.0, 55.5])
            ring = box(x, y, width, height)
            if chance.random() < 0.3:
                ring = lines(
                    (x, y), (x + width, y), (x + width, y + height), (x, y + height),
                    (x, y + height / 2),
                )  # fmt: skip
            number = 10 * row + column + 1
            features.append(contour(ring, line=number))
            shape = shapely.box(x, y, x + width, y + height)
            if chance.random() < 0.5:
                features.append(contour(circle(x + 20, y + 15, 10), line=100 + number))
                shape = shape.difference(shapely.Point(x + 20, y + 15).buffer(5, quad_segs=64))
            found.append(shape)
            x += width
        y += height
    return drawing(*features, thickness=3.0), found


@pytest.mark.parametrize("seed", sampled(range(12), 2))
def test_parts_of_a_drawing_that_touch_keep_their_size(seed: int) -> None:
    part, shapes = touching(seed)
    posted = post((part,), nested())
    pieces = [p for p in left_of_sheet(posted.text) if p.area > 200 and p.area < SHEET.area / 2]
    assert len(pieces) == len(shapes)
    for shape in shapes:
        fits = [
            p for p in pieces
            if abs(p.area - shape.area) < 3e-4 * shape.area
            and _at_origin(p).symmetric_difference(_at_origin(shape)).buffer(-0.03).is_empty
        ]  # fmt: skip
        assert fits
        pieces.remove(fits[0])
    assert not read_back(posted.text, Request((part,), nested()))


def _at_origin(shape: shapely.Polygon) -> shapely.Polygon:
    x, y, _, _ = shape.bounds
    return shapely.affinity.translate(shape, -x, -y)


def test_they_are_told_and_refused_without_the_option() -> None:
    part, _ = touching(1)
    assert "plan-sheet-apart" in {d.code for d in post((part,), nested()).remarks}
    with pytest.raises(PlanError, match="plan-shared-edge"):
        post((part,), nested(common_cuts=False))


def slanted(seed: int) -> tuple[Part, list[shapely.Polygon]]:
    """A drawing of parts that touch along slants, in one row or with one part above all of it."""
    chance = random.Random(seed)
    tops, bottoms = [0.0], [0.0]
    for _ in range(chance.randint(2, 4)):
        middle = max(tops[-1], bottoms[-1]) + chance.choice([40.0, 62.5])
        lean = chance.choice([-12.0, 7.5, 15.0])
        bottoms.append(middle - lean)
        tops.append(middle + lean)
    rings = [
        [(bottoms[k], 0.0), (bottoms[k + 1], 0.0), (tops[k + 1], 40.0), (tops[k], 40.0)]
        for k in range(len(tops) - 1)
    ]
    if chance.random() < 0.4:
        rings.append([(tops[0], 40.0), (tops[-1], 40.0), (tops[-1], 70.0), (tops[0], 70.0)])
    if chance.random() < 0.5:
        turn = chance.choice([17.0, 45.0, 90.0]) * pi / 180
        rings = [
            [(x * cos(turn) - y * sin(turn), x * sin(turn) + y * cos(turn)) for x, y in ring]
            for ring in rings
        ]
    features = [contour(lines(*ring), line=k + 1) for k, ring in enumerate(rings)]
    return drawing(*features, thickness=3.0), [shapely.Polygon(ring) for ring in rings]


@pytest.mark.parametrize("seed", range(16))
def test_parts_that_touch_along_slants_keep_their_size(seed: int) -> None:
    """They go apart square to their edges, told, and each comes free as it is drawn."""
    part, shapes = slanted(seed)
    posted = post((part,), nested())
    assert "plan-sheet-apart" in {d.code for d in posted.remarks}
    pieces = [p for p in left_of_sheet(posted.text) if p.area > 200 and p.area < SHEET.area / 2]
    assert len(pieces) == len(shapes)
    for shape in shapes:
        fits = [
            p for p in pieces
            if abs(p.area - shape.area) < 3e-4 * shape.area
            and _at_origin(p).symmetric_difference(_at_origin(shape)).buffer(-0.03).is_empty
        ]  # fmt: skip
        assert fits
        pieces.remove(fits[0])
    assert not read_back(posted.text, Request((part,), nested()))
    cut = sum(length(points) for stroke in strokes(posted.text) for points, _ in stroke)
    assert cut < sum(shape.length for shape in shapes) - 20.0


def test_two_parts_go_apart_by_one_kerf_across_their_slant() -> None:
    """By hand: the edge rises 40 over 20 to the left, so its normal is (2, 1) / sqrt(5)."""
    one, other = (
        lines((0, 0), (60, 0), (40, 40), (0, 40)),
        lines((60, 0), (100, 0), (100, 40), (40, 40)),
    )
    part = drawing(contour(one), contour(other, line=2), thickness=3.0)
    text = post((part,), nested()).text
    x = 10 + 100 + KERF * 2 / 5**0.5 + KERF / 2
    y = 10 + 40 + KERF / 5**0.5 + KERF / 2
    found = {(float(a), float(b)) for a, b in re.findall(r"X([\d.]+) Y([\d.]+)", text)}
    assert any(abs(a - x) + abs(b - y) < 2e-3 for a, b in found)


def test_boxes_move_with_those_that_they_touch_by_way_of_others() -> None:
    """Two boxes one above the other lift the one above them by two kerfs, so those beside by one.

    By hand; the read-back moved the boxes beside to the right only, and found them elsewhere.
    """
    boxes = [
        box(0, 0, 50, 35), box(0, 35, 50, 35), box(50, 0, 30, 70), box(80, 0, 40, 70),
        box(0, 70, 120, 70),
    ]  # fmt: skip
    part = drawing(*(contour(b, line=k) for k, b in enumerate(boxes, 1)), thickness=3.0)
    torch = nested().torch
    assert torch is not None
    k = KERF
    expected = [(0, 0), (0, 35 + k), (50 + k, k), (80 + 2 * k, k), (0, 70 + 2 * k)]
    for moved in (pulled_apart(part, torch, kerf_on(part, torch)), apart(part, torch)[0]):
        starts = [one.curves[0].start for one in moved.contours]
        assert sum(starts, ()) == pytest.approx(sum(expected, ()))
    assert not read_back(post((part,), nested()).text, Request((part,), nested()))


def test_a_shared_arc_stays_shared() -> None:
    """No move parts a curve from itself by the same everywhere."""
    bow = Arc((60.0, 20.0), 20.0, -90.0, 180.0)
    left = (*lines((60, 40), (0, 40), (0, 0), (60, 0), closed=False), bow)
    right = (*lines((60, 0), (120, 0), (120, 40), (60, 40), closed=False), bow.reversed())
    part = drawing(contour(left), contour(right, line=2), thickness=3.0)
    with pytest.raises(PlanError, match="plan-shared-edge"):
        post((part,), nested())


def test_closed_contours_alone_have_their_levels() -> None:
    inner, outer = (
        Shape("cut", curves, True, (line,), Source("p.dxf", line), parent=parent)
        for line, (curves, parent) in enumerate([(circle(50, 50, 20), 1), (box(0, 0, 99, 99), -1)])
    )
    torch = nested().torch
    assert torch is not None
    assert [shape.level for shape in in_levels([inner, outer], torch)] == [0, 0]


# --- bridges --------------------------------------------------------------------------------------


@pytest.mark.parametrize("tab", [2.0, 4.0])
def test_a_rest_is_no_ring_with_a_bridge(tab: float) -> None:
    """The rest of the lower part begins and ends 7.2 mm apart, in kerfs of the upper one, whose own
    bridge lies between: that is none of the lower part, which gets two of its own."""
    upper, lower = contour(box(20, 40, 6, 20)), contour(box(0, 0, 60, 40), line=2)
    assert post((drawing(upper, lower, thickness=3.0),), nested(tabs=2, tab_width=tab)).text


def teeth(width: float) -> Part:
    """A row of parts on a long one."""
    row = (contour(box(k * width, 40, width, 20), line=2 + k) for k in range(20))
    return drawing(contour(box(0, 0, 20 * width, 40)), *row, thickness=3.0)


@pytest.mark.parametrize(("width", "tab", "fits"), [(4, 3, True), (5, 5, True), (4, 5, False)])
def test_bridges_lie_between_the_cuts_of_parts_that_touch(width: int, tab: int, fits: bool) -> None:
    """Those are cut a kerf of 1.2 mm and a part apart; the path leaves a bridge and a kerf."""
    machine = nested(tabs=3, tab_width=float(tab))
    if not fits:
        with pytest.raises(PlanError) as refused:
            post((teeth(width),), machine)
        assert [d.code for d in refused.value.diagnostics] == ["plan-tabs-joint"]
        assert "at x 41.000, y 40.600" in str(refused.value.diagnostics[0])
        return
    for tabs in (1, 4):
        assert post((teeth(width),), nested(tabs=tabs, tab_width=float(tab))).text
