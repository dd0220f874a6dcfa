"""Shared by the readers of drawings: units of length, contours, and the part that holds them."""

import re
from collections.abc import Iterable, Sequence
from itertools import chain as chained
from itertools import pairwise
from math import hypot
from pathlib import PurePath

from beamcam.errors import Diagnostic, Source, error, note, warning
from beamcam.geometry.conics import direction_deg
from beamcam.geometry.curves import Arc, Bezier, BSpline, Curve, EllipseArc, Line, NewtonCurve
from beamcam.geometry.plane import MAX_COORDINATE
from beamcam.model.part import Contour, Measures, Part, Profile, extent
from beamcam.plain_text import whole_text

# fmt: off

UNITS_OPTION = error("drawing-units-option",
    "found unit {found!r}, expected one of {expected}",
    "The option --units names the unit of the drawing's numbers.")
WIDTH_OPTION = error("drawing-width-option",
    "found width {found!r}, expected a length above 0 such as 600mm or 24in",
    "The option --width gives the width of the page, where the file does not say it.")
LAYER_OPTION = error("drawing-layer-option",
    "found no layer {found!r}; expected one of the drawing's: {expected}",
    "The option --layers names the layers to read; a misspelt name would lose a part of them.")
NO_CURVES = error("drawing-empty",
    "found no curve that a tool could follow ({found}), expected at least one",
    "Everything is text, hidden, or on a sheet of paper space, or the export went wrong.")
TOO_LARGE = warning("drawing-large",
    "found a drawing of {width:.0f} x {height:.0f} mm in the unit {unit}; check the unit, --units "
    "overrides it",
    "Programs write metres as their default unit into drawings that are meant in mm.")
FIT_LAYER = error("drawing-fit-layer",
    "found {found}, expected --fit newton=LAYER with polylines on one of the layers {expected}",
    "The option --fit names the layers whose polylines are the nodes of polynomials.")
FIT_NODES = error("drawing-fit-nodes",
    "found a polyline that is no polynomial ({found}), expected vertices apart from each other",
    "A polynomial needs a place of its own for each of its nodes.")
FITTED = note("drawing-fitted",
    "found {count} polylines on layer {layer!r}, now polynomials through their vertices; {kept} "
    "other contours there stay as they are drawn",
    "This is what --fit newton=LAYER asked for; single lines and polylines with arcs are kept.")

WRAP_NAME = error("drawing-wrap-option",
    "found the tube {found!r}; expected its diameter and its wall in mm, as RO168.3x8",
    "The option --wrap names the round tube whose unrolled surface is drawn.")
WRAP_WIDE = error("drawing-wrap",
    "found a largest outline of {found} mm; expected one {expected} mm wide, the circumference of "
    "{tube}",
    "--wrap takes a drawing as the unrolled surface of a tube: one closed outline of all of it, as "
    "wide as the tube is round, and what is cut out of it. Another unit (--units) or another tube "
    "is meant.")
WRAPPED = note("drawing-wrapped",
    "taken as the unrolled outside of {tube}{how}: x along it, y round it from its lowest line",
    "This is what --wrap asked for. All that is closed is cut out; --layers leaves other lines.")


# fmt: on


#: Millimetres in a unit, by the words of `--units` and `--width`.
MM_PER_UNIT = {
    "um": 0.001, "mil": 0.0254, "q": 0.25, "mm": 1.0, "cm": 10.0, "dm": 100.0, "in": 25.4,
    "ft": 304.8, "yd": 914.4, "m": 1000.0, "pt": 25.4 / 72, "pc": 25.4 / 6, "px72": 25.4 / 72,
    "px90": 25.4 / 90, "px96": 25.4 / 96,
}  # fmt: skip

#: Ends of a chain that are nearer than this are one point; files carry 1e-6 mm and coarser.
ONE_POINT = 1e-9

#: A sheet larger than this leaves every machine: a sign that the unit is not what it says.
LARGEST_SIZE = 50_000.0

_LENGTH = re.compile(
    r"\s*+([+-]?(?:\d++\.?\d*+|\.\d++)(?:[eE][+-]?\d++)?)\s*+([a-zA-Z%]*+\d*+)\s*+\Z"
)


def split_length(text: str) -> tuple[float, str]:
    """Number and unit of "24in", "100 %", "3": the unit in lower case, "" if there is none.

    Raises ValueError if it is no such text.
    """
    match = _LENGTH.match(text)
    if match is None:
        raise ValueError(f"found {text!r}, expected a number and a unit")
    number = float(match[1])
    if abs(number) > MAX_COORDINATE:
        raise ValueError(f"found {text!r}, expected a number of at most {MAX_COORDINATE:g}")
    return number, match[2].lower()


def joined(chain: Sequence[Curve]) -> bool:
    """Whether the end of a chain is its start."""
    if not chain:
        return False
    (x0, y0), (x1, y1) = chain[0].start, chain[-1].end
    return hypot(x1 - x0, y1 - y0) <= ONE_POINT


def is_in_bounds(curve: Curve) -> bool:
    """Whether all coordinates of a curve are numbers of at most `MAX_COORDINATE`."""
    match curve:
        case Line():
            values: Iterable[float] = (*curve.start, *curve.end)
        case Arc():
            values = (*curve.centre, curve.radius, curve.start_deg, curve.sweep_deg)
        case EllipseArc():
            values = (*curve.centre, *curve.axis, curve.ratio, curve.start_deg, curve.sweep_deg)
        case Bezier():
            values = chained.from_iterable(curve.points)
        case BSpline():
            values = chained(chained.from_iterable(curve.control), curve.knots, curve.weights or ())
        case NewtonCurve():
            values = chained.from_iterable(curve.nodes)
    # Of nan the comparison is false.
    return all(map(MAX_COORDINATE.__ge__, map(abs, values)))


def lines_through(points: Iterable[tuple[float, float]]) -> tuple[Line, ...]:
    """Lines from point to point, without those of no length."""
    return tuple(Line(a, b) for a, b in pairwise(points) if a != b)


def round_if_circle(curve: EllipseArc) -> Arc | EllipseArc:
    """The arc that an ellipse of equal axes is, else the ellipse."""
    if curve.ratio < 1.0 - 1e-12:
        return curve
    return Arc(
        curve.centre, curve.major, direction_deg(curve.axis) + curve.start_deg, curve.sweep_deg
    )


def as_contour(
    curves: tuple[Curve, ...], source: Source, layer: str | None, colour: str | None
) -> Contour:
    """A chain as it was drawn; one that ends where it starts is closed."""
    closed = joined(curves)
    return Contour(
        face="v", kind="outer" if closed else "open", curves=curves, source=source, closed=closed,
        layer=layer, colour=colour,
    )  # fmt: skip


def drawing_part(name: str, contours: tuple[Contour, ...], measures: Measures) -> Part:
    """A sheet of unknown thickness, as large as its contours, marked as the file is called."""
    box = extent(curve for contour in contours for curve in contour.curves)
    x0, y0, x1, y1 = box or (0.0, 0.0, 0.0, 0.0)
    profile = Profile("B", "", y1 - y0, 0.0, 0.0, None)
    mark = whole_text(PurePath(name).stem)
    return Part(mark, profile, x1 - x0, Source(name), features=contours, measures=measures)


def counted(counts: Iterable[tuple[str, int]]) -> str:
    """ "3 TEXT, 1 HATCH"; "nothing else" if there is nothing."""
    return ", ".join(f"{count} {name}" for name, count in counts if count) or "nothing else"


def verdict(
    part: Part, seen: Iterable[tuple[str, int]], unit: str | None, source: Source
) -> list[Diagnostic]:
    """An error for a drawing without curves, a warning for one that no machine could hold.

    `seen` says what there is in place of curves; `unit` is None where the user gave it.
    """
    if not part.features and not (part.measures and part.measures.filled):
        return [NO_CURVES.at(source, found=counted(seen))]
    width, height = part.length, part.profile.height
    if max(width, height) > LARGEST_SIZE and unit is not None:
        return [TOO_LARGE.at(source, width=width, height=height, unit=unit)]
    return []


def unknown_layers(
    known: Iterable[str], selected: Iterable[str], source: Source
) -> tuple[Diagnostic, ...]:
    """An error for each layer that the user named and the drawing has not."""
    names = {name.lower(): name for name in known}
    diagnostics = []
    for name in selected:
        if name.lower() not in names:
            from difflib import get_close_matches

            near = get_close_matches(name.lower(), names, 1)
            expected = repr(names[near[0]]) if near else ", ".join(map(repr, names.values()))
            diagnostics.append(LAYER_OPTION.at(source, found=name, expected=expected or "none"))
    return tuple(diagnostics)
