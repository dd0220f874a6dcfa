"""The rows of a DXF file and its tables; layer, colour and visibility of an entity by them.

What an entity does not say it inherits through the inserts above it.
"""

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from msgspec import Struct, field
from numpy.typing import NDArray

#: Group codes: names of tables and entries, of entities (handles), subclasses, brackets.
NAME, HANDLE, SUBCLASS, BRACKET, VARIABLE, COMMENT = 2, 5, 100, 102, 9, 999


class Rows(Struct, frozen=True):
    """All lines, the group code of each row, and where entities begin."""

    lines: list[str]
    codes: NDArray[np.int32]
    starts: list[int]  #: the rows of group 0
    sections: dict[str, range]  #: which of `starts` stand in each that is there just once

    def value(self, row: int) -> str:
        return self.lines[2 * row + 1]

    def kind(self, entity: int) -> str:
        """The kind of an entity by its place among `starts`."""
        return self.value(self.starts[entity])

    def sequences(self, entities: Iterable[int]) -> Iterator[tuple[int, int, bytes]]:
        """First row, the row behind the last, and the group codes of entities as bytes."""
        codes, starts, size = self.codes.tobytes(), self.starts, self.codes.itemsize
        for k in entities:
            first, last = starts[k], starts[k + 1]
            yield first, last, codes[size * first : size * last]


def rows_of(text: str) -> Rows | None:
    """The rows of a text up to EOF; None if they are not two lines each, or if EOF is missing."""
    lines = text.rstrip().split("\n")
    if len(lines) % 2 or lines[-1] != "EOF":
        return None
    texts = lines[::2]
    try:
        numbers = {text: int(text) for text in set(texts)}
        codes = np.fromiter(map(numbers.__getitem__, texts), np.int32, len(texts))
    except (ValueError, OverflowError):
        return None
    starts: list[int] = np.flatnonzero(codes == 0).tolist()
    ends = [k for k in starts if lines[2 * k + 1] == "EOF"]
    if ends != [len(texts) - 1]:
        return None
    sections: dict[str, list[range]] = {}
    name = ""
    for k, row in enumerate(starts):
        kind = lines[2 * row + 1].strip()
        if kind == "SECTION":
            name, begin = lines[2 * row + 3] if codes[row + 1] == NAME else "", k + 1
        elif kind == "ENDSEC" and name:
            sections.setdefault(name, []).append(range(begin, k))
            name = ""
    once = {name: places[0] for name, places in sections.items() if len(places) == 1}
    return Rows(lines, codes, starts, once)


# --- layers ---------------------------------------------------------------------------------------

Document = Any  #: of ezdxf, which publishes no types that mypy can follow

# Values of group 62. Source: Autodesk DXF reference, "Common group codes for entities".
BYBLOCK, BYLAYER = 0, 256
#: Line types without gaps, and those that are another's (group 6), in upper case.
CONTINUOUS = ("", "CONTINUOUS")
TYPE_BY_BLOCK, TYPE_BY_LAYER = "BYBLOCK", "BYLAYER"

#: The colour of what says none anywhere: number 7, white on a dark screen.
WHITE = "#ffffff"


class Attributes(Struct, frozen=True):
    """An entity's own display attributes."""

    layer: str = "0"
    colour: int = BYLAYER  #: number in AutoCAD's palette, or one of the two above
    true_colour: int | None = None  #: 0xrrggbb
    invisible: bool = False  #: group 60
    line_type: str = TYPE_BY_LAYER


class LayerStyle(Struct, frozen=True):
    """Resolved display attributes of an entity, inherited by its content if it is an insert."""

    layer: str = "0"
    colour: str = WHITE  #: "#rrggbb"
    invisible: bool = False  #: switched off itself (group 60), or in an insert that is
    line_type: str = ""  #: one with gaps, as a centre line has it; empty for a line without


# --- tables ---------------------------------------------------------------------------------------

# Group codes of entries. Source: Autodesk DXF reference, TABLES section.
COLOUR, TRUE_COLOUR, LINE_TYPE, FLAGS, PLOT, DASH = 62, 420, 6, 70, 290, 49
FROZEN = 1  #: of the flags
#: The class that an entry names behind that of all entries; R12 has none.
_CLASSES = {
    "LAYER": "AcDbLayerTableRecord",
    "LTYPE": "AcDbLinetypeTableRecord",
    "BLOCK_RECORD": "AcDbBlockTableRecord",
}


class TableLayer(Struct, frozen=True):
    """A layer as the table has it."""

    name: str
    colour: int = 7  #: number in AutoCAD's palette
    true_colour: int | None = None  #: 0xrrggbb
    line_type: str = ""
    hidden: bool = False  #: off, frozen or not plotting


_UNKNOWN = TableLayer("")  #: white, and shown


class Tables(Struct, frozen=True):
    """Layers, and which line types have gaps, by their names in lower case."""

    layers: dict[str, TableLayer]
    has_gaps: dict[str, bool]
    model_space: str  #: handle of its block record


def tables_of(document: Document) -> Tables:
    """The tables of a document of ezdxf."""
    layers = [
        TableLayer(
            layer.dxf.name, abs(layer.dxf.get("color", 7)), layer.dxf.get("true_color"),
            str(layer.dxf.get("linetype", "")),
            bool(layer.is_off() or layer.is_frozen() or not layer.dxf.get("plot", 1)),
        )
        for layer in document.layers
    ]  # fmt: skip
    has_gaps = {
        kind.dxf.name.lower(): any(tag.code == DASH for tag in kind.pattern_tags.tags)
        for kind in document.linetypes
    }
    space = str(document.modelspace().layout_key)
    return Tables({layer.name.lower(): layer for layer in layers}, has_gaps, space)


def tables_by_rows(rows: Rows, r12: bool) -> Tables | None:
    """The tables of a sound file; None where an entry is one for ezdxf."""
    entries = {kind: _entries(rows, kind, r12) for kind in _CLASSES}
    try:
        layers = {name: _layer(entry) for name, entry in entries["LAYER"].items()}
    except ValueError:
        return None
    layers.setdefault("0", TableLayer("0"))
    layers.setdefault("defpoints", TableLayer("Defpoints"))
    has_gaps = {name: DASH in entry for name, entry in entries["LTYPE"].items()}
    space = entries["BLOCK_RECORD"].get("*model_space", {}).get(HANDLE, [""])[0]
    is_odd = any("" in names for names in entries.values())
    return None if is_odd else Tables(layers, has_gaps, space)


def _entries(rows: Rows, kind: str, r12: bool) -> dict[str, dict[int, list[str]]]:
    """The values of a table's entries by group code, by names in lower case.

    The name is empty of one that is not as it should be, or has another's.
    """
    entries: dict[str, dict[int, list[str]]] = {}
    for k in rows.sections.get("TABLES", ()):
        if rows.kind(k) != kind:
            continue
        entry: dict[int, list[str]] = {}
        for row in range(rows.starts[k] + 1, rows.starts[k + 1]):
            entry.setdefault(int(rows.codes[row]), []).append(rows.value(row))
        names = entry.get(NAME, [])
        classes = [] if r12 else ["AcDbSymbolTableRecord", _CLASSES[kind]]
        is_sound = len(names) == 1 and entry.get(SUBCLASS, []) == classes
        name = names[0].lower() if is_sound else ""
        entries["" if name in entries else name] = entry
    return entries


def _layer(entry: dict[int, list[str]]) -> TableLayer:
    """The layer of an entry. Raises ValueError where it says something twice."""
    (name,), (line_type,) = entry[NAME], entry.get(LINE_TYPE, [""])
    colour, flags, plot, true_colour = (
        int(number)
        for code, missing in ((COLOUR, "7"), (FLAGS, "0"), (PLOT, "1"), (TRUE_COLOUR, "-1"))
        for (number,) in [entry.get(code, [missing])]
    )
    hidden = colour < 0 or bool(flags & FROZEN) or not plot
    return TableLayer(
        name, abs(colour), None if TRUE_COLOUR not in entry else true_colour, line_type, hidden
    )


# --- how an entity looks --------------------------------------------------------------------------


class _Layer(Struct, frozen=True):
    """What a layer gives the entities on it."""

    colour: str
    line_type: str
    hidden: bool  #: off, frozen, not plotting, or Defpoints


class Layers(Struct):
    """The layers of a drawing, and which of them are read."""

    tables: Tables
    chosen: frozenset[str] | None = None  #: names in lower case; None is all that plot
    _known: dict[str, _Layer] = field(default_factory=dict)

    def names(self) -> tuple[str, ...]:
        return tuple(layer.name for layer in self.tables.layers.values())

    def style(self, attributes: Attributes, above: LayerStyle, inside: bool) -> LayerStyle:
        """How what has `attributes` shows below `above`; `inside`: whether it stands in a block.

        In a block, layer 0 stands for the layer of the insert, and BYBLOCK for its colour and its
        line type.
        """
        layer = above.layer if inside and attributes.layer == "0" else attributes.layer
        colour, invisible = self._colour(attributes, layer, above), attributes.invisible
        line_type = attributes.line_type.upper()
        if line_type == TYPE_BY_BLOCK:
            line_type = above.line_type
        elif line_type == TYPE_BY_LAYER:
            line_type = self._layer(layer).line_type
        else:
            line_type = self._with_gaps(line_type)
        return LayerStyle(layer, colour, above.invisible or invisible, line_type)

    def hides(self, style: LayerStyle) -> bool:
        """Whether what shows so is not read: off, frozen, not plotting, Defpoints, not chosen."""
        if style.invisible:
            return True
        if self.chosen is not None:
            return style.layer.lower() not in self.chosen
        return self._layer(style.layer).hidden

    def _layer(self, name: str) -> _Layer:
        """A layer as the table has it; white and visible if an entity names one that it has not."""
        key = name.lower()
        if key not in self._known:
            layer = self.tables.layers.get(key, _UNKNOWN)
            true_colour, number = layer.true_colour, layer.colour
            colour = colour_of_number(number) if true_colour is None else _hex(true_colour)
            hidden = layer.hidden or key == "defpoints"
            self._known[key] = _Layer(colour, self._with_gaps(layer.line_type), hidden)
        return self._known[key]

    def _colour(self, attributes: Attributes, layer: str, above: LayerStyle) -> str:
        if attributes.true_colour is not None:
            return _hex(attributes.true_colour)
        number = abs(attributes.colour)
        if number == BYBLOCK:
            return above.colour
        if number == BYLAYER or number > 255:
            return self._layer(layer).colour
        return colour_of_number(number)

    def _with_gaps(self, name: str) -> str:
        """A line type if it has gaps, by the table or, where that lacks it, by its name."""
        if name.upper() in (*CONTINUOUS, TYPE_BY_BLOCK, TYPE_BY_LAYER):
            return ""
        return name if self.tables.has_gaps.get(name.lower(), True) else ""


def attributes_of(entity: Any) -> Attributes:
    """Display attributes of an ezdxf entity."""
    dxf = entity.dxf
    return Attributes(
        dxf.layer, dxf.get("color", BYLAYER), dxf.get("true_color"),
        bool(dxf.get("invisible", 0)), str(dxf.get("linetype", TYPE_BY_LAYER)),
    )  # fmt: skip


#: The colours of AutoCAD's palette (ACI) that have names, from 1 on; ezdxf knows the others.
_NAMED = (
    "#ff0000", "#ffff00", "#00ff00", "#00ffff", "#0000ff", "#ff00ff", WHITE, "#808080", "#c0c0c0",
)  # fmt: skip


def colour_of_number(number: int) -> str:
    """The colour of AutoCAD's palette, "#rrggbb"; white for numbers that it has not."""
    if 1 <= number <= len(_NAMED):
        return _NAMED[number - 1]
    from ezdxf.colors import aci2rgb

    return "#{:02x}{:02x}{:02x}".format(*aci2rgb(number)) if 1 <= number <= 255 else WHITE


def _hex(true_colour: int) -> str:
    return f"#{true_colour & 0xFFFFFF:06x}"
