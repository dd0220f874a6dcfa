"""The faces of a solid in OpenCASCADE's BREP text, each with its exact surface, in mm.

A text is a list of tables: locations, curves, surfaces, and the shapes from vertex to compound,
where each shape names its parts by numbers that count from the end. Curves of edges are passed
over, for the surfaces say all that a member is read by. The format is described in OpenCASCADE's
"BRep Format" (dox/specification/brep_format.md), for versions 1 to 3 of the topology.

ifcopenshell gives facets, or this text; its Python interface has no surfaces, and facets lose the
radius of a hole. Nothing may be guessed here: a table that is not understood refuses the member.
That the corners of the kernel's facets lie on these surfaces is the law of
tests/unit/readers/ifc/test_brep.py.
"""

import re
from collections.abc import Iterator

from msgspec import Struct

from beamcam.readers.ifc.space import IDENTITY, Frame, Vec, cross, size, unit

# --- surfaces -------------------------------------------------------------------------------------

# The surfaces that faces of the kernel's solids lie on.


class Plane(Struct, frozen=True):
    """The plane of x and y of a frame."""

    frame: Frame

    def moved(self, by: Frame) -> "Plane":
        return Plane(by.times(self.frame))


class Cylinder(Struct, frozen=True):
    """A cylinder about the z of a frame."""

    frame: Frame
    radius: float

    @property
    def axis(self) -> Vec:
        """The unit vector along it."""
        return unit(self.frame.z)

    def moved(self, by: Frame) -> "Cylinder":
        """The cylinder elsewhere; its radius grows as the frame does."""
        grown = size(by.vector(self.frame.x)) / size(self.frame.x)
        return Cylinder(by.times(self.frame), self.radius * grown)


class Cone(Struct, frozen=True):
    """A cone about the z of a frame, of `radius` at its origin, its sides off z by `half_rad`."""

    frame: Frame
    radius: float
    half_rad: float

    def moved(self, by: Frame) -> "Cone":
        grown = size(by.vector(self.frame.x)) / size(self.frame.x)
        return Cone(by.times(self.frame), self.radius * grown, self.half_rad)


class Unnamed(Struct, frozen=True):
    """A surface that no member is read by, with its name."""

    kind: str

    def moved(self, _by: Frame) -> "Unnamed":
        return self


Surface = Plane | Cylinder | Cone | Unnamed


METRES = Frame(x=(1e3, 0.0, 0.0), y=(0.0, 1e3, 0.0), z=(0.0, 0.0, 1e3))  #: the kernel's unit
STRAIGHT = 1e-12  #: sine of the angle between an extrusion and its circle's axis, from rounding
VERSIONS = ("1", "2", "3")
FLAGS = 7  #: digits that follow each shape: free, modified, checked, ...
WITHOUT_GEOMETRY = ("Wi", "Sh", "So", "CS", "Co")


class BrepError(ValueError):
    """A text that is not a BREP; says what was found and what was expected."""


class _Circle(Struct, frozen=True):
    frame: Frame
    radius: float


class _Straight(Struct, frozen=True):
    origin: Vec
    along: Vec


_Curve = _Circle | _Straight | str  #: or the name of another curve


class _Use(Struct, frozen=True):
    """A shape as part of another: its number from the end, and its placement."""

    shape: int
    location: int


class _Shape(Struct, frozen=True):
    parts: tuple[_Use, ...]
    surface: int = 0  #: of a face
    location: int = 0  #: of that surface


def surfaces_of(text: str) -> tuple[Surface, ...]:
    """The surfaces of all faces of a BREP text in metres, placed, in mm. Raises BrepError."""
    head = re.search(r"CASCADE Topology V(\S+),", text)
    if head is None:
        raise BrepError(f"found {text.strip()[:40]!r}; expected 'CASCADE Topology V'")
    if head[1] not in VERSIONS:
        raise BrepError(f"found version {head[1]}; expected one of {', '.join(VERSIONS)}")
    tokens = iter(text[head.end() :].split())
    try:
        places = _locations(tokens, _table(tokens, "Locations"))
        surfaces = [_surface(tokens) for _ in range(_table(tokens, "Surfaces"))]
        shapes = [_shape(tokens, head[1]) for _ in range(_table(tokens, "TShapes"))]
        root = _use(next(tokens), tokens)
        return tuple(_faces(root, METRES, places, surfaces, shapes))
    except StopIteration:
        raise BrepError("found the end of the text; expected more of a table") from None
    except (IndexError, ValueError) as fault:
        if isinstance(fault, BrepError):
            raise
        raise BrepError(f"found a table that does not hold ({fault})") from fault


def _faces(
    use: _Use, place: Frame, places: list[Frame], surfaces: list[Surface], shapes: list[_Shape]
) -> Iterator[Surface]:
    """The surfaces of the faces of a shape that stands in `place`."""
    shape = shapes[_below(len(shapes) - use.shape, len(shapes))]
    here = place.times(places[use.location])
    if shape.surface:
        yield surfaces[shape.surface - 1].moved(here.times(places[shape.location]))
        return
    for part in shape.parts:
        yield from _faces(part, here, places, surfaces, shapes)


def _below(index: int, count: int) -> int:
    """The index, which negative numbers are none of. Raises IndexError."""
    if not 0 <= index < count:
        raise IndexError(f"shape {count - index} of {count}")
    return index


def _table(tokens: Iterator[str], name: str) -> int:
    """The length of the next table of that name; what stands before it is passed over."""
    for token in tokens:
        if token == name:
            return int(next(tokens))
    raise BrepError(f"found no table {name!r}; expected one")


def _numbers(tokens: Iterator[str], count: int) -> list[float]:
    return [float(next(tokens)) for _ in range(count)]


def _integers(tokens: Iterator[str], count: int) -> list[int]:
    return [int(next(tokens)) for _ in range(count)]


def _vec(tokens: Iterator[str]) -> Vec:
    x, y, z = _numbers(tokens, 3)
    return x, y, z


def _axes(tokens: Iterator[str]) -> Frame:
    """A frame as origin, z, x, y."""
    o, z, x, y = (_vec(tokens) for _ in range(4))
    return Frame(o, x, y, z)


def _locations(tokens: Iterator[str], count: int) -> list[Frame]:
    """The locations by their numbers, of which 0 is none at all."""
    found = [IDENTITY]
    for _ in range(count):
        if next(tokens) == "1":
            a, b, c = (_numbers(tokens, 4) for _ in range(3))
            found.append(
                Frame(*((a[i], b[i], c[i]) for i in (3, 0, 1, 2))),
            )
            continue
        place = IDENTITY
        while number := int(next(tokens)):
            # Each elementary location is put to the left of those before it.
            place = _power(found[number], int(next(tokens))).times(place)
        found.append(place)
    return found


def _power(frame: Frame, by: int) -> Frame:
    if by < 0:
        return _power(frame.inverse(), -by)
    made = IDENTITY
    for _ in range(by):
        made = made.times(frame)
    return made


def _surface(tokens: Iterator[str]) -> Surface:
    """The next surface of the table."""
    kind = next(tokens)
    match kind:
        case "1":
            return Plane(_axes(tokens))
        case "2":
            return Cylinder(_axes(tokens), float(next(tokens)))
        case "3":
            return Cone(_axes(tokens), *_numbers(tokens, 2))
        case "6":
            along = _vec(tokens)
            return _extruded(_curve(tokens), along)
        case "10":  # a piece of another one
            _numbers(tokens, 4)
            return _surface(tokens)
    return Unnamed(_passed_over(kind, tokens))


def _passed_over(kind: str, tokens: Iterator[str]) -> str:
    """The name of a surface that no member is read by; its numbers are passed over."""
    match kind:
        case "4":
            _numbers(tokens, 13)
            return "sphere"
        case "5":
            _numbers(tokens, 14)
            return "torus"
        case "7":
            _numbers(tokens, 6)
            _curve(tokens)
            return "surface of revolution"
        case "8":
            u_weights, v_weights, u_degree, v_degree = _integers(tokens, 4)
            _numbers(tokens, (u_degree + 1) * (v_degree + 1) * (3 + (u_weights or v_weights)))
            return "Bezier surface"
        case "9":
            u_weights, v_weights, _, _, _, _, u, v, u_knots, v_knots = _integers(tokens, 10)
            _numbers(tokens, u * v * (3 + (u_weights or v_weights)) + 2 * (u_knots + v_knots))
            return "B-spline surface"
        case "11":
            _numbers(tokens, 1)
            _surface(tokens)
            return "offset surface"
    raise BrepError(f"found surface type {kind!r}; expected 1 to 11")


def _extruded(curve: _Curve, along: Vec) -> Surface:
    """The surface that a curve leaves behind it."""
    if isinstance(curve, _Circle):
        if size(cross(curve.frame.z, along)) <= STRAIGHT * size(along):
            return Cylinder(curve.frame, curve.radius)
        return Unnamed("circle extruded at a slant")
    if isinstance(curve, _Straight):
        x = unit(curve.along)
        square = unit(cross(cross(x, along), x))
        return Plane(Frame(curve.origin, x, square, cross(x, square)))
    return Unnamed(f"extruded {curve}")


def _curve(tokens: Iterator[str]) -> _Curve:
    """The next curve, which a surface is made from."""
    kind = next(tokens)
    match kind:
        case "1":
            return _Straight(_vec(tokens), _vec(tokens))
        case "2":
            return _Circle(_axes(tokens), float(next(tokens)))
        case "3":
            _numbers(tokens, 14)
            return "ellipse"
        case "4":
            _numbers(tokens, 13)
            return "parabola"
        case "5":
            _numbers(tokens, 14)
            return "hyperbola"
        case "6":
            weights, degree = _integers(tokens, 2)
            _numbers(tokens, (degree + 1) * (3 + weights))
            return "Bezier curve"
        case "7":
            weights, _, _, poles, knots = _integers(tokens, 5)
            _numbers(tokens, poles * (3 + weights) + 2 * knots)
            return "B-spline curve"
        case "8":
            _numbers(tokens, 2)
            return _curve(tokens)
        case "9":
            _numbers(tokens, 4)
            _curve(tokens)
            return "offset curve"
    raise BrepError(f"found curve type {kind!r}; expected 1 to 9")


def _shape(tokens: Iterator[str], version: str) -> _Shape:
    """The next shape; of a face its surface, of all but faces and edges the parts."""
    kind = next(tokens)
    surface = location = 0
    if kind == "Fa":
        _numbers(tokens, 2)
        surface, location = _integers(tokens, 2)
    elif kind == "Ve" or kind == "Ed":
        _numbers(tokens, 4)
    elif kind not in WITHOUT_GEOMETRY:
        raise BrepError(f"found shape {kind!r}; expected Ve, Ed, Fa, {', '.join(WITHOUT_GEOMETRY)}")
    _flags(tokens, kind)
    parts = []
    while (token := next(tokens)) != "*":
        parts.append(_use(token, tokens))
    return _Shape(tuple(parts), surface, location)


def _flags(tokens: Iterator[str], kind: str) -> None:
    """Pass over the curves and points of a shape to the flags that end them."""
    for token in tokens:
        if len(token) == FLAGS and not token.strip("01"):
            return
    raise BrepError(f"found no flags after {kind!r}; expected {FLAGS} digits")


def _use(token: str, tokens: Iterator[str]) -> _Use:
    """A part by its token, `+12`, `-12`, `i12` or `e12`, and the location after it."""
    if token[0] not in "+-ie":
        raise BrepError(f"found part {token!r}; expected it to begin with +, -, i or e")
    return _Use(int(token[1:]), int(next(tokens)))
