"""Whatever can be planned is read back without a word, and a part that differs is told apart."""

from typing import Any

from hypothesis import assume, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.bars import run, verify
from beamcam.comparison.bars import diff_programs
from beamcam.errors import PlanError, Source, errors_in
from beamcam.machine import load
from beamcam.model.part import EndCuts, Hole, Part, Profile, Slot
from beamcam.pipeline import post
from tests.conftest import examples

PROFILES = (
    Profile("I", "IPE300", 300.0, 150.0, 10.7, 7.1, 15.0),
    Profile("U", "UPN200", 200.0, 75.0, 11.5, 8.5, 11.5),
    Profile("L", "L150*100*12", 150.0, 100.0, 12.0, 12.0, 12.0),
)
MACHINES = ("beamline", "beamline-annex", "beamline-pusher")
TENTHS = 10.0
TURNS = (0.0, 90.0, 30.0)


def tenths(least: float, greatest: float) -> st.SearchStrategy[float]:
    return st.integers(int(least * TENTHS), int(greatest * TENTHS)).map(lambda n: n / TENTHS)


@st.composite
def holes(draw: Any, length: float, kinds: tuple[str, ...]) -> Hole:
    kind = draw(st.sampled_from(kinds))
    diameter = draw(st.sampled_from((12.0, 16.0) if kind == "thread" else (9.0, 14.0, 17.5, 22.0)))
    depth = draw(st.sampled_from((None, 4.0))) if kind == "blind" else None
    face = draw(st.sampled_from("vou"))
    x, y = draw(tenths(150, length - 150)), draw(tenths(20, 55))
    return Hole(face, x, y, diameter, Source("p", 1), depth or None, kind)  # type: ignore[arg-type]


@st.composite
def bars(draw: Any, machine: str) -> tuple[Part, ...]:
    """Parts of one profile for a bar: flange holes now and then in pairs, ends square or skew."""
    profile = draw(st.sampled_from(PROFILES[: 2 if machine == "beamline-annex" else 3]))
    kinds = ("through", "through", "blind", "thread") if machine == "beamline-pusher" else (
        ("through", "blind") if machine == "beamline" else ("through",)
    )  # fmt: skip
    parts = []
    for _ in range(draw(st.integers(1, 3))):
        length = draw(tenths(500, 4000))
        found: list[Hole | Slot] = draw(st.lists(holes(length, kinds), max_size=8))
        for hole in [h for h in found if isinstance(h, Hole) and h.face == "o"]:
            near = draw(st.sampled_from((0.0, 0.05, 0.3)))
            found.append(replace(hole, face="u", x=hole.x + near))
        if machine == "beamline-pusher" and draw(st.booleans()):
            found.append(
                Slot("v", length / 2, 60.0, 18.0, 30.0, 0.0, draw(st.sampled_from(TURNS)),
                     Source("p", 2))
            )  # fmt: skip
        angles = [draw(st.sampled_from((0.0, 0.0, 30.0, -12.5, 4.37))) for _ in range(2)]
        cuts = EndCuts(*angles)
        parts.append(Part("P", profile, length, Source("p", 1), cuts=cuts, features=tuple(found)))
    if draw(st.booleans()):
        parts.append(parts[0])
    return tuple(parts)


@settings(deadline=None, max_examples=examples(120))
@given(st.sampled_from(MACHINES).flatmap(lambda m: st.tuples(st.just(m), bars(m))))
def test_what_is_planned_is_read_back(case: tuple[str, tuple[Part, ...]]) -> None:
    name, parts = case
    machine = load(name)
    try:
        text = post(parts, machine, bar=15000.0, verified=False).text
    except PlanError:
        assume(False)
    assert [str(d) for d in verify(text, parts, machine, bar=15000.0)] == []


@settings(deadline=None, max_examples=examples(80))
@given(
    bars("beamline"), st.integers(0, 10**6), st.sampled_from((0.01, 0.1, 1.0, 25.0)),
    st.sampled_from(("x", "y", "diameter", "length", "face", "cut", "gone", "more")),
)  # fmt: skip
def test_another_part_is_told_apart(
    parts: tuple[Part, ...], pick: int, by: float, what: str
) -> None:
    machine = load("beamline")
    try:
        text = post(parts, machine, bar=15000.0).text
    except PlanError:
        assume(False)
    index = pick % len(parts)
    part = parts[index]
    assume(part.features or what in ("length", "cut", "more"))
    other = (*parts[:index], changed(part, pick, by, what), *parts[index + 1 :])
    assume(other[index] != part)
    assert verify(text, other, machine) != ()


def changed(part: Part, pick: int, by: float, what: str) -> Part:
    """The part with one thing of it changed."""
    if what == "length":
        return replace(part, length=part.length + by)
    if what == "cut":
        return replace(part, cuts=replace(part.cuts, web_end=part.cuts.web_end + 1 + by))
    extra = Hole("v", part.length / 3 + by, 71.3, 14.0, Source("p", 3))
    if what == "more":
        return replace(part, features=(*part.features, extra))
    features = list(part.features)
    at = pick % len(features)
    hole = features[at]
    assert isinstance(hole, Hole)
    if what == "gone":
        twin = [h for h in part.holes if h is not hole and replace(h, source=hole.source) == hole]
        return part if twin else replace(part, features=(*features[:at], *features[at + 1 :]))
    # A pair may be merged though its holes are 0.05 apart, so less is no difference in x or y.
    step = max(by, 0.2)
    if what == "x":
        features[at] = replace(hole, x=hole.x + step)
    elif what == "y":
        features[at] = replace(hole, y=hole.y + step)
    elif what == "diameter":
        features[at] = replace(hole, diameter=hole.diameter + 3)
    else:
        features[at] = replace(hole, face="v" if hole.face != "v" else "o")
    return replace(part, features=tuple(features))


LETTERS = "NGMXYZFKLIJRTE%("
VALUES = [
    "0", "1", "2", "3", "4", "5", "8", "9", "13", "30", "40", "42", "43", "44", "45", "46", "49",
    "90", "91", "98", "-5", "61.4", "1098.56", "1e9", ".", "999999999999999",
]  # fmt: skip
ODD = ("/", "()", "(a", "%", ";", "\x00", "G75", "\N{ARABIC-INDIC DIGIT FIVE}", "X" + "9" * 5000)
WORDS = st.one_of(
    st.builds("{}{}".format, st.sampled_from(LETTERS), st.sampled_from(VALUES)),
    st.sampled_from(ODD),
)
TEXTS = st.lists(st.lists(WORDS, max_size=5).map(" ".join), max_size=40).map("\n".join)
FIXED = Part(
    "P", PROFILES[0], 1000.0, Source("p", 1),
    features=(Hole("v", 300.0, 80.0, 22.0, Source("p", 2)),
              Hole("o", 500.0, 40.0, 14.0, Source("p", 3)),
              Slot("v", 700.0, 150.0, 18.0, 30.0, 0.0, 0.0, Source("p", 4))),
)  # fmt: skip


@settings(deadline=None, max_examples=examples(300))
@given(st.sampled_from(MACHINES), TEXTS)
def test_any_text_at_all_is_answered_with_messages(name: str, text: str) -> None:
    for parts in ((), (FIXED,)):
        said = verify(text, parts, load(name))
        assert said
        assert all(str(d) for d in said)


@settings(deadline=None, max_examples=examples(200))
@given(st.sampled_from(MACHINES), TEXTS, st.integers(0, 60))
def test_nonsense_inside_of_a_program_is_found_or_changes_nothing(
    name: str, text: str, at: int
) -> None:
    machine = load(name)
    slotless = replace(FIXED, features=FIXED.features[:2])
    right = post((slotless,), machine, bar=6000.0).text
    lines = right.split("\n")
    lines[at:at] = text.split("\n")
    said = verify("\n".join(lines), (slotless,), machine)
    assert all(str(d) for d in said)
    if not errors_in(said):
        # It is only let through where it makes the same in every way that programs are compared.
        new, old = (run(program, machine).made for program in ("\n".join(lines), right))
        assert diff_programs(old, new, machine.format.resolution) == ()
