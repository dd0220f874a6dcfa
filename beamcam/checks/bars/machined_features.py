"""Machined features: what a program made, in machine coordinates."""

from collections.abc import Sequence

from msgspec import Struct


class Cut(Struct, frozen=True, gc=False):
    """One saw cut."""

    line: int
    x: float  #: machine X
    angle: float  #: degrees, in the machine's counting
    feed_mm_min: float
    tilt: float = 0.0  #: degrees, in the machine's counting


class Bore(Struct, frozen=True, gc=False):
    """One hole, as its spindle made it; a stroke of two spindles makes two."""

    line: int  #: of the deepest feed
    face: str
    x: float  #: machine X
    y: float  #: on the face
    diameter: float  #: of the tool
    tip_depth: float  #: of the tool's tip, from the surface of the face
    spindle: int  #: number that the program chose it by
    feed_mm_min: float
    stroke: float  #: where the stroke axis turned back
    kind: str = "drill"  #: of the tool
    turning: int = 0  #: the M word that started the spindle; 0 if it is stopped
    pitch: float = 0.0  #: that was chosen for a tap
    speed_rpm: float = 0.0  #: 0 where the program does not say
    begin: float = 0.0  #: where its feed began on the stroke axis


class MachinedPath(Struct, frozen=True, gc=False):
    """A path that a tool was led along in the material."""

    line: int  #: of its first point
    face: str
    kind: str  #: of the tool
    points: tuple[tuple[float, float], ...]  #: machine X and y on the face
    diameter: float  #: of the tool
    min_depth: float  #: of the tool's tip, from the surface of the face
    max_depth: float
    spindle: int
    feed_mm_min: float


class StampedText(Struct, frozen=True, gc=False):
    """A text that a stamp or printer was told."""

    line: int
    face: str
    kind: str  #: of the unit
    text: str
    x: float  #: machine X
    y: float  #: on the face
    height: float
    angle: float  #: degrees


Thing = Cut | Bore | MachinedPath | StampedText


class MachinedFeatures(Struct, frozen=True):
    """All that a program makes, in its order."""

    section: tuple[tuple[str, float], ...]  #: what it says about the bar, by field name
    cuts: tuple[Cut, ...]
    bores: tuple[Bore, ...]
    paths: tuple[MachinedPath, ...]
    order: tuple[Thing, ...]  #: all of them, as they follow one another
    texts: tuple[StampedText, ...] = ()


def made_in_order(
    section: tuple[tuple[str, float], ...], order: Sequence[Thing]
) -> MachinedFeatures:
    """All that is in `order`, and each kind by itself."""
    return MachinedFeatures(
        section,
        tuple([o for o in order if type(o) is Cut]),
        tuple([o for o in order if type(o) is Bore]),
        tuple([o for o in order if type(o) is MachinedPath]),
        tuple(order),
        tuple([o for o in order if type(o) is StampedText]),
    )
