"""Texts on bars: lettered by a scribe, and read back stroke by stroke."""

from collections.abc import Callable
from itertools import pairwise

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.bars import run
from beamcam.errors import Diagnostic, errors_in
from beamcam.machine import load
from beamcam.model.part import EndCuts, Feature, Part, Profile, Slot, TextMark
from beamcam.model.request import Request
from beamcam.pipeline import Posted, post, read_back
from tests.conftest import examples
from tests.letters import Lines, read
from tests.unit.planning.shop import CHANNEL, SOURCE, TUBE, hole, part

PUSHER = load("beamline-pusher")
SKEW = EndCuts(web_start=20.0, web_end=-30.0)


def text(
    words: str, x: float = 500.0, y: float = 70.0, angle: float = 0.0, height: float = 10.0,
    face: str = "v", **more: str,
) -> TextMark:  # fmt: skip
    return TextMark(face, x, y, angle, height, words, SOURCE, **more)  # type: ignore[arg-type]


def lettered(program: str, one: Part, face: str) -> Lines:
    """The lines that the scribe draws on a face, as they are seen from outside."""
    made = run(program, PUSHER, one.profile).made
    up = -1.0 if face in ("o", "h") else 1.0
    return [
        ((a[0], up * a[1]), (b[0], up * b[1]))
        for path in made.paths
        if path.kind == "scribe" and path.face == face
        for a, b in pairwise(path.points)
    ]


def found_in(program: str, one: Part) -> tuple[Diagnostic, ...]:
    return read_back(program, Request((one,), PUSHER))


def listed(posted: Posted) -> list[str]:
    return [o.by for o in posted.plan.outcomes if o.how == "listed"]


@pytest.mark.parametrize("face", ["v", "o", "u"])
@pytest.mark.parametrize("angle", [0.0, 90.0, 180.0, 20.0])
def test_a_text_reads_right_on_every_face_seen_from_outside(face: str, angle: float) -> None:
    one = part(text("P-12/b", angle=angle, face=face))
    posted = post([one], PUSHER)
    assert posted.remarks == ()
    seen = -angle if face == "o" else angle
    assert read(lettered(posted.text, one, face), 10.0, seen) == "P-12/b"


@pytest.mark.parametrize(
    ("features", "more"),
    [
        ((text("X7"), hole(510, 72)), {}),
        ((text("X7", y=2.0),), {}),
        ((text("X7", 2995.0),), {}),
        ((text("X7", 0.0),), {"cuts": SKEW}),
        ((text("X7", 2990.0),), {"cuts": SKEW}),
        ((text("X7", 5.0, 20.0, face="o"),), {"cuts": EndCuts(flange_start=30.0)}),
        ((text("X7"), Slot("v", 510, 75, 18.0, 60.0, 0.0, 30.0, SOURCE)), {}),
        ((text("X7", y=-20.0),), {"profile": CHANNEL}),
        ((text("X7", y=260.0),), {"profile": TUBE}),
    ],
)
def test_a_text_that_does_not_stand_free_is_moved(
    features: tuple[Feature, ...], more: dict[str, object]
) -> None:
    one = part(*features, **more)
    posted = post([one], PUSHER)
    assert [said.code for said in posted.remarks] == ["plan-text-moved"]
    face = features[0].face  # type: ignore[union-attr]
    assert read(lettered(posted.text, one, face), 10.0).startswith("X7")


@given(
    st.floats(-50, 1050), st.floats(-20, 320), st.floats(4.0, 60.0),
    st.sampled_from([0.0, 90.0, 33.0]), st.sampled_from("vou"),
    st.lists(st.tuples(st.floats(100, 900), st.floats(60, 240)), max_size=1),
    st.floats(-30, 30), st.floats(-30, 30),
)  # fmt: skip
@settings(max_examples=examples(8), phases=[Phase.explicit, Phase.generate])
def test_what_is_planned_is_read_back(
    x: float, y: float, height: float, angle: float, face: str,
    holes: list[tuple[float, float]], start: float, end: float,
) -> None:  # fmt: skip
    drilled = [hole(round(a, 1), round(b, 1)) for a, b in holes]
    ends = EndCuts(web_start=start, web_end=end)
    one = part(text("M-4", x, y, angle, height, face), *drilled, length=1000.0, cuts=ends)
    posted = post([one], PUSHER, skips=("all",))
    assert posted.plan.outcomes[0].how in ("made", "listed")


T_BAR = Profile("T", "T100", 100.0, 100.0, 11.0, 11.0, 11.0)


@pytest.mark.parametrize(
    "voids",
    [
        [Slot("v", 500, 150, 80.0, 100.0, 0.0, 0.0, SOURCE)],
        [Slot("v", 500, 110, 40.0, 100.0, 80.0, 90.0, SOURCE)],
    ],
)
def test_there_is_no_steel_in_the_ends_of_a_slot(voids: list[Feature]) -> None:
    """One that is left out here is made elsewhere."""
    one = part(*voids, text("I", 500.0, 148.0, height=4.0))
    posted = post([one], PUSHER, skips={"slot"})
    moved = [said for said in posted.remarks if said.code == "plan-text-moved"]
    assert len(moved) == 1


@pytest.mark.parametrize("y", [1.0, 4.0, 6.0, 9.0, 40.0, 45.0, 60.0, 88.0, 95.0])
@pytest.mark.parametrize("profile", [TUBE, T_BAR], ids=["tube", "T"])
def test_a_text_stands_clear_of_corners_and_stems(profile: Profile, y: float) -> None:
    """Wherever the part has it: what is planned is read back, and no letter is on the stem."""
    one = part(text("X7", y=y), profile=profile, length=1200.0)
    posted = post([one], PUSHER)
    ys = [point[1] for line in lettered(posted.text, one, "v") for point in line]
    if profile is TUBE:
        assert min(ys) >= 8.0 + 3.0 - 0.01
    else:
        foot = 11.0 / 2 + 11.0 + 3.0 - 0.01
        assert max(ys) <= 50.0 - foot or min(ys) >= 50.0 + foot


def test_what_cannot_be_lettered_is_left_to_the_hand() -> None:
    assert listed(post([part(text("A", face="h"))], PUSHER)) == ["face"]
    assert listed(post([part(text("A" * 2000))], PUSHER)) == ["no-room"]
    over = part(hole(505, 75), text("A", option="z"))
    assert listed(post([over], PUSHER)) == ["no-room"]
    assert listed(post([part(text("A", height=1.0))], PUSHER)) == ["too-small"]


def test_two_pieces_of_a_part_are_both_lettered() -> None:
    one = part(text("A1", 500.0, 150.0))
    posted = post([one, one], PUSHER)
    assert {o.feature[0] for o in posted.plan.outcomes if o.how == "made"} == {0, 1}
    assert not errors_in(read_back(posted.text, Request((one, one), PUSHER)))


WRONG: dict[str, Callable[[TextMark], TextMark]] = {
    "a character is another": lambda t: replace(t, text="P13"),
    "a character is missing": lambda t: replace(t, text="P1"),
    "a character is too much": lambda t: replace(t, text="P122"),
    "upside down": lambda t: replace(t, x=530.0, y=80.0, angle=180.0),
    "on another face": lambda t: replace(t, face="o"),
    "moved though there is room": lambda t: replace(t, y=71.0),
    "smaller though there is room": lambda t: replace(t, height=9.0),
    "larger": lambda t: replace(t, height=11.0),
}


@pytest.mark.parametrize("how", WRONG)
def test_a_text_that_is_another_is_refused(how: str) -> None:
    asked = text("P12")
    program = post([part(WRONG[how](asked))], PUSHER).text
    assert errors_in(found_in(program, part(asked)))


def test_a_text_over_a_hole_or_mirrored_is_refused() -> None:
    asked = text("P12", 500.0, 150.0)
    program = post([part(asked)], PUSHER).text
    over = [d.code for d in found_in(program, part(hole(505, 155), asked))]
    assert "verify-text" in over
    mirrored = "\n".join(
        block.replace("Y-", "Y+").replace("Y+", "Y") if "G0" in block else block
        for block in program.splitlines()
    )
    assert errors_in(found_in(mirrored, part(asked)))


def test_a_text_that_is_not_made_though_it_could_be_is_refused() -> None:
    program = post([part()], PUSHER).text
    assert errors_in(found_in(program, part(text("P12"))))
    assert not errors_in(found_in(program, part(text("P12", face="h"))))
