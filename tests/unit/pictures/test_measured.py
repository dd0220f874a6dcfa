"""A part measured by its picture alone, as a foreman does with the sheet in his hand.

Circles, lines and texts of the SVG are all that is read: from a hole along its dotted lines to the
figures, and along its leader or by its letter to its size. What comes out is the part's own list.
"""

from math import dist
from xml.etree.ElementTree import Element

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.errors import Source
from beamcam.model.part import Hole, Part, Profile
from beamcam.pictures.formats import to_svg
from beamcam.pictures.part import part_scene
from beamcam.pictures.scene import Scene
from tests.conftest import examples
from tests.unit.pictures.drawings import Drawing, corners

HERE = Source("x.nc1", 1)
NEAR = 0.06  #: pixels
SECTIONS = {
    "I": Profile("I", "IPE300", 300.0, 150.0, 10.7, 7.1),
    "U": Profile("U", "UPN200", 200.0, 75.0, 11.5, 8.5),
}
Point = tuple[float, float]


def place_of(text: Element) -> Point:
    return float(text.get("x", "nan")), float(text.get("y", "nan"))


def words_of(text: Element) -> str:
    return "".join(text.itertext())


class Sheet:
    """The picture, and how it is measured."""

    def __init__(self, scene: Scene) -> None:
        drawing = Drawing(to_svg(scene))
        self.holes = [
            (float(c.get("cx", 0)), float(c.get("cy", 0)), float(c.get("r", 0)))
            for c in drawing.all("hole")
        ]
        self.faces = [corners(f) for f in drawing.all("face")]
        self.titles = [words_of(t)[0] for t in drawing.all("label") if "; y = 0" in words_of(t)]
        self.guides = [corners(g) for g in drawing.all("guide")]
        self.dims = [corners(d) for d in drawing.all("dim") if "leader" not in d.get("class", "")]
        self.leaders = [corners(d) for d in drawing.all("leader")]
        self.figures = [(*place_of(t), float(t.get("data-mm", "nan")))
                        for t in drawing.all("figure") if t.get("data-mm")]  # fmt: skip
        self.callouts = [(place_of(t), words_of(t)) for t in drawing.all("callout")]
        self.letters = [(place_of(t), words_of(t)) for t in drawing.all("letter")]

    def face(self, x: float, y: float) -> str:
        for title, outline in zip(self.titles, self.faces, strict=True):
            (x0, x1), (y0, y1) = ((min(v), max(v)) for v in zip(*outline, strict=True))
            if x0 <= x <= x1 and y0 <= y <= y1:
                return title
        raise AssertionError("a hole beside its face")

    def along(self, x: float, y: float, axis: int) -> float:
        """The figure at the end of the dotted line through a place."""
        across = 1 - axis
        at = (x, y)
        line = next(
            g for g in self.guides
            if abs(g[0][axis] - at[axis]) < NEAR and abs(g[1][axis] - at[axis]) < NEAR
            and min(p[across] for p in g) - NEAR <= at[across] <= max(p[across] for p in g) + NEAR
        )  # fmt: skip
        # Its dimension begins two pixels off the face, at the same place.
        end = line[0]
        off = (end[0], end[1] + 2.0) if axis == 0 else (end[0] - 2.0, end[1])
        dim = next(d for d in self.dims if dist(d[0], off) < 3 * NEAR)
        foot = dim[-1]
        text = (foot[0] + 3.5, foot[1] + 3.0) if axis == 0 else (foot[0] - 2.0, foot[1] + 3.5)
        return next(v for fx, fy, v in self.figures if dist((fx, fy), text) < 3 * NEAR)

    def size(self, x: float, y: float, radius: float) -> float:
        """The diameter that is said of a hole: by its leader, or by the letter beside it."""
        for leader in self.leaders:
            if abs(dist(leader[0], (x, y)) - radius) < 2 * NEAR:
                end = leader[-1]
                said = min(self.callouts, key=lambda c: self.off(c, end))
                return float(said[1].split("Ø")[-1])
        letter = {words for place, words in self.letters if self.beside(place, x, y, radius)}
        if letter:
            (one,) = letter
            said = next(c for c in self.callouts if c[1].split("  ")[0] == one)
            return float(said[1].split("Ø")[-1])
        (only,) = {words.split("Ø")[-1] for _, words in self.callouts}
        return float(only)

    def off(self, callout: tuple[Point, str], end: Point) -> float:
        (x, y), _ = callout
        return min(abs(x - end[0]), 99.0) + abs(y - 3.6 - end[1])

    def beside(self, place: Point, x: float, y: float, radius: float) -> bool:
        """Whether a letter is nearest to this hole of all."""
        middle = (place[0] + 2.4, place[1] - 2.9)
        nearest = min(self.holes, key=lambda h: dist(middle, h[:2]) - h[2])
        return nearest == (x, y, radius)

    def measured(self) -> list[tuple[str, float, float, float]]:
        return sorted(
            (self.face(x, y), self.along(x, y, 0), self.along(x, y, 1), self.size(x, y, r))
            for x, y, r in self.holes
        )


def part_of(code: str, holes: list[Hole]) -> Part:
    return Part("B1", SECTIONS[code], 2400.0, HERE, features=tuple(holes))


#: Places a hand's breadth apart, as holes in steel lie.
HOLES = st.lists(
    st.builds(
        lambda face, x, y, d: Hole(face, x, y, d, HERE), st.sampled_from("vou"),
        st.integers(1, 18).map(lambda k: 120.0 * k + 30.5), st.sampled_from([20.0, 55.0]),
        st.sampled_from([13.0, 18.0, 22.0]),
    ), min_size=1, max_size=25, unique_by=lambda h: (h.face, h.x, h.y),
)  # fmt: skip


@pytest.mark.parametrize("code", SECTIONS)
@given(holes=HOLES)
@settings(max_examples=examples(20), deadline=None)
def test_every_hole_is_found_and_sized(code: str, holes: list[Hole]) -> None:
    found = Sheet(part_scene(part_of(code, holes))).measured()
    assert found == sorted((h.face, h.x, h.y, h.diameter) for h in holes)


@given(holes=HOLES)
@settings(max_examples=examples(10), deadline=None)
def test_a_mirror_image_measures_otherwise(holes: list[Hole]) -> None:
    """The same holes counted from the other edge of each flange are another part on paper too."""
    width = SECTIONS["U"].width
    flanges = [h for h in holes if h.face in "ou"]
    mirrored = [
        Hole(h.face, h.x, width - h.y if h.face in "ou" else h.y, h.diameter, HERE) for h in holes
    ]
    if flanges and sorted((h.face, h.x, h.y) for h in holes) != sorted(
        (h.face, h.x, h.y) for h in mirrored
    ):
        one, other = (Sheet(part_scene(part_of("U", some))).measured()
                      for some in (holes, mirrored))  # fmt: skip
        assert one != other
