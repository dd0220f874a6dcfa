"""Plain entities: those whose numbers can be taken from the lines of the file as they stand.

A DXF file is rows of two lines, a group code and a value. Programs write thousands of entities
with the same sequence of group codes, so that it is looked at once where in such a sequence the
numbers are (a `Plan`), and every further entity costs little more than reading its numbers. ezdxf
builds an object for each row instead, which takes twenty times as long.

A sequence that holds anything beyond what is known here has no plan, and an entity with a value
that cannot be read raises ValueError: such entities are for ezdxf, which knows all of DXF. What is
taken here is what ezdxf would give, to the last bit: tests/property/test_dxf_plain_laws.py holds
both ways equal over files, drawings by ezdxf and damaged ones. No repair and no default is made
here.
"""

from collections.abc import Callable, Sequence
from math import isfinite, log10
from operator import itemgetter
from typing import Any

from msgspec import Struct, field

from beamcam.readers.dxf.curves import Vertex
from beamcam.readers.dxf.layers import BRACKET, BYLAYER, HANDLE, SUBCLASS, TYPE_BY_LAYER, Attributes

Codes = tuple[int, ...]
Values = tuple[Any, ...]  #: what the function of `curves` for the kind of entity takes

#: Layer, colour, true colour, whether it is hidden, line type, as a file has them.
Texts = tuple[str, str, str, str, str]
#: The values of an entity, one a row, and `BEYOND` behind them.
Row = list[str]

#: Places in a row of what an entity does not say, and of coordinates that it does not give.
NOT_SAID, NOT_GIVEN = -2, -1
UNSAID = "\n"  # no line of a file holds that
BEYOND = (UNSAID, "0")

OWNER = 330  #: group code: name of the entity's layout
_BASE = frozenset((HANDLE, OWNER, BRACKET))
# Layer, line type, its scale, colour, visibility, line weight, true colour and its name,
# transparency, shadows, plot style, material. Paper space (67) makes an entity one for ezdxf.
_COMMON = frozenset((8, 6, 48, 62, 60, 370, 420, 430, 440, 284, 380, 390, 347, 348))
# Data of other programs, behind everything else.
_XDATA = frozenset((1000, 1001, 1002, 1003, 1005, 1040, 1041, 1042, 1070, 1071))
_EXTRUSION = (210, 220, 230)

# The types of values by group code. Source: Autodesk DXF reference, "Group code value types".
_REAL = frozenset((*range(10, 60), *range(210, 240), *range(1010, 1060)))
_WHOLE = frozenset(
    code
    for first, last in ((60, 79), (90, 99), (270, 289), (370, 389), (420, 449), (1060, 1071))
    for code in range(first, last + 1)
    if not 430 <= code <= 439
)


class ValuePlaces(Struct, frozen=True):
    """Positions of an entity's values in its row."""

    handle: int
    owner: int
    attributes: Callable[[Row], Texts]
    values: Callable[[Row], Values]
    reals: tuple[int, ...]  #: numbers that are not used here, but have to be some
    wholes: tuple[int, ...]
    extrusion: tuple[int, ...]  #: none where the entity does not name its plane
    brackets: tuple[int, ...]  #: around names of objects that want to hear of changes

    def read(self, row: Row) -> Values:
        """The values in a row. Raises ValueError or ArithmeticError where it is for ezdxf."""
        for k in self.reals:
            float(row[k])
        for k in self.wholes:
            int(row[k])
        if self.handle != NOT_SAID:
            int(row[self.handle], 16)
        for number, k in enumerate(self.brackets):
            if row[k] != ("}" if number % 2 else "{ACAD_REACTORS"):
                raise ValueError(f"found the bracket {row[k]!r}")
        if self.extrusion and _numbers([row[k] for k in self.extrusion]) != (0.0, 0.0, 1.0):
            raise ValueError("found a plane of its own")
        return self.values(row)


def attributes_from(
    layer: str, colour: str, true_colour: str, invisible: str, line_type: str
) -> Attributes:
    """Display attributes of an entity, `UNSAID` where it has none.

    Raises ValueError where a number is expected and not found.
    """
    return Attributes(
        "0" if layer == UNSAID else layer,
        BYLAYER if colour == UNSAID else int(colour),
        None if true_colour == UNSAID else int(true_colour),
        invisible != UNSAID and int(invisible) != 0,
        TYPE_BY_LAYER if line_type == UNSAID else line_type,
    )


class _Rows(Struct, frozen=True):
    """The places of group codes in one sequence of them."""

    codes: Codes
    places: dict[int, list[int]]

    def first(self, code: int, missing: int = NOT_GIVEN) -> int:
        return self.places.get(code, (missing,))[0]

    def points(self, code: int) -> tuple[int, ...]:
        """The places of x, y and z of all points whose x has group `code`, point by point."""
        after = (*self.codes, 0)
        rows: list[int] = []
        for k in self.places.get(code, ()):
            rows += (k, k + 1, k + 2 if after[k + 2] == code + 20 else NOT_GIVEN)
        return tuple(rows)

    def owner(self) -> int | None:
        """The place of the layout's name, `NOT_SAID` if it has none.

        None where it is there twice, or brackets are around anything but names.
        """
        brackets = self.places.get(BRACKET, [])
        pairs = zip(brackets[::2], brackets[1::2], strict=False)
        inside = {k for begin, end in pairs for k in range(begin + 1, end)}
        owners = [k for k in self.places.get(OWNER, ()) if k not in inside]
        if len(brackets) % 2 or len(owners) > 1 or any(self.codes[k] != OWNER for k in inside):
            return None
        return owners[0] if owners else NOT_SAID


class _Kind(Struct, frozen=True):
    """A kind of entity whose plan can be made."""

    needed: set[int]
    optional: set[int]
    unused: set[int]
    subclasses: int  #: beside that of all entities; R12 has none
    plan: Callable[[_Rows], Callable[[Row], Values] | None]
    many: set[int] = field(default_factory=set)  #: codes that may be there more than once
    in_r12: bool = True  #: whether the entity is known without subclasses


def plan_of(kind: str, codes: Codes, r12: bool) -> ValuePlaces | None:
    """Where the values of an entity with these group codes stand; None if it is not plain.

    `r12` tells that the file is of R12 or before.
    """
    known = _KINDS.get(kind)
    if known is None or (r12 and not known.in_r12):
        return None
    end = next((k for k, code in enumerate(codes) if code >= 1000), len(codes))
    head, others = codes[:end], codes[end:]
    if not _is_regular(known, head) or others[:1] not in ((), (1001,)):
        return None
    places: dict[int, list[int]] = {}
    for k, code in enumerate(head):
        places.setdefault(code, []).append(k)
    rows = _Rows(head, places)
    owner = rows.owner()
    values = known.plan(rows)
    if owner is None or values is None or not _XDATA.issuperset(others):
        return None
    used = known.needed | known.optional
    unread = [(k, code) for k, code in enumerate(codes) if code not in used]
    return ValuePlaces(
        rows.first(HANDLE, NOT_SAID),
        owner,
        itemgetter(*(rows.first(code, NOT_SAID) for code in (8, 62, 420, 60, 6))),
        values,
        tuple(k for k, code in unread if code in _REAL),
        tuple(k for k, code in unread if code in _WHOLE),
        rows.points(210),
        tuple(places.get(BRACKET, ())),
    )


def _is_regular(kind: _Kind, codes: Codes) -> bool:
    """Whether a sequence holds what it has to, each once, nothing unknown, and whole points."""
    own = kind.needed | kind.optional | kind.unused | {*_EXTRUSION}
    marks = [k for k, code in enumerate(codes) if code == SUBCLASS]
    if marks:
        ordered = (
            len(marks) == kind.subclasses + 1
            and _BASE.issuperset(codes[1 : marks[0]])
            and _COMMON.issuperset(codes[marks[0] + 1 : marks[1]])
            and own.issuperset(c for c in codes[marks[1] :] if c != SUBCLASS)
        )
    else:
        ordered = kind.in_r12 and (_COMMON | own | {HANDLE}).issuperset(codes[1:])
    if not ordered or not kind.needed.issubset(codes):
        return False
    once = [c for c in codes if c not in kind.many and c not in (SUBCLASS, BRACKET, OWNER)]
    before, after = (-1, *codes), (*codes[1:], -1)
    return len(once) == len(set(once)) and all(
        (after[k] == code + 10 or code not in _X)
        and (before[k] == code - 10 or (code - 10 not in _X and code - 20 not in _X))
        for k, code in enumerate(codes)
    )


#: The group codes of x of a point; y follows with 10 more, and z with 20 if it is there.
_X = (10, 11, 12, 13, 210)


def _numbers(texts: Sequence[str]) -> tuple[float, ...]:
    """The numbers in texts. Raises ValueError for what is not a finite number."""
    numbers = tuple(map(float, texts))
    # A sum that is finite has no other terms; that of great numbers may be beyond all of them.
    if not isfinite(sum(numbers)) and not all(map(isfinite, numbers)):
        raise ValueError("found a number that is not finite")
    return numbers


# --- the kinds ------------------------------------------------------------------------------------


def _line(rows: _Rows) -> Callable[[Row], Values]:
    pick = itemgetter(*rows.points(10), *rows.points(11))

    def values(row: Row) -> Values:
        x0, y0, z0, x1, y1, z1 = _numbers(pick(row))
        return (x0, y0, z0), (x1, y1, z1)

    return values


def _circle(rows: _Rows) -> Callable[[Row], Values]:
    """Centre and radius, and the angles of an arc."""
    pick = itemgetter(*rows.points(10), *(rows.first(c) for c in (40, 50, 51) if c in rows.places))

    def values(row: Row) -> Values:
        x, y, z, *others = _numbers(pick(row))
        return (x, y, z), *others

    return values


def _ellipse(rows: _Rows) -> Callable[[Row], Values]:
    pick = itemgetter(*rows.points(10), *rows.points(11), *map(rows.first, (40, 41, 42)))
    normal = rows.points(210)

    def values(row: Row) -> Values:
        x, y, z, ax, ay, az, *others = _numbers(pick(row))
        up = _numbers([row[k] for k in normal]) or (0.0, 0.0, 1.0)
        return (x, y, z), (ax, ay, az), up, *others

    return values


def _polyline(rows: _Rows) -> Callable[[Row], Values] | None:
    """Vertices, whether the last goes on to the first, and the elevation.

    A bulge belongs to the vertex before it.
    """
    corners = rows.places[10]
    bulges = dict.fromkeys(corners, NOT_GIVEN)
    for place in rows.places.get(42, ()):
        if place < corners[0]:
            return None
        bulges[max(k for k in corners if k < place)] = place
    several = len(corners) > 1
    pick_x, pick_y = itemgetter(*corners), itemgetter(*(k + 1 for k in corners))
    pick_bulge = itemgetter(*bulges.values())
    straight = 42 not in rows.places
    flags, elevation = rows.first(70), rows.first(38)

    def values(row: Row) -> Values:
        vertices: list[Vertex]
        x, y, bulge = pick_x(row), pick_y(row), pick_bulge(row)
        if not several:
            x, y, bulge = (x,), (y,), (bulge,)
        turns = (0.0,) * len(x) if straight else _numbers(bulge)
        vertices = list(zip(_numbers(x), _numbers(y), turns, strict=True))
        (height,) = _numbers([row[elevation]])
        return vertices, bool(int(row[flags]) & 1), height

    return values


#: Degrees of splines that ezdxf takes.
_MOST_DEGREE = 10


def _spline(rows: _Rows) -> Callable[[Row], Values] | None:
    """Degree, control points, knots and weights, where there are as many as there have to be."""
    count = len(rows.places[10])
    knots, weights = rows.places[40], rows.places.get(41, [])
    degree, tolerance = rows.first(71), rows.places.get(42)
    if len(weights) not in (0, count):
        return None
    pick = itemgetter(*rows.points(10))

    def values(row: Row) -> Values:
        order = int(row[degree]) + 1
        if not 2 <= order <= min(count, _MOST_DEGREE + 1) or len(knots) != count + order:
            raise ValueError("found a spline that is not whole")
        flat = iter(_numbers(pick(row)))
        points = tuple(zip(flat, flat, flat, strict=True))
        # Knots are rounded, and from 0 to 1 if they do not begin at 0, as ezdxf has them; a
        # tolerance that is not above 0 and knots that are all one raise an error.
        slack = _numbers([row[tolerance[0]]])[0] if tolerance else KNOT_TOLERANCE
        digits = -int(log10(slack))
        places = _numbers([row[k] for k in knots])
        if digits > 0:
            places = tuple(round(knot, digits) for knot in places)
        if first := places[0]:
            places = tuple((knot - first) / (places[-1] - first) for knot in places)
        return order - 1, points, places, _numbers([row[k] for k in weights])

    return values


#: What knots are rounded to where the file does not say it, as ezdxf does.
KNOT_TOLERANCE = 1e-10


#: Tangents, fit points and their tolerance, flags and counts.
_OF_SPLINES = {11, 21, 31, 12, 22, 32, 13, 23, 33, 43, 44, 70, 72, 73, 74}
_KINDS: dict[str, _Kind] = {
    "LINE": _Kind({10, 20, 11, 21}, {30, 31}, {39}, 1, _line),
    "CIRCLE": _Kind({10, 20, 40}, {30}, {39}, 1, _circle),
    "ARC": _Kind({10, 20, 40, 50, 51}, {30}, {39}, 2, _circle),
    "ELLIPSE": _Kind({10, 20, 11, 21, 40, 41, 42}, {30, 31}, {39}, 1, _ellipse),
    "LWPOLYLINE": _Kind(
        {10, 20},
        {38, 42, 70},
        {39, 40, 41, 43, 90, 91},
        1,
        _polyline,
        many={10, 20, 40, 41, 42, 91},
        in_r12=False,
    ),
    "SPLINE": _Kind(
        {10, 20, 40, 71},
        {30, 41, 42},
        _OF_SPLINES,
        1,
        _spline,
        many={10, 20, 30, 11, 21, 31, 40, 41},
        in_r12=False,
    ),
}
