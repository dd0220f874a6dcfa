"""Contours moved off the part by half a kerf, or left to the controller to move."""

from collections.abc import Sequence

from msgspec.structs import replace

from beamcam.errors import Diagnostic
from beamcam.geometry.curves import Arc, Line, join_boxes
from beamcam.machine.machine import Torch
from beamcam.planning.contours import rules
from beamcam.planning.contours.shape import Shape

#: What of the machine's tolerance the fitting of arcs may take; the offset and the rounding of
#: coordinates take the rest.
FIT_SHARE = 0.4


def compensated(
    shapes: Sequence[Shape], kerfs: Sequence[float], torch: Torch
) -> tuple[list[Shape], list[Diagnostic]]:
    """The ways of the torch along the shapes, one for each, and why that cannot be.

    `kerfs` says for each shape what is to be kept off, 0 for nothing. By offset the contours lie
    half of it away from the part: outwards, in a hole inwards. A controller that keeps off by
    itself gets lines and arcs.
    """
    found = list(shapes)
    by_machine = torch.kerf_by == "machine"
    which = [
        k
        for k, (shape, kerf) in enumerate(zip(shapes, kerfs, strict=True))
        if (by_machine and shape.process == "cut" and shape.closed)
        or (kerf and torch.kerf_by == "offset")
    ]
    if not which:
        return found, []
    from beamcam.geometry.arc_fitting import fit_chains

    fits = fit_chains([shapes[k].curves for k in which], torch.tolerance * FIT_SHARE)
    if by_machine:
        for k, curves in zip(which, fits, strict=True):
            found[k] = replace(shapes[k], curves=curves)
        return found, []
    said: list[Diagnostic] = []
    rings = _moved([shapes[k] for k in which], fits, [kerfs[k] for k in which], torch.tolerance)
    for k, ring in zip(which, rings, strict=True):
        if ring is None:
            said.append(_no_room(shapes[k], kerfs[k]))
        else:
            found[k] = ring
    return found, said


def _moved(
    shapes: Sequence[Shape],
    fits: Sequence[tuple[Line | Arc, ...]],
    kerfs: Sequence[float],
    tolerance: float,
) -> list[Shape | None]:
    """The shapes half a kerf away from the part; None for what has no room for the kerf.

    A notch narrower than the kerf closes up and leaves a ring, a hole with a narrow neck falls
    into several: the torch cannot make the one nor the other.
    """
    from beamcam.geometry.offset import Vanished, offset_chains

    amounts = [
        -kerf / 2 if shape.is_hole else kerf / 2 for shape, kerf in zip(shapes, kerfs, strict=True)
    ]
    moved = offset_chains(fits, amounts, tolerance * FIT_SHARE)
    found: list[Shape | None] = []
    for shape, offset in zip(shapes, moved, strict=True):
        sized = (
            [] if isinstance(offset, Vanished) else zip(offset.chains, offset.areas, strict=True)
        )
        rings = [(chain, area) for chain, area in sized if abs(area) > tolerance * tolerance]
        one = len(rings) == 1
        found.append(replace(shape, curves=rings[0][0], area=rings[0][1]) if one else None)
    return found


def _no_room(shape: Shape, kerf: float) -> Diagnostic:
    box = join_boxes([c.bbox for c in shape.curves]) or (0.0, 0.0, 0.0, 0.0)
    size = f"{box[2] - box[0]:.3g} x {box[3] - box[1]:.3g}"
    return rules.VANISHED.at(shape.source, found=size, kerf=f"{kerf:g}")


def closes(shape: Shape) -> bool:
    """Whether a contour is a ring with an inside, as an offset needs one."""
    return shape.closed and shape.area != 0.0
