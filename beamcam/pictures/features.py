"""Shapes of a part's features, and of the section that it is made of."""

from collections.abc import Iterator, Sequence
from math import hypot

from beamcam.geometry.curves import Arc, Curve, Line, unit_vector
from beamcam.geometry.polylines import polylines
from beamcam.model.part import (
    MIRRORED_FACES,
    Bend,
    Camber,
    Contour,
    Feature,
    Hole,
    Profile,
    Slot,
    TextMark,
)  # fmt: skip
from beamcam.pictures.scene import CAPITAL, Circle, Frame, Point, Polyline, Shape, Text
from beamcam.verify.bars.machined_features import StampedText

CHORD_PIXELS = 0.02  #: of the chords that stand for curves
CROSS = 5.0  #: half of the cross of a mark, pixels
MIN_RADIUS = 0.8  #: of a circle that can be seen, pixels


def feature_shapes(feature: Feature, frame: Frame) -> Iterator[Shape]:
    """The shapes of a feature; the first one has the feature's own class."""
    match feature:
        case Hole() if feature.kind == "mark" or feature.diameter == 0.0:
            yield from cross("mark", frame.at(feature.x, feature.y), _hole_tip(feature))
        case Hole():
            yield from _hole(feature, frame)
        case Slot():
            points = chain_points(slot_curves(feature), frame)
            size = f"{feature.length + feature.diameter:g} x {feature.height + feature.diameter:g}"
            tip = f"slot {feature.face} {size} at x {feature.x:g}, y {feature.y:g}"
            yield Polyline("slot", points, True, tip)
        case Contour():
            yield _contour(feature, frame)
        case TextMark():
            tip = f"text {feature.face} at x {feature.x:g}, y {feature.y:g}"
            yield lettering("text", feature, frame, tip)
        case Bend():
            tip = f"bend of {feature.angle:g} degrees"
            yield Polyline("bend", frame.all((feature.start, feature.end)), False, tip)
        case Camber():
            yield from cross("bend", frame.at(feature.x, feature.y), "camber")


def lettering(
    classes: str, told: TextMark | StampedText, frame: Frame, tip: str = "", line: int = 0
) -> Text:
    """A text where it stands on its face, to be read.

    On h, which is drawn through the web, it would stand as mirror writing below its base line; it
    fills the same place there and runs the same way.
    """
    size = max(told.height * frame.scale * 1.35, 5.0)
    x, y = frame.at(told.x, told.y)
    turn = -told.angle if frame.down else told.angle
    if told.face in MIRRORED_FACES and not frame.down:
        c, s = unit_vector(turn)
        x, y = x + CAPITAL * size * s, y + CAPITAL * size * c
    return Text(classes, (x, y), told.text, size, "start", turn, None, tip, line)


def _hole(hole: Hole, frame: Frame) -> Iterator[Circle]:
    at = frame.at(hole.x, hole.y)
    radius = max(hole.diameter / 2 * frame.scale, MIN_RADIUS)
    yield Circle("hole", at, radius, _hole_tip(hole))
    if hole.kind in ("thread", "left-thread"):
        yield Circle("thread", at, radius * 0.8)
    elif hole.kind == "countersink":
        yield Circle("thread", at, radius * 0.6)


def _hole_tip(hole: Hole) -> str:
    depth = "" if hole.depth is None else f", {hole.depth:g} deep"
    kind = "" if hole.kind == "through" else f" {hole.kind}"
    return f"hole {hole.face} {hole.diameter:g}{kind} at x {hole.x:g}, y {hole.y:g}{depth}"


def _contour(contour: Contour, frame: Frame) -> Polyline:
    """A contour: filled where it encloses steel or a cut-out, else a line of its process."""
    closed = contour.closed and contour.process == "cut" and contour.kind != "open"
    return contour_line(contour, frame, contour.kind if closed else None, contour.process)


def contour_line(contour: Contour, frame: Frame, style: str | None, process: str) -> Polyline:
    """A contour as a line of a style, by default that of its process."""
    points = chain_points(contour.curves, frame)
    tip = f"{contour.kind} contour {contour.face}, {process}, {len(contour.curves)} curves"
    if contour.layer is not None:
        tip += f", layer {contour.layer}, {contour.colour or 'no colour'}"
    style = style or ("open" if process == "cut" else process)
    return Polyline(f"{style} contour by-{process}", points, contour.closed, tip)


def chain_points(curves: Sequence[Curve], frame: Frame) -> tuple[Point, ...]:
    """The points of a chain of curves on the paper."""
    found = polylines(curves, max(CHORD_PIXELS / frame.scale, 1e-6))
    points: list[Point] = []
    rows = frame.all(found.points.tolist())
    for first, last in zip(found.begins[:-1].tolist(), found.begins[1:].tolist(), strict=True):
        points += rows[first + (1 if points else 0) : last]
    if len(points) > 2 and hypot(points[0][0] - points[-1][0], points[0][1] - points[-1][1]) < 1e-6:
        points.pop()
        points.append(points[0])
    return tuple(points)


def cross(classes: str, at: Point, tip: str, line: int = 0) -> Iterator[Polyline]:
    """A cross; its second stroke is of no class but the style's."""
    (x, y) = at
    yield Polyline(f"{classes} cross", ((x - CROSS, y), (x + CROSS, y), (x, y), (x, y - CROSS),
                                        (x, y + CROSS)), False, tip, line)  # fmt: skip


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
