"""The part of a sheet: the paths of its tools without their leads, and without the kerf.

A path that comes back to itself is a contour: an outline where it lies in an even number of others,
else a hole. Where the program keeps the beam off by itself, the contour lies half a kerf beside the
path; a controller that compensates gets the contour.
"""

from collections.abc import Mapping, Sequence
from math import dist
from typing import cast

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from beamcam.checks.sheets.asked_sheet import rows_of
from beamcam.checks.sheets.compare import verify_sheet
from beamcam.checks.sheets.remainder import unchained
from beamcam.checks.sheets.strokes import HeadStroke, Strokes, strokes_of
from beamcam.controllers import table_run
from beamcam.errors import Diagnostic, Source, errors_in
from beamcam.geometry.array_types import Floats
from beamcam.geometry.curves import Line, join_boxes, signed_area
from beamcam.machine.machine import Machine
from beamcam.machine.torch import Torch, TorchProcess
from beamcam.model.part import Contour, ContourKind, Hole, Measures, Part, Process, Profile
from beamcam.recovery import rules
from beamcam.recovery.paths import Curves, bridge, ring_of, whole
from beamcam.recovery.recovered import Recovered, mark_of

MARK: Process = "punch"  #: of a marked contour, so that DSTV can hold it (KO)
MOST_CROSSINGS = 100_000  #: of closed paths, about, that are looked into
SAMPLED = 256  #: chords by which crossings are counted
ALONE = 8  #: chords that one may meet where no path is followed often
LOOK_SHARE = 1 / 8  #: of the tolerance, for polygons that tell what lies in what
ROUNDED = 5  #: last places by which the ends of two arcs at one place differ, centres being rounded
OFFSET_SHARE = 1 / 4  #: of the tolerance, to which contours are moved by half a kerf


class _Path(Struct, frozen=True):
    """The path of one stroke without leads."""

    process: TorchProcess
    curves: Curves
    closed: bool
    kerf: float  #: that the program itself keeps off the contour
    source: Source


def recover_sheet(text: str, machine: Machine, name: str, is_known: bool) -> Recovered:
    """The part of a sheet, its lower left corner at 0, 0 unless the machine leaves it in place.

    Unless its thickness `is_known`, one of the machine's cut chart is taken that the program suits.
    """
    torch = machine.needed(machine.torch, "torch")
    recovered = _recovered(text, machine, torch, name)
    if is_known or not errors_in(recovered.diagnostics):
        return recovered
    for thickness in sorted({row.up_to for row in torch.rows} - {torch.thickness}):
        fitted = replace(torch, thickness=thickness)
        other = _recovered(text, replace(machine, torch=fitted), fitted, name)
        if not errors_in(other.diagnostics):
            note = rules.FITTED.at(Source(name), found=f"{thickness:g}")
            return Recovered(other.parts, (*other.diagnostics, note))
    return recovered


def _recovered(text: str, machine: Machine, torch: Torch, name: str) -> Recovered:
    """The part of a sheet of the machine's own thickness."""
    from beamcam.geometry.polylines import polylines

    thickness = torch.thickness
    sheet = Part(
        mark_of(name), Profile("B", "", 0.0, 0.0, 0.0, thickness), 0.0, Source(name),
        grade=torch.material,
    )  # fmt: skip
    done, diagnostics = table_run(text, machine, name)
    rows = rows_of(sheet, torch)
    if not rows:
        material = torch.material or "any material"
        shown = "unknown thickness:" if thickness is None else f"{thickness:g}"
        diagnostics.append(rules.SHEET.at(Source(name), found=shown, material=material))
    if errors_in(diagnostics):
        return Recovered((), tuple(diagnostics))
    strokes, more = strokes_of(done, machine, torch, rows, name)
    diagnostics += more
    if errors_in(diagnostics):
        return Recovered((), tuple(diagnostics))
    strokes, _ = unchained(strokes, torch, machine.format.resolution)
    paths = _paths(strokes, torch, ROUNDED * machine.format.resolution, name)
    spots = [
        Hole("v", *p.curves[0].start, 0.0, p.source, kind="mark")
        for p in paths if p.process == "spot"
    ]  # fmt: skip
    paths = [path for path in paths if path.process != "spot"]
    cuts = {
        k: polylines(path.curves, torch.tolerance * LOOK_SHARE).points
        for k, path in enumerate(paths)
        if path.closed and path.process == "cut"
    }
    crossings = _crossings([*cuts.values()])
    if crossings > MOST_CROSSINGS:
        diagnostics.append(rules.CROWDED.at(Source(name), found=f"{crossings:.1g}"))
        return Recovered((), tuple(diagnostics))
    contours = _contours(paths, _depths(len(paths), cuts), torch, diagnostics)
    part = _placed(sheet, contours, spots, torch)
    if not errors_in(diagnostics):
        diagnostics += [
            d for d in verify_sheet(text, (part,), machine, name=name) if d not in diagnostics
        ]
    return Recovered((part,), tuple(diagnostics))


def _paths(strokes: Strokes, torch: Torch, fine: float, name: str) -> list[_Path]:
    """The paths of the strokes; those of a contour with bridges in it are one.

    Ends within `fine` are one place.
    """
    legs, near = list(strokes.moves.each()), max(torch.gap, fine)
    paths: list[_Path] = []
    waiting: list[Curves] = []  #: pieces of a contour that did not close yet
    for stroke in strokes.each:
        own = legs[stroke.first : stroke.last]
        curves: Curves = tuple([leg.curve or Line(leg.start, leg.end) for leg in own])
        if torch.tabs and stroke.process == "cut" and ring_of(curves, fine, near) is None:
            reach = torch.tab_width + stroke.row.kerf + near
            if waiting and dist(waiting[-1][-1].end, curves[0].start) <= reach:
                waiting.append(curves)
            else:
                paths += [_path((w,), stroke, torch, fine, name) for w in waiting]
                waiting = [curves]
            one = _path(waiting, stroke, torch, fine, name)
            if one.closed:
                paths.append(one)
                waiting = []
        else:
            paths.append(_path((curves,), stroke, torch, fine, name))
    return paths + [_path((w,), strokes.each[-1], torch, fine, name) for w in waiting]


def _path(
    pieces: Sequence[Curves], stroke: HeadStroke, torch: Torch, fine: float, name: str
) -> _Path:
    """One path without its leads, its pieces joined and its end closed."""
    curves, near = pieces[0], max(torch.gap, fine)
    for more in pieces[1:]:
        curves = (*curves, *bridge(curves[-1], more[0]), *more)
    ring = ring_of(curves, fine, near)
    kerf = 0.0
    if ring is not None:
        curves = whole(curves[ring[0] : ring[1]], near)
        if dist(curves[-1].end, curves[0].start) > torch.tolerance * OFFSET_SHARE:
            curves = (*curves, Line(curves[-1].end, curves[0].start))
        kerf = stroke.row.kerf if stroke.process == "cut" and torch.kerf_by == "offset" else 0.0
    return _Path(stroke.process, curves, ring is not None, kerf, Source(name, stroke.line))


def _contours(
    paths: Sequence[_Path], inside: Sequence[int], torch: Torch, diagnostics: list[Diagnostic]
) -> list[Contour]:
    """The contours of the paths in their order, each `inside` so many cuts."""
    from beamcam.geometry.offset import Vanished, offset_chains

    moved = [k for k, path in enumerate(paths) if path.kerf]
    amounts = [paths[k].kerf / 2 * (1 if inside[k] % 2 else -1) for k in moved]
    rings = [paths[k].curves for k in moved]
    chains = {}
    offsets = offset_chains(rings, amounts, torch.tolerance * OFFSET_SHARE)
    for k, offset in zip(moved, offsets, strict=True):
        if isinstance(offset, Vanished):
            kerf, area = paths[k].kerf, abs(offset.area)
            diagnostics.append(rules.KERF.at(paths[k].source, found=area, kerf=kerf))
        else:
            largest = max(range(len(offset.areas)), key=lambda n: abs(offset.areas[n]))
            chains[k] = offset.chains[largest]
    contours = []
    for k, path in enumerate(paths):
        curves = chains.get(k, path.curves)
        kind: ContourKind = "open"
        if path.closed and path.process == "cut":
            kind = "inner" if inside[k] % 2 else "outer"
        if kind == "outer" and signed_area(curves) < 0.0:
            curves = tuple([c.reversed() for c in reversed(curves)])
        process = MARK if path.process == "mark" else path.process
        contours.append(
            Contour("v", kind, curves, path.source, cast("Process", process), path.closed)
        )
    return contours


def _crossings(drawn: Sequence[Floats]) -> float:
    """About how often closed cuts cross or cover each other and themselves, from a few chords."""
    import shapely

    if not drawn:
        return 0.0
    ends = np.concatenate([np.stack((points[:-1], points[1:]), axis=1) for points in drawn])
    chords = shapely.linestrings(ends)
    step = max(1, len(chords) // SAMPLED)
    met, _ = shapely.STRtree(chords).query(chords[::step], "intersects")
    return float(np.maximum(np.bincount(met) - ALONE, 0).sum()) * step / 2


def _depths(count: int, cuts: Mapping[int, Floats]) -> list[int]:
    """In how many closed cuts each of so many paths lies; `cuts` are polygons by their path."""
    import shapely

    rings, shapes = [*cuts], [shapely.Polygon(points).buffer(0.0) for points in cuts.values()]
    depths = [0] * count
    tree = shapely.STRtree(shapes)
    inner, outer = tree.query([s.representative_point() for s in shapes], "within")
    for a, b in zip(inner.tolist(), outer.tolist(), strict=True):
        depths[rings[a]] += a != b and shapes[a].area < shapes[b].area
    return depths


def _placed(sheet: Part, contours: Sequence[Contour], spots: Sequence[Hole], torch: Torch) -> Part:
    """The part with its contours and centre points, and the sheet's size."""
    box = join_boxes([c.bbox for contour in contours for c in contour.curves])
    if box is None:
        return replace(sheet, measures=Measures())
    x, y = (0.0, 0.0) if torch.place == "drawn" else box[:2]
    shift = (1.0, 0.0, -x), (0.0, 1.0, -y)
    if x or y:
        contours = [
            replace(contour, curves=tuple([c.transformed(shift) for c in contour.curves]))
            for contour in contours
        ]
        spots = [replace(spot, x=spot.x - x, y=spot.y - y) for spot in spots]
    height = box[3] - y
    thickness = sheet.profile.web_thickness or 0.0
    profile = Profile("B", f"PL{thickness:g}", height, 0.0, 0.0, sheet.profile.web_thickness)
    outlined = any(c.kind == "outer" for c in contours)
    return replace(
        sheet, profile=profile, length=box[2] - x, features=(*contours, *spots),
        measures=None if outlined else Measures(),
    )  # fmt: skip
