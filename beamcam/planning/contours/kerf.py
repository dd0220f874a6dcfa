"""Contours moved off the part by half a kerf, or left to the controller to move."""

from collections.abc import Sequence

from msgspec.structs import replace

from beamcam.errors import Diagnostic
from beamcam.geometry.curves import Arc, Curve, Line, join_boxes, signed_area
from beamcam.machine.machine import Torch
from beamcam.planning.contours import rules
from beamcam.planning.contours.join import Shape

#: What of the machine's tolerance the fitting of arcs may take; the offset and the rounding of
#: coordinates take the rest.
FIT_SHARE = 0.4


def fitted(curves: Sequence[Curve], tolerance: float) -> tuple[Line | Arc, ...]:
    """A chain as lines and arcs, its deviation a share of the machine's tolerance."""
    from beamcam.geometry.arc_fitting import fit_chains

    return fit_chains((curves,), tolerance * FIT_SHARE)[0]


def compensated(
    shapes: Sequence[Shape], kerfs: Sequence[float], torch: Torch
) -> tuple[list[Shape], list[Diagnostic]]:
    """The ways of the torch along the shapes, one for each, and why that cannot be.

    `kerfs` says for each shape what is to be kept off, 0 for nothing. A controller that keeps off
    by itself gets lines and arcs.
    """
    said: list[Diagnostic] = []
    found: list[Shape] = []
    for shape, kerf in zip(shapes, kerfs, strict=True):
        if kerf and torch.kerf_by == "offset":
            rings, refused = offset_shape(shape, kerf, torch.tolerance)
            found += rings
            if refused is not None:
                said.append(refused)
        elif torch.kerf_by == "machine" and shape.process == "cut" and shape.closed:
            found.append(replace(shape, curves=fitted(shape.curves, torch.tolerance)))
        else:
            found.append(shape)
    return found, said


def offset_shape(
    shape: Shape, kerf: float, tolerance: float
) -> tuple[list[Shape], Diagnostic | None]:
    """The contours of a closed cut half a kerf away from the part: outwards, in a hole inwards.

    A hole with a narrow neck gives several. What has no room for the kerf is refused.
    """
    from beamcam.geometry.offset import Vanished, offset_chain

    is_hole = shape.depth % 2 == 1
    curves = fitted(shape.curves, tolerance)
    moved = offset_chain(curves, -kerf / 2 if is_hole else kerf / 2, tolerance * FIT_SHARE)
    if isinstance(moved, Vanished):
        return [], _no_room(shape, kerf)
    chains = [c for c in moved.chains if abs(signed_area(c)) > tolerance * tolerance]
    if not is_hole and len(chains) > 1:
        # A notch narrower than the kerf closes up and leaves a ring: the torch cannot make it.
        return [], _no_room(shape, kerf)
    if is_hole and len(chains) != 1:
        return [], _no_room(shape, kerf)
    return [replace(shape, curves=c, area=signed_area(c)) for c in chains], None


def _no_room(shape: Shape, kerf: float) -> Diagnostic:
    box = join_boxes([c.bbox for c in shape.curves]) or (0.0, 0.0, 0.0, 0.0)
    size = f"{box[2] - box[0]:.3g} x {box[3] - box[1]:.3g}"
    return rules.VANISHED.at(shape.source, found=size, kerf=f"{kerf:g}")


def closes(shape: Shape) -> bool:
    """Whether a contour is a ring with an inside, as an offset needs one."""
    return shape.closed and shape.area != 0.0
