"""Features in words, for messages."""

from beamcam.model.part import Bend, Camber, Contour, EndPlane, Feature, Hole, Slot, TextMark


def description(feature: Feature) -> str:
    """A feature in words: what it is, its size and its place on its face."""
    match feature:
        case Hole():
            kind = "hole" if feature.kind == "through" else feature.kind
            return f"{kind} {feature.diameter:g} {_at(feature)}"
        case Slot():
            size = f"{feature.length + feature.diameter:g} x {feature.height + feature.diameter:g}"
            return f"slot {size} {_at(feature)}"
        case Contour():
            cut = feature.process == "cut"
            what = f"{feature.kind} contour" if cut else f"line to {feature.process}"
            return f"{what} of {len(feature.curves)} curve(s) on face {feature.face}"
        case TextMark():
            return f"text {feature.text!r} {_at(feature)}"
        case Bend():
            return f"bend of {feature.angle:g} degrees"
        case EndPlane():
            return "end plane"
        case Camber():
            return f"camber {_at(feature)}"


def named(feature: Feature) -> str:
    """Description of what a spindle makes, with its size: `a hole of diameter 18`."""
    match feature:
        case Hole(kind="mark"):
            return "a centre point"
        case Hole():
            kind = "" if feature.kind in ("through", "blind") else f"{feature.kind} "
            return f"a {kind}hole of diameter {feature.diameter:g}"
        case Slot():
            return f"a slot of width {feature.diameter:g}"
        case _:
            return "a line to mark"


def _at(feature: Hole | Slot | TextMark | Camber) -> str:
    return f"on face {feature.face} at x {feature.x:g}, y {feature.y:g}"
