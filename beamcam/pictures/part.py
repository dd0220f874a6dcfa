"""The picture of a part: its faces unfolded in true proportions, dimensioned along x.

h  web, through it     faces lie one above the other as they unfold (`faces`); the ends are cut as
o  top flange          the part's mitres say
v  web
u  bottom flange
"""

from collections.abc import Iterator, Mapping, Sequence
from math import radians, tan
from pathlib import PurePath

from msgspec.structs import replace

from beamcam.geometry.curves import join_boxes
from beamcam.model.colour import process_of
from beamcam.model.faces import FACE_NAMES, face_title, runs_down
from beamcam.model.part import (
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
)  # fmt: skip
from beamcam.pictures import features as shapes
from beamcam.pictures.scene import Frame, Point, Polyline, Scene, Shape, Text, Unit, shown
from beamcam.pictures.views import (
    SIDE,
    WIDTH,
    Box,
    Paper,
    View,
    figures,
    footing,
    head_height,
    heading,
    laid_out,
    measured,
    titles,
)

FACES_OF = {"I": "ovu", "U": "ovu", "C": "ovu", "T": "ov", "L": "vu", "M": "hovu", "B": "v"}
SMALL = (150.0, 60.0)  #: pixels of a small picture
MAX_SMALL_SHAPES = 120
SECTION_SIDE = 70.0  #: of the picture of the section
SECTION_HEAD = 76.0  #: least height of a heading that the section stands in
MAX_EDGES = 40  #: of contours that have a dimension
MAX_CORNERS = 16  #: of an outer contour whose corners have one


Processes = Mapping[str, str]  #: of a machine, by colour or layer


def part_scene(part: Part, unit: Unit = "mm", processes: Processes | None = None) -> Scene:
    """The faces of a part with all its features; a drawing by the processes of a machine."""
    lines = [line for line in _head(part, unit) if line]
    views = tuple(view_of(part, face) for face in faces_of(part))
    section = _section(part.profile)
    paper = laid_out(views, max(head_height(lines), SECTION_HEAD if section else 0.0))
    drawn: list[Shape] = [*heading(lines), *section, *titles(views, paper)]
    for view in views:
        drawn += _face(part, view, paper, processes)
        drawn += figures(view, paper, unit)
    last = max(views, key=lambda view: view.box[2] - view.box[0])
    frame = paper.frames[last.name]
    y = paper.bottom + 8.0
    left, right = frame.at(last.box[0], 0.0)[0], frame.at(last.box[2], 0.0)[0]
    drawn += measured((left, y), (right, y), last.box[2] - last.box[0], unit)
    notes = [f"lengths in {unit}", *_notes(part)]
    drawn += footing(notes, y + 8.0)
    drawn += _legend(drawn, y + 24.0 + 13.0 * len(notes)) if part.measures is not None else ()
    title = f"{part.mark or 'part'} {part.profile.name}".strip()
    about = f"faces of {title}, {len(part.features)} features, lengths in {unit}"
    return Scene(title, about, WIDTH, y + 44.0 + 13.0 * len(notes), tuple(drawn))


def small_scene(part: Part) -> Scene:
    """A small picture without figures: the web, or the whole of a plate or a drawing."""
    view = view_of(part, "v")
    x0, y0, x1, y1 = view.box
    scale = min(SMALL[0] / max(x1 - x0, 1.0), SMALL[1] / max(y1 - y0, 1.0))
    height = (y1 - y0) * scale + 4.0
    frame = Frame(scale, 2.0 - x0 * scale, height - 2.0 + y0 * scale)
    paper = Paper({"v": frame}, 0.0, height, scale)
    shapes = [s for s in _face(part, view, paper) if not isinstance(s, Text)]
    bare = tuple(replace(s, tip="") for s in shapes[:MAX_SMALL_SHAPES])
    return Scene(part.mark or "part", "the web", SMALL[0] + 4.0, height, bare)


def _head(part: Part, unit: Unit) -> Iterator[str]:
    yield f"{part.mark or '(no mark)'}   {part.profile.name}".rstrip()
    length = f"{shown(part.length, unit)} {unit} long" if part.length else ""
    words = [length, f"{part.quantity} pieces" if part.quantity != 1 else "1 piece", part.grade]
    yield ", ".join(word for word in words if word)
    names = [f"{name} {value}" for name, value in (("order", part.order),
             ("drawing", part.drawing), ("phase", part.phase)) if value]  # fmt: skip
    yield ", ".join(names)


def _notes(part: Part) -> Iterator[str]:
    planes = sum(isinstance(f, EndPlane) and not f.normal[0] for f in part.features)
    if planes:
        yield f"{planes} cutting planes along the part are not drawn"
    yield PurePath(part.source.file).name


def faces_of(part: Part) -> tuple[Face, ...]:
    """The faces that are drawn, from the top of the paper down: those of the section and more."""
    wanted = set(FACES_OF.get(part.profile.code, "v"))
    used = {face_of(f) for f in part.features}
    planes = [plane.name for plane in part.planes if plane.name in used]
    if part.measures is not None:  # a drawing
        wanted = {"v"}
    return (*(f for f in ("h", "o", "v", "u") if f in wanted | used), *planes)


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
    for feature in own:
        match feature:
            case Contour():
                around = join_boxes([curve.bbox for curve in feature.curves])
                if around is not None:
                    boxes.append(around)
                    edges |= set(_edges(feature, around))
            case Hole() | Slot() | TextMark() | Camber():
                boxes.append((feature.x, feature.y, feature.x, feature.y))
                if isinstance(feature, Hole | Slot):
                    places.add(round(feature.x, 3))
                    heights.add(round(feature.y, 3))
            case _:
                pass
    if len(edges) <= MAX_EDGES:
        places |= edges
    box = join_boxes(boxes) or (0.0, 0.0, part.length or 100.0, 100.0)
    if box[3] - box[1] < 1.0:
        box = (box[0], box[1] - 5.0, box[2], box[3] + 5.0)
    title = face_title(face, part.profile.code)
    return View(face, title, box, tuple(places), tuple(heights), runs_down(face))


def _edges(contour: Contour, around: Box) -> Iterator[float]:
    """The places along x at which a contour is dimensioned: both ends, corners of an outer one."""
    yield from (round(around[0], 3), round(around[2], 3))
    if contour.kind == "outer" and len(contour.curves) <= MAX_CORNERS:
        yield from (round(curve.start[0], 3) for curve in contour.curves)


def _legend(drawn: Sequence[Shape], y: float) -> Iterator[Shape]:
    """The processes of a drawing."""
    x = SIDE
    styles = {s.classes.split("by-")[1]: s.classes.split()[0] for s in drawn if " by-" in s.classes}
    for process, style in styles.items():
        yield Polyline(f"{style} legend", ((x, y), (x + 18.0, y)))
        yield Text("label", (x + 23.0, y + 4.0), process)
        x += 46.0 + 6.2 * len(process)


def _drawn_line(contour: Contour, frame: Frame, processes: Processes | None) -> Shape:
    """A line of a drawing: nothing is filled, as the steel side is not known yet."""
    process: str = contour.process
    if processes is not None and (contour.layer, contour.colour) != (None, None):
        process = process_of(contour, processes) or "ignored"  # type: ignore[arg-type]
    if process in ("ignore", "ignored"):
        return shapes.contour_line(contour, frame, "ignored", "ignored")
    return shapes.contour_line(contour, frame, None, process)


def _face(
    part: Part, view: View, paper: Paper, processes: Processes | None = None
) -> Iterator[Shape]:
    """A face with its features, what is largest first so that nothing is hidden."""
    face, frame = view.name, paper.frames[view.name]
    own = [f for f in part.features if face_of(f) == face]
    outlined = any(isinstance(f, Contour) and f.kind == "outer" for f in own)
    if not outlined and face in FACE_NAMES and part.measures is None:
        yield Polyline("face", _outline(part, face, frame), True, f"face {face}")
    for feature in sorted(own, key=_depth):
        if part.measures is not None and isinstance(feature, Contour):
            yield _drawn_line(feature, frame, processes)
        else:
            yield from shapes.feature_shapes(feature, frame)
    if face == "v" and part.profile.code != "B":
        yield from _end_cuts(part, frame)
    if face == "v":
        yield from _planes(part, frame)


def _depth(feature: Feature) -> int:
    if isinstance(feature, Contour):
        return {"outer": 0, "inner": 1, "open": 2}[feature.kind]
    return 4 if isinstance(feature, TextMark) else 3


def _rise_and_depth(profile: Profile, face: Face, y: float) -> Point:
    """Place in the section of a point of a face: up from the lower edge, and across."""
    if face in ("v", "h"):
        return y, profile.width / 2
    return (profile.height if face == "o" else 0.0), y


def end_lines(part: Part, face: Face) -> tuple[tuple[Point, Point], tuple[Point, Point]]:
    """The lines in which the end cuts meet a face, each from y 0 upwards.

    x = c - rise tan(web) - across tan(flange) at both ends; the start touches x 0, the end the
    length (DSTV, header).
    """
    p, cuts = part.profile, part.cuts
    corners = [(r, z) for r in (0.0, p.height) for z in (0.0, p.width)]

    def line(web_deg: float, flange_deg: float, start: bool) -> tuple[Point, Point]:
        a, b = tan(radians(web_deg)), tan(radians(flange_deg))
        ways = [-r * a - z * b for r, z in corners]
        c = -min(ways) if start else part.length - max(ways)

        def at(y: float) -> Point:
            r, z = _rise_and_depth(p, face, y)
            return c - r * a - z * b, y

        return at(0.0), at(p.face_width(face))

    return (
        line(cuts.web_start, cuts.flange_start, True),
        line(cuts.web_end, cuts.flange_end, False),
    )


def _outline(part: Part, face: Face, frame: Frame) -> tuple[Point, ...]:
    (a, b), (c, d) = end_lines(part, face)
    return frame.all((a, c, d, b))


def _end_cuts(part: Part, frame: Frame) -> Iterator[Polyline]:
    """The cuts of both ends, on the web."""
    c = part.cuts
    for k, (line, web, flange) in enumerate(
        zip(end_lines(part, "v"), (c.web_start, c.web_end), (c.flange_start, c.flange_end),
            strict=True)
    ):  # fmt: skip
        angles = f"web {web:g}, flange {flange:g} degrees"
        yield Polyline("cut", frame.all(line), False, f"{'end' if k else 'start'} cut, {angles}")


def _planes(part: Part, frame: Frame) -> Iterator[Polyline]:
    """The cutting planes, where they cross the web at the depth of their point."""
    for plane in part.features:
        if isinstance(plane, EndPlane) and plane.normal[0]:
            (px, py, _), (nx, ny, nz) = plane.point, plane.normal
            line = [(px - (y - py) * ny / nx, y) for y in (0.0, part.profile.height)]
            tip = f"cutting plane, normal {nx:g}, {ny:g}, {nz:g}"
            yield Polyline("cut", frame.all(line), False, tip)


def _section(profile: Profile) -> Sequence[Shape]:
    """A small picture of the section in the upper right corner."""
    outlines = shapes.section_outlines(profile)
    if not outlines:
        return ()
    scale = SECTION_SIDE / max(profile.height, profile.width)
    frame = Frame(scale, WIDTH - SIDE - profile.width * scale, 14.0 + profile.height * scale)
    styles = ("section", "paper")
    found: list[Shape] = [
        Polyline(style, frame.all(points), True)
        for style, points in zip(styles, outlines, strict=False)
    ]
    if len(outlines) > 1:
        found.append(Polyline("axis", frame.all(outlines[1]), True))
    at = (WIDTH - SIDE - profile.width * scale - 8.0, 24.0)
    found.append(Text("label", at, f"{profile.height:g} x {profile.width:g}", 10.0, "end"))
    return found
