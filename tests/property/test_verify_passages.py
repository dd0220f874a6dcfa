"""Passages that are known say of any program what the interpreter says, or nothing."""

import random
import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.machine import Machine, load
from beamcam.model.part import Profile
from beamcam.verify import run
from beamcam.verify.alone import Passage
from beamcam.verify.made import Made
from beamcam.verify.meaning import meaning_of
from beamcam.verify.passages import MOST_KNOWN, Bar, Passages
from beamcam.verify.stations import choices_of
from benchmarks.mutants import MUTATIONS, REWRITES
from benchmarks.mutation import Case, cases
from tests.unit.verify.programs import BEAM, IPE200, PROGRAM

MUTANTS = 1500


def known(text: str, profile: Profile, machine: Machine, passages: Passages) -> Made | None:
    return passages.made(text, profile, choices_of(machine, profile))


def known_of(bar: Bar) -> list[Passage]:
    """All passages that are known of a bar."""
    return [passage for passages in bar.known.values() for passage in passages.values()]


def judged(text: str, profile: Profile, machine: Machine, passages: Passages) -> str:
    """ "unknown", or "right" if what is known is what the interpreter finds, without a fault."""
    made = known(text, profile, machine, passages)
    if made is None:
        return "unknown"
    done = run(text, machine, profile)
    return "right" if (done.made, done.diagnostics) == (made, ()) else "wrong"


@pytest.fixture(scope="module")
def programs() -> list[Case]:
    return list(cases())


@pytest.fixture(scope="module")
def shops() -> dict[str, Passages]:
    machines = [load(name) for name in ("beamline", "beamline-annex", "beamline-pusher")]
    return {m.name: Passages(m, meaning_of(m)) for m in machines}


def test_programs_of_strokes_and_cuts_are_known(
    programs: list[Case], shops: dict[str, Passages]
) -> None:
    for case in programs:
        passages, profile = shops[case.machine.name], case.parts[0].profile
        mills = "mill" in {t.kind for t in case.machine.tools}  # paths have more than one X
        for _ in ("first", "again"):
            said = judged(case.text, profile, case.machine, passages)
            assert said == "right" or (mills and said == "unknown"), case.name


def test_mutants_are_known_only_for_what_they_are(
    programs: list[Case], shops: dict[str, Passages]
) -> None:
    rng = random.Random(5)
    taken = 0
    for _ in range(MUTANTS):
        case = rng.choice(programs)
        lines = case.text.split("\n")
        for _ in range(rng.choice((1, 2, 3))):
            step = case.machine.format.resolution
            lines = rng.choice(MUTATIONS)(lines, rng, step) or lines
        text = "\n".join(lines)
        if rng.random() < 0.2 and text.count("\n") > 12:
            text = rng.choice(REWRITES)(text, rng)
        profile, passages = case.parts[0].profile, shops[case.machine.name]
        said = judged(text, profile, case.machine, passages)
        assert said != "wrong"
        taken += said == "right"
    assert taken > MUTANTS / 50  # such as another X of a hole, which is a fault of the part alone


LINES = PROGRAM.split("\n")
EXTRA = (
    "G91", "G90", "G00 X1098.56 Y20", "G01 X1098.56 Y20 Z61.409", "G00 Z-5", "M05", "M30",
    "(X1 M30)", "%", "N3 N4 M05", "M40 K2 L22", "M40 K1 L14", "G01 X17.98 F41.667",
    "M42 K0 F41.667", "M03 K362", "G01 X17.98",
    "M43 K1", "M44 K100 L200", "M44 K100 L201", "g00 x5", "G00 X", "G00 X5 X6", "\0",
    "G04 T1", "G02 X1 Y1 R5", "M77", "",
)  # fmt: skip


@settings(deadline=None, max_examples=400)
@given(
    st.lists(st.tuples(st.integers(0, len(LINES) - 1), st.sampled_from(EXTRA)), max_size=3),
    st.lists(st.integers(0, len(LINES) - 1), max_size=3),
)
def test_lines_put_in_and_left_out(put: list[tuple[int, str]], out: list[int]) -> None:
    lines = [line for i, line in enumerate(LINES) if i not in out]
    for at, line in put:
        lines.insert(min(at, len(lines)), line)
    passages = Passages(BEAM, meaning_of(BEAM))
    assert judged(PROGRAM, IPE200, BEAM, passages) == "right"
    assert judged("\n".join(lines), IPE200, BEAM, passages) != "wrong"


NUMBER = re.compile(r"(?<= [XYZFKL])[-.0-9]+")
NUMBERS = (
    "0", "-0", "+20", "20.", ".5", "20.0", "020", "1.2.3", "--2", "2-", ".", "-", "1e3", "nan",
    "1_0", "123456789012345", "1234567890123456", "20.00000000000001", "20.000000000000001", "X20",
    "2 0",
)  # fmt: skip


@settings(deadline=None, max_examples=300)
@given(st.integers(0), st.sampled_from(NUMBERS), st.booleans(), st.booleans())
def test_numbers_written_in_any_way(pick: int, number: str, everywhere: bool, bare: bool) -> None:
    places = list(NUMBER.finditer(PROGRAM))
    at = places[pick % len(places)]
    text = PROGRAM[: at.start()] + number + PROGRAM[at.end() :]
    if everywhere:  # in all blocks of its passage and of others
        text = re.sub(rf"(?<= [XYZ]){re.escape(at[0])}(?=[ \n])", number, PROGRAM)
    if bare:
        text = re.sub(r"(?m)^N\d+ ", "", text)
    passages = Passages(BEAM, meaning_of(BEAM))
    for _ in ("first", "again"):
        assert judged(text, IPE200, BEAM, passages) != "wrong"


def test_a_passage_taken_for_another_is_judged_wrong() -> None:
    passages = Passages(BEAM, meaning_of(BEAM))
    assert judged(PROGRAM, IPE200, BEAM, passages) == "right"
    (bar,) = passages._bars.values()
    for known in bar.known.values():
        for words, passage in known.items():
            if passage.cut is None:
                known[words] = passage._replace(lines=passage.lines + 1)
    assert judged(PROGRAM, IPE200, BEAM, passages) == "wrong"


def test_blocks_without_numbers_are_another_form() -> None:
    passages = Passages(BEAM, meaning_of(BEAM))
    bare = re.sub(r"(?m)^N\d+ ", "", PROGRAM)
    for text in (PROGRAM, bare, PROGRAM, bare):
        assert judged(text, IPE200, BEAM, passages) == "right"
    odd = re.sub(r"(?m)^N(\d)\b", r"N4711\1", PROGRAM)
    assert odd != PROGRAM
    assert judged(odd, IPE200, BEAM, passages) == "right"


@pytest.mark.parametrize(("old", "new"), [
    ("N4 G00 X17.98", "N4 G01 X17.98"),  # at a feed from nowhere
    ("N11 G01 X1098.56 Y20 Z61.409 F1.507", "N11 G01 X1098.56 Y20 Z61.409"),
    ("N14 M05\n", ""),  # it is left turning
    ("N12 G00 X1098.56 Y20 Z-5", "N12 G00 X1098.56 Y20 Z5"),  # and here in the bar
    ("N7 G00 X1098.56 Y20 Z-5", "N7 G00 X1098.56 Z-5"),  # across from where it was before
    ("N12 G00 X1098.56", "N12 G00 X1098.57"),
    ("N10 M08", "N10 M08\nG75"),
    ("X1498.56", "X998.56"),  # the stop would have to go back
    ("X17.98", "X-17.98"),
    ("N3 M43 K1\n", ""),
    ("N25 M30", "N25 M30\nN26 M30"),
    ("N22 M05\n", "N22 M05\n(by hand)\n"),
])  # fmt: skip
def test_what_depends_on_more_than_itself_is_left_to_the_interpreter(old: str, new: str) -> None:
    passages = Passages(BEAM, meaning_of(BEAM))
    assert known(PROGRAM, IPE200, BEAM, passages) is not None
    assert old in PROGRAM
    assert known(PROGRAM.replace(old, new), IPE200, BEAM, passages) is None
    assert known(PROGRAM, IPE200, BEAM, passages) is not None


def test_a_stroke_is_known_at_any_place_that_it_reaches_freely() -> None:
    passages = Passages(BEAM, meaning_of(BEAM))
    assert judged(PROGRAM, IPE200, BEAM, passages) == "right"
    (bar,) = passages._bars.values()
    before = known_of(bar)
    for web, flange in (("20", "158.6"), ("-31.5", "158.6"), ("0", "120"), ("91", "-300")):
        text = PROGRAM.replace("Y20 ", f"Y{web} ").replace("Z158.6", f"Z{flange}")
        assert judged(text, IPE200, BEAM, passages) == "right"
    assert known_of(bar) == before
    for web, flange in (("92", "158.6"), ("-600", "158.6"), ("20", "-321"), ("20", "201")):
        text = PROGRAM.replace("Y20 ", f"Y{web} ").replace("Z158.6", f"Z{flange}")
        assert judged(text, IPE200, BEAM, passages) == "unknown"


def test_another_section_is_another_bar() -> None:
    passages = Passages(BEAM, meaning_of(BEAM))
    thinner = Profile("I", "W", 200.0, 100.0, 8.5, 4.0, 12.0)
    first, other = (known(PROGRAM, p, BEAM, passages) for p in (IPE200, thinner))
    assert first is not None
    assert other is not None
    assert first.bores[0].tip_depth != other.bores[0].tip_depth
    assert run(PROGRAM, BEAM, thinner).made == other


def test_what_is_kept_has_a_bound() -> None:
    passages = Passages(BEAM, meaning_of(BEAM))
    for number in range(MOST_KNOWN + 10):
        text = PROGRAM.replace("Z61.409", f"Z{61 + number / 1000:.3f}")
        agreed = known(text, IPE200, BEAM, passages)
        assert agreed is not None
    assert 0 < sum(len(known_of(bar)) for bar in passages._bars.values()) <= MOST_KNOWN
