"""The picture of a bar's program: what its cuts and strokes make, as the read-back found it.

o  [ trim |  part 1  (1) (3)   / part 2   (7)    | remnant ]     numbers: order of the work
v  [      |     (2)            /                 |         ]     dashed: moves between strokes
     ^ stop positions of the bar: machine x of each stroke and cut
"""

from collections.abc import Iterator

from msgspec.structs import replace

from beamcam.checks.bars.pieces import CutPlane
from beamcam.checks.bars.stations import Bore, Cut, MachinedFeatures, MachinedPath, StampedText
from beamcam.machine.machine import text_x
from beamcam.model.description import face_title, runs_down
from beamcam.pictures.bar_made import BarMade
from beamcam.pictures.features import lettering
from beamcam.pictures.scene import (
    TOOL_COLOURS,
    Circle,
    Labels,
    PaperFrame,
    Pieces,
    Point,
    Polyline,
    Scene,
    Shape,
    Text,
    Unit,
    as_text,
    shown,
)
from beamcam.pictures.views import (
    FACES_DOWN,
    FIGURE_SIZE,
    LEGEND_ROW,
    SIDE,
    WIDTH,
    View,
    datum,
    edges_of,
    figures,
    footing,
    guides,
    head_height,
    heading,
    laid_out,
    legend,
    spread,
    titles,
    unshown,
)

MITRE_SIZE = 9.0
NUMBER_SIZES = (9.0, 6.0)  #: of an operation's number, and where there is no room for it


def bar_scene(bar: BarMade, unit: Unit = "mm") -> Scene:
    """The faces of the bar with its pieces, cuts and strokes."""
    made, machine = bar.made, bar.machine
    drill_x = machine.drill.x if machine.drill else 0.0
    used = {"v", *(op.face for ops in (made.bores, made.paths, made.texts) for op in ops)}
    used |= {s.face for s in machine.spindles if bar.profile.face_width(s.face)}
    lines = _head(bar, unit)
    views: tuple[View, ...] = tuple(
        View(
            face, face_title(face, bar.profile.code) + (
                "" if bar.profile.face_width(face) else "; drawn as far as its holes"),
            (0.0, 0.0, bar.drawn_end, bar.face_width(face)),
            tuple({round(b.x - drill_x, 3) for b in made.bores if b.face == face}
                  | {round(t.points[0][0] - drill_x, 3) for t in made.paths if t.face == face}),
            tuple({round(b.y, 3) for b in made.bores if b.face == face}
                  | {bar.profile.face_width(face)} - {0.0}), runs_down(face),
            tuple((b.x - drill_x, b.y) for b in made.bores if b.face == face),
            edges=edges_of(face, bar.profile.code),
        )
        for face in FACES_DOWN if face in used
    )  # fmt: skip
    views, y = laid_out(views, head_height(lines))
    tools = tool_numbers(made)
    drawn: list[Shape] = [*heading(lines), *titles(views)]
    for view in views:
        drawn += _stock(bar, view, unit)
        drawn += guides(view)
        drawn += datum(view)
        drawn += _rapids(bar, view, drill_x)
        drawn += _strokes(bar, view, drill_x, tools)
        drawn += figures(view, unit)
    drawn += _stops(bar, views[-1].frame, y, unit)
    rows = list(_legend(bar, tools, y + 62.0, unit))
    drawn += rows
    y = max(y, *(s.at[1] - 66.0 for s in rows if isinstance(s, Text)))
    notes = [f"{bar.name}   sha-256 {bar.sha256}",
             f"lengths in {unit} from the front end; stop positions in machine x",
             *(row for view in views for row in unshown(view, unit))]  # fmt: skip
    drawn += footing(notes, y + 76.0)
    about = (
        f"program {bar.name} as interpreted: {len(made.cuts)} cuts, {len(made.bores)} holes, "
        f"{len(made.paths)} paths; sha-256 {bar.sha256}"
    )
    return Scene(bar.name, about, WIDTH, y + 96.0 + 13.0 * len(notes), tuple(drawn))


def _head(bar: BarMade, unit: Unit) -> list[str]:
    profile = bar.profile
    size = profile.name or profile.code
    if profile.height and profile.width:
        size += f" {profile.height:g} x {profile.width:g}"
    else:
        size += f" {profile.height:g}, width" if profile.height else ", size"
        size += " not said"
    length = "length not said" if bar.bar is None else f"bar {shown(bar.bar, unit)} {unit}"
    parts = [p.mark for p in bar.pieces() if p.kind == "part"]
    return [bar.name, f"{bar.machine.name}, {size}, {length}", "parts: " + ", ".join(parts)]


def _edge(
    bar: BarMade, plane: CutPlane | None, face: str, end: float, kerf: int
) -> tuple[float, float]:
    """Bar x of an end of a piece at y 0 and at the greatest y; `kerf` is the side of the blade."""
    if plane is None:
        return end, end
    width = bar.face_width(face)
    off = kerf * plane.half_kerf
    return bar.x_on(plane, face, 0.0) + off, bar.x_on(plane, face, width) + off


def _stock(bar: BarMade, view: View, unit: Unit) -> Iterator[Shape]:
    """The pieces of the bar and its cuts on a face."""
    face, frame, width = view.name, view.frame, view.box[3]
    on_web = face == "v"
    for piece in bar.pieces():
        a, b = _edge(bar, piece.start, face, 0.0, 1)
        c, d = _edge(bar, piece.end, face, bar.drawn_end, -1)
        points = frame.all(((a, 0.0), (c, 0.0), (d, width), (b, width)))
        tip = piece.mark or piece.kind
        yield Polyline(f"{piece.kind} piece", points, True, tip)
        if on_web and piece.kind == "part":
            middle = frame.at((b + d) / 2, width)
            long = (min(c, d) - max(a, b)) * frame.scale
            first, last = bar.extent(piece)
            words: Pieces = (piece.mark, "   ", round(last - first, 3))
            if long < 6.5 * len(as_text(words, unit)):
                words = (piece.mark[: max(1, int(long / 6.5))],)
            if long > 12.0:
                at = (middle[0], middle[1] - 4)
                yield Text("label piece-mark", at, as_text(words, unit), 11.0, "middle",
                           pieces=words, unit=unit)  # fmt: skip
    if bar.drawn_end < bar.end:
        # The sign that a bar goes on: a zigzag across its end.
        (x, y0), (_, y1) = frame.at(bar.drawn_end, width), frame.at(bar.drawn_end, 0.0)
        middle_y = (y0 + y1) / 2
        zigzag = ((x, y0 - 4.0), (x, middle_y - 4.0), (x - 4.0, middle_y - 1.5),
                  (x + 4.0, middle_y + 1.5), (x, middle_y + 4.0), (x, y1 + 4.0))  # fmt: skip
        yield Polyline("dim break", zigzag, False, "the bar goes on")
    for plane in bar.saw_planes:
        ends = frame.all(((bar.x_on(plane, face, 0.0), 0.0), (bar.x_on(plane, face, width), width)))
        cut = plane.cut
        tip = f"cut at machine x {cut.x:g}, {plane.web_deg:g} and {plane.flange_deg:g} degrees"
        yield Polyline("cut" if on_web else "cut-edge", ends, False, tip, cut.line)


def tool_numbers(made: MachinedFeatures) -> dict[tuple[str, float], int]:
    """The tools of a program, numbered as they are first used."""
    tools: dict[tuple[str, float], int] = {}
    for op in made.order:
        if isinstance(op, Bore | MachinedPath):
            tools.setdefault((op.kind, op.diameter), len(tools))
    return tools


def order_numbers(made: MachinedFeatures) -> dict[int, int]:
    """The number of each operation by its line, from 1; a stroke of two spindles is one."""
    numbers: dict[int, int] = {}
    for op in made.order:
        numbers.setdefault(op.line, len(numbers) + 1)
    return numbers


def _strokes(
    bar: BarMade, view: View, drill_x: float, tools: dict[tuple[str, float], int]
) -> Iterator[Shape]:
    """What is made on a face, and its numbers in the order of the work."""
    frame = view.frame
    numbers = order_numbers(bar.made)
    places: list[tuple[int, int, Point, float]] = []  #: number, line, where, and how far off it
    labels = _labels(bar, view)
    angles: list[tuple[float, Point]] = []
    planes_of = {id(plane.cut): plane for plane in bar.saw_planes}
    for op in bar.made.order:
        number = numbers[op.line]
        if isinstance(op, Cut):
            plane = planes_of[id(op)]
            at = frame.at(bar.x_on(plane, view.name, view.top), view.top)
            angle = plane.web_deg if view.name in ("v", "h") else plane.flange_deg
            if round(angle, 2):
                foot = frame.at(bar.x_on(plane, view.name, view.bottom), view.bottom)
                angles.append((angle, ((at[0] + foot[0]) / 2, (at[1] + foot[1]) / 2)))
            if view.name == "v":
                places.append((number, op.line, at, 2.0))
        elif op.face == view.name:
            shape, at, gap = _stroke(op, number, bar, frame, drill_x, tools)
            yield shape
            if isinstance(op, Bore):
                radius = _radius(op, frame)
                labels.block((at[0] - radius, at[1] - radius, at[0] + radius, at[1] + radius))
            places.append((number, op.line, at, gap))
    for number, line, at, gap in places:
        placed = ((size, labels.place(at, gap, str(number), size, 2)) for size in NUMBER_SIZES)
        size, free = next((one for one in placed if one[1] is not None), (NUMBER_SIZES[-1], at))
        yield Text("number order", free or at, str(number), size, line=line)
    left, top = frame.at(0.0, view.top)  # figures stand beyond, and the title
    for y in (view.top, view.bottom):
        labels.block_line(frame.at(0.0, y), frame.at(view.box[2], y))
    for angle, at in angles:
        text = f"{round(abs(angle), 2):g}\N{DEGREE SIGN}"
        place = labels.place(
            at, 2.0, text, MITRE_SIZE, 5, lambda box: box[0] >= left and box[1] > top - 14.0
        )
        yield Text("figure mitre", place or at, text, MITRE_SIZE)


def _labels(bar: BarMade, view: View) -> Labels:
    """The room for numbers on a face: off the cuts, off the names of the faces beside it, and of a
    narrow face beside it."""
    labels, frame, width = Labels(), view.frame, view.box[3]
    for y in (0.0, width):
        if width * frame.scale < 2 * NUMBER_SIZES[0]:
            labels.block_line(frame.at(0.0, y), frame.at(view.box[2], y))
        right, level = frame.at(view.box[2], y)
        labels.block((right + 3.0, level - 6.0, right + 30.0, level + 4.0))
    for plane in bar.saw_planes:
        labels.block_line(*(frame.at(bar.x_on(plane, view.name, y), y) for y in (0.0, width)))
    return labels


def _stroke(
    op: Bore | MachinedPath | StampedText, number: int, bar: BarMade, frame: PaperFrame,
    drill_x: float, tools: dict[tuple[str, float], int],
) -> tuple[Shape, Point, float]:  # fmt: skip
    """What an operation makes, the place that its number stands beside, and how far off it."""
    if isinstance(op, StampedText):
        x = op.x - text_x(bar.machine)
        tip = f"{number}: {op.kind} {op.text!r}, {op.height:g} high, at x {x:g}, y {op.y:g}"
        text = lettering("text", replace(op, x=x), frame, tip, op.line)
        return text, text.at, 2.0
    colour = tools[op.kind, op.diameter] % len(TOOL_COLOURS)
    tip = f"{number}: {op.kind} {op.diameter:g}"
    if isinstance(op, MachinedPath):
        points = frame.all([(x - drill_x, y) for x, y in op.points])
        return Polyline(f"path-{colour} trail", points, False, tip, op.line), points[0], 2.5
    at, radius = frame.at(op.x - drill_x, op.y), _radius(op, frame)
    tip += f" at x {op.x - drill_x:g}, y {op.y:g}"
    noun = "hole" if op.kind == "drill" else op.kind
    hole = Circle(f"tool-{colour} {noun}", at, radius, tip, op.line)
    return hole, at, 0.8 * radius + 1.2


def _radius(bore: Bore, frame: PaperFrame) -> float:
    """A hole as it is drawn; a point is drawn as one too."""
    return max(bore.diameter / 2 * frame.scale, 1.2)


def _rapids(bar: BarMade, view: View, drill_x: float) -> Iterator[Polyline]:
    """The rapid moves from stroke to stroke of a face, as they lie over the bar."""
    frame = view.frame
    here: tuple[float, float] | None = None
    for op in bar.made.order:
        if not isinstance(op, Bore | MachinedPath) or op.face != view.name:
            continue
        first, last = ((op.x, op.y),) * 2 if isinstance(op, Bore) else (op.points[0], op.points[-1])
        if here is not None:
            yield Polyline("rapid", (here, frame.at(first[0] - drill_x, first[1])), line=op.line)
        here = frame.at(last[0] - drill_x, last[1])


def _stops(bar: BarMade, frame: PaperFrame, y: float, unit: Unit) -> Iterator[Shape]:
    """Stopping positions of the bar: machine x of the strokes and cuts."""
    drill_x = bar.machine.drill.x if bar.machine.drill else 0.0
    saw_x = bar.machine.saw.x if bar.machine.saw else 0.0
    stations = {Cut: saw_x, StampedText: text_x(bar.machine)}
    stops: dict[float, float] = {}
    for op in bar.made.order:
        x = op.points[0][0] if isinstance(op, MachinedPath) else op.x
        stops.setdefault(round(x, 3), x - stations.get(type(op), drill_x))
    yield Text("figure", (SIDE - 38.0, y + 4.0), "stop", 9.0)
    rows = sorted((place, x) for x, place in stops.items())
    most = int((WIDTH - 2 * SIDE) / FIGURE_SIZE)
    if len(rows) > most:
        rows = [rows[round(k * (len(rows) - 1) / (most - 1))] for k in range(most)]
    ideal = [frame.at(place, 0.0)[0] for place, _ in rows]
    for (_, x), at, label in zip(rows, ideal, spread(ideal, FIGURE_SIZE), strict=True):
        yield Polyline("stop", ((at, y - 2.0), (at, y + 4.0), (label, y + 12.0)), tip=f"x {x:g}")
        place = (label + 3.5, y + 15.0)
        yield Text("figure", place, shown(x, unit), FIGURE_SIZE, "end", 90.0, x)


def _legend(
    bar: BarMade, tools: dict[tuple[str, float], int], y: float, unit: Unit
) -> Iterator[Shape]:
    """The tools with how many holes each makes and how deep, and what the lines are."""
    x, depths = SIDE, bar.depths
    for (kind, diameter), number in tools.items():
        counts: dict[float | None, int] = {}
        for op in bar.made.order:
            if isinstance(op, Bore | MachinedPath) and (op.kind, op.diameter) == (kind, diameter):
                depth = depths.of(op)
                depth = None if depth is None else round(depth, 1)
                counts[depth] = counts.get(depth, 0) + 1
        words: list[str | float] = [kind + " Ø", diameter, ": "]
        for k, (depth, count) in enumerate(counts.items()):
            words += [", " if k else "", f"{count} × "]
            words += ["through"] if depth is None else [depth, " deep"]
        text = as_text(tuple(words), unit)
        if x + 26.0 + 6.2 * len(text) > WIDTH - 8.0:
            x, y = SIDE, y + LEGEND_ROW
        yield Circle(f"tool-{number % len(TOOL_COLOURS)} legend", (x + 4.0, y), 4.0)
        yield Text("label", (x + 12.0, y + 4.0), text, pieces=tuple(words), unit=unit)
        x += 26.0 + 6.2 * len(text)
    lines = [("cut", "saw cut"), ("rapid", "rapid move"), ("stop", "stop position"),
             ("guide", "to its dimension"), ("datum", "y = 0")]  # fmt: skip
    yield from legend(lines, y, x)
