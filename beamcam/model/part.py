"""The part: what a reader gives and everything after it works from.

Faces are DSTV's: `v` front (the web), `o` top, `u` bottom, `h` behind; `E0` to `E9` name planes
of their own. On each, x runs along the part from 0 and y from the face's lower edge, in mm.
Numbers stand as in a DSTV file: v and u are right-handed seen from outside, o and h are seen
mirrored (7th edition, page 8), so that counter-clockwise seen from outside is clockwise in the
numbers of o and h. Curves are plain geometry in those numbers.
"""

from collections.abc import Iterable, Iterator, Sequence
from math import inf
from pathlib import PurePath
from typing import Annotated, Literal, TypeVar

from msgspec import Meta, Struct, field
from msgspec.structs import replace

from beamcam.conversion import Keys
from beamcam.errors import Source
from beamcam.geometry.curves import Arc, Curve, Line
from beamcam.geometry.plane import MAX_COORDINATE, Box, Point, unit_vector

Face = str
FACES = ("v", "o", "u", "h")
PLATE_FACES = ("v", "h")  #: of a plate; what goes through has the same numbers on both
MIRRORED_FACES = ("o", "h")  #: their numbers are left-handed seen from outside

ProfileCode = Literal["I", "U", "L", "M", "RO", "RU", "C", "T", "B", "SO"]
PROFILE_CODES: tuple[ProfileCode, ...] = ("I", "U", "L", "M", "RO", "RU", "C", "T", "B", "SO")
HoleKind = Literal["through", "blind", "thread", "left-thread", "countersink", "mark"]
ContourKind = Literal["outer", "inner", "open"]
Process = Literal["cut", "mark", "engrave", "punch", "powder"]

Vector = tuple[float, float, float]

#: A part reaches from one end of all coordinates to the other at most.
MAX_NUMBER = 10 * MAX_COORDINATE
ALONG_DEG = 90.0  #: of an end cut that would run along the part, and so is none

Number = Annotated[float, Meta(ge=-MAX_NUMBER, le=MAX_NUMBER)]
Whole = Annotated[int, Meta(ge=-int(MAX_NUMBER), le=int(MAX_NUMBER))]
EndAngle = Annotated[float, Meta(gt=-ALONG_DEG, lt=ALONG_DEG)]


class Profile(Struct, frozen=True, cache_hash=True):
    """The cross-section of the stock; a sheet has code B, its width as height."""

    code: ProfileCode
    name: str
    height: float  #: of the web; width of a plate; outer diameter of a round
    width: float  #: of the flange
    flange_thickness: float
    web_thickness: float | None  #: thickness of a plate; None for a drawing that does not say
    radius: float = 0.0
    #: of a C how long its lips are, from the outside of the flange; None where it is not known
    lip: float | None = None

    @property
    def is_round(self) -> bool:
        """Whether it is a round bar or tube."""
        return self.code in ("RO", "RU")

    def face_width(self, face: Face) -> float:
        """Extent of `face` across the part: the height on v and h, the flange width on o and u."""
        return self.height if face in ("v", "h") else self.width

    def thickness(self, face: Face) -> float:
        """Thickness of the material behind `face`; 0 where it is not known."""
        if face in ("v", "h") or self.code == "B":
            return self.web_thickness or 0.0
        return self.flange_thickness

    def face_depth(self, face: Face) -> float:
        """How far the surface of `face` lies below the outermost material on its side.

        Flanges stand in front of the web: of an I on both sides of it, of a U, C or L (which lies
        on its h side) on the v side only. A T lies on its flange, whose edges stand out beside
        its stem on o and u. Section axes: page 7.
        """
        web = self.web_thickness or 0.0
        if face in ("v", "h") and self.code == "I":
            return (self.width - web) / 2
        if face == "v" and self.code in ("U", "C", "L", "T"):
            return self.width - web
        if face in ("o", "u") and self.code == "T":
            return (self.height - self.flange_thickness) / 2
        return 0.0


class EndCuts(Keys, frozen=True):
    """Angles of the end cuts in degrees, with DSTV's signs.

    At either end `angle = atan2(x(lowest y) - x(highest y), y_high - y_low)`, of the web in the
    view of v, of the flange in the view of u: positive at the start when the top edge is the
    longest, positive at the end when the bottom edge is.
    """

    web_start: EndAngle = 0.0
    web_end: EndAngle = 0.0
    flange_start: EndAngle = 0.0
    flange_end: EndAngle = 0.0


class Hole(Struct, frozen=True):
    """A round hole, thread, countersink or punch mark."""

    face: Face
    x: float
    y: float
    diameter: float  #: of a countersink the outer one; of a thread the nominal one
    source: Source
    depth: float | None = None  #: None is through
    kind: HoleKind = "through"
    angle: float | None = None  #: cone of a countersink in degrees; None is a flat counterbore
    edge: str = ""  #: reference letter of x: the edge rolling tolerance is measured from

    @property
    def centres(self) -> tuple[Point, ...]:
        """Its centre, as `Slot.centres`."""
        return ((self.x, self.y),)


class Slot(Struct, frozen=True):
    """A slotted or rectangular hole with round corners."""

    face: Face
    x: float  #: of the centre
    y: float  #: of the centre
    diameter: float  #: of the corner circles
    length: float  #: centre to centre of the corner circles, along `angle`
    height: float  #: centre to centre, across `angle`
    angle: float  #: degrees from the x axis, counter-clockwise in the face's numbers
    source: Source
    depth: float | None = None  #: None is through
    kind: HoleKind = "through"
    edge: str = ""

    @property
    def centres(self) -> tuple[Point, ...]:
        """Centres of the corner circles: two, or four of a rectangle."""
        c, s = unit_vector(self.angle)
        halves = dict.fromkeys(
            (k * self.length / 2, m * self.height / 2) for k in (-1, 1) for m in (-1, 1)
        )
        return tuple((self.x + c * a - s * b, self.y + s * a + c * b) for a, b in halves)


class Bevel(Keys, frozen=True):
    """A weld preparation on one curve of a contour."""

    curve: Whole  #: index into the contour's curves
    angle: Number  #: degrees; positive cuts the face that is looked at, negative the far side
    #: where the bevel ends, measured from the far side; 0 with an angle below 0 is all of the wall
    land: Number


class Notch(Keys, frozen=True):
    """A theoretical corner that a rounded or drilled corner stands for (notch rows t and w)."""

    curve: Whole  #: index of the curve that it belongs to
    kind: Literal["t", "w"]  #: tangent radius, or drilled corner
    corner: Point
    radius: Number = 0.0


class Contour(Struct, frozen=True, gc=False):
    """A chain of curves on a face; outer ones run counter-clockwise seen from outside."""

    face: Face
    kind: ContourKind
    curves: tuple[Curve, ...]
    source: Source
    process: Process = "cut"
    closed: bool = True
    bevels: tuple[Bevel, ...] = ()
    notches: tuple[Notch, ...] = ()
    edge: str = ""
    layer: str | None = None
    colour: str | None = None  #: "#rrggbb"


class TextMark(Struct, frozen=True):
    """A text to be marked, stamped or engraved."""

    face: Face
    x: float
    y: float
    angle: float  #: degrees
    height: float
    text: str
    source: Source
    option: Literal["", "r", "z"] = ""  #: r: turns with the part; z: all values are binding
    edge: str = ""


class Bend(Struct, frozen=True):
    """A bend about a line of the flat part; positive bends towards +Z."""

    start: Point
    end: Point
    angle: float  #: degrees
    radius: float | None
    source: Source


class EndPlane(Struct, frozen=True):
    """A plane that cuts the part, where no contour can say it (SC)."""

    point: Vector
    normal: Vector  #: outward: away from the material that stays
    source: Source

    def x(self, y: float, z: float) -> float:
        """Where the plane is at a place of the section; infinite if it runs along the part."""
        (px, py, pz), (a, b, c) = self.point, self.normal
        return px - (b * (y - py) + c * (z - pz)) / a if a else inf


class Camber(Struct, frozen=True):
    """A point of the cambered line; all other coordinates are without camber."""

    face: Face
    x: float
    y: float
    source: Source


Feature = Hole | Slot | Contour | TextMark | Bend | EndPlane | Camber


class Plane(Struct, frozen=True):
    """A plane of its own that features lie on, named as their `face`."""

    name: str
    origin: Vector
    along_x: Vector  #: the point 100 mm along the plane's x axis
    along_y: Vector  #: the point 100 mm along its y axis
    source: Source


class SectionPoint(Keys, frozen=True):
    """A corner of a special profile's outline (PR): `+` outside, `-` inside, radius to the next."""

    side: Literal["+", "-"]
    y: Number
    z: Number
    radius: Number = 0.0


class FileComment(Keys, frozen=True):
    """A comment of the file, and the place it precedes."""

    text: str
    before: str  #: "header:9", "feature:4", "feature:4:2" (row 2 of it), "end"; see anchors.py


class Dashed(Struct, frozen=True):
    """Curves of one look that are drawn with gaps, as centre lines and hidden edges are."""

    layer: str | None
    colour: str | None
    line_type: str  #: its name in the drawing
    count: int  #: of chains
    source: Source  #: of the first


class Measures(Struct, frozen=True):
    """Contents of a drawing that are not features of the part, since nothing is cut along them.

    They are kept so that their lengths can be given when somebody asks.
    """

    filled: tuple[Curve, ...] = ()  #: outlines of shapes with a fill and no stroke
    hidden: tuple[Curve, ...] = ()  #: curves on layers that are off, frozen or not plotting
    not_cut: tuple[tuple[str, int], ...] = ()  #: entities that are not curves, by name: how many
    grid: float | None = None  #: what coordinates are rounded to, if the file shows it
    lettered: tuple[tuple[str, int], ...] = ()  #: layers whose texts are marked, and how many
    dashed: tuple[Dashed, ...] = ()


class Part(Struct, frozen=True):
    """A piece mark, its stock and its features, in the order of the file."""

    mark: str
    profile: Profile
    length: float
    source: Source
    quantity: int = 1
    saw_length: float | None = None
    order: str = ""
    drawing: str = ""
    phase: str = ""
    grade: str = ""
    cuts: EndCuts = field(default_factory=EndCuts)
    features: tuple[Feature, ...] = ()
    planes: tuple[Plane, ...] = ()
    weight: float = 0.0  #: kg/m, of a plate kg/m2
    surface: float = 0.0  #: paint, m2/m, of a plate m2/m2
    notes: tuple[str, ...] = ()  #: the free texts of the header
    tolerance: tuple[float, float] | None = None  #: of the length, lower and upper
    section: tuple[SectionPoint, ...] = ()
    info: tuple[tuple[str, str], ...] = ()  #: word and text (IN)
    comments: tuple[FileComment, ...] = ()
    guid: str | None = None  #: IFC GlobalId
    #: Of a part that another machine has begun: the features that are there, and so are its ends.
    #: None of a whole part, to be made from stock.
    made: tuple[Feature, ...] | None = None
    #: Of a drawing: what was seen and is not a feature, and so makes no difference between parts.
    measures: Measures | None = None
    #: Of the file, where the angles of `cuts` stand, in their order; None where they have no lines.
    cut_lines: tuple[int, int, int, int] | None = None
    #: Which counts of header and contour, where they described different ends ("" where not).
    ends_by: Literal["", "contour", "header"] = ""

    def cut_source(self, kind: Literal["web", "flange"], at: Literal["start", "end"]) -> Source:
        """Where an angle of an end stands; of one without a place of its own that of the part."""
        if self.cut_lines is None:
            return self.source
        return Source(self.source.file, self.cut_lines[2 * (kind == "flange") + (at == "end")])

    @property
    def holes(self) -> Iterator[Hole]:
        return (f for f in self.features if type(f) is Hole)

    @property
    def slots(self) -> Iterator[Slot]:
        return (f for f in self.features if type(f) is Slot)

    @property
    def contours(self) -> Iterator[Contour]:
        return (f for f in self.features if type(f) is Contour)

    @property
    def texts(self) -> Iterator[TextMark]:
        return (f for f in self.features if type(f) is TextMark)


Moved = TypeVar("Moved", bound=Feature)


def moved_feature(feature: Moved, by: Point) -> Moved:
    """The feature moved in the plane of its plate; values across the plate stay."""
    if isinstance(feature, Contour):
        return replace(feature, curves=tuple([moved_curve(curve, by) for curve in feature.curves]))
    if isinstance(feature, Hole | Slot | TextMark):
        return replace(feature, x=feature.x + by[0], y=feature.y + by[1])
    return feature


def moved_curve(curve: Curve, by: Point) -> Curve:
    """The curve moved; of lines and arcs no angle is rounded."""
    dx, dy = by
    if isinstance(curve, Line):
        (x0, y0), (x1, y1) = curve.start, curve.end
        return Line((x0 + dx, y0 + dy), (x1 + dx, y1 + dy))
    if isinstance(curve, Arc):
        x, y = curve.centre
        return Arc((x + dx, y + dy), curve.radius, curve.start_deg, curve.sweep_deg)
    return curve.transformed(((1.0, 0.0, dx), (0.0, 1.0, dy)))


def extent(curves: Iterable[Curve]) -> Box | None:
    """The bounding box of all curves; None if there are none."""
    from beamcam.geometry.arrays import table_of

    return table_of(tuple(curves)).box


def part_data(parts: Sequence[Part]) -> dict[str, str]:
    """The data of the parts of a program; of several that differ, joined by +. Lengths in mm.

    The date of the job is not among them: see `posts.Job`.
    """
    data = [
        {
            "mark": part.mark, "name": PurePath(part.source.file).stem,
            "profile": part.profile.name, "grade": part.grade, "length": f"{part.length:g}",
            "quantity": str(part.quantity), "order": part.order, "drawing": part.drawing,
            "phase": part.phase,
        }
        for part in parts
    ]  # fmt: skip
    return {key: "+".join(dict.fromkeys(one[key] for one in data)) for key in data[0]}
