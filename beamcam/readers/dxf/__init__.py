"""The DXF reader: every curve of model space, exact, in mm."""

import re
from collections.abc import Sequence
from typing import Any

from msgspec import Struct
from msgspec.structs import replace

from beamcam.errors import Diagnostic, ReadError, Source
from beamcam.model.part import Measures, Part
from beamcam.readers import Reading
from beamcam.readers.drawing import (
    MM_PER_UNIT,
    UNITS_OPTION,
    counted,
    drawing_part,
    fit_newton,
    unknown_layers,
    verdict,
    wrapped,
)
from beamcam.readers.dxf import rules
from beamcam.readers.dxf.curves import scaled
from beamcam.readers.dxf.layers import Document, Layers, LayerStyle
from beamcam.readers.dxf.load import is_binary, load_document, looks_like
from beamcam.readers.dxf.walk import DrawingContent, DrawingWalk

__all__ = ["RULES", "looks_like", "read"]

RULES = rules.RULES


#: Heights that differ by less are noise of the writer: files carry 1e-9 to 1e-7.
FLAT = 1e-3


def read(
    data: bytes,
    name: str,
    units: str | None = None,
    layers: Sequence[str] = (),
    fit: Sequence[str] = (),
    letters: Sequence[str] = (),
    wrap: str | None = None,
) -> Reading:
    """The part that a DXF file draws in model space, and the remarks; never raises.

    `units` ("mm", "in", ...) overrides what the file says about its unit. `layers` names the
    layers to read, hidden ones too; by default those that are visible and plot. `fit` names layers
    whose polylines and splines by fit points become polynomials through their vertices, `letters`
    those whose texts are to be lettered. `wrap` names the tube whose unrolled surface is drawn.
    """
    source = Source(name)
    unit, diagnostics = find_unit(data, units, source)
    if unit is None:
        return Reading("dxf", (), diagnostics)
    try:
        loaded = load_document(data, source)
    except ReadError as error:
        return Reading("dxf", (), error.diagnostics)
    chosen = Layers(loaded.tables, _folded(layers) or None)
    diagnostics += (*loaded.remarks, *unknown_layers(chosen.names(), layers, source))
    runs, frame = iter(loaded.runs), scaled(unit.mm)
    walk = DrawingWalk(name, chosen, loaded.handles, runs, _folded(fit), _folded(letters))
    try:
        if loaded.document is None:
            walk.run(next(runs), frame)
        else:
            walk.entities(loaded.document.modelspace(), frame, LayerStyle(), ())
    except ReadError as error:
        return Reading("dxf", (), diagnostics + error.diagnostics)
    collected = walk.found
    part, fitted = _part(name, collected, fit)
    seen = sorted([*collected.not_cut.items(), ("hidden curves", collected.hidden_on.total())])
    diagnostics += (
        *contradictions(loaded.document, unit, name),
        *collected.diagnostics,
        *fitted,
        *_remarks(collected, source),
        *verdict(part, seen, None if unit.given else unit.name, source),
    )
    return wrapped(Reading("dxf", (part,), diagnostics), wrap)


def _folded(names: Sequence[str]) -> frozenset[str]:
    return frozenset(name.lower() for name in names)


def _part(
    name: str, collected: DrawingContent, fit: Sequence[str]
) -> tuple[Part, tuple[Diagnostic, ...]]:
    """The part of a drawing, polylines on the layers of `fit` as polynomials; what is said."""
    not_cut = tuple(sorted(collected.not_cut.items()))
    lettered = tuple(sorted(collected.lettered.items()))
    dashed = tuple(collected.dashed.values())
    measures = Measures((), tuple(collected.hidden), not_cut, lettered=lettered, dashed=dashed)
    part, fitted = fit_newton(drawing_part(name, tuple(collected.contours), measures), fit)
    return replace(part, features=(*part.features, *collected.texts)), fitted


def _remarks(collected: DrawingContent, source: Source) -> list[Diagnostic]:
    """Remarks on entities that are not contours, by kind and count."""
    by_kind = (
        (rules.NOT_CUT, collected.not_cut),
        (rules.EDGE_ON, collected.edge_on),
        (rules.EMPTY_CURVES, collected.empty),
        (rules.HIDDEN, collected.hidden_on),
    )
    diagnostics = [
        rule.at(source, count=counts.total(), found=counted(sorted(counts.items())))
        for rule, counts in by_kind
        if counts
    ]
    if collected.heights:
        low, high = min(collected.heights), max(collected.heights)
        if high - low > FLAT:
            diagnostics.append(rules.NOT_FLAT.at(source, low=low, high=high))
    return diagnostics


# --- units ----------------------------------------------------------------------------------------

# Unit of length of a DXF file, from its own data.
#
# ezdxf invents `$INSUNITS` 6 (metres) for files without a header, so that the raw text is asked.


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

_NL = rb"[ \t]*(?:\r\n|\r|\n)[ \t]*"


class LengthUnit(Struct, frozen=True):
    """The unit of a drawing's numbers."""

    name: str
    mm: float
    given: bool = False  #: by the user: what the file says about it does not count


def header_number(data: bytes, variable: str) -> int | None:
    """The whole number that the header gives to `variable` (group 70); None if it does not.

    Of a number of more digits than any variable has the first nine.
    """
    name = re.escape(variable.encode("ascii"))
    if is_binary(data):
        # Group codes are two bytes since R13, and the values of group 70 too.
        match = re.search(rb"\x09\x00" + name + rb"\x00\x46\x00(..)", data, re.DOTALL)
        return None if match is None else int.from_bytes(match[1], "little", signed=True)
    end = data.find(b"ENDSEC")
    text = data[: end if end >= 0 else len(data)]
    match = re.search(
        rb"(?:^|[\r\n])[ \t]*9" + _NL + name + _NL + rb"70" + _NL + rb"(-?\d{1,9})", text
    )
    return None if match is None else int(match[1])


def find_unit(
    data: bytes, units: str | None, source: Source
) -> tuple[LengthUnit | None, tuple[Diagnostic, ...]]:
    """The unit of a file, or the one that the user gave; None with an error if there is none."""
    if units is not None:
        mm = MM_PER_UNIT.get(units.lower())
        if mm is None:
            expected = ", ".join(MM_PER_UNIT)
            return None, (UNITS_OPTION.at(source, found=units, expected=expected),)
        return LengthUnit(units.lower(), mm, given=True), ()
    code = header_number(data, "$INSUNITS")
    if code is None or code == 0:
        return LengthUnit("mm", 1.0), (rules.UNITS_MISSING.at(source, found=_missing(data, code)),)
    if code not in INSUNITS:
        expected = ", ".join(f"{c} {name}" for c, (name, _) in INSUNITS.items() if c <= 6)
        return None, (rules.UNITS_UNKNOWN.at(source, found=code, expected=expected),)
    unit = LengthUnit(*INSUNITS[code])
    shown = header_number(data, "$LUNITS")
    if shown in (3, 4) and unit.mm not in (25.4, 304.8):
        return unit, (rules.UNITS_IMPERIAL.at(source, found=shown, unit=unit.name),)
    return unit, ()


def _missing(data: bytes, code: int | None) -> str:
    text = "no $INSUNITS" if code is None else "$INSUNITS 0 (no unit)"
    if header_number(data, "$MEASUREMENT") == 0:
        return text + " but $MEASUREMENT 0 (inches)"
    return text


# --- what dimensions say --------------------------------------------------------------------------

_STATED = re.compile(r"(\d+(?:[.,]\d+)?)\s*(mm|cm|m|inch(?:es)?|in|ft|\"|″|')\.?\Z", re.IGNORECASE)
_WORDS = {"inch": 25.4, "inches": 25.4, '"': 25.4, "″": 25.4, "'": 304.8}
_FORMATTING = re.compile(r"\\[A-Za-z][^;\\]*;|[{}]")


def contradictions(
    document: Document | None, unit: LengthUnit, name: str
) -> tuple[Diagnostic, ...]:
    """An error for the first dimension that names a length in a unit which denies `unit`.

    A dimension measures in drawing units and may show its length with a unit, written by hand
    ("100 mm") or appended by its style. If both differ by the factor between two units, the
    drawing was scaled or its header is wrong. Other differences are no matter of units.
    """
    if unit.given or document is None:
        return ()
    for dimension in document.modelspace().query("DIMENSION"):
        stated = _stated_length(dimension)
        if stated is None:
            continue
        text, length, measured = stated
        size = measured * unit.mm
        if size > 0.0 and _is_unit_factor(length / size):
            return (
                rules.UNITS_CONTRADICT.at(
                    Source(name, None, dimension.dxf.handle),
                    stated=text,
                    measured=measured,
                    unit=unit.name,
                    size=size,
                ),
            )
    return ()


def _stated_length(dimension: Any) -> tuple[str, float, float] | None:
    """Text, mm that it states, and measure in drawing units; None if it names no unit."""
    measured = dimension.dxf.get("actual_measurement")
    if not measured or not 0.0 < measured < 1e9:
        return None
    text = _FORMATTING.sub("", dimension.dxf.get("text", "") or "<>").strip()
    if "<>" in text:
        style = dimension.override()
        shown = measured * float(style.get("dimlfac", 1.0) or 1.0)
        post = str(style.get("dimpost", "") or "")
        text = text.replace("<>", (post if "<>" in post else "<>" + post))
        text = text.replace("<>", f"{shown:.9f}")
    match = _STATED.match(text)
    if match is None:
        return None
    word = match[2].lower()
    mm = _WORDS.get(word) or MM_PER_UNIT[word]
    return text, float(match[1].replace(",", ".")) * mm, measured


def _is_unit_factor(factor: float) -> bool:
    sizes = (1.0, 10.0, 25.4, 304.8, 1000.0)
    known = {a / b for a in sizes for b in sizes if a != b}
    return any(abs(factor / k - 1.0) < 0.01 for k in known)
