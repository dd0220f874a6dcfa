"""Points, vectors and frames in space, as plain tuples: a member has too few for numpy to pay."""

from math import sqrt

from msgspec import Struct

Vec = tuple[float, float, float]

ORIGIN: Vec = (0.0, 0.0, 0.0)
RIGID = 1e-13  #: by which the axes of a rigid frame may be off 1 and off square, from rounding


def add(a: Vec, b: Vec) -> Vec:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def sub(a: Vec, b: Vec) -> Vec:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def scale(a: Vec, by: float) -> Vec:
    return a[0] * by, a[1] * by, a[2] * by


def dot(a: Vec, b: Vec) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vec, b: Vec) -> Vec:
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def size(a: Vec) -> float:
    return sqrt(dot(a, a))


def unit(a: Vec) -> Vec:
    """The vector of length 1 along `a`. Raises ValueError for the zero vector."""
    length = size(a)
    if length == 0.0:
        raise ValueError("the zero vector has no direction")
    return scale(a, 1 / length)


def across(a: Vec) -> Vec:
    """A unit vector square to `a`, along the axis that `a` has least of."""
    least = min(range(3), key=lambda i: abs(a[i]))
    axis: Vec = (float(least == 0), float(least == 1), float(least == 2))
    return unit(cross(a, axis))


class Frame(Struct, frozen=True):
    """An affine map by its columns; the axes may be scaled, and left-handed after a mirror."""

    o: Vec = ORIGIN
    x: Vec = (1.0, 0.0, 0.0)
    y: Vec = (0.0, 1.0, 0.0)
    z: Vec = (0.0, 0.0, 1.0)

    def vector(self, vector: Vec) -> Vec:
        """A direction of this frame, in the frame that it stands in."""
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = self.x, self.y, self.z
        u, v, w = vector
        return ax * u + bx * v + cx * w, ay * u + by * v + cy * w, az * u + bz * v + cz * w

    def point(self, p: Vec) -> Vec:
        """A point of this frame, in the frame that it stands in."""
        return add(self.o, self.vector(p))

    def times(self, inner: "Frame") -> "Frame":
        """`inner`, which stands in this frame, in the frame that this one stands in."""
        if self is IDENTITY or inner is IDENTITY:
            return inner if self is IDENTITY else self
        # Most of a model's arithmetic is here, and calls cost more than sums.
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = self.x, self.y, self.z
        x, y, z, o = [
            (ax * u + bx * v + cx * w, ay * u + by * v + cy * w, az * u + bz * v + cz * w)
            for u, v, w in (inner.x, inner.y, inner.z, inner.o)
        ]
        return Frame(add(self.o, o), x, y, z)

    @property
    def rigid(self) -> bool:
        """Whether lengths and right angles are kept; a mirror keeps them too."""
        x, y, z = self.x, self.y, self.z
        return (
            abs(dot(x, x) - 1.0) < RIGID
            and abs(dot(y, y) - 1.0) < RIGID
            and abs(dot(z, z) - 1.0) < RIGID
            and abs(dot(x, y)) < RIGID
            and abs(dot(y, z)) < RIGID
            and abs(dot(z, x)) < RIGID
        )

    def inverse(self) -> "Frame":
        """The map back. Raises ValueError if the axes lie in one plane."""
        yz, zx, xy = cross(self.y, self.z), cross(self.z, self.x), cross(self.x, self.y)
        det = dot(self.x, yz)
        if abs(det) < 1e-12:
            raise ValueError("the axes of the placement lie in one plane")
        rows = (scale(yz, 1 / det), scale(zx, 1 / det), scale(xy, 1 / det))
        back = Frame(
            ORIGIN,
            (rows[0][0], rows[1][0], rows[2][0]),
            (rows[0][1], rows[1][1], rows[2][1]),
            (rows[0][2], rows[1][2], rows[2][2]),
        )
        return Frame(scale(back.vector(self.o), -1.0), back.x, back.y, back.z)


IDENTITY = Frame()
