"""What is asked of a sheet: rows of the cut chart, their words, openings that no torch cuts.

Of words those count that start and stop a tool, M words, as the machine's templates have them.
"""

from collections.abc import Iterable, Sequence
from itertools import dropwhile, takewhile
from math import pi

import numpy as np
import shapely
from msgspec import Struct
from msgspec.structs import replace

from beamcam.checks.sheets.region import Region
from beamcam.controllers import table_events
from beamcam.controllers.dialect import tool_words
from beamcam.controllers.events import Pause, Said, Switch, TableEvent, ToolOffset
from beamcam.geometry.array_types import Floats
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.geometry.plane import Point
from beamcam.machine.machine import Machine
from beamcam.machine.torch import (
    LayerSettings,
    Torch,
    TorchProcess,
    TorchRow,
    is_row_for,
    material_said,
)
from beamcam.model.description import PART_DATA
from beamcam.model.part import Part, extent


def thickness_of(part: Part, torch: Torch) -> float:
    """Of the part's sheet in mm, what the machine's file takes where it does not say; 0 unknown."""
    own = part.profile.web_thickness
    return own if own is not None else torch.thickness or 0.0


def rows_of(part: Part, torch: Torch) -> list[TorchRow]:
    """The rows that may run on the part's sheet: of each process, then of colours and layers."""
    rows = rows_on(part, torch)
    return rows + [
        with_settings(row, own)
        for key, own in torch.settings.items()
        for row in rows
        if torch.colours.get(key) == row.process
    ]


def with_settings(row: TorchRow, own: LayerSettings) -> TorchRow:
    """A row as the settings of a colour or a layer have it."""
    return replace(
        row,
        feed_mm_min=row.feed_mm_min if own.speed is None else own.speed,
        power=row.power if own.power is None else own.power,
        passes=row.passes if own.passes is None else own.passes,
    )


def _at_feed(row: TorchRow, torch: Torch, thickness: float) -> TorchRow:
    """A row at the feed that the chart has for a thickness, where the file says it lies between."""
    if torch.between_rows != "interpolate":
        return row
    alike = [
        r for r in torch.rows
        if (r.process, r.material, r.amps, r.nozzle)
        == (row.process, row.material, row.amps, row.nozzle)
    ]  # fmt: skip
    thinner = [r for r in alike if r.up_to <= thickness]
    if not thinner or row.up_to == thickness:
        return row
    below = max(thinner, key=lambda r: r.up_to)
    share = (thickness - below.up_to) / (row.up_to - below.up_to)
    feed = below.feed_mm_min + share * (row.feed_mm_min - below.feed_mm_min)
    return replace(row, feed_mm_min=feed)


def rows_on(part: Part, torch: Torch) -> list[TorchRow]:
    """The row of each process on the part's sheet, as the machine's file has it."""
    thickness = thickness_of(part, torch)
    material = material_said(part.grade, torch.material)
    rows: dict[TorchProcess, TorchRow] = {}
    for row in torch.rows:
        if 0.0 < thickness <= row.up_to and is_row_for(row.material, material):
            rows.setdefault(row.process, _at_feed(row, torch, thickness))
    if torch.drilled == "spot" and "cut" in rows:
        rows.setdefault("spot", rows["cut"].spotting())
    return list(rows.values())


# --- words ---------------------------------------------------------------------------------------


class RowWords(Struct, frozen=True):
    """The M words of one row: what starts its tool and what stops it."""

    row: TorchRow
    on: tuple[Said, ...]
    off: tuple[Said, ...]
    pierce_s: float
    tool: int  #: of the controller's table, whose places they choose; 0 is the torch
    stop_s: float  #: that it stays on for, the head at rest, before it is stopped


def words_of(row: TorchRow, machine: Machine, torch: Torch) -> RowWords:
    """The words of a row, read from the machine's templates by the controller's own rules.

    Programs write powers, seconds and feeds to three decimals. In laser mode a word by itself
    switches nothing; here it is looked at what it says.
    """
    second = 0.001 if machine.format.dwell_unit == "ms" else 1.0
    reader = replace(machine, torch=replace(torch, laser_mode=False))
    figures = {
        "power": row.power, "pierce": row.pierce_s / second, "preheat": row.preheat_s / second,
        "pierce_height": row.pierce_height, "cut_height": row.cut_height, "amps": row.amps,
        "volts": row.volts,
    }  # fmt: skip
    values = {name: f"{figure:.3f}" for name, figure in figures.items()}
    values |= {"feed": "1", "number": str(row.number), "clearance": "0", "touch_height": "0"}
    values |= PART_DATA  # in comments only, as the machine's file is checked

    def events(key: str) -> list[TableEvent]:
        template: tuple[str, ...] = getattr(machine.words, key)
        return table_events("\n".join(line.format(**values) for line in template), reader)[0]

    on, off = events(f"{row.process}_on"), events(f"{row.process}_off")
    chosen = events(f"choose_{row.process}")
    starts = tool_words((e for e in on if isinstance(e, Switch)), True)
    stops = tool_words((e for e in off if isinstance(e, Switch)), False)
    return RowWords(
        row,
        tuple(e.said for e in starts),
        tuple(e.said for e in stops),
        _seconds(dropwhile(lambda e: e not in starts, on)),
        next((e.number for e in reversed(chosen) if isinstance(e, ToolOffset)), 0),
        _seconds(takewhile(lambda e: e not in stops, off)),
    )


def _seconds(events: Iterable[TableEvent]) -> float:
    return sum(event.seconds for event in events if isinstance(event, Pause))


# --- small openings -------------------------------------------------------------------------------

# Round openings and slots of drawings that are smaller than a torch cuts.


SAME_SIZE = 1e-6  #: mm, that an opening may be below the least by its last digits


class SmallOpening(Struct, frozen=True):
    """A round opening or a slot of a drawing."""

    centres: tuple[Point, ...]  #: of a slot those of its ends
    features: tuple[int, ...]  #: that draw it
    twins: tuple[int, ...]  #: that draw it again


def small_openings(
    region: Region, ways: Sequence[Curve], owners: Sequence[int], drawn: Sequence[bool],
    torch: Torch, least: float,
) -> list[SmallOpening]:  # fmt: skip
    """The openings among the cuts that are circles or slots narrower than `least`, by their ways.

    An opening is what an odd number of contours enclose, or what lies within one that is too small.
    `owners` are the features of the `ways`, `drawn` tells which of them are contours.
    """
    twins = [k for k in np.flatnonzero(region.twins).tolist() if drawn[k]]
    openings = []
    for number, centres in _openings(region, ways, torch.tolerance, least).items():
        mine = sorted({owners[way] for way, _ in region.rings[number]})
        hole = shapely.box(*shapely.bounds(shapely.buffer(region.polygons[number], torch.gap)))
        again = [owners[k] for k in twins if hole.contains(shapely.box(*ways[k].bbox))]
        openings.append(SmallOpening(centres, tuple(mine), tuple(again)))
    return openings


def _openings(
    region: Region, ways: Sequence[Curve], tolerance: float, least: float
) -> dict[int, tuple[Point, ...]]:
    """The centres of the rings that are small openings, by the rings' numbers."""
    round_ended: dict[int, tuple[Point, ...]] = {}
    areas = shapely.area(region.polygons)
    around = shapely.length(region.polygons)
    # A slot that has this area and this length all round is as wide as this; chords make it less.
    widths = (around - np.sqrt(np.maximum(around**2 - 4 * pi * areas, 0.0))) / pi
    small = np.flatnonzero(widths < least + tolerance)
    x0, y0, x1, y1 = shapely.bounds(region.polygons[small]).reshape(-1, 4).T
    # The middle of a circle or a slot lies in it, and in what is around it.
    middles = shapely.points((x0 + x1) / 2, (y0 + y1) / 2)
    own, around_it = shapely.STRtree(region.polygons).query(middles, "within")
    own = own[areas[around_it] > areas[small[own]]]
    for k in sorted(set(own.tolist())):
        number = int(small[k])
        curves = [ways[way] for way, _ in region.rings[number]]
        corners = np.asarray(region.polygons[number].exterior.coords)
        if centres := _centres(corners, curves, tolerance, least):
            round_ended[number] = centres
    if not round_ended:
        return {}
    rings = np.array(list(round_ended), dtype=np.int64)
    larger = np.bincount(own, minlength=len(small))[np.searchsorted(small, rings)]
    openings = rings[larger % 2 == 1]
    wider = shapely.STRtree(shapely.buffer(region.polygons[openings], tolerance))
    inside, _ = wider.query(region.polygons[rings], "covered_by")
    return {k: round_ended[k] for k in sorted({*openings.tolist(), *rings[inside].tolist()})}


def _centres(
    corners: Floats, curves: Sequence[Curve], tolerance: float, least: float
) -> tuple[Point, ...]:
    """The centres of an outline that is a circle or a slot below `least`; none if it is neither.

    Its box is that of its curves, as chords of a circle are within it; of one with straight sides
    that along the longest of them.
    """
    if len(curves) == 1 and isinstance(circle := curves[0], Arc) and abs(circle.sweep_deg) == 360.0:
        return (circle.centre,) if 2 * circle.radius < least - SAME_SIZE else ()
    sides = [curve for curve in curves if isinstance(curve, Line)]
    ux, uy = max(sides, key=lambda side: side.length).tangent(0.0) if sides else (1.0, 0.0)
    axes = np.array([[ux, uy], [-uy, ux]])
    if float(np.ptp(corners @ axes[1])) >= least:
        return ()
    turned = [curve.transformed(((ux, uy, 0.0), (-uy, ux, 0.0))) for curve in curves]
    low, high = np.array(extent(turned) or (0.0, 0.0, 0.0, 0.0)).reshape(2, 2)
    long, wide = (high - low).tolist()
    if abs(long - wide) <= 2 * tolerance:
        long = wide = (long + wide) / 2
    if wide > long or wide >= least - SAME_SIZE:
        return ()
    middle = (low + high) / 2
    far = middle + np.array([[-1.0, 0.0], [1.0, 0.0]]) * (long - wide) / 2
    line = shapely.LineString(far @ axes)
    places = np.concatenate((corners, (corners[1:] + corners[:-1]) / 2))
    off = np.abs(shapely.distance(shapely.points(places), line) - wide / 2)
    if off.max() > tolerance:
        return ()
    ends: list[list[float]] = np.unique(far @ axes, axis=0).tolist()
    return tuple((x, y) for x, y in ends)
