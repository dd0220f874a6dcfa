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

from beamcam.pictures.scene import Frame, Point, Polyline, Shape, Text, Unit, shown

WIDTH = 1000.0
SIDE = 46.0  #: at the left and at the right of the views
HEAD_LINE = 16.0
TITLE = 30.0  #: above each view, for its name and the names of pieces
FIGURES = 52.0  #: below a view, for the figures of its places
GAP = 14.0
MAX_VIEWS_HEIGHT = 520.0
FIGURE_SIZE = 10.0

Box = tuple[float, float, float, float]


class View(Struct, frozen=True):
    """Content of one view: a box in millimetres and the dimensioned positions along x."""

    name: str
    title: str
    box: Box
    places: tuple[float, ...] = ()
    heights: tuple[float, ...] = ()  #: places along y
    down: bool = False  #: whether y runs down the paper

    @property
    def top(self) -> float:
        """The y of the box's upper edge on the paper."""
        return self.box[1] if self.down else self.box[3]

    @property
    def bottom(self) -> float:
        """The y of the box's lower edge on the paper."""
        return self.box[3] if self.down else self.box[1]


class Paper(Struct, frozen=True):
    """Layout of the views."""

    frames: dict[str, Frame]
    top: float  #: of the first view's title
    bottom: float  #: below the figures of the last view
    scale: float


def laid_out(views: Sequence[View], top: float) -> Paper:
    """The frames of views below `top`, as large as the paper allows, all at one scale."""
    length = max(v.box[2] for v in views) - min(v.box[0] for v in views)
    heights = sum(v.box[3] - v.box[1] for v in views)
    scale = (WIDTH - 2 * SIDE) / (length or 1.0)
    if heights * scale > MAX_VIEWS_HEIGHT:
        scale = MAX_VIEWS_HEIGHT / heights
    first = min(v.box[0] for v in views)
    left = SIDE - first * scale
    frames: dict[str, Frame] = {}
    y = top
    for view in views:
        y += TITLE + (view.box[3] - view.box[1]) * scale
        base = y - view.bottom * scale if view.down else y + view.bottom * scale
        frames[view.name] = Frame(scale, left, base, view.down)
        y += (FIGURES if view.places else 0.0) + GAP
    return Paper(frames, top, y, scale)


def heading(lines: Sequence[str], x: float = SIDE) -> Iterator[Text]:
    """The lines at the top of a picture, the first one larger."""
    for k, line in enumerate(lines):
        y = 26.0 + k * HEAD_LINE
        yield Text("heading" if k == 0 else "label", (x, y), line, 14.0 if k == 0 else 11.0)


def head_height(lines: Sequence[str]) -> float:
    """Height of the heading."""
    return 26.0 + len(lines) * HEAD_LINE


def titles(views: Sequence[View], paper: Paper) -> Iterator[Text]:
    """The names of the views, each above its upper left corner."""
    for view in views:
        x, y = paper.frames[view.name].at(view.box[0], view.top)
        yield Text("label", (x, y - 17.0), view.title)


def figures(view: View, paper: Paper, unit: Unit, offset: float = 0.0) -> Iterator[Shape]:
    """The dimensions of a view: each place along x at a line of its own, each y at the left.

    `offset` is taken off the figures, not off the places.
    """
    frame = paper.frames[view.name]
    base = frame.at(0.0, view.bottom)[1]
    places = sorted(set(view.places))
    most = int((WIDTH - 2 * SIDE + 30.0) / FIGURE_SIZE)
    if len(places) > most:
        places = [places[round(k * (len(places) - 1) / (most - 1))] for k in range(most)]
    ideal = [frame.at(x, 0.0)[0] for x in places]
    for x, at, label in zip(places, ideal, spread(ideal, FIGURE_SIZE), strict=True):
        yield Polyline("dim", ((at, base + 2.0), (at, base + 6.0), (label, base + 14.0)))
        value = x - offset
        place = (label + 3.5, base + 17.0)
        yield Text("figure", place, shown(value, unit), FIGURE_SIZE, "end", 90.0, value)
    left = frame.at(view.box[0], 0.0)[0]
    ys = sorted(set(view.heights), reverse=view.down)
    ideal = [-frame.at(0.0, y)[1] for y in ys]
    for y, at, label in zip(ys, ideal, spread(ideal, FIGURE_SIZE), strict=True):
        yield Polyline("dim", ((left - 2.0, -at), (left - 5.0, -at), (left - 9.0, -label)))
        place = (left - 11.0, -label + 3.5)
        yield Text("figure", place, shown(y, unit), FIGURE_SIZE, "end", 0.0, y)


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
