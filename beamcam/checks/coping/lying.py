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
    if part.profile.code == "C":
        on_lips = rotated(part, _ON_ITS_LIPS)
        on_lips = replace(on_lips, features=_over_web(on_lips))
        if part.made is None:
            return on_lips
        begun = rotated(replace(part, features=part.made), _ON_ITS_LIPS)
        return replace(on_lips, made=_over_web(begun))
    if part.profile.code != "T":
        return part
    turned = rotated(part, _ON_ITS_SIDE)
    made = part.made
    if made is not None:
        there = rotated(replace(part, features=made), _ON_ITS_SIDE).features
        made = tuple(_seen(one, part.profile) for one in there)
    features = tuple(_seen(one, part.profile) for one in turned.features)
    return replace(turned, features=features, made=made)


def as_drawn(part: Part) -> Part:
    """A part that lies under the torch in the axes of its section; of a T on faces h and u, of a C
    with what its web has on v."""
    if part.profile.code == "C":
        drawn = rotated(part, _ON_ITS_LIPS)
        return replace(drawn, features=_over_web(drawn))
    if part.profile.code != "T":
        return part
    back: Rotation = ((1.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.0, 1.0, 0.0))
    return rotated(part, back)


def _over_web(part: Part) -> tuple[Feature, ...]:
    """The features of a part, those of its web on v."""
    return tuple(map(_from_front, part.features))


def _from_front(feature: Feature) -> Feature:
    """A feature of a web that is seen from behind, on v in the same place."""
    if getattr(feature, "face", "") != "h":
        return feature
    if isinstance(feature, Contour):
        curves = tuple(curve.reversed() for curve in reversed(feature.curves))
        return replace(feature, face="v", curves=curves)
    return replace(feature, face="v")


def _seen(feature: Feature, tee: Profile) -> Feature:
    """A feature of a T on its side, on the face of its plate that the torch looks at."""
    thick = {"o": tee.flange_thickness, "h": tee.web_thickness or 0.0}
    if (face := getattr(feature, "face", "")) not in thick:  # the inside of the flange, or below
        return feature
    if isinstance(feature, Contour):
        bevels = tuple(other_side(one, thick[face]) for one in feature.bevels)
        feature = replace(feature, bevels=bevels)
    return replace(feature, face="u" if face == "o" else "v")


def other_side(bevel: Bevel, thickness: float) -> Bevel:
    """A bevel as it is seen from the other side of its wall; its land counts from the far side."""
    land = thickness if bevel.angle < 0.0 and not bevel.land else bevel.land
    return replace(bevel, angle=-bevel.angle, land=thickness - land)
