"""Lettering and marks as machine data: what the machine makes, and what is left for manual work."""

from collections.abc import Mapping
from typing import Literal

from msgspec import field

from beamcam.conversion import Keys, NotNegative, Positive

#: How a kind of mark is made: by the machine, manually from the list, or refused.
Policy = Literal["make", "list", "refuse"]
#: What letters: a needle or milling point, a torch at low power or a laser, each of which draws the
#: strokes of a single-line font; or a stamp or a printer, which is told the text.
MarkingUnit = Literal["none", "scribe", "plasma", "laser", "stamp", "printer"]
#: Units that are told a text by a word of the program and draw no strokes.
TOLD_UNITS = ("stamp", "printer")


class Marks(Keys, frozen=True):
    """What becomes of texts (DSTV: SI), centre points (BO of diameter 0) and lines (KO, PU).

    Points and lines that cannot be made though they are to be are refused, as they locate other
    parts. A text without room goes on the list of manual work.
    """

    text: Policy = "list"  #: texts; list: left for manual work
    points: Policy = "make"  #: centre points
    contours: Policy = "make"  #: lines to scribe or to punch
    unit: MarkingUnit = "none"  #: what letters
    height_of: Literal["capital", "body"] = "capital"  #: what the height of a text is that of
    min_height: Positive = 3.0  #: of a capital; of a stamp its least of `heights` counts
    min_distance: NotNegative = 3.0  #: of letters from holes, edges and ends
    spacing: Positive = 1.0  #: from letter to letter; 1 as the font has it
    replace: Mapping[str, str] = field(default_factory=dict)  #: for characters that a font lacks
    characters: str = ""  #: that a stamp or printer has
    heights: tuple[Positive, ...] = ()  #: that it has; empty: any
    pitch: Positive = 0.8  #: from character to character, as a share of the height
    angles: tuple[float, ...] = (0.0,)  #: degrees at which it letters
    #: faces that it comes to, and what {face} calls the unit there
    faces: Mapping[str, int] = field(default_factory=dict)
    x: float | None = None  #: machine X of a text at bar x 0; None is where the drill stands

    @property
    def is_told(self) -> bool:
        """Whether a stamp or a printer letters, which is told its texts."""
        return self.unit in TOLD_UNITS
