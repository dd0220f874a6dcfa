"""Cut charts of other programs, as rows of a machine's file.

    [MATERIAL_NUMBER_3]          QtPlasmaC's table of materials, <machine>_material.cfg
    NAME = Mild steel 6mm 45A
    CUT_SPEED = 2300 ...

    [Tool4]                      SheetCam's table of tools, *.tools; lengths in mm
    Tool\\ class=PlasmaTool
    Name=Stainless 1/4 in 65A
    Feed\\ rate=2100 ...

Neither has a thickness or a material of its own: both are read off the name, and so are amperes
that stand nowhere else. Source: LinuxCNC, "QtPlasmaC User Guide", and what its
`qtplasmac-materials` reads of SheetCam.
"""

import re
from collections.abc import Iterator, Mapping
from typing import Any

from beamcam.errors import Diagnostic, Source
from beamcam.machine.torch import ALUMINIUM, MILD_STEEL, STAINLESS
from beamcam.machine.words import CHART

MM_PER_INCH = 25.4
_SECTION = re.compile(r"\[(MATERIAL_NUMBER_|Tool)\s*(\d+)\]", re.IGNORECASE)
_QTPLASMAC = {
    "kerf_width": "kerf", "pierce_height": "pierce_height", "pierce_delay": "pierce_s",
    "cut_height": "cut_height", "cut_speed": "feed_mm_min", "cut_amps": "amps",
    "cut_volts": "volts", "name": "name",
}  # fmt: skip
_SHEETCAM = {
    "kerf width": "kerf", "pierce height": "pierce_height", "pierce delay": "pierce_s",
    "cut height": "cut_height", "feed rate": "feed_mm_min", "preset current": "amps",
    "cut current": "amps", "preset volts": "volts", "cut voltage": "volts", "name": "name",
    "tool class": "class", "tool number": "number",
}  # fmt: skip
_NEEDED = ("feed_mm_min", "pierce_height", "pierce_s", "cut_height")
_MM = re.compile(r"(\d+(?:[.,]\d+)?)\s*mm\b", re.IGNORECASE)
_INCH = re.compile(r"(?:(\d+)/(\d+)|(\d*\.\d+|\d+))\s*(?:in(?:ch)?\b|\")", re.IGNORECASE)
_AMPS = re.compile(r"(\d+)\s*A(?:mps?)?\b", re.IGNORECASE)
_MATERIALS = (
    (STAINLESS, re.compile(r"stainless|inox|edelstahl|\bss\b|\b1\.4\d{3}|\b3(?:04|16)", re.I)),
    (ALUMINIUM, re.compile(r"\balu|\bal\b|almg", re.I)),
    (MILD_STEEL, re.compile(r"mild|carbon|\bms\b|baustahl|\bs235|\bs355|steel|stahl", re.I)),
)

Row = dict[str, Any]


def chart_rows(text: str, name: str) -> tuple[list[Row], list[Diagnostic]]:
    """The rows to cut of a chart, thinnest first, and what is wrong with it.

    A row is the table of a machine's file; `name` is the file, for messages.
    """
    rows: list[Row] = []
    diagnostics: list[Diagnostic] = []
    for line, number, values in _entries(text):
        if "class" in values and "plasma" not in values["class"].casefold():
            continue  # a drill or a mill of SheetCam's
        row = _row(number, values)
        if isinstance(row, dict):
            rows.append(row)
        else:
            found, expected = row
            diagnostics.append(CHART.at(Source(name, line), found=found, expected=expected))
    if not rows and not diagnostics:
        expected = "[MATERIAL_NUMBER_1] of QtPlasmaC or [Tool1] of SheetCam"
        diagnostics.append(CHART.at(Source(name), found="no row to cut", expected=expected))

    def key(row: Row) -> tuple[Any, ...]:
        return row["material"], row["up_to"], row.get("amps", 0.0)

    seen: dict[tuple[Any, ...], str] = {}
    for row in rows:
        if key(row) in seen:
            size = f"{row['material']} up to {row['up_to']:g} mm"
            found, expected = f"two rows of {size}, {seen[key(row)]!r} too", "one, or other amperes"
            diagnostics.append(CHART.at(Source(name), found=found, expected=expected))
        seen[key(row)] = row["nozzle"]
    return sorted(rows, key=key), diagnostics


def _entries(text: str) -> Iterator[tuple[int, int, dict[str, str]]]:
    """Line, number and values of each section of a chart, by our names."""
    names: Mapping[str, str] = {}
    entry: tuple[int, int, dict[str, str]] | None = None
    for line, row in enumerate(text.splitlines(), 1):
        bare = row.strip()
        section = _SECTION.fullmatch(bare)
        if bare.startswith("["):
            if entry is not None:
                yield entry
            entry = (line, int(section[2]), {}) if section else None
            names = _SHEETCAM if section and section[1].casefold() == "tool" else _QTPLASMAC
        elif entry is not None and "=" in bare and not bare.startswith("#"):
            key, _, value = bare.partition("=")
            own = names.get(key.replace("\\", "").strip().casefold())
            if own is not None and (own not in entry[2] or not key.startswith("Preset")):
                entry[2][own] = value.strip()
    if entry is not None:
        yield entry


def _row(number: int, values: Mapping[str, str]) -> Row | tuple[str, str]:
    """The row of a section, or what was found and expected instead."""
    title = values.get("name", "")
    thickness = 0.0
    if match := _MM.search(title):
        thickness = float(match[1].replace(",", "."))
    elif match := _INCH.search(title):
        inches = int(match[1]) / int(match[2]) if match[1] and int(match[2]) else 0.0
        thickness = round((inches or float(match[3] or 0.0)) * MM_PER_INCH, 3)
    material = next((name for name, pattern in _MATERIALS if pattern.search(title)), "")
    if not thickness:
        return f"the row {title!r} without a thickness", "it in the name, as 6 mm or 1/4 in"
    if not material:
        return f"the row {title!r} without a material", "mild steel, stainless or aluminium"
    row: Row = {"process": "cut", "material": material, "up_to": thickness}
    for name in ("feed_mm_min", "kerf", "pierce_height", "pierce_s", "cut_height", "amps", "volts"):
        if name not in values:
            continue
        try:
            row[name] = float(values[name])
        except ValueError:
            return f"{values[name]!r} for {name} of {title!r}", "a number"
        if not 0.0 <= row[name] < 1e6:
            return f"{values[name]} for {name} of {title!r}", "a number from 0 on"
    missing = [k for k in _NEEDED if k not in row or (k != "pierce_s" and not row[k])]
    if missing:
        return f"the row {title!r} without {', '.join(missing)}", "them, above 0"
    if not row.get("amps") and (amps := _AMPS.search(title)):
        row["amps"] = float(amps[1])
    return {**row, "nozzle": title, "number": number}
