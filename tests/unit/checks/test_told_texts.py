"""Texts that a stamp or printer is told: string, face, place, height and angle are read back."""

import json
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.bars import run
from beamcam.comparison.bars import diff_programs
from beamcam.controllers import cell_events
from beamcam.controllers.events import Lettering
from beamcam.errors import Diagnostic, MachineError, VerifyError, errors_in
from beamcam.machine import load
from beamcam.machine.machine import Machine
from beamcam.model.part import TextMark
from beamcam.model.request import Request
from beamcam.pipeline import Posted, post, read_back
from tests.conftest import SAMPLES, examples
from tests.runs import call
from tests.unit.planning.shop import SOURCE, hole, part

FILES = {unit: SAMPLES / "machines" / f"beamline-{unit}.toml" for unit in ("stamp", "printer")}
STAMP, PRINTER = load(str(FILES["stamp"])), load(str(FILES["printer"]))
MARKED = str(SAMPLES / "dstv" / "marked.nc1")


def text(words: str, x: float = 500.0, y: float = 140.0, **more: object) -> TextMark:
    values: dict[str, object] = {"face": "v", "angle": 0.0, "height": 10.0} | more
    option = values.pop("option", "")
    return TextMark(x=x, y=y, text=words, source=SOURCE, option=option, **values)  # type: ignore[arg-type]


def told(posted: Posted, machine: Machine) -> list[tuple[str, str, float, float, float, float]]:
    """What a parser of the test finds: string, face, x and y on the part, height and angle."""
    found = []
    for event in cell_events(posted.text, machine)[0]:
        if isinstance(event, Lettering):
            faces = {number: face for face, number in machine.marks.faces.items()}
            face = faces[int(event.values.get("face", 1))]
            before = posted.text.splitlines()[: event.line - 1]
            line = next(block for block in reversed(before) if " X" in block)
            x = float(line.rpartition("X")[2]) - (machine.marks.x or 0.0)
            values = event.values
            found.append(
                (event.text, face, x, values["y"], values["height"], values.get("angle", 0.0))
            )
    return found


def found_in(program: str, machine: Machine, *features: TextMark) -> tuple[Diagnostic, ...]:
    return read_back(program, Request((part(*features),), machine))


def codes(found: tuple[Diagnostic, ...]) -> set[str]:
    return {said.code for said in errors_in(found)}


@given(
    st.text("ABCXYZ0189-/. ", min_size=1, max_size=8).filter(str.strip),
    st.floats(-50.0, 3050.0), st.floats(-10.0, 310.0), st.sampled_from(["v", "o"]),
    st.sampled_from([0.0, 180.0]), st.floats(3.0, 30.0),
)  # fmt: skip
@settings(max_examples=examples(20))
def test_each_text_is_told_once_and_lies_on_its_face(
    words: str, x: float, y: float, face: str, angle: float, height: float
) -> None:
    asked = text(words, x, y, face=face, angle=angle, height=height)
    posted = post([part(asked, hole(500.0, 150.0))], STAMP)
    ((said, on, at, up, high, turned),) = told(posted, STAMP)
    front = 20.0  # the front trim
    assert (said, on, turned) == (words, face, angle)
    assert high in STAMP.marks.heights
    left = high * 0.8 * len(words)
    low, top = (at - front, at - front + left) if angle == 0.0 else (at - front - left, at - front)
    assert low >= -1e-3 + 10.0
    assert top <= 3000.0 - 10.0 + 1e-3
    up_or_down = (1.0 if face == "v" else -1.0) * (1.0 if angle == 0.0 else -1.0)
    ys = sorted((up, up + up_or_down * high))
    assert ys[0] >= 10.0 - 1e-3
    assert ys[1] <= (300.0 if face == "v" else 150.0) - 10.0 + 1e-3


def test_a_character_that_is_not_there_is_told_and_replaced_never_lost() -> None:
    posted = post([part(text("b_1é"), text("½", 900.0), text("Ω", 1300.0))], STAMP)
    assert [one[0] for one in told(posted, STAMP)] == [
        "B-1E", "1/2", "GREEK CAPITAL LETTER OMEGA",
    ]  # fmt: skip
    assert sum(said.code == "plan-text-sign" for said in posted.remarks) == 5
    digits = replace(STAMP, marks=replace(STAMP.marks, characters="0123456789"))
    left = post([part(text("A1"))], digits)
    assert [(o.how, o.by) for o in left.plan.outcomes] == [("listed", "characters")]


def test_the_nearest_height_is_taken_and_that_is_told() -> None:
    posted = post([part(text("A", height=14.0))], STAMP)
    assert [one[4] for one in told(posted, STAMP)] == [16.0]
    assert [said.code for said in posted.remarks] == ["plan-text-height"]
    assert [one[4] for one in told(post([part(text("A", height=14.0))], PRINTER), PRINTER)] == [14]


@pytest.mark.parametrize(
    ("asked", "why"),
    [
        (text("A", face="u"), "face"),
        (text("A", angle=90.0), "angle"),
        (text("A", height=11.0, option="z"), "height"),
        (text("A" * 400), "no-room"),
        (text(" "), "blank"),
    ],
)
def test_what_the_unit_cannot_letter_is_on_the_list(asked: TextMark, why: str) -> None:
    posted = post([part(asked)], STAMP)
    assert [(o.how, o.by) for o in posted.plan.outcomes] == [("listed", why)]
    assert {"plan-by-hand", "verify-by-hand"} & {said.code for said in posted.remarks}


def test_a_printer_lists_what_is_too_small() -> None:
    posted = post([part(text("A", height=2.0))], PRINTER)
    assert [o.by for o in posted.plan.outcomes] == ["too-small"]


P12 = 'M60 K1 L10 P140 R0 "P12"'
WRONG = {
    "a character is another": (P12, P12.replace("P12", "P13")),
    "upside down": (P12, P12.replace("R0", "R180")),
    "another face": (P12, P12.replace("K1", "K2")),
    "no such face": (P12, P12.replace("K1", "K7")),
    "another height": (P12, P12.replace("L10", "L16")),
    "no such height": (P12, P12.replace("L10", "L9")),
    "elsewhere across": (P12, P12.replace("P140", "P141")),
    "elsewhere along": ("G00 X2320\n", "G00 X2321\n"),
    "not told": (P12, "M08"),
    "told twice": (P12, f"{P12}\n{P12}"),
    "told otherwise": (P12, P12.replace('"', "'")),
    "before the bar stands anywhere": ("N4 G00 X17.98", f"{P12}\nN4 G00 X17.98"),
    "behind the end": ("M30", f"M30\n{P12}"),
}


@pytest.mark.parametrize("how", WRONG)
def test_a_text_that_is_told_otherwise_is_refused(how: str) -> None:
    asked = text("P12")
    program = post([part(asked)], STAMP).text
    assert not errors_in(found_in(program, STAMP, asked))
    old, new = WRONG[how]
    assert program.count(old) == 1, program
    assert errors_in(found_in(program.replace(old, new), STAMP, asked))


def test_a_text_over_a_hole_or_missing_is_refused_by_name() -> None:
    asked = text("P12")
    program = post([part(asked)], STAMP).text
    request = Request((part(asked, hole(505.0, 150.0)),), STAMP)
    assert "verify-text" in codes(read_back(program, request))
    assert codes(found_in(program, STAMP, text("P13"))) == {
        "verify-text-missing", "verify-text-extra",
    }  # fmt: skip


def test_pieces_of_a_bar_have_their_own_texts() -> None:
    one = part(text("P12"), length=1000.0)
    posted = post([one, one], STAMP)
    first, second = told(posted, STAMP)
    assert second[2] - first[2] == pytest.approx(1004.04)
    lines = posted.text.splitlines()
    (lost,) = (
        k for k, line in enumerate(lines) if '"' in line and f"X{1800 + 520:g}" in lines[k - 1]
    )
    program = "\n".join(lines[:lost] + lines[lost + 1 :])
    found = read_back(program, Request((one, one), STAMP))
    assert "verify-text-missing" in codes(found)


def test_recover_diff_simulate_and_plot_follow_the_texts(tmp_path: Path) -> None:
    out, machine = str(tmp_path / "marked.gcode"), ["--machine", str(FILES["stamp"])]

    def called(*words: str) -> str:
        done = call(*words, *machine)
        assert done.exit_code in (0, 1), done.stderr
        return done.stdout

    called("post", MARKED, "-o", out)
    called("recover", out, "--profile", "IPE300", "-o", str(tmp_path / "again.json"))
    again = json.loads((tmp_path / "again.json").read_text(encoding="utf-8"))
    texts = again["texts"] if "texts" in again else again["parts"][0]["texts"]
    assert [(t["text"], t["face"], t["height"]) for t in texts] == [
        ("B-12", "v", 10), ("B-12", "v", 10), ("B-12", "o", 16),
    ]  # fmt: skip
    other = tmp_path / "other.gcode"
    other.write_text(Path(out).read_text(encoding="utf-8").replace('R0 "B-12"', 'R0 "B-13"', 1))
    made = [run(Path(p).read_text(encoding="utf-8"), STAMP).made for p in (out, str(other))]
    assert [d.text for d in diff_programs(*made, 0.001)] == [
        "text 'B-12' v at x 2120.0 text 'B-12' to 'B-13'"
    ]
    assert ">B-12<" in called("plot", out, "-o", "-")
    trace = called("simulate", out, "-o", "-").splitlines()
    times = [float(row.partition(",")[0]) for row in trace[1:]]
    assert sum(b - a == pytest.approx(7.0) for a, b in pairwise(times)) == 3
    explained = called("plan", MARKED)
    assert "stamp 10" in explained
    assert "'B-12' at 180 deg" in explained


BAD: list[tuple[str, Callable[[str], str], str]] = [
    ("no characters", lambda t: t.replace("ABC", "\\t"), "marks.characters"),
    ("a quote among them", lambda t: t.replace("/. ", "/. \\\""), "character behind {string}"),
    ("no face", lambda t: t.replace("faces = { v = 1, o = 2 }", ""), "marks.faces"),
    ("an unknown face", lambda t: t.replace("v = 1", "w = 1"), "among v, o, u, h"),
    ("one number for two", lambda t: t.replace("o = 2", "o = 1"), "a number of its own"),
    ("no angle", lambda t: t.replace("[0, 180]", "[]"), "marks.angles"),
    ("before the saw", lambda t: t.replace("x = 1800", "x = -5"), "at least saw.x"),
    ("no word", lambda t: t.partition("[words]")[0], "one line with {string}"),
    ("no height told", lambda t: t.replace(" L{height}", ""), "{height} beside {string}"),
    ("no y told", lambda t: t.replace(" P{y}", ""), "{y} beside {string}"),
    ("y told twice", lambda t: t.replace(" P{y}", " P{y} Q{y}"), "{y} once"),
    ("nowhere", lambda t: t.replace('"G00 X{x}", ', ""), "a line before it with X{x}"),
    ("the bar comes later",
     lambda t: t.replace('["G00 X{x}", ', "[").replace("\"']", "\"', 'G00 X{x}']"),
     "a move to X{x} before {string}"),
]  # fmt: skip


@pytest.mark.parametrize(("change", "says"), [b[1:] for b in BAD], ids=[b[0] for b in BAD])
def test_what_a_stamp_lacks_is_told_at_its_key(
    change: Callable[[str], str], says: str, tmp_path: Path
) -> None:
    from beamcam.arguments import load_machine

    plain = FILES["stamp"].read_text(encoding="utf-8")
    path = tmp_path / "mine.toml"
    path.write_text(change(plain), encoding="utf-8")
    assert path.read_text(encoding="utf-8") != plain
    with pytest.raises(MachineError) as caught:
        load_machine(str(path))
    assert says in "\n".join(map(str, caught.value.diagnostics))


def test_a_table_is_told_no_texts(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('base = "plate-linuxcnc"\n[marks]\nunit = "stamp"\n', encoding="utf-8")
    with pytest.raises(MachineError, match="scribe, plasma or laser"):
        load(str(path))


def test_a_line_of_linuxcnc_tells_texts_too(tmp_path: Path) -> None:
    hall = SAMPLES / "machines" / "hall-drill.toml"
    path = tmp_path / "mine.toml"
    path.write_text(
        f'base = "{hall.as_posix()}"\n[marks]\ntext = "make"\nunit = "printer"\n'
        'characters = "ABC123-"\nfaces = { v = 1 }\n'
        "[words]\nprinter = ['G0 X{x}', '(PRINT,{height},{y},{string})']\n",
        encoding="utf-8",
    )
    machine = load(str(path))
    asked = text("C-12", 200.0, 60.0)
    try:
        posted = post([part(asked, hole(300.0, 60.0), length=800.0)], machine)
    except VerifyError as error:
        pytest.fail(str(error))
    assert "(PRINT,10,60,C-12)" in posted.text
