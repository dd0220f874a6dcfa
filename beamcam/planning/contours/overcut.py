"""Overcuts: closed cuts go on along their contour, so that nothing is left where they close."""

from beamcam.machine.torch import Torch
from beamcam.planning.contours.direction import Curves, stretch
from beamcam.planning.contours.look_settings import PLAIN
from beamcam.planning.contours.outline import Shape, stretches_of

ROUNDING = 1e-6


def overcut_length(shape: Shape, torch: Torch) -> float:
    """The overcut that is asked of a contour: of its colour or layer, of small holes, or of all."""
    if shape.process != "cut" or not shape.is_ring:
        return 0.0
    own = torch.settings.get(shape.look, PLAIN).overcut
    if own is None and shape.is_small:
        own = torch.hole_overcut
    return torch.overcut if own is None else own


def overcut(shape: Shape, kerf: float, torch: Torch) -> Curves:
    """The stretch of a closed contour that is cut again at its end, none without an overcut.

    It is at most half of the way to the first bridge, or of the
    contour where there is none.
    """
    asked = overcut_length(shape, torch)
    if not asked:
        return ()
    first = stretches_of(shape, kerf, torch)[0]
    lengths = [curve.length for curve in first]
    return stretch(first, lengths, 0.0, min(asked, sum(lengths) / 2))


def is_shortened(shape: Shape, kerf: float, torch: Torch) -> bool:
    """Whether a contour has too little room for its overcut."""
    asked = overcut_length(shape, torch)
    if not asked:
        return False
    first = stretches_of(shape, kerf, torch)[0]
    return sum(curve.length for curve in first) / 2 < asked - ROUNDING
