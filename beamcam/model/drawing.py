"""Contents of a drawing other than its contours, and the extent of curves.

Filled shapes and curves on hidden layers are not features, since nothing is cut along them; they
are kept so that their lengths can be given when somebody asks.
"""

from collections.abc import Iterable

from msgspec import Struct

from beamcam.errors import Source
from beamcam.geometry.curves import Curve
from beamcam.geometry.plane import Box
from beamcam.model.lengths import total_length


class Dashed(Struct, frozen=True):
    """Curves of one look that are drawn with gaps, as centre lines and hidden edges are."""

    layer: str | None
    colour: str | None
    line_type: str  #: its name in the drawing
    count: int  #: of chains
    source: Source  #: of the first


class Measures(Struct, frozen=True):
    """Contents of a drawing that are not features of the part."""

    filled: tuple[Curve, ...] = ()  #: outlines of shapes with a fill and no stroke
    hidden: tuple[Curve, ...] = ()  #: curves on layers that are off, frozen or not plotting
    not_cut: tuple[tuple[str, int], ...] = ()  #: entities that are not curves, by name: how many
    grid: float | None = None  #: what coordinates are rounded to, if the file shows it
    lettered: tuple[tuple[str, int], ...] = ()  #: layers whose texts are marked, and how many
    dashed: tuple[Dashed, ...] = ()

    @property
    def filled_length(self) -> float:
        """Length of `filled`."""
        return total_length(self.filled)

    @property
    def hidden_length(self) -> float:
        """Length of `hidden`."""
        return total_length(self.hidden)


def extent(curves: Iterable[Curve]) -> Box | None:
    """The bounding box of all curves; None if there are none."""
    from beamcam.geometry.arrays import CurveTable

    return CurveTable(tuple(curves)).box
