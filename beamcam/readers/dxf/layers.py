"""Layer, colour and visibility of an entity, inherited through the inserts above it."""

from typing import Any

from msgspec import Struct, field

Document = Any  #: of ezdxf, which publishes no types that mypy can follow

# Values of group 62. Source: Autodesk DXF reference, "Common group codes for entities".
BYBLOCK, BYLAYER = 0, 256

#: The colour of what says none anywhere: number 7, white on a dark screen.
WHITE = "#ffffff"


class Attributes(Struct, frozen=True):
    """An entity's own display attributes."""

    layer: str = "0"
    colour: int = BYLAYER  #: number in AutoCAD's palette, or one of the two above
    true_colour: int | None = None  #: 0xrrggbb
    invisible: bool = False  #: group 60


class Look(Struct, frozen=True):
    """Resolved display attributes of an entity, inherited by its content if it is an insert."""

    layer: str = "0"
    colour: str = WHITE  #: "#rrggbb"
    invisible: bool = False  #: switched off itself (group 60), or in an insert that is


class Layers(Struct):
    """The layers of a document, and which of them are read."""

    document: Document
    chosen: frozenset[str] | None = None  #: names in lower case; None is all that plot
    _colours: dict[str, str] = field(default_factory=dict)
    _hidden: dict[str, bool] = field(default_factory=dict)

    def names(self) -> tuple[str, ...]:
        return tuple(layer.dxf.name for layer in self.document.layers)

    def look(self, said: Attributes, above: Look, inside: bool) -> Look:
        """How what says `said` shows below `above`; `inside` tells whether it stands in a block.

        In a block, layer 0 stands for the layer of the insert, and BYBLOCK for its colour.
        """
        layer = above.layer if inside and said.layer == "0" else said.layer
        return Look(layer, self._colour(said, layer, above), above.invisible or said.invisible)

    def hides(self, look: Look) -> bool:
        """Whether what looks so is not read: off, frozen, not plotting, Defpoints, not chosen."""
        if look.invisible:
            return True
        key = look.layer.lower()
        if self.chosen is not None:
            return key not in self.chosen
        if key not in self._hidden:
            self._hidden[key] = self._is_hidden(look.layer)
        return self._hidden[key]

    def _is_hidden(self, name: str) -> bool:
        if name.lower() == "defpoints":
            return True
        layer = self._layer(name)
        if layer is None:
            return False
        return bool(layer.is_off() or layer.is_frozen() or not layer.dxf.get("plot", 1))

    def _layer(self, name: str) -> Any:
        """The layer's entry; None where an entity names a layer that the table has not."""
        return self.document.layers.get(name) if self.document.layers.has_entry(name) else None

    def _colour(self, said: Attributes, layer: str, above: Look) -> str:
        if said.true_colour is not None:
            return _hex(said.true_colour)
        number = abs(said.colour)
        if number == BYBLOCK:
            return above.colour
        if number == BYLAYER or number > 255:
            return self._layer_colour(layer)
        return colour_of_number(number)

    def _layer_colour(self, name: str) -> str:
        key = name.lower()
        if key not in self._colours:
            layer = self._layer(name)
            if layer is None:
                self._colours[key] = WHITE
            elif layer.dxf.get("true_color") is not None:
                self._colours[key] = _hex(layer.dxf.true_color)
            else:
                self._colours[key] = colour_of_number(abs(layer.dxf.get("color", 7)))
        return self._colours[key]


def attributes_of(entity: Any) -> Attributes:
    """Display attributes of an ezdxf entity."""
    dxf = entity.dxf
    return Attributes(
        dxf.layer, dxf.get("color", BYLAYER), dxf.get("true_color"), bool(dxf.get("invisible", 0))
    )


def colour_of_number(number: int) -> str:
    """The colour of AutoCAD's palette (ACI), "#rrggbb"; white for numbers that it has not."""
    from ezdxf.colors import aci2rgb

    return "#{:02x}{:02x}{:02x}".format(*aci2rgb(number)) if 1 <= number <= 255 else WHITE


def _hex(true_colour: int) -> str:
    return f"#{true_colour & 0xFFFFFF:06x}"
