"""Equal parts counted together."""

from collections.abc import Iterable

from msgspec.structs import replace

from beamcam.model.part import Contour, EndPlane, Hole, Part, Slot

GRAIN = 0.05  #: mm to which measures are compared


def equal_parts(parts: Iterable[Part]) -> tuple[Part, ...]:
    """The parts with those of one mark, grade and geometry as one, its quantity their sum.

    They stand in the order in which each came first.
    """
    first: dict[object, Part] = {}
    for part in parts:
        key = (part.mark, part.grade, part.drawing, geometry_key(part))
        known = first.get(key)
        first[key] = (
            part if known is None else replace(known, quantity=known.quantity + part.quantity)
        )
    return tuple(first.values())


def geometry_key(part: Part) -> tuple[object, ...]:
    """Key that parts of equal geometry share."""
    p, c = part.profile, part.cuts
    numbers = (p.height, p.width, p.flange_thickness, p.web_thickness or 0.0, part.length)
    angles = (c.web_start, c.web_end, c.flange_start, c.flange_end)
    return (
        p.code,
        tuple(_grain(v) for v in numbers),
        tuple(round(a, 2) + 0.0 for a in angles),
        tuple(sorted(repr(_feature_key(f)) for f in part.features)),
    )


def _grain(value: float) -> int:
    return round(value / GRAIN)


def _feature_key(feature: object) -> tuple[object, ...]:
    match feature:
        case Hole():
            return (
                "hole",
                feature.face,
                _grain(feature.x),
                _grain(feature.y),
                _grain(feature.diameter),
                feature.depth,
            )
        case Slot():
            values = (feature.x, feature.y, feature.diameter, feature.length, feature.height)
            return (
                "slot",
                feature.face,
                *map(_grain, values),
                round(feature.angle, 2),
                feature.depth,
            )
        case Contour():
            ends = (
                (_grain(k.start[0]), _grain(k.start[1]), _grain(k.length)) for k in feature.curves
            )
            return ("contour", feature.face, feature.kind, tuple(sorted(ends)))
        case EndPlane():
            return ("plane", *map(_grain, feature.point), *(round(n, 4) for n in feature.normal))
    return ("other", repr(feature))
