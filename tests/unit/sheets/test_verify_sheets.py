"""Programs of tables read back: right ones pass, each fault has its code."""

import re
from collections.abc import Callable
from math import sqrt

import pytest
from msgspec.structs import replace

from beamcam.checks.sheets import grid, rules
from beamcam.checks.sheets.compare import verify_sheet
from beamcam.controllers.dialect import SHEET_RULES
from beamcam.errors import Rule, VerifyError
from beamcam.geometry.curves import Bezier, BSpline, Curve, EllipseArc, Line, NewtonCurve
from beamcam.machine import Machine
from beamcam.model.part import Bend, Hole, Part
from beamcam.pipeline import post
from tests.conftest import sampled
from tests.unit.sheets.parts import NESTED, S, box, circle, contour, drawing, lines, plate, table

KAPPA = 0.5522847498307936


def cubic_circle(x: float, y: float, r: float) -> tuple[Bezier, ...]:
    """A circle as CorelDRAW writes it."""
    k = KAPPA * r
    corners = [(r, 0.0, 0.0, 1.0), (0.0, r, -1.0, 0.0), (-r, 0.0, 0.0, -1.0), (0.0, -r, 1.0, 0.0)]
    found = []
    for (ax, ay, ux, uy), (bx, by, vx, vy) in zip(corners, corners[1:] + corners[:1], strict=True):
        found.append(
            Bezier(
                (
                    (x + ax, y + ay),
                    (x + ax + k * ux, y + ay + k * uy),
                    (x + bx - k * vx, y + by - k * vy),
                    (x + bx, y + by),
                )
            )
        )
    return tuple(found)


FREE = drawing(
    contour(box(0, 0, 300, 120)),
    contour(cubic_circle(40, 60, 25)),
    contour((EllipseArc((110, 60), (25.0, 8.0), 0.6, 0.0, 360.0),)),
    contour((Bezier(((150, 20), (190, 120), (230, 20))), Line((230, 20), (150, 20)))),
    contour((NewtonCurve(((240, 20), (260, 60), (280, 30))),), "#0000ff"),
    contour(
        (
            BSpline(
                3, ((150, 90), (170, 115), (190, 80), (210, 110), (230, 90)),
                (0, 0, 0, 0, 0.5, 1, 1, 1, 1),
            ),
        ),
        "#0000ff",
    ),
)  # fmt: skip

MACHINES = [
    ("plate-linuxcnc", {}),
    ("plate-linuxcnc", {"kerf_by": "machine", "lead": "line"}),
    ("plate-linuxcnc", {"kerf_by": "none", "lead": "none"}),
    ("plate-linuxcnc", {"tabs": 2}),
    ("plate-codesys", {}),
    ("plate-codesys", {"kerf_by": "none", "lead": "none", "tabs": 3}),
    ("plate-codesys", {"kerf_by": "machine", "lead": "line"}),
    ("laser-grbl", {"material": "wood"}),
    ("laser-grbl", {"material": "wood", "kerf": 0.2, "tabs": 4}),
]


#: Contours that say their process themselves, as those of DSTV and of the JSON form do.
PLAIN_PART = plate(
    contour(box(20, 20, 40, 40), None),
    contour(lines((80, 20), (120, 20), closed=False), None, process="powder"),
)


@pytest.mark.parametrize(
    "part", [NESTED, FREE, plate(), PLAIN_PART], ids=["nested", "free", "plate", "plain"]
)
@pytest.mark.parametrize(("name", "values"), MACHINES)
def test_what_is_posted_passes(name: str, values: dict[str, object], part: Part) -> None:
    posted = post((part,), table(name, **values))
    assert not [s for s in posted.remarks if s.code.startswith("verify")]


def alike(machine: Machine) -> Machine:
    """A laser that marks with the power it cuts with, so that the feed alone tells both apart."""
    assert machine.torch is not None
    rows = tuple(replace(row, power=1000.0) for row in machine.torch.rows)
    return replace(machine, torch=replace(machine.torch, rows=rows))


def test_processes_that_start_with_the_same_word_are_told_apart_by_their_feeds() -> None:
    machine = alike(table("laser-grbl", material="wood"))
    posted = post((FREE,), machine)
    all_cut = replace(FREE, features=tuple(replace(f, colour="#ff0000") for f in FREE.features))
    codes = {said.code for said in verify_sheet(posted.text, (all_cut,), machine)}
    assert codes >= {"verify-sheet-missing"}
    slower = re.sub(r"F3000(\.0*)?", "F2000", posted.text)
    assert slower != posted.text
    codes = {said.code for said in verify_sheet(slower, (FREE,), machine)}
    assert codes == {"verify-sheet-feed"}


def test_processes_may_share_a_word_that_starts_and_have_two_that_stop() -> None:
    machine = table("plate-codesys")
    words = replace(machine.words, cut_on=("M13", "G04 T{pierce}"))
    assert "M13" in post((FREE,), replace(machine, words=words)).text


def test_words_of_codesys() -> None:
    text = post((FREE,), table("plate-codesys", kerf_by="none", lead="none")).text
    assert len(re.findall(r"^N\d+ G06 ", text, re.M)) == 2
    assert len(re.findall(r"^N\d+ G0[89] ", text, re.M)) == 4
    assert "G06" not in post((FREE,), table()).text


def test_a_circle_of_cubics_is_two_arcs() -> None:
    part = drawing(contour(cubic_circle(40, 60, 25)))
    machine = table("plate-linuxcnc", kerf_by="none", lead="none", start="nearest")
    text = post((part,), machine).text
    assert len(re.findall(r"^G[23] ", text, re.M)) == 2
    assert "G1 " not in text


Change = Callable[[str], str]


def swap(old: str, new: str, count: int = 1) -> Change:
    def change(text: str) -> str:
        assert old in text, old
        return text.replace(old, new, count)

    return change


def without(pattern: str) -> Change:
    def change(text: str) -> str:
        found = re.search(pattern, text, re.M)
        assert found, pattern
        return text[: found.start()] + text[found.end() :]

    return change


def twice(text: str) -> str:
    """The block of the small hole once more, at the end of the marks."""
    block = re.search(r"^G0 X1[56]\d.*?\nM5\n", text, re.M | re.S)
    assert block
    return text[: block.end()] + block[0] + text[block.end() :]


def last_first(text: str) -> str:
    """The outline before all other cuts."""
    blocks = re.findall(r"^G0 X\S+ Y\S+\nM3.*?\nM5\n", text, re.M | re.S)
    assert len(blocks) == 4
    return text.replace(blocks[-1], "").replace(blocks[0], blocks[-1] + blocks[0])


def mark_last(text: str) -> str:
    block = re.search(r"^G0 X\S+ Y\S+\nM3 \$1.*?M5 \$1\n", text, re.M | re.S)
    assert block
    return text.replace(block[0], "").replace("G0 X0 Y0", block[0] + "G0 X0 Y0")


def more_tabs(text: str) -> str:
    """The first long line of the last contour in two strokes with a bridge between them."""
    lines = text.split("\n")
    last = max(k for k, line in enumerate(lines) if line == "F2300")
    k = next(k for k in range(last + 2, len(lines)) if lines[k].startswith("G1"))
    (x0, y0), (x1, y1) = (map(float, re.findall(r"[XY](\S+)", lines[j])) for j in (k - 1, k))
    length = abs(x1 - x0) + abs(y1 - y0)
    near, far = ((length / 4 + d) / length for d in (-1.2, 1.2))
    a, b = (f"X{x0 + s * (x1 - x0):.4f} Y{y0 + s * (y1 - y0):.4f}" for s in (near, far))
    bridge = [f"G1 {a}", "M5", f"G0 {b}", "M3 S1", "G4 P0.5", "F2300"]
    return "\n".join([*lines[:k], *bridge, *lines[k:]])


PLAIN = {"kerf_by": "none", "lead": "none"}
MUTANTS: list[tuple[str, dict[str, object], Change, str]] = [
    ("plate-linuxcnc", {}, swap("M5\n", ""), "verify-sheet-rapid"),
    ("plate-linuxcnc", {}, swap("M3 S1\n", ""), "verify-sheet-idle"),
    ("plate-linuxcnc", {}, swap("M3 S1", "M3 S2"), "verify-sheet-tool"),
    ("plate-linuxcnc", {}, swap("G4 P0.5", "G4 P0.1"), "verify-sheet-tool"),
    ("plate-linuxcnc", {}, swap("F2300", "F9000"), "verify-sheet-feed"),
    ("plate-linuxcnc", {}, without(r"^G1 X210.75.*\n"), "verify-sheet-missing"),
    ("plate-linuxcnc", PLAIN, without(r"^G1 X210 .*\n"), "verify-sheet-missing"),
    ("plate-linuxcnc", PLAIN, without(r"^G0 X\S+ Y\S+\nM3(.|\n)*?M5\n"), "verify-sheet-missing"),
    ("plate-linuxcnc", PLAIN, swap("G1 X190 Y30", "G1 X195 Y30"), "verify-sheet-extra"),
    ("plate-linuxcnc", PLAIN, swap("G1 X190 Y30", "G1 X185 Y30"), "verify-sheet-open"),
    ("plate-linuxcnc", PLAIN, twice, "verify-sheet-twice"),
    ("plate-linuxcnc", {}, twice, "verify-sheet-twice"),
    ("plate-linuxcnc", {}, last_first, "verify-sheet-order"),
    ("plate-linuxcnc", {}, mark_last, "verify-sheet-order"),
    ("plate-linuxcnc", {}, swap("G0 X0 Y0", "G0 X3100 Y0"), "verify-sheet-area"),
    ("plate-linuxcnc", {}, swap("M2\n", ""), "verify-sheet-end"),
    ("plate-linuxcnc", {}, swap("\nM5\nG0 X0 Y0", ""), "verify-sheet-end"),
    ("plate-linuxcnc", {}, swap("G91.1 ", ""), "verify-sheet-setting"),
    ("plate-linuxcnc", {}, swap("G64", "G65"), "verify-sheet-word"),
    ("plate-linuxcnc", {}, swap("M5", "M55"), "verify-sheet-word"),
    ("plate-linuxcnc", {}, swap("G0 X0", "G0 Z0 X0"), "verify-sheet-word"),
    ("plate-linuxcnc", {}, swap("(JOB)", "(JOB"), "verify-sheet-syntax"),
    ("plate-linuxcnc", {}, swap("%\n", ""), "verify-sheet-syntax"),
    ("plate-linuxcnc", {}, swap("G1 X", "G1 X1-"), "verify-sheet-syntax"),
    ("plate-linuxcnc", {}, swap("G1 X", "G1 X\u0661"), "verify-sheet-syntax"),
    ("plate-linuxcnc", {"kerf_by": "machine", "lead": "line"}, swap("G41.1", "G42.1"),
     "verify-sheet-side"),
    ("plate-linuxcnc", {"kerf_by": "machine", "lead": "line"}, swap("D1.5", "D2.5"),
     "verify-sheet-extra"),
    ("plate-linuxcnc", {"kerf_by": "machine", "lead": "line"}, swap("D1.5", "D0.9"),
     "verify-sheet-band"),
    ("plate-linuxcnc", {"kerf_by": "machine", "lead": "line"}, swap("D1.5", "D7"),
     "verify-sheet-compensation"),
    ("plate-linuxcnc", {"tabs": 2}, more_tabs, "verify-sheet-tabs"),
    ("laser-grbl", {"material": "wood"}, swap("(JOB)", "%"), "verify-sheet-syntax"),
    ("laser-grbl", {"material": "wood"}, swap("(JOB)", "(" + "J" * 90 + ")"),
     "verify-sheet-syntax"),
    ("plate-codesys", {}, swap("G90", "G91"), "verify-sheet-word"),
    ("plate-codesys", {}, without(r"^N1 G90\n"), "verify-sheet-setting"),
    ("plate-codesys", {}, swap("M30", "M31"), "verify-sheet-end"),
    ("plate-codesys", {}, swap(" E1000", " E3000"), "verify-sheet-ramp"),
    ("plate-codesys", {}, swap(" E-1000", " E-100"), "verify-sheet-ramp"),
    ("plate-codesys", {}, swap(" E-1000", ""), "verify-sheet-ramp"),
    ("plate-codesys", {}, swap(" E1000", " E0"), "verify-sheet-ramp"),
    ("plate-codesys", {}, without(r" F25\.\S+"), "verify-sheet-feed"),
    ("plate-codesys", {}, swap(" F35", " F30"), "verify-sheet-feed"),
    ("plate-linuxcnc", {}, swap("F2300", "F2300 E900"), "verify-sheet-word"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "values", "change", "code"), sampled(MUTANTS, 2))
def test_mutants(name: str, values: dict[str, object], change: Change, code: str) -> None:
    machine = table(name, **values)
    text = post((NESTED,), machine).text
    assert not verify_sheet(text, (NESTED,), machine)
    assert code in {said.code for said in verify_sheet(change(text), (NESTED,), machine)}


#: What is done to a program, and what is said of which contour.
NAMED: list[tuple[dict[str, object], Change, str]] = [
    (PLAIN, without(r"^G0 X\S+ Y\S+\nM3(.|\n)*?M5\n"),
     "cuts the contour of sheet.dxf:5 at x"),
    (PLAIN, swap("G1 X190 Y30", "G1 X195 Y30"), "nearest contour to mark, that of sheet.dxf:4;"),
    (PLAIN, swap("G1 X190 Y30", "G1 X185 Y30"), "in the middle of the contour of sheet.dxf:4;"),
    (PLAIN, twice,
     "the contour of sheet.dxf:5 at x 154.619, y 61.913 followed 2 times"),
    ({}, last_first, "the contour of sheet.dxf:5 after the contour of sheet.dxf:1 around it, cut "),
    ({}, mark_last, "work to mark the contour of sheet.dxf:4 after the cut on line"),
    ({"kerf_by": "machine", "lead": "line"}, swap("G41.1", "G42.1"),
     "on the part's side of the contour of sheet.dxf:5; expected it in the waste"),
    ({"kerf_by": "machine", "lead": "line"}, swap("D1.5", "D0.9"),
     "0.448 mm from the contour of sheet.dxf:5 at X"),
    ({"tabs": 2}, more_tabs, "found 3 bridge(s) in the contour of sheet.dxf:1; expected 2"),
]  # fmt: skip


@pytest.mark.parametrize(("values", "change", "text"), NAMED)
def test_a_message_names_the_contour(values: dict[str, object], change: Change, text: str) -> None:
    machine = table(**values)
    program = change(post((NESTED,), machine).text)
    found = [said.message for said in verify_sheet(program, (NESTED,), machine)]
    assert any(text in message for message in found), found


def test_a_message_names_the_plate_whose_outline_is_missing() -> None:
    machine, bare = table(), plate()
    program = post((bare,), machine).text
    (said,) = verify_sheet(without(r"^M3(.|\n)*M5\n")(program), (bare,), machine)
    assert "cuts the contour of p.nc1 at" in said.message


def shifted_arcs(text: str, name: str) -> str:
    """The first centre moved by 0.4 mm."""

    def moved(match: re.Match[str]) -> str:
        return f"I{float(match[1]) + 0.4:.4f}"

    return re.sub(r"\bI(\S+)", moved, text, count=1)


@pytest.mark.parametrize("name", ["plate-linuxcnc", "plate-codesys", "laser-grbl"])
def test_an_arc_that_does_not_fit(name: str) -> None:
    machine = table(name, start="nearest")
    text = shifted_arcs(post((NESTED,), machine).text, name)
    assert "verify-sheet-arc" in {s.code for s in verify_sheet(text, (NESTED,), machine)}


def test_a_flat_s_is_no_arc_of_a_large_radius() -> None:
    """A line in its place is a third of a millimetre off, though a circle of 400 mm is near."""
    points = ((10.0, 10.0), (9.0, 11.46), (8.75, 12.77), (7.57, 12.93))
    drawn = drawing(contour((Bezier(points),), "#0000ff"))
    straight = drawing(contour((Line(points[0], points[-1]),), "#0000ff"))
    machine = table(place="drawn")
    assert verify_sheet(post((drawn,), machine).text, (drawn,), machine) == ()
    said = verify_sheet(post((straight,), machine).text, (drawn,), machine)
    assert {d.code for d in said} == {"verify-sheet-missing", "verify-sheet-extra"}


def test_the_wrong_side_of_the_kerf() -> None:
    """A program whose holes are larger by the kerf and whose plates are smaller."""
    part = drawing(contour(box(0, 0, 100, 60)), contour(circle(50, 30, 20)))
    right, wrong = table(kerf=1.0, lead="none"), table(kerf=1.0, lead="none", margin=9.0)
    smaller = drawing(contour(box(1, 1, 98, 58)), contour(circle(50, 30, 22)))
    text = post((smaller,), table(kerf=1.0, lead="none", margin=11.0)).text
    del wrong
    assert "verify-sheet-side" in {s.code for s in verify_sheet(text, (part,), right)}


def test_a_lead_that_bites() -> None:
    """A lead of the outer contour that lies in the part."""
    machine: Machine = table(kerf=1.0, lead="line", start="straight")
    part = drawing(contour(box(0, 0, 100, 60)))
    text = post((part,), machine).text
    start = re.search(r"^G0 X(\S+) Y(\S+)\nM3", text, re.M)
    assert start
    x, y = float(start[1]), float(start[2])
    inner = (
        f"G0 X{x + 6:g} Y{y:g}\nM3" if x < 20 else f"G0 X{x:g} Y{y + (6 if y < 20 else -6):g}\nM3"
    )
    found = verify_sheet(text.replace(start[0], inner), (part,), machine)
    assert {s.code for s in found} & {"verify-sheet-lead", "verify-sheet-extra"}


def test_a_feature_that_nothing_makes() -> None:
    machine = table()
    text = post((plate(),), machine).text
    bent = plate(Bend((0, 0), (9, 0), 90.0, 3.0, S))
    (said,) = verify_sheet(text, (bent,), machine)
    assert (said.code, said.source) == ("verify-by-hand", S)
    assert machine.marks is not None
    machine = replace(machine, marks=replace(machine.marks, bends="refuse"))
    (said,) = verify_sheet(text, (bent,), machine)
    assert (said.code, said.source) == ("verify-sheet-not-made", S)
    (left,) = verify_sheet(text, (bent,), machine, ("other",))
    assert (left.code, left.source) == ("verify-left-out", S)


def test_what_is_written_to_three_decimals_is_read_back_so() -> None:
    """And of a kerf that is less than what a path may be off no side is told."""
    for name in ("plate-linuxcnc", "plate-codesys"):
        machine = table(name)
        assert machine.torch is not None
        rows = tuple(
            replace(row, feed_mm_min=16.0016, pierce_s=0.90091, power=1.00049, kerf=0.002)
            for row in machine.torch.rows
        )
        machine = replace(machine, torch=replace(machine.torch, rows=rows))
        assert not verify_sheet(post((NESTED,), machine).text, (NESTED,), machine)


@pytest.mark.parametrize("bound", ["MOST_NEAR", "MOST_MEASURED"])
def test_what_is_compared_is_bounded(bound: str, monkeypatch: pytest.MonkeyPatch) -> None:
    machine = table()
    text = post((NESTED,), machine).text
    monkeypatch.setattr(grid, bound, 10)
    monkeypatch.setattr(grid, "MOST_AT_A_POINT", 1)
    with pytest.raises(VerifyError, match="beside a contour, about X"):
        verify_sheet(text, (NESTED,), machine)


def test_every_rule_has_a_case() -> None:
    shown = {code for _, _, _, code in MUTANTS} | {
        "verify-sheet-arc", "verify-sheet-side", "verify-sheet-lead", "verify-sheet-not-made",
        "verify-sheet-crowded", "verify-sheet-settings", "verify-sheet-turn", "verify-sheet-hatch",
        "verify-sheet-other", "verify-sheet-overcut", "verify-sheet-tab-width",
        "verify-sheet-tab-place", "verify-sheet-hatch-way", "verify-sheet-radius",
        "verify-sheet-corner", "verify-sheet-end-skew", "verify-sheet-direction",
        "verify-sheet-restart", "verify-sheet-beside",
        "verify-sheet-laid", "verify-sheet-pierce", "verify-sheet-hole-feed",
        "verify-sheet-hole-lead", "verify-sheet-spot",
        "verify-sheet-contour", "verify-sheet-rest", "verify-sheet-edge",
        "verify-sheet-frame", "verify-sheet-overscan",
        # tests/unit/sheets/test_heights.py, test_outputs.py, tests/test_qtplasmac.py
        "verify-sheet-height", "verify-sheet-thc", "verify-sheet-output", "verify-sheet-material",
        "verify-sheet-dark",
        # tests/unit/sheets/test_chains.py
        "verify-sheet-link",
    }  # fmt: skip
    every = (*SHEET_RULES, *vars(rules).values())
    assert {rule.code for rule in every if isinstance(rule, Rule)} == shown


MARKED = plate(
    Hole("v", 60, 40, 14.0, S),
    Hole("v", 30, 40, 0.0, S, kind="mark"),
    Hole("v", 150, 40, 0.0, S, kind="mark"),
    contour(lines((20, 20), (120, 20), closed=False), None, process="punch"),
    contour(lines((20, 80), (120, 85), closed=False), None, process="powder"),
)


@pytest.mark.parametrize("name", ["plate-linuxcnc", "plate-codesys"])
def test_marks_of_a_plate_are_read_back(name: str) -> None:
    """A punched and a powdered line are a stroke each, a centre is two; none may be missing."""
    machine = table(name)
    text = post([MARKED], machine).text
    assert verify_sheet(text, [MARKED], machine) == ()
    begins = [k for k, line in enumerate(text.split("\n")) if re.search(r"M3 \$1 S1$|M13$", line)]
    assert len(begins) == 6
    lines_of = text.split("\n")
    for k in begins:
        end = next(i for i in range(k, len(lines_of)) if re.search(r"M5 \$1$|M15$", lines_of[i]))
        without = "\n".join([*lines_of[:k], *lines_of[end + 1 :]])
        assert "verify-sheet-missing" in {d.code for d in verify_sheet(without, [MARKED], machine)}
    unknown = table(name, cross=0.0)
    said = verify_sheet(text, [MARKED], unknown)
    assert {d.code for d in said} >= {"verify-sheet-not-made", "verify-sheet-extra"}


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ("F5200", "F5300", "verify-sheet-feed"),
        ("G4 P0.2", "G4 P0.9", "verify-sheet-tool"),
        ("G1 X", "G0 X", "verify-sheet-rapid"),
    ],
)
def test_a_message_about_a_block_names_the_contour_beside_it(old: str, new: str, code: str) -> None:
    """The second of two squares, of which the first is line 1 of the drawing."""
    part = drawing(contour(box(0, 0, 20, 20)), contour(box(50, 0, 20, 20), line=7), thickness=3.0)
    machine = table(thickness=3.0)
    text = post((part,), machine).text
    at = text.rindex(old)
    said = verify_sheet(text[:at] + new + text[at + len(old) :], (part,), machine)
    (one, *_) = (d for d in said if d.code == code)
    assert str(one).endswith("beside the contour of sheet.dxf:7")


@pytest.mark.parametrize("far", ["500", "4750000", "4750000000", "9" * 14, "9" * 400])
def test_an_arc_that_leaves_the_table_between_its_ends_is_told(far: str) -> None:
    machine = table("plate-linuxcnc", thickness=6.0, kerf_by="none", lead="none")
    part = drawing(contour(circle(500, 500, 20)))
    text = post((part,), machine).text
    start = re.search("^G0 X([0-9.]+) Y([0-9.]+)", text, re.M)
    assert start is not None
    arc = re.compile("^G[23] .*\\n", re.M)
    whole = f"G3 X{start[1]} Y{start[2]} I{far} J0\n"
    ring = "".join(arc.findall(text))
    said = {d.code for d in verify_sheet(text.replace(ring, whole), (part,), machine)}
    assert said & {"verify-sheet-area", "verify-sheet-radius", "verify-sheet-syntax"}
    assert post((part,), machine).text == text


def test_a_cut_that_begins_far_off_is_told_and_not_compared() -> None:
    machine = table("plate-linuxcnc", thickness=6.0, kerf_by="none", lead="none")
    part = drawing(contour(box(0, 0, 200, 100)))
    text = re.sub("^G0 X[0-9.]+", "G0 X999999999999", post((part,), machine).text, flags=re.M)
    assert {d.code for d in verify_sheet(text, (part,), machine)} == {"verify-sheet-area"}


def chords(
    x: float, y: float, radius: float, pitch: float, offset: float
) -> list[tuple[Curve, ...]]:
    """Lines at 45 degrees across a circle, as a hatch has them."""
    found = []
    aside = offset - radius
    while (aside := aside + pitch) < radius - 0.02:
        half, c = sqrt(radius * radius - aside * aside), sqrt(0.5)
        found.append(lines(
            (x + (half - aside) * c, y + (half + aside) * c),
            (x - (half + aside) * c, y - (half - aside) * c), closed=False,
        ))  # fmt: skip
    return found


@pytest.mark.parametrize(
    ("radius", "pitch", "offset"), [(1.1, 0.08, 0.0), (1.2, 0.06, -0.01), (1.2, 0.1, -0.05)]
)
def test_a_small_hole_is_told_from_the_hatch_across_it(
    radius: float, pitch: float, offset: float
) -> None:
    """The path round it lies on lines that are cut along their middle, at most of its places."""
    hole = [contour(box(0, 0, 30, 30)), contour(circle(15, 15, 2 * radius), line=2)]
    hatch = [
        contour(some, line=3 + k) for k, some in enumerate(chords(15, 15, radius, pitch, offset))
    ]
    machine = table("plate-linuxcnc", allow_open=True)
    text = post((drawing(*hole, *hatch, thickness=8.0),), machine).text
    more = drawing(*hole, *hatch, contour(circle(22, 15, 3), line=99), thickness=8.0)
    assert "verify-sheet-missing" in {said.code for said in verify_sheet(text, (more,), machine)}
