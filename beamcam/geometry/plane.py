"""Points, boxes, directions and affine maps of the plane."""

from collections.abc import Callable, Hashable, Iterable, Sequence
from math import cos, hypot, radians, sin
from typing import TypeVar

Point = tuple[float, float]
Box = tuple[float, float, float, float]  #: minimum x, minimum y, maximum x, maximum y
#: mm that a coordinate may have at most: 1,000 km. Sums and squares of such stay numbers, and keep
#: their digits to a thousandth.
MAX_COORDINATE = 1e9

Matrix = tuple[tuple[float, float, float], tuple[float, float, float]]
#: rows (a, b, c) and (d, e, f): x' = a x + b y + c, y' = d x + e y + f

IDENTITY: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))

#: How far the two axes of a similarity may differ, relative to its scale.
SIMILARITY_SLACK = 1e-12


def unit_vector(angle_deg: float) -> Point:
    """Cosine and sine of an angle in degrees, exact at multiples of 90."""
    turns, rest = divmod(angle_deg, 90.0)
    c, s = (1.0, 0.0) if rest == 0.0 else (cos(radians(rest)), sin(radians(rest)))
    return ((c, s), (-s, c), (-c, -s), (s, -c))[int(turns) % 4]


def normalized(vector: Point) -> Point:
    """The vector of length 1 along `vector`. Raises ValueError for the zero vector."""
    x, y = vector
    size = hypot(x, y)
    if size == 0.0:
        raise ValueError("the zero vector has no direction")
    return x / size, y / size


def cross(a: Point, b: Point) -> float:
    """Area of the parallelogram of two vectors, positive if `b` lies left of `a`."""
    return a[0] * b[1] - a[1] * b[0]


def dot(a: Point, b: Point) -> float:
    """Scalar product of two vectors."""
    return a[0] * b[0] + a[1] * b[1]


def distance(a: Point, b: Point) -> float:
    """Distance of two points."""
    return hypot(b[0] - a[0], b[1] - a[1])


def between(a: Point, b: Point, t: float) -> Point:
    """The point at share `t` of the way from `a` to `b`; 0 and 1 give them exactly."""
    return b if t == 1.0 else (a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]))


def mapped(matrix: Matrix, point: Point) -> Point:
    """The image of a point."""
    (a, b, c), (d, e, f) = matrix
    x, y = point
    return a * x + b * y + c, d * x + e * y + f


def mapped_vector(matrix: Matrix, vector: Point) -> Point:
    """The image of a direction: the matrix without its shift."""
    (a, b, _), (d, e, _) = matrix
    return a * vector[0] + b * vector[1], d * vector[0] + e * vector[1]


def determinant(matrix: Matrix) -> float:
    """By how much areas grow; negative if the matrix mirrors, 0 if it flattens the plane."""
    (a, b, _), (d, e, _) = matrix
    return a * e - b * d


def is_similarity(matrix: Matrix) -> bool:
    """Whether circles stay circles: turns, shifts, mirrors and one scale for both axes."""
    (a, b, _), (d, e, _) = matrix
    slack = SIMILARITY_SLACK * (a * a + b * b + d * d + e * e)
    return abs(a * a + d * d - b * b - e * e) <= slack and abs(a * b + d * e) <= slack


def refuse_singular(matrix: Matrix) -> None:
    """Raises ValueError if `matrix` flattens the plane to a line or a point."""
    (a, b, _), (d, e, _) = matrix
    if abs(determinant(matrix)) <= 1e-12 * (a * a + b * b + d * d + e * e):
        raise ValueError("the matrix flattens the plane (its determinant is 0)")


def join_boxes(boxes: list[Box]) -> Box | None:
    """The box around all `boxes`; None if there are none."""
    if not boxes:
        return None
    x0, y0, x1, y1 = zip(*boxes, strict=True)
    return min(x0), min(y0), max(x1), max(y1)


def box_around(points: Sequence[Point]) -> Box:
    """The bounding box of one or more points."""
    xs = [p[0] for p in points]
    ys = [p[1] for p in points]
    return min(xs), min(ys), max(xs), max(ys)


# Nodes and weights of the Gauss-Legendre rule with ten points, upper half: exact to degree 19.
_GAUSS = (
    (0.1488743389816312, 0.2955242247147529),
    (0.4333953941292472, 0.2692667193099963),
    (0.6794095682990244, 0.2190863625159820),
    (0.8650633666889845, 0.1494513491505806),
    (0.9739065285171717, 0.0666713443086881),
)

MAX_HALVINGS = 24  #: of the range, by `integrate`


def integrate(
    function: Callable[[float], float], low: float = 0.0, high: float = 1.0, floor: float = 0.0
) -> float:
    """Integral of a function that is smooth but for a few points, to about 1e-12 relative.

    Ten-point Gauss rule over the whole and over the halves; halves again where they differ by
    more than rounding can (measured by the integral of the function's size) and by more than
    `floor`, what rounding makes of a 0.
    """

    def rule(a: float, b: float) -> tuple[float, float]:
        centre, half = (a + b) / 2, (b - a) / 2
        total = size = 0.0
        for x, w in _GAUSS:
            left, right = function(centre - half * x), function(centre + half * x)
            total += w * (left + right)
            size += w * (abs(left) + abs(right))
        return half * total, half * size

    def refine(a: float, b: float, whole: float, left: int) -> float:
        middle = (a + b) / 2
        first, second = rule(a, middle)[0], rule(middle, b)[0]
        if left == 0 or abs(first + second - whole) <= slack:
            return first + second
        return refine(a, middle, first, left - 1) + refine(middle, b, second, left - 1)

    estimate, size = rule(low, high)
    slack = max(floor, 1e-12 * size)
    return refine(low, high, estimate, MAX_HALVINGS)


Member = TypeVar("Member", bound=Hashable)


def groups_of(pairs: Iterable[tuple[Member, Member]]) -> list[list[Member]]:
    """What hangs together by pairs, group by group, in the order in which each is first named."""
    group_of: dict[Member, list[Member]] = {}
    for a, b in pairs:
        one, other = group_of.setdefault(a, [a]), group_of.setdefault(b, [b])
        if len(one) < len(other):
            one, other = other, one
        if one is not other:
            one += other
            group_of.update(dict.fromkeys(other, one))
    return list({id(group): group for group in group_of.values()}.values())
