"""Planes (SC) that take nothing of a part: an end that is stated once more, or one beyond it."""

from collections.abc import Iterable, Iterator
from math import hypot

from beamcam.errors import Diagnostic, note
from beamcam.model.part import EndPlane, Part

NOTHING_TAKEN = note("plan-plane-nothing",
    "found an end plane that takes nothing of the part; it is no cut of its own",
    "It states an end once more that length, header or outline give, or it lies beyond "
    "it.")  # fmt: skip
BESIDE = 0.1  #: mm that a plane may lie inside of the end that it states once more

Place = tuple[float, float, float]


def takes_nothing(plane: EndPlane, outermost: Iterable[Place]) -> bool:
    """Whether the outermost places of a part, x, y and z of its section, all lie behind a plane."""
    (px, py, pz), (a, b, c) = plane.point, plane.normal
    most = BESIDE * hypot(a, b, c)
    return all(a * (x - px) + b * (y - py) + c * (z - pz) <= most for x, y, z in outermost)


def idle_planes(part: Part, outermost: Iterable[Place]) -> Iterator[tuple[int, Diagnostic]]:
    """The planes of a part that take nothing, by their indices, and a note on each."""
    places = tuple(outermost)
    for index, feature in enumerate(part.features):
        if isinstance(feature, EndPlane) and takes_nothing(feature, places):
            yield index, NOTHING_TAKEN.at(feature.source)
