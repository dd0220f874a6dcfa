"""The piece that a coper's program leaves of its bar or tube beside the part that it should be.

The part lies where its program says, x 0 at `coper.trim`. How far a sound program's piece may be
off follows from the machine's file:

    slack     the tolerance of the cut, and the last decimals of X, Y, Z and A
    corners   a re-entrant corner that is drawn sharp keeps the round of `coper.corner_radius`
    square    an edge with a bevel keeps its wedge, a skew end that no torch was tilted to what its
              walls and roots have beyond it, a web with a hole at a flange a ledge along that, a
              hole of a tube what a drill takes inside, an end that is skew through the wall of a
              tube its inside

The last two are told, by how much steel they leave.
"""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import asin, ceil, hypot, radians
from typing import TYPE_CHECKING

from msgspec import Struct
from msgspec.structs import replace
from shapely import intersection_all, union_all
from shapely.affinity import translate

from beamcam.controllers import cell_events
from beamcam.controllers.events import in_degrees
from beamcam.errors import Diagnostic, Source
from beamcam.geometry.curves import Line
from beamcam.machine.coper import Coper
from beamcam.machine.machine import Machine
from beamcam.model.part import Contour, EndCuts, Face, Feature, Hole, Part, Profile
from beamcam.model.request import Request
from beamcam.model.rounds import is_unrolled, rolled
from beamcam.solid import PIECES, ROUNDED, SQUARE
from beamcam.solid.compare import (
    ALIKE,
    Bodies,
    bodies_of,
    differences,
    fit_of,
    likely,
    lumps,
    ways_to_lie,
    without_left_out,
)
from beamcam.solid.coper_corners import rounded_corners
from beamcam.solid.coper_roots import ledges_of, square_ends, steps_of
from beamcam.solid.coper_solid import Burn, burns_of, pieces_of, stock_of
from beamcam.solid.kernel import CHORD, FREE, circle, kernel, minus
from beamcam.solid.part_solid import part_solid
from beamcam.solid.stock_solid import Margins, end_planes, is_cut, stock_solid
from beamcam.solid.wrapped import (
    edges_on_rounds,
    outline_gone,
    skew_ends,
    skin_of,
    square_to_surface,
    unrolled,
    wrapped,
)

if TYPE_CHECKING:
    from manifold3d import Manifold

OFF_TANGENT = 1.0  #: mm that an outline may end off the tangents of its face and mean them
SKIN = 0.05  #: mm off surfaces that no one cuts: those that lie in one another are dear to cut


class PartWithAllowance(Struct, frozen=True):
    """A part with the steel that its machine may leave on it."""

    bodies: Bodies  #: its most steel has the round of its corners, its bevels and straight holes
    plain: "Manifold"  #: the most steel of what is drawn
    corners: "Manifold"  #: what the corners keep
    radii: Sequence[float]  #: of the corners
    square: str  #: what is cut square to the wall that is drawn otherwise; "" for nothing


def coper_faults(
    text: str, parts: Sequence[Part], request: Request, bar: float | None
) -> list[Diagnostic]:
    """Where the piece that a program leaves differs from its part, and what is known to differ."""
    machine, name, source = request.machine, request.name, Source(request.name)
    coper = machine.needed(machine.coper, "coper")
    if len({*parts}) > 1:
        return [PIECES.at(source, found="1 piece", expected=f"{len(parts)}, one for each part")]
    part = with_lip(parts[0], coper)
    part = as_tube(part, coper) if coper.turns == "bar" else part
    events, _ = cell_events(text, machine, name)
    events = in_degrees(events, coper, part.profile.height)
    burns = list(burns_of(events, machine, coper, part, name))
    pieces = pieces_of(stock_of(part, coper, bar), burns, coper, part)
    one = _allowed(part, machine, coper, burns)
    costs = likely(pieces, one.bodies)
    if not costs:
        return [PIECES.at(source, found="no piece", expected=part.mark or "a part")]
    near = [pieces[k] for cost, k in costs if cost <= costs[0][0] + ALIKE]
    best = min((fit_of(piece, one.bodies) for piece in near), key=lambda fit: fit.differs)
    beyond = best.extra
    best, diagnostics = without_left_out(best, one.bodies, "the piece", request.skips)
    if not best.differs:
        return [*_known(best.laid, beyond, one), *diagnostics]
    off = sum(lump.volume() for lump in best.missing) - sum(lump.volume() for lump in best.extra)
    mirror: Iterator[Manifold] = iter(())
    if abs(off) < best.differs / 2:  # a mirror image has as much steel
        mirror = ways_to_lie(best.laid, one.bodies.part, one.bodies, True)
    return [*diagnostics, *differences(best, mirror, one.bodies, "the piece", source)]


def with_lip(part: Part, coper: Coper) -> Part:
    """A part; a C with the lips that the machine file says where no file does."""
    size = part.profile
    if size.code != "C" or size.lip is not None or not coper.lip:
        return part
    return replace(part, profile=replace(size, lip=coper.lip))


def as_tube(part: Part, coper: Coper, there: Sequence[Feature] = ()) -> Part:
    """A tube as it is turned: with the radius of its corners, and both of its webs outlined.

    A plate that is called a pipe is the tube that it is the unrolled surface of. DSTV, 7th edition,
    page 13: M has one contour of the web; one that is `there` already has its own.
    """
    if part.made is not None:
        begun = as_tube(replace(part, features=part.made, made=None), coper)
        asked = as_tube(replace(part, made=None), coper, part.made)
        return replace(asked, made=begun.features)
    size = part.profile
    wall = max(size.flange_thickness, size.web_thickness or 0.0)
    if is_unrolled(size):
        size = rolled(part).profile
    elif size.code == "M":
        size = replace(size, radius=coper.outer_radius(size.radius, wall))
        whole = tuple(_to_edges(f, size) if isinstance(f, Contour) else f for f in part.features)
        part = replace(part, features=whole)
        outer = [c for c in part.contours if c.kind == "outer" and is_cut(c)]
        made = (f for f in there if isinstance(f, Contour) and f.kind == "outer" and is_cut(f))
        webs = {c.face for c in outer} & {"v", "h"}
        if len(webs | ({c.face for c in made} & {"v", "h"})) == 1 and webs:
            other: Face = "h" if "v" in webs else "v"
            twins = (replace(c, face=other, bevels=()) for c in outer if c.face in webs)
            part = replace(part, features=(*part.features, *twins))
    return replace(part, profile=size)


def _to_edges(contour: Contour, size: Profile) -> Contour:
    """An outline that ends at the tangents of its face, its sides gone straight on to the edges."""
    wide, r, curves = size.face_width(contour.face), size.radius, list(contour.curves)
    ys = [y for c in curves for y in (c.bbox[1], c.bbox[3])]
    for farthest, tangent, edge in ((min(ys), r, 0.0), (max(ys), wide - r, wide)):
        for k, side in enumerate(curves):
            before, after = curves[k - 1], curves[(k + 1) % len(curves)]
            if contour.kind != "outer" or not is_cut(contour) or any(
                abs(y - tangent) > OFF_TANGENT for y in (farthest, side.start[1], side.end[1])
            ) or not (isinstance(before, Line) and isinstance(after, Line)):  # fmt: skip
                continue
            at = [
                x + (edge - y) * (x - xo) / (y - yo)
                for (x, y), (xo, yo) in ((side.start, before.start), (side.end, after.end))
            ]
            curves[k - 1] = Line(before.start, (at[0], edge))
            curves[k] = Line((at[0], edge), (at[1], edge))
            curves[(k + 1) % len(curves)] = Line((at[1], edge), after.end)
    return replace(contour, curves=tuple(curves))


def _allowed(
    part: Part, machine: Machine, coper: Coper, burns: Sequence[Burn]
) -> PartWithAllowance:
    """A part with the steel that a sound program leaves of it at least and at most."""
    form = machine.format
    slack = coper.tolerance + 2 * form.resolution + 3 * CHORD
    if coper.turns == "bar":
        reach = hypot(part.profile.height, part.profile.width) / 2
        step = 10.0**-form.angle_decimals
        slack += step if coper.a_unit == "mm" else reach * radians(step)
    whole = replace(part, features=(*part.features, *(part.made or ())), made=None)
    # A saw does not follow an outline next to an end, a torch does.
    largest = Margins(lambda _: slack, 0.0, slack, slack, skin=SKIN, noise=0.0)
    smallest = Margins(lambda _: -slack, 0.0, -slack, -slack, skin=-SKIN)
    bodies = bodies_of(whole, largest, smallest, 2 * slack, slack)
    cut = part
    if part.made is not None:  # of a tube its ends are all there; outlines of others go with them
        round_there = part.profile.code == "RO"
        cut = replace(part, made=None, cuts=EndCuts() if round_there else part.cuts)
    as_cut, square = _cut_square(cut)
    corners, rounds, radii = rounded_corners(cut, smallest, coper.corner_radius)
    least = bodies.least if cut is part else part_solid(cut, largest)
    most = (bodies.most if as_cut == whole else part_solid(as_cut, smallest)) + corners
    if part.profile.code == "M" or (part.profile.code == "RO" and skew_ends(cut)):
        least, most = square_to_surface(least, most, cut, smallest)
        most += corners ^ stock_solid(cut, replace(smallest, end=-FREE))
    if cut is not part:  # what is there was drawn so, whatever cut it
        there = replace(part, features=part.made or (), made=None)
        most_there = part_solid(there, smallest)
        least, most = least ^ part_solid(there, largest), most ^ most_there
        if part.profile.code == "RO" and skew_ends(there):
            most += _beside_ends(cut, there, slack) ^ most_there
    drawn = part_solid(as_cut) if square else bodies.drawn
    ends: list[Manifold] = list(square_ends(part, coper, burns, slack))
    ledges: list[Manifold] = []
    if part.made is None:
        ledges = list(ledges_of(drawn, part, burns, slack))
    steps = list(steps_of(part, rounds, burns, slack))
    on_rounds = list(edges_on_rounds(part, slack))
    for many, what in (
        (len(ends), "skew end(s)"), (len(ledges), "hole(s) at a flange"),
        (len(steps), "cut(s) not square at a root"), (len(on_rounds), "edge(s) in corners"),
    ):  # fmt: skip
        if many:
            square = f"{square}, {many} {what}" if square else f"{many} {what}"
    if ends or ledges or steps or on_rounds:
        m = kernel()
        on_tube = [one ^ stock_solid(part, replace(smallest, end=-FREE)) for one in on_rounds]
        more = [*ends, *ledges, *steps, *on_tube]
        most = m.Manifold.batch_boolean([most, *more], m.OpType.Add)
    allowed = replace(bodies, least=least, most=most)
    return PartWithAllowance(allowed, bodies.most, corners, (*radii.values(),), square)


def _beside_ends(part: Part, there: Part, slack: float) -> "Manifold":
    """What the outline of a round piece leaves out beside a skew end that is there, and that end
    has: it is drawn on one surface of the wall, which ends elsewhere on the other."""
    skin, wall = skin_of(part)
    piece = unrolled(part_solid(there), skin, wall + FREE)
    deep = OFF_TANGENT + wall * max(
        hypot(*normal[1:]) / abs(normal[0]) for _, normal in end_planes(there)
    )
    ways = deep, -deep
    inner = intersection_all([piece, *(translate(piece, way, 0.0) for way in ways)])
    cut = outline_gone(part).intersection(inner)  # and so to the end, along the tube
    steps = range(-ceil(2 * deep), ceil(2 * deep) + 1)
    open_to_end = union_all([translate(cut, step / 2, 0.0) for step in steps]).buffer(-slack)
    return wrapped(piece.difference(inner).difference(open_to_end), skin, -FREE, wall + FREE)


def _known(
    piece: "Manifold", beyond: "Sequence[Manifold]", one: PartWithAllowance
) -> Iterator[Diagnostic]:
    """The steel on a sound piece that is more than what is drawn, without what may be left out."""
    mark, source = one.bodies.part.mark or "the part", one.bodies.part.source
    if one.radii:
        left = float((piece ^ one.corners).volume())
        radius = " to ".join(f"{r:.3g}" for r in sorted({min(one.radii), max(one.radii)}))
        yield ROUNDED.at(
            source, found=f"{left:.1f}", count=len(one.radii), mark=mark, radius=radius
        )
    if one.square:
        more = minus(piece, [one.plain, one.corners, *beyond])
        left = sum(lump.volume() for lump in lumps(more))
        if left or one.bodies.part.profile.code == "RO":  # else bevels that a skew end shows
            yield SQUARE.at(source, what=one.square, mark=mark, found=f"{left:.1f}")


# --- cut square -----------------------------------------------------------------------------------


def _cut_square(part: Part) -> tuple[Part, str]:
    """A part as a torch that stands square to its wall cuts it, and what is drawn otherwise."""
    features: list[Feature] = []
    bevels = holes = 0
    for feature in part.features:
        if isinstance(feature, Contour) and feature.bevels:
            bevels += len(feature.bevels)
            feature = replace(feature, bevels=())
        elif isinstance(feature, Hole) and feature.kind == "through" and part.profile.code == "RO":
            holes += 1
            # A drill through the axis meets the outside so, unrolled.
            radius, x, y = part.profile.height / 2, feature.x, feature.y
            ring = circle(0.0, 0.0, min(feature.diameter / 2, radius))
            ring = [(x + along, y + radius * asin(across / radius)) for along, across in ring]
            curves = tuple(Line(a, b) for a, b in pairwise([*ring, ring[0]]))
            feature = Contour("v", "inner", curves, feature.source)
        features.append(feature)
    texts = [f"{bevels} edge(s) with a bevel"] if bevels else []
    skew = skew_ends(part) if part.profile.code in ("M", "RO") else 0
    texts += [f"{skew} end(s) skew through the wall"] if skew else []
    texts += [f"{holes} hole(s) round its axis"] if holes else []
    return replace(part, features=tuple(features)), ", ".join(texts)
