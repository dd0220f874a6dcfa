"""A part as it is laid for the machine: mirrored, turned, and copied in rows and columns."""

from collections.abc import Iterator

from msgspec.structs import replace

from beamcam.errors import Source
from beamcam.geometry.conics import direction_deg
from beamcam.geometry.curves import Arc, Curve
from beamcam.geometry.plane import Matrix, determinant, mapped, mapped_vector, unit_vector
from beamcam.machine.torch import Torch
from beamcam.model.part import Contour, Feature, Hole, Part, Slot, TextMark
from beamcam.planning.contours.outline import reach_of, with_outline


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
    x0, y0, x1, y1 = reach_of(_as_turned(part, torch))
    (columns, rows), gap = torch.copies, torch.spacing
    return columns * (x1 - x0 + gap) - gap, rows * (y1 - y0 + gap) - gap


def laid_out(part: Part, torch: Torch) -> Part:
    """The part with all its copies: mirrored and turned about its middle, then repeated.

    Copies stand side by side in X and above each other in Y, their boxes `spacing` apart.
    """
    turned = _as_turned(part, torch)
    x0, y0, x1, y1 = reach_of(turned)
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
    whole = with_outline(part)
    if torch.mirror == "none" and not torch.rotate:
        return whole
    x0, y0, x1, y1 = reach_of(whole)
    (c, s), (mx, my) = unit_vector(torch.rotate), ((x0 + x1) / 2, (y0 + y1) / 2)
    fx, fy = (-1.0 if torch.mirror == axis else 1.0 for axis in ("x", "y"))
    a, b, d, e = c * fx, -s * fy, s * fx, c * fy
    matrix = (a, b, mx - a * mx - b * my), (d, e, my - d * mx - e * my)
    return replace(whole, features=tuple([_placed(f, matrix) for f in whole.features]))


def _placed(feature: Feature, matrix: Matrix) -> Feature:
    """A feature moved by a matrix that keeps lengths; a contour goes round as it did."""
    if isinstance(feature, Contour):
        is_moved = matrix[0][:2] == (1.0, 0.0) and matrix[1][:2] == (0.0, 1.0)
        curves: list[Curve] = [
            # An arc that is only moved keeps its angles as they are.
            replace(curve, centre=mapped(matrix, curve.centre))
            if is_moved and isinstance(curve, Arc) else curve.transformed(matrix)
            for curve in feature.curves
        ]  # fmt: skip
        notches = [replace(n, corner=mapped(matrix, n.corner)) for n in feature.notches]
        if determinant(matrix) < 0.0:
            last = len(curves) - 1
            curves = [curve.reversed() for curve in reversed(curves)]
            notches = [replace(notch, curve=last - notch.curve) for notch in notches]
        return replace(feature, curves=tuple(curves), notches=tuple(notches))
    if isinstance(feature, Hole | Slot | TextMark):
        x, y = mapped(matrix, (feature.x, feature.y))
        if isinstance(feature, Hole):
            return replace(feature, x=x, y=y)
        angle = direction_deg(mapped_vector(matrix, unit_vector(feature.angle)))
        return replace(feature, x=x, y=y, angle=angle)
    return feature
