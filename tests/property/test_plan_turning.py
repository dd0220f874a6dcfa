"""The eight ways that a part may lie: turned, worked and turned back it is the same part."""

from collections.abc import Iterator

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.errors import Source
from beamcam.geometry.curves import Arc, Line
from beamcam.machine import load
from beamcam.machine.machine import saw_of
from beamcam.model.part import (
    Bend,
    Bevel,
    Camber,
    Contour,
    EndCuts,
    EndPlane,
    Hole,
    Notch,
    Part,
    Plane,
    Profile,
    SectionPoint,
    Slot,
    TextMark,
    Vector,
)
from beamcam.model.plan import SKIP_NAMES, DrillOp, PathOp, SawOp
from beamcam.planning.beam import plan_bar
from beamcam.planning.operations.finished_part import ends_of
from beamcam.planning.turning import TURNS, Turn, alike, lies, turned
from tests.conftest import examples

SOURCE = Source("a.nc1", 1)
SAW = saw_of(load("beamline-pusher"))
PROFILES = {
    "I": Profile("I", "IPE300", 300.0, 150.0, 10.7, 7.1, 15.0),
    "U": Profile("U", "UPN200", 200.0, 75.0, 11.5, 8.5, 11.5),
    "L": Profile("L", "L150*100*12", 150.0, 100.0, 12.0, 12.0, 12.0),
    "M": Profile("M", "RHS200*120*8", 200.0, 120.0, 8.0, 8.0, 8.0),
    "T": Profile("T", "T100", 100.0, 90.0, 11.0, 10.0, 5.0),
}
CODES = st.sampled_from(sorted(PROFILES))
FACES = st.sampled_from(("v", "o", "u", "h"))


def turn_between(part, other):
    """The turn that makes `part` the same piece of steel as `other`; None if there is none.

    Parts that are mirror images of each other have no such turn, unless they are symmetrical.
    """
    return next((t for t in TURNS if alike(turned(part, t), other)), None)


@st.composite
def parts(draw: st.DrawFn, code: str | None = None) -> Part:
    """Parts with holes, slots, lines, bevels and texts on all faces, and skew ends."""
    profile = PROFILES[code or draw(CODES)]
    length = draw(st.integers(1300, 4000)) / 1.0
    features: list[Hole | Slot | Contour | TextMark] = []
    for _ in range(draw(st.integers(1, 6))):
        face = draw(FACES)
        width = profile.face_width(face)
        x, y = draw(st.floats(100, length - 100)), draw(st.floats(15, width - 15))
        angle = draw(st.sampled_from((0.0, 30.0, 90.0, 180.0, -90.0, -45.0)))
        edge = draw(st.sampled_from(("", "u", "o", "s")))
        kind = draw(st.integers(0, 3))
        if kind == 0:
            features.append(
                Hole(face, x, y, draw(st.sampled_from((14.0, 18.0))), SOURCE, edge=edge)
            )
        elif kind == 1:
            features.append(Slot(face, x, y, 18.0, 20.0, 0.0, angle, SOURCE, edge=edge))
        elif kind == 2:
            corner = (x + 5, y)
            chain = (Line((x, y), corner), Arc((x + 5, y + 5), 5.0, -90.0, 90.0))
            features.append(
                Contour(face, "open", chain, SOURCE, "mark", False, (Bevel(0, 30.0, 2.0),),
                        (Notch(1, "t", (x + 10, y), 5.0),), edge)
            )  # fmt: skip
        else:
            features.append(TextMark(face, x, y, angle, 10.0, "A1", SOURCE, edge=edge))
    angles = st.sampled_from((0.0, 10.0, -20.0))
    cuts = EndCuts(*(draw(angles) for _ in range(4)))
    return Part("A", profile, length, SOURCE, cuts=cuts, features=tuple(features))


def in_space(part: Part, face: str, x: float, y: float) -> Vector:
    """A place on a face in the section's axes."""
    height, width = part.profile.height, part.profile.width
    return {
        "v": (x, y, width), "h": (x, y, 0.0), "o": (x, height, y), "u": (x, 0.0, y)
    }[face]  # fmt: skip


def rotated(part: Part, turn: Turn, at: Vector) -> Vector:
    """A place after the rotation about the middle of the part's box, by the matrix."""
    box = part.length, part.profile.height, part.profile.width
    centred = [value - size / 2 for value, size in zip(at, box, strict=True)]
    after = box if not turn.swap else (box[0], box[2], box[1])
    x, y, z = (
        sum(m * v for m, v in zip(row, centred, strict=True)) + size / 2
        for row, size in zip(turn.matrix, after, strict=True)
    )
    return x, y, z


def determinant(rows: tuple[Vector, Vector, Vector]) -> float:
    (a, b, c), (d, e, f), (g, h, i) = rows
    return a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)


def places(part: Part) -> Iterator[tuple[str, float, float]]:
    """Points that say where every feature is, and which way it points."""
    for f in part.features:
        if isinstance(f, Contour):
            yield from ((f.face, *curve.point(t)) for curve in f.curves for t in (0.0, 0.4, 1.0))
            yield from ((f.face, *notch.corner) for notch in f.notches)
        elif isinstance(f, Hole | Slot | TextMark):
            yield f.face, f.x, f.y


def undo(turn: Turn) -> Turn:
    """The turn that brings a part back: a rotation's inverse is its transpose."""
    (back,) = (t for t in TURNS if t.matrix == tuple(zip(*turn.matrix, strict=True)))
    return back


def test_the_turns_are_the_eight_rotations() -> None:
    assert len({t.matrix for t in TURNS}) == 8
    for turn in TURNS:
        assert determinant(turn.matrix) == 1.0
        assert undo(turn) in TURNS


@settings(max_examples=examples(150), deadline=None)
@given(parts())
def test_every_place_is_where_the_rotation_brings_it(part: Part) -> None:
    for turn in TURNS:
        lying = turned(part, turn)
        assert lying.profile.height == (part.profile.width if turn.swap else part.profile.height)
        for (face, x, y), (to, new_x, new_y) in zip(places(part), places(lying), strict=True):
            expected = rotated(part, turn, in_space(part, face, x, y))
            assert in_space(lying, to, new_x, new_y) == pytest.approx(expected, abs=1e-9)


@settings(max_examples=examples(150), deadline=None)
@given(parts())
def test_turned_and_turned_back_is_the_part(part: Part) -> None:
    for turn in TURNS:
        back = turned(turned(part, turn), undo(turn))
        assert back.profile == part.profile
        assert back.cuts == part.cuts
        found = turn_between(back, part)
        assert found is not None
        assert found.name == TURNS[0].name
        for f, g in zip(part.features, back.features, strict=True):
            assert f.edge == g.edge  # type: ignore[union-attr]
            if isinstance(f, Slot | TextMark):
                assert isinstance(g, Slot | TextMark)
                assert (f.angle - g.angle) % 360 == pytest.approx(0, abs=1e-9)


@settings(max_examples=examples(100), deadline=None)
@given(parts("M"))
def test_end_planes_turn_with_the_part(part: Part) -> None:
    for end in ends_of(part, SAW)[0]:
        for turn in TURNS:
            lying = turned(part, turn)
            ends = ends_of(lying, SAW)[0]
            same = (
                ends[1 - int(end.at == "start")]
                if not turn.reverse_x
                else (ends[int(end.at == "start")])
            )
            for y in (0.0, part.profile.height):
                for z in (0.0, part.profile.width):
                    x, new_y, new_z = rotated(part, turn, (end.x(y, z), y, z))
                    assert same.x(new_y, new_z) == pytest.approx(x, abs=1e-6)


def asymmetric(code: str) -> Part:
    """A part that no turn and no mirror maps to itself."""
    profile = PROFILES[code]
    low, high = profile.height / 4, profile.height / 3
    features = (
        Hole("v", 300.0, high, 14.0, SOURCE),
        Hole("v", 500.0, profile.height - low, 18.0, SOURCE),
        Hole("u", 700.0, profile.width / 3, 14.0, SOURCE),
    )
    if code in ("I", "U", "M"):
        features = (
            *features,
            Hole("o", 450.0, profile.width / (2 if code == "U" else 4), 18.0, SOURCE),
        )
    cuts = EndCuts(web_start=10.0)
    return Part("A", profile, 2000.0, SOURCE, cuts=cuts, features=features)


def mirrored(part: Part) -> Part:
    """The part in a mirror across its length: end for end, and nothing else."""
    features = tuple(replace(f, x=part.length - f.x) for f in part.features if isinstance(f, Hole))
    cuts = EndCuts(-part.cuts.web_end + 0.0, -part.cuts.web_start)
    return replace(part, features=features, cuts=cuts)


@pytest.mark.parametrize("code", sorted(PROFILES))
def test_mirrored_twins_are_told_apart(code: str) -> None:
    part = asymmetric(code)
    assert len({repr(turned(part, t).features) for t in TURNS}) == 8
    for turn in TURNS:
        lying = turned(part, turn)
        found = turn_between(part, lying)
        assert found is not None
        assert found.name == turn.name
        assert turn_between(mirrored(part), lying) is None
    assert turn_between(mirrored(mirrored(part)), part) == TURNS[0]


def test_a_part_that_is_its_own_mirror_image_is_not_told_apart() -> None:
    hole = Hole("v", 1000.0, 150.0, 14.0, SOURCE)
    part = Part("A", PROFILES["I"], 2000.0, SOURCE, features=(hole,))
    assert turn_between(mirrored(part), part) == TURNS[0]


@pytest.mark.parametrize("code", sorted(PROFILES))
@pytest.mark.parametrize("turn", TURNS, ids=lambda t: t.name)
def test_planned_and_undone_the_holes_are_those_of_the_part(code: str, turn: Turn) -> None:
    """Every stroke of the turned part's plan is taken back into the part's own axes."""
    part = asymmetric(code)
    lying = turned(part, turn)
    machine = load("beamline-pusher")
    assert machine.drill is not None
    assert machine.saw is not None
    # Half of the turns lean the blade the other way.
    machine = replace(machine, saw=replace(machine.saw, min_tilt=-45.0))
    if not lies(part.profile, turn):
        assert any(t.name != turn.name and lies(part.profile, t) for t in TURNS)
        return
    plan = plan_bar([lying], machine, skips=SKIP_NAMES)
    made = set()
    for op in plan.operations:
        if isinstance(op, SawOp):
            continue
        assert isinstance(op, DrillOp | PathOp)
        x = op.x - machine.drill.x - plan.pieces[0].start
        hole = Hole(op.faces[0], x, op.y, op.tool.diameter, SOURCE)
        (back,) = turned(replace(lying, features=(hole,)), undo(turn)).features
        assert isinstance(back, Hole)
        own = part.features[op.features[0][1]]
        assert isinstance(own, Hole)
        same_plate = {"v": "h", "h": "v"} if code != "M" else {}
        legs = {"o": "u", "u": "o"} if code == "L" else {}
        assert back.face in (own.face, {**same_plate, **legs}.get(own.face))
        assert (back.x, back.y) == pytest.approx((own.x, own.y), abs=1e-9)
        assert back.diameter == own.diameter
        made.add(op.features[0][1])
    skipped = {o.feature[1] for o in plan.outcomes if o.how == "skipped"}
    assert made | skipped == set(range(len(part.features)))
    assert not made & skipped


def test_what_stands_in_space_turns_with_the_part() -> None:
    plane = Plane("E0", (0.0, 0.0, 0.0), (100.0, 0.0, 0.0), (0.0, 100.0, 0.0), SOURCE)
    part = Part(
        "A",
        Profile("B", "PL10", 200.0, 10.0, 0.0, 10.0),
        1000.0,
        SOURCE,
        features=(
            Bend((0.0, 50.0), (1000.0, 50.0), 30.0, 5.0, SOURCE),
            EndPlane((0.0, 10.0, 5.0), (-1.0, 0.0, 0.5), SOURCE),
            Camber("v", 400.0, 20.0, SOURCE),
        ),
        planes=(plane,),
        section=(SectionPoint("+", 1.0, 2.0, 0.0),),
    )
    lying = turned(part, TURNS[1])
    bend, end, camber = lying.features
    assert isinstance(bend, Bend)
    assert (bend.start, bend.angle) == ((0.0, 150.0), -30.0)
    assert isinstance(end, EndPlane)
    assert (end.point, end.normal) == ((0.0, 190.0, 5.0), (-1.0, 0.0, -0.5))
    assert isinstance(camber, Camber)
    assert (camber.face, camber.x, camber.y) == ("h", 400.0, 180.0)
    assert lying.planes[0].along_y == (0.0, 100.0, 10.0)
    assert (lying.section[0].y, lying.section[0].z) == (199.0, 8.0)
    for turn in TURNS:
        if not lies(part.profile, turn):
            continue  # a sheet is not set on its edge
        back = turned(turned(part, turn), undo(turn))
        assert back.planes == part.planes
        assert back.section == part.section
        assert turn_between(back, part) == TURNS[0]
