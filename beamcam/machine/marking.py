"""Lettering and marks as machine data: what the machine makes, and what is left for manual work."""

from collections.abc import Mapping
from typing import Literal

from msgspec import field

from beamcam.conversion import Keys, NotNegative, Positive

#: How a kind of mark is made: by the machine, manually from the list, or refused.
Policy = Literal["make", "list", "refuse"]
#: What letters: a needle or milling point, a torch at low power or a laser; each draws the strokes
#: of a single-line font.
MarkingUnit = Literal["none", "scribe", "plasma", "laser"]


class Marks(Keys, frozen=True):
    """What becomes of texts (DSTV: SI), centre points (BO of diameter 0) and lines (KO, PU).

    Points and lines that cannot be made though they are to be are refused, as they locate other
    parts. A text that finds no place is put on the list for the hand.
    """

    text: Policy = "list"
    points: Policy = "make"
    contours: Policy = "make"  #: lines to scribe or to punch
    unit: MarkingUnit = "none"  #: what letters
    height_of: Literal["capital", "body"] = "capital"  #: what the height of a text is that of
    min_height: Positive = 3.0  #: of a capital
    min_distance: NotNegative = 3.0  #: of letters from holes, edges and ends
    spacing: Positive = 1.0  #: from letter to letter; 1 as the font has it
    replace: Mapping[str, str] = field(default_factory=dict)  #: for characters that a font lacks
