"""Strangers: rs274 runs the programs, and the solid kernel cuts the bar by what it prints.

Nothing of the planner, the emitter, the controllers or the read-back is used on the way from the
canonical output to the steel: a torch that is on cuts a slab as wide as its kerf, along its own
direction, as deep as its speed is for.
"""

import re
from collections.abc import Callable
from itertools import pairwise
from math import acos, cos, pi, radians, sin, tan
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from msgspec.structs import replace
from shapely import LineString, Polygon

from beamcam.machine import Machine, load
from beamcam.model.part import Contour, EndCuts, Part
from beamcam.planning.coping.plan import plan_coping
from beamcam.planning.manual_list import manual_rows
from beamcam.solid.kernel import kernel, outline
from beamcam.solid.part_solid import part_solid
from tests.conftest import sampled
from tests.random_bevels import random_cut_out, random_end
from tests.random_copes import (
    CEES,
    random_bevel,
    random_cope,
    random_lipped,
    random_mitre,
    random_prepared_web,
    random_shaped_bevel,
    random_tee,
)  # fmt: skip
from tests.rs274 import INI, interpreted, needs_rs274
from tests.unit.coping.samples import COPER, NAMES, part_of, program_of, sample

BEVEL = load("coper-tilt-linuxcnc")
#: Kerf and depth by the feed, as the machine file has them.
CHART = {row.feed_mm_min: (row.kerf, row.up_to) for row in COPER.coper.rows} if COPER.coper else {}
START = 30.0  #: X of a part's x 0
MOVE = re.compile(r"STRAIGHT_(TRAVERSE|FEED)\(([^)]*)\)")


class Burn(NamedTuple):
    """What is cut between torch on and torch off."""

    feed: float
    points: list[tuple[float, ...]]  #: X, Y, Z, A, B; the first where it pierces


def burns(path: Path) -> list[Burn]:
    """The strokes of the torch as rs274 prints them."""
    done = interpreted(path, ini=INI)
    assert done.returncode == 0, done.stderr
    found: list[Burn] = []
    here: tuple[float, ...] = ()
    feed, is_on = 0.0, False
    for line in done.stdout.splitlines():
        if "SET_FEED_RATE" in line:
            feed = float(line.split("(")[1].rstrip(") "))
        if "START_SPINDLE_CLOCKWISE" in line:
            is_on = True
            found.append(Burn(0.0, [here]))
        if "STOP_SPINDLE" in line:
            is_on = False
        move = MOVE.search(line)
        if move is not None:
            here = tuple(float(v) for v in move[2].split(","))[:5]
            if is_on:  # the way down says the speed; in inverse time rs274 prints none of the face
                assert move[1] == "FEED"
                found[-1] = Burn(found[-1].feed or feed, [*found[-1].points, here])
    assert not is_on
    return [burn for burn in found if len(burn.points) > 1]


def written(part: Part, folder: Path, machine: Machine = COPER) -> Path:
    path = folder / "part.ngc"
    path.write_text(program_of(part, machine))
    return path


def slab(burn: Burn) -> Any:
    """What a stroke takes of the bar: its kerf, along the torch, as deep as the steel is cut.

    A torch that is tilted stands off by 6 mm tan B more, half its width, and 3 mm / cos B.
    """
    m = kernel()
    kerf, deep = CHART[burn.feed]
    tips = burn.points[1:]
    if len({tip[3:] for tip in tips}) > 1:
        return turning(tips, kerf, deep)
    a, b = radians(tips[0][3]), radians(tips[0][4])
    out = (sin(b), -sin(a) * cos(b), cos(a) * cos(b))  # from the steel to the torch
    side = (0.0, cos(a), sin(a))
    along = (cos(b), sin(a) * sin(b), -cos(a) * sin(b))
    ways = [
        tuple(sum(p * q for p, q in zip((x - START, y, z), way, strict=True))
              for way in (along, side, out))
        for x, y, z, *_ in tips
    ]  # fmt: skip
    flat = [(p, q) for p, q, _ in ways]
    lean = acos(cos(a - pi / 2 * round(2 * a / pi)) * cos(b))  # off the normal of its wall
    off = 3.0 / cos(lean) + 6.0 * tan(lean)
    shape = LineString(flat).buffer(kerf / 2, 16)
    rings = [
        list(ring.coords)[:-1]
        for one in getattr(shape, "geoms", (shape,))
        for ring in (one.exterior, *one.interiors)
    ]
    heights = [high for *_, high in ways]  # of a torch that is tilted they differ along the path
    assert lean or max(heights) - min(heights) < 1e-3
    low = min(heights) - off - deep
    body = m.Manifold.extrude(m.CrossSection(rings, m.FillRule.EvenOdd), max(heights) - low)
    rows = [(along[k], side[k], out[k], low * out[k]) for k in (0, 1, 2)]
    return body.transform(rows)


def turning(tips: list[tuple[float, ...]], kerf: float, deep: float) -> Any:
    """What a torch takes that turns: hulls of round jets, at four places of each stretch."""
    m = kernel()
    rounds = []
    # Each stretch from its start, and the last place.
    for one, other in pairwise([*tips, tips[-1]]):
        for k in range(4 if one[3:] != other[3:] else 1):
            x, y, z, *turn = (p + k / 4 * (q - p) for p, q in zip(one, other, strict=True))
            a, b = map(radians, turn)
            lean = acos(cos(a - pi / 2 * round(2 * a / pi)) * cos(b))
            far = 3.0 / cos(lean) + 6.0 * tan(lean) + deep + kerf / 2 * tan(lean)
            out = (sin(b), -sin(a) * cos(b), cos(a) * cos(b))
            side, along = (0.0, cos(a), sin(a)), (cos(b), sin(a) * sin(b), -cos(a) * sin(b))
            turns = (pi * j / 8 for j in range(16))
            ring = [(kerf / 2 * cos(t), kerf / 2 * sin(t)) for t in turns]
            rounds.append([
                tuple(at + p * u + q * v - down * w
                      for at, u, v, w in zip((x - START, y, z), along, side, out, strict=True))
                for p, q in ring for down in (0.0, far)
            ])  # fmt: skip
    hulls = [m.Manifold.hull_points([*a, *b]) for a, b in pairwise(rounds)]
    return m.Manifold.batch_boolean(hulls, m.OpType.Add)


def pieces(part: Part, strokes: list[Burn], stock: Any = None) -> list[Any]:
    """The pieces of the bar, or of what comes, after all strokes, the heaviest first."""
    m = kernel()
    section = outline(part)
    rings = [list(section.exterior.coords)[:-1], *(list(r.coords)[:-1] for r in section.interiors)]
    bar = m.Manifold.extrude(m.CrossSection(rings, m.FillRule.EvenOdd), part.length + 2 * START)
    along = ((0.0, 0.0, 1.0, -START), (1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0))
    left = lying(bar.transform(along) if stock is None else stock, part)
    for burn in strokes:
        left = left - slab(burn)
    found = [one for one in left.decompose() if one.volume() > 1.0]
    return sorted(found, key=lambda one: -one.volume())


def lying(solid: Any, part: Part) -> Any:
    """A solid in the section's axes as it lies: of a T Y is what was Z, Z what was height - Y, a C
    is turned by 180 degrees."""
    high, wide = part.profile.height, part.profile.width
    if part.profile.code == "C":
        return solid.transform(
            ((1.0, 0.0, 0.0, 0.0), (0.0, -1.0, 0.0, high), (0.0, 0.0, -1.0, wide))
        )
    if part.profile.code != "T":
        return solid
    rows = (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.0, -1.0, 0.0, part.profile.height)
    return solid.transform(rows)


def corners(part: Part) -> int:
    """How many corners of contours may be rounded, at most."""
    return sum(len(c.curves) for c in part.features if isinstance(c, Contour))


def check(part: Part, folder: Path, machine: Machine = COPER) -> tuple[list[Burn], Any]:
    """The strokes of its program, and the heaviest piece, which is the part, but for the corners
    that are rounded and the tolerance."""
    strokes = burns(written(part, folder, machine))
    piece = pieces(part, strokes)[0]
    compare(part, piece)
    return strokes, piece


def compare(part: Part, piece: Any) -> None:
    """A piece is a part, but for the corners that are rounded and the tolerance."""
    wanted = lying(part_solid(part), part)
    thick = max(part.profile.flange_thickness, part.profile.web_thickness or 0.0)
    # A rounded corner of 90 degrees keeps (1 - pi / 4) r^2 of steel, one of 45 degrees 1.63 r^2.
    more, less = (piece - wanted), (wanted - piece)
    assert more.volume() <= corners(part) * 45.0 * thick + 60.0
    if more.volume() > 165.0 * thick:  # else no piece of it is larger
        assert max(one.volume() for one in more.decompose()) <= 165.0 * thick
    assert less.volume() <= 0.003 * wanted.volume() + 60.0
    # Nothing of it is thicker than what paths and chords may be off.
    assert thicker(less).volume() < 1.0


def thicker(solid: Any) -> Any:
    """What of a solid lies more than 0.05 mm below its surface, along each axis."""
    for axis in range(3):
        shift = tuple(0.05 * (axis == k) for k in range(3))
        solid = solid.translate(shift) ^ solid.translate(tuple(-s for s in shift))
    return solid


@needs_rs274
@pytest.mark.parametrize("name", sampled(NAMES, 3))
def test_samples_fall_out_of_the_bar_that_rs274_cuts(name: str, tmp_path: Path) -> None:
    check(sample(name), tmp_path)


@needs_rs274
@pytest.mark.parametrize("seed", sampled([0, 3, 5, 7, 11], 3))
def test_random_parts_fall_out_of_the_bar(seed: int, tmp_path: Path) -> None:
    check(random_cope(seed), tmp_path)


@needs_rs274
@pytest.mark.parametrize("seed", sampled([0, 1, 2, 3, 5, 8], 3))
def test_random_tees_fall_out_of_the_bar(seed: int, tmp_path: Path) -> None:
    check(random_tee(seed), tmp_path)


@needs_rs274
@pytest.mark.parametrize("seed", sampled(range(12), 2))
def test_random_sections_with_lips_fall_out_of_the_bar(seed: int, tmp_path: Path) -> None:
    check(random_lipped(seed), tmp_path)


@needs_rs274
def test_a_lip_holds_the_piece_where_it_is_not_cut(tmp_path: Path) -> None:
    part = sample("joist")
    strokes, _ = check(part, tmp_path)
    deep = max(burn.feed for burn in strokes if CHART[burn.feed][1] >= 20.0)
    lips = [burn for burn in strokes if burn.feed == deep]
    assert len(lips) == 6  # two at each end, two of a notch
    for lip in lips[::3]:
        rest = [burn for burn in strokes if burn is not lip]
        wanted = lying(part_solid(part), part)
        assert (pieces(part, rest)[0] - wanted).volume() > 500.0


@needs_rs274
@pytest.mark.parametrize("seed", sampled([0, 1, 2, 3, 4, 6], 3))
def test_random_sections_with_lips_end_skew(seed: int, tmp_path: Path) -> None:
    check(random_mitre(seed, CEES), tmp_path, BEVEL)


@needs_rs274
@pytest.mark.parametrize("seed", sampled(range(12), 3))
def test_random_mitres_fall_out_of_the_bar(seed: int, tmp_path: Path) -> None:
    part = random_mitre(seed)
    if "plan-coping-slant" not in {d.code for d in plan_coping((part,), BEVEL).remarks}:
        check(part, tmp_path, BEVEL)


@needs_rs274
@pytest.mark.parametrize("seed", sampled(range(12), 3))
def test_random_bevels_fall_out_of_the_bar(seed: int, tmp_path: Path) -> None:
    part = random_bevel(seed)
    strokes, _ = check(part, tmp_path, BEVEL)
    square = [burn for burn in strokes if not burn.points[1][4]]
    if len(square) < len(strokes):  # a second pass that is missing is seen
        wedges = (pieces(part, square)[0] - lying(part_solid(part), part)).volume()
        assert wedges > 100.0


@needs_rs274
@pytest.mark.parametrize("seed", sampled(range(60), 4))
def test_random_webs_with_bevels_on_both_sides_fall_out_of_the_bar(
    seed: int, tmp_path: Path
) -> None:
    part = random_prepared_web(seed)
    plan = plan_coping((part,), BEVEL)
    if any(cut.bevel for cut in plan.operations) and not manual_rows(plan):
        strokes, piece = check(part, tmp_path, BEVEL)
        square = [burn for burn in strokes if not burn.points[1][4]]
        assert len(square) < len(strokes)
        # Without its passes the piece keeps the wedges.
        wanted = lying(part_solid(part), part)
        assert (pieces(part, square)[0] - wanted).volume() > (piece - wanted).volume() + 40.0


@needs_rs274
def test_a_splice_falls_out_of_the_bar(tmp_path: Path) -> None:
    check(sample("splice"), tmp_path, BEVEL)


@needs_rs274
def test_a_round_bevel_and_one_along_the_bar_fall_out_of_it(tmp_path: Path) -> None:
    part = sample("collar")
    strokes, piece = check(part, tmp_path, BEVEL)
    assert sum(len({point[3:] for point in burn.points}) > 10 for burn in strokes) == 1
    # Without the passes the piece keeps their wedges.
    square = [burn for burn in strokes if burn.points[1][3] % 90.0 == 0.0 and not burn.points[1][4]]
    assert len(square) == len(strokes) - 3
    wedges = (pieces(part, square)[0] - piece).volume()
    along, across = 10.6**2 * tan(radians(40.0)) / 2, 10.6**2 * tan(radians(30.0)) / 2
    least = 1110.0 * along + 170.0 * across + 270.0 * 7.4**2 * tan(radians(30.0)) / 2
    assert wedges > least


@needs_rs274
@pytest.mark.parametrize("seed", sampled([8, 11, 14, 23, 31, 38, 43, 68], 8))
def test_random_bevels_in_any_direction_fall_out_of_the_bar(seed: int, tmp_path: Path) -> None:
    part = random_shaped_bevel(seed)
    assert any(cut.bevel for cut in plan_coping((part,), BEVEL).operations)
    check(part, tmp_path, BEVEL)


@needs_rs274
@pytest.mark.parametrize(("random_part", "seed"), [(random_cut_out, 56), (random_end, 56)])
def test_random_undercuts_fall_out_of_the_bar(
    random_part: Callable[[int], Part], seed: int, tmp_path: Path
) -> None:
    """Without its pass, which alone makes the edge, the piece keeps what that cuts off."""
    part = random_part(seed)
    plan = plan_coping((part,), BEVEL)
    (k,) = (k for k, cut in enumerate(plan.operations) if cut.bevel)
    assert plan.operations[k].lower
    assert len(plan.operations[k].turns) > 15
    strokes = burns(written(part, tmp_path, BEVEL))
    compare(part, pieces(part, strokes)[0])
    rest = pieces(part, strokes[:k] + strokes[k + 1 :])[0]
    assert (rest - lying(part_solid(part), part)).volume() > 10000.0


@needs_rs274
def test_only_ledges_stay_of_the_access_holes_of_a_girder(tmp_path: Path) -> None:
    """They are as wide as the web with its fillets, along the flange in the hole, and 26.1 mm high;
    in the corner to the side of the hole half a kerf more, where the jet is round."""
    part = sample("girder")
    piece, wanted = pieces(part, burns(written(part, tmp_path)))[0], part_solid(part)
    assert thicker(wanted - piece).volume() < 1.0
    high, flange = part.profile.height, part.profile.flange_thickness
    ledges = [one for one in (piece - wanted).decompose() if one.volume() > 1000.0]
    assert ledges
    for ledge in ledges:
        _, y0, z0, _, y1, z1 = ledge.bounding_box()
        above, below = y0 - flange, high - flange - y1
        assert min(abs(above), abs(below)) < 0.2  # it stands on a flange
        assert y1 - y0 < 26.1 + 0.3 + max(kerf for kerf, _ in CHART.values()) / 2
        assert z1 - z0 < (part.profile.web_thickness or 0.0) + 2 * part.profile.radius + 0.2


@needs_rs274
def test_the_jet_goes_along_the_plane_of_an_end(tmp_path: Path) -> None:
    part = replace(part_of(length=1500.0), cuts=EndCuts(web_end=30.0, flange_start=20.0))
    planes = {"far": lambda y, z: 1500.0 - y * tan(radians(30.0)),
              "near": lambda y, z: (150.0 - z) * tan(radians(20.0))}  # fmt: skip
    seen = 0
    for burn in burns(written(part, tmp_path, BEVEL)):
        kerf, _ = CHART[burn.feed]
        end = "near" if burn.points[0][0] < 500.0 else "far"
        for x, y, z, a_deg, b_deg in burn.points[2:-1]:
            a, b = radians(a_deg), radians(b_deg)
            for deep in (5.0, 15.0, 25.0):
                px = x - START - deep * sin(b)
                py, pz = y + deep * sin(a) * cos(b), z - deep * cos(a) * cos(b)
                lean = {"far": 30.0, "near": 20.0}[end]
                off = (px - planes[end](py, pz)) * cos(radians(lean))
                assert abs(off) == pytest.approx(kerf / 2, abs=2e-3), (burn, deep)
                assert (off > 0.0) == (end == "far")
                seen += 1
    assert seen > 20


@needs_rs274
@pytest.mark.exhaustive
@pytest.mark.parametrize("random_part", [random_cope, random_tee, random_lipped])
def test_many_random_parts_fall_out_of_the_bar(
    random_part: Callable[[int], Part], tmp_path: Path
) -> None:
    from beamcam.errors import PlanError

    made = 0
    for seed in range(100, 160):
        part = random_part(seed)
        try:
            program_of(part)
        except PlanError:
            continue
        check(part, tmp_path)
        made += 1
    assert made > 50


@needs_rs274
def test_a_piece_of_another_part_is_not_taken_for_it(tmp_path: Path) -> None:
    part = sample("coped")
    strokes = burns(written(part, tmp_path))
    wanted = part_solid(part)
    for k in range(0, len(strokes), 4):
        piece = pieces(part, strokes[:k] + strokes[k + 1 :])[0]
        assert (piece - wanted).volume() > 100.0, k


@needs_rs274
def test_the_path_of_a_flange_is_its_outline(tmp_path: Path) -> None:
    part = sample("coped")
    ends = [b for b in burns(written(part, tmp_path)) if b.points[0][3] == -90.0][-2:]
    drawn = Polygon([(80.0, 0.0), (1130.0, 0.0), (1130.0, 150.0), (80.0, 150.0)])
    for burn in ends:
        kerf, _ = CHART[burn.feed]
        for x, y, z, *_ in burn.points[2:]:
            assert y == 303.0
            if 0.0 <= z <= 150.0:
                off = drawn.exterior.distance(LineString([(x - START, z), (x - START, z + 1e-6)]))
                assert off == pytest.approx(kerf / 2, abs=1e-3)
