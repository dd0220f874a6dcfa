"""The saw of a line."""

from typing import Literal

from beamcam.conversion import Keys, NotNegative, Positive


class SawSection(Keys, frozen=True):
    """The largest section that the blade reaches across, up to an angle off the square cut."""

    max_angle: NotNegative  #: degrees off the square cut, to either side
    max_height: Positive  #: of a section at that angle
    max_width: Positive  #: of a section at that angle


class Saw(Keys, frozen=True):
    """The saw: its position, its range and its angle convention."""

    kerf: NotNegative  #: width of its cut
    min_angle: float  #: of the mitre, in the machine's own counting
    max_angle: float  #: of the mitre
    max_height: Positive  #: of the largest section
    max_width: Positive  #: of the largest section
    x: float = 0.0  #: machine X of a cut at bar x 0
    kerf_along: Literal["normal", "x"] = "normal"  #: across the blade, or along the bar
    pivot: Literal["o", "u"] = "o"  #: the edge of the web on which X is counted
    square: float = 0.0  #: what a square cut is called: 0 or 90
    angle_sign: Literal[-1, 1] = 1  #: of DSTV's web angle in the machine's counting
    feed_mm_min: Positive = 2500.0  #: of the blade
    #: an end nearer to square than this is sawn square, degrees of web or flange
    min_mitre: float = 0.2
    min_tilt: float = 0.0  #: of the blade out of the vertical, for flange angles
    max_tilt: float = 0.0  #: 0 and 0: the blade does not tilt
    tilt_sign: Literal[-1, 1] = 1  #: of DSTV's flange angle in the machine's counting
    compound: bool = False  #: whether it may turn and tilt in one cut
    common_cuts: bool = False  #: whether one cut may end a part and start the next
    max_sections: tuple[SawSection, ...] = ()  #: by angle; empty: only the maximum is known
