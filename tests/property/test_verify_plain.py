"""What is told of plain holes and square cuts at a glance is what looking closely tells."""

import random
import sys
from collections.abc import Sequence

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.errors import PlanError, Source
from beamcam.machine import Machine, load
from beamcam.model.part import Hole, Part, Profile
from beamcam.pipeline import post
from beamcam.verify import verify
from beamcam.verify.placing import Placing
from benchmarks.mutants import MUTATIONS
from benchmarks.mutation import cases

MUTANTS = 300
PROFILES = (
    Profile("I", "IPE300", 300.0, 150.0, 10.7, 7.1, 15.0),
    Profile("L", "L150*100*12", 150.0, 100.0, 12.0, 12.0, 12.0),
)
MACHINES = ("beamline", "beamline-annex", "beamline-pusher")
STEPS = (0.0, 0.001, 0.004, 0.02, 0.1, 0.25, 5.0)  #: between holes that lie close to each other


class Glances:
    """Counts how often a glance was enough."""

    def __init__(self, patch: pytest.MonkeyPatch) -> None:
        self.enough = self.square = 0
        self.closely = False
        compare = sys.modules["beamcam.verify.compare"]
        glance, square = compare.plainly_made, Placing._all_square

        def counted(*args):  # type: ignore[no-untyped-def]
            found = None if self.closely else glance(*args)
            self.enough += found is not None
            return found

        def placed(*args):  # type: ignore[no-untyped-def]
            found = not self.closely and square(*args)
            self.square += found
            return found

        patch.setattr(compare, "plainly_made", counted)
        patch.setattr(Placing, "_all_square", placed)

    def same(self, text: str, parts: Sequence[Part], machine: Machine) -> None:
        """Assert that a glance and a close look tell the same, before and after they learned."""
        told = [verify(text, parts, machine)]
        self.closely = True
        told.append(verify(text, parts, machine))
        self.closely = False
        told.append(verify(text, parts, machine))
        assert told[0] == told[1] == told[2]


@pytest.fixture(scope="module")
def glances():  # type: ignore[no-untyped-def]
    with pytest.MonkeyPatch.context() as patch:
        yield Glances(patch)


def test_mutants(glances: Glances) -> None:
    programs = list(cases())
    rng = random.Random(7)
    for case in programs:
        glances.same(case.text, case.parts, case.machine)
    before, square = glances.enough, glances.square
    for _ in range(MUTANTS):
        case = rng.choice(programs)
        lines = MUTATIONS[rng.randrange(len(MUTATIONS))](
            case.text.split("\n"), rng, case.machine.format.resolution
        )
        if lines is not None:
            glances.same("\n".join(lines), case.parts, case.machine)
    assert glances.enough > before  # such as a stroke that is a little longer
    assert glances.square > square


@st.composite
def close_holes(draw: st.DrawFn) -> Part:
    """Plain holes of which many lie close to each other."""
    holes: list[Hole] = []
    for line in range(draw(st.integers(1, 8))):
        face = draw(st.sampled_from("vou"))
        diameter = draw(st.sampled_from((14.0, 14.0, 17.5)))
        depth = draw(st.sampled_from((None, None, 4.0)))
        if holes and draw(st.booleans()):
            other = draw(st.sampled_from(holes))
            x = other.x + draw(st.sampled_from(STEPS))
            y = other.y + draw(st.sampled_from(STEPS))
        else:
            x, y = draw(st.integers(100, 900)) / 1.0, draw(st.sampled_from((40.0, 42.5, 55.25)))
        kind = "blind" if depth else "through"
        holes.append(Hole(face, x, y, diameter, Source("p", line), depth, kind))
    profile = draw(st.sampled_from(PROFILES))
    return Part("P", profile, 1000.0, Source("p", 1), grade="S355", features=tuple(holes))


@settings(deadline=None, max_examples=100)
@given(
    st.sampled_from(MACHINES), st.lists(close_holes(), min_size=1, max_size=2),
    st.integers(0, 99), st.sampled_from(STEPS), st.sampled_from(("x", "y", "diameter", "gone")),
)  # fmt: skip
def test_parts_with_holes_close_to_each_other(
    glances: Glances, name: str, parts: list[Part], pick: int, by: float, what: str
) -> None:
    machine = load(name)
    parts = [replace(part, profile=parts[0].profile) for part in parts]
    try:
        text = post(parts, machine, bar=6000.0).text
    except PlanError:
        assume(False)
    glances.same(text, parts, machine)
    features = list(parts[0].features)
    hole = features.pop(pick % len(features))
    assert isinstance(hole, Hole)
    if what != "gone":
        features.append(replace(hole, **{what: getattr(hole, what) + by}))
    other = replace(parts[0], features=tuple(features))
    glances.same(text, [other, *parts[1:]], machine)


def test_a_glance_is_enough_for_plain_holes(glances: Glances) -> None:
    machine = load("beamline")
    holes = [
        Hole(face, x, y, 14.0, Source("p", 3))
        for x in (200.0, 270.0, 900.0) for face in "vou" for y in (45.0, 105.0)
    ]  # fmt: skip
    part = Part("P", PROFILES[0], 1000.0, Source("p", 1), features=tuple(holes))
    text = post([part, part], machine, bar=6000.0).text
    before = glances.enough
    assert verify(text, [part, part], machine) == ()
    assert glances.enough == before + 1
