"""Plain holes and their bores, told at a glance; most programs make nothing else.

Sorted by face, X and y, holes and bores go together one by one: each bore in its hole's place, and
like one that was judged before and found right. `matching` and `strokes`, which know of everything,
would find the same: no hole is so near another one that a bore might be for either.
"""

from collections.abc import Sequence
from operator import itemgetter

from beamcam.model.part import Hole, Part, Slot
from beamcam.verify.made import Bore
from beamcam.verify.matching import x_tolerance, y_tolerance
from beamcam.verify.rack import Rack, Wants

_by_place = itemgetter(1, 2, 3)  # face, X and y of a bore


def plainly_made(
    bores: Sequence[Bore], parts: Sequence[Part], from_x: Sequence[float], rack: Rack,
    resolution: float,
) -> list[tuple[int, Bore]] | None:  # fmt: skip
    """The bore of every hole and slot of the parts, with the index of its part.

    `from_x` is where the parts begin, in machine X. None says no more than that one has to look
    closer.
    """
    holes: list[tuple[str, float, float, int, int, Hole]] = []
    for p, part in enumerate(parts):
        begin = from_x[p]
        for feature in part.features:
            if type(feature) is Hole:
                holes.append((feature.face, begin + feature.x, feature.y, len(holes), p, feature))
            elif type(feature) is Slot:
                return None
    if len(holes) != len(bores):
        return None
    holes.sort()
    x_off, y_off = x_tolerance(resolution), y_tolerance(resolution)
    merge = rack.drill.merge_tolerance
    x_apart, y_apart = 2 * (x_off + merge), 2 * (y_off + merge)
    fine = [rack.fine(part.profile, part.grade) for part in parts]
    found: list[tuple[int, Bore]] = []
    sizes: dict[int, float] = {}  #: of holes, by the line of their stroke
    last_face, last_x, last_y = "", 0.0, 0.0
    for (face, x, y, _, p, hole), bore in zip(holes, sorted(bores, key=_by_place), strict=True):
        line, bore_face, bore_x, bore_y = bore[:4]
        if not (bore_face == face and abs(bore_x - x) <= x_off and abs(bore_y - y) <= y_off):
            return None
        # Holes of one X lie in the order of y; those of nearly one might not.
        near = face == last_face and x - last_x <= x_apart
        if near and (x != last_x or y - last_y <= y_apart):
            return None
        if bore[4:] not in fine[p].get(plain_wants(hole), ()):
            return None
        if sizes.setdefault(line, hole.diameter) != hole.diameter:  # two of one stroke
            return None
        found.append((p, bore))
        last_face, last_x, last_y = face, x, y
    return found


def plain_wants(hole: Hole) -> Wants:
    """What a plain hole of a section wants made, but for its place."""
    return hole.face, hole.kind, hole.diameter, hole.depth, hole.angle
