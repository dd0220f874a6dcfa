"""Curves that a sheet requires to be cut and marked, from part and machine table alone."""

from collections.abc import Collection, Sequence
from itertools import compress
from math import dist
from typing import cast

import numpy as np
from msgspec import Struct, field

from beamcam.checks.job import is_manual_work, left_out, manual_work
from beamcam.checks.sheets import rules
from beamcam.checks.sheets.asked_sheet import rows_on, small_openings, thickness_of
from beamcam.checks.sheets.plates import header_outline, open_edges, outlines_of
from beamcam.checks.sheets.region import Region, region_of
from beamcam.checks.sheets.toolpaths import Toolpaths
from beamcam.checks.within import needless
from beamcam.errors import Diagnostic, Source
from beamcam.geometry.curves import Arc, Curve, Line, unit_vector
from beamcam.geometry.plane import Point
from beamcam.machine.machine import Machine
from beamcam.machine.torch import Torch, TorchProcess, TorchRow
from beamcam.model.colour import key_of, process_of
from beamcam.model.part import (
    PLATE_FACES,
    Contour,
    EndPlane,
    Feature,
    Hole,
    Part,
    Process,
    Slot,
    TextMark,
    extent,
)
from beamcam.model.request import policy_on

SAME_PLACE = 1e-5  #: mm between the centres of two features that are spotted once
PLANE_OFF = 0.1  #: mm that an end plane may lie inside of a plate and take nothing
OUTLINE = -1  #: in place of a feature, for the rectangle of a plate without a contour of its own


class Need(Struct):
    """Curves by process, as the part has them."""

    curves: dict[TorchProcess, list[Curve]] = field(default_factory=dict)
    features: dict[TorchProcess, list[int]] = field(default_factory=dict)  #: of each curve
    looks: dict[TorchProcess, list[str]] = field(default_factory=dict)  #: keys of their settings
    rows: dict[TorchProcess, TorchRow] = field(default_factory=dict)  #: of processes on the sheet
    sources: dict[int, Source] = field(default_factory=dict)  #: of the features
    #: contours that are filled and not followed, by the key of their settings
    filled: dict[str, list[Contour]] = field(default_factory=dict)
    #: places that the torch spots, and a feature whose centre each is
    spots: dict[Point, int] = field(default_factory=dict)
    diagnostics: list[Diagnostic] = field(default_factory=list)
    drawn: dict[tuple[TorchProcess, float], Toolpaths] = field(default_factory=dict)
    regions: dict[float, Region] = field(default_factory=dict)

    def add(
        self, process: TorchProcess, curves: Sequence[Curve], feature: int, source: Source,
        look: str = "",
    ) -> None:  # fmt: skip
        self.sources[feature] = source
        self._forget(process)
        self.looks.setdefault(process, []).extend([look] * len(curves))
        self.curves.setdefault(process, []).extend(curves)
        self.features.setdefault(process, []).extend([feature] * len(curves))

    def add_centre(self, place: Point, torch: Torch, feature: int, source: Source) -> None:
        """A centre to mark: by a spot, once for all features there, or by a cross."""
        if torch.drilled != "spot":
            (x, y), half = place, torch.cross / 2
            cross = [Line((x - half, y), (x + half, y)), Line((x, y - half), (x, y + half))]
            self.add("mark", cross, feature, source)
            return
        self.sources[feature] = source
        if all(dist(place, other) > SAME_PLACE for other in self.spots):
            self.spots[place] = feature

    def source(self, process: TorchProcess, curve: int) -> Source:
        """Where the input has a curve of a process, which is known by its number."""
        return self.sources[self.features[process][curve]]

    def without_cuts(self, features: Collection[int]) -> None:
        """Take away the cuts of some features."""
        kept = [feature not in features for feature in self.features["cut"]]
        for rows in (self.curves, self.looks, self.features):
            rows["cut"] = list(compress(rows["cut"], kept))  # type: ignore[arg-type]
        self._forget("cut")

    def _forget(self, process: TorchProcess) -> None:
        """Curves of a process are others now."""
        if not self.drawn and not self.regions:
            return
        self.drawn = {key: drawn for key, drawn in self.drawn.items() if key[0] != process}
        if process == "cut":
            self.regions = {}

    def toolpaths(self, process: TorchProcess, tolerance: float) -> Toolpaths:
        """The curves of a process as elements, where the part has them; made once."""
        key = process, tolerance
        if key not in self.drawn:
            self.drawn[key] = Toolpaths(self.curves.get(process, []), tolerance)
        return self.drawn[key]

    def region(self, torch: Torch) -> Region:
        """What the cuts enclose, where the part has them; made once."""
        fine = torch.tolerance / 8
        if fine not in self.regions:
            features = np.array(self.features.get("cut", []), dtype=np.int64)
            self.regions[fine] = region_of(self.toolpaths("cut", fine), features, torch.gap, fine)
        return self.regions[fine]


def need_of(part: Part, machine: Machine, torch: Torch, skips: Collection[str]) -> Need:
    """The curves of a part; features that nothing is known to make are reported.

    A feature may be missing if its colour or layer is mapped to "ignore", or if the machine cannot
    make it and its kind is one of `skips`, as `--allow-skips` names them. A feature that the
    machine can make is needed whatever is named; marks that the machine file leaves for manual work
    are told.
    """
    rows = {row.process: row for row in reversed(rows_on(part, torch))}
    gone = needless(part)
    header = () if part.measures is not None else header_outline(part)
    edges = open_edges(part, header, OUTLINE, gone)
    policies = [policy_on(feature, machine.marks) for feature in part.features]
    by_hand = [
        k for k, feature in enumerate(part.features)
        if policies[k] is not None and is_manual_work(feature, machine)
    ]  # fmt: skip
    listed = [manual_work(part.features[k], part, machine) for k in by_hand]
    need, gone = Need(diagnostics=listed, rows=rows), gone.union(by_hand)
    table = cast("dict[str, Process]", torch.colours)
    processes: dict[tuple[str | None, str | None], str | None] = {}
    thickness = thickness_of(part, torch)
    for index, feature in enumerate(part.features):
        needless_end = isinstance(feature, EndPlane) and not _cuts(feature, part, thickness)
        if index in gone or needless_end:
            continue
        policy = policies[index]
        if policy == "make" and isinstance(feature, TextMark):
            continue  # its position is taken from the program: see `marks.add_texts`
        kind = "mark" if policy == "refuse" else kind_not_made(feature, torch, thickness)
        if kind is not None and _is_left(need, part, index, kind, machine, torch, skips):
            continue
        if isinstance(feature, Contour):
            look = feature.layer, feature.colour
            if look not in processes:
                processes[look] = process_of(feature, table)
            if index in edges:
                need.add("cut", edges[index], index, feature.source)
                continue
            _follow(need, part, index, feature, torch, processes[look])
        elif isinstance(feature, Hole) and feature.kind == "mark":
            need.add_centre((feature.x, feature.y), torch, index, feature.source)
        else:
            hole = cast("Hole | Slot", feature)
            need.add("cut", _ring(hole), index, hole.source)
    if part.measures is None and not outlines_of(part):
        sides = edges.get(OUTLINE) or header_outline(part)
        need.add("cut", sides, OUTLINE, part.source)
    _leave_small_openings(need, part, machine, torch, skips)
    return need


def _is_left(
    need: Need, part: Part, index: int, kind: str, machine: Machine, torch: Torch,
    skips: Collection[str],
) -> bool:  # fmt: skip
    """Whether a feature is not cut, of a `kind` that the machine does not make; says why."""
    feature = part.features[index]
    if kind == "bevel" and torch.bevel == "square":
        # It is cut as it stands, square, and the rest is manual work.
        need.diagnostics.append(manual_work(feature, part, machine))
        return False
    is_drilled = kind in ("tool", "slot") and torch.drilled != "refuse"
    if is_drilled and isinstance(feature, Hole | Slot) and feature.kind != "mark":
        need.diagnostics.append(manual_work(feature, part, machine))
        # Where the drill begins: the middle of a hole, those of the corners of a slot.
        (c, s), u, v = (1.0, 0.0), 0.0, 0.0
        if isinstance(feature, Slot):
            (c, s), u, v = unit_vector(feature.angle), feature.length / 2, feature.height / 2
        for x, y in {(c * x - s * y, s * x + c * y) for x in (-u, u) for y in (-v, v)}:
            need.add_centre((feature.x + x, feature.y + y), torch, index, feature.source)
    elif kind not in skips:
        _not_made(need, part, feature, kind)
    elif kind == "bevel":
        return False  # a bevel that may be missing leaves a contour that is cut square
    else:
        need.diagnostics += left_out(part, (index,))
    return True


def _leave_small_openings(
    need: Need, part: Part, machine: Machine, torch: Torch, skips: Collection[str]
) -> None:
    """Have openings of drawings that the torch cannot cut marked for the drill, or left out."""
    least = max(torch.min_hole, torch.min_hole_share * thickness_of(part, torch))
    ways, owners = need.curves.get("cut"), need.features.get("cut")
    if not least or not ways or not owners:
        return
    drawn = [k != OUTLINE and isinstance(part.features[k], Contour) for k in owners]
    left: set[int] = set()
    for opening in small_openings(need.region(torch), ways, owners, drawn, torch, least):
        left.update(opening.features, opening.twins)
        for index in opening.features:
            feature = part.features[index]
            if torch.drilled != "refuse":
                need.diagnostics.append(manual_work(feature, part, machine))
                for place in opening.centres:
                    need.add_centre(place, torch, index, feature.source)
            elif (kind := "slot" if len(opening.centres) > 1 else "tool") in skips:
                need.diagnostics += left_out(part, (index,))
            else:
                _not_made(need, part, feature, kind)
    if left:
        need.without_cuts(left)


def _follow(
    need: Need, part: Part, index: int, contour: Contour, torch: Torch, process: str | None
) -> None:
    """Require the curves of a contour; or its inside, if only that is filled.

    `process` is that of its colour or layer; one that has neither says its own.
    """
    is_plain = contour.layer is None and contour.colour is None
    if is_plain:
        process = "mark" if contour.process in ("punch", "powder") else contour.process
    if process is None:
        _not_made(need, part, contour, "map")
        return
    if process == "ignore":
        return
    is_set = torch.settings and (contour.layer or contour.colour)
    key = (key_of(contour, torch.colours) or "") if is_set else ""
    own = torch.settings.get(key)
    closes = contour.closed or contour.curves[0].start == contour.curves[-1].end
    if own is not None and own.hatch is not None and not own.hatch_outline and closes:
        need.filled.setdefault(key, []).append(contour)
        return
    need.add(cast("TorchProcess", process), contour.curves, index, contour.source, key)


def kind_not_made(feature: Feature, torch: Torch, thickness: float) -> str | None:
    """What a table cannot make of a feature, by the name of `--allow-skips`; None if it can.

    A contour with a bevel loses no steel by a square cut: a bevel only takes away from what the
    contour holds, on the face that is looked at or on the far one.
    """
    least = max(torch.min_hole, torch.min_hole_share * thickness)
    match feature:
        case Contour() | Hole() | Slot() if feature.face not in PLATE_FACES:
            return "face"
        case Contour():
            meant = any(abs(bevel.angle) >= torch.min_bevel for bevel in feature.bevels)
            return "bevel" if meant else None
        case Hole() if feature.kind == "mark":
            marked = torch.cross or torch.drilled == "spot"
            return None if marked and feature.depth is None else "tool"
        case Hole() | Slot():
            across = min(feature.length, feature.height) if isinstance(feature, Slot) else 0.0
            is_wide = across + feature.diameter >= least
            through = feature.kind == "through" and feature.depth is None
            what = "slot" if isinstance(feature, Slot) else "tool"
            return None if through and is_wide else what
        case TextMark():
            return "mark"
        case _:
            return "other"


def _cuts(plane: EndPlane, part: Part, thickness: float) -> bool:
    """Whether some of a plate lies before a plane, by more than its edges may be off."""
    ways = np.array(plane.normal) / np.linalg.norm(plane.normal)
    own = [c for f in part.contours if f.kind == "outer" for c in f.curves]
    ends = [at for c in own or header_outline(part) for at in (c.bbox[:2], c.bbox[2:])]
    low, high = (*np.min(ends, axis=0), 0.0), (*np.max(ends, axis=0), thickness)
    farthest = np.where(ways > 0.0, high, low)
    return bool(ways @ (farthest - plane.point) > PLANE_OFF)


def _not_made(need: Need, part: Part, feature: Feature, kind: str) -> None:
    source, found = getattr(feature, "source", part.source), type(feature).__name__.lower()
    need.diagnostics.append(rules.NOT_MADE.at(source, found=found, kind=kind))


def _ring(feature: Hole | Slot) -> list[Curve]:
    """The outline of a hole; that of a slot as its four sides and four corners."""
    radius = feature.diameter / 2
    if isinstance(feature, Hole):
        return [Arc((feature.x, feature.y), radius, 0.0, 360.0)]
    c, s = unit_vector(feature.angle)
    u, v = feature.length / 2, feature.height / 2
    far_u, far_v = u + radius, v + radius

    def at(x: float, y: float) -> Point:
        return feature.x + c * x - s * y, feature.y + s * x + c * y

    sides: list[Curve] = [
        Line(at(*a), at(*b))
        for a, b in (((-u, far_v), (u, far_v)), ((far_u, -v), (far_u, v)),
                     ((u, -far_v), (-u, -far_v)), ((-far_u, v), (-far_u, -v)))
        if a != b
    ]  # fmt: skip
    corners = ((u, v), (-u, v), (-u, -v), (u, -v)) if radius > 0.0 else ()
    arcs = (Arc(at(*p), radius, feature.angle + 90.0 * k, 90.0) for k, p in enumerate(corners))
    return [*sides, *arcs]


def shift_of(need: Need, torch: Torch) -> tuple[float, float]:
    """Machine coordinates of the part's x 0, y 0, as the machine places a sheet."""
    if (torch.place == "drawn" and torch.origin == "table") or not need.curves:
        return 0.0, 0.0
    box = extent(curve for curves in need.curves.values() for curve in curves)
    x0, y0, x1, y1 = box or (0.0, 0.0, 0.0, 0.0)
    if torch.origin == "table":
        return torch.margin - x0, torch.margin - y0
    xs = {"left": x0, "right": x1, "centre": (x0 + x1) / 2}
    ys = {"lower": y0, "upper": y1, "centre": (y0 + y1) / 2}
    across, _, along = torch.origin.partition("-")
    return -xs[along or across], -ys[across]
