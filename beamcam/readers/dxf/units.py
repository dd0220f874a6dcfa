"""Unit of length of a DXF file, from its own data.

ezdxf invents `$INSUNITS` 6 (metres) for files without a header, so that the raw text is asked.
"""

import re
from typing import Any

from msgspec import Struct

from beamcam.errors import Diagnostic, Source
from beamcam.readers.drawing import MM_PER_UNIT
from beamcam.readers.drawing.rules import UNITS_OPTION
from beamcam.readers.dxf import rules
from beamcam.readers.dxf.layers import Document
from beamcam.readers.dxf.load import is_binary

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
        found = re.search(rb"\x09\x00" + name + rb"\x00\x46\x00(..)", data, re.DOTALL)
        return None if found is None else int.from_bytes(found[1], "little", signed=True)
    end = data.find(b"ENDSEC")
    text = data[: end if end >= 0 else len(data)]
    found = re.search(
        rb"(?:^|[\r\n])[ \t]*9" + _NL + name + _NL + rb"70" + _NL + rb"(-?\d{1,9})", text
    )
    return None if found is None else int(found[1])


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
    said = "no $INSUNITS" if code is None else "$INSUNITS 0 (no unit)"
    if header_number(data, "$MEASUREMENT") == 0:
        return said + " but $MEASUREMENT 0 (inches)"
    return said


# --- what dimensions say --------------------------------------------------------------------------

_STATED = re.compile(r"(\d+(?:[.,]\d+)?)\s*(mm|cm|m|inch(?:es)?|in|ft|\"|″|')\.?\Z", re.IGNORECASE)
_WORDS = {"inch": 25.4, "inches": 25.4, '"': 25.4, "″": 25.4, "'": 304.8}
_FORMATTING = re.compile(r"\\[A-Za-z][^;\\]*;|[{}]")


def contradictions(document: Document, unit: LengthUnit, name: str) -> tuple[Diagnostic, ...]:
    """An error for the first dimension that names a length in a unit which denies `unit`.

    A dimension measures in drawing units and may show its length with a unit, written by hand
    ("100 mm") or appended by its style. If both differ by the factor between two units, the
    drawing was scaled or its header is wrong. Other differences are no matter of units.
    """
    if unit.given:
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
    found = _STATED.match(text)
    if found is None:
        return None
    word = found[2].lower()
    mm = _WORDS.get(word) or MM_PER_UNIT[word]
    return text, float(found[1].replace(",", ".")) * mm, measured


def _is_unit_factor(factor: float) -> bool:
    sizes = (1.0, 10.0, 25.4, 304.8, 1000.0)
    known = {a / b for a in sizes for b in sizes if a != b}
    return any(abs(factor / k - 1.0) < 0.01 for k in known)
