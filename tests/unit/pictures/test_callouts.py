"""Sizes said in pictures of parts: of every hole, once, in the words of a drawing."""

from itertools import pairwise
from math import hypot
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.errors import Source
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.model.part import (
    Bend,
    Bevel,
    Contour,
    EndCuts,
    Feature,
    Hole,
    Part,
    Profile,
    Slot,
    TextMark,
)  # fmt: skip
from beamcam.pictures.callouts import size_letters, sizes_on
from beamcam.pictures.formats import to_svg
from beamcam.pictures.part import part_scene
from beamcam.pictures.scene import CAPITAL, LETTER, Labels, Scene, Text, as_text
from beamcam.pipeline import read_file
from tests.conftest import SAMPLES, examples
from tests.unit.pictures.drawings import NAMESPACE, Drawing, corners

HERE = Source("x.nc1", 1)
BEAM = Profile("I", "IPE300", 300.0, 150.0, 10.7, 7.1)


def beam(*features: Feature, **more: Any) -> Part:
    return Part("B1", BEAM, 2000.0, HERE, features=features, **more)


def callouts_of(scene: Scene) -> list[str]:
    return [s.text for s in scene.shapes if isinstance(s, Text) and "callout" in s.classes]


def rectangle(x0: float, y0: float, x1: float, y1: float) -> tuple[Curve, ...]:
    points = ((x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0))
    return tuple(Line(a, b) for a, b in pairwise(points))


@pytest.mark.parametrize(
    ("feature", "words"),
    [
        (Hole("v", 100, 50, 18, HERE), "Ø18"),
        (Hole("v", 100, 50, 18, HERE, depth=12.5), "Ø18, 12.5 deep"),
        (Hole("v", 100, 50, 16, HERE, kind="thread"), "M16"),
        (Hole("v", 100, 50, 16, HERE, 20.0, "left-thread"), "M16 left, 20 deep"),
        (Hole("v", 100, 50, 30, HERE, kind="countersink", angle=90.0), "sink Ø30 × 90°"),
        (Hole("v", 100, 50, 30, HERE, 8.0, "countersink"), "flat sink Ø30, 8 deep"),
        (Hole("v", 100, 50, 0, HERE), "centre point"),
        (Slot("v", 100, 50, 18, 16, 0, 0, HERE), "slot 34 × 18"),
        (Slot("v", 100, 50, 18, 16, 0, 150, HERE), "slot 34 × 18, -30°"),
        (Slot("v", 100, 50, 10, 50, 30, 0, HERE, 4.0), "cut-out 60 × 40, R5, 4 deep"),
        (TextMark("v", 100, 50, 0, 12, "B1", HERE), "text 12 high"),
        (Contour("v", "inner", rectangle(50, 50, 130, 90), HERE), "cut-out 80 × 40"),
        (Contour("v", "inner", (Arc((90.0, 90.0), 25.0, 0.0, 360.0),), HERE), "Ø50"),
        (Bend((100.0, 0.0), (100.0, 300.0), 90.0, 6.0, HERE), "bend 90°, R6"),
    ],
)  # fmt: skip
def test_a_size_is_said_as_a_drawing_says_it(feature: Feature, words: str) -> None:
    assert words in callouts_of(part_scene(beam(feature)))


def test_bevels_and_round_corners_are_said() -> None:
    curves = (
        Line((0.0, 0.0), (200.0, 0.0)), Line((200.0, 0.0), (200.0, 80.0)),
        Arc((180.0, 80.0), 20.0, 0.0, 90.0), Line((180.0, 100.0), (0.0, 100.0)),
        Line((0.0, 100.0), (0.0, 0.0)),
    )  # fmt: skip
    bevels = (Bevel(1, 45.0, 2.0), Bevel(0, -30.0, 0.0), Bevel(3, -40.0, 6.0))
    outline = Contour("v", "outer", curves, HERE, bevels=bevels)
    plate = Part("P1", Profile("B", "PL10*100", 100.0, 0.0, 0.0, 10.0), 200.0, HERE,
                 features=(outline,))  # fmt: skip
    said_ = callouts_of(part_scene(plate))
    assert {"R20", "bevel 45°, land 2", "bevel 30° of the far side"} <= {*said_}
    assert "bevel 40° of the far side, 6 deep" in said_


def test_skew_ends_have_their_angles() -> None:
    part = beam(cuts=EndCuts(30.0, -45.0, 0.0, 12.5))
    said_ = callouts_of(part_scene(part))
    assert sorted(said_) == ["mitre 12.5°", "mitre 12.5°", "mitre 30°", "mitre 45°"]
    assert callouts_of(part_scene(beam())) == []


SIZES = st.sampled_from([13.0, 18.0, 22.0, 26.0])
HOLES = st.lists(
    st.builds(
        lambda face, x, y, d: Hole(face, x, y, d, HERE), st.sampled_from("vou"),
        st.integers(3, 97).map(lambda k: 20.0 * k), st.sampled_from([35.0, 60.0, 115.0]), SIZES,
    ), max_size=40, unique_by=lambda h: (h.face, h.x, h.y),
)  # fmt: skip


@given(HOLES)
@settings(max_examples=examples(25), deadline=None)
def test_each_hole_is_counted_and_none_is_counted_twice(holes: list[Hole]) -> None:
    """What a reader adds up: callouts and letters of a face are all its holes, by size."""
    scene = part_scene(beam(*holes))
    counts: dict[str, int] = {}
    letters: dict[str, str] = {}
    for text in callouts_of(scene):
        letter, _, rest = text.rpartition("  ")
        number, _, size = rest.rpartition(" × ")
        counts[size] = counts.get(size, 0) + int(number or 1)
        if letter:
            assert letters.setdefault(size, letter) == letter
    wanted = {f"Ø{d:g}": sum(h.diameter == d for h in holes) for d in {h.diameter for h in holes}}
    assert counts == wanted
    assert len({*letters.values()}) == len(letters)
    beside = [s.text for s in scene.shapes if isinstance(s, Text) and "letter" in s.classes]
    sizes = size_letters([sizes_on([h for h in holes if h.face == f]) for f in "ovu"])
    for words, letter in sizes.items():
        places = [h for h in holes if as_text(("Ø", h.diameter)) == as_text(words)]
        assert beside.count(letter) == len(places) - len({h.face for h in places})


@given(HOLES)
@settings(max_examples=examples(25), deadline=None)
def test_callouts_do_not_lie_over_one_another(holes: list[Hole]) -> None:
    scene = part_scene(beam(*holes))
    boxes = []
    for s in scene.shapes:
        if isinstance(s, Text) and "callout" in s.classes:
            wide = 0.55 * s.size * len(s.text)
            x = s.at[0] - (wide if s.anchor == "end" else 0.0)
            boxes.append((x, s.at[1] - 7.0, x + wide, s.at[1]))
    for k, a in enumerate(boxes):
        assert a[0] > 0.0
        assert a[2] < scene.width
        for b in boxes[:k]:
            assert not (a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]), (a, b)


def test_a_leader_ends_at_its_hole() -> None:
    part = read_file(str(SAMPLES / "dstv" / "gusset.nc1")).parts[0]
    found = Drawing(to_svg(part_scene(part)))
    circles = [tuple(float(c.get(k, 0)) for k in ("cx", "cy", "r")) for c in found.all("hole")]
    edges = [corners(line)[0] for line in found.all("leader")]
    assert any(
        abs(((x - cx) ** 2 + (y - cy) ** 2) ** 0.5 - r) < 0.1
        for x, y in edges for cx, cy, r in circles
    )  # fmt: skip


def test_lines_lead_from_each_dimension_to_its_holes() -> None:
    holes = (Hole("v", 300, 60, 18, HERE), Hole("v", 300, 200, 18, HERE),
             Hole("v", 900, 60, 18, HERE))  # fmt: skip
    found = Drawing(to_svg(part_scene(beam(*holes))))
    circles = [(float(c.get("cx", 0)), float(c.get("cy", 0))) for c in found.all("hole")]
    lines = [corners(e) for e in found.all("guide")]
    assert len(lines) == 4  # two places along x, two of y
    for x, y in circles:
        assert any(abs(a[0] - x) < 0.02 and min(a[1], b[1]) - 0.02 <= y <= max(a[1], b[1]) + 0.02
                   for a, b in lines)  # fmt: skip
        assert any(abs(a[1] - y) < 0.02 and min(a[0], b[0]) - 0.02 <= x <= max(a[0], b[0]) + 0.02
                   for a, b in lines)  # fmt: skip


def test_lengths_among_words_are_data_and_follow_the_unit() -> None:
    part = beam(Hole("v", 300, 60, 25.4, HERE, 12.7))
    inch = Drawing(to_svg(part_scene(part, "inch")))
    assert "Ø1, 0.5 deep" in inch.texts
    spans = [e.get("data-mm") for e in inch.root.iter(f"{NAMESPACE}tspan")]
    assert spans == ["25.4", "12.7"]


@pytest.mark.parametrize("count", [60, 120, 400])
def test_no_place_along_x_is_left_out(count: int) -> None:
    """In a row, in two rows, and beyond that in the notes below."""
    holes = tuple(Hole("v", 20.0 + 4.9 * k, 60, 4, HERE) for k in range(count))
    found = Drawing(to_svg(part_scene(beam(*holes))))
    shown = {float(e.get("data-mm", "nan")) for e in found.all("figure") if e.get("data-mm")}
    listed = {float(word) for text in found.texts if text.startswith("x on v: ")
              for word in text.removeprefix("x on v: ").split(", ")}  # fmt: skip
    for hole in holes:
        assert any(abs(hole.x - x) < 0.051 for x in shown | listed)
    assert bool(listed) is (count == 400)


def test_the_section_has_the_letters_of_its_faces() -> None:
    texts = Drawing(to_svg(part_scene(beam()))).texts
    assert {"v", "o", "u", "h", "seen from the start", "to o", "to u", "to v"} <= {*texts}
    flat = replace(beam(), profile=Profile("B", "PL10*300", 300.0, 0.0, 0.0, 10.0))
    assert "to o" not in Drawing(to_svg(part_scene(flat))).texts


def test_the_legend_names_what_is_drawn_and_no_more() -> None:
    plain = Drawing(to_svg(part_scene(beam()))).texts
    assert "end cut" in plain
    assert "hole" not in plain
    with_slot = Drawing(to_svg(part_scene(beam(Slot("v", 100, 50, 18, 16, 0, 0, HERE))))).texts
    assert "slot" in with_slot


def test_bends_are_dimensioned_and_equal_figures_stand_once() -> None:
    bend = Bend((412.5, 0.0), (412.5, 300.0), 90.0, 6.0, HERE)
    holes = (Hole("v", 300.01, 60.0, 18, HERE), Hole("v", 300.04, 200.0, 18, HERE))
    found = Drawing(to_svg(part_scene(beam(bend, *holes))))
    assert found.texts.count("412.5") == 1
    assert found.texts.count("300") == 2  # along x, and the height of the web
    inch = Drawing(to_svg(part_scene(beam(bend, *holes), "inch")))
    assert {"11.811", "11.813"} <= {*inch.texts}


# --- numbers beside what they name ----------------------------------------------------------------


PLACES = st.lists(st.tuples(st.integers(0, 120), st.integers(0, 60)), min_size=1, max_size=25)
SIZE, RADIUS = 9.0, 2.0


@given(PLACES)
def test_no_label_lies_over_another_or_over_a_hole(places: list[tuple[int, int]]) -> None:
    labels = Labels()
    holes = [(x - RADIUS, y - RADIUS, x + RADIUS, y + RADIUS) for x, y in places]
    for hole in holes:
        labels.block(hole)
    boxes = []
    for number, at in enumerate(places, 1):
        found = labels.place(at, RADIUS, str(number), SIZE)
        if found is not None:
            wide, high = LETTER * SIZE * len(str(number)), CAPITAL * SIZE
            boxes.append((found[0], found[1] - high, found[0] + wide, found[1]))
            middle = found[0] + wide / 2, found[1] - high / 2
            assert hypot(middle[0] - at[0], middle[1] - at[1]) < 3 * (RADIUS + high + wide)
    taken = [*boxes, *holes]
    for k, a in enumerate(boxes):
        for b in taken[k + 1 :]:
            assert a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]


def test_alone_it_stands_to_the_upper_right() -> None:
    x, y = Labels().place((50.0, 50.0), RADIUS, "7", SIZE) or (0.0, 0.0)
    assert x > 50.0
    assert y < 50.0
