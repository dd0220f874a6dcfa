"""Many holes and slots are compared as the few are: each two of them give the same."""

import random
import re
from itertools import combinations
from math import dist
from operator import itemgetter
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.budget import InForce, LimitError, Limits
from beamcam.errors import PlanError, Source
from beamcam.geometry.curves import Line
from beamcam.machine import load
from beamcam.machine.stations import Drill
from beamcam.model.part import Contour, Hole, Part, Profile, Slot
from beamcam.pipeline import post
from beamcam.planning.beam import MOST_TRIED
from beamcam.planning.operations import part_planner, slot
from beamcam.planning.operations.hole import _is_same, drop_duplicates
from beamcam.planning.operations.part_planner import ROUNDING, Group, Placed
from beamcam.suggestions import MOST_CURVES, suggestions
from tests.conftest import ROOT, examples
from tests.runs import call

SOURCE = Source("test")
IPE300 = Profile("I", "IPE300", 300, 150, 10.7, 7.1, 15)
MACHINE = load("beamline")


def drill_of(name: str) -> Drill:
    drill = load(name).drill
    assert drill is not None
    return drill


def compared_one_by_one(holes: Group, tolerance: float) -> dict[int, Placed]:
    """The repeats among holes, by comparing each two."""
    repeats: dict[int, Placed] = {}
    for first, other in combinations(sorted(holes, key=itemgetter(1)), 2):
        same = _is_same(first[2], other[2], tolerance + ROUNDING)
        if same and repeats.keys().isdisjoint((first[1], other[1])):
            repeats[other[1]] = first
    return dict(sorted(repeats.items()))


def crowd(seed: int, step: float) -> Group:
    """Holes in a few places, some of them a step apart, some written twice."""
    chance = random.Random(seed)
    holes = [
        Hole(
            chance.choice("vo"), 100 + step * chance.randint(0, 6),
            50 + step * chance.randint(0, 4), chance.choice((18.0, 22.0)), SOURCE,
        )
        for _ in range(chance.randint(2, 40))
    ]  # fmt: skip
    return tuple(sorted((hole.x, f, hole) for f, hole in enumerate(holes)))


@settings(deadline=None, max_examples=examples(300))
@given(st.integers(0, 10**9), st.sampled_from((0.0, 0.05, 0.1)), st.sampled_from((0.05, 0.07, 1.0)))
def test_repeats_are_those_of_comparing_each_two(seed: int, tolerance: float, step: float) -> None:
    holes = crowd(seed, step)
    kept, repeats = drop_duplicates(holes, tolerance)
    assert repeats == compared_one_by_one(holes, tolerance)
    assert [placed for placed in holes if placed[1] not in repeats] == list(kept)


def shapes_of(chance: random.Random, count: int, length: float) -> list[Hole | Slot]:
    return [
        Slot(
            chance.choice("vo"), chance.uniform(0, length), chance.uniform(0, 200), 18.0,
            chance.uniform(0, 60), chance.choice((0.0, 30.0)), chance.uniform(0, 180), SOURCE,
        )
        if chance.random() < 0.5
        else Hole(
            chance.choice("vo"), chance.uniform(0, length), chance.uniform(0, 200), 18.0, SOURCE,
        )
        for _ in range(count)
    ]  # fmt: skip


@settings(deadline=None, max_examples=examples(100))
@given(st.integers(0, 10**9))
def test_neighbours_of_slots_are_those_of_comparing_each_two(seed: int) -> None:
    chance = random.Random(seed)
    shapes, steel = shapes_of(chance, 30, 400.0), 3.0
    wanted = [
        (k, one.source)
        for (_, one), (k, other) in combinations(enumerate(shapes), 2)
        if one.face == other.face and (isinstance(one, Slot) or isinstance(other, Slot))
        and slot.core_distance(one, other) - (one.diameter + other.diameter) / 2
        < steel - slot.TOLERANCE
    ]  # fmt: skip
    found = list(slot._judge_neighbours(list(enumerate(shapes)), steel))
    assert [f for f, _ in found] == [f for f, _ in wanted]
    assert {said.code for _, said in found} <= {slot.NEAR_EDGE.code}


def part_of(features: list[Hole | Slot]) -> Part:
    return Part("B1", IPE300, 12000.0, SOURCE, features=tuple(features))


def refused(part: Part, machine: str = "beamline") -> list[str]:
    with pytest.raises(PlanError) as told:
        post((part,), load(machine))
    return [one.code for one in told.value.diagnostics]


def test_more_features_than_a_bar_has_are_refused_by_name() -> None:
    holes: list[Hole | Slot] = [
        Hole("v", 50 + k % 600 * 18.0, 40 + k // 600 * 20.0, 6.0, Source("big.nc1", k))
        for k in range(Limits().features + 1)
    ]
    with pytest.raises(LimitError) as told:
        post((part_of(holes),), MACHINE)
    (said,) = told.value.diagnostics
    assert said.code == "limit-features"
    assert "found 10001 features on one bar" in said.message
    half = part_of(holes[:5001])
    with pytest.raises(LimitError):
        post((half, half), MACHINE)
    InForce.limits = Limits(features=3)
    try:
        with pytest.raises(LimitError):
            post((part_of(holes[:4]),), MACHINE)
    finally:
        InForce.limits = Limits()


def test_a_crowd_of_holes_is_counted_and_not_compared() -> None:
    chance = random.Random(1)
    holes: list[Hole | Slot] = [
        Hole("v", 100 + 100 * chance.random(), 100 + 50 * chance.random(), 18.0, SOURCE)
        for _ in range(9000)
    ]
    assert refused(part_of(holes)) == [part_planner.MANY_PAIRS.code]
    assert refused(part_of(holes[:300]))[0] == "plan-hole-overlap"


def test_the_crowd_counts_the_pairs_that_would_be_compared() -> None:
    holes = tuple((k * 0.011, k, Hole("v", k * 0.011, 50.0, 18.0, SOURCE)) for k in range(2500))
    drill = drill_of("beamline")
    ((_, said),) = part_planner.refuse_many_pairs(holes, drill)
    reach = 18.0 + drill.min_edge_distance
    pairs = sum(b[0] - a[0] <= reach for a, b in combinations(holes, 2))
    assert f"found {pairs} pairs of holes that stand within {reach:g} mm" in said.message
    assert not list(part_planner.refuse_many_pairs(holes[:2000], drill))


def test_a_crowd_of_slots_is_counted_and_not_compared() -> None:
    chance = random.Random(1)
    slots: list[Hole | Slot] = [
        Slot("v", 100 + 100 * chance.random(), 150.0, 18.0, 20.0, 0.0, 0.0, SOURCE)
        for _ in range(600)
    ]
    assert refused(part_of(slots), "beamline-pusher") == [slot.MANY_PAIRS.code]


def test_ways_out_are_tried_for_parts_that_a_shop_has() -> None:
    """Each way is a plan of the whole; fifty plans of thousands of holes would take minutes."""
    from beamcam.model.request import Request

    few: list[Hole | Slot] = [Hole("v", 100.0, 150.0, 91.0, SOURCE)]
    many = few * (MOST_TRIED + 1)
    tried = (MACHINE,)
    assert suggestions(Request((part_of(many),), MACHINE), tried, ()).code == "plan-ways-untried"
    assert suggestions(Request((part_of(few),), MACHINE), tried, ()).code != "plan-ways-untried"
    count = MOST_CURVES + 1
    long = Contour("v", "inner", (Line((0.0, 0.0), (1.0, 0.0)),) * count, SOURCE)
    said = suggestions(Request((replace(part_of(few), features=(long,)),), MACHINE), tried, ())
    assert said.message.startswith(f"found {count} curves, not every way out was looked for")


def test_slots_are_read_back_however_many() -> None:
    """The read-back finds the path of each pocket among those near it, and misses none."""
    slots: list[Hole | Slot] = [
        Slot("v", 100 + k * 60.0, 150.0, 18.0, 20.0, 0.0, 0.0, Source("s", k)) for k in range(60)
    ]
    posted = post((part_of(slots),), load("beamline-pusher"))
    assert sum(one.how == "made" for one in posted.plan.outcomes) == 60


def test_the_read_back_looks_at_the_holes_that_comparing_each_two_finds() -> None:
    from beamcam.checks.bars.machine_limits import CornerCircles, _side_by_side

    for seed in range(100):
        chance = random.Random(seed)
        holes = [
            Hole(
                chance.choice("vo"), chance.uniform(0, 200), chance.uniform(0, 90),
                chance.choice((6.0, 18.0, 40.0)), SOURCE,
            )
            for _ in range(25)
        ]  # fmt: skip
        shapes = [shape_of(CornerCircles, hole) for hole in holes]

        def touch(one: Any, other: Any) -> bool:
            near = dist(one.centres[0], other.centres[0]) < one.radius + other.radius
            return one.face == other.face and near

        wanted = [pair for pair in combinations(shapes, 2) if touch(*pair)]
        assert [pair for pair in _side_by_side(shapes) if touch(*pair)] == wanted


def shape_of(kind: Any, hole: Hole) -> Any:
    """A hole as the read-back has it, whatever else is known of it."""
    known = {
        "face": hole.face, "centres": ((hole.x, hole.y),), "radius": hole.diameter / 2,
        "hole": hole, "what": "hole", "source": SOURCE,
    }  # fmt: skip
    names = kind.__struct_fields__
    return kind(**{name: known.get(name) for name in names})


def test_a_move_beyond_all_limits_is_not_looked_at_mm_by_mm(tmp_path: Path) -> None:
    program = tmp_path / "far.gcode"
    text = (ROOT / "tests/golden/beamline/channel.gcode").read_text("ascii")
    lines = text.splitlines(keepends=True)
    at = next(k for k, line in enumerate(lines) if "G00 X" in line and " Z" in line)
    lines[at] = re.sub(r"Z\S+", "Z1000000000", lines[at])
    program.write_text("".join(lines), "ascii")
    done = call("report", program, "-o", tmp_path / "x.html")
    assert "1e+09" in done.stderr
    assert (tmp_path / "x.html").is_file() or done.exit_code == 1
