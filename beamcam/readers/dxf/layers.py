"""Layer, colour and visibility of an entity, inherited through the inserts above it."""

from typing import Any

from msgspec import Struct, field

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


class _Layer(Struct, frozen=True):
    """What a layer gives the entities on it."""

    colour: str
    line_type: str
    hidden: bool  #: off, frozen, not plotting, or Defpoints


class Layers(Struct):
    """The layers of a document, and which of them are read."""

    document: Document
    chosen: frozenset[str] | None = None  #: names in lower case; None is all that plot
    _known: dict[str, _Layer] = field(default_factory=dict)

    def names(self) -> tuple[str, ...]:
        return tuple(layer.dxf.name for layer in self.document.layers)

    def look(self, attributes: Attributes, above: LayerStyle, inside: bool) -> LayerStyle:
        """How what has `attributes` shows below `above`; `inside`: whether it stands in a block.

        In a block, layer 0 stands for the layer of the insert, and BYBLOCK for its colour and its
        line type.
        """
        layer = above.layer if inside and attributes.layer == "0" else attributes.layer
        return LayerStyle(
            layer, self._colour(attributes, layer, above), above.invisible or attributes.invisible,
            self._line_type(attributes, layer, above),
        )  # fmt: skip

    def hides(self, look: LayerStyle) -> bool:
        """Whether what looks so is not read: off, frozen, not plotting, Defpoints, not chosen."""
        if look.invisible:
            return True
        if self.chosen is not None:
            return look.layer.lower() not in self.chosen
        return self._layer(look.layer).hidden

    def _layer(self, name: str) -> _Layer:
        key = name.lower()
        if key not in self._known:
            self._known[key] = self._read(name)
        return self._known[key]

    def _read(self, name: str) -> _Layer:
        """A layer as the table has it; white and visible if an entity names one that it has not."""
        hidden = name.lower() == "defpoints"
        if not self.document.layers.has_entry(name):
            return _Layer(WHITE, "", hidden)
        layer = self.document.layers.get(name)
        true_colour = layer.dxf.get("true_color")
        number = abs(layer.dxf.get("color", 7))
        return _Layer(
            _hex(true_colour) if true_colour is not None else colour_of_number(number),
            self._with_gaps(str(layer.dxf.get("linetype", ""))),
            bool(hidden or layer.is_off() or layer.is_frozen() or not layer.dxf.get("plot", 1)),
        )

    def _colour(self, attributes: Attributes, layer: str, above: LayerStyle) -> str:
        if attributes.true_colour is not None:
            return _hex(attributes.true_colour)
        number = abs(attributes.colour)
        if number == BYBLOCK:
            return above.colour
        if number == BYLAYER or number > 255:
            return self._layer(layer).colour
        return colour_of_number(number)

    def _line_type(self, attributes: Attributes, layer: str, above: LayerStyle) -> str:
        name = attributes.line_type.upper()
        if name == TYPE_BY_BLOCK:
            return above.line_type
        return self._layer(layer).line_type if name == TYPE_BY_LAYER else self._with_gaps(name)

    def _with_gaps(self, name: str) -> str:
        """A line type if it has gaps, by the table or, where that lacks it, by its name."""
        if name.upper() in (*CONTINUOUS, TYPE_BY_BLOCK, TYPE_BY_LAYER):
            return ""
        table = self.document.linetypes
        if not table.has_entry(name):
            return name
        dashes = [tag for tag in table.get(name).pattern_tags.tags if tag.code == 49]
        return name if dashes else ""


def attributes_of(entity: Any) -> Attributes:
    """Display attributes of an ezdxf entity."""
    dxf = entity.dxf
    return Attributes(
        dxf.layer, dxf.get("color", BYLAYER), dxf.get("true_color"),
        bool(dxf.get("invisible", 0)), str(dxf.get("linetype", TYPE_BY_LAYER)),
    )  # fmt: skip


def colour_of_number(number: int) -> str:
    """The colour of AutoCAD's palette (ACI), "#rrggbb"; white for numbers that it has not."""
    from ezdxf.colors import aci2rgb

    return "#{:02x}{:02x}{:02x}".format(*aci2rgb(number)) if 1 <= number <= 255 else WHITE


def _hex(true_colour: int) -> str:
    return f"#{true_colour & 0xFFFFFF:06x}"
