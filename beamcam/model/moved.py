"""Features of a plate at another place."""

from msgspec.structs import replace

from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.geometry.plane import Point
from beamcam.model.part import Contour, Feature, Hole, Slot, TextMark


def moved_feature(feature: Feature, by: Point) -> Feature:
    """The feature moved in the plane of its plate; values across the plate stay."""
    if isinstance(feature, Contour):
        return replace(feature, curves=tuple([moved_curve(curve, by) for curve in feature.curves]))
    if isinstance(feature, Hole | Slot | TextMark):
        return replace(feature, x=feature.x + by[0], y=feature.y + by[1])
    return feature


def moved_curve(curve: Curve, by: Point) -> Curve:
    """The curve moved; of lines and arcs no angle is rounded."""
    dx, dy = by
    if isinstance(curve, Line):
        (x0, y0), (x1, y1) = curve.start, curve.end
        return Line((x0 + dx, y0 + dy), (x1 + dx, y1 + dy))
    if isinstance(curve, Arc):
        x, y = curve.centre
        return Arc((x + dx, y + dy), curve.radius, curve.start_deg, curve.sweep_deg)
    return curve.transformed(((1.0, 0.0, dx), (0.0, 1.0, dy)))
