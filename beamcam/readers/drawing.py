"""Shared by the readers of drawings: units of length, contours, and the part that holds them."""

import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain as chained
from itertools import pairwise
from math import pi
from pathlib import PurePath

from msgspec.structs import replace

from beamcam.errors import Diagnostic, Source, error, note, warning
from beamcam.geometry.conics import direction_deg
from beamcam.geometry.curves import Arc, Bezier, BSpline, Curve, EllipseArc, Line, NewtonCurve
from beamcam.geometry.newton import find_oscillation, newton_through, node_error
from beamcam.geometry.plane import MAX_COORDINATE, Matrix, distance, join_boxes
from beamcam.model.part import Contour, Measures, Part, Profile, extent
from beamcam.plain_text import whole_text
from beamcam.readers import Reading

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

OSCILLATION = warning("polynomial-oscillates",
    "found that {found}",
    "Between many nodes a polynomial swings; take fewer nodes, or several curves of up to five.")
NODES_LOST = error("polynomial-lost",
    "found a polynomial through {nodes} nodes that misses them by {found:.3g} mm, expected at most "
    "{expected:g} mm; take fewer nodes",
    "Its values cancel each other until no digit of them is left.")
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


def is_in_bounds(curve: Curve) -> bool:
    """Whether all coordinates of a curve are numbers of at most `MAX_COORDINATE`."""
    match curve:
        case Line():  # as most of a drawing
            (x0, y0), (x1, y1), most = curve.start, curve.end, MAX_COORDINATE
            return abs(x0) <= most and abs(y0) <= most and abs(x1) <= most and abs(y1) <= most
        case Arc():
            angles = curve.start_deg, curve.sweep_deg
            values: Iterable[float] = (*curve.centre, curve.radius, *angles)
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
    closed = bool(curves) and distance(curves[0].start, curves[-1].end) <= ONE_POINT
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
    known: Iterable[str], chosen: Iterable[str], source: Source
) -> tuple[Diagnostic, ...]:
    """An error for each layer that the user named and the drawing has not."""
    names = {name.lower(): name for name in known}
    diagnostics = []
    for name in chosen:
        if name.lower() not in names:
            from difflib import get_close_matches

            near = get_close_matches(name.lower(), names, 1)
            expected = repr(names[near[0]]) if near else ", ".join(map(repr, names.values()))
            diagnostics.append(LAYER_OPTION.at(source, found=name, expected=expected or "none"))
    return tuple(diagnostics)


# --- polynomials through vertices: --fit newton=LAYER ---------------------------------------------

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
        else:
            found = f"no layer {name!r}" if name else "no layer"
            found = f"no polylines on layer {there[name]!r}" if name in there else found
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
    own = [k for k, c in enumerate(contours) if (c.layer or "").lower() == layer.lower()]
    polylines = [k for k in own if is_polyline(contours[k])]
    for k in polylines:
        curves = contours[k].curves
        try:
            fitted = newton_through((curves[0].start, *(curve.end for curve in curves)))
            contours[k] = replace(contours[k], curves=(fitted,))
        except ValueError as error:
            diagnostics.append(FIT_NODES.at(contours[k].source, found=error))
    count, kept = len(polylines) - len(diagnostics), len(own) - len(polylines)
    return [*diagnostics, FITTED.at(source, count=count, layer=layer, kept=kept)]


# --- the unrolled surface of a tube: --wrap -------------------------------------------------------

# Drawings of the unrolled surface of a round tube, read as that tube.
#
# u |  _________________        x runs along the tube, u round it: the width of the outline
#   | |      ( )       /        is the circumference, and its lower edge the lowest line of
#   | |_______________/         the tube, from where face v comes first. Seen from outside.
#   |_____________________ x


#: A diameter and a wall in mm, as RO168.3x8.
_TUBE = re.compile(
    r"\s*(?:RO|CHS|PIPE|TUBE)?\s*([0-9]{1,4}(?:\.[0-9]+)?)\s*[xX*]\s*([0-9]{1,3}(?:\.[0-9]+)?)\s*",
    re.IGNORECASE,
)
SLACK = 1.0  #: mm between the width of an outline and the circumference


def tube_of(name: str) -> Profile | None:
    """A round tube by its diameter and its wall; None where a name has none."""
    size = _TUBE.fullmatch(name)
    if size is None:
        return None
    across, wall = float(size[1]), float(size[2])
    if not 0.0 < 2 * wall < across:
        return None
    return Profile("RO", f"CHS{across:g}*{wall:g}", across, across, wall, wall)


def wrapped(reading: Reading, name: str | None) -> Reading:
    """The parts of a drawing as tubes whose unrolled surface is drawn, where one is named."""
    if name is None or reading.refused:
        return reading
    (part,), tube = reading.parts, tube_of(name)
    if tube is None:
        remark = WRAP_NAME.at(part.source, found=name)
        return replace(reading, parts=(), diagnostics=(*reading.diagnostics, remark))
    part, remark = _round(part, tube)
    return replace(reading, parts=(part,), diagnostics=(*reading.diagnostics, remark))


def _round(part: Part, tube: Profile) -> tuple[Part, Diagnostic]:
    """A drawing as a tube, and what is said of it; as it was where its outline is no surface."""
    turn = pi * tube.height
    boxes = {
        k: box
        for k, f in enumerate(part.features)
        if isinstance(f, Contour) and f.closed and (box := join_boxes([c.bbox for c in f.curves]))
    }
    sizes = {k: (b[2] - b[0], b[3] - b[1]) for k, b in boxes.items()}
    upright = [k for k, (_, high) in sizes.items() if abs(high - turn) <= SLACK]
    lying = [k for k, (wide, _) in sizes.items() if abs(wide - turn) <= SLACK]
    outline = max(upright or lying, key=lambda k: sizes[k][0] * sizes[k][1], default=None)
    if outline is None:
        largest = max(sizes.values(), key=lambda size: size[0] * size[1], default=(0.0, 0.0))
        return part, WRAP_WIDE.at(
            part.source, found=" x ".join(f"{v:.2f}" for v in largest), tube=tube.name,
            expected=f"{turn:.2f}",
        )  # fmt: skip
    x0, y0, x1, _ = boxes[outline]
    moved: Matrix = ((1.0, 0.0, -x0), (0.0, 1.0, -y0))
    if not upright:  # turned clockwise, so that it is no mirror image
        moved = ((0.0, 1.0, -y0), (-1.0, 0.0, x1))
    features = tuple(
        replace(
            f, kind="outer" if k == outline else "inner" if f.closed else f.kind,
            curves=tuple(c.transformed(moved) for c in f.curves),
        )
        if isinstance(f, Contour) else f
        for k, f in enumerate(part.features)
    )  # fmt: skip
    length = sizes[outline][0 if upright else 1]
    wrapped = replace(part, profile=tube, length=length, features=features)
    how = "" if upright else ", turned clockwise by 90 degrees"
    return wrapped, WRAPPED.at(part.source, tube=tube.name, how=how)


#: Name and mm of the values of $INSUNITS. Source: Autodesk DXF reference, HEADER section. Those
#: of astronomy (17 to 20) are left out.
INSUNITS: dict[int, tuple[str, float]] = {
    1: ("inches", 25.4),
    2: ("feet", 304.8),
    3: ("miles", 1_609_344.0),
    4: ("mm", 1.0),
    5: ("cm", 10.0),
    6: ("metres", 1000.0),
    7: ("km", 1_000_000.0),
    8: ("microinches", 25.4e-6),
    9: ("mils", 0.0254),
    10: ("yards", 914.4),
    11: ("angstroms", 1e-7),
    12: ("nm", 1e-6),
    13: ("microns", 0.001),
    14: ("dm", 100.0),
    15: ("dam", 10_000.0),
    16: ("hm", 100_000.0),
    21: ("US survey feet", 1200_000.0 / 3937),
    22: ("US survey inches", 100_000.0 / 3937),
    23: ("US survey yards", 3600_000.0 / 3937),
    24: ("US survey miles", 1200_000.0 / 3937 * 5280),
}
