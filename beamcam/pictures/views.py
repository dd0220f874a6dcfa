"""Views of faces stacked on one paper, at one scale, with room for their dimensions.

heading
o  top flange     [==============]   y = 0 is its upper edge, away from the web's front
                   |   |     |       figures of x, each at its line
v  web            [==============]   y = 0 is its lower edge
                   ...
footing
"""

from collections.abc import Iterator, Sequence

from msgspec import Struct
from msgspec.structs import replace

from beamcam.model.part import Face
from beamcam.pictures.scene import PaperFrame, Point, Polyline, Shape, Text, Unit, shown

WIDTH = 1000.0
SIDE = 46.0  #: at the left and at the right of the views
HEAD_LINE = 16.0
TITLE = 30.0  #: above each view, for its name and the names of pieces
FIGURES = 52.0  #: below a view, for the figures of its places
GAP = 14.0
TWO_ROWS_SIZE = 6.0  #: from figure to figure where they stand in two rows
TWO_ROWS = 30.0  #: how much deeper the second row stands
MAX_VIEW_HEIGHT = 520.0  #: of a view by itself
#: Of several views together with what stands about each, and at least: a page on its side has room
#: for them.
MAX_VIEWS_HEIGHT, MIN_VIEWS_HEIGHT = 600.0, 160.0
FIGURE_SIZE = 10.0

#: Figures along x that stand in one row, and at most in two.
ONE_ROW = int((WIDTH - 2 * SIDE + 30.0) / FIGURE_SIZE)
MOST = int((WIDTH - 2 * SIDE + 30.0) / TWO_ROWS_SIZE)
LEGEND_ROW = 16.0
NEAR_ZERO = 0.1  #: mm of a view that its zero may lie outside of it
LISTED = 24  #: figures in a line of the footing

Box = tuple[float, float, float, float]


FLANGED = "IUCTLM"  #: sections whose faces meet at edges
FACES_DOWN: tuple[Face, ...] = ("h", "o", "v", "u")  #: as they unfold, from the top of the paper
#: The faces that the edges y = 0 and greatest y of a view lead to.
BESIDE = {"v": ("u", "o"), "h": ("u", "o"), "o": ("h", "v"), "u": ("h", "v")}


def edges_of(face: str, code: str) -> tuple[str, str]:
    """The faces beside the lower and the upper edge of a face's y; blank of other sections."""
    return BESIDE.get(face, ("", "")) if code in FLANGED else ("", "")


class View(Struct, frozen=True):
    """Content of one view: a box in millimetres and the dimensioned positions along x."""

    name: str
    title: str
    box: Box
    places: tuple[float, ...] = ()
    heights: tuple[float, ...] = ()  #: places along y
    down: bool = False  #: whether y runs down the paper
    points: tuple[Point, ...] = ()  #: of holes, to which lines lead from their dimensions
    above: float = 0.0  #: pixels between the title and the face, for callouts
    edges: tuple[str, str] = ("", "")  #: faces that its lower and its upper edge of y lead to
    frame: PaperFrame = PaperFrame(1.0, 0.0, 0.0)  #: where it stands, once it is laid out

    @property
    def top(self) -> float:
        """The y of the box's upper edge on the paper."""
        return self.box[1] if self.down else self.box[3]

    @property
    def bottom(self) -> float:
        """The y of the box's lower edge on the paper."""
        return self.box[3] if self.down else self.box[1]


def laid_out(views: Sequence[View], top: float) -> tuple[tuple[View, ...], float]:
    """Views below `top`, as large as the paper allows, all at one scale; and y below the last."""
    length = max(v.box[2] for v in views) - min(v.box[0] for v in views)
    heights = sum(v.box[3] - v.box[1] for v in views)
    scale = (WIDTH - 2 * SIDE) / (length or 1.0)
    about = TITLE + FIGURES + GAP
    most = max(MIN_VIEWS_HEIGHT, MAX_VIEWS_HEIGHT - about * len(views))
    most = most if len(views) > 1 else MAX_VIEW_HEIGHT
    if heights * scale > most:
        scale = most / heights
    first = min(v.box[0] for v in views)
    left = SIDE - first * scale
    placed, y = [], top
    for view in views:
        high = (view.box[3] - view.box[1]) * scale
        # Figures of y may need more height than the face has.
        y += max(0.0, FIGURE_SIZE * len(distinct(view.heights)) - high - FIGURES - TITLE) / 2
        y += TITLE + view.above + high
        base = y - view.bottom * scale if view.down else y + view.bottom * scale
        placed.append(replace(view, frame=PaperFrame(scale, left, base, view.down)))
        y += (FIGURES if view.places else 0.0) + GAP
        y += TWO_ROWS if len(distinct(view.places)) > ONE_ROW else 0.0
    return tuple(placed), y


def heading(lines: Sequence[str], x: float = SIDE) -> Iterator[Text]:
    """The lines at the top of a picture, the first one larger."""
    for k, line in enumerate(lines):
        y = 26.0 + k * HEAD_LINE
        yield Text("heading" if k == 0 else "label", (x, y), line, 14.0 if k == 0 else 11.0)


def head_height(lines: Sequence[str]) -> float:
    """Height of the heading."""
    return 26.0 + len(lines) * HEAD_LINE


def titles(views: Sequence[View]) -> Iterator[Text]:
    """The names of the views, each above its upper left corner."""
    for view in views:
        x, y = view.frame.at(view.box[0], view.top)
        yield Text("label", (x, y - 17.0 - view.above), view.title)


def figures(view: View, unit: Unit, offset: float = 0.0) -> Iterator[Shape]:
    """The dimensions of a view: each place along x at a line of its own, each y at the left.

    `offset` is taken off the figures, not off the places.
    """
    frame = view.frame
    base = frame.at(0.0, view.bottom)[1]
    places = distinct(view.places, unit)
    rows = 1 if len(places) <= ONE_ROW else 2
    if len(places) > MOST:  # the footing has them all (`unshown`)
        places = [places[round(k * (len(places) - 1) / (MOST - 1))] for k in range(MOST)]
    ideal = [frame.at(x, 0.0)[0] for x in places]
    gap = FIGURE_SIZE if rows == 1 else TWO_ROWS_SIZE
    for k, (x, at, label) in enumerate(zip(places, ideal, spread(ideal, gap), strict=True)):
        deep = base + TWO_ROWS * (k % rows)
        line = ((at, base + 2.0), (at, base + 6.0), (label, base + 14.0), (label, deep + 14.0))
        yield Polyline("dim", line[: 3 + k % rows])
        value = x - offset
        place = (label + 3.5, deep + 17.0)
        yield Text("figure", place, shown(value, unit), FIGURE_SIZE, "end", 90.0, value)
    left = frame.at(view.box[0], 0.0)[0]
    ys = distinct(view.heights, unit)[:: -1 if view.down else 1]
    ideal = [-frame.at(0.0, y)[1] for y in ys]
    for y, at, label in zip(ys, ideal, spread(ideal, FIGURE_SIZE), strict=True):
        yield Polyline("dim", ((left - 2.0, -at), (left - 5.0, -at), (left - 9.0, -label)))
        place = (left - 11.0, -label + 3.5)
        yield Text("figure", place, shown(y, unit), FIGURE_SIZE, "end", 0.0, y)


def distinct(places: Sequence[float], unit: Unit = "mm") -> list[float]:
    """Places in order, of those that would show the same figure the first alone."""
    values: list[float] = []
    for place in sorted(places):
        if not values or shown(place, unit) != shown(values[-1], unit):
            values.append(place)
    return values


def guides(view: View) -> Iterator[Polyline]:
    """A pale line from each dimension through all holes that it is for, to the last of them."""
    left, base = view.frame.at(view.box[0], view.bottom)
    columns: dict[float, float] = {}
    rows: dict[float, float] = {}
    for x, y in view.points:
        px, py = view.frame.at(x, y)
        columns[px] = min(columns.get(px, base), py)
        rows[py] = max(rows.get(py, left), px)
    for x, top in columns.items():
        yield Polyline("guide", ((x, base), (x, top)))
    for y, right in rows.items():
        yield Polyline("guide", ((left, y), (right, y)))


def datum(view: View) -> Iterator[Shape]:
    """Where a face is measured from: the edge y = 0, x = 0, and the faces beside its edges."""
    (x0, y0, x1, y1), frame = view.box, view.frame
    if not (x0 <= NEAR_ZERO and y0 <= NEAR_ZERO and x1 > 0.0 and y1 > 0.0):
        return  # a drawing away from its zero
    (ax, ay), (bx, _) = frame.at(x0, 0.0), frame.at(x1, 0.0)
    yield Polyline("datum", ((ax, ay), (bx, ay)), False, "y = 0: heights are measured from here")
    zero, up = frame.at(0.0, 0.0)[0], 1.0 if frame.down else -1.0
    high = min(18.0, abs(y1) * frame.scale)
    arrow = ay + up * high
    yield Polyline(
        "datum",
        ((zero, ay), (zero, arrow), (zero - 3.0, arrow - up * 5.0), (zero, arrow),
         (zero + 3.0, arrow - up * 5.0)), False, "x = 0: lengths are measured from here",
    )  # fmt: skip
    for face, y in zip(view.edges, (0.0, y1), strict=True):
        if face:
            at = frame.at(x1, y)
            yield Text("figure", (at[0] + 4.0, at[1] + 3.0), f"to {face}", 9.0)


def unshown(view: View, unit: Unit) -> Iterator[str]:
    """All places along x of a view that has more of them than there is room for, as a list."""
    places = distinct(view.places, unit)
    if len(places) > MOST:
        for k in range(0, len(places), LISTED):
            figures_ = ", ".join(shown(x, unit) for x in places[k : k + LISTED])
            yield f"x on {view.name}: {figures_}"


def spread(ideal: Sequence[float], gap: float) -> list[float]:
    """Places in order, at least `gap` apart, as near to the ideal ones as that allows.

    Least squares by pooling neighbours that come too near (isotonic regression).
    """
    pools: list[tuple[float, int]] = []  #: mean of ideal - k gap, and how many
    for k, at in enumerate(ideal):
        pools.append((at - k * gap, 1))
        while len(pools) > 1 and pools[-2][0] > pools[-1][0]:
            (a, m), (b, n) = pools[-2:]
            pools[-2:] = [((a * m + b * n) / (m + n), m + n)]
    means = [mean for mean, count in pools for _ in range(count)]
    return [mean + k * gap for k, mean in enumerate(means)]


def measured(a: Point, b: Point, value: float, unit: Unit) -> Iterator[Shape]:
    """A horizontal dimension line with arrows from `a` to `b`, and its figure."""
    (x0, y), (x1, _) = a, b
    yield Polyline("dim", (a, b))
    for x, way in ((x0, 1), (x1, -1)):
        yield Polyline("dim", ((x + way * 6, y - 2.5), (x, y), (x + way * 6, y + 2.5)))
        yield Polyline("dim", ((x, y - 7.0), (x, y + 4.0)))
    yield Text("figure", ((x0 + x1) / 2, y - 4.0), shown(value, unit), 11.0, "middle", 0.0, value)


def footing(lines: Sequence[str], y: float) -> Iterator[Text]:
    """Small lines at the bottom of a picture; a page that shows another unit says so in them."""
    for k, line in enumerate(lines):
        classes = "figure unit-note" if line.startswith("lengths in ") else "figure"
        yield Text(classes, (SIDE, y + 14.0 + k * 13.0), line, 9.0)


def legend(rows: Sequence[tuple[str, str]], y: float, x: float = SIDE) -> Iterator[Shape]:
    """Styles and what they stand for; behind the right edge of the paper in a line below."""
    for style, words in rows:
        wide = 34.0 + 6.2 * len(words)
        if x + wide > WIDTH - 8.0:
            x, y = SIDE, y + LEGEND_ROW
        yield Polyline(f"{style} legend", ((x, y), (x + 18.0, y)))
        yield Text("label", (x + 23.0, y + 4.0), words)
        x += wide
