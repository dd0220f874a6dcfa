"""The picture of a part: its faces unfolded in true proportions, dimensioned along x.

h  web, through it     faces lie one above the other as they unfold (`faces`); the ends are cut as
o  top flange          the part's mitres say
v  web
u  bottom flange
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import PurePath

from msgspec.structs import replace

from beamcam.geometry.curves import circle_of, join_boxes
from beamcam.model.colour import process_of
from beamcam.model.description import FACE_NAMES, end_lines, face_title, runs_down
from beamcam.model.part import (
    Bend,
    Camber,
    Contour,
    EndPlane,
    Face,
    Feature,
    Hole,
    Part,
    Profile,
    Slot,
    TextMark,
)
from beamcam.pictures import features as shapes
from beamcam.pictures.callouts import called_on, size_letters, sizes_on
from beamcam.pictures.features import cutting_planes, end_cuts, mitres
from beamcam.pictures.scene import (
    LETTER,
    Circle,
    Labels,
    PaperFrame,
    Point,
    Polyline,
    Scene,
    Shape,
    Text,
    Unit,
    shown,
)
from beamcam.pictures.views import (
    FACES_DOWN,
    SIDE,
    WIDTH,
    Box,
    View,
    datum,
    edges_of,
    figures,
    footing,
    guides,
    head_height,
    heading,
    legend,
    measured,
    titles,
    unshown,
)

FACES_OF = {"I": "ovu", "U": "ovu", "C": "ovu", "T": "ovu", "L": "vu", "M": "hovu", "B": "v"}
MAX_BLOCKED = 400  #: points of a line that callouts keep clear of; of a longer one some
SMALL = (150.0, 60.0)  #: pixels of a small picture
MAX_SMALL_SHAPES = 120
SECTION_SIDE = 70.0  #: of the picture of the section
SECTION_HEAD = 112.0  #: least height of a heading that the section stands in
MAX_EDGES = 40  #: of contours that have a dimension
MAX_CORNERS = 16  #: of an outer contour whose corners have one


Processes = Mapping[str, str]  #: of a machine, by colour or layer


def part_scene(part: Part, unit: Unit = "mm", processes: Processes | None = None) -> Scene:
    """The faces of a part with all its features; a drawing by the processes of a machine."""
    length = f"{shown(part.length, unit)} {unit} long" if part.length else ""
    words = [length, f"{part.quantity} pieces" if part.quantity != 1 else "1 piece", part.grade]
    names = [f"{name} {value}" for name, value in (("order", part.order),
             ("drawing", part.drawing), ("phase", part.phase)) if value]  # fmt: skip
    lines = [f"{part.mark or '(no mark)'}   {part.profile.name}".rstrip(),
             ", ".join(filter(None, words)), *([", ".join(names)] if names else [])]  # fmt: skip
    views = tuple(view_of(part, face) for face in faces_of(part))
    section = _section(part.profile)
    top = max(head_height(lines), SECTION_HEAD if section else 0.0)
    own = {view.name: [f for f in part.features if face_of(f) == view.name] for view in views}
    sizes = {face: [*sizes_on(features), *mitres(part, face)] for face, features in own.items()}
    views, bottom, called = called_on(
        views, sizes, top, unit, size_letters(sizes.values()),
        lambda view: _labels(own[view.name], part, view),
    )  # fmt: skip
    drawn: list[Shape] = [*heading(lines), *section, *titles(views)]
    for view in views:
        drawn += _face(part, view, processes, True)
        drawn += called[view.name].shapes
        drawn += figures(view, unit)
    last = max(views, key=lambda view: view.box[2] - view.box[0])
    y = bottom + 8.0
    left, right = (last.frame.at(x, 0.0)[0] for x in (last.box[0], last.box[2]))
    drawn += measured((left, y), (right, y), last.box[2] - last.box[0], unit)
    left_out = sum(one.left for one in called.values())
    notes = [f"lengths in {unit}"]
    if left_out:
        notes.append(f"{left_out} more sizes are not said here; `beamcam inspect` lists them")
    if any(isinstance(f, Hole | Slot) and f.kind != "mark" for f in part.features):
        notes.append("holes and slots go through their wall where no depth is said")
    planes = sum(isinstance(f, EndPlane) and not f.normal[0] for f in part.features)
    if planes:
        notes.append(f"{planes} cutting planes along the part are not drawn")
    notes.append(PurePath(part.source.file).name)
    notes += [row for view in views for row in unshown(view, unit)]
    y += 24.0
    # Styles that occur and what they stand for; of a drawing its processes.
    used = {shape.classes.split(" ", 1)[0] for shape in drawn}
    rows = [(style, words) for style, words in LEGEND if style in used]
    if part.measures is not None:
        lines_of = dict.fromkeys(s.classes for s in drawn if " by-" in s.classes)
        rows = [(classes.split()[0], classes.split("by-")[1]) for classes in lines_of]
    shapes_ = list(legend(rows, y))
    y = max([y, *(s.points[0][1] for s in shapes_ if isinstance(s, Polyline))])
    drawn += shapes_
    drawn += footing(notes, y + 8.0)
    title = f"{part.mark or 'part'} {part.profile.name}".strip()
    about = f"faces of {title}, {len(part.features)} features, lengths in {unit}"
    return Scene(title, about, WIDTH, y + 20.0 + 13.0 * len(notes), tuple(drawn))


def _labels(own: Sequence[Feature], part: Part, view: View) -> Labels:
    """What lies on a face already: its features, its edges and its lines."""
    labels, frame = Labels(), view.frame
    shapes_ = [s for f in own for s in shapes.feature_shapes(f, frame)]
    if view.name == "v" and part.measures is None:
        shapes_ += [*end_cuts(part, frame), *cutting_planes(part, frame)]
    for shape in shapes_:
        match shape:
            case Polyline(points=points):
                ring = (*points, points[0]) if shape.closed else points
                few = (*ring[:: len(ring) // MAX_BLOCKED + 1], ring[-1])
                for a, b in pairwise(few):
                    labels.block_line(a, b)
            case Circle(at=(x, y), radius=r):
                labels.block((x - r, y - r, x + r, y + r))
            case Text(at=(x, y), text=text, size=size):
                wide = LETTER * size * len(text)
                labels.block((x, y - size, x + wide, y) if not shape.turn_deg
                             else (x - size, y - wide, x + wide, y + wide))  # fmt: skip
    return labels


def small_scene(part: Part) -> Scene:
    """A small picture without figures: the web, or the whole of a plate or a drawing."""
    view = view_of(part, "v")
    x0, y0, x1, y1 = view.box
    scale = min(SMALL[0] / max(x1 - x0, 1.0), SMALL[1] / max(y1 - y0, 1.0))
    height = (y1 - y0) * scale + 4.0
    frame = PaperFrame(scale, 2.0 - x0 * scale, height - 2.0 + y0 * scale)
    shapes = [s for s in _face(part, replace(view, frame=frame)) if not isinstance(s, Text)]
    bare = tuple(replace(s, tip="") for s in shapes[:MAX_SMALL_SHAPES])
    return Scene(part.mark or "part", "the web", SMALL[0] + 4.0, height, bare)


def faces_of(part: Part) -> tuple[Face, ...]:
    """The faces that are drawn, from the top of the paper down: those of the section and more."""
    faces = set(FACES_OF.get(part.profile.code, "v"))
    used = {face_of(f) for f in part.features}
    planes = [plane.name for plane in part.planes if plane.name in used]
    if part.measures is not None:  # a drawing
        faces = {"v"}
    return (*(f for f in FACES_DOWN if f in faces | used), *planes)


def face_of(feature: Feature) -> Face | None:
    """The face that a feature is drawn on; None of a cutting plane."""
    return None if isinstance(feature, EndPlane) else getattr(feature, "face", "v")


def view_of(part: Part, face: Face) -> View:
    """A face with the box around all that lies on it, and the places that it is dimensioned at."""
    own = [f for f in part.features if face_of(f) == face]
    boxes: list[Box] = []
    is_outlined = part.profile.code == "B" and any(
        isinstance(f, Contour) and f.kind == "outer" and f.curves for f in own
    )
    is_stock = face in FACE_NAMES and part.profile.face_width(face) and part.measures is None
    if is_stock and not is_outlined:
        boxes.append((0.0, 0.0, part.length, part.profile.face_width(face)))
    places: set[float] = set()
    edges: set[float] = set()
    heights: set[float] = set()
    rises: set[float] = set()  #: of the edges of contours
    points: list[Point] = []
    if is_stock and part.profile.code != "B":
        places |= {round(x, 3) for line in end_lines(part, face) for x, _ in line}
    for feature in own:
        match feature:
            case Contour() if circle_of(feature.curves) is not None:
                centre, radius = circle_of(feature.curves) or ((0.0, 0.0), 0.0)
                boxes.append((centre[0] - radius, centre[1] - radius, centre[0] + radius,
                              centre[1] + radius))  # fmt: skip
                points.append(centre)
            case Contour():
                around = join_boxes([curve.bbox for curve in feature.curves])
                if around is not None:
                    boxes.append(around)
                    edges |= set(_edges(feature, around, 0))
                    rises |= set(_edges(feature, around, 1))
            case Bend(start=(x0, y0), end=(x1, y1)):
                places |= {round(x0, 3), round(x1, 3)}
                heights |= {round(y0, 3), round(y1, 3)}
            case Hole() | Slot() | TextMark() | Camber():
                boxes.append((feature.x, feature.y, feature.x, feature.y))
                if not isinstance(feature, Camber):
                    points.append((feature.x, feature.y))
            case _:
                pass
    box = join_boxes(boxes) or (0.0, 0.0, part.length or 100.0, 100.0)
    if box[3] - box[1] < 1.0:
        box = (box[0], box[1] - 5.0, box[2], box[3] + 5.0)
    places |= {round(x, 3) for x, _ in points}
    heights |= {round(y, 3) for _, y in points}
    if len(edges) <= MAX_EDGES:
        places |= edges
    if len(rises) <= MAX_EDGES:
        heights |= rises
    heights.add(round(box[3], 3))
    title = face_title(face, part.profile.code)
    if part.measures is not None:
        title = f"{face}   front, seen from the front; x and y as in the drawing"
    return View(
        face, title, box, tuple(places), tuple(heights), runs_down(face), tuple(points),
        edges=edges_of(face, part.profile.code),
    )  # fmt: skip


def _edges(contour: Contour, around: Box, axis: int) -> Iterator[float]:
    """The places along an axis at which a contour is dimensioned: ends, corners of an outer one."""
    yield from (round(around[axis], 3), round(around[axis + 2], 3))
    if contour.kind == "outer" and len(contour.curves) <= MAX_CORNERS:
        yield from (round(curve.start[axis], 3) for curve in contour.curves)


#: What styles of a part stand for, in the order of its legend.
LEGEND = (
    ("datum", "y = 0; arrow: x = 0"), ("hole", "hole"), ("slot", "slot"),
    ("thread", "thread, sink"), ("mark", "mark"), ("inner", "cut-out"), ("cut", "end cut"),
    ("bend", "bend, camber"), ("text", "text"), ("open", "open line"), ("punch", "punched line"),
    ("powder", "powder line"), ("engrave", "engraved line"), ("guide", "to its dimension"),
)  # fmt: skip


def _face(
    part: Part, view: View, processes: Processes | None = None, is_measured: bool = False
) -> Iterator[Shape]:
    """A face with its features, what is largest first so that nothing is hidden."""
    face, frame = view.name, view.frame
    own = [f for f in part.features if face_of(f) == face]
    outlined = any(isinstance(f, Contour) and f.kind == "outer" for f in own)
    if not outlined and face in FACE_NAMES and part.measures is None:
        (a, b), (c, d) = end_lines(part, face)
        yield Polyline("face", frame.all((a, c, d, b)), True, f"face {face}")
    # Lines to dimensions lie on the steel and under what is made in it.
    layers = sorted(own, key=_depth)
    steel = [f for f in layers if _depth(f) == 0]
    if is_measured and not steel:
        yield from guides(view)
    for feature in layers:
        if part.measures is not None and isinstance(feature, Contour):
            # A line of a drawing: nothing is filled, as the steel side is not known yet.
            process: str | None = feature.process
            if processes is not None and (feature.layer, feature.colour) != (None, None):
                process = process_of(feature, processes)  # type: ignore[arg-type]
            process = "ignored" if process in (None, "", "ignore") else process
            style = process if process == "ignored" else None
            yield shapes.contour_line(feature, frame, style, process)
        else:
            yield from shapes.feature_shapes(feature, frame)
        if is_measured and steel and feature is steel[-1]:
            yield from guides(view)
    if is_measured:
        yield from datum(view)
    if face == "v" and part.profile.code != "B":
        yield from end_cuts(part, frame)
    if face == "v":
        yield from cutting_planes(part, frame)


def _depth(feature: Feature) -> int:
    if isinstance(feature, Contour):
        return {"outer": 0, "inner": 1, "open": 2}[feature.kind]
    return 4 if isinstance(feature, TextMark) else 3


def _section(profile: Profile) -> Sequence[Shape]:
    """A small picture of the section in the upper right corner."""
    outlines = shapes.section_outlines(profile)
    if not outlines:
        return ()
    scale = SECTION_SIDE / max(profile.height, profile.width)
    left, wide = WIDTH - SIDE - profile.width * scale, profile.width * scale
    frame = PaperFrame(scale, left, 26.0 + profile.height * scale)
    styles = ("section", "paper")
    section: list[Shape] = [
        Polyline(style, frame.all(points), True)
        for style, points in zip(styles, outlines, strict=False)
    ]
    if len(outlines) > 1:
        section.append(Polyline("axis", frame.all(outlines[1]), True))
    middle, high = 26.0 + profile.height * scale / 2 + 4.0, 26.0 + profile.height * scale
    section += [
        Text("heading", (left + wide / 2, 21.0), "o", 11.0, "middle"),
        Text("heading", (left + wide / 2, high + 13.0), "u", 11.0, "middle"),
        Text("heading", (left - 5.0, middle), "h", 11.0, "end"),
        Text("heading", (left + wide + 5.0, middle), "v", 11.0),
    ]
    at = (left - 22.0, 26.0)
    section.append(Text("label", at, f"{profile.height:g} x {profile.width:g}", 10.0, "end"))
    at = (left - 22.0, 39.0)
    section.append(Text("figure", at, "seen from the start", 9.0, "end"))
    return section
