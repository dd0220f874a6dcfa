"""The kinds of work on a bar: each feature has one, and a part enters few rooms of planning."""

import sys
from collections import Counter
from collections.abc import Iterator
from types import FrameType
from typing import Any, get_args

import pytest

from beamcam.geometry.curves import Line
from beamcam.machine import load
from beamcam.model.part import (
    Bend,
    Camber,
    Contour,
    EndCuts,
    EndPlane,
    Feature,
    Hole,
    Slot,
    TextMark,
)
from beamcam.model.plan import SKIP_NAMES
from beamcam.planning.beam import plan_bar
from beamcam.planning.operations.work import KINDS, kind_of
from tests.unit.planning.shop import SOURCE, hole, part

CURVES = (Line((100, 50), (200, 50)),)
FEATURES: tuple[tuple[Feature, str], ...] = (
    (hole(500), "hole"),
    (hole(500, diameter=0, kind="mark"), "hole"),
    (Slot("v", 700, 150, 20, 40, 0, 0, SOURCE), "slot"),
    (Contour("v", "open", CURVES, SOURCE, "mark", False), "mark"),
    (Contour("v", "inner", CURVES, SOURCE), "contour"),
    (TextMark("v", 100, 100, 0, 10, "M58", SOURCE), "text"),
    (Bend((0, 0), (0, 100), 90, 5, SOURCE), "other"),
    (EndPlane((0, 0, 0), (1, 0, 0), SOURCE), "other"),
    (Camber("v", 1000, 5, SOURCE), "other"),
)


@pytest.mark.parametrize(("feature", "name"), FEATURES, ids=lambda v: v if type(v) is str else "")
def test_each_feature_is_made_by_one_kind_of_work(feature: Feature, name: str) -> None:
    assert kind_of(feature).name == name


def test_no_feature_of_the_model_is_without_a_kind() -> None:
    assert {type(feature) for feature, _ in FEATURES} == set(get_args(Feature))


def test_kinds_and_their_reasons_are_told_apart() -> None:
    for names in ([kind.name for kind in KINDS], [c for kind in KINDS for c in kind.reasons]):
        assert [name for name, count in Counter(names).items() if count > 1] == []


def room_of(frame: FrameType) -> str | None:
    """The module or package of planning that a call is in, or where it came from."""
    words = str(frame.f_globals.get("__name__", "")).split(".")
    return words[2] if words[:2] == ["beamcam", "planning"] and len(words) > 2 else None


def walked(parts: Any) -> set[tuple[str, str, str]]:
    """The rooms that planning a bar enters: from which room, into which, for which function."""
    steps: set[tuple[str, str, str]] = set()

    def look(frame: FrameType, event: str, _: object) -> None:
        into = room_of(frame) if event == "call" else None
        if into and frame.f_back and not frame.f_code.co_name.startswith("<"):
            out_of = room_of(frame.f_back)
            if out_of not in (None, into):
                steps.add((str(out_of), into, frame.f_code.co_name))

    before = sys.getprofile()
    sys.setprofile(look)
    try:
        plan_bar(parts, load("beamline"), skips=SKIP_NAMES)
    finally:
        sys.setprofile(before)
    return steps


def all_work() -> Iterator[Hole | Slot | Contour]:
    yield from (hole(500), hole(700, face="o", y=40.0), hole(700, face="u", y=40.0))
    yield hole(900, diameter=60)
    yield Slot("v", 1300, 150, 20, 40, 0, 0, SOURCE)


def test_a_part_enters_few_rooms_of_planning_and_returns_seldom() -> None:
    steps = walked((part(*all_work(), cuts=EndCuts(web_end=30.0)),))
    assert {"operations", "nesting", "order", "axis_limits"} <= {into for _, into, _ in steps}
    assert len({into for _, into, _ in steps}) <= 8
    assert len(steps) <= 14
