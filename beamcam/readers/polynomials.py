"""Diagnostics of a part's polynomials: those that oscillate, and those that are lost."""

from collections.abc import Iterator

from beamcam.errors import Diagnostic
from beamcam.geometry.newton import NewtonCurve, find_oscillation, node_error
from beamcam.model.part import Part
from beamcam.readers.rules import NODES_LOST, OSCILLATION

#: A polynomial that misses its nodes by more, in mm, is another curve than was asked for.
MAX_NODE_ERROR = 1e-6


def checked_polynomials(part: Part) -> Iterator[Diagnostic]:
    """A warning for each polynomial that oscillates between its nodes, with how far; an error for
    each that arithmetic does not bring through them."""
    for contour in part.contours:
        for curve in contour.curves:
            if not isinstance(curve, NewtonCurve):
                continue
            error = node_error(curve)
            if not error <= MAX_NODE_ERROR:
                yield NODES_LOST.at(
                    contour.source,
                    nodes=len(curve.nodes),
                    found=error,
                    expected=MAX_NODE_ERROR,
                )
            elif (found := find_oscillation(curve)) is not None:
                yield OSCILLATION.at(contour.source, found=found)
