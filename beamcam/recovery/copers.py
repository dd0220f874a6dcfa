"""The part that a torch cuts out of a bar as it goes round it, or over a tube that turns.

    | trim |# part, (o) #|  trim       Each wall of the bar less the kerfs falls into pieces. Those
           '             '             that reach an end of the bar are trims, and those in which
         kerf          kerf            a cut begins scrap, (o); the others are the part.

Of an I, a U or an L the web goes on below its flanges where it stands on them, and the stem of a T.
"""

from collections.abc import Iterable, Iterator, Sequence
from math import inf
from typing import Any

from msgspec import Struct
from msgspec.structs import replace

from beamcam.checks.coping import codes_read, verify_coping
from beamcam.checks.coping import rules as coping_rules
from beamcam.checks.coping.compare import taken_of
from beamcam.checks.coping.lying import as_drawn, lying
from beamcam.checks.coping.program import head_part, head_profile, strokes_of
from beamcam.checks.coping.section import CoperSection, kerf_of, pieces_of
from beamcam.checks.coping.strokes import TorchStroke
from beamcam.checks.coping.tube import tube_section
from beamcam.checks.job import head_of
from beamcam.errors import Diagnostic, Source, errors_in
from beamcam.geometry.plane import Point
from beamcam.machine.coper import Coper
from beamcam.machine.machine import Machine
from beamcam.model.part import Contour, EndCuts, Face, Feature, Hole, Part, Slot
from beamcam.model.rounds import rolled
from beamcam.recovery import rings, rules
from beamcam.recovery.box_tube import Faces, corner_radius, faces_of
from beamcam.recovery.recovered import KnownStock, Recovered, mark_of, plain
from beamcam.recovery.tilted import SAME, Ends, cuts_of, ends_of, length_of, whole_wall, with_bevels

Shape = Any  #: of shapely

REFIT_SHARE = 1 / 8  #: of the tolerance, to which chords are refitted
BEGINS = 0.02  #: mm beyond half a kerf from where a cut begins, within which all is scrap
AS_SAID = 1.0  #: mm by which the outlines of a part may be shorter than the length in its head
SPECK = 0.05  #: mm2 that is nothing
AROUND = (-1, 0, 1)  #: turns of a tube that its surface is laid in, one above the other
NO_ENDS: Ends = (None, None)  #: skew ones
MADE_OF_CUT = "COMES CUT: "  #: how a program begins whose piece is there


class _Wall(Struct, frozen=True):
    """What stays of a wall, and its box where nothing is cut but its ends."""

    face: Face
    shape: Shape
    wide: float
    line: int  #: of its first cut
    is_drawn: bool = False  #: whether it has an outline though it is whole


class _Job(Struct, frozen=True):
    """A program that is recovered, and the part as far as its head says it."""

    text: str
    machine: Machine
    coper: Coper
    name: str
    bare: Part
    diagnostics: tuple[Diagnostic, ...]
    tube_radius: float | None  #: of a round tube

    @property
    def within(self) -> float:
        """How near to the cut contours are refitted, in mm."""
        return self.coper.tolerance * REFIT_SHARE

    def part(self, end: float, slack: float) -> Part:
        """The part without features that reaches so far, as long as its head says if it may be."""
        is_as_said = abs(end - self.bare.length) <= slack
        length = self.bare.length if is_as_said else plain(end, rings.PLACE, rings.DECIMALS)
        return replace(self.bare, mark=self.bare.mark or mark_of(self.name), length=length)

    def recovered(self, part: Part, features: Iterable[Feature]) -> Recovered:
        """A part with its features, and what the read-back says of the program beside it."""
        part = as_drawn(replace(part, features=tuple(features)))
        more = verify_coping(self.text, (part,), self.machine, name=self.name)
        diagnostics = [*self.diagnostics, *(d for d in more if d not in self.diagnostics)]
        if contours := [*part.contours]:  # which are not known to be as they were drawn
            within = f"{self.within:g}"
            diagnostics.append(rules.REFITTED.at(part.source, count=len(contours), within=within))
        radius = self.coper.corner_radius
        corners = sum(rings.rounded_corners(c.curves, radius, self.within) for c in contours)
        if corners:
            diagnostics.append(rules.ROUNDED.at(part.source, count=corners, radius=f"{radius:g}"))
        return Recovered((part,), tuple(diagnostics), bool(self.bare.mark))

    def features(self, part: Part, wall: _Wall, whole: Shape = None) -> Iterator[Feature]:
        """The outline of a wall, where it is no whole one, and what is cut out of it.

        A whole one is a rectangle as long as the part, or `whole`.
        """
        from shapely import MultiPolygon, Polygon, box
        from shapely.geometry.polygon import orient

        source = Source(part.source.file, wall.line)
        is_tube = self.tube_radius is not None
        pieces = [orient(piece) for piece in pieces_of(wall.shape)]
        outlines = [Polygon(piece.exterior) for piece in pieces]
        whole = whole or box(0.0, 0.0, part.length, wall.wide)
        if is_tube:
            turn = box(-1e6, 0.0, 1e6, wall.wide)
            outlines = pieces_of(MultiPolygon(outlines).intersection(turn))
        is_whole = len(outlines) == 1 and outlines[0].hausdorff_distance(whole) <= self.within
        if not is_whole or wall.is_drawn or part.profile.code == "B":
            for outline in outlines:
                ring = _ring(orient(outline).exterior)
                curves = rings.curves_of(ring, self.within, (0.0, wall.wide))
                yield Contour(wall.face, "outer", curves, source)
        for piece in pieces:
            for hole in piece.interiors:
                _, low, _, high = hole.bounds
                if not is_tube or 0.0 <= (low + high) / 2 < wall.wide:
                    yield self._cut_out(wall.face, _ring(hole), source)

    def of_box(self, part: Part, faces: Faces, line: int) -> Iterator[Feature]:
        """The outlines of a rectangular tube's faces where one is no whole one, and its cut-outs.

        What opens to an edge of a face goes on over the corner, as a cut-out of both.
        """
        from shapely import box, union_all
        from shapely.geometry.polygon import orient

        source = Source(part.source.file, line)
        outlines: list[Contour] = []
        inner: list[Feature] = []
        whole = True
        for face, steel in faces.steel.items():
            wide = part.profile.face_width(face)
            low, _, high, _ = steel.bounds
            gone = pieces_of(box(low - 1.0, 0.0, high + 1.0, wide).difference(steel))
            within = [one for one in gone if low <= one.bounds[0] and one.bounds[2] <= high]
            within = [one for one in within if one.buffer(-self.within).area > 0.0]
            outline = union_all([steel, *(one.buffer(rings.PLACE) for one in within)])
            outline = outline.intersection(box(low, 0.0, high, wide))
            same = outline.hausdorff_distance(box(0.0, 0.0, part.length, wide)) <= self.within
            whole = whole and (same or faces.cuts != EndCuts())
            for one in pieces_of(outline):
                curves = rings.curves_of(_ring(orient(one).exterior), self.within, (0.0, wide))
                outlines.append(Contour(face, "outer", curves, source))
            for one in within:
                ring = _ring(orient(one, -1.0).exterior)
                if any(abs(y - edge) <= rings.PLACE for _, y in ring for edge in (0.0, wide)):
                    curves = rings.curves_of(ring, self.within, (0.0, wide))
                    inner.append(Contour(face, "inner", curves, source))
                else:
                    inner.append(self._cut_out(face, ring, source))
        yield from outlines if not whole else ()
        yield from inner

    def _cut_out(self, face: Face, ring: Sequence[Point], source: Source) -> Feature:
        """A hole, a slot, or a contour.

        Where the corners of a rectangle have the radius that the machine gives sharp ones it is a
        contour.
        """
        if self.tube_radius is None:
            circle = rings.round_of(ring, self.within)
        else:
            circle = rings.drilled_of(ring, self.tube_radius, self.within)
        if circle is not None:
            return Hole(face, *circle, source)
        slot = rings.pocket_of(ring, self.within)
        if slot is not None:
            _, _, diameter, _, height, _ = slot
            if height <= 0.0 or abs(diameter / 2 - self.coper.corner_radius) > self.within:
                return Slot(face, *slot, source)
        return Contour(face, "inner", rings.curves_of(ring, self.within), source)


def recover_coped(text: str, machine: Machine, name: str, stock: KnownStock) -> Recovered:
    """The part that a coper's program makes; none where an error is said.

    Section, grade, mark, drawing and order are those of the program's head, but for a section and
    a grade of `stock`. Raises TypeError for a machine without a coper.
    """
    coper = machine.needed(machine.coper, "coper")
    head, source = head_of(text), Source(name)
    if MADE_OF_CUT in text:
        return Recovered((), (rules.COMES_CUT.at(source),))
    profile = stock.profile or head_profile(head)
    if profile is None:
        found = head.stock if head is not None and head.stock else "none"
        return Recovered((), (rules.UNNAMED.at(source, found=found),))
    bare = head_part(head, profile, name)
    bare = replace(bare, grade=stock.grade or bare.grade)
    if profile.code == "M" and not profile.radius:
        turned = replace(profile, radius=corner_radius(text, machine, profile))
        bare = replace(bare, profile=turned)
    bare = lying(bare)
    code, codes = rolled(bare).profile.code, codes_read(coper)
    if code not in codes:
        expected = ", ".join(codes)
        return Recovered((), (coping_rules.SECTION.at(source, found=code, expected=expected),))
    strokes, diagnostics = strokes_of(text, bare, machine, name)
    if errors_in(diagnostics):
        return Recovered((), tuple(diagnostics))
    is_tube = coper.unrolls(profile.code)
    radius = rolled(bare).profile.height / 2 if is_tube and code != "M" else None
    job = _Job(text, machine, coper, name, bare, tuple(diagnostics), radius)
    if any(stroke.is_tilted for stroke in strokes):
        return _tilted(job, strokes)
    walls = [_surface(bare, strokes, coper)] if is_tube else [*_walls(bare, strokes, coper)]
    missing = [rules.NOT_PARTED.at(source, face=wall.face) for wall in walls if wall.shape.is_empty]
    if missing:
        return Recovered((), (*diagnostics, *missing))
    part = job.part(max(wall.shape.bounds[2] for wall in walls), AS_SAID)
    if code == "M":
        faces = faces_of(walls[0].shape, bare.profile, job.within)
        if faces.lost:
            return Recovered((), (*diagnostics, rules.CORNER.at(source, found=faces.lost)))
        part = replace(part, cuts=faces.cuts)
        return job.recovered(part, job.of_box(part, faces, walls[0].line))
    return job.recovered(part, (one for wall in walls for one in job.features(part, wall)))


def _tilted(job: _Job, strokes: Sequence[TorchStroke]) -> Recovered:
    """The part that a tilted torch makes: with skew ends, or else with bevels at square ones.

    The read-back says which of them it is; an error where it takes neither.
    """
    section = CoperSection(job.bare.profile)
    square = [stroke for stroke in strokes if not stroke.is_tilted]
    ends = ends_of(strokes, section)
    tries: list[tuple[Sequence[TorchStroke], Ends]] = [] if ends is None else [(strokes, ends)]
    for cutting, planes in (*tries, (square, NO_ENDS)):
        walls = [*_walls(job.bare, cutting, job.coper, planes)]
        if any(wall.shape.is_empty for wall in walls):
            continue
        end = max(wall.shape.bounds[2] for wall in walls)
        end = length_of(planes[1], section) if planes[1] is not None else end
        part = replace(job.part(end, SAME), cuts=cuts_of(planes))
        if planes == NO_ENDS:  # an outline carries the bevels, whatever else is cut of its wall
            tilted = {stroke.face for stroke in strokes if stroke.is_tilted}
            walls = [replace(wall, is_drawn=wall.face in tilted) for wall in walls]
        features: list[Feature] = []
        for wall in walls:
            whole = whole_wall(wall.face, planes, part.length, section, wall.wide)
            features += job.features(part, wall, whole)
        if planes == NO_ENDS:
            features = [*with_bevels(features, strokes, section)]
        recovered = job.recovered(part, features)
        if not errors_in(recovered.diagnostics):
            return recovered
    first = next(stroke for stroke in strokes if stroke.is_tilted)
    tilt = rules.TILTED.at(Source(job.name, first.line), found=f"{first.b_deg:g}")
    return Recovered((), (tilt,))


# --- walls ----------------------------------------------------------------------------------------


def _walls(
    part: Part, strokes: Sequence[TorchStroke], coper: Coper, ends: Ends = NO_ENDS
) -> Iterator[_Wall]:
    """The walls of an I, a U or an L, of a T on its side or a C on its lips."""
    from shapely import box, union_all

    section = CoperSection(part.profile)
    far = max((x for stroke in strokes for x, _ in stroke.points), default=0.0) + coper.trim
    for face in section.faces:
        own = [stroke for stroke in strokes if stroke.face == face]
        low, high = section.extent(face)
        taken = union_all([surely for surely, _ in taken_of(face, own, strokes, section)])
        bar = box(-coper.trim, low, far, high)
        shape = _part_of(bar, taken, [(s.points[0], s.row.kerf / 2) for s in own])
        if face == "v":
            shape = union_all([shape, *_below_flanges(shape, section, ends)])
        wide = section.high if face == "v" else section.wide
        yield _Wall(face, shape, wide, own[0].line if own else 1)


def _below_flanges(web: Shape, section: CoperSection, ends: Ends) -> Iterator[Shape]:
    """The web within its flanges, where it stands on them; at a skew end along that."""
    from shapely import LineString, Polygon

    def at(x: float, inner: float, outer: float) -> float:
        """Where a side of the web that ends at x goes on to."""
        for end in ends:
            there, more = end.on("v", section, 0.0) if end is not None else (inf, 0.0)
            if abs(there + more * inner - x) <= SAME:
                return there + more * outer
        return x

    if web.is_empty:
        return
    low, high = section.extent("v")
    bands = [(low, 0.0)] if section.code in ("L", "T") else [(low, 0.0), (high, section.high)]
    for inner, outer in bands:
        left, _, right, _ = web.bounds
        for one in pieces_of(web.intersection(LineString([(left, inner), (right, inner)]))):
            first, _, last, _ = one.bounds
            if last > first:
                yield Polygon([
                    (first, inner), (last, inner), (at(last, inner, outer), outer),
                    (at(first, inner, outer), outer),
                ])  # fmt: skip


def _surface(part: Part, strokes: Sequence[TorchStroke], coper: Coper) -> _Wall:
    """The unrolled surface of a tube, laid around AROUND one above the other."""
    from shapely import box, union_all
    from shapely.affinity import translate

    turn = tube_section(rolled(part), coper).turn
    far = max((x for stroke in strokes for x, _ in stroke.points), default=0.0) + coper.trim
    kerfs, begins = [], []
    for stroke in strokes:
        kerf = kerf_of(stroke.points, stroke.row.kerf / 2)
        back = round(stroke.points[0][1] / turn)  # turns of its start from the first one
        for k in range(AROUND[0] - 2, AROUND[-1] + 3):
            off = (k - back) * turn
            kerfs.append(translate(kerf, 0.0, off))
            x, u = stroke.points[0]
            begins.append(((x, u + off), stroke.row.kerf / 2))
    bar = box(-coper.trim, AROUND[0] * turn, far, (AROUND[-1] + 1) * turn)
    shape = _part_of(bar, union_all(kerfs), begins)
    return _Wall("v", shape, turn, strokes[0].line if strokes else 1)


def _part_of(bar: Shape, taken: Shape, begins: Sequence[tuple[Point, float]]) -> Shape:
    """The pieces of a bar that are the part; `begins` are places where cuts begin, and half kerfs.

    Empty where none is parted from both ends of the bar.
    """
    from shapely import MultiPolygon
    from shapely import Point as Place

    left, _, right, _ = bar.bounds
    kept = []
    for piece in pieces_of(bar.difference(taken)):
        first, _, last, _ = piece.bounds
        is_parted = piece.area > SPECK and left < first and last < right
        scrap = any(piece.distance(Place(at)) <= half + BEGINS for at, half in begins)
        if is_parted and not scrap:
            kept.append(piece)
    return MultiPolygon(kept)


def _ring(ring: Shape) -> list[Point]:
    """The places of a ring without the one that repeats its start."""
    return [(x, y) for x, y in ring.coords[:-1]]
