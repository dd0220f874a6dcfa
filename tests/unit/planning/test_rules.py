"""Every message of the planner, as it stands on the screen."""

import importlib
import pkgutil
from unittest.mock import patch

import pytest
from msgspec.structs import replace

from beamcam import planning
from beamcam.errors import PlanError
from beamcam.geometry.curves import Line
from beamcam.machine import load
from beamcam.machine.stations import Marks
from beamcam.model.part import Bend, Bevel, Contour, EndCuts, Part, Profile, Slot, TextMark
from beamcam.model.plan import SKIP_NAMES
from beamcam.planning import lettering, lettering_room
from beamcam.planning.beam import plan_bar, plan_oriented
from beamcam.planning.operations import part_planner, slot
from tests.conftest import SAMPLES, rules_of
from tests.unit.planning.shop import ANGLE, BEAM, CHANNEL, SOURCE, TUBE, hole, part

#: Of bars; sheets and copers have rules and cases of their own, and so have maps and what is left
#: out.
OTHERS = ("contours", "coping")
RULES = [
    rule
    for module in pkgutil.walk_packages(planning.__path__, "beamcam.planning.")
    if not module.name.startswith(tuple(f"beamcam.planning.{own}" for own in OTHERS))
    for rule in rules_of(importlib.import_module(module.name))
    if not (module.name == "beamcam.planning.left_out" and not rule.code.startswith("plan-text"))
]

Points = tuple[tuple[float, float], ...]


def outline(points: Points, **more: object) -> Contour:
    """An outer contour on v through points, closed."""
    chain = tuple(Line(a, b) for a, b in zip(points, (*points[1:], points[0]), strict=True))
    return Contour("v", "outer", chain, SOURCE, **more)  # type: ignore[arg-type]


SQUARE: Points = ((0, 0), (3000, 0), (3000, 300), (0, 300))
SKEW: Points = ((0, 0), (3000, 0), (2900, 300), (0, 300))
COPED: Points = ((0, 0), (3000, 0), (3000, 260), (2900, 260), (2900, 300), (0, 300))
LINE = Contour("v", "open", (Line((100, 50), (200, 50)),), SOURCE, "mark", False)
HOUSE = Contour("v", "inner", (Line((1, 2), (61, 2)), Line((61, 2), (1, 42)),
                               Line((1, 42), (1, 2))), SOURCE)  # fmt: skip
THREAD = hole(500, diameter=16, kind="thread", depth=2.0)
MITRED = part(cuts=EndCuts(web_start=30.0, web_end=30.0))

PUSHER = load("beamline-pusher")
STAMP = str(SAMPLES / "machines" / "beamline-stamp.toml")
HEB400 = Profile("I", "HEB400", 400.0, 300.0, 24.0, 13.5, 27.0)

#: Code, machine, parts and options, and the message.
Case = tuple[str, str, tuple[Part, ...], dict[str, object], str]
CASES: tuple[Case, ...] = (
    ("plan-no-parts", "beamline", (), {}, "found no part; expected at least one"),
    ("plan-stock", "beamline", (part(profile=TUBE),), {},
     "found a part of profile code M; expected I, U, L, which beamline takes"),
    ("plan-unrolled", "beamline-pusher",
     (part(profile=Profile("B", "O76.1*4", 239.08, 0.0, 0.0, 4.0)),), {},
     "found the profile O76.1*4, a pipe written as a plate; expected a flat bar, or a pipe of "
     "profile code RO"),
    ("plan-mixed-profiles", "beamline", (part(), part(profile=CHANNEL)), {},
     "found profile UPN200; expected IPE300, as the first part on the bar"),
    ("plan-section", "beamline", (part(profile=replace(BEAM, height=1005.0)),), {},
     "found a section of 1005 x 150 mm; expected at most 1000 x 500 mm (height x width), "
     "which the drill takes"),
    ("plan-no-saw", "uncut", (part(), part()), {},
     "found 2 parts for one bar; expected one, uncut has no saw and takes parts that are cut"),
    ("plan-no-work", "uncut", (part(),), {},
     "found no work on the part; expected a hole or another feature, uncut has no saw"),
    ("plan-comes-cut", "uncut", (part(hole(500)),), {},
     "the part is expected cut to 3000.000 mm with finished ends; uncut has no saw"),
    ("plan-saw-angle", "beamline", (part(cuts=EndCuts(web_end=-50.0)),), {},
     "found a cut of -50 degrees at the end; expected one from -45 to 60, as far as the saw turns"),
    ("plan-cut-noise", "beamline", (part(cuts=EndCuts(flange_start=-0.11)),), {},
     "found a flange cut of -0.11 degrees at the start; below 0.2 degrees an end is sawn square"),
    ("plan-flange-cut", "beamline", (part(cuts=EndCuts(flange_start=10.0)),), {},
     "found a flange cut of 10 degrees at the start; expected 0, the blade does not tilt"),
    ("plan-flange-cut", "beamline-pusher", (part(cuts=EndCuts(flange_start=-70.0)),), {},
     "found a flange cut of -70 degrees at the start; expected one from -65 to 65"),
    ("plan-compound", "simple", (part(cuts=EndCuts(web_end=10.0, flange_end=20.0)),), {},
     "found a cut of 10 degrees on the web and 20 on the flange at the end; expected one of them, "
     "the saw cannot turn and tilt at once"),
    ("plan-cut-denied", "beamline", (part(outline(SKEW), cuts=EndCuts(web_end=-9.0)),), {},
     "found a web cut of -9 degrees at the end; expected 18.435, which the contour has"),
    ("plan-cut-from-contour", "beamline", (part(outline(SKEW)),), {},
     "found no web cut in the header at the end; the contour's 18.435 degrees are sawn"),
    ("plan-bar-short", "beamline", (part(length=1000.0),), {"bar": 1024.04},
     "found a bar of 1024.040 mm; expected at least 1200 mm, give --bar if the stock is longer"),
    ("plan-bar-long", "beamline-pusher", (part(length=15400.0),), {},
     "found a bar of 15696.600 mm; expected at most 15500 mm"),
    ("plan-bar-full", "beamline-pusher", (part(),), {"bar": 3200.0},
     "found parts, kerfs, trims and dead zone of 3296.600 mm; expected at most the bar's "
     "3200.000 mm"),
    ("plan-part-short", "beamline-pusher", (part(length=100.0),), {},
     "found a part of 100.000 mm; expected at least 120 mm"),
    ("plan-remnant", "beamline-pusher", (part(),), {"bar": 6000.0},
     "a remnant of 2983.400 mm is long enough to go back to stock"),
    ("plan-tool", "beamline", (part(hole(500, diameter=51)),), {},
     "found a through hole of diameter 51 on face v; expected a hole near a drill of 50 or 49"),
    ("plan-tool", "beamline", (part(hole(500, diameter=16, kind="thread")),), {},
     "found a thread hole of diameter 16 on face v; expected none, the machine has no tap"),
    ("plan-tool", "beamline-pusher", (part(hole(500, diameter=18, kind="thread")),), {},
     "found a thread hole of diameter 18 on face v; "
     "expected one of M6, M8, M10, M12, M16, M20, M24, M30"),
    ("plan-tool", "beamline-pusher",
     (part(hole(500, diameter=12), hole(500, diameter=23, kind="countersink", depth=4.0)),), {},
     "found a countersink hole of diameter 23 on face v; "
     "expected one that the countersinks 11, 15, 18, 20, 26, 32, 33, 40, 50 make"),
    ("plan-countersink", "beamline-pusher", (part(hole(500, kind="countersink", angle=90.0)),), {},
     "found a countersink of diameter 18 on face v at x 500, y 150; "
     "expected a hole to sink at that place"),
    ("plan-sink-depth", "beamline-pusher",
     (part(hole(500, diameter=12), hole(500, kind="countersink", diameter=20.0, depth=2.0,
                                        angle=90.0)),), {},
     "found a countersink of diameter 20 and depth 2 on face v; "
     "expected a depth of at least 4.00 for that cone and hole"),
    ("plan-thread-depth", "beamline-pusher", (part(THREAD),), {},
     "found a thread of depth 2 on face v; "
     "expected at most 0.0, the tapping drill would come through"),
    ("plan-duplicate", "beamline", (part(hole(500), hole(500.005)),), {},
     "found a hole of diameter 18 on face v at x 500.005, y 150 a second time; "
     "it is drilled once, for p.nc1:7"),
    ("plan-face", "beamline", (part(hole(500, face="h", kind="blind", depth=4.0)),), {},
     "found a blind hole on face h; expected one of o, v, u"),
    ("plan-off-face", "beamline", (part(hole(500, 301)),), {},
     "found a hole at x 500, y 301 on face v; expected it within 3000 x 300 mm"),
    ("plan-reach", "beamline", (part(hole(500, 19.0)),), {},
     "found a hole of diameter 18 at y 19 on face v; expected y from 19.7 to 280.3, "
     "the flange is in the tool's way"),
    ("plan-reach", "beamline", (part(hole(500, 12.0), profile=ANGLE),), {},
     "found a hole of diameter 18 at y 12 on face v; expected y from 21 to 141, "
     "the flange is in the tool's way"),
    ("plan-reach", "beamline-pusher",
     (part(replace(LINE, curves=(Line((100, 50), (200, 5)),)), profile=ANGLE),),
     {}, "found 109.659 mm of line to mark at y 5 on face v; expected y from 12 to 150, "
     "the flange is in the tool's way"),
    ("plan-stroke", "beamline-annex", (part(hole(500, 200, 22), profile=HEB400),), {},
     "found a stroke to 6.750 mm below face v, the same for every hole; "
     "expected at least 20.109 mm for a hole of diameter 22"),
    ("plan-stroke", "beamline-annex", (part(hole(500, 150, kind="blind", depth=4.0)),), {},
     "found a stroke to 78.550 mm below face v, the same for every hole; "
     "expected 9.408 mm for a hole of diameter 18"),
    ("plan-reach", "beamline-pusher", (part(replace(LINE, curves=(Line((100, 50), (200, 5)),))),),
     {}, "found 109.659 mm of line to mark at y 5 on face v; expected y from 10.7 to 289.3, "
     "the flange is in the tool's way"),
    ("plan-hole-crowd", "crowded", (part(*(hole(500 + 5 * k) for k in range(3))),), {},
     "found 3 pairs of holes that stand within 21 mm of each other along the part, most of them "
     "about this one; expected at most 2"),
    ("plan-slot-crowd", "crowded",
     (part(*(Slot("v", 500 + k, 150, 18, 20, 0, 0, SOURCE) for k in range(3))),), {},
     "found the pair of holes and slots side by side that is one too many; expected at most 2 on "
     "a part"),
    ("plan-too-near", "beamline-annex", (part(hole(500), hole(500.12, 150.05)),), {},
     "found a hole of diameter 18 on face v at x 500.12, y 150.05, 0.13 mm from that of p.nc1:7; "
     "expected the same place, or one more than 0.2 mm away"),
    ("plan-axis", "beamline-pusher",
     (part(replace(LINE, face="o", curves=(Line((100, 50), (200, -12)),))),), {},
     "found a line to mark on face o that takes the left drill vertical to 200.600; "
     "expected -320 to 200"),
    ("plan-stop", "behind", (part(hole(60, diameter=100)),), {},
     "found a hole of diameter 100 on face v of P1 that takes the pusher to 35.000; "
     "expected at least 50"),
    ("plan-slot", "beamline", (part(Slot("v", 500, 150, 22, 40, 0, 0, SOURCE)),), {},
     "found a slot of 62 x 22 mm on face v; expected no slot, the machine has no mill"),
    ("plan-slot", "beamline-pusher", (part(Slot("v", 500, 150, 6, 40, 0, 0, SOURCE)),), {},
     "found a slot of 46 x 6 mm on face v; expected one at least 8 wide, as the smallest mill"),
    ("plan-slot", "beamline-pusher",
     (part(Slot("v", 500, 150, 22, 40, 0, 0, SOURCE, kind="countersink")),), {},
     "found a slot of 62 x 22 mm on face v; expected a slot without a countersink"),
    ("plan-cope", "beamline", (part(outline(COPED)),), {},
     "found a contour on face v that leaves the straight stock at x 2900, y 260; "
     "expected straight edges and saw cuts"),
    ("plan-cutout", "beamline", (part(HOUSE),), {},
     "found a cut-out of 60 x 40 mm on face v; expected none, the machine has no torch"),
    ("plan-mark", "beamline", (part(LINE),), {},
     'found 100 mm of line to mark on face v; expected none, marks.contours of the machine file is '
     '"refuse"'),
    ("plan-mark", "unit-less", (part(LINE),), {},
     "found 100 mm of line to mark on face v; expected none, the machine has no scribe for it"),
    ("plan-mark", "beamline", (part(hole(500, diameter=0, kind="mark")),), {},
     'found a centre punch to mark on face v; expected none, marks.points of the machine file is '
     '"refuse"'),
    ("plan-mark", "unit-less", (part(hole(500, diameter=0, kind="mark")),), {},
     "found a centre punch to mark on face v; expected none, the machine has no punch for it"),
    ("plan-mark", "silent", (part(TextMark("v", 9, 9, 0, 10, "X1", SOURCE)),), {},
     "found the text 'X1' to mark on face v; expected none, marks.text of the machine file is "
     '"refuse"'),
    ("plan-text-moved", "beamline-pusher",
     (part(hole(506, 105), TextMark("v", 500, 100, 0, 10, "X1", SOURCE)),), {},
     "the text 'X1' is lettered at x 516.7, y 100.0, 10.0 mm high; "
     "found no room 3 mm clear at x 500, y 100, 10 mm high"),
    ("plan-text-sign", "beamline-pusher", (part(TextMark("v", 9, 99, 0, 10, "½", SOURCE)),), {},
     "found '½' in the text '½'; expected a character of the font, '1/2' is written"),
    ("plan-text-height", STAMP, (part(TextMark("v", 500, 100, 0, 14, "X1", SOURCE)),), {},
     "found the text 'X1' 14 mm high; it is lettered 16 mm high, the nearest of the machine's"),
    ("plan-text-search", "hasty",
     (part(hole(506, 105), TextMark("v", 500, 100, 0, 10, "X1", SOURCE)),), {},
     "found no end of the search for a place of the text 'X1' on face v in 3 steps; expected room "
     'where the part has it, fewer texts, or text = "list" in [marks]'),
    ("plan-bevel", "beamline", (part(outline(SQUARE, bevels=(Bevel(1, 40.0, 0.0),))),), {},
     "found a bevel of 40 degrees on face v; expected none but those of the saw cuts"),
    ("plan-bevel-noise", "beamline",
     (part(outline(SQUARE, bevels=(Bevel(1, 0.06, 0.0), Bevel(2, -0.11, 0.0)))),), {},
     "found 2 bevel(s) of at most 0.11 degrees; below 0.2 degrees an edge is cut square"),
    ("plan-drill-size", "beamline", (part(hole(500, 100, 18.3), hole(600, 100, 18.3)),), {},
     "holes of diameter 18.3 are drilled with 18, 0.3 mm under"),
    ("plan-other", "beamline", (part(Bend((0, 1), (9, 1), 90, 5, SOURCE)),), {},
     "found a bend; expected none, the machine does not bend, camber or cut in space"),
    ("plan-quantity", "beamline", (part(quantity=3),), {},
     "found a quantity of 3; this program makes 1, --quantity file makes all"),
    ("plan-turned", "beamline", (part(cuts=EndCuts(web_end=-50.0)),), {"turn": True},
     "the part is turned over, end for end: as given it cannot be made (plan-saw-angle)"),
    ("plan-turn-helps", "beamline", (part(cuts=EndCuts(web_end=-50.0)),), {},
     "the machine can make the part turned 180 about its length; allow it by --turn"),
    ("plan-order", "beamline",
     (MITRED, replace(part(length=2000.0), mark="P2"), replace(MITRED, mark="P3")),
     {"order": "best"},
     "the parts lie in the order P1 P3 P2: 173.2 mm less bar than as given"),
    ("plan-reload", "beamline", (part(*(hole(500 + 100 * i, diameter=12 + i) for i in range(7))),),
     {},
     "found 7 tools for the 5 stations of spindle web; 2 must be changed manually during the work"),
    ("plan-section-shape", "beamline", (part(profile=replace(BEAM, web_thickness=0.0)),), {},
     "found a web thickness of 0 mm in a section of profile code I; "
     "expected walls that fit into each other"),
    ("plan-cuts-cross", "beamline", (part(cuts=EndCuts(45.0, -45.0), length=500.0),), {"bar": 9e3},
     "found end cuts that cross by 100.000 mm at y 0, z 0; "
     "expected the part to be longer than both mitres there"),
    ("plan-cuts-touch", "beamline", (part(cuts=EndCuts(45.0, -45.0), length=600.0),), {"bar": 9e3},
     "the end cuts meet in a point at y 0, z 0"),
    ("plan-saw-reach", "beamline", (part(cuts=EndCuts(50.0), profile=replace(BEAM, height=900.0)),),
     {}, "found a section of 900 x 150 mm at a cut of 50 degrees at the start; "
     "expected at most 500 x 500 mm (height x width), as the blade reaches at that angle"),
    ("plan-bar-left", "beamline", (part(), part(length=145.0)), {"bar": 3900.0},
     "found 875.960 mm of bar from the last part on; expected at least 1200 mm, "
     "give a longer --bar or another order of parts"),
    ("plan-off-part", "beamline", (part(hole(20, 40), cuts=EndCuts(30.0)),), {},
     "found a hole of diameter 18 at x 20, y 40 on face v that reaches 122 mm beyond the start of "
     "the part; expected it wholly within the finished part"),
    ("plan-off-part", "beamline", (part(hole(500, 5, face="o")),), {},
     "found a hole of diameter 18 at x 500, y 5 on face o that reaches 4 mm beyond the edge of "
     "face o; "
     "expected it wholly within the finished part"),
    ("plan-near-edge", "beamline", (part(hole(10)),), {},
     "found a hole of diameter 18 at x 10, y 150 on face v, 1 mm from the start of the part; "
     "expected at least 3 mm"),
    ("plan-near-edge", "beamline", (part(hole(500), hole(520)),), {},
     "found a hole of diameter 18 at x 520, y 150 on face v, 2 mm from a hole of diameter 18 of "
     "p.nc1:7; expected at least 3 mm"),
    ("plan-hole-overlap", "beamline", (part(hole(500), hole(510, diameter=22)),), {},
     "found a hole of diameter 22 at x 510, y 150 on face v, 10 mm from a hole of diameter 18 of "
     "p.nc1:7; expected at least 20 mm between their middles"),
    ("plan-wall", "beamline", (part(hole(500, 75, face="o")),), {},
     "found a hole of diameter 18 at x 500, y 75 on face o; "
     "expected it clear of the wall from y 71.45 to 78.55"),
    ("plan-fillet", "beamline", (part(hole(500, 92, face="o")),), {},
     "found a hole of diameter 18 at x 500, y 92 on face o where the root fillet is 4.34 mm high; "
     "expected at most 2 mm, the breakthrough behind the wall"),
    ("plan-fillet", "beamline", (part(hole(500, 20)),), {},
     "found a hole of diameter 18 at x 500, y 20 on face v where the root fillet is 12 mm high; "
     "expected at most 5 mm, the clearance of the rapid approach"),
    ("plan-near-fillet", "beamline", (part(hole(500, 26)),), {},
     "found a hole of diameter 18 at x 500, y 26 on face v, 8.7 mm into the root fillet; "
     "expected at least 0 mm from it"),
    ("plan-blind-depth", "beamline", (part(hole(500, kind="blind", depth=30.0)),), {},
     "found a hole of diameter 18 of depth 30 at x 500, y 150 on face v; "
     "expected at most 7.1 mm, the thickness of the wall"),
    ("plan-blind-shallow", "beamline", (part(hole(500, kind="blind", depth=1e-12)),), {},
     "found a hole of diameter 18 of depth 1e-12 at x 500, y 150 on face v; "
     "expected at least 0.001 mm, which programs of the machine can say"),
    ("plan-blind-point", "beamline", (part(hole(500, kind="blind", depth=4.0)),), {},
     "found a hole of diameter 18 of depth 4 at x 500, y 150 on face v; "
     "its point comes 2.31 mm through the wall of 7.1 mm"),
    ("plan-line-beyond", "beamline-pusher", (part(LINE, cuts=EndCuts(45.0)),), {},
     "found a line to mark on face v that goes 106 mm beyond the start of the part; "
     "expected it on the finished part"),
    ("plan-near-edge", "beamline-pusher",
     (part(hole(500), Slot("v", 520, 150, 18, 10, 0, 0, SOURCE)),), {},
     "found a slot of width 18 at x 520, y 150 on face v, 0 mm from a hole of diameter 18 of "
     "p.nc1:7; expected at least 3 mm"),
    ("plan-from-behind", "beamline", (part(hole(500, face="h")),), {},
     "found a hole of diameter 18 at x 500, y 150 on face h; it is made from face v"),
    ("plan-angle-face", "beamline", (part(hole(500, 50, face="o"), profile=ANGLE),), {},
     "found a hole of diameter 18 at x 500, y 50 on face o of an angle, which has faces v and u; "
     "it is made on face u"),
    ("plan-change-word", "wordless", (part(*(hole(500 + 100 * i, diameter=12 + i)
                                             for i in range(7))),), {},
     "found 7 tools for the 5 stations of spindle web; expected at most 5, as words.change of "
     "wordless is empty"),
    ("plan-grade", "beamline", (part(hole(500), grade="C45"),), {},
     "found steel grade C45, which no row of drill.cutting in beamline names; "
     "its rows for any grade are used"),
    ("plan-cutting-speed", "beamline", (part(hole(500, diameter=45), grade="1.4301"),), {},
     "found drill 45 in 1.4301, which should turn at 85 rpm; "
     "the spindle turns at 150 rpm at least"),
)  # fmt: skip

#: Machines that are the beamline but for what becomes of marks.
MARKS = {
    "unit-less": Marks(), "silent": Marks(text="refuse"), "wordless": Marks(),
    "uncut": Marks(),
}  # fmt: skip


def said(case: Case) -> list[tuple[str, str]]:
    """Code and text of everything that planning a case says."""
    _, name, parts, options, _ = case
    machine = load(
        {"simple": "beamline-pusher", "hasty": "beamline-pusher", "crowded": "beamline-pusher"}.get(
            name, "beamline" if name in MARKS else name
        )
        if name != "behind"
        else "beamline-pusher"
    )
    if name == "behind":  # the pusher does not come as far as that
        axes = tuple(replace(a, min=50.0) if a.moves == "X" else a for a in PUSHER.axes)
        machine = replace(PUSHER, axes=axes)
    if name in MARKS:
        machine = replace(machine, name=name, marks=MARKS[name])
    if name == "wordless":
        machine = replace(machine, name=name, words=replace(machine.words, change=()))
    if name == "uncut":
        machine = replace(machine, saw=None)
    if name == "simple":
        assert machine.saw is not None
        machine = replace(machine, saw=replace(machine.saw, compound=False))
    squares = 3 if name == "hasty" else lettering_room.MOST_SQUARES
    try:
        with (
            patch.object(lettering_room, "MOST_SQUARES", squares),
            patch.object(lettering, "MOST_SQUARES", squares),
            patch.object(part_planner, "MOST_PAIRS", 2 if name == "crowded" else 10**6),
            patch.object(slot, "MOST_PAIRS", 2 if name == "crowded" else 10**6),
        ):
            found = plan_oriented(parts, machine, **options).remarks  # type: ignore[arg-type]
    except PlanError as error:
        found = error.diagnostics
    return [(d.code, d.message) for d in found]


@pytest.mark.parametrize("case", CASES, ids=[f"{c[0]}-{i}" for i, c in enumerate(CASES)])
def test_message(case: Case) -> None:
    code, _, _, _, text = case
    assert (code, text) in said(case)


def test_every_rule_has_its_message_here() -> None:
    # What a machine's file says of faces is checked without a part (test_machines_check.py), a part
    # that is begun in unit/coping/test_pieces.py, a remnant's text in test_over_stock.py.
    # Rounds as they are read stand in test_round_bars.py, openings in others in
    # property/test_within.py, planes that take nothing in property/test_end_planes.py.
    elsewhere = {"machine-hand", "plan-begun", "batch-remnant", "plan-pipe", "plan-round",
                 "plan-within", "plan-opening-overlap", "plan-plane-nothing"}  # fmt: skip
    assert {case[0] for case in CASES} == {rule.code for rule in RULES} - elsewhere
    assert len({rule.code for rule in RULES}) == len(RULES)


@pytest.mark.parametrize("own", SKIP_NAMES)
def test_what_may_be_left_out_is_left_out_by_its_name_only(own: str) -> None:
    code = f"plan-{own}"
    _, name, parts, _, _ = next(c for c in CASES if c[0] == code)
    plan = plan_bar(parts, load(name), skips=(own,))
    assert [o.by for o in plan.outcomes if o.how == "skipped"] == [code]
    others = [n for n in SKIP_NAMES if n != own]
    with pytest.raises(PlanError):
        plan_bar(parts, load(name), skips=others)


def test_all_reasons_to_refuse_a_part_are_given_at_once() -> None:
    features = (
        hole(500, 301),
        hole(600, diameter=60),
        hole(700, face="h", kind="blind", depth=4.0),
    )
    with pytest.raises(PlanError) as caught:
        plan_bar([part(*features, cuts=EndCuts(web_end=-80.0))], load("beamline"))
    codes = [d.code for d in caught.value.diagnostics]
    assert codes == ["plan-saw-angle", "plan-off-face", "plan-tool", "plan-face"]
    assert [str(d.source) for d in caught.value.diagnostics] == ["p.nc1:7"] * 4


def test_a_short_part_without_a_bar_is_cut_from_the_usual_one() -> None:
    plan = plan_bar((part(length=320.0),), load("beamline"))
    assert plan.bar is not None
    assert plan.bar.length == 12000.0
    whole = plan_bar((part(length=3000.0),), load("beamline")).bar
    assert whole is not None
    assert whole.length < 3100.0
