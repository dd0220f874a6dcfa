"""Whether all of a body is explained by what was read of it.

The part is rebuilt with the facets that the body has, so that what differs is what no feature
explains. The bound is that of the file: 0.1 cm3, and its own precision over the faces that cuts
made.
"""

from collections.abc import Callable, Sequence

import numpy as np
from msgspec import Struct

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.curves import Point
from beamcam.model.part import Contour
from beamcam.readers.ifc import rules
from beamcam.readers.ifc.finish import Shaped
from beamcam.readers.ifc.lumps import Lump, lumps, section_area
from beamcam.readers.ifc.rebuilt import rebuilt
from beamcam.readers.ifc.region import rectangle
from beamcam.readers.ifc.section import Section, Stocks
from beamcam.readers.ifc.shell import Shell
from beamcam.readers.ifc.walls import Wall, walls_of

BOUND = 100.0  #: mm3 that a body may differ from its part
ROUNDEST = 0.01  #: mm of a file's stated precision that is believed
KERNEL_SLACK = 0.13  #: mm, half of what the kernel's facets may be off
SHOWN = 3  #: lumps that a message names
LEVEL_REACH = 0.15  #: thicknesses of a wall that a level may lie inside it
LEAN_REACH = 2.0  #: thicknesses of a wall that an edge may lean through it
#: Share of a volume from which on it is an error that no lump explains it, that it leans, or that
#: it is of a root fillet.
GROSS = 0.005


class UnexplainedRegions(Struct, frozen=True):
    """Regions of a body that no feature accounts for."""

    lumps: tuple[Lump, ...] = ()
    fillets: tuple[Lump, ...] = ()  #: root fillets, which no contour of a flange describes
    leaning: tuple[Lump, ...] = ()  #: beside edges that do not go square through their wall
    off: float = 0.0  #: mm3 that the body is larger
    volume: float = 0.0  #: mm3 of the body

    def said(self, source: Source) -> tuple[Diagnostic, ...]:
        """The diagnostics of it."""
        if self.lumps:
            return (rules.UNEXPLAINED.at(source, found=_told(self.lumps)),)
        if sum(one.volume for one in self.fillets) > GROSS * self.volume > 0.0:
            share = f"{100 * GROSS:g}"
            return (rules.ROOT_CUT.at(source, found=_told(self.fillets), share=share),)
        said = [
            rule.at(source, found=_told(found))
            for rule, found in ((rules.ROOT_FILLET, self.fillets), (rules.LEANING, self.leaning))
            if found
        ]
        if self.off and not said:
            rule = rules.VOLUME_OFF if abs(self.off) > GROSS * self.volume else rules.VOLUME
            text = f"{self.volume / 1e3:.2f}", f"{(self.volume - self.off) / 1e3:.2f}"
            said = [rule.at(source, found=text[0], expected=text[1])]
        return tuple(said)


def difference(
    shaped: Shaped,
    body: Shell,
    stocks: Stocks,
    *,
    volume: float | None,
    slack: float,
    precision: float,
    faceted: bool,
) -> UnexplainedRegions:
    """What of a body, in the part's place, is not explained by its part.

    `volume` is that of the exact solid, or of the body's own facets where it has no other
    (`faceted`); None where it has none. Facets may be `slack` mm off what they stand for.
    """
    corners = corners_on(body) if faceted else None
    made = rebuilt(shaped, stocks.exact, corners)
    rounding = min(precision, ROUNDEST) * _cut_area(shaped, stocks.area)
    bound = BOUND + rounding
    off = 0.0
    if volume is not None:
        off = volume - made.volume * (stocks.area / float(stocks.exact.area))
    alike = made if faceted else rebuilt(shaped, stocks.faceted, corners_on(body))
    found = lumps(body, alike, shaped.section, slack)
    fillets = tuple(one for one in found if one.face == "the root fillet")
    rest = [one for one in found if one.face != "the root fillet"]
    leaning = tuple(one for one in rest if _leans(one, shaped))
    if volume is not None and sum(one.volume for one in leaning) > GROSS * volume:
        leaning = ()  # too much for a cut whose edge leans
    rest = [one for one in rest if one not in leaning]
    if sum(one.volume for one in rest) <= bound:
        rest = []
    if sum(one.volume for one in fillets) <= bound:
        fillets = ()
    if sum(one.volume for one in leaning) <= bound:
        leaning = ()
    return UnexplainedRegions(
        tuple(rest), fillets, leaning, off if abs(off) > bound else 0.0, volume or 0.0
    )


def plain_stocks(section: Section) -> Stocks:
    """Those of a flat bar or a plate."""
    whole = rectangle(0.0, 0.0, section.width, section.height)
    return Stocks(whole, whole, section.width * section.height)


def measured(body: Shell) -> float:
    """mm3 of a body, by its sections where its faces are not turned alike."""
    return body.volume if body.volume is not None else section_area(body)


def corners_on(body: Shell) -> Callable[[Wall], Sequence[Point]]:
    """Which corners of a body lie in a wall, as (x, q)."""

    def on(wall: Wall) -> Sequence[Point]:
        q, c = (2, 1) if wall.normal == "y" else (1, 2)
        depth = body.points[:, c]
        there = (depth > wall.low - 0.01) & (depth < wall.high + 0.01)
        found = np.unique(body.points[there][:, (0, q)].round(5), axis=0)
        return [(float(x), float(y)) for x, y in found]

    return on


def _cut_area(shaped: Shaped, area: float) -> float:
    """mm2 of the faces that cuts made: both ends, and the edges of contours."""
    edges = sum(
        c.length * 25.0 for f in shaped.features if isinstance(f, Contour) for c in f.curves
    )
    return 2 * area + min(edges, 20 * area)


def _leans(lump: Lump, shaped: Shaped) -> bool:
    """Whether a lump is what an edge leaves that does not go square through its wall.

    The part has the outline of both sides of the wall together, so that it may lack no more than
    what lies between its surface and the level at which it was looked at.
    """
    wall = next((w for w in walls_of(shaped.section) if w.face == lump.face), None)
    if wall is None or lump.beside is None:
        return False
    return lump.beside <= wall.thickness * (LEVEL_REACH if lump.more else LEAN_REACH)


def _told(found: Sequence[Lump]) -> str:
    text = "; ".join(map(str, found[:SHOWN]))
    more = len(found) - SHOWN
    return f"{text}; and {more} more" if more > 0 else text
