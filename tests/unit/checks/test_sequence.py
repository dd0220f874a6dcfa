"""The order of work, a tap's feed, and what the operator is told at a stop, in a whole program.

Two parts with every kind of work are posted for the line that makes all of it; each case moves a
whole operation, or says something else in one word.
"""

import re
from collections.abc import Callable
from functools import cache

import pytest
from msgspec.structs import replace

from beamcam.checks.bars import verify
from beamcam.machine import load
from beamcam.pipeline import post
from benchmarks.liars import PROFILES, parts
from tests.runs import call
from tests.unit.checks.programs import interpret

PUSHER = load("beamline-pusher")
PARTS = parts("beamline-pusher", PROFILES[0])
_BEGINS = re.compile(r"(?:N\d+ )?(?:M4[05789] K|M50 K|\(web station|G00 X\S+$|M30)")
DRILL_OF_TAP, TAP, DRILL, SINK, ENTRY, MILL, SCRIBE = (
    "L10.2", "M45", "X1015", "M47", "X1230", "M49", "M50",
)  # fmt: skip

PARTING, TRIM = "M42 K105", "X1264"

Operations = tuple[str, ...]


@cache
def operations() -> Operations:
    """The program without block numbers, operation by operation, the head first."""
    text = post(PARTS, PUSHER, bar=6000.0).text
    found: list[list[str]] = [[]]
    for line in re.sub(r"(?m)^N\d+ ", "", text).splitlines():
        comes_alone = not (found[-1] and found[-1][-1].startswith(("(web", "M06")))
        if _BEGINS.match(line) and comes_alone:
            found.append([])
        found[-1].append(line)
    return tuple("\n".join(lines) for lines in found)


def program(done: Operations | None = None) -> str:
    return "\n".join(done or operations()) + "\n"


def at(*words: str) -> int:
    """The first operation with all of some words."""
    return next(i for i, one in enumerate(operations()) if all(w in one for w in words))


def moved(which: int, behind: int) -> str:
    done = [*operations()]
    one = done.pop(which)
    done.insert(behind if which < behind else behind + 1, one)
    return program(tuple(done))


def said(text: str) -> list[str]:
    return [d.code for d in verify(text, PARTS, PUSHER, bar=6000.0)]


def test_the_program_is_right_however_it_is_cut_up() -> None:
    assert said(program()) == []
    assert len(operations()) > 20


@pytest.mark.parametrize(
    ("what", "change", "code"),
    [
        ("tap before its drill", lambda: moved(at(DRILL_OF_TAP, "X915"), at(TAP)), "verify-order"),
        ("sink before its hole", lambda: moved(at("M40", DRILL), at(SINK)), "verify-order"),
        ("entry behind the mill", lambda: moved(at("M40", ENTRY), at(MILL)), "verify-order"),
        ("mill behind the cut", lambda: moved(at(MILL), at(PARTING)), "verify-cut-off"),
        ("scribe behind the cut", lambda: moved(at(SCRIBE), at(PARTING)), "verify-cut-off"),
        ("drill behind the cut", lambda: moved(at("X315"), at(PARTING)), "verify-cut-off"),
        ("cut behind the next", lambda: moved(at("M42", TRIM), at(PARTING)), "verify-cut-off"),
    ],
)  # fmt: skip
def test_work_in_another_order_is_refused(what: str, change: Callable[[], str], code: str) -> None:
    assert code in said(change()), what


def test_what_is_said_of_the_order() -> None:
    """The places as the machine counts them."""
    wrong = moved(at("M40", DRILL), at(SINK))
    assert [str(d) for d in verify(wrong, PARTS, PUSHER, bar=6000.0)] == [
        "program:82: error verify-order: found a countersink 20 on face v at X 1015, y 150 before "
        "its hole; expected its hole first"
    ]
    late = moved(at(SCRIBE), at(PARTING))
    assert (
        " error verify-cut-off: found a line at X 1315 in a part that the cut on line "
        in "".join(str(d) for d in verify(late, PARTS, PUSHER, bar=6000.0))
    )
    fast = program().replace(FEED, "Z80.55 F9")
    assert str(verify(fast, PARTS, PUSHER, bar=6000.0)[0]) == (
        "program:71: error verify-tap: found a tap of pitch 1.75 fed in at 540 mm/min; expected "
        "371 mm/min, as it turns"
    )


def test_an_entry_that_is_missing_is_refused_but_not_the_other_end_of_the_slot() -> None:
    done = operations()
    entry, other = at("M40", ENTRY), at("M40", "X1200")
    assert said(program((*done[:entry], *done[entry + 1 :]))) == ["verify-order"]
    left = operations()[other].splitlines()
    stop = "\n".join(line for line in left if line.startswith(("(", "M06")))
    assert said(program((*done[:other], stop, *done[other + 1 :]))) == []


def test_a_machine_that_does_not_drill_first_may_plunge() -> None:
    assert PUSHER.drill is not None
    mills = replace(PUSHER, drill=replace(PUSHER.drill, slots="mill"))
    done = operations()
    entry = at("M40", ENTRY)
    text = program((*done[:entry], *done[entry + 1 :]))
    assert [d.code for d in verify(text, PARTS, mills, bar=6000.0)] == []


def test_the_order_at_a_place_is_seen_without_the_parts() -> None:
    wrong = moved(at(DRILL_OF_TAP, "X915"), at(TAP))
    assert "verify-order" in [d.code for d in verify(wrong, (), PUSHER)]
    assert interpret(program(), PUSHER).bores
    assert "verify-order" not in [d.code for d in verify(program(), (), PUSHER)]


FEED, OUT = "Z80.55 F6.189", "Z66.45 F6.189"
TAPS = [
    ("slow", [(FEED, "Z80.55 F3.7"), (OUT, "Z66.45 F3.7")]),
    ("1 % fast", [(FEED, "Z80.55 F6.25")]),
    ("out at twice", [(OUT, "Z66.45 F12.4")]),
    ("out at half", [(OUT, "Z66.45 F3.1")]),
    ("out at other turns", [("M04 K212", "M04 K150")]),
    ("in at other turns", [("M03 K212", "M03 K190")]),
    ("another pitch on the way", [("M04 K212", "M46 K1.5\nM04 K212")]),
]


@pytest.mark.parametrize(("what", "changes"), TAPS, ids=[what for what, _ in TAPS])
def test_a_tap_goes_in_and_out_by_its_pitch(what: str, changes: list[tuple[str, str]]) -> None:
    text = program()
    for old, new in changes:
        assert text.count(old) == 1
        text = text.replace(old, new)
    assert "verify-tap" in said(text)
    assert "verify-tap" in [d.code for d in verify(text, (), PUSHER)]


def test_a_tap_whose_turns_are_not_written_comes_out_as_it_went_in() -> None:
    words = PUSHER.words
    silent = replace(
        words,
        tap=tuple(line.replace(" K{speed}", "") if "M0" in line else line for line in words.tap),
    )
    others = {
        name: tuple(line.replace(" K{speed}", "") for line in getattr(words, name))
        for name in ("drill", "countersink", "mill")
    }
    machine = replace(PUSHER, words=replace(silent, **others))
    text = post(PARTS, machine, bar=6000.0).text
    assert [d.code for d in verify(text, PARTS, machine, bar=6000.0)] == []
    wrong = text.replace(OUT, "Z66.45 F7")
    assert [d.code for d in verify(wrong, PARTS, machine, bar=6000.0)] == ["verify-tap"]


STOP = "(web station 3: mill 16 for drill 18)"
TOLD = [
    ("another kind of tool", "(web station 3: drill 16 for drill 18)"),
    ("another size", "(web station 3: mill 20 for drill 18)"),
    ("out goes what is needed", "(web station 3: mill 16 for drill 14)"),
    ("out goes what is not there", "(web station 3: mill 16 for drill 17)"),
    ("another station", "(web station 2: mill 16 for drill 18)"),
    ("no such station", "(web station 6: mill 16 for drill 18)"),
    ("another spindle", "(left flange station 3: mill 16 for drill 18)"),
    ("no comment at one stop", "(changed by hand)"),
    ("two comments", f"{STOP}\n{STOP}"),
]


@pytest.mark.parametrize(("what", "comment"), TOLD, ids=[what for what, _ in TOLD])
def test_what_the_operator_is_told_at_a_stop_has_to_be_so(what: str, comment: str) -> None:
    assert program().count(STOP) == 1
    found = said(program().replace(STOP, comment))
    assert found
    assert {*found} == {"verify-stop-comment"}


@pytest.mark.parametrize(
    "comment", [STOP.upper(), STOP.replace(" ", "\t"), STOP.replace(" ", "   ")]
)
def test_the_operator_may_be_told_in_other_letters(comment: str) -> None:
    assert said(program().replace(STOP, comment)) == []


def test_a_program_that_tells_nothing_at_its_stops_is_right() -> None:
    assert said(re.sub(r"(?m)^\(web station.*\n", "", program())) == []


def test_diff_refuses_a_tap_before_its_drill(tmp_path_factory: pytest.TempPathFactory) -> None:
    folder = tmp_path_factory.mktemp("diff")
    (folder / "a.gcode").write_text(program())
    (folder / "b.gcode").write_text(moved(at(DRILL_OF_TAP, "X915"), at(TAP)))
    files = [str(folder / "a.gcode"), str(folder / "b.gcode")]
    done = call("diff", *files, "--machine", "beamline-pusher", status=1)
    assert "verify-order" in done.stderr
