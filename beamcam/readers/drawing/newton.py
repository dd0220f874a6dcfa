"""Polylines of a layer as polynomials through their vertices: `--fit newton=LAYER`."""

from collections.abc import Iterator, Sequence

from msgspec.structs import replace

from beamcam.errors import Diagnostic, Source
from beamcam.geometry.curves import Line
from beamcam.geometry.newton import NewtonCurve, find_oscillation, newton_through, node_error
from beamcam.model.part import Contour, Part
from beamcam.readers.content import NODES_LOST, OSCILLATION
from beamcam.readers.drawing import FIT_LAYER, FIT_NODES, FITTED, drawing_part

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
                    contour.source, nodes=len(curve.nodes), found=error, expected=MAX_NODE_ERROR,
                )  # fmt: skip
            elif (oscillation := find_oscillation(curve)) is not None:
                yield OSCILLATION.at(contour.source, found=oscillation)


def fit_newton(part: Part, layers: Sequence[str]) -> tuple[Part, tuple[Diagnostic, ...]]:
    """The part of a drawing with a polynomial for each polyline on `layers`, and what is said.

    Where x rises or falls from vertex to vertex y is a polynomial of x; elsewhere both are
    polynomials of the length of the chords. Layers are named without regard to case; "" and a
    layer without polylines are errors.
    """
    if not layers:
        return part, ()
    there = {c.layer.lower(): c.layer for c in part.contours if c.layer is not None}
    with_polylines = {(c.layer or "").lower() for c in part.contours if is_polyline(c)}
    diagnostics: list[Diagnostic] = []
    contours = list(part.contours)
    for name in dict.fromkeys(layer.lower() for layer in layers):
        if name in there and name in with_polylines:
            diagnostics += _fit_layer(contours, there[name], part.source)
            continue
        found = f"no layer {name!r}" if name else "no layer"
        if name in there:
            found = f"no polylines on layer {there[name]!r}"
        expected = ", ".join(map(repr, there.values())) or "none"
        diagnostics.append(FIT_LAYER.at(part.source, found=found, expected=expected))
    measures = part.measures
    assert measures is not None
    made = drawing_part(part.source.file, tuple(contours), measures)
    return made, (*diagnostics, *checked_polynomials(made))


def is_polyline(contour: Contour) -> bool:
    """Whether a contour is two lines or more and nothing else."""
    return len(contour.curves) > 1 and all(isinstance(c, Line) for c in contour.curves)


def _fit_layer(contours: list[Contour], layer: str, source: Source) -> list[Diagnostic]:
    """Replaces the polylines of one layer in `contours`; what is said about it."""
    diagnostics: list[Diagnostic] = []
    count = kept = 0
    for k, contour in enumerate(contours):
        if (contour.layer or "").lower() != layer.lower():
            continue
        if not is_polyline(contour):
            kept += 1
            continue
        nodes = (contour.curves[0].start, *(curve.end for curve in contour.curves))
        try:
            contours[k] = replace(contour, curves=(newton_through(nodes),))
        except ValueError as error:
            diagnostics.append(FIT_NODES.at(contour.source, found=error))
            continue
        count += 1
    diagnostics.append(FITTED.at(source, count=count, layer=layer, kept=kept))
    return diagnostics
