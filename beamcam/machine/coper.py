"""A torch that goes round a profile: it turns about the bar, along which it or the bar moves."""

from math import asin, atan, cos, degrees, radians, sin, sqrt, tan
from typing import Annotated, Literal

from msgspec import Meta

from beamcam.conversion import Keys, NotNegative, Positive
from beamcam.machine.torch import PathSlack, TorchRow

#: Degrees of A at which the torch looks at a face: its head is at Y -sin A, Z cos A of its tip.
A_OF_FACE = {"o": -90.0, "v": 0.0, "u": 90.0}
TUBES = ("RO", "M")  #: codes of sections that close round


def torch_way(a_deg: float, b_deg: float = 0.0) -> tuple[float, float, float]:
    """The way from the tip of the torch to its head, of length 1: B tilts it towards X."""
    a, b = radians(a_deg), radians(b_deg)
    return sin(b), -sin(a) * cos(b), cos(a) * cos(b)


def torch_angles(face: str, lean: tuple[float, float]) -> tuple[float, float]:
    """A off that of a face, and B, of a torch whose head is so far over along the bar and across
    the face, by mm of its height over that face."""
    along, across = lean
    off = degrees(atan(across if face == "o" else -across)) + 0.0
    return off, 0.0 + degrees(asin(along / sqrt(1.0 + along * along + across * across)))


class TubeCorner(Keys, frozen=True):
    """How round the corners of rectangular tubes are, up to a thickness of the wall."""

    up_to: Positive  #: thickness of the wall
    share: Positive  #: outer radius, in thicknesses


class SupportZone(Keys, frozen=True):
    """A part of X where a support holds the bar."""

    min: float  #: X where it begins
    max: float  #: X where it ends


class Coper(Keys, frozen=True):
    """The torch of a machine that copes profiles.

    X runs along the bar from its leading end. Y and Z are those of the section: Y 0 is the outside
    of the lower flange, Z 0 the edge that lies on the rollers. A T lies on its side, as an I that
    has no upper flange: its flange at Y 0, its stem across. A C lies on its lips.
    """

    max_height: Positive  #: of the section, along Y
    max_width: Positive  #: of the section, along Z
    rows: tuple[TorchRow, ...]  #: of each thickness; of a root that of flange and root together
    #: at which feed steel between two rows is cut: that of the row for thicker, or one in between
    between_rows: Literal["row above", "interpolate"] = "row above"
    turns: Literal["torch", "bar"] = "torch"  #: what A turns; below an upright torch a bar does
    #: what A counts: degrees, or mm of the surface of a round tube, from its lowest line towards v
    a_unit: Literal["deg", "mm"] = "deg"
    #: over a bar that turns: whether Y follows the place that is cut, or the torch stays over the
    #: axis, where only round tubes are square to it
    y: Literal["follows", "fixed"] = "follows"
    #: DSTV codes that it takes; RO and M only where the bar turns
    profiles: tuple[Literal["I", "U", "L", "T", "C", "RO", "M"], ...] = ("I", "U", "L")
    #: of rectangular tubes whose file does not say how round their corners are
    corners: tuple[TubeCorner, ...] = ()
    #: outer radius of those corners, mm, which goes before `corners`; 0 for none
    corner: NotNegative = 0.0
    #: length of the lips of a C whose file does not say it, mm; 0 for none
    lip: NotNegative = 0.0
    length: Positive = 12000.0  #: of the bar
    material: str = ""  #: of a part that does not say
    chuck: NotNegative = 0.0  #: of a bar that turns, held behind what is cut
    supports: tuple[SupportZone, ...] = ()  #: along X, where nothing is cut
    seam: float = 0.0  #: where the ends of a tube are pierced: of 360 round its surface, from u 0
    trim: Positive = 30.0  #: of the bar before a part and behind it, for leads and pierces
    torch_width: Positive = 16.0  #: diameter of the torch from its tip to its holder
    torch_length: Positive = 200.0  #: from the tip to the holder
    head_width: Positive = 120.0  #: diameter of the holder and of all that is behind it
    clearance: Positive = 20.0  #: of the tip from the bar's box as the torch travels and turns
    play: Positive = 0.5  #: between the torch and steel beside it, at least
    tcp: bool = True  #: whether X, Y and Z say where the tip is, or the axis that it turns about
    pivot: NotNegative = 0.0  #: from the tip to the axis that it turns about
    #: degrees that B tilts the torch along the bar, at most; 0 where the machine has no B
    tilt: Annotated[float, Meta(ge=0, le=60)] = 0.0
    #: The root between web and flange, where the torch has no room over the web: refused, or cut
    #: from outside of the flange by a pass that is deep enough.
    k_area: Literal["refuse", "pass"] = "refuse"
    root_over: Positive = 2.0  #: how much deeper than the root such a pass cuts
    #: of a re-entrant corner that is drawn sharp, or as round as there is room
    corner_radius: Positive = 10.0
    tolerance: PathSlack = 0.2  #: of the cut from the contour
    lead: Positive = 8.0  #: from the pierce point, in scrap, to the contour
    over: Positive = 2.0  #: how far a cut goes on beyond a free edge
    min_hole: NotNegative = 0.0  #: smallest diameter that is burnt
    min_hole_share: NotNegative = 0.0  #: smallest diameter that is burnt, by the thickness
    min_bevel: NotNegative = 1.0  #: degrees; an edge with a smaller bevel is cut square
    #: mm that a measured height or width may differ from that of the section, at most
    rolled: NotNegative = 5.0

    def unrolls(self, code: str) -> bool:
        """Whether a section of a DSTV code is cut on its surface, unrolled, as it turns below the
        torch: a tube, or a plate (B) that is the surface of one. Others are cut wall by wall."""
        return self.turns == "bar" and code in (*TUBES, "B")

    def outer_radius(self, radius: float, wall: float) -> float:
        """That of the corners of a rectangular tube: its own, `corner`, or by the table.

        No corner is less round outside than its wall is thick. Without a row for so thick a wall it
        is what the file says.
        """
        rows = sorted(self.corners, key=lambda row: row.up_to)
        share = next((row.share for row in rows if wall <= row.up_to), 0.0)
        return radius if radius >= wall else self.corner or share * wall or radius

    def standoff(self, height: float, b_deg: float) -> float:
        """How far the tip of a tilted torch is from the steel along its axis, in mm.

        The torch is torch_width wide at its tip, whose lower edge keeps that height over the steel:
        height / cos(B) + tan(B) torch_width / 2.
        """
        b = radians(abs(b_deg))
        return height / cos(b) + self.torch_width / 2 * tan(b)

    def reach_beside(self, radius: float, cut_height: float) -> float:
        """How near to a flange's inner surface the middle of the torch comes over the web, in mm.

        The edge of its tip, `cut_height` over the web, keeps `play` off the flange and off a root
        fillet of that radius r, whose middle lies r from both: at d from the flange it is
        sqrt((r - d)^2 + (r - cut_height)^2) from that middle, which may be r - play at most.
        """
        beside = self.play
        if cut_height < radius:
            beside = radius - sqrt((radius - self.play) ** 2 - (radius - cut_height) ** 2)
        return self.torch_width / 2 + beside
