"""In which order contours are cut: marks first, and what lies in a contour before it."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from beamcam.errors import Diagnostic, Source
from beamcam.machine.torch import TorchProcess
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.shared import SKELETON
from beamcam.verify.sheets.work import SHOWN, Traced, Work

if TYPE_CHECKING:
    from shapely import Polygon

TOUCHING = 0.01  #: mm by which a contour may leave the one around it
AT_ONCE = 64  #: rings that are looked at together


def order_faults(
    traced: Sequence[Traced], works: Mapping[TorchProcess, Work], name: str
) -> list[Diagnostic]:
    """Marks behind cuts, and what lies in a contour that was cut before, in the program's order."""
    said: list[Diagnostic] = []
    first_cut = next((t for t in traced if t.stroke.process == "cut"), None)
    for t in traced:
        if first_cut and t.stroke.process != "cut" and t.stroke.line > first_cut.stroke.line:
            said.append(
                rules.ORDER.at(
                    Source(name, t.stroke.line),
                    found=f"work to {t.stroke.process} {_contour(works, t)}",
                    before=f"the cut on line {first_cut.stroke.line}",
                )
            )  # fmt: skip
            break
    said += _before_skeleton(traced, works, name)
    # An open cut has no inside, and lies in none.
    cuts = [t for t in traced if t.stroke.process == "cut" and t.goes_round]
    for a, b in _inside_of_earlier(cuts):
        if cuts[a].group != cuts[b].group:
            said.append(
                rules.ORDER.at(
                    Source(name, cuts[a].stroke.line), found=_contour(works, cuts[a]),
                    before=f"{_contour(works, cuts[b])} around it, cut on line "
                    f"{cuts[b].stroke.line}",
                )
            )  # fmt: skip
    return said[:SHOWN]


def _before_skeleton(
    traced: Sequence[Traced], works: Mapping[TorchProcess, Work], name: str
) -> list[Diagnostic]:
    """Parts that are cut behind a cut through the skeleton, which they hang in."""
    work = works.get("cut")
    if work is None or not work.torch.skeleton_cuts or not work.need.count:
        return []
    skeleton = [t for t in traced if t.stroke.process == "cut" and not t.half_kerf and not t.closed]
    for t in skeleton:
        path = (work.path.starts[t.first] + work.path.ends[t.last - 1]) / 2
        _, way = work.need.nearest_to(path)
        behind = [
            o for o in traced
            if o.stroke.line > t.stroke.line and (o.half_kerf or o.closed)
        ]  # fmt: skip
        if work.asked.source("cut", way).where == SKELETON and behind:
            return [
                rules.ORDER.at(
                    Source(name, behind[0].stroke.line), found=_contour(works, behind[0]),
                    before=f"the cut through the skeleton on line {t.stroke.line}",
                )
            ]  # fmt: skip
    return []


def _contour(works: Mapping[TorchProcess, Work], t: Traced) -> str:
    return f"the contour of {works[t.stroke.process].contour_at(np.array(t.middle))}"


def _inside_of_earlier(cuts: Sequence[Traced]) -> list[tuple[int, int]]:
    """Pairs of a cut and an earlier one whose ring it lies in.

    Boxes are looked at first: in most programs no contour is in the box of an earlier one. That is
    done for some rings at a time, so that it takes no more memory the more of them lie above one
    another.
    """
    import shapely

    rings = [k for k, t in enumerate(cuts) if t.ring or t.contour is not None]
    tree = shapely.STRtree(shapely.points(np.array([t.middle for t in cuts]).reshape(-1, 2)))
    pairs: list[tuple[int, int]] = []
    for low in range(0, len(rings), AT_ONCE):
        some = np.array(rings[low : low + AT_ONCE])
        boxes = shapely.box(*np.array([cuts[k].box for k in some]).T)
        number, inner = tree.query(boxes)
        later = inner > some[number]
        found, starts = np.unique(some[number[later]], return_index=True)
        for ring, own in zip(found.tolist(), np.split(inner[later], starts)[1:], strict=True):
            pairs += _within(cuts, own.tolist(), ring)
    return sorted(pairs)


def _within(cuts: Sequence[Traced], inner: list[int], ring: int) -> list[tuple[int, int]]:
    """Those of some cuts that lie in the ring of one, with it.

    They may touch it. One that lies on it all round has the same inside, and either may be first.
    """
    import shapely

    polygon = cuts[ring].inside()
    if polygon is None:
        return []
    wider = shapely.buffer(polygon, TOUCHING)
    inside = shapely.contains_xy(wider, np.array([cuts[k].middle for k in inner]))
    return [
        (k, ring)
        for k, is_in in zip(inner, inside.tolist(), strict=True)
        if is_in
        and shapely.covers(wider, shapely.multipoints(cuts[k].corners()))
        and not _covers(cuts[k].inside(), polygon)
    ]


def _covers(polygon: "Polygon | None", other: "Polygon") -> bool:
    """Whether a polygon has all of another within it, but for what counts as touching."""
    import shapely

    return polygon is not None and bool(shapely.covers(shapely.buffer(polygon, TOUCHING), other))
