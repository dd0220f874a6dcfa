"""What a plasma cutter leaves of a sheet, measured apart from the read-back.

    program --rs274--> canonical moves --shapely--> band of the kerf
    drawing --ezdxf--> rings           --even-odd-> part

Nothing here is shared with beamcam. Part: the points enclosed by an odd number of closed
contours; curves that close no ring are open, the beam stays centred on them. Curves are chords at
most `FINE` off, discs have `QUADRANT` chords a quarter: of a beam of 1 mm they are 0.00002 mm
short, so that all figures hold within 0.005 mm.

    python -m tests.swept_band PROGRAM.ngc DRAWING.dxf KERF [KERF_BY]
"""

import re
import sys
from collections.abc import Iterable, Iterator
from math import ceil, pi
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry
from shapely.strtree import STRtree

from tests.rs274 import interpreted

FINE = 0.002
QUADRANT = 64
GAP = 0.0501  #: ends as near as this belong together
MARGIN = 10.0  #: of plate-linuxcnc, to whose corner the drawing is moved
MM_PER_UNIT = {0: 1.0, 1: 25.4, 2: 304.8, 4: 1.0, 5: 10.0, 6: 1000.0, 13: 0.001, 14: 100.0}
#: What a round beam leaves in a corner is no farther from it than so many kerfs: 11 degrees.
DEEPEST = 5.0
NO_CURVES = ("TEXT", "MTEXT", "POINT", "HATCH", "ATTRIB", "ATTDEF", "SOLID", "DIMENSION")
UNCUT_COLOURS = (2, 5)  #: yellow and blue are marked

_CALL = re.compile(
    r"(STRAIGHT_TRAVERSE|STRAIGHT_FEED|ARC_FEED|START_SPINDLE_\w+|STOP_SPINDLE_\w+"
    r"|SET_MOTION_OUTPUT_BIT|CLEAR_MOTION_OUTPUT_BIT)\(([^)]*)\)"
)


class Refused(Exception):
    """The interpreter does not take the program."""


def strokes_of(program: Path) -> list[shapely.LineString]:
    """The ways of the torch while it cuts, as LinuxCNC's interpreter moves it.

    Raises Refused with what the interpreter says.
    """
    run = interpreted(program)
    if run.returncode:
        raise Refused(run.stderr.replace("executing", "").strip())
    found: list[shapely.LineString] = []
    here = np.zeros(2)
    points: list[np.ndarray] | None = None
    for name, values in _CALL.findall(run.stdout):
        if name.startswith("START"):
            points = [here]
        elif name.startswith("STOP"):
            if points is not None and len(points) > 1:
                found.append(shapely.LineString(np.array(points)))
            points = None
        elif name.startswith(("STRAIGHT", "ARC")):
            numbers = [float(v) for v in values.split(",")]
            way = _arc(here, numbers) if name == "ARC_FEED" else [np.array(numbers[:2])]
            here = way[-1]
            if points is not None:
                points += way
    return found


def _arc(start: np.ndarray, numbers: list[float]) -> list[np.ndarray]:
    """Points along an arc; the interpreter says its end, its centre and its turns."""
    end, centre, turns = np.array(numbers[:2]), np.array(numbers[2:4]), numbers[4]
    u, v = start - centre, end - centre
    first, last = np.arctan2(u[1], u[0]), np.arctan2(v[1], v[0])
    sweep = (last - first) % (2 * pi) if turns > 0 else -((first - last) % (2 * pi))
    if abs(sweep) < 1e-12 or abs(abs(sweep) - 2 * pi) < 1e-9:
        sweep = 2 * pi if turns > 0 else -2 * pi
    near, far = np.hypot(*u), np.hypot(*v)
    count = max(2, ceil(abs(sweep) / np.sqrt(8 * FINE / max(near, FINE))))
    share = np.linspace(0.0, 1.0, count + 1)[1:]
    angle, radius = first + sweep * share, near + (far - near) * share
    points = centre + np.column_stack((radius * np.cos(angle), radius * np.sin(angle)))
    points[-1] = end
    return list(points)


class Drawn(NamedTuple):
    """The curves of a drawing where the machine puts them."""

    rings: list[shapely.Polygon]  #: each once
    opened: list[shapely.LineString]

    def part(self) -> BaseGeometry:
        """What is enclosed by an odd number of rings."""
        found = [shapely.Polygon(), *(shapely.make_valid(ring) for ring in self.rings)]
        while len(found) > 1:
            odd = found[len(found) // 2 * 2 :]
            found = [
                shapely.symmetric_difference(*two)
                for two in zip(found[::2], found[1::2], strict=False)
            ] + odd
        return found[0]


def drawn(path: Path, mm: float | None = None) -> Drawn:
    """The curves to cut in a DXF file; `mm` is its unit where its header does not say."""
    import ezdxf
    from ezdxf.disassemble import recursive_decompose
    from ezdxf.path import make_path

    document = ezdxf.readfile(path)
    scale = mm or MM_PER_UNIT.get(document.header.get("$INSUNITS", 0), 1.0)
    lines, marked = [], []
    for entity in recursive_decompose(document.modelspace()):
        layer = (
            document.layers.get(entity.dxf.layer) if entity.dxf.layer in document.layers else None
        )
        if entity.dxftype() in NO_CURVES or (layer and (layer.is_off() or layer.is_frozen())):
            continue
        try:
            # A path has cubics that come near to a rational spline, which are not enough here.
            smooth = entity if entity.dxftype() == "SPLINE" else make_path(entity)
            points = [tuple(v)[:2] for v in smooth.flattening(FINE / scale, segments=16)]
        except TypeError:
            continue
        if len(points) > 1:
            colour = entity.dxf.color
            if colour == 256 and layer is not None:
                colour = layer.dxf.color
            line = shapely.LineString(np.array(points) * scale)
            (marked if colour in UNCUT_COLOURS else lines).append(line)
    low = np.min([line.bounds[:2] for line in (*lines, *marked)], axis=0)
    return chained([shapely.transform(line, lambda p: p - low + MARGIN) for line in lines])


def chained(lines: Iterable[shapely.LineString]) -> Drawn:
    """Rings and open curves of lines whose ends are at most `GAP` apart."""
    kept = [line for line in lines if line.length > GAP]
    ends = np.array([p for line in kept for p in (line.coords[0], line.coords[-1])])
    place = _clusters(ends) if len(ends) else ends
    closed, loose = [], []
    for k, line in enumerate(kept):
        points = np.array(line.coords)
        points[0], points[-1] = place[2 * k], place[2 * k + 1]
        (closed if np.all(points[0] == points[-1]) else loose).append(shapely.LineString(points))
    loose = _each_once(loose)
    merged = shapely.get_parts(shapely.line_merge(shapely.MultiLineString(loose))).tolist()
    closed += [line for line in merged if line.is_ring or line.coords[0] == line.coords[-1]]
    rings = [shapely.Polygon(line) for line in _each_once(closed) if len(line.coords) > 3]
    rings = [r for r in rings if r.area > GAP * GAP]
    on_rings = shapely.union_all(shapely.buffer(shapely.get_exterior_ring(rings), GAP))
    opened = [line for line in merged if line.coords[0] != line.coords[-1]]
    return Drawn(rings, [line for line in opened if not on_rings.covers(line)])


def _clusters(ends: np.ndarray) -> np.ndarray:
    """For each place the first of those within the gap of it, (n, 2)."""
    tree = STRtree(shapely.points(ends))
    who, near = tree.query(shapely.points(ends), "dwithin", distance=GAP)
    first = np.arange(len(ends))
    for _ in range(8):
        np.minimum.at(first, who, first[near])
    return ends[first]


def _each_once(lines: list[shapely.LineString]) -> list[shapely.LineString]:
    """Lines without those that lie on an earlier one from end to end."""
    kept: list[shapely.LineString] = []
    tree = STRtree(lines)
    gone: set[int] = set()
    for k, line in enumerate(lines):
        if k in gone:
            continue
        kept.append(line)
        for other in tree.query(line, "dwithin", distance=GAP).tolist():
            same = abs(lines[other].length - line.length) < 4 * GAP
            if other > k and same and shapely.hausdorff_distance(line, lines[other]) < GAP:
                gone.add(other)
    return kept


class Measured(NamedTuple):
    """A cut sheet beside its drawing."""

    strokes: list[shapely.LineString]
    drawn: Drawn
    kerf: float

    def band(self, wider: float = 0.0) -> BaseGeometry:
        """All that the beam takes away, so much wider at each side."""
        radius = self.kerf / 2 + wider
        return shapely.union_all(shapely.buffer(self.strokes, radius, quad_segs=QUADRANT))

    def into_part(self) -> float:
        """How deep the band reaches into the part at most, in mm; 0 if it does not."""
        part = self.drawn.part()
        allowed = shapely.union_all(
            shapely.buffer(self.drawn.opened, self.kerf / 2 + 2 * GAP, quad_segs=QUADRANT)
        )
        bitten = shapely.difference(shapely.intersection(self.band(), part), allowed)
        # A strip along the edge has its corners on the outline, so that its sides are asked too.
        places = shapely.get_coordinates(shapely.segmentize(bitten, self.kerf / 8))
        return float(np.max(shapely.distance(shapely.points(places), part.boundary), initial=0.0))

    def pierced(self, by: float) -> int:
        """Strokes that begin inside of the part, more than `by` mm from its edge."""
        inner = self.drawn.part().buffer(-by)
        inner = shapely.difference(inner, shapely.union_all(shapely.buffer(self.drawn.opened, GAP)))
        return sum(bool(inner.intersects(shapely.Point(s.coords[0]))) for s in self.strokes)

    def uncut(self, by: float) -> float:
        """Length of contours in mm that the band misses by more than `by` though it could reach."""
        part, radius = self.drawn.part(), self.kerf / 2
        left = shapely.difference(part.boundary, self.band(by))
        waste = shapely.difference(self._sheet(), part)
        middles = waste.buffer(-radius, quad_segs=QUADRANT)
        reached = middles.buffer(radius, quad_segs=QUADRANT)
        return float(shapely.intersection(left, reached).length) + self._open_uncut(by)

    def _sheet(self) -> BaseGeometry:
        """More than all that is cut."""
        return shapely.box(
            *shapely.total_bounds([*self.strokes, *self.drawn.rings, *self.drawn.opened])
        ).buffer(4 * self.kerf + 1)

    def unreached(self, by: float) -> float:
        """How far the contour is from the band at most, where no beam of that kerf comes."""
        left = shapely.difference(self.drawn.part().boundary, self.band(by))
        places = shapely.get_coordinates(shapely.segmentize(left, self.kerf / 8))
        return float(np.max(shapely.distance(shapely.points(places), self.band()), initial=0.0))

    def _open_uncut(self, by: float) -> float:
        """Length of open curves that the middle of the beam does not follow."""
        if not self.drawn.opened:
            return 0.0
        # What lies on a ring is drawn twice, and cut beside it.
        rings = shapely.get_exterior_ring(self.drawn.rings)
        once = [*shapely.buffer(self.strokes, GAP + by), *shapely.buffer(rings, GAP)]
        left = shapely.difference(
            shapely.MultiLineString(self.drawn.opened), shapely.union_all(once)
        )
        return float(left.length)

    def joined(self, by: float) -> int:
        """Parts that still hang on the sheet or on another, where the band is `by` mm wider.

        Pieces of one ring that touch are one part.
        """
        rest = shapely.get_parts(shapely.difference(self._sheet(), self.band(by)))
        pieces = shapely.get_parts(self.drawn.part().buffer(-self.kerf / 4))
        middles = shapely.point_on_surface(pieces[shapely.area(pieces) > GAP * GAP])
        sizes = shapely.area(self.drawn.rings)
        rings = STRtree(self.drawn.rings)
        owner = [min(rings.query(m, "within").tolist(), key=lambda k: sizes[k]) for m in middles]
        inside, around = STRtree(rest).query(middles, "within")
        held: dict[int, set[int]] = {}
        for piece, whole in zip(inside.tolist(), around.tolist(), strict=True):
            held.setdefault(whole, set()).add(owner[piece])
        edge = self._sheet().exterior
        return sum(len(own) - (not rest[k].intersects(edge)) for k, own in held.items())

    def twice(self, by: float) -> float:
        """Length in mm of the paths that run within `by` of a path that was there before."""
        done, doubled = shapely.LineString(), 0.0
        for stroke in self.strokes:
            doubled += float(shapely.intersection(stroke, done.buffer(by)).length)
            done = shapely.union(done, stroke)
        return doubled

    def faults(self, by: float = 0.03) -> Iterator[str]:
        """What is wrong with the cut, in words."""
        if not (self.strokes or self.drawn.rings or self.drawn.opened):
            return
        if (found := self.into_part()) > by:
            yield f"{found:.3f} mm into the part"
        if found := self.pierced(by):
            yield f"{found} pierced in the part"
        if (found := self.uncut(by)) > by:
            yield f"{found:.3f} mm uncut"
        if (found := self.unreached(by)) > DEEPEST * self.kerf:
            yield f"{found:.3f} mm of a narrow place left"
        if found := self.joined(by):
            yield f"{found} parts not free"
        if (found := self.twice(by)) > self.kerf * len(self.strokes):
            yield f"{found:.3f} mm cut twice"


def measure(program: Path, drawing: Path, kerf: float, mm: float | None = None) -> Measured:
    """The program's cut beside its drawing. Raises Refused where the interpreter does."""
    return Measured(strokes_of(program), drawn(drawing, mm), kerf)


def main(*words: Any) -> None:
    program, drawing, kerf = words[:3]
    found = list(measure(Path(program), Path(drawing), float(kerf)).faults())
    print(f"{drawing}: {'; '.join(found) or 'right'}")


if __name__ == "__main__":
    main(*sys.argv[1:])
