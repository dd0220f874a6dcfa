"""Tables whose programs move Z: followed by a reader of the test's own, and broken in every way."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec import Struct
from msgspec.structs import replace

from beamcam.checks.sheets.compare import verify_sheet
from beamcam.controllers import table_events
from beamcam.controllers.events import FeedShare, Lift, Output, Touch, Zero
from beamcam.machine import Machine, load
from beamcam.pipeline import post
from tests.conftest import SAMPLES, examples, sampled
from tests.unit.sheets.parts import NESTED, table

PIERCE, CUT, CLEAR, TRIPS = 3.8, 1.5, 20.0, -3.0
_WORD = re.compile(r"([A-Z])([-+]?[\d.]+)")


class Cut(Struct):
    """What a reader that shares nothing with beamcam sees of a start."""

    pierced: float
    lowest: float
    highest: float
    moves: int
    held: bool  #: whether the height control was on in every move


def followed(
    text: str, trips: float = TRIPS, clear: float = CLEAR, hold: tuple[str, str] = ("120", "121")
) -> Iterator[Cut]:
    """The cuts of a program for Mach3, block by block; asserts what a torch may not do.

    Z of the machine is 0 at the top; the sheet lies at an uneven depth, so that only a touch
    tells where it is. `trips` is the height of the tip where the probe trips, `hold` are the M
    words that switch the height control on and off.
    """
    axis, shift, depth = 0.0, 0.0, 63.7
    on = held = fresh = False
    cut: Cut | None = None
    for block in text.splitlines():
        words = dict(_WORD.findall(re.sub(r"\(.*\)", "", block)))
        over = axis + depth  # the tip over the sheet
        m, g = words.get("M"), words.get("G")
        if block.startswith("G53"):
            axis = float(words["Z"])
        elif g == "31":
            assert not on
            axis, fresh = trips - depth, True
        elif g == "92":
            shift = axis - float(words["Z"])
        elif g in ("0", "1") and "Z" in words:
            axis = float(words["Z"]) + shift
        elif g in ("0", "1", "2", "3") and "X" in words:
            if g == "0":
                assert over >= clear - 1e-9
                assert not on
                fresh, depth = False, depth + 0.7  # the sheet is not flat
            elif cut is not None:
                cut.moves += 1
                cut.lowest, cut.highest = min(cut.lowest, over), max(cut.highest, over)
                cut.held = cut.held and held
        elif m == "3":
            assert fresh
            assert not held
            on, cut = True, Cut(round(over, 6), 99.0, -99.0, 0, True)
        elif m == "5":
            assert not held
            on = False
            assert cut is not None
            yield cut
            cut = None
        elif m in hold:
            held = m == hold[0]
    assert not on


def program(machine: Machine) -> str:
    text = post((NESTED,), machine).text
    assert isinstance(text, str)
    return text


def test_a_stranger_sees_each_cut_at_its_heights() -> None:
    """At sheets that lie otherwise at each place: only a touch before each start makes it so."""
    cuts = list(followed(program(load("plate-mach3"))))
    assert len(cuts) == 4
    for cut in cuts:
        assert cut.pierced == PIERCE
        assert cut.lowest == pytest.approx(CUT)
        assert cut.highest == pytest.approx(CUT)
        assert cut.moves > 3
        assert cut.held


@pytest.mark.parametrize("sample", ["dstv/gusset.nc1", "json/cam.json"])
def test_a_stranger_follows_the_table_of_the_page(sample: str) -> None:
    """docs/my-table.md: the head floats 2.4 mm, traverses are 25 mm up, M205 holds the height."""
    from beamcam.pipeline import read_file

    machine = load(str(SAMPLES / "machines" / "hall-plasma.toml"))
    parts = read_file(str(SAMPLES / sample)).parts
    text = post(parts, machine).text
    assert isinstance(text, str)
    cuts = list(followed(text, -2.4, 25.0, ("205", "206")))
    assert cuts
    for cut in cuts:
        assert cut.pierced == 3.8
        assert (cut.lowest, cut.highest) == (pytest.approx(1.5), pytest.approx(1.5))
        assert cut.held


@settings(max_examples=examples(20), deadline=None)
@given(
    pierce=st.floats(2.5, 12.0).map(lambda v: round(v, 2)),
    cut=st.floats(0.5, 2.4).map(lambda v: round(v, 2)),
    more=st.floats(0.5, 40.0).map(lambda v: round(v, 2)),
    trips=st.floats(-8.0, 0.0).map(lambda v: round(v, 2)),
    off=st.floats(0.05, 5.0).map(lambda v: round(v, 2)),
    at=st.integers(0, 1000),
)  # fmt: skip
def test_whatever_the_heights_are_they_are_kept_and_no_other_passes(
    pierce: float, cut: float, more: float, trips: float, off: float, at: int
) -> None:
    machine = load("plate-mach3")
    torch = machine.needed(machine.torch, "torch")
    clear = max(pierce, 12.0) + more  # the scribe works at 12
    rows = tuple([
        replace(row, pierce_height=pierce, cut_height=cut) if row.process == "cut" else row
        for row in torch.rows
    ])  # fmt: skip
    other = replace(torch, clearance=round(clear, 2), touch_height=trips, rows=rows)
    machine = replace(machine, torch=other)
    text = program(machine)
    for one in followed(text, trips, other.clearance):
        assert one.pierced == pytest.approx(pierce)
        assert one.lowest == pytest.approx(cut)
        assert one.highest == pytest.approx(cut)
    # Any Z of the program that is another by more than its step is refused.
    blocks = text.split("\n")
    lifts = [k for k, b in enumerate(blocks) if re.match(r"G(0|1|92) Z", b)]
    k = lifts[at % (len(lifts) - 1)]  # behind the last one the axis goes to its top
    changed = re.sub(r"Z(-?[\d.]+)", lambda m: f"Z{float(m[1]) - off:.3f}", blocks[k])
    broken = "\n".join([*blocks[:k], changed, *blocks[k + 1 :]])
    said = verify_sheet(broken, (NESTED,), machine)
    assert "verify-sheet-height" in {d.code for d in said}


#: What stands in a sound program, another in its place, and the code that it is refused by.
MUTANTS = [
    ("G0 Z3.8", "G0 Z4.8", "height", "the tool started 4.8 mm over the sheet; expected 3.8 mm"),
    ("G0 Z3.8", "G0 Z2.8", "height", "the tool started 2.8 mm over the sheet; expected 3.8 mm"),
    ("G1 Z1.5 F1500", "G1 Z0.5 F1500", "height", "0.5 mm over the sheet; expected 1.5 to 3.8"),
    ("G1 Z1.5 F1500", "G1 Z5 F1500", "height", "5 mm over the sheet; expected 1.5 to 3.8"),
    ("G1 Z1.5 F1500", "G1 Z2 F1500", "height", "a feed 2 mm over the sheet; expected 1.5 mm"),
    ("G1 Z1.5 F1500\n", "", "height", "a feed 3.8 mm over the sheet; expected 1.5 mm"),
    ("G1 Z1.5 F1500", "G0 Z1.5", "height", "a traverse in Z with the tool on"),
    ("G92 Z-3\nG0 Z3.8", "G92 Z0\nG0 Z3.8", "height", "started 0.8 mm over"),
    ("G92 Z-3\nG0 Z3.8", "G92 Z3\nG0 Z3.8", "height", "-2.2 mm over the sheet; expected 0 or"),
    ("G92 Z-3\nG0 Z3.8", "G0 Z3.8", "height", "counts from before the touch; expected G92"),
    ("G31 Z-150 F600\nG92 Z-3\nG0 Z3.8", "G0 Z3.8", "height", "a start without a touch"),
    ("G53 G0 Z0\n", "", "height", "a traverse at a height that nothing says; expected 20 mm"),
    ("G53 G0 Z0\n", "G53 G0 Z-5\n", "height", "expected a Z that counts from the sheet"),
    ("G53 G0 Z0\n", "G0 Z50\n", "height", "expected a Z that counts from the sheet"),
    ("G0 Z20\nG0", "G0", "height", "a traverse 12 mm over the sheet; expected 20 mm"),
    ("G0 Z20\nG0", "G0 Z10\nG0", "height", "a traverse 10 mm over the sheet; expected 20 mm"),
    ("M5\nG4 P0.2\nG0 Z20", "G0 Z20\nM5", "height", "a move in Z in mid contour"),
    ("G92.1\n", "", "height", "the end while G92 holds"),
    ("G53 G0 Z0\nG92.1", "G92.1", "", ""),
    ("G53 G0 Z0\nG92.1\nG0 X0 Y0", "G0 Z5\nG92.1", "height", "the end with the torch 5 mm"),
    ("M120\n", "", "thc", "a cut with the height control off"),
    ("M3\n", "M120\nM3\n", "thc", "the height control on with the tool off"),
    ("G4 P0.5\nG1", "M120\nG4 P0.5\nG1", "thc", "the height control on 3.8 mm over the sheet"),
    ("M121\nM5", "M5\nM121", "thc", "the tool stopped with the height control on"),
    ("M121\nM5", "M5", "thc", "the tool stopped with the height control on"),
    ("M121\n", "M121\nM120\nM121\n", "", ""),
    ("G31 Z-150 F600", "G31 X50 F600", "word", "a touch in X, Y or nothing"),
    ("G92 Z-3", "G92 X0 Z-3", "word", "G92, which beamcam does not know"),
    ("M3\n", "M3\nG31 Z-50\n", "height", "a touch with the tool on"),
    ("M3\n", "M3\nM122\n", "word", "M122, which beamcam does not know"),
    ("G1 Z1.5 F1500", "G1 X50 Z1.5 F1500", "word", "X or Y together with Z"),
    ("G64\n", "G64\nG43 H1\n", "word", "G43, which beamcam does not know"),
    ("G92 Z-3", "G10 L20 P2 Z-3", "word", "G10, which beamcam does not know"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "code", "said"), sampled(MUTANTS, 2))
def test_each_wrong_height_is_refused_and_none_that_is_right(
    old: str, new: str, code: str, said: str
) -> None:
    machine = load("plate-mach3")
    text = program(machine)
    assert not verify_sheet(text, (NESTED,), machine)
    begins = text.rindex(old) if "Z0\nG92.1" in old else text.index(old)
    changed = text[:begins] + new + text[begins + len(old) :]
    found = verify_sheet(changed, (NESTED,), machine)
    if not code:
        assert not found
        return
    assert f"verify-sheet-{code}" in {one.code for one in found}
    assert any(said in one.message for one in found), found


#: Words that mean the same, for every place at which they stand.
RIGHT = [
    ("G92 Z-3", "G92 Z0\nG0 Z3\nG92 Z0"), ("G92 Z-3", "G10 L20 P1 Z-3"),
    ("G92 Z-3", "G10 L20 P0 Z-3"), ("G0 Z3.8\n", "G0 Z10\nG1 Z3.8 F2000\n"),
    ("G1 Z1.5 F1500", "G91\nG1 Z-2.3 F1500\nG90"), ("G0 Z20\n", "G53 G0 Z0\n"),
    ("G1 Z1.5 F1500", "G1 Z2.5 F1500\nG1 Z1.5"), ("G31 Z-150 F600", "F600\nG31 Z-90"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new"), RIGHT)
def test_heights_may_be_said_otherwise(old: str, new: str) -> None:
    machine = load("plate-mach3")
    text = program(machine)
    assert old in text
    assert not verify_sheet(text.replace(old, new), (NESTED,), machine)


def test_a_traverse_may_rise_on_its_way_where_it_is_clear(tmp_path: Path) -> None:
    text = "G90\nG53 G0 Z0\nG0 X10 Y10\nG31 Z-50 F600\nG92 Z-3\nG0 Z30\nG0 X50 Y60 Z40\n"
    events, said = table_events(text + "M30", load("plate-mach3"))
    assert not [one for one in said if one.code == "verify-sheet-word"]
    lifts = [event for event in events if isinstance(event, Lift)]
    assert [lift.end for lift in lifts] == [float("inf"), 30.0, 40.0]
    low = table_events(text.replace("Z30", "Z5") + "M30", load("plate-mach3"))[1]
    assert any("X or Y together with Z" in one.message for one in low)


def test_a_touch_and_a_zero_are_events() -> None:
    text = "G53 G0 Z0\nG31 Z-50 F300\nG92 Z-3\nG1 Z2 F100\nG92.1\nM120\nM30"
    events, _ = table_events(text, load("plate-mach3"))
    assert [event for event in events if isinstance(event, Touch | Zero | Output)] == [
        Touch(2, -3.0, 300.0), Zero(3, True), Zero(5, False), Output(6, "thc", True),
    ]  # fmt: skip
    assert [event.end for event in events if isinstance(event, Lift)] == [float("inf"), 2.0]


def own(tmp_path: Path, more: str, base: str = "plate-mach3") -> Machine:
    path = tmp_path / "mine.toml"
    path.write_text(f'base = "{base}"\n{more}')
    return load(str(path))


def test_a_macro_may_touch_off_and_go_to_a_height(tmp_path: Path) -> None:
    machine = own(tmp_path, """
[codes]
M200 = "touch off"
M201 = "height"
M120 = "thc on"
M121 = "thc off"
[words]
cut_on = [
    "M200", "M201 P{pierce_height}", "M3", "G4 P{pierce}", "M201 P{cut_height}", "M120", "F{feed}",
]
mark_on = ["M200", "M201 P{cut_height}", "M7", "F{feed}"]
footer = ["G53 G0 Z0", "G0 X0 Y0", "M30"]
""")  # fmt: skip
    text = program(machine)
    assert not verify_sheet(text, (NESTED,), machine)
    for old, new in (("M201 P1.5", "M201 P1"), ("M201 P3.8", "M201 P3.3"), ("M200\n", "")):
        said = verify_sheet(text.replace(old, new, 1), (NESTED,), machine)
        assert "verify-sheet-height" in {one.code for one in said}, (old, said)


def test_a_table_that_waits_in_milliseconds_says_them(tmp_path: Path) -> None:
    machine = own(tmp_path, '[format]\ndwell_unit = "ms"\n[words]\ncut_off = ["M121", "M5", '
                            '"G0 Z{clearance}"]\n')  # fmt: skip
    text = program(machine)
    assert "\nG4 P500\n" in text
    assert not verify_sheet(text, (NESTED,), machine)
    said = verify_sheet(text.replace("G4 P500", "G4 P0.5"), (NESTED,), machine)
    assert "verify-sheet-tool" in {one.code for one in said}


def test_a_z_that_the_operator_has_set_needs_no_touch(tmp_path: Path) -> None:
    machine = own(tmp_path, """
[torch]
touch = "none"
[words]
header = ["({job})", "G21 G17 G90 G91.1 G40 G94", "G0 Z{clear}"]
cut_on = ["G0 Z{pierce_height}", "M3", "G4 P{pierce}", "G1 Z{cut_height} F1500", "M120", "F{feed}"]
mark_on = ["G0 Z{cut_height}", "M7", "F{feed}"]
footer = ["G0 X0 Y0", "M30"]
""".replace("{clear}", "20"))  # fmt: skip
    text = program(machine)
    assert not verify_sheet(text, (NESTED,), machine)
    said = verify_sheet(text.replace("G0 Z20\n", "", 1), (NESTED,), machine)
    assert "verify-sheet-height" in {one.code for one in said}


def test_a_share_of_the_feed_is_the_feed() -> None:
    text = "G21 G17 G90 G91.1 G40 G94\nG0 X0 Y0\nF1000\nM67 E3 Q60\nG1 X10 Y0\nG1 X20 Y0\n"
    text += "M68 E3 Q0\nG1 X30 Y0\nG1 X40 Y0\nM2\n"
    events, said = table_events(text, load("plate-qtplasmac"))
    assert not said
    assert [e.feed_mm_min for e in events if hasattr(e, "rapid") and not e.rapid] == [
        600.0, 600.0, 1000.0, 1000.0,
    ]  # fmt: skip
    assert [e.share for e in events if isinstance(e, FeedShare)] == [0.6, 1.0]


#: A key of a torch that cannot be, and what is expected.
WRONG_KEYS = [
    ("clearance = 0", "a height for traverses"), ("clearance = 3", "more than 3.8"),
    ('z = "controller"', "none, as the controller moves Z"),
    ("touch_height = 2", "at most 0"),
]  # fmt: skip


@pytest.mark.parametrize(("key", "expected"), WRONG_KEYS)
def test_keys_of_heights_that_contradict_each_other(
    key: str, expected: str, tmp_path: Path
) -> None:
    from beamcam.errors import MachineError

    with pytest.raises(MachineError) as raised:
        own(tmp_path, f"[torch]\n{key}\n")
    assert expected in raised.value.diagnostics[0].message


@pytest.mark.parametrize(
    ("base", "more", "expected"),
    [
        ("plate-linuxcnc", '[torch]\nz = "program"\n', "a height for traverses"),
        ("plate-codesys", '[torch]\nz = "program"\nclearance = 20\n', "is not followed in Z"),
        ("plate-linuxcnc", '[torch]\nthc = "program"\n', "words of codes that are thc on and"),
        ("plate-mach3", '[[axes]]\nname = "a"\nmoves = "X"\nspeed = 100\nacceleration = 100\n'
         '[[axes]]\nname = "b"\nmoves = "Y"\nspeed = 100\nacceleration = 100\n',
         "an axis for Z, as the program moves it"),
        ("plate-mach3", '[codes]\nM120 = "thc"\n', "expected one of"),
        ("plate-mach3", '[codes]\nZ = "none"\n', "as the program moves Z"),
        ("plate-mach3", '[codes]\nM5 = "none"\n', "what it switches"),
        ("plate-mach3", '[codes]\nG33 = "thc on"\n', "a G word switches nothing"),
        ("plate-mach3", '[codes]\nM120 = "drill-cycle"\n', "a table does not drill"),
        ("plate-mach3", '[codes]\n"#<a>" = "none"\n', "mach3 has no names"),
        ("plate-linuxcnc", '[codes]\n"o<a>" = "feed share"\n', "a meaning without a number"),
    ],
)  # fmt: skip
def test_words_and_keys_that_a_table_cannot_have(
    base: str, more: str, expected: str, tmp_path: Path
) -> None:
    from beamcam.errors import MachineError

    with pytest.raises(MachineError) as raised:
        own(tmp_path, more, base)
    assert expected in raised.value.diagnostics[0].message


def test_simulate_has_the_height_as_an_axis() -> None:
    from beamcam.simulation.program import simulate_program

    machine = table("plate-mach3")
    done = simulate_program(program(machine), machine, parts=(NESTED,))
    trace = done.trace
    assert [axis.name for axis in trace.axes] == ["bridge", "torch", "lift"]
    heights = trace.positions[:, 2]
    assert heights.min() == TRIPS
    assert heights.max() == CLEAR
    cutting = [trace.states[k].process == "cut" for k in trace.state.tolist()]
    moved = (abs(trace.positions[1:, :2] - trace.positions[:-1, :2]).max(axis=1) > 0).tolist()
    cut_at = {h for h, on, xy in zip(heights[1:], cutting, moved, strict=True) if on and xy}
    assert {round(float(height), 6) for height in cut_at} == {CUT}


@pytest.mark.parametrize("words", ["", '[words]\ncut_off = ["M121", "M5", "G53 G0 Z0"]\n'])
def test_plan_and_simulate_count_the_moves_of_the_torch(words: str, tmp_path: Path) -> None:
    from beamcam.simulation.program import simulate_program

    machine = own(tmp_path, words)
    made = post((NESTED,), machine)
    time = made.time(machine)
    duration_s = simulate_program(str(made.text), machine, parts=(NESTED,)).trace.duration_s
    assert duration_s == pytest.approx(sum(time.operations) + time.home_s, rel=2e-4)
    # Four cuts and a mark: 23 mm down at 600 mm/min for each alone take 11 s.
    flat = post((NESTED,), load("plate-qtplasmac"))
    assert sum(time.operations) > sum(flat.time(load("plate-qtplasmac")).operations) + 11.0
