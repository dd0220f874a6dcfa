"""Each rule of the read-back: a program that keeps it, one that breaks it, and what is said."""

import re
from pathlib import Path

import pytest
from msgspec.structs import replace

from beamcam.checks import rules
from beamcam.checks.bars import verify
from beamcam.geometry.curves import Line
from beamcam.model.part import Contour, Slot, TextMark
from beamcam.pipeline import post
from tests.conftest import rules_of
from tests.unit.checks.programs import (
    ANNEX,
    BEAM,
    PART,
    PROGRAM,
    SOURCE,
    edit,
    hole,
    messages,
    part,
)


def test_a_right_program_raises_nothing() -> None:
    assert messages(PROGRAM) == []


Change = tuple[str, str]

#: What is changed in the program, and every line that is said about it.
BROKEN: list[tuple[str, list[Change], list[str]]] = [
    ("glued words", [("N9 M03", "N9 M 03")], [
        "P1.gcode:10: error verify-syntax: found 'M'; "
        "expected a letter and a number, set off by spaces",
        "P1.gcode:12: error verify-spindle-off: found a feed into the material on face v with the "
        "spindle standing; expected it turning",
    ]),
    ("two commands", [("N1 G90", "N1 G90 M08")], [
        "P1.gcode:2: error verify-syntax: found 'M08'; "
        "expected one command a block, G90 stands there already",
    ]),
    ("a letter nobody knows", [("Y20 Z-5\nN8", "Y20 Z-5 S1\nN8")], [
        "P1.gcode:8: error verify-syntax: found 'S1'; expected a word that the controller knows",
        "P1.gcode:9: error verify-sideways: found a move of X with the tool of face v at Z 42.2; "
        "expected it drawn back",
    ]),
    ("a word of another machine", [("N2 M44", "N2 M46")], [
        "P1.gcode:3: error verify-word: found M46; "
        "expected a word of this machine: M03, M05, M06, M08, M09, M30, M40, M42, M43, M44",
        "P1.gcode:6: error verify-section: found no height, width; expected height, width before",
    ]),
    ("the end is missing", [("N25 M30\n%\n", "")], [
        "P1.gcode:25: error verify-end: found the end of the program; "
        "expected M30 once, as the last command",
    ]),
    ("a block behind the end", [("N25 M30\n", "N25 M30\nN26 G01 X3000\n")], [
        "P1.gcode:27: error verify-end: found a block behind the end of the program; "
        "expected M30 once, as the last command",
    ]),
    ("65 M words in a row", [("N25 M30\n", "M09\n" * 63 + "N25 M30\n")], [
        "P1.gcode:89: error verify-m-queue: found 65 M words in a row; expected at most 64",
    ]),
    ("an arc that is a line", [("N23 G00 X2022.02", "N23 G02 X2022.02 I5 J3 F41.667")], [
        "P1.gcode:24: error verify-arc: found an arc whose radii at start and end differ by "
        "512.6; expected one that start, end and centre agree on",
        "P1.nc1:1: error verify-cut-missing: found no cut of 0 degrees at X 2022.02 for the end "
        "of P1; expected one",
        "P1.gcode:25: error verify-cut-extra: found a cut of 0 degrees at X 1498.56; "
        "expected none there",
    ]),
    ("beyond an axis", [("Y-5 Z158.6\nN17", "Y-25 Z158.6\nN17")], [
        "P1.gcode:17: error verify-limit: found left drill horizontal at -25; "
        "expected -20 to 520",
        "P1.gcode:17: error verify-limit: found right drill horizontal at -25; "
        "expected -20 to 520",
    ]),
    ("beyond the saw", [("N24 M42 K0", "N24 M42 K61")], [
        "P1.gcode:25: error verify-limit: found saw rotation at 61; expected -45 to 60",
        "P1.gcode:25: error verify-cut-angle: found a cut of 61 degrees for the end of P1; "
        "expected 0",
    ]),
    ("the stop goes back", [("N25 M30", "N25 G00 X2000\nN26 M30")], [
        "P1.gcode:26: error verify-stop-back: found X 2000 after X 2022.02; "
        "expected the stop never to move back",
    ]),
    ("no spindle", [("N4 G00", "N4 G00 Y5 Z-5\nG00")], [
        "P1.gcode:5: error verify-no-spindle: found a move of Y or Z; "
        "expected a spindle to be chosen before",
    ]),
    ("the spindle stands", [("N17 M03 K568\n", "")], [
        "P1.gcode:19: error verify-spindle-off: found a feed into the material on face o with the "
        "spindle standing; expected it turning",
        "P1.gcode:19: error verify-spindle-off: found a feed into the material on face u with the "
        "spindle standing; expected it turning",
    ]),
    ("the spindle still turns", [("N14 M05\n", "")], [
        "P1.gcode:15: error verify-spindle-on: found the choice of a spindle with the spindle "
        "turning; expected it off",
        "P1.gcode:16: error verify-spindle-on: found a move of the bar with the spindle turning; "
        "expected it off",
    ]),
    ("it turns the other way", [("N9 M03", "N9 M04")], [
        "P1.gcode:10: error verify-word: found M04; "
        "expected a word of this machine: M03, M05, M06, M08, M09, M30, M40, M42, M43, M44",
        "P1.gcode:12: error verify-spindle-off: found a feed into the material on face v with the "
        "spindle standing; expected it turning",
    ]),
    ("dry drilling", [("N10 M08\n", "")], [
        "P1.gcode:11: error verify-coolant: found a feed into the material; "
        "expected the coolant on",
    ]),
    ("the coolant runs on", [("N21 M09\n", "")], [
        "P1.gcode:23: error verify-coolant: found a move of the bar; expected the coolant off",
        "P1.gcode:24: error verify-coolant: found a cut; expected the coolant off",
        "P1.gcode:25: error verify-coolant: found the end of the program; "
        "expected the coolant off",
    ]),
    ("rapid into the web", [("N11 G01", "N11 G00")], [
        "P1.gcode:12: error verify-rapid: found a rapid move to Z 61.409, 14.209 mm into the "
        "material; expected a feed",
        "P1.gcode:15: error verify-spindle-idle: found a drill 22 started and stopped without a "
        "stroke; expected a feed into the material between",
        "P1.nc1:30: error verify-hole-missing: found no hole 22 on face v of P1 at x 300, y 80; "
        "expected one at X 1098.56",
    ]),
    ("not drawn back", [("N12 G00 X1098.56 Y20 Z-5\n", "")], [
        "P1.gcode:14: error verify-spindle-stopped: found the spindle stopped with the tool of "
        "face v at Z 61.409, in the material; expected it drawn back before",
        "P1.gcode:15: error verify-sideways: found the choice of a spindle with the tool of face "
        "v at Z 61.409; expected it drawn back",
    ]),
    ("stopped at the bottom", [("N12 G00 X1098.56 Y20 Z-5\nN13 M09\nN14 M05\n",
                                "N13 M09\nN14 M05\nN12 G00 X1098.56 Y20 Z-5\n")], [
        "P1.gcode:14: error verify-spindle-stopped: found the spindle stopped with the tool of "
        "face v at Z 61.409, in the material; expected it drawn back before",
    ]),
    ("a rapid onto the web", [("N8 G00 X1098.56 Y20 Z42.2", "N8 G00 X1098.56 Y20 Z47.2")], [
        "P1.gcode:9: error verify-clearance: found a rapid move that ends 0.000 mm before face v; "
        "expected at least 5 mm",
    ]),
    ("too near beside the flange", [("N16 G00 X1498.56 Y-5", "N16 G00 X1498.56 Y-2")], [
        "P1.gcode:17: error verify-clearance: found a rapid move that ends 2.000 mm before face "
        "o; expected at least 5 mm",
    ]),
    ("too fast a spindle", [("N9 M03 K362", "N9 M03 K600")], [
        "P1.gcode:10: error verify-speed: found a speed of 600 rpm for a drill 22; "
        "expected 150 to 435 rpm",
    ]),
    ("the feed of nothing", [("Y14.706 Z158.6 F1.895", "Y14.706 Z158.6")], [
        "P1.gcode:20: error verify-no-feed: found a stroke of a drill 14 without a feed; "
        "expected an F word" for _ in "ou"
    ]),
    ("a drill that creeps", [("F1.507", "F0.7")], [
        "P1.gcode:12: warning verify-feed: found a feed of 42 mm/min for a drill 22; "
        "expected about 90.43 mm/min",
    ]),
    ("sideways in the web", [("N12 G00 X1098.56 Y20 Z-5", "N12 G00 X1099.56 Y20 Z-5")], [
        "P1.gcode:13: error verify-spindle-on: found a move of the bar with the spindle turning; "
        "expected it off",
        "P1.gcode:13: error verify-coolant: found a move of the bar; expected the coolant off",
        "P1.gcode:13: error verify-sideways: found a move of X with the tool of face v at Z "
        "61.409; expected it drawn back",
    ]),
    ("no feed", [("N4 G00 X17.98", "N4 G01 X17.98")], [
        "P1.gcode:5: error verify-no-feed: found a move without a feed; expected an F word",
    ]),
    ("too fast a saw", [("N24 M42 K0 F41.667", "N24 M42 K0 F50")], [
        "P1.gcode:25: error verify-feed-limit: found a feed of 3000 mm/min for the saw; "
        "expected at most 2500 mm/min",
    ]),
    ("too fast a drill", [("F1.507", "F400")], [
        "P1.gcode:12: error verify-feed-limit: found a feed of 24000 mm/min for a drill 22; "
        "expected at most 108.6 mm/min",
    ]),
    ("another section", [("M44 K100 L200", "M44 K100 L220")], [
        "P1.gcode: error verify-section: found height 220; expected 200",
    ]),
    ("another profile", [("M43 K1", "M43 K2")], [
        "P1.gcode: error verify-section: found section 2; expected 1",
    ]),
    ("no parting cut", [("N24 M42 K0 F41.667\n", "")], [
        "P1.nc1:1: error verify-cut-missing: found no cut of 0 degrees at X 2022.02 for the end "
        "of P1; expected one",
    ]),
    ("a longer part", [("X2022.02", "X2025.02")], [
        "P1.gcode:25: error verify-cut-place: found the cut for the end of P1 at X 2025.02; "
        "expected X 2022.02",
    ]),
    ("a cut askew", [("N24 M42 K0", "N24 M42 K1")], [
        "P1.gcode:25: error verify-cut-angle: found a cut of 1 degrees for the end of P1; "
        "expected 0",
    ]),
    ("a cut too many", [("N15 M40", "N15 M42 K0 F41.667\nM40")], [
        "P1.gcode:16: error verify-cut-extra: found a cut of 0 degrees at X 1098.56; "
        "expected none there",
    ]),
    ("a hole elsewhere", [(f"N{n} G0{g} X1098.56 Y20", f"N{n} G0{g} X1098.56 Y25")
                          for n, g in ((7, 0), (8, 0), (11, 1), (12, 0))], [
        "P1.gcode:12: error verify-hole-place: found the hole 22 on face v of P1 at x 300, y 75; "
        "expected it at x 300, y 80",
    ]),
    ("one flange only", [("M40 K13", "M40 K1")], [
        "P1.nc1:32: error verify-hole-missing: found no hole 14 on face u of P1 at x 700, y 30; "
        "expected one at X 1498.56",
    ]),
    ("a shallow hole", [("Z61.409", "Z55")], [
        "P1.gcode:12: error verify-depth: found the hole 22 on face v of P1 at x 300, y 80 "
        "made 1.191 mm deep; expected at least 5.600",
    ]),
    ("a deep hole", [("Y14.706", "Y20")], [
        f"P1.gcode:20: error verify-depth: found the hole 14 on face {face} of P1 at x 700, y 30 "
        "made 15.794 mm deep; expected at most 10.500" for face in "ou"
    ]),
    ("another drill", [("K2 L22", "K2 L24"), ("F1.507", "F1.547")], [
        "P1.gcode:12: error verify-tool: found a drill 24 for the hole 22 on face v of P1 "
        "at x 300, y 80; expected a drill 22",
    ]),
    ("a drill that nobody has", [("K2 L22", "K2 L22.2")], [
        "P1.gcode:7: error verify-no-tool: found a drill 22.2 chosen; expected a tool that the "
        "shop has, the nearest is 22",
        "P1.gcode:12: error verify-tool: found a drill 22.2 for the hole 22 on face v of P1 "
        "at x 300, y 80; expected a drill 22, the shop has none of that size",
    ]),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "said"), [b[1:] for b in BROKEN], ids=[b[0] for b in BROKEN])
def test_what_is_said(changes: list[Change], said: list[str]) -> None:
    assert messages(edit(*changes)) == said


def test_a_hole_twice_is_one_too_many() -> None:
    block = PROGRAM[PROGRAM.index("N6 M40") : PROGRAM.index("N15")]
    assert messages(PROGRAM.replace("N15 M40", block + "N15 M40")) == [
        "P1.gcode:21: error verify-hole-extra: found a hole 22 on face v at X 1098.56, y 80; "
        "expected none there"
    ]


def test_any_drill_within_the_fit_will_do() -> None:
    wide = part(hole("v", 300.0, 80.0, 21.9), *PART.features[1:])  # type: ignore[arg-type]
    drills = BEAM.tools[0]
    more = replace(drills, diameters=(*drills.diameters, 22.25))
    text = edit(("K2 L22", "K2 L22.25"), ("Z61.409", "Z61.484"), ("F1.507", "F1.49"))
    assert messages(text, wide, machine=replace(BEAM, tools=(more,))) == []


def test_features_that_nothing_makes() -> None:
    slot = Slot("v", 500.0, 100.0, 18.0, 30.0, 0.0, 0.0, SOURCE)
    text = TextMark("v", 500.0, 100.0, 0.0, 10.0, "P1", SOURCE)
    corners = (
        (0.0, 0.0), (2000.0, 0.0), (2000.0, 200.0), (60.0, 200.0), (60.0, 150.0), (0.0, 150.0)
    )  # fmt: skip
    curves = tuple(Line(a, b) for a, b in zip(corners, (*corners[1:], corners[0]), strict=True))
    cope = Contour("v", "outer", curves, SOURCE)
    more = part(*PART.features, slot, text, cope)  # type: ignore[arg-type]
    assert [str(d) for d in verify(PROGRAM, (more,), BEAM)] == [
        "P1.nc1:1: warning verify-by-hand: found nothing that makes the text 'P1' on face v at x "
        "500, y 100 of P1; it is left for manual work, as beamline says",
        "P1.nc1:1: error verify-not-made: found nothing that makes the slot 48 x 18 of "
        "P1; "
        "expected it to be made, or skipped by name",
        "P1.nc1:1: error verify-outline: found an outline on face v of P1 that leaves the sawn "
        "stock at x 60, y 150; expected none that saw cuts do not make",
    ]
    allowed = verify(PROGRAM, (more,), BEAM, ("slot", "mark", "cope"))
    assert sorted(said.code for said in allowed) == ["verify-by-hand", *["verify-left-out"] * 2]
    told = verify(PROGRAM, (more,), BEAM, ("slot", "mark"))
    left = ["verify-by-hand", "verify-left-out"]
    assert sorted(said.code for said in told) == [*left, "verify-outline"]


def test_a_tool_that_no_station_holds() -> None:
    """Six drills for five stations: the sixth needs a stop, and which one goes is not written."""
    sizes = (10, 12, 14, 16, 18, 20, 10)
    holes = [hole("v", 300.0 + 100 * i, 80.0, float(d)) for i, d in enumerate(sizes)]
    made = part(*holes)
    text = post((made,), BEAM).text
    assert text.count("M06 K2") == 1
    assert verify(text, (made,), BEAM) == ()
    without = "\n".join(line for line in text.split("\n") if " M06 " not in line)
    assert [str(said).split(": ", 1)[1] for said in verify(without, (made,), BEAM)] == [
        "error verify-tool-change: found a drill 20 chosen on spindle 2; expected a stop before "
        "that puts it into one of the 5 stations",
        "error verify-stop-comment: found 'web station 2: drill 20 for drill 12' and no stop "
        "behind it; expected a stop of its own",
    ]
    stop = next(line for line in text.split("\n") if " M06 " in line)
    (idle, _) = verify(text.replace(stop, f"{stop}\n{stop}"), (made,), BEAM)
    assert idle.message == (
        "found a stop for a tool of 20 on spindle 2; expected a stroke behind it with such a tool "
        "that was not there before"
    )


def test_what_a_program_alone_leaves_open() -> None:
    assert [str(said) for said in verify(PROGRAM, (), BEAM, name="P1.gcode")] == [
        "P1.gcode: note verify-unseen: how far face v lies below the flanges is not in the "
        "program, so rapids towards it were not checked; give the parts by --against",
        "P1.gcode: note verify-unknown-steel: the program does not name the steel, so feeds "
        "and speeds were compared with the highest that the machine has for any; give the parts "
        "by --against",
    ]
    annex = verify("N1 G90\nN2 M30\n", (), ANNEX)
    assert "verify-unknown-steel" not in {said.code for said in annex}  # it carries no feeds


@pytest.mark.parametrize("code", [
    "verify-spindle-stopped", "verify-speed", "verify-no-feed", "verify-feed-limit",
    "verify-sideways", "verify-spindle-off", "verify-coolant", "verify-spindle-on", "verify-end",
])  # fmt: skip
def test_what_breaks_tools_is_said_without_parts(code: str) -> None:
    told = [b for b in BROKEN if any(code in line for line in b[2])]
    assert told
    for _, changes, _ in told:
        assert code in {said.code for said in verify(edit(*changes), (), BEAM)}


def test_a_hole_behind_its_cut_where_the_drill_comes_first() -> None:
    layout = replace(BEAM.layout, order="drill-saw")  # type: ignore[type-var]
    machine = replace(BEAM, layout=layout)
    assert messages(PROGRAM, machine=machine) == []
    start = PROGRAM.index("N15 M40")
    cycle = PROGRAM[start : PROGRAM.index("N23")]
    late = PROGRAM.replace(cycle, "").replace("N25 M30", cycle + "N25 M30")
    assert (
        messages(late, machine=machine)
        == [
            "P1.gcode:22: error verify-cut-off: found a hole at X 1498.56 in a part that the cut "
            "on line 17 has already parted; expected it before"
        ]
        * 2
    )


def test_the_words_are_those_of_the_machine() -> None:
    assert "P1.gcode:6: error verify-word: found M42; " in messages(PROGRAM, machine=ANNEX)[1]


def test_every_rule_has_a_test_of_its_message() -> None:
    """Each code stands, as a whole message has it, in one of the tests."""
    folder = Path(__file__).parents[2]
    texts = "".join(path.read_text("utf-8") for path in sorted(folder.rglob("test_*.py")))
    for rule in rules_of(rules):
        said = {
            "verify-unseen": "how far", "verify-unknown-steel": "the program",
            "verify-bar-needed": "the length",
        }.get(rule.code, "found")  # fmt: skip
        assert re.search(rf"[ \"]{rule.code}: {said}", texts), rule.code
