"""A part as it lies under the torch of a coper: a T on its side, a C on its lips."""

from msgspec.structs import replace

from beamcam.checks.bars.orientations import Rotation, rotated
from beamcam.model.part import Bevel, Contour, Feature, Part, Profile

#: Rotation of a T about X onto its side: Y is then what was Z, and Z what was -Y.
_ON_ITS_SIDE: Rotation = ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, -1.0, 0.0))
#: Rotation of a C about X onto its lips, and back.
_ON_ITS_LIPS: Rotation = ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0))


def lying(part: Part) -> Part:
    """A part as it lies under the torch; what a T has on the far sides of its plates on u and v,
    what a C has on its web on v."""
    rotation = {"T": _ON_ITS_SIDE, "C": _ON_ITS_LIPS}.get(part.profile.code)
    if rotation is None:
        return part
    turned = rotated(part, rotation)
    begun = rotated(replace(part, features=part.made or ()), rotation)
    features, made = (
        tuple(_seen(f, part.profile) for f in one.features) for one in (turned, begun)
    )
    return replace(turned, features=features, made=None if part.made is None else made)


def as_drawn(part: Part) -> Part:
    """A part that lies under the torch in the axes of its section; of a T on faces h and u, of a C
    with what its web has on v."""
    if part.profile.code == "C":
        drawn = rotated(part, _ON_ITS_LIPS)
        return replace(drawn, features=tuple(_seen(f, part.profile) for f in drawn.features))
    if part.profile.code != "T":
        return part
    back: Rotation = ((1.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.0, 1.0, 0.0))
    return rotated(part, back)


def _seen(feature: Feature, profile: Profile) -> Feature:
    """A feature of a T on its side, or of the web of a C, on the face that the torch looks at."""
    thick = {"h": profile.web_thickness or 0.0}
    if profile.code == "T":
        thick["o"] = profile.flange_thickness
    if (face := getattr(feature, "face", "")) not in thick:  # the inside of the flange, or below
        return feature
    if isinstance(feature, Contour) and profile.code == "C":
        curves = tuple(curve.reversed() for curve in reversed(feature.curves))
        feature = replace(feature, curves=curves)
    elif isinstance(feature, Contour):
        bevels = tuple(other_side(one, thick[face]) for one in feature.bevels)
        feature = replace(feature, bevels=bevels)
    return replace(feature, face="u" if face == "o" else "v")


def other_side(bevel: Bevel, thickness: float) -> Bevel:
    """A bevel as it is seen from the other side of its wall; its land counts from the far side."""
    land = thickness if bevel.angle < 0.0 and not bevel.land else bevel.land
    return replace(bevel, angle=-bevel.angle, land=thickness - land)
