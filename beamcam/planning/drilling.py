"""Which drill makes which hole, and which flange holes are one stroke of two spindles."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from beamcam.errors import Diagnostic
from beamcam.machine.machine import Drill, Machine, Pair, Tool
from beamcam.model.part import Hole, Part
from beamcam.model.plan import FeatureRef
from beamcam.planning import rules


@dataclass(frozen=True, slots=True)
class Drilling:
    """One stroke on a part: a hole, or the same hole on both flanges."""

    x: float  #: on the part
    y: float  #: on the face; the middle of the two of a pair
    spindle: int
    tool: Tool
    holes: tuple[tuple[FeatureRef, Hole], ...]
    reason: str


def choose_drill(diameter: float, machine: Machine) -> Tool | None:
    """The drill nearest to a hole's diameter within the machine's fit; None if there is none.

    Of two that are equally near the smaller, because a hole can be reamed and not be filled.
    """
    drill = machine.drill
    fit = next((f for f in drill.fits if diameter <= f.up_to), None) if drill else None
    if fit is None:
        return None
    fitting = [
        (abs(d - diameter), d, tools.point_deg)
        for tools in machine.tools
        if tools.kind == "drill"
        for d in tools.diameters
        if -fit.minus - 1e-9 <= d - diameter <= fit.plus + 1e-9
    ]
    if not fitting:
        return None
    _, size, point_deg = min(fitting)
    return Tool("drill", size, point_deg)


def refuse_hole(hole: Hole, part: Part, machine: Machine) -> Diagnostic | None:
    """Why the machine cannot drill a hole; None if it can."""
    faces = [s.face for s in machine.spindles]
    if hole.face not in faces:
        return rules.NO_SPINDLE.at(
            hole.source, kind="hole", found=hole.face, expected=", ".join(faces) or "none"
        )
    width = part.profile.face_width(hole.face)
    if not (0 <= hole.x <= part.length and 0 <= hole.y <= width):
        return rules.OFF_FACE.at(
            hole.source, x=f"{hole.x:g}", y=f"{hole.y:g}", face=hole.face,
            length=f"{part.length:g}", width=f"{width:g}",
        )  # fmt: skip
    if hole.kind not in ("through", "blind") or choose_drill(hole.diameter, machine) is None:
        return rules.NO_TOOL.at(
            hole.source, kind=hole.kind, found=f"{hole.diameter:g}", face=hole.face,
            expected=_nearest_drills(hole.diameter, machine),
        )  # fmt: skip
    return None


def _nearest_drills(diameter: float, machine: Machine) -> str:
    sizes = sorted((abs(d - diameter), d) for t in machine.tools for d in t.diameters)
    if not sizes:
        return "none, the machine has no drill"
    return "a through or blind hole near a drill of " + " or ".join(f"{d:g}" for _, d in sizes[:2])


def merge_pairs(
    holes: Iterable[tuple[FeatureRef, Hole]], machine: Machine, drill: Drill
) -> Iterator[tuple[tuple[FeatureRef, Hole], ...]]:
    """The holes, those that are the same on both faces of a pair of spindles two by two.

    The same is: x, y, diameter and depth nearer than the merge tolerance, and of one kind. Each
    hole finds at most one partner, the nearest.
    """
    left = dict(holes)
    for ref, hole in sorted(left.items(), key=lambda item: (item[1].x, item[0])):
        if ref not in left:
            continue
        del left[ref]
        pair = pair_of(hole.face, machine)
        partners = [
            (abs(other.x - hole.x) + abs(other.y - hole.y), key)
            for key, other in left.items()
            if pair and key[0] == ref[0] and _same(hole, other, pair, drill.merge_tolerance)
        ]
        if partners:
            partner = min(partners)[1]
            yield tuple(sorted(((ref, hole), (partner, left.pop(partner))), key=_face_order))
        else:
            yield ((ref, hole),)


def _face_order(item: tuple[FeatureRef, Hole]) -> str:
    return item[1].face


def pair_of(face: str, machine: Machine) -> Pair | None:
    """The pair of spindles that reaches a face."""
    return next((p for p in machine.pairs if face in p.faces), None)


def _same(a: Hole, b: Hole, pair: Pair, tolerance: float) -> bool:
    limit = tolerance + 1e-9
    return (
        a.face != b.face
        and b.face in pair.faces
        and a.kind == b.kind
        and (a.depth is None) == (b.depth is None)
        and abs((a.depth or 0.0) - (b.depth or 0.0)) <= limit
        and abs(a.x - b.x) <= limit
        and abs(a.y - b.y) <= limit
        and abs(a.diameter - b.diameter) <= limit
    )


def drillings(
    holes: Iterable[tuple[FeatureRef, Hole]], machine: Machine, drill: Drill
) -> Iterator[Drilling]:
    """The strokes that make `holes`, each of which `refuse_hole` has let pass."""
    for group in merge_pairs(holes, machine, drill):
        faces = tuple(hole.face for _, hole in group)
        sizes = [hole.diameter for _, hole in group]
        tool = choose_drill(max(sizes), machine)
        if tool is None:
            raise AssertionError(f"no drill for {sizes}, which refuse_hole has to say")
        if len(group) == 2:
            pair = pair_of(faces[0], machine)
            if pair is None:
                raise AssertionError(f"no pair for {faces}, which merge_pairs has found")
            number = pair.number
        else:
            number = next(s.number for s in machine.spindles if s.face == faces[0])
        reason = "drill-exact" if tool.diameter in sizes else "drill-nearest"
        if len(group) == 2:
            reason += ", same on both flanges"
        yield Drilling(
            sum(h.x for _, h in group) / len(group),
            sum(h.y for _, h in group) / len(group),
            number,
            tool,
            group,
            reason,
        )
