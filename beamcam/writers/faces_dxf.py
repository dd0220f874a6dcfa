"""The writer of a part as a DXF drawing: each face on layers of its own, one above the other.

    BEHIND   h   |  views are stacked along y with a gap between them, named above each
    TOP      o   |
    FRONT    v   |  lengths run to the right on all of them
    BOTTOM   u   |

Views lie as the faces unfold (`model.description`): o has its y = 0 at the top, h is drawn through
the web; the name of a view says so. For looking at and for measuring; ezdxf is imported when it is
needed.
"""

from __future__ import annotations

import io
from math import hypot, radians
from threading import Lock
from typing import TYPE_CHECKING, Any

from msgspec.structs import replace

from beamcam.geometry.curves import (
    Arc,
    Bezier,
    Box,
    BSpline,
    Curve,
    EllipseArc,
    Line,
    NewtonCurve,
    bezier_pieces,
    join_boxes,
    unit_vector,
)
from beamcam.model.description import THROUGH, end_lines, face_title, runs_down
from beamcam.model.part import Bend, Camber, Contour, Face, Feature, Hole, Part, Slot, TextMark

if TYPE_CHECKING:
    from ezdxf.layouts.layout import Modelspace

FACE_NAMES = {"h": "BEHIND", "o": "TOP", "v": "FRONT", "u": "BOTTOM"}
GAP = 50.0  #: between the views
#: AutoCAD colour index of a face's layers, by what stands behind its name
_COLOURS = {"": 7, "_HOLES": 1, "_MARKS": 3, "_TEXT": 5, "_LABEL": 8}
_ONE_AT_A_TIME = Lock()  #: the options of ezdxf are those of the process
_MARK_ARM = 5.0  #: half of the cross that shows a punch mark
_LABEL_HEIGHT = 20.0


def write(part: Part) -> str:
    """The faces of `part` as DXF text (R2010, mm): layers FACE_v, FACE_v_HOLES and the like.

    A face is drawn when a feature lies on it; v always is, by its outline or between the ends that
    the header cuts, at the surface of the face. Bends and points of the camber lie on v. Cutting
    planes have no face, so they are named in the label only.
    """
    from ezdxf._options import options

    # ezdxf stamps the time and random identities, which would differ from run to run
    with _ONE_AT_A_TIME:
        stamps = options.write_fixed_meta_data_for_testing
        options.write_fixed_meta_data_for_testing = True
        try:
            return _drawing(part)
        finally:
            options.write_fixed_meta_data_for_testing = stamps


def _drawing(part: Part) -> str:
    from ezdxf import units
    from ezdxf.filemanagement import new

    document = new("R2010")
    document.units = units.MM
    space = document.modelspace()
    shift = 0.0
    used = {_face_of(feature) for feature in part.features} | {"v"}
    planes = [plane.name for plane in part.planes if plane.name in used]
    for face in (*(face for face in ("u", "v", "o", "h") if face in used), *planes):
        features = [f for f in part.features if _face_of(f) == face]
        if runs_down(face):
            features = [_upside_down(f) for f in features]
        layer = "FACE_" + face.replace("#", "-")
        for suffix, colour in _COLOURS.items():
            document.layers.add(layer + suffix, color=colour)
        box = _box(part, face, features)
        view = _View(space, layer, shift - box[1])
        (low, high), sign = _edges(part, face), -1.0 if runs_down(face) else 1.0
        has_outline = any(isinstance(f, Contour) and f.kind == "outer" for f in features)
        if high > low and not has_outline:  # between the ends that the header cuts
            (a, d), (b, c) = end_lines(part, face)
            corners = [(x, sign * y) for x, y in (a, b, c, d)]
            for a, b in zip(corners, corners[1:] + corners[:1], strict=True):
                view.line(a, b)
        for feature in features:
            _draw(feature, view)
        name = f"{face} {FACE_NAMES.get(face, 'PLANE')}  {part.mark}  {part.profile.name}"
        cuts = sum(1 for f in part.features if _face_of(f) is None) if face == "v" else 0
        note = f"  {cuts} cutting planes not drawn" if cuts else ""
        view.label(f"{name}  {face_title(face, part.profile.code)}{note}", box)
        shift += box[3] - box[1] + GAP
    stream = io.StringIO()
    document.write(stream)
    return stream.getvalue()


def _upside_down(feature: Feature) -> Feature:
    """A feature as it lies on a view whose y runs down: with y and angles of the other sign."""
    match feature:
        case Hole() | Camber():
            return replace(feature, y=-feature.y)
        case Slot() | TextMark():
            return replace(feature, y=-feature.y, angle=-feature.angle)
        case Contour():
            down = ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0))
            return replace(feature, curves=tuple(c.transformed(down) for c in feature.curves))
    return feature


def _face_of(feature: Feature) -> Face | None:
    """The face that a feature is drawn on; None of a cutting plane."""
    return "v" if isinstance(feature, Bend) else getattr(feature, "face", None)


def _box(part: Part, face: Face, features: list[Feature]) -> Box:
    """The box around a view."""
    low, high = _edges(part, face)
    boxes: list[Box] = [(0.0, low, part.length, high)] if high > low else []
    for feature in features:
        match feature:
            case Contour():
                boxes += [curve.bbox for curve in feature.curves]
            case Hole() | Slot() | TextMark() | Camber():
                boxes.append((feature.x, feature.y, feature.x, feature.y))
            case Bend():
                boxes += [(*feature.start, *feature.start), (*feature.end, *feature.end)]
    return join_boxes(boxes) or (0.0, 0.0, part.length, 0.0)


def _edges(part: Part, face: Face) -> tuple[float, float]:
    """The lower and the upper edge of a face on its view."""
    width = part.profile.face_width(face) if face in FACE_NAMES else 0.0
    return (-width, 0.0) if runs_down(face) else (0.0, width)


class _View:
    """Draws on the layers of one face, shifted up by `shift`."""

    def __init__(self, space: Modelspace, layer: str, shift: float) -> None:
        self.space = space
        self.layer = layer
        self.shift = shift

    def at(self, point: tuple[float, float]) -> tuple[float, float]:
        return point[0], point[1] + self.shift

    def on(self, suffix: str) -> dict[str, Any]:
        return {"layer": self.layer + suffix}

    def label(self, text: str, box: Box) -> None:
        place = self.at((box[0], box[3] + GAP / 4 - _LABEL_HEIGHT / 4))
        entity = self.space.add_text(text, height=_LABEL_HEIGHT / 2, dxfattribs=self.on("_LABEL"))
        entity.set_placement(place)

    def line(self, a: tuple[float, float], b: tuple[float, float], suffix: str = "") -> None:
        self.space.add_line(self.at(a), self.at(b), dxfattribs=self.on(suffix))

    def cross(self, x: float, y: float) -> None:
        self.line((x - _MARK_ARM, y), (x + _MARK_ARM, y), "_MARKS")
        self.line((x, y - _MARK_ARM), (x, y + _MARK_ARM), "_MARKS")


def _draw(feature: Feature, view: _View) -> None:
    match feature:
        case Hole() if feature.kind == "mark" or feature.diameter == 0:
            view.cross(feature.x, feature.y)
        case Hole():
            centre = view.at((feature.x, feature.y))
            view.space.add_circle(centre, feature.diameter / 2, dxfattribs=view.on("_HOLES"))
        case Slot():
            _draw_slot(feature, view)
        case Contour():
            suffix = "" if feature.process == "cut" else "_MARKS"
            for curve in feature.curves:
                _draw_curve(curve, view, suffix)
        case TextMark():
            from ezdxf.enums import TextEntityAlignment

            height, on = feature.height or 1.0, view.on("_TEXT")
            entity = view.space.add_text(
                feature.text, height=height, rotation=feature.angle, dxfattribs=on
            )
            # Through the web a text would be mirror writing below its base line.
            align = TextEntityAlignment["TOP_LEFT" if feature.face == THROUGH else "LEFT"]
            entity.set_placement(view.at((feature.x, feature.y)), align=align)
        case Bend():
            view.line(feature.start, feature.end, "_MARKS")
        case Camber():
            view.cross(feature.x, feature.y)


def _draw_slot(slot: Slot, view: _View) -> None:
    """Straight sides and corner arcs; of no straight side where length or height is 0."""
    radius = slot.diameter / 2
    half = slot.length / 2, slot.height / 2
    (c, s) = unit_vector(slot.angle)

    def place(x: float, y: float) -> tuple[float, float]:
        return slot.x + x * c - y * s, slot.y + x * s + y * c

    corners = ((1, 1), (-1, 1), (-1, -1), (1, -1))
    for k, (i, j) in enumerate(corners):
        x, y = i * half[0], j * half[1]
        turn = slot.angle + 90.0 * k
        if radius:
            _draw_curve(Arc(place(x, y), radius, turn, 90.0), view, "_HOLES")
        # the side from the end of this corner to the start of the next one
        i_next, j_next = corners[(k + 1) % 4]
        out_x, out_y = ((0, radius), (-radius, 0), (0, -radius), (radius, 0))[k]
        a = place(x + out_x, y + out_y)
        b = place(i_next * half[0] + out_x, j_next * half[1] + out_y)
        if hypot(a[0] - b[0], a[1] - b[1]) > 1e-9:
            view.line(a, b, "_HOLES")


def _draw_curve(curve: Curve, view: _View, suffix: str) -> None:
    """A curve as the entity that is exactly it; a Newton polynomial as its Bezier curve."""
    attributes = view.on(suffix)
    match curve:
        case Line():
            view.line(curve.start, curve.end, suffix)
        case Arc() if abs(curve.sweep_deg) >= 360.0:
            view.space.add_circle(view.at(curve.centre), curve.radius, dxfattribs=attributes)
        case Arc():
            start, end = sorted((curve.start_deg, curve.start_deg + curve.sweep_deg))
            centre = view.at(curve.centre)
            view.space.add_arc(centre, curve.radius, start, end, dxfattribs=attributes)
        case EllipseArc():
            start, end = sorted((curve.start_deg, curve.start_deg + curve.sweep_deg))
            centre, span = view.at(curve.centre), (radians(start), radians(end))
            view.space.add_ellipse(centre, curve.axis, curve.ratio, *span, dxfattribs=attributes)
        case BSpline():
            _draw_spline(curve, view, attributes)
        case Bezier() | NewtonCurve():
            for piece in bezier_pieces(curve):
                degree = piece.degree
                knots = (0.0,) * (degree + 1) + (1.0,) * (degree + 1)
                _draw_spline(BSpline(degree, piece.points, knots, piece.weights), view, attributes)


def _draw_spline(curve: BSpline, view: _View, attributes: dict[str, Any]) -> None:
    control = [view.at(point) for point in curve.control]
    spline = view.space.add_spline(dxfattribs=attributes)
    spline.dxf.degree = curve.degree
    spline.control_points = [(x, y, 0.0) for x, y in control]
    spline.knots = list(curve.knots)
    if curve.weights is not None:
        spline.weights = list(curve.weights)
