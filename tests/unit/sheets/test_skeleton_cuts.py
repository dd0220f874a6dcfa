"""Skeleton cuts: what is left of a sheet falls into strips between its rows, last of all."""

import re

import pytest
import shapely

from beamcam.checks.sheets.compare import verify_sheet
from beamcam.machine import Machine, load
from beamcam.machine.overlay import with_torch
from beamcam.model.request import Request
from beamcam.pipeline import post, read_back
from tests.conftest import sampled
from tests.unit.sheets.test_common_cuts import (
    KERF,
    blocks_of,
    drawn,
    parts_are_exact,
    random_nest,
)
from tests.unit.sheets.test_feeds import strokes

LONG, WIDE = 420.0, 600.0
SHEET = shapely.box(0, 0, LONG, WIDE)


def sheet_of(**values: object) -> Machine:
    asked = {"skeleton_cuts": True, "sheet_size": (LONG, WIDE), **values}
    return with_torch(load("plate-linuxcnc"), thickness=3.0, **asked)  # type: ignore[arg-type]


def strips(text: str) -> list[shapely.Polygon]:
    """What is left of the sheet from its one edge to the other, by the beam's band."""
    ways = [[p for points, _ in stroke for p in points] for stroke in strokes(text)]
    band = shapely.union_all([shapely.LineString(w).buffer(KERF / 2) for w in ways])
    pieces = shapely.get_parts(SHEET.difference(band))
    return [p for p in pieces if p.bounds[0] < 0.1 and p.bounds[2] > LONG - 0.1]


@pytest.mark.parametrize("seed", sampled(range(15), 2))
def test_strips_fall_and_parts_are_exact(seed: int) -> None:
    parts = random_nest(seed)
    posted = post(parts, sheet_of())
    parts_are_exact(posted)
    rows = {round(drawn(p.part, p.place).bounds[1], 2) for p in posted.plan.pieces}
    assert len(strips(posted.text)) == len(rows) + 1
    assert not read_back(posted.text, Request(tuple(parts), sheet_of()))
    whole = post(parts, sheet_of(skeleton_cuts=False))
    assert posted.text.startswith(whole.text[: whole.text.rindex("G0 X0 Y0")])


def test_mutants_are_refused() -> None:
    """A cut through the skeleton left out, doubled, elsewhere, shorter, or before a part."""
    parts, machine = random_nest(3), sheet_of()
    text = post(parts, machine).text
    every = blocks_of(text)
    last = every[-1]
    assert re.search(rf"X(0|{LONG:g}) ", last)
    wrong = {
        "left out": (text.replace(last, ""), "verify-sheet-missing"),
        "doubled": (text.replace(last, last * 2), "verify-sheet-twice"),
        "before a part": (
            text.replace(last, "").replace(every[0], last + every[0]), "verify-sheet-order",
        ),
        "elsewhere": (
            text.replace(last, re.sub(r"Y([\d.]+)", lambda m: f"Y{float(m[1]) - 3}", last)),
            "verify-sheet-extra",
        ),
        "shorter": (text.replace(last, last.replace(f"X{LONG:g}", "X300")), "verify-sheet-missing"),
    }  # fmt: skip
    for what, (mutant, code) in wrong.items():
        assert mutant != text, what
        assert code in {d.code for d in verify_sheet(mutant, parts, machine)}, what
    assert verify_sheet(text, parts, sheet_of(skeleton_cuts=False))


def test_none_where_there_is_no_room() -> None:
    parts = random_nest(3)
    with_cuts, without = (
        post(parts, sheet_of(skeleton_cuts=asked, common_cuts=True)).text for asked in (True, False)
    )
    assert with_cuts == without
