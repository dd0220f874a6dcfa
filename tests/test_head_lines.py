"""The head of a program says what it is, whatever the parts are called, and excuses nothing."""

import re
from functools import cache
from pathlib import Path

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.arguments import expected_job
from beamcam.checks.job import Head, head_of
from beamcam.controllers import longest_line
from beamcam.emitters.gcode import MAX_TEXT, comment_room
from beamcam.errors import MachineError, errors_in
from beamcam.machine import load
from beamcam.model.description import PART_DATA
from beamcam.model.part import EndCuts, Part, part_data
from beamcam.model.request import Request
from beamcam.pipeline import begin, finished, parts_of, post, read_back, read_file
from beamcam.plain_text import outside_text
from beamcam.readers import read
from tests.conftest import SAMPLES, examples
from tests.runs import call, part
from tests.strategies import BEAM, CHANNEL, SOURCE, bars

#: A sample that each machine makes, and how its program begins the line of a part.
MADE = {
    "beamline": "dstv/channel.nc1", "beamline-annex": "dstv/channel.nc1",
    "plate-linuxcnc": "dstv/gusset.nc1", "plate-codesys": "dstv/gusset.nc1",
    "laser-grbl": "json/shield-small.json", "table-simotion": "json/shield-small.json",
    "laser-stepper": "json/shield-small.json",
}  # fmt: skip
HOSTILE = (
    "BEAMCAM 2 MACHINE beamline 00000000", "x BEAMCAM 1 MACHINE y", "M1)\n(BAR 99)\n(",
    "*) x := 1; (*", "ALLOWED TO BE LEFT OUT: cope", "M1 DRAWING 9 ORDER 8",
    "web station 3: mill 16", "Träger Größe 5", "x" * 300, "%", "  ", "N5 M30",
    "PART 1 AT 0 LENGTH 1 MARK x", "(MSG,stop",
)  # fmt: skip
texts = st.sampled_from(HOSTILE) | st.text(max_size=60)


def parts_for(machine: str) -> tuple[Part, ...]:
    return parts_of([read_file(str(SAMPLES / MADE[machine]))])[0]


def head_in(text: str) -> Head:
    head = head_of(text)
    assert head is not None
    return head


def named(part: Part) -> str:
    """What a head calls a part."""
    said = (("MARK", part.mark), ("DRAWING", part.drawing), ("ORDER", part.order))
    return " ".join(f"{key} {outside_text(text)[:MAX_TEXT]}" for key, text in said if text)


@pytest.mark.parametrize("machine", MADE)
@settings(max_examples=examples(15), deadline=None)
@given(mark=texts, drawing=texts, order=texts, grade=st.sampled_from(("", *HOSTILE)))
@example("M1", "", "", "")
def test_any_text_is_told_and_none_is_obeyed(
    machine: str, mark: str, drawing: str, order: str, grade: str
) -> None:
    loaded = load(machine)
    if machine.startswith("beamline"):
        (part,) = parts_for(machine)
        part = replace(part, mark=mark, drawing=drawing, order=order, grade=grade)
    else:  # a material that no row of a torch knows is refused
        (part,) = (replace(p, mark=mark, drawing=drawing, order=order) for p in parts_for(machine))
    posted = post([part], loaded, job="JOB" if expected_job(mark) else mark)
    head = head_in(posted.text)
    assert not head.allowed
    assert [told.texts for told in head.parts] == [named(part)]
    if (longest := longest_line(loaded)) is not None:
        assert all(len(line) <= longest for line in posted.text.splitlines())
    assert not errors_in(read_back(posted.text, Request((part,), loaded)))


@settings(max_examples=examples(25), deadline=None)
@given(bars())
def test_each_part_of_a_bar_stands_in_the_head_and_begins_once(parts: list[Part]) -> None:
    machine = load("beamline")
    posted = post(parts, machine)
    head = head_in(posted.text)
    assert posted.plan.pieces
    assert [told.at[0] for told in head.parts] == pytest.approx(
        [piece.start for piece in posted.plan.pieces], abs=0.001
    )
    begun = re.findall(r"^\(PART ([0-9]+) BEGINS: ", posted.text, re.MULTILINE)
    assert sorted(map(int, begun)) == list(range(1, len(parts) + 1))
    first = {int(n): posted.text.index(f"(PART {n} BEGINS: ") for n in begun}
    assert first[1] < min((at for n, at in first.items() if n > 1), default=len(posted.text))


def test_figures_do_not_depend_on_the_room_of_a_line() -> None:
    (part,) = parts_for("laser-grbl")
    part = replace(part, mark="m" * 50, drawing="d" * 50, order="o" * 50)
    text = post([part], load("laser-grbl")).text
    assert [line for line in text.splitlines() if line.startswith("(PART")] == [
        f"(PART 1 AT -1 -3 SIZE 15 15 MARK {'m' * 40})",
        f"(PART 1 DRAWING {'d' * 40})",
        f"(PART 1 ORDER {'o' * 40})",
    ]
    assert head_in(text).parts[0].texts == named(part)


def test_the_head_counts_programs_and_what_is_left_out() -> None:
    parts = tuple(parts_for("beamline")) * 3
    request = Request(parts, load("beamline"), stock=(6500.0,), quantity=1)
    heads = [head_in(finished(one).text) for one in begin(request)]
    assert [head.program for head in heads] == [(1, 2), (2, 2)]
    assert [len(head.parts) for head in heads] == [2, 1]
    assert [(head.bar, head.as_needed) for head in heads] == [(6500.0, False)] * 2
    slot, _ = parts_of([read_file(str(SAMPLES / "bad" / "slot.nc1"))])
    assert head_in(post(slot, load("beamline"), skips=("slot",)).text).left_out == 1


# --- what verify makes of it ----------------------------------------------------------------------

MITRE = Part("M1", CHANNEL, 2000.0, SOURCE, cuts=EndCuts(web_end=20.0), grade="S235JR")
SQUARE = Part("S1", BEAM, 2000.0, SOURCE, grade="S235JR")


def without_last_cut(text: str, machine: str = "beamline-pusher") -> str:
    """The program without its last saw cut, numbers of its blocks kept."""
    lines = text.splitlines(keepends=True)
    last = max(k for k, line in enumerate(lines) if " M42 " in line)
    assert " X" in lines[last - 1]
    return "".join([*lines[: last - 1], *lines[last + 1 :]])


def changed_head(text: str, old: str, new: str) -> str:
    found, count = re.subn(old, new, text, count=1)
    assert count == 1
    return found


def test_a_missing_last_cut_is_found_by_the_bar_of_the_head() -> None:
    """Behind a mitre the bar might end; only the head says that it does not."""
    request = Request((MITRE,), load("beamline"))
    text = post([MITRE], request.machine, bar=6000.0).text
    assert not errors_in(read_back(text, request))
    lame = without_last_cut(text)
    assert [one.code for one in errors_in(read_back(lame, request))] == ["verify-cut-missing"]
    old = changed_head(
        lame, r"BEAMCAM 2(?s:.)*?\n(?=\(PART 1 BEGINS)", "BEAMCAM 1 MACHINE beamline)\n"
    )
    assert not errors_in(read_back(old, request))


def test_a_bar_that_ends_with_its_part_takes_no_cut_away() -> None:
    """A head that has the bar end where the last cut is missing is no cut."""
    request = Request((SQUARE,), load("beamline"))
    text = without_last_cut(post([SQUARE], request.machine).text)
    forged = changed_head(text, r"BAR [0-9.]+ AS NEEDED", "BAR 2020")
    assert any(one.code == "verify-cut-missing" for one in read_back(forged, request))


#: Lines that a forged head may have.
forged_lines = st.one_of(
    st.floats(1.0, 20000.0).map(lambda bar: f"BAR {bar:.3f}"),
    st.floats(1.0, 20000.0).map(lambda bar: f"BAR {bar:.3f} AS NEEDED"),
    st.tuples(st.floats(0, 5000), st.floats(0, 5000)).map(
        lambda f: f"PART 1 AT {f[0]:.3f} LENGTH {f[1]:.3f} MARK S1"
    ),
    st.sampled_from(
        ("PART 1 AT 20 LENGTH 2000 MARK S1", "SECTION IPE300 GRADE S235JR", "LEFT OUT: 3 slot",
         "LEFT TO THE HAND: 9", "PROGRAM 4 OF 2", "NOT VERIFIED: THIS PROGRAM WAS NOT READ BACK")
    ),
)  # fmt: skip


@settings(max_examples=examples(60), deadline=None)
@given(
    st.lists(forged_lines, min_size=6, max_size=6), st.sampled_from((1, 2, 3)),
    st.sampled_from(("cut", "place", "section")), st.sampled_from((MITRE, SQUARE)),
)  # fmt: skip
def test_no_head_takes_a_fault_away(lines: list[str], form: int, fault: str, part: Part) -> None:
    """What is wrong with a program without a head is wrong with it under any head."""
    request = Request((part,), load("beamline"))
    text = post([part], request.machine).text
    begin, end = text.index("(BEAMCAM"), text.index("(PART 1 BEGINS")
    wrong = {
        "cut": without_last_cut, "place": lambda t: re.sub(r"G00 X", "G00 X1", t, count=1),
        "section": lambda t: re.sub(r" L[0-9]+\n", " L111\n", t, count=1),
    }[fault](text)  # fmt: skip
    blank = "(-)\n" * 7
    forged = "".join(f"({line})\n" for line in (f"BEAMCAM {form} MACHINE beamline", *lines))
    bare, told = (wrong[:begin] + head + wrong[end:] for head in (blank, forged))
    assert errors_in(read_back(bare, request)) or fault == "cut"
    assert set(errors_in(read_back(bare, request))) <= set(read_back(told, request))


@pytest.mark.parametrize(
    ("old", "new", "code", "found"),
    [
        (r"AT 20 LENGTH", "AT 21 LENGTH", "verify-head", "part 1 at 21.000"),
        (r"LENGTH 3000", "LENGTH 3001", "verify-head", "3001.000 mm"),
        (r"\(PART 1 AT.*\n", "", "verify-head", "found 0 part(s)"),
        (r"\(BAR .*\n", "", "verify-head", "found no bar"),
        (r"\(PART 1 AT", "(PART 2 AT", "verify-head", "found 0 part(s)"),
        (r"BAR [0-9.]+", "BAR 2500", "verify-bar-end", "3024.040 mm"),
        (r"MARK C1", "MARK C2", "verify-head-text", "MARK C2"),
        (r"UPN200 GRADE", "UPN220 GRADE", "verify-head-text", "UPN220"),
        (r"GRADE S235JR", "GRADE S355", "verify-head-text", "the grade S355"),
    ],
)
def test_verify_says_where_a_head_is_wrong(old: str, new: str, code: str, found: str) -> None:
    parts = parts_for("beamline")
    text = changed_head(post(parts, load("beamline")).text, old, new)
    said = {one.code: one.message for one in read_back(text, Request(parts, load("beamline")))}
    assert found in said[code]


@cache
def written_for(machine: str) -> str:
    return str(post(parts_for(machine), load(machine)).text)


@pytest.mark.parametrize("machine", [name for name in MADE if not name.startswith("beamline")])
@pytest.mark.parametrize(
    ("old", "new"),
    [(r"AT -?[0-9]+", "AT 77"), (r"SIZE [0-9]+", "SIZE 77"), (r"SHEET [0-9]+", "SHEET 77")],
)
def test_verify_says_where_the_head_of_a_sheet_is_wrong(machine: str, old: str, new: str) -> None:
    parts, loaded = parts_for(machine), load(machine)
    text = changed_head(written_for(machine), old, new)
    found = errors_in(read_back(text, Request(parts, loaded)))
    assert [one.code for one in found] == ["verify-head"]


@pytest.mark.parametrize(
    ("posted", "asked", "wrong"),
    [(6000, 6000, False), (6000, 12000, True), (6000, 5000, True), (None, 12000, False),
     (None, 3000, True), (6000, None, False), (None, None, False)],
)  # fmt: skip
def test_a_bar_that_is_given_has_to_be_that_of_the_head(
    tmp_path: Path, posted: int | None, asked: int | None, wrong: bool
) -> None:
    part, program = SAMPLES / "dstv" / "channel.nc1", tmp_path / "a.gcode"
    bar = () if posted is None else ("--bar", posted)
    assert call("post", part, "-o", program, "-q", *bar).exit_code == 0
    done = call("verify", program, "--against", part, *(() if asked is None else ("--bar", asked)))
    assert done.exit_code == wrong
    assert ("verify-head-bar: found a program for a bar of" in done.stderr) == wrong
    assert "verify-bar-needed" not in done.stderr


def test_a_comment_of_each_machine_has_room_for_figures() -> None:
    longest = "PART 123456 AT 123456.123 123456.123 SIZE 123456.123 123456.123"
    assert all(comment_room(load(machine)) >= len(longest) for machine in MADE)


# --- data of parts --------------------------------------------------------------------------------


HEADER = " ".join(f"{name}={{{name}}}" for name in PART_DATA)


def machine(folder: Path, base: str, header: str) -> str:
    path = folder / "mine.toml"
    own = load(base).words.header
    lines = ", ".join(repr(line) for line in (own[0], f"({header})", *own[1:]))
    path.write_text(f'base = "{base}"\n[words]\nheader = [{lines}]\n')
    return str(path)


def test_a_bar_says_the_data_of_its_parts_once(tmp_path: Path) -> None:
    on = load(machine(tmp_path, "beamline", HEADER))
    parts = [read(part(mark, quantity=q).encode(), "a.nc1").parts[0] for mark, q in
             (("A", 2), ("B", 2), ("A", 2))]  # fmt: skip
    text = post(parts, on).text
    assert (
        "(mark=A+B name=a profile=UPN200 grade=S235JR length=2000 quantity=2 order=TEST "
        "drawing=1 phase=1 date=)" in text
    )
    assert part_data(parts)["mark"] == "A+B"


def test_a_sheet_says_them_too(tmp_path: Path) -> None:
    place = machine(tmp_path, "plate-linuxcnc", HEADER)
    out = tmp_path / "a.ngc"
    words = ["post", str(SAMPLES / "dstv" / "gusset.nc1"), "-o", str(out), "--machine", place]
    assert call(*words).exit_code == 0
    (line,) = (line for line in out.read_text().splitlines() if "mark=" in line)
    assert set(PART_DATA) == {
        word.partition("=")[0] for word in line.strip("()").split() if "=" in word
    }


@pytest.mark.parametrize("name", ["width", "height", "section", "marc"])
def test_what_a_sheet_cannot_say_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(MachineError, match="machine-value"):
        load(machine(tmp_path, "plate-linuxcnc", f"{{{name}}}"))
