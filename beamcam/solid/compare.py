"""A piece as a solid beside its part: what is missing, what is left, how long it is, which hand.

The part stands twice: with every void as large as it may be (`least` steel) and as small (`most`).
Of a sound piece nothing lies outside the one, and nothing of the other is missing:

    least steel  <=  piece  <=  most steel

A piece may lie turned; eight turns keep a bar along its axis, and eight more make its mirror image,
which is another part. The piece is moved into the part's own axes, so that places are the part's.
"""

from collections.abc import Iterable, Iterator, Sequence
from itertools import product
from math import atan2, inf, pi
from typing import TYPE_CHECKING

from msgspec import Struct
from shapely.affinity import affine_transform

from beamcam.errors import Diagnostic, Source
from beamcam.model.part import Contour, EndPlane, Feature, Hole, Part, Slot
from beamcam.solid import EXTRA, HAND, LEFT_OUT, MISSING, SIZE
from beamcam.solid.kernel import Frame, kernel, minus, outline, walls
from beamcam.solid.part_solid import part_solid, voids
from beamcam.solid.stock_solid import AS_DRAWN, Margins, stock_solid

if TYPE_CHECKING:
    from manifold3d import Manifold

NOISE = 0.5  #: mm3; what the kernel's rounding leaves of faces that coincide is far below
UNTOUCHED = 0.01  #: of what a feature takes; of one that was left out no more is gone
SAME_SECTION = 1e-3  #: of its area, that a section may differ from itself turned, by its chords
ALIKE = 1.0  #: mm of length or outline by which pieces may differ that are tried for one part
SHORTEST = 1e-6  #: mm of length that rounding may leave

#: Kinds of `--allow-skips` that may leave out a feature.
_OF_HOLES = ("tool", "countersink", "sink-depth", "thread-depth", "face", "reach", "stroke", "axis",
             "off-face", "other")  # fmt: skip
KINDS: dict[type, tuple[str, ...]] = {
    Hole: _OF_HOLES,
    Slot: ("slot", *_OF_HOLES),
    Contour: ("cope", "cutout", "bevel", "other"),
    EndPlane: ("other", "axis"),
}
KIND_NAMES = {Hole: "hole", Slot: "slot", Contour: "contour", EndPlane: "end plane"}


class Bodies(Struct, frozen=True):
    """A part's solids, and the margins between them."""

    part: Part
    drawn: "Manifold"
    least: "Manifold"
    most: "Manifold"
    largest: Margins  #: of the voids of `least`
    smallest: Margins  #: of those of `most`
    end: float  #: that its length may differ by
    tolerance: float  #: of places, for messages


def bodies_of(part: Part, largest: Margins, smallest: Margins, end: float, place: float) -> Bodies:
    """A part with its voids as drawn, as large as they may be, and as small."""
    drawn, least, most = (part_solid(part, margins) for margins in (AS_DRAWN, largest, smallest))
    return Bodies(part, drawn, least, most, largest, smallest, end, place)


class FittedPiece(Struct, frozen=True):
    """A piece laid on its part, and the lumps that differ beyond the margins."""

    laid: "Manifold"
    missing: "list[Manifold]"
    extra: "list[Manifold]"

    @property
    def differs(self) -> float:
        """mm3."""
        return float(sum(lump.volume() for lump in (*self.missing, *self.extra)))


def lumps(body: "Manifold") -> "list[Manifold]":
    """The separate pieces of a body that are no noise, largest first."""
    if body.volume() < NOISE:
        return []
    sized = [(float(one.volume()), k, one) for k, one in enumerate(body.decompose())]
    return [one for volume, _, one in sorted(sized, reverse=True) if volume >= NOISE]


def fit_of(laid: "Manifold", bodies: Bodies) -> FittedPiece:
    """A piece in the part's own axes beside the part."""
    return FittedPiece(laid, lumps(bodies.least - laid), lumps(laid - bodies.most))


def turns_of_bar(mirrored: bool) -> Iterator[Frame]:
    """Maps that keep a bar along its axis: eight turns, or eight that mirror it."""
    for swap, x, y, z in product((False, True), (1.0, -1.0), (1.0, -1.0), (1.0, -1.0)):
        if (x * y * z * (-1.0 if swap else 1.0) < 0) == mirrored:
            rows = ((0.0, y, 0.0, 0.0), (0.0, 0.0, z, 0.0))
            if swap:
                rows = ((0.0, 0.0, y, 0.0), (0.0, z, 0.0, 0.0))
            yield (x, 0.0, 0.0, 0.0), rows[0], rows[1]


def ways_to_lie(
    piece: "Manifold", lying: Part, bodies: Bodies, mirrored: bool
) -> "Iterator[Manifold]":
    """The ways in which a piece of a bar may be laid on its part, as it lies first.

    Across it lies where the bar's section does, along it begins or ends where the part does. A turn
    that lays the section on another one is none.
    """
    size, own = lying.profile, bodies.part.profile
    bar, section = outline(lying), outline(bodies.part)
    low, high = bodies.drawn.bounding_box()[0], bodies.drawn.bounding_box()[3]
    for frame in turns_of_bar(mirrored):
        (_, a, b, _), (_, c, d, _) = frame[1:]
        shift = [
            half - p * size.height / 2 - q * size.width / 2
            for half, p, q in ((own.height / 2, a, b), (own.width / 2, c, d))
        ]
        turned = affine_transform(bar, [a, b, c, d, *shift])
        if turned.symmetric_difference(section).area > SAME_SECTION * section.area:
            continue
        rows = [(*row[:3], at) for row, at in zip(frame, (0.0, *shift), strict=True)]
        one = piece.transform(rows)
        box = one.bounding_box()
        yield one.translate((low - box[0], 0.0, 0.0))
        if abs((box[3] - box[0]) - (high - low)) > SHORTEST:
            yield one.translate((high - box[3], 0.0, 0.0))


def best_fit(ways: "Iterable[Manifold]", bodies: Bodies) -> FittedPiece | None:
    """The way to lie that differs least, the first that does not; None without any."""
    best: FittedPiece | None = None
    for laid in ways:
        one = fit_of(laid, bodies)
        if best is None or one.differs < best.differs:
            best = one
        if not best.differs:
            break
    return best


def differences(
    best: FittedPiece, mirror: "Iterable[Manifold]", bodies: Bodies, name: str, source: Source
) -> Iterator[Diagnostic]:
    """What is wrong with a piece by its best fit; nothing of a sound one.

    `mirror` are the ways in which its mirror image may lie.
    """
    if not best.differs:
        return
    mark = bodies.part.mark or "the part"
    image = best_fit(mirror, bodies)
    if image is not None and image.differs < best.differs / 2:
        yield HAND.at(
            source, piece=name, mark=mark, found=f"{image.differs:.0f}",
            other=f"{best.differs:.0f}",
        )  # fmt: skip
        return
    found, expected = _length(best.laid), _length(bodies.drawn)
    if abs(found - expected) > bodies.end:
        yield SIZE.at(
            source, piece=name, mark=mark, found=f"{found:.3f}", expected=f"{expected:.3f}"
        )
    for rule, many in ((MISSING, best.missing), (EXTRA, best.extra)):
        if many:
            yield rule.at(
                source, piece=name, mark=mark, found=f"{sum(o.volume() for o in many):.1f}",
                lumps=f"{len(many)} lump(s)", largest=f"{many[0].volume():.1f}",
                where=where(many[0], bodies), tolerance=f"{bodies.tolerance:.3g}",
            )  # fmt: skip


def _length(body: "Manifold") -> float:
    box = body.bounding_box()
    return float(box[3] - box[0])


def without_left_out(
    fit: FittedPiece, bodies: Bodies, name: str, skips: Sequence[str]
) -> tuple[FittedPiece, list[Diagnostic]]:
    """The fit without the steel of features that may be left out, and what is said of them."""
    allowed = {
        kind for kind, names in KINDS.items() if "all" in skips or not {*names}.isdisjoint(skips)
    }
    if not fit.extra or not allowed:
        return fit, []
    largest = _by_feature(bodies.part, bodies.largest)
    smallest = _by_feature(bodies.part, bodies.smallest)
    diagnostics: list[Diagnostic] = []
    extra = fit.extra
    x0, y0, z0, x1, y1, z1 = fit.laid.bounding_box()
    within = kernel().Manifold.cube((x1 - x0, y1 - y0, z1 - z0)).translate((x0, y0, z0))
    stock = stock_solid(bodies.part) ^ within  # a sound end may be off by the width of a hair
    for at, (feature, taken) in largest.items():
        if type(feature) not in allowed or not any(
            (one ^ taken).volume() >= NOISE for one in extra
        ):
            continue
        others = [body for other, (_, body) in largest.items() if other != at]
        own = minus(smallest[at][1] ^ stock, others)
        partly = (own - fit.laid).volume() > UNTOUCHED * own.volume() + NOISE
        is_sink = isinstance(feature, Hole) and feature.kind == "countersink"
        if partly and not (is_sink and "sink-depth" in skips):
            continue
        before = sum(one.volume() for one in extra)
        extra = [lump for one in extra for lump in lumps(one - taken)]
        volume = before - sum(one.volume() for one in extra)
        diagnostics.append(left_out(feature, volume, name))
    return FittedPiece(fit.laid, fit.missing, extra), diagnostics


def _by_feature(part: Part, margins: Margins) -> "dict[int, tuple[Feature, Manifold]]":
    """What each feature takes in all, by its number."""
    bodies: dict[int, tuple[Feature, Manifold]] = {}
    numbers = {id(feature): k for k, feature in enumerate(part.features)}
    for feature, body in voids(part, margins):
        at = numbers[id(feature)]
        bodies[at] = feature, (bodies[at][1] + body if at in bodies else body)
    return bodies


def left_out(feature: Feature, volume: float, name: str) -> Diagnostic:
    """The note on the steel of a feature that may be left out."""
    kind = next(name for kind, name in KIND_NAMES.items() if isinstance(feature, kind))
    face = getattr(feature, "face", "")
    where = f"of a {kind}" + (f" on face {face}" if face else "")
    return LEFT_OUT.at(
        feature.source, piece=name, found=f"{volume:.1f}", where=where, what=kind + "s"
    )


def where(lump: "Manifold", bodies: Bodies) -> str:
    """The place of a lump on the part: its face, x and y, by the middle of its box."""
    box = lump.bounding_box()
    x, y, z = ((box[k] + box[k + 3]) / 2 for k in range(3))
    whole = bodies.drawn.bounding_box()
    if box[0] <= whole[0] + SHORTEST and box[3] - box[0] < (whole[3] - whole[0]) / 2:
        end = " at the start"
    elif box[3] >= whole[3] - SHORTEST and box[3] - box[0] < (whole[3] - whole[0]) / 2:
        end = " at the end"
    else:
        end = ""
    face, off = "v", inf
    sides = walls(bodies.part.profile)
    for name in (face for face in ("v", "u", "o", "h") if face in sides):
        wall = sides[name]
        deep = wall.inward * ((y if wall.normal == "y" else z) - wall.surface)
        away = abs(deep - wall.thickness / 4)
        if away < off:
            face, off = name, away
    q = z if face in ("o", "u") else y
    if bodies.part.profile.is_round:  # the arc from the lowest line towards v
        radius = bodies.part.profile.height / 2
        q = atan2(z - radius, radius - y) % (2 * pi) * radius
    return f"on face {face} at x {x:.1f}, y {q:.1f}{end}"


def likely(pieces: "Sequence[Manifold]", bodies: Bodies) -> list[tuple[float, int]]:
    """The pieces that may be a part, by how little they differ in length and volume.

    What differs in volume counts as the length of bar that it would be, in mm.
    """
    length, volume = _length(bodies.drawn), bodies.drawn.volume()
    per = volume / length if length > 0 else 1.0
    return sorted(
        (round(abs(_length(p) - length) + abs(p.volume() - volume) / per, 2), k)
        for k, p in enumerate(pieces)
    )
