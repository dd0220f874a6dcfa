"""The roots of a web: where a cut over it meets one through a flange, at one x or in one plane.

   x: a cut of the flange, and below it one of the web; the root between them goes with the
___|___   flange. What is cut of the root otherwise (along it, or of one wall alone) cannot be
   |      made: the flange would be hurt, or the scrap would hold.

At a skew end both lie in its plane, in which a pass from outside of the flange goes on.
"""

from collections.abc import Iterator, Mapping, Sequence

from msgspec import Struct

from beamcam.errors import Diagnostic, Source
from beamcam.machine.coper import Coper
from beamcam.model.part import Face
from beamcam.planning.coping import rules
from beamcam.planning.coping.cuts import borders_of, chains_of
from beamcam.planning.coping.regions import Region
from beamcam.planning.coping.walls import EDGE, Root, Wall

SHARE = 0.5  #: of the tolerance, that web and flange may differ by at a root


class Crossing(Struct, frozen=True):
    """A cut through the whole of a root, square to the bar or in the plane of an end."""

    x: float
    right: bool  #: whether the scrap lies at greater x
    square: bool = True  #: to the bar
    end: int | None = None  #: in whose plane it lies, 0 at the start


def root_faults(
    regions: Mapping[Face, Region], depths: Mapping[int | None, float], coper: Coper,
    source: Source,
) -> Iterator[Diagnostic]:  # fmt: skip
    """What cannot be cut at the roots of a web.

    `depths` are those to which a pass through a root may cut, from outside of the flange: what it
    meets of the web has to be cut at that x anyway, or in the plane of the end that it is tilted
    to (0 at the start).
    """
    web = regions["v"]
    for root in web.wall.roots:
        flange = regions[root.face]
        on_web, wrong = crossings(web, _band(root, depths[None], web.wall), coper)
        for end in {one.end for one in on_web} & depths.keys() - {None}:
            deeper, _ = crossings(web, _band(root, depths[end], web.wall), coper)
            if end not in {one.end for one in deeper}:
                wrong += [one.x for one in on_web if one.end == end]
        yield from _said(wrong, web.wall, source)
        (behind,) = flange.wall.roots
        band = max(EDGE, behind.low), min(flange.wall.width - EDGE, behind.high)
        on_flange, wrong = crossings(flange, band, coper)
        yield from _said(wrong, flange.wall, source)
        yield from _unpaired(on_web, on_flange, web.wall, flange.wall, coper, source)
        if coper.k_area == "refuse":
            for one in on_web[:1]:
                yield rules.K_AREA.at(source, x=f"{one.x:g}", face=root.face)


def _band(root: Root, depth: float, web: Wall) -> tuple[float, float]:
    """The y of the web between the flange's inner surface and where a pass through it ends."""
    if root.low == 0.0:
        return root.inner + EDGE, max(root.high, depth)
    return min(root.low, web.width - depth), root.inner - EDGE


def crossings(
    region: Region, band: tuple[float, float], coper: Coper
) -> tuple[list[Crossing], list[float]]:
    """The cuts through a band of a wall, along x, and where it is cut otherwise."""
    found: list[Crossing] = []
    wrong: list[float] = []
    for chain in chains_of(region.shape, borders_of(region.wall, *band, -EDGE)):
        xs = [x for x, _ in chain.points]
        whole = {chain.start, chain.end} == {"low", "high"}
        near = SHARE * coper.tolerance
        end = next(
            (k for k, line in enumerate(region.wall.skew)
             if line and all(abs(x - line.x(y)) <= near for x, y in chain.points)),
            None,
        )  # fmt: skip
        square = max(xs) - min(xs) <= near
        if not whole or (end is None and not square):
            wrong.append(xs[0])
            continue
        # The region lies on the left of its ring: upwards, the scrap is at greater x.
        found.append(Crossing((max(xs) + min(xs)) / 2, chain.start == "low", square, end))
    return sorted(found, key=lambda one: one.x), wrong


def _said(wrong: Sequence[float], wall: Wall, source: Source) -> Iterator[Diagnostic]:
    for x in wrong[:3]:
        yield rules.ROOT.at(
            source, what="a cut into or along a root", x=f"{x:g}", face=wall.face,
            expected="one through all of it, square to the bar or along a skew end, or none",
        )  # fmt: skip


def _unpaired(
    on_web: Sequence[Crossing],
    on_flange: Sequence[Crossing],
    web: Wall,
    flange: Wall,
    coper: Coper,
    source: Source,
) -> Iterator[Diagnostic]:
    """Cuts through a root of one wall without one of the other at the same x and side."""

    def has(one: Crossing, others: Sequence[Crossing]) -> bool:
        return any(
            one.right == other.right
            and (
                (one.end is not None and one.end == other.end)
                or (one.square and other.square
                    and abs(one.x - other.x) <= SHARE * coper.tolerance)
            )
            for other in others
        )  # fmt: skip

    for mine, others, wall, other in (
        (on_web, on_flange, web, flange), (on_flange, on_web, flange, web)
    ):  # fmt: skip
        for one in mine:
            if not has(one, others):
                yield rules.ROOT.at(
                    source, what="a cut to the root", x=f"{one.x:g}", face=wall.face,
                    expected=f"one of face {other.face} at that x, which the root goes with",
                )  # fmt: skip
