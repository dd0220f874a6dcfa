"""Writes a drawing as DXF and as SVG, the same for the same seed: plates with holes and slots.

    python benchmarks/make_drawing.py FOLDER [--segments 20000] [--arcs 2000] [--splines 500]

Straight segments are the sides of polygons, drawn as LINE entities and as a polyline each in turn;
arcs are the ends of slots, circles and lone arcs; splines are closed cubic B-splines, of the kind
that text as curves gives. Everything is drawn in red, in mm, no two contours touching. Beside it
stands jagged.dxf: 100 closed contours with 200 sharp corners each, and 2,500 open curves.
"""

from math import cos, pi, sin
from pathlib import Path
from random import Random

from script import arguments, at_least, start

CELL = 24.0  #: mm between the centres of two figures
SIDES = 40  #: of a polygon
RED = 1

Point = tuple[float, float]


class Drawing:
    """Figures one a cell, row by row."""

    def __init__(self, seed: int, columns: int) -> None:
        self.random = Random(seed)
        self.columns = columns
        self.count = 0
        self.polygons: list[list[Point]] = []
        self.slots: list[tuple[Point, float, float]] = []  #: centre, length between ends, radius
        self.circles: list[tuple[Point, float]] = []
        self.splines: list[list[Point]] = []  #: corners of closed uniform cubic B-splines

    def place(self) -> Point:
        """The centre of the next cell."""
        row, column = divmod(self.count, self.columns)
        self.count += 1
        return CELL * (column + 0.5), CELL * (row + 0.5)

    def ring(self, points: int, least: float, greatest: float) -> list[Point]:
        """A star-shaped polygon about the next cell's centre."""
        x, y = self.place()
        found = []
        for k in range(points):
            r = self.random.uniform(least, greatest)
            a = 2 * pi * (k + self.random.uniform(-0.3, 0.3)) / points
            found.append((x + r * cos(a), y + r * sin(a)))
        return found


def make(segments: int, arcs: int, splines: int, seed: int = 1) -> Drawing:
    """A drawing with so many straight segments, arcs (a circle counts as one) and splines."""
    figures = segments // SIDES + arcs + splines
    drawing = Drawing(seed, max(1, round(figures**0.5)))
    slots = arcs // 4
    for _ in range(max(0, segments - 2 * slots) // SIDES):
        drawing.polygons.append(drawing.ring(SIDES, 8.0, 11.0))
    for _ in range(slots):
        drawing.slots.append(
            (drawing.place(), drawing.random.uniform(3, 10), drawing.random.uniform(1, 4))
        )
    for _ in range(arcs - 2 * slots):
        drawing.circles.append((drawing.place(), drawing.random.uniform(1, 10)))
    for _ in range(splines):
        drawing.splines.append(drawing.ring(10, 6.0, 10.0))
    return drawing


def write_dxf(drawing: Drawing, path: Path) -> None:
    """The drawing as DXF R2010, mm."""
    import ezdxf

    document = ezdxf.new("R2010")
    document.header["$INSUNITS"] = 4
    space = document.modelspace()
    red = {"color": RED}
    for number, points in enumerate(drawing.polygons):
        if number % 2:
            space.add_lwpolyline(points, close=True, dxfattribs=red)
        else:
            for a, b in zip(points, [*points[1:], points[0]], strict=True):
                space.add_line(a, b, dxfattribs=red)
    for (x, y), length, r in drawing.slots:
        half = length / 2
        space.add_line((x - half, y - r), (x + half, y - r), dxfattribs=red)
        space.add_arc((x + half, y), r, -90, 90, dxfattribs=red)
        space.add_line((x + half, y + r), (x - half, y + r), dxfattribs=red)
        space.add_arc((x - half, y), r, 90, 270, dxfattribs=red)
    for centre, radius in drawing.circles:
        space.add_circle(centre, radius, dxfattribs=red)
    for corners in drawing.splines:
        closed = [*corners, *corners[:3]]
        spline = space.add_open_spline([(x, y, 0.0) for x, y in closed], 3, dxfattribs=red)
        spline.knots = [float(k) for k in range(len(closed) + 4)]
    document.saveas(path)


def write_svg(drawing: Drawing, path: Path) -> None:
    """The same as SVG, Y downwards, coordinates in mm; splines as cubic Bezier curves."""
    rows = -(-drawing.count // drawing.columns)
    width, height = CELL * drawing.columns, CELL * rows

    def at(point: Point) -> str:
        return f"{point[0]:.6f},{height - point[1]:.6f}"

    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}mm" height="{height}mm" '
        f'viewBox="0 0 {width} {height}">',
        '<g style="fill:none;stroke:#ff0000;stroke-width:0.1">',
    ]
    for points in drawing.polygons:
        lines.append(f'<polygon points="{" ".join(map(at, points))}"/>')
    for (x, y), length, r in drawing.slots:
        a, b = (x - length / 2, y - r), (x + length / 2, y - r)
        c, d = (x + length / 2, y + r), (x - length / 2, y + r)
        lines.append(
            f'<path d="M{at(a)} L{at(b)} A{r},{r} 0 0 0 {at(c)} '
            f'L{at(d)} A{r},{r} 0 0 0 {at(a)} z"/>'
        )
    for (x, y), radius in drawing.circles:
        lines.append(f'<circle cx="{x:.6f}" cy="{height - y:.6f}" r="{radius:.6f}"/>')
    for corners in drawing.splines:
        lines.append(f'<path d="{_bezier_path(corners, at)}"/>')
    lines += ["</g>", "</svg>", ""]
    path.write_text("\n".join(lines), encoding="utf-8")


def write_jagged(path: Path, seed: int = 1) -> None:
    """100 closed contours with 200 sharp corners each and 2,500 open curves, as DXF R2010, mm.

    The contours are spikes about 14 mm long, round a place each; of the open curves, above them, a
    third each are lines, arcs and polylines of four sides.
    """
    import ezdxf

    uniform = Random(seed).uniform
    document = ezdxf.new("R2010")
    document.header["$INSUNITS"] = 4
    space, red = document.modelspace(), {"color": RED}
    for k in range(100):
        x, y = 100.0 * (k % 10 + 0.5), 100.0 * (k // 10 + 0.5)
        corners = []
        for i in range(200):
            r = uniform(22, 30) if i % 2 else uniform(36, 44)
            a = 2 * pi * (i + uniform(-0.2, 0.2)) / 200
            corners.append((round(x + r * cos(a), 4), round(y + r * sin(a), 4)))
        space.add_lwpolyline(corners, close=True, dxfattribs=red)
    for k in range(2_500):
        x, y = 10.0 * (k % 100 + 0.5), 1020 + 10.0 * (k // 100 + 0.5)
        if k % 3 == 0:
            ends = (x - 3, y + uniform(-3, 3)), (x + 3, y + uniform(-3, 3))
            space.add_line(*ends, dxfattribs=red)
        elif k % 3 == 1:
            angles = uniform(0, 90), uniform(180, 300)
            space.add_arc((x, y), uniform(1, 4), *angles, dxfattribs=red)
        else:
            corners = [(x - 4 + 2 * i, round(y + uniform(-4, 4), 4)) for i in range(5)]
            space.add_lwpolyline(corners, dxfattribs=red)
    document.saveas(path)


def _bezier_path(corners: list[Point], at: object) -> str:
    """A closed uniform cubic B-spline as cubics: thirds of the control polygon's sides."""
    count = len(corners)

    def mix(a: Point, b: Point, share: float) -> Point:
        return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])

    text = []
    for k in range(count):
        p0, p1, p2, p3 = (corners[(k + i) % count] for i in range(4))
        first, second = mix(p1, p2, 1 / 3), mix(p1, p2, 2 / 3)
        start = mix(mix(p0, p1, 2 / 3), first, 0.5)
        end = mix(second, mix(p2, p3, 1 / 3), 0.5)
        if not text:
            text.append(f"M{at(start)}")  # type: ignore[operator]
        text.append(f"C{at(first)} {at(second)} {at(end)}")  # type: ignore[operator]
    return " ".join([*text, "z"])


def main() -> None:
    """Writes drawing.dxf and drawing.svg."""
    parser = arguments(__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--segments", type=at_least(0), default=20_000, help="default 20000")
    parser.add_argument("--arcs", type=at_least(0), default=2_000, help="default 2000")
    parser.add_argument("--splines", type=at_least(0), default=500, help="default 500")
    parser.add_argument("--seed", type=int, default=1, help="default 1")
    asked = parser.parse_args()
    folder = asked.folder
    drawing = make(asked.segments, asked.arcs, asked.splines, asked.seed)
    folder.mkdir(parents=True, exist_ok=True)
    write_dxf(drawing, folder / "drawing.dxf")
    write_svg(drawing, folder / "drawing.svg")
    write_jagged(folder / "jagged.dxf", asked.seed)


if __name__ == "__main__":
    start(main)
