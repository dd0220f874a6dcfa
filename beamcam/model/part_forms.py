"""The JSON form of a part as records: what a file may say, before it is a part.

Their fields are the keys of the file, so that its schema is made of them.
"""

from typing import Annotated, Any, Literal

from msgspec import UNSET, Meta, UnsetType, field

from beamcam.conversion import Keys
from beamcam.model.part import (
    MAX_NUMBER,
    Bevel,
    ContourKind,
    EndCuts,
    FileComment,
    HoleKind,
    Notch,
    Number,
    Process,
    ProfileCode,
    SectionPoint,
    Whole,
)

Positive = Annotated[float, Meta(gt=0, le=MAX_NUMBER)]
NotNegative = Annotated[float, Meta(ge=0, le=MAX_NUMBER)]
Sweep = Annotated[float, Meta(ge=-360, le=360)]
Point = tuple[Number, Number]
Vector = tuple[Number, Number, Number]
Points = Annotated[tuple[Point, ...], Meta(min_length=2)]
Polygon = Annotated[tuple[Point, ...], Meta(min_length=3)]
Numbers = tuple[Number, ...]


class Located(Keys, frozen=True, kw_only=True):
    """The source of an object; absent if written by hand."""

    line: Whole | UnsetType | None = UNSET  #: of its file
    where: str | None = None  #: its place in a file without lines, such as a handle
    file: str | None = None  #: where that is not the part's


class Featured(Located, frozen=True, kw_only=True):
    """A feature of the part."""

    feature: Whole | None = None  #: its place among all; those without follow as they stand


class ArcForm(Keys, frozen=True):
    centre: Point
    radius: Positive
    start: Number  #: degrees
    sweep: Sweep  #: degrees; a negative one runs clockwise


class EllipseForm(Keys, frozen=True):
    centre: Point
    axis: Point  #: half of the long axis
    ratio: Annotated[float, Meta(gt=0, le=1)]  #: of the short axis to the long one
    start: Number = 0.0  #: degrees
    sweep: Sweep = 360.0


class BezierForm(Keys, frozen=True):
    points: Points
    weights: Numbers | None = None


class SplineForm(Keys, frozen=True):
    degree: Whole
    control: Points
    knots: Numbers
    weights: Numbers | None = None


class CircleForm(Keys, frozen=True):
    centre: Point
    radius: Positive


class TangentForm(Keys, frozen=True):
    """The arc of at most 180 degrees through two tangent points."""

    start: Point = field(name="from")
    end: Point = field(name="to")
    radius: Positive
    side: Literal["left", "right"]  #: of the way on which its centre lies


class TouchedForm(Keys, frozen=True):
    """A curve that a circle touches: an object of one key. A line is meant beyond its ends, an arc
    as its whole circle."""

    line: tuple[Point, ...] | None = None
    arc: ArcForm | None = None
    circle: CircleForm | None = None


class TangentCircleForm(Keys, frozen=True):
    """The circle that touches two curves and has a radius, or that touches three."""

    to: tuple[TouchedForm, ...]
    radius: Positive | None = None
    near: Point | None = None  #: of several, the one whose centre is nearest to it


class FunctionForm(Keys, frozen=True):
    """A graph, y of x between two ends, or the way of a point, x and y of t."""

    y: str
    x: str | None = None
    t: tuple[Number | str, ...] | None = None  #: both ends of the parameter, numbers or arithmetic
    low: Number | str | None = field(default=None, name="from")  #: of a graph
    high: Number | str | None = field(default=None, name="to")
    tolerance: Positive | None = None  #: distance of the curves from it, mm


class CurveForm(Keys, frozen=True):
    """A curve: an object of one key."""

    line: tuple[Point, ...] | None = None
    arc: ArcForm | None = None
    ellipse: EllipseForm | None = None
    bezier: Points | BezierForm | None = None
    bspline: SplineForm | None = None
    newton: Points | None = None  #: the polynomial through nodes
    polygon: Polygon | None = None  #: closed, turned as its kind asks for
    circle: CircleForm | None = None
    tangent_arc: TangentForm | None = None
    tangent_circle: TangentCircleForm | None = None
    function: FunctionForm | None = None


class ProfileForm(Keys, frozen=True):
    code: ProfileCode
    height: Number  #: of the web; width of a plate; outer diameter of a round
    name: str = ""
    width: Number = 0.0  #: of the flange
    flange_thickness: Number = 0.0
    web_thickness: Number | None = None  #: thickness of a plate
    radius: Number = 0.0
    #: of a C how long its lips are, from the outside of the flange; without it it is not known
    lip: Positive | None = None


class HoleForm(Featured, frozen=True, kw_only=True):
    x: Number
    y: Number
    diameter: NotNegative
    face: str = "v"
    depth: Number | None = None  #: without one it is through
    kind: HoleKind | UnsetType = UNSET
    angle: Number | None = None  #: cone of a countersink, degrees
    edge: str = ""


class SlotForm(Featured, frozen=True, kw_only=True):
    x: Number  #: of the centre
    y: Number
    diameter: NotNegative  #: of the corner circles
    length: Number  #: centre to centre of the corner circles, along `angle`
    height: Number = 0.0  #: centre to centre, across `angle`
    angle: Number = 0.0  #: degrees
    face: str = "v"
    depth: Number | None = None  #: without one it is through
    kind: HoleKind | UnsetType = UNSET
    edge: str = ""


class ContourForm(Featured, frozen=True, kw_only=True):
    kind: ContourKind
    curves: tuple[CurveForm, ...] = ()
    face: str = "v"
    process: Process = "cut"
    closed: bool | UnsetType = UNSET
    bevels: tuple[Bevel, ...] = ()
    notches: tuple[Notch, ...] = ()
    edge: str = ""
    layer: str | None = None
    colour: str | None = None
    length: Any = None  #: computed, not read
    bbox: Any = None  #: computed, not read


class TextForm(Featured, frozen=True, kw_only=True):
    x: Number
    y: Number
    height: Number
    text: str
    face: str = "v"
    angle: Number = 0.0  #: degrees
    option: Literal["", "r", "z"] = ""
    edge: str = ""


class BendForm(Featured, frozen=True, kw_only=True):
    start: Point
    end: Point
    angle: Number  #: degrees
    radius: Number | None = None


class EndPlaneForm(Featured, frozen=True, kw_only=True):
    point: Vector
    normal: Vector  #: away from the material that stays


class CamberForm(Featured, frozen=True, kw_only=True):
    x: Number
    y: Number
    face: str = "v"


class PlaneForm(Located, frozen=True, kw_only=True):
    name: str
    origin: Vector
    along_x: Vector  #: the point 100 mm along the plane's x axis
    along_y: Vector


class FeatureLists(Keys, frozen=True, kw_only=True):
    """Features by their kinds."""

    holes: tuple[HoleForm, ...] = ()
    slots: tuple[SlotForm, ...] = ()
    contours: tuple[ContourForm, ...] = ()
    texts: tuple[TextForm, ...] = ()
    bends: tuple[BendForm, ...] = ()
    end_planes: tuple[EndPlaneForm, ...] = ()
    cambers: tuple[CamberForm, ...] = ()


class PartForm(Keys, frozen=True, kw_only=True):
    """A part in the form `beamcam/part/1`."""

    schema: Any = UNSET
    mark: str
    profile: ProfileForm
    length: Positive
    quantity: Whole = 1
    saw_length: Number | None = None
    order: str = ""
    drawing: str = ""
    phase: str = ""
    grade: str = ""
    cuts: EndCuts = EndCuts()
    #: of the file, where the four angles stand
    cut_lines: tuple[Whole, Whole, Whole, Whole] | None = None
    holes: tuple[HoleForm, ...] = ()
    slots: tuple[SlotForm, ...] = ()
    contours: tuple[ContourForm, ...] = ()
    texts: tuple[TextForm, ...] = ()
    bends: tuple[BendForm, ...] = ()
    end_planes: tuple[EndPlaneForm, ...] = ()
    cambers: tuple[CamberForm, ...] = ()
    #: of a part that another machine has begun: the features that are there, and so are its ends
    made: FeatureLists | None = None
    planes: tuple[PlaneForm, ...] = ()
    weight: Number = 0.0  #: kg/m, of a plate kg/m2
    surface: Number = 0.0  #: paint, m2/m, of a plate m2/m2
    notes: tuple[str, ...] = ()
    tolerance: tuple[Number, Number] | None = None  #: of the length, lower and upper
    section: tuple[SectionPoint, ...] = ()
    info: tuple[tuple[str, str], ...] = ()  #: word and text
    comments: tuple[FileComment, ...] = ()
    guid: str | None = None
    source: Located | None = None
    bbox: Any = None  #: computed, not read
    path_length: Any = None  #: computed, not read
    duplicate_length: Any = None  #: computed, not read
    filled_length: Any = None  #: of a drawing, not read
    hidden_length: Any = None  #: of a drawing, not read
    not_cut: Any = None  #: of a drawing, not read
