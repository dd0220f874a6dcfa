"""Check by polygons that the lines of a hatch are inside their contours and fill them."""

from itertools import groupby

import shapely
from msgspec import Struct

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.curves import Curve, Line
from beamcam.machine.torch import Torch, TorchProcess
from beamcam.verify.sheets import rules
from beamcam.verify.sheets.need import Need

CHORD = 0.1  #: mm
ROOM = 1.5  #: distances from the edge, and about a line, within which all is filled
HATCH = "hatch"  #: where the input's reader says that a line of a hatch is


class Filled(Struct):
    """The filled area of one look, and its lines."""

    rings: list[shapely.Polygon]
    lines: list[shapely.LineString]


def hatch_faults(need: Need, torch: Torch, name: str) -> list[Diagnostic]:
    """Hatches of which a line leaves its contours, or that leave a place of them empty."""
    said: list[Diagnostic] = []
    for process, curves in need.curves.items():
        for look in dict.fromkeys(need.looks[process]):
            own = torch.settings.get(look)
            if own is None or own.hatch is None:
                continue
            filled = _filled(need, process, look, curves)
            inside: shapely.Geometry = shapely.Polygon()
            for ring in filled.rings:
                inside = shapely.symmetric_difference(inside, shapely.make_valid(ring))
            lines = shapely.MultiLineString(filled.lines)
            outside = shapely.difference(lines, shapely.buffer(inside, torch.tolerance))
            empty = shapely.difference(
                shapely.buffer(inside, -ROOM * own.hatch), shapely.buffer(lines, ROOM * own.hatch)
            )
            for what, found in (("a line outside", outside), ("an empty place inside", empty)):
                if not found.is_empty:
                    x, y = found.representative_point().coords[0]
                    values = {"x": f"{x:.3f}", "y": f"{y:.3f}", "expected": f"{own.hatch:g}"}
                    said.append(rules.HATCH.at(Source(name), key=look, found=what, **values))
    return said


def _filled(need: Need, process: TorchProcess, look: str, curves: list[Curve]) -> Filled:
    found = Filled([], [])
    rows = zip(need.features[process], need.looks[process], curves, strict=True)
    for feature, group in groupby(rows, key=lambda row: row[0]):
        mine = [curve for _, key, curve in group if key == look]
        if not mine:
            continue
        points = [p for curve in mine for p in _points(curve)]
        if need.sources[feature].where == HATCH:
            found.lines.append(shapely.LineString(points))
        elif len(points) > 3 and mine[0].start == mine[-1].end:
            found.rings.append(shapely.Polygon(points))
    return found


def _points(curve: Curve) -> list[tuple[float, float]]:
    count = 1 if isinstance(curve, Line) else max(16, int(curve.length / CHORD))
    return [curve.point(k / count) for k in range(count + 1)]
