"""A sheet's part as it is laid on the table: mirrored, turned, and copied in rows and columns."""

from collections.abc import Iterator, Sequence
from itertools import product
from math import dist

from msgspec.structs import replace

from beamcam.errors import Diagnostic, PlanError, Source
from beamcam.geometry.arrays import CurveTable, table_of
from beamcam.geometry.conics import direction_deg
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.geometry.plane import (
    IDENTITY,
    Box,
    Matrix,
    Point,
    determinant,
    mapped,
    mapped_vector,
    unit_vector,
)
from beamcam.machine.torch import ORIGINS, Torch
from beamcam.model.colour import key_of
from beamcam.model.description import end_lines
from beamcam.model.hatch import hatched, not_filled
from beamcam.model.part import (
    PLATE_FACES,
    Contour,
    Feature,
    Hole,
    Part,
    Slot,
    TextMark,
    extent,
    moved_curve,
)
from beamcam.model.plan import ContourOp
from beamcam.planning.contours import rules
from beamcam.planning.contours.material import SheetMaterial
from beamcam.planning.contours.outline import Shape
from beamcam.planning.contours.spread import spread


def box_of(curves: CurveTable) -> Box:
    """The bounding box of one or more curves."""
    if curves.box is None:
        raise AssertionError("curves without a box")
    return curves.box


def shift_of(box: Box, torch: Torch) -> Point:
    """Machine coordinates of the part's x 0, y 0, by the box of its work."""
    if torch.place == "drawn" and torch.origin == "table":
        return 0.0, 0.0
    if torch.origin in ORIGINS:
        (u, v), (x0, y0, x1, y1) = ORIGINS[torch.origin], box
        return -x0 - u * (x1 - x0), -y0 - v * (y1 - y0)
    return torch.margin - box[0], torch.margin - box[1]


def moved(shapes: Sequence[Shape], shift: Point) -> list[Shape]:
    """The shapes in machine coordinates."""
    if shift == (0.0, 0.0):
        return list(shapes)
    return [
        replace(shape, curves=tuple([moved_curve(c, shift) for c in shape.curves]))
        for shape in shapes
    ]


def refuse_large(box: Box, part: Part, torch: Torch) -> None:
    """Raises PlanError if the box of the work is larger than the area; kerf and leads add to it.

    Asked first, because what a damaged file holds may be as large as a planet and take hours.
    """
    _refuse_extent(box, part, torch, torch.gap + torch.tolerance)


def worked_box(operations: Sequence[ContourOp], overscan: float = 0.0) -> Box:
    """The box around all that the tool does, leads included, and round hatches their overscan."""
    passes = [one for op in operations for one in op.passes]
    ways = [way for p in passes for way in (p.lead_in, p.curves, p.lead_out)]
    box = box_of(table_of(tuple([curve for way in ways for curve in way])))
    beyond = [
        point
        for op in operations
        if overscan and op.is_hatch
        for (x0, y0), (x1, y1) in ((op.start, op.end),)
        for k in (overscan / (dist(op.start, op.end) or 1.0),)
        for point in ((x0 - k * (x1 - x0), y0 - k * (y1 - y0)),
                      (x1 + k * (x1 - x0), y1 + k * (y1 - y0)))
    ]  # fmt: skip
    xs, ys = [x for x, _ in beyond], [y for _, y in beyond]
    return (min([box[0], *xs]), min([box[1], *ys]), max([box[2], *xs]), max([box[3], *ys]))


def refuse_size(operations: Sequence[ContourOp], part: Part, torch: Torch) -> None:
    """Raises PlanError if the head would have to leave the work area."""
    low_x, low_y, high_x, high_y = torch.area
    box = worked_box(operations, torch.overscan)
    slack = torch.tolerance
    _refuse_extent(box, part, torch, slack)
    if (
        box[0] < low_x - slack or box[1] < low_y - slack
        or box[2] > high_x + slack or box[3] > high_y + slack
    ):  # fmt: skip
        x0, y0, x1, y1 = (f"{v:.1f}" for v in box)
        raise PlanError(
            rules.SHEET_PLACE.at(
                part.source, x0=x0, y0=y0, x1=x1, y1=y1,
                length=f"{torch.length:g}", width=f"{torch.width:g}",
            )
        )  # fmt: skip


def _refuse_extent(box: Box, part: Part, torch: Torch, slack: float) -> None:
    if box[2] - box[0] > torch.length + slack or box[3] - box[1] > torch.width + slack:
        raise PlanError(
            rules.SHEET_SIZE.at(
                part.source,
                found=f"{box[2] - box[0]:.1f} x {box[3] - box[1]:.1f}",
                expected=f"{torch.length:g} x {torch.width:g}",
            )
        )


NOISE_DEG = 1.0  #: of an angle in a header; less is noise of its writer
QUARTER = 90.0  #: degrees by which a part is turned that fits so only


def is_laid_otherwise(torch: Torch) -> bool:
    """Whether a part is moved from its drawn position, or repeated."""
    return bool(torch.mirror != "none" or torch.rotate or torch.copies != (1, 1))


def laid(parts: tuple[Part, ...], torch: Torch | None) -> tuple[tuple[Part, ...], list[Diagnostic]]:
    """Parts of a sheet as the job wants them: mirrored, turned, copied, and hatched; and notes.

    One that fits turned only is turned, those of a drawing may be moved apart. Raises PlanError
    for a feature that cannot be laid so, a sheet that is too small, or a hatch that fills nothing.
    """
    if torch is None:
        return parts, []
    notes: list[Diagnostic] = []
    if len(parts) == 1:
        part, notes = apart(parts[0], torch)
        parts = (part,)
    torch = spaced(parts[0], torch) if parts else torch
    if fits_turned(parts, torch):
        torch = replace(torch, rotate=QUARTER)
        x0, y0, x1, y1 = _box(_with_outline(parts[0]))
        found, expected = f"{x1 - x0:.1f} x {y1 - y0:.1f}", f"{torch.length:g} x {torch.width:g}"
        notes = [*notes, rules.TURNED.at(parts[0].source, found=found, expected=expected)]
    if not (torch.settings or is_laid_otherwise(torch)):
        return parts, notes
    diagnostics: list[Diagnostic] = []
    if is_laid_otherwise(torch):
        diagnostics += [
            rules.LAYOUT.at(source, found=what)
            for part in parts
            for source, what in cannot_lie(part, torch)
        ]
        for part in () if diagnostics else parts:
            length, width = size_of(part, torch)
            if length > torch.length + torch.gap or width > torch.width + torch.gap:
                found = f"{length:.1f} x {width:.1f}"
                expected = f"{torch.length:g} x {torch.width:g}"
                diagnostics.append(rules.SHEET_SIZE.at(part.source, found=found, expected=expected))
        if diagnostics:
            raise PlanError(diagnostics)
        parts = tuple([laid_out(part, torch) for part in parts])
    diagnostics += [
        rules.HATCH.at(part.source, key=key, found=what)
        for part in parts
        for key, what in not_filled(part, torch)
    ]
    if diagnostics:
        raise PlanError(diagnostics)
    return tuple([hatched(part, torch) for part in parts]), notes


def apart(part: Part, torch: Torch) -> tuple[Part, list[Diagnostic]]:
    """A drawing for common cuts with its parts a kerf apart where they touch, and a note."""
    if not torch.common_cuts or torch.kerf_by == "none":
        return part, []
    return spread(part, torch, SheetMaterial(part, torch).kerf("cut"))


def spaced(part: Part, torch: Torch) -> Torch:
    """The torch with the spacing of its parts: for common cuts that is the kerf of the sheet."""
    if not torch.common_cuts:
        return torch
    kerf = 0.0 if torch.kerf_by == "none" else SheetMaterial(part, torch).kerf("cut")
    return replace(torch, spacing=kerf)


def fits_turned(parts: Sequence[Part], torch: Torch) -> bool:
    """Whether one part is too large for the sheet as it is drawn, and not if it is turned by 90
    degrees. What is asked for as it is drawn, or laid by an option, stays as it is."""
    if len(parts) != 1 or is_laid_otherwise(torch):
        return False
    if torch.place == "drawn" and torch.origin == "table":
        return False
    (part,) = parts
    any_ignored = "ignore" in torch.colours.values()
    curves = [
        curve
        for feature in _with_outline(part).features
        if not (any_ignored and isinstance(feature, Contour) and _is_ignored(feature, torch))
        for curve in _curves(feature)
    ]
    box = extent(curves)
    if box is None or next(cannot_lie(part, torch), None) is not None:
        return False
    length, width = box[2] - box[0], box[3] - box[1]
    long, wide = torch.length + torch.gap, torch.width + torch.gap
    return (length > long or width > wide) and width <= long and length <= wide


def _is_ignored(contour: Contour, torch: Torch) -> bool:
    key = key_of(contour, torch.colours)
    return key is not None and torch.colours[key] == "ignore"


def cannot_lie(part: Part, torch: Torch) -> Iterator[tuple[Source, str]]:
    """Features that cannot be mirrored, turned or copied: where they are, and what they are."""
    for feature in part.features:
        if isinstance(feature, Contour):
            if feature.bevels:
                yield feature.source, "a bevelled contour"
        elif isinstance(feature, TextMark):
            if torch.mirror != "none":
                yield feature.source, "a text, which would be read from behind"
        elif not isinstance(feature, Hole | Slot):
            yield getattr(feature, "source", part.source), type(feature).__name__.lower()


def size_of(part: Part, torch: Torch) -> tuple[float, float]:
    """Length and width of all copies together, with the spacing between them."""
    x0, y0, x1, y1 = _box(_as_turned(part, torch))
    (columns, rows), gap = torch.copies, torch.spacing
    return columns * (x1 - x0 + gap) - gap, rows * (y1 - y0 + gap) - gap


def laid_out(part: Part, torch: Torch) -> Part:
    """The part with all its copies: mirrored and turned about its middle, then repeated.

    Copies stand side by side in X and above each other in Y, their boxes `spacing` apart.
    """
    turned = _as_turned(part, torch)
    x0, y0, x1, y1 = _box(turned)
    columns, rows = torch.copies
    features = [
        _placed(feature, ((1.0, 0.0, k * (x1 - x0 + torch.spacing)),
                          (0.0, 1.0, n * (y1 - y0 + torch.spacing))))
        for n in range(rows) for k in range(columns) for feature in turned.features
    ]  # fmt: skip
    length, width = size_of(part, torch)
    return replace(
        turned, features=tuple(features), length=length,
        profile=replace(part.profile, height=width),
    )  # fmt: skip


def _as_turned(part: Part, torch: Torch) -> Part:
    whole = _with_outline(part)
    x0, y0, x1, y1 = _box(whole)
    matrix = _about(((x0 + x1) / 2, (y0 + y1) / 2), torch)
    if matrix == IDENTITY:
        return whole
    return replace(whole, features=tuple([_placed(f, matrix) for f in whole.features]))


def _about(middle: tuple[float, float], torch: Torch) -> Matrix:
    """The matrix that mirrors and then turns about a point."""
    if torch.mirror == "none" and not torch.rotate:
        return IDENTITY
    (c, s), (mx, my) = unit_vector(torch.rotate), middle
    fx, fy = (-1.0 if torch.mirror == axis else 1.0 for axis in ("x", "y"))
    a, b, d, e = c * fx, -s * fy, s * fx, c * fy
    return (a, b, mx - a * mx - b * my), (d, e, my - d * mx - e * my)


def _with_outline(part: Part) -> Part:
    """A plate that is described by its length and width alone, with its rectangle as a contour."""
    lines = outline_of(part)
    if not lines:
        return part
    return replace(part, features=(*part.features, Contour("v", "outer", lines, part.source)))


def outline_of(part: Part) -> tuple[Line, ...]:
    """The outline of a plate that has no contour of its own: its length and width, and its ends as
    the header has them; nothing for others and drawings.
    """
    cut = [c for c in part.contours if c.kind == "outer" and c.process == "cut"]
    if part.measures is not None or any(contour.face in PLATE_FACES for contour in cut):
        return ()
    (a, d), (b, c) = end_lines(part, "v")
    return Line(a, b), Line(b, c), Line(c, d), Line(d, a)


def outermost(part: Part, thickness: float) -> Iterator[tuple[float, float, float]]:
    """The corners of the box of a plate, by its outline or its header."""
    outer = [curve for one in part.contours if one.kind == "outer" for curve in one.curves]
    x0, y0, x1, y1 = extent(outer) or (0.0, 0.0, part.length, part.profile.height)
    return product((x0, x1), (y0, y1), (0.0, thickness))


def skew_ends(part: Part, torch: Torch) -> Iterator[Diagnostic]:
    """An error for each end of a plate that the header has skew through the thickness, unless
    bevels of an outline say edge by edge what is: see `skew_ends.with_bevels`."""
    if any(contour.bevels for contour in part.contours):
        return
    cuts, least = part.cuts, max(torch.min_bevel, NOISE_DEG)
    if abs(cuts.flange_start) >= least:
        source = part.cut_source("flange", "start")
        yield rules.SKEW_END.at(source, end="start", found=f"{cuts.flange_start:g}")
    if abs(cuts.flange_end) >= least:
        source = part.cut_source("flange", "end")
        yield rules.SKEW_END.at(source, end="end", found=f"{cuts.flange_end:g}")


def _box(part: Part) -> Box:
    box = extent(curve for feature in part.features for curve in _curves(feature))
    return box or (0.0, 0.0, part.length, part.profile.height)


def _curves(feature: Feature) -> Iterator[Curve]:
    """Curves that reach as far as a feature does."""
    if isinstance(feature, Contour):
        yield from feature.curves
    elif isinstance(feature, Hole):
        yield Arc((feature.x, feature.y), feature.diameter / 2, 0.0, 360.0)
    elif isinstance(feature, Slot):
        c, s = unit_vector(feature.angle)
        for u in (-feature.length / 2, feature.length / 2):
            for v in (-feature.height / 2, feature.height / 2):
                centre = feature.x + c * u - s * v, feature.y + s * u + c * v
                yield Arc(centre, feature.diameter / 2, 0.0, 360.0)


def _placed(feature: Feature, matrix: Matrix) -> Feature:
    """A feature moved by a matrix that keeps lengths; a contour goes round as it did."""
    if isinstance(feature, Contour):
        return _placed_contour(feature, matrix)
    if isinstance(feature, Hole):
        x, y = mapped(matrix, (feature.x, feature.y))
        return replace(feature, x=x, y=y)
    if isinstance(feature, Slot | TextMark):
        x, y = mapped(matrix, (feature.x, feature.y))
        angle = direction_deg(mapped_vector(matrix, unit_vector(feature.angle)))
        return replace(feature, x=x, y=y, angle=angle)
    return feature


def _placed_contour(contour: Contour, matrix: Matrix) -> Contour:
    curves = tuple([_moved(curve, matrix) for curve in contour.curves])
    notches = tuple([replace(n, corner=mapped(matrix, n.corner)) for n in contour.notches])
    if determinant(matrix) < 0.0:
        last = len(curves) - 1
        curves = tuple([curve.reversed() for curve in reversed(curves)])
        notches = tuple([replace(notch, curve=last - notch.curve) for notch in notches])
    return replace(contour, curves=curves, notches=notches)


def _moved(curve: Curve, matrix: Matrix) -> Curve:
    """As `transformed`; an arc that is only moved keeps its angles as they are."""
    if isinstance(curve, Arc) and matrix[0][:2] == (1.0, 0.0) and matrix[1][:2] == (0.0, 1.0):
        return replace(curve, centre=mapped(matrix, curve.centre))
    return curve.transformed(matrix)
