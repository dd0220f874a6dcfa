"""Texts that a program draws, checked for position.

Where one may stand follows from the steel and the machine file; nothing is known of where it was
planned.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct

from beamcam.checks.drawn_texts import EXACT, DrawnText, RequiredText, Segment, is_where_wanted
from beamcam.checks.request import TEXT_MOVED
from beamcam.errors import Diagnostic, error
from beamcam.geometry.array_types import Floats
from beamcam.geometry.plane import Point
from beamcam.machine.stations import Marks
from beamcam.model.part import MIRRORED_FACES

if TYPE_CHECKING:
    from shapely import Geometry, Polygon


TEXT = error("verify-text",
    "found the text {text!r} at x {x}, y {y}, {height} mm high; expected {expected}",
    "A text stands where the part has it, or where it is clear of holes, edges and other "
    "texts.")  # fmt: skip
TEXT_MISSING = error("verify-text-missing",
    "found no text {text!r} on face {face} of {mark} at {angle} degrees; expected it at x {x}, y "
    "{y}",
    "A text that the machine's stamp or printer could letter has to be in the program, character "
    "by character.")  # fmt: skip
TEXT_EXTRA = error("verify-text-extra",
    "found the text {text!r} on face {face} at machine x {x}, y {y}; expected none, no part has it "
    "there",
    "What is stamped or printed cannot be taken off again.")  # fmt: skip


SURE = 0.15  #: mm by which a place is more than clear, or a room wide enough


class Steel(Struct, frozen=True):
    """Steel on a face, and obstacles for letters."""

    edges: "Geometry"  #: of the steel and its holes
    pieces: Floats  #: the same as straight pieces, (n, 2, 2)

    def holds(self, box: "Polygon") -> bool:
        """Whether steel lies under a box that no edge passes.

        Around steel lies an odd number of edges: most rays from the box cross so many, whatever
        gap between two curves one of them may slip through.
        """
        x, y = box.centroid.x, box.centroid.y
        places = [(x, y), *box.exterior.coords[:4]]
        return sum(map(self._is_in, places)) * 2 > len(places)

    def _is_in(self, place: Point) -> bool:
        a, b = self.pieces[:, 0], self.pieces[:, 1]
        passed = (a[:, 1] > place[1]) != (b[:, 1] > place[1])
        a, b = a[passed], b[passed]
        at = a[:, 0] + (place[1] - a[:, 1]) * (b[:, 0] - a[:, 0]) / (b[:, 1] - a[:, 1])
        return int((at > place[0]).sum()) % 2 == 1


def steel_within(pieces: Sequence[Segment]) -> Steel:
    """The steel that edges lie around, given as straight pieces in any order."""
    import shapely

    ends = np.array(pieces, dtype=np.float64)
    return Steel(shapely.multilinestrings(shapely.linestrings(ends)), ends)


def box_of(text: RequiredText, x: float, y: float, height: float) -> "Polygon":
    """The box around a text along its line."""
    import shapely
    from shapely.affinity import rotate

    turned = shapely.MultiLineString([[a, b] for a, b in text.at(x, y, height)])
    angle = text.feature.angle
    level = rotate(turned, -angle, origin=(x, y))
    return rotate(shapely.box(*level.bounds), angle, origin=(x, y))


def is_clear(
    box: "Polygon", steel: Steel, others: Sequence["Polygon"], distance: float, gap: float = 0.0
) -> bool:
    """Whether a text's box lies in the steel, so far from its edges and beside other texts."""
    import shapely

    return (
        steel.edges.distance(box) >= max(distance, 1e-9)
        and steel.holds(box)
        and not (shapely.distance(box, others) <= gap).any()
    )


def judge(
    text: RequiredText, found: DrawnText, steel: Steel, others: Sequence["Polygon"], marks: Marks,
    sure: Steel | None = None,
) -> Iterator[Diagnostic]:  # fmt: skip
    """What is wrong with the place of a text, or that it is another than the part's.

    `sure` is the steel to which what letters comes for sure, where that is not all of it.
    """
    feature = text.feature
    box = box_of(text, found.x, found.y, found.height)
    labels = {
        "text": text.text, "x": f"{found.x:.1f}", "y": f"{found.y:.1f}",
        "height": f"{found.height:.1f}",
    }  # fmt: skip
    if not is_clear(box, steel, others, marks.min_distance - EXACT):
        expected = f"it {marks.min_distance:g} mm clear of edges and holes, beside other texts"
        yield TEXT.at(feature.source, expected=expected, **labels)
    elif is_where_wanted(text, found):
        return
    elif feature.option == "z" or is_surely_clear(text, sure or steel, others, marks):
        expected = f"it at x {feature.x:g}, y {feature.y:g}, {text.height:g} mm high"
        yield TEXT.at(feature.source, expected=expected, **labels)
    else:
        yield TEXT_MOVED.at(
            feature.source, wanted_x=f"{feature.x:g}", wanted_y=f"{feature.y:g}",
            wanted_height=f"{text.height:g}", **labels,
        )  # fmt: skip


def is_surely_clear(
    text: RequiredText, steel: Steel, others: Sequence["Polygon"], marks: Marks
) -> bool:
    feature = text.feature
    box = box_of(text, feature.x, feature.y, text.height)
    return is_clear(box, steel, others, marks.min_distance + SURE, SURE)


class Places:
    """Where on a face texts that were not drawn might have been, between those that were."""

    def __init__(self, steel: Steel, others: Sequence["Polygon"], marks: Marks) -> None:
        self._face = steel, others, marks
        self._rooms: dict[object, bool] = {}  #: for texts of one shape the answer is the same

    def has(self, text: RequiredText) -> bool:
        """Whether a text might have been drawn: where the part has it, or elsewhere."""
        marks = self._face[2]
        if not text.pieces or text.height < marks.min_height:
            return False
        if is_surely_clear(text, *self._face):
            return True
        if text.feature.option == "z":
            return False
        shape = text.text, text.feature.angle, text.feature.face in MIRRORED_FACES
        if shape not in self._rooms:
            self._rooms[shape] = _has_room(text, *self._face)
        return self._rooms[shape]


def _has_room(text: RequiredText, steel: Steel, others: Sequence["Polygon"], marks: Marks) -> bool:
    """Whether there is room for the smallest box of a text, with something to spare.

    The middle of a box that is clear lies in the steel, and outside of what the box sweeps when it
    is led along all edges (their Minkowski sum).
    """
    import shapely
    from shapely.affinity import translate

    box = box_of(text, 0.0, 0.0, marks.min_height)
    low_x, low_y, high_x, high_y = box.bounds
    centred = translate(box, -(low_x + high_x) / 2, -(low_y + high_y) / 2)
    grown = centred.buffer(marks.min_distance + SURE, quad_segs=4)
    sides = [np.array([*pairwise(other.exterior.coords)]) for other in others]
    walls = np.concatenate((steel.pieces, *sides))
    corners = walls[:, :, None, :] + shapely.get_coordinates(grown)
    swept = shapely.convex_hull(shapely.linestrings(corners.reshape(len(walls), -1, 2)))
    around = shapely.box(*steel.edges.bounds)
    middles = around.difference(shapely.union_all([*swept, *others])).buffer(-0.5)
    parts = [part for part in shapely.get_parts(middles) if not part.is_empty]
    places = (part.representative_point() for part in parts)
    return any(steel.holds(translate(centred, p.x, p.y)) for p in places)
