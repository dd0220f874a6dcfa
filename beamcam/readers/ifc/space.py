"""Points, vectors and frames in space, as plain tuples: a member has too few for numpy to pay."""

from math import sqrt

import numpy as np
from msgspec import Struct

from beamcam.geometry.array_types import Floats

Vec = tuple[float, float, float]

ORIGIN: Vec = (0.0, 0.0, 0.0)
EVEN = 1e-6  #: by which they may be off one length and off square, of a frame that keeps forms


def add(a: Vec, b: Vec) -> Vec:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def sub(a: Vec, b: Vec) -> Vec:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def scale(a: Vec, by: float) -> Vec:
    return a[0] * by, a[1] * by, a[2] * by


def dot(a: Vec, b: Vec) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vec, b: Vec) -> Vec:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def size(a: Vec) -> float:
    x, y, z = a
    return sqrt(x * x + y * y + z * z)


def unit(a: Vec) -> Vec:
    """The vector of length 1 along `a`. Raises ValueError for the zero vector."""
    if (length := size(a)) == 0.0:
        raise ValueError("the zero vector has no direction")
    return scale(a, 1 / length)


def across(a: Vec) -> Vec:
    """A unit vector square to `a`, along the axis that `a` has least of."""
    least = min(range(3), key=lambda i: abs(a[i]))
    axis: Vec = (float(least == 0), float(least == 1), float(least == 2))
    return unit(cross(a, axis))


class Frame(Struct, frozen=True, gc=False):
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
        (ox, oy, oz), (ax, ay, az), (bx, by, bz), (cx, cy, cz) = self.o, self.x, self.y, self.z
        u, v, w = p
        return (
            ox + (ax * u + bx * v + cx * w),
            oy + (ay * u + by * v + cy * w),
            oz + (az * u + bz * v + cz * w),
        )

    def times(self, inner: "Frame") -> "Frame":
        """`inner`, which stands in this frame, in the frame that this one stands in."""
        if self is IDENTITY or inner is IDENTITY:
            return inner if self is IDENTITY else self
        x, y, z = map(self.vector, (inner.x, inner.y, inner.z))
        return Frame(self.point(inner.o), x, y, z)

    @property
    def even(self) -> bool:
        """Whether it keeps the form of what lies in it, be it larger, smaller or mirrored."""
        x, y, z, xx = self.x, self.y, self.z, dot(self.x, self.x)
        off = dot(y, y) - xx, dot(z, z) - xx, dot(x, y), dot(y, z), dot(z, x)
        return max(map(abs, off)) < EVEN * xx

    def inverse(self) -> "Frame":
        """The map back. Raises ValueError if the axes lie in one plane."""
        yz, zx, xy = cross(self.y, self.z), cross(self.z, self.x), cross(self.x, self.y)
        det = dot(self.x, yz)
        if abs(det) < 1e-12:
            raise ValueError("the axes of the placement lie in one plane")
        rows = scale(yz, 1 / det), scale(zx, 1 / det), scale(xy, 1 / det)
        (ax, ay, az), (bx, by, bz), (cx, cy, cz) = rows
        o = -dot(rows[0], self.o), -dot(rows[1], self.o), -dot(rows[2], self.o)
        return Frame(o, (ax, bx, cx), (ay, by, cy), (az, bz, cz))


IDENTITY = Frame()


class Cylinder(Struct, frozen=True):
    """A cylinder by a point of its axis, the unit vector along it, and its radius."""

    point: Vec
    axis: Vec
    radius: float

    def off(self, points: Floats) -> Floats:
        """How many mm points (n, 3) lie off it."""
        across = np.cross(points - np.array(self.point), np.array(self.axis))
        off: Floats = np.abs(np.linalg.norm(across, axis=1) - self.radius)
        return off

    def moved(self, by: Frame) -> "Cylinder":
        """The cylinder elsewhere, as large as it is."""
        return Cylinder(by.point(self.point), unit(by.vector(self.axis)), self.radius)
