"""What the strokes leave of each wall: pieces of the part, scrap, scrap that holds to the part."""

from collections.abc import Iterator, Sequence
from typing import Any

from msgspec import Struct
from shapely import (
    LineString,
    MultiPolygon,
    force_2d,
    get_coordinates,
    prepare,
    transform,
    union_all,
)

from beamcam.checks.coping import rules
from beamcam.checks.coping.section import CoperSection, TubeSection, line_of, pieces_of
from beamcam.errors import Diagnostic, Source

Shape = Any  #: of shapely
SPECK = 0.05  #: mm2 that is nothing


class WallPieces(Struct, frozen=True):
    """What is left of a wall: the pieces of the part, and the others."""

    part: Shape
    scrap: Shape


def parted(bar: Shape, gone: Sequence[Shape], drawn: Shape, slack: float) -> WallPieces:
    """The pieces of a surface that is cut; those of the part have steel well within it."""
    pieces = [p for p in pieces_of(bar.difference(union_all(gone))) if p.area > SPECK]
    core = drawn.intersection(bar).buffer(-2 * slack, join_style="mitre")
    prepare(core)  # whose border most pieces lie off
    mine = [p for p in pieces if core.intersects(p) and core.intersection(p).area > SPECK]
    others = [p for p in pieces if not any(p is one for one in mine)]
    return WallPieces(MultiPolygon(mine), MultiPolygon(others))


def kept_faults(
    face: str, left: WallPieces, required: Shape, slack: float, name: str,
    tube: TubeSection | None = None,
) -> Iterator[Diagnostic]:  # fmt: skip
    """Scrap that holds to the part, on a face or on the whole surface of a tube."""
    if left.part.is_empty:
        yield rules.GONE.at(Source(name), face=face)
        return
    around = required.buffer(slack, join_style="mitre")
    if around.covers(left.part):
        return
    for piece in pieces_of(left.part.difference(around)):
        if piece.area > SPECK:
            far = max(required.distance(line_of([p])) for p in outline_of(piece))
            x, y = piece.representative_point().coords[0]
            yield rules.LEFT.at(
                Source(name), found=f"{far:.2f}", face=tube.face_at(y) if tube else face,
                x=f"{x:.1f}", y=f"{y:.1f}",
            )  # fmt: skip
            return


def hurt_fault(
    hurt: Shape, kept: Shape, slack: float, source: Source, face: str | TubeSection
) -> Diagnostic:
    """That a stroke takes of what is kept, at one place and as deep as anywhere."""
    x, y = hurt.representative_point().coords[0]
    deep = slack + max(kept.boundary.distance(line_of([p])) for p in outline_of(hurt))
    return rules.HURT.at(
        source, found=f"{deep:.2f}", face=face if isinstance(face, str) else face.face_at(y),
        x=f"{x:.1f}", y=f"{y:.1f}", expected=f"{slack:.2f}",
    )  # fmt: skip


def holding_faults(
    face: str,
    web: WallPieces,
    flange: WallPieces,
    section: CoperSection,
    z: float,
    slack: float,
    name: str,
) -> Iterator[Diagnostic]:
    """Scrap of the web that a flange holds at a surface z of it, or the other way round."""
    y = section.web_ends[1] - 1e-3 if face == "o" else section.web_ends[0] + 1e-3
    along = LineString([(-1e6, y), (1e6, y)])
    beside = LineString([(-1e6, z), (1e6, z)])

    def flat(shape: Shape) -> Shape:
        """Stretches along x, whatever their y."""

        def to_axis(points: Any) -> Any:
            points = points.copy()
            points[:, 1] = 0.0
            return points

        return transform(force_2d(shape), to_axis)

    for scrap, other, names in (
        (web.scrap, flange.part, ("v", face)), (flange.scrap, web.part, (face, "v"))
    ):  # fmt: skip
        lines = (along, beside) if names[0] == "v" else (beside, along)
        held = flat(scrap.intersection(lines[0])).intersection(flat(other.intersection(lines[1])))
        if held.length > 2 * slack:
            yield rules.HOLDS.at(
                Source(name), scrap=names[0], face=names[1], found=f"{held.length:.2f}",
                x=f"{held.bounds[0]:.1f}",
            )  # fmt: skip


def outline_of(shape: Shape) -> list[tuple[float, float]]:
    return [tuple(p) for p in get_coordinates(shape).tolist()]
