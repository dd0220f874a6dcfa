r"""Shapes of a part's features, and of the section that it is made of.

Depths of machined features in the steel: of the full diameter, not of the tool's point.

|\        /|   drill      to the shoulder of its point; through, once that has passed the wall
| \      / |   sink       of the cone within the steel: what is in the pilot hole cuts nothing
|  |    |  |   tap, mill  of the tip
"""

from collections.abc import Iterable, Iterator, Sequence
from math import atan2, degrees, hypot, radians, tan

from beamcam.checks.bars.stations import Bore, MachinedPath, StampedText
from beamcam.checks.bars.tools import ToolCatalogue
from beamcam.geometry.curves import Arc, Curve, Line, unit_vector
from beamcam.geometry.polylines import polylines
from beamcam.machine.machine import Machine
from beamcam.machine.stations import FLAT_DEG
from beamcam.model.description import FACE_NAMES, end_lines
from beamcam.model.part import (
    MIRRORED_FACES,
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
from beamcam.pictures.callouts import FaceSize, SizePlace
from beamcam.pictures.scene import CAPITAL, Circle, PaperFrame, Point, Polyline, Shape, Text

SAME_PLACE = 0.5  #: mm between a sink and its pilot hole


class SteelDepths:
    """Depths of what a program makes on a bar."""

    def __init__(self, machine: Machine, profile: Profile, bores: Iterable[Bore]) -> None:
        self._tools = ToolCatalogue(machine, machine.drill) if machine.drill is not None else None
        self._profile, self._noise = profile, 2 * machine.format.resolution
        self._pilots: dict[tuple[str, int, int], float] = {}
        for bore in bores:
            if bore.kind == "drill":
                key = _place(bore)
                self._pilots[key] = max(self._pilots.get(key, 0.0), bore.diameter)

    def of(self, op: Bore | MachinedPath) -> float | None:
        """The depth of one in the steel, mm; None where it goes through the wall."""
        thickness = self._profile.thickness(op.face)
        depth = self._bore(op) if isinstance(op, Bore) else op.max_depth
        is_through = op.kind in ("drill", "tap", "mill") and thickness > 0.0
        return None if is_through and depth > thickness - self._noise else depth

    def _bore(self, bore: Bore) -> float:
        if self._tools is None or bore.kind not in ("drill", "countersink"):
            return bore.tip_depth
        if bore.kind == "drill":
            return bore.tip_depth - self._tools.tip("drill", bore.diameter, bore.face)
        angle = self._tools.point_deg("countersink", bore.diameter, bore.face)
        if angle >= FLAT_DEG:
            return bore.tip_depth
        pilot = self._pilots.get(_place(bore), 0.0)
        return bore.tip_depth - pilot / 2 / tan(radians(angle) / 2)


def _place(bore: Bore) -> tuple[str, int, int]:
    return bore.face, round(bore.x / SAME_PLACE), round(bore.y / SAME_PLACE)


CHORD_PIXELS = 0.02  #: of the chords that stand for curves
CROSS = 5.0  #: half of the cross of a mark, pixels
MIN_RADIUS = 0.8  #: of a circle that can be seen, pixels
INNER_CIRCLES = {"thread": 0.8, "left-thread": 0.8, "countersink": 0.6}  #: shares of the radius


def feature_shapes(feature: Feature, frame: PaperFrame) -> Iterator[Shape]:
    """The shapes of a feature; the first one has the feature's own class."""
    match feature:
        case Hole() if feature.kind == "mark" or feature.diameter == 0.0:
            yield cross("mark", frame.at(feature.x, feature.y), _hole_tip(feature))
        case Hole():
            at = frame.at(feature.x, feature.y)
            radius = max(feature.diameter / 2 * frame.scale, MIN_RADIUS)
            yield Circle("hole", at, radius, _hole_tip(feature))
            if feature.kind in INNER_CIRCLES:
                yield Circle("thread", at, radius * INNER_CIRCLES[feature.kind])
        case Slot():
            points = chain_points(slot_curves(feature), frame)
            size = f"{feature.length + feature.diameter:g} x {feature.height + feature.diameter:g}"
            tip = f"slot {feature.face} {size} at x {feature.x:g}, y {feature.y:g}"
            yield Polyline("slot", points, True, tip)
        case Contour():
            # Filled where it encloses steel or a cut-out, else a line of its process.
            closed = feature.closed and feature.process == "cut" and feature.kind != "open"
            style = feature.kind if closed else None
            yield contour_line(feature, frame, style, feature.process)
        case TextMark():
            tip = f"text {feature.face} at x {feature.x:g}, y {feature.y:g}"
            yield lettering("text", feature, frame, tip)
        case Bend():
            tip = f"bend of {feature.angle:g} degrees"
            yield Polyline("bend", frame.all((feature.start, feature.end)), False, tip)
        case Camber():
            yield cross("bend", frame.at(feature.x, feature.y), "camber")


def lettering(
    classes: str, text: TextMark | StampedText, frame: PaperFrame, tip: str = "", line: int = 0
) -> Text:
    """A text where it stands on its face, to be read.

    On h, which is drawn through the web, it would stand as mirror writing below its base line; it
    fills the same place there and runs the same way.
    """
    size = max(text.height * frame.scale * 1.35, 5.0)
    x, y = frame.at(text.x, text.y)
    turn = -text.angle if frame.down else text.angle
    if text.face in MIRRORED_FACES and not frame.down:
        c, s = unit_vector(turn)
        x, y = x + CAPITAL * size * s, y + CAPITAL * size * c
    return Text(classes, (x, y), text.text, size, "start", turn, None, tip, line)


def _hole_tip(hole: Hole) -> str:
    depth = "" if hole.depth is None else f", {hole.depth:g} deep"
    kind = "" if hole.kind == "through" else f" {hole.kind}"
    return f"hole {hole.face} {hole.diameter:g}{kind} at x {hole.x:g}, y {hole.y:g}{depth}"


def contour_line(contour: Contour, frame: PaperFrame, style: str | None, process: str) -> Polyline:
    """A contour as a line of a style, by default that of its process."""
    points = chain_points(contour.curves, frame)
    tip = f"{contour.kind} contour {contour.face}, {process}, {len(contour.curves)} curves"
    if contour.layer is not None:
        tip += f", layer {contour.layer}, {contour.colour or 'no colour'}"
    style = style or ("open" if process == "cut" else process)
    return Polyline(f"{style} contour by-{process}", points, contour.closed, tip)


def chain_points(curves: Sequence[Curve], frame: PaperFrame) -> tuple[Point, ...]:
    """The points of a chain of curves on the paper."""
    chains = polylines(curves, max(CHORD_PIXELS / frame.scale, 1e-6))
    points: list[Point] = []
    rows = frame.all(chains.points.tolist())
    for first, last in zip(chains.begins[:-1].tolist(), chains.begins[1:].tolist(), strict=True):
        points += rows[first + (1 if points else 0) : last]
    if len(points) > 2 and hypot(points[0][0] - points[-1][0], points[0][1] - points[-1][1]) < 1e-6:
        points.pop()
        points.append(points[0])
    return tuple(points)


def cross(classes: str, at: Point, tip: str) -> Polyline:
    """A cross in one stroke."""
    (x, y) = at
    points = (x - CROSS, y), (x + CROSS, y), (x, y), (x, y - CROSS), (x, y + CROSS)
    return Polyline(f"{classes} cross", points, False, tip)


def slot_curves(slot: Slot) -> tuple[Curve, ...]:
    """The outline of a slot: corner arcs and the sides between them."""
    radius = slot.diameter / 2
    c, s = unit_vector(slot.angle)

    def place(x: float, y: float) -> Point:
        return slot.x + x * c - y * s, slot.y + x * s + y * c

    curves: list[Curve] = []
    for k, (i, j) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1))):
        centre = place(i * slot.length / 2, j * slot.height / 2)
        arc = Arc(centre, radius, slot.angle + 90.0 * k, 90.0)
        if curves and curves[-1].end != arc.start:
            curves.append(Line(curves[-1].end, arc.start))
        curves.append(arc)
    curves.append(Line(curves[-1].end, curves[0].start))
    return tuple(curves)


def section_outlines(profile: Profile) -> tuple[tuple[Point, ...], ...]:
    """The outlines of a section, z to the right and y up, without root fillets; rounds as none."""
    h, w = profile.height, profile.width
    f, t = profile.flange_thickness, profile.web_thickness or 0.0
    if not (h > 0.0 and w > 0.0 and t > 0.0):
        return ()
    a, b = (w - t) / 2, (w + t) / 2
    match profile.code:
        case "I":
            return (((0, 0), (w, 0), (w, f), (b, f), (b, h - f), (w, h - f), (w, h), (0, h),
                     (0, h - f), (a, h - f), (a, f), (0, f)),)  # fmt: skip
        case "C" if profile.lip is not None:
            g = profile.lip
            return (((0, 0), (w, 0), (w, g), (w - t, g), (w - t, f), (t, f), (t, h - f),
                     (w - t, h - f), (w - t, h - g), (w, h - g), (w, h), (0, h)),)  # fmt: skip
        case "U" | "C":
            return (((0, 0), (w, 0), (w, f), (t, f), (t, h - f), (w, h - f), (w, h), (0, h)),)
        case "L":
            return (((0, 0), (w, 0), (w, f), (t, f), (t, h), (0, h)),)
        case "T":
            low, high = (h - f) / 2, (h + f) / 2
            return (((0, 0), (t, 0), (t, low), (w, low), (w, high), (t, high), (t, h), (0, h)),)
        case "M":
            outer = ((0.0, 0.0), (w, 0.0), (w, h), (0.0, h))
            return (outer, ((t, f), (w - t, f), (w - t, h - f), (t, h - f)))
    return ()


def end_cuts(part: Part, frame: PaperFrame) -> Iterator[Polyline]:
    """The cuts of both ends, on the web."""
    c = part.cuts
    for k, (line, web, flange) in enumerate(
        zip(end_lines(part, "v"), (c.web_start, c.web_end), (c.flange_start, c.flange_end),
            strict=True)
    ):  # fmt: skip
        angles = f"web {web:g}, flange {flange:g} degrees"
        yield Polyline("cut", frame.all(line), False, f"{'end' if k else 'start'} cut, {angles}")


def cutting_planes(part: Part, frame: PaperFrame) -> Iterator[Polyline]:
    """The cutting planes, where they cross the web at the depth of their point."""
    for plane in part.features:
        if isinstance(plane, EndPlane) and plane.normal[0]:
            (px, py, _), (nx, ny, nz) = plane.point, plane.normal
            line = [(px - (y - py) * ny / nx, y) for y in (0.0, part.profile.height)]
            tip = f"cutting plane, normal {nx:g}, {ny:g}, {nz:g}"
            yield Polyline("cut", frame.all(line), False, tip)


def mitres(part: Part, face: Face) -> Iterator[FaceSize]:
    """The angles of skew end cuts as they are seen on a face, and of cutting planes on the web."""
    if face not in FACE_NAMES or part.measures is not None:
        return
    c, on_web = part.cuts, face in ("v", "h")
    angles = (c.web_start, c.web_end) if on_web else (c.flange_start, c.flange_end)
    if part.profile.code != "B":
        for (a, b), angle in zip(end_lines(part, face), angles, strict=True):
            if angle:
                middle = SizePlace(((a[0] + b[0]) / 2, (a[1] + b[1]) / 2))
                yield FaceSize(
                    (f"mitre {round(abs(angle), 2):g}\N{DEGREE SIGN}",), (middle,), False
                )
    for plane in part.features if face == "v" else ():
        if isinstance(plane, EndPlane) and plane.normal[0]:
            (px, py, _), (nx, ny, nz) = plane.point, plane.normal
            web, tilt = (round(degrees(atan2(n, abs(nx))), 2) for n in (ny, nz))
            tilted = f", tilted {abs(tilt):g}\N{DEGREE SIGN}" if tilt else ""
            words = f"plane {abs(web):g}\N{DEGREE SIGN}{tilted}"
            yield FaceSize((words,), (SizePlace((px, py)),), False)
