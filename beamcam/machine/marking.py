"""Lettering and marks as machine data: what the machine makes of them, and what is left to hand."""

from typing import Literal

from beamcam.conversion import Keys

#: What becomes of a kind of mark: made by the machine, put on the list for the hand, or refused.
Policy = Literal["make", "list", "refuse"]


class Marks(Keys, frozen=True):
    """What becomes of texts (DSTV: SI), centre points (BO of diameter 0) and lines (KO, PU).

    Points and lines that cannot be made though they are to be are refused, as they locate other
    parts. A text that finds no place is put on the list for the hand.
    """

    text: Policy = "list"
    points: Policy = "make"
    contours: Policy = "make"  #: lines to scribe or to punch
