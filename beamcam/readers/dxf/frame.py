"""From the coordinates of a drawing or a block, and of an entity's own plane, to mm in X and Y."""

from typing import Any

from msgspec import Struct

from beamcam.geometry.plane import Matrix, Point

Vector = tuple[float, float, float]
Axes = tuple[Vector, Vector, Vector]  #: x, y and z of a plane, each of length 1
Row = tuple[float, float, float, float]  #: x' = a x + b y + c z + d

#: The axes of a plane that is seen from above, as the drawing is.
FROM_ABOVE: Axes = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


class Frame(Struct, frozen=True):
    """An affine map of space, as its three rows; the third gives the height above the drawing."""

    x: Row
    y: Row
    z: Row

    def height(self, v: Vector) -> float:
        return _value(self.z, v)

    def point(self, v: Vector) -> Point:
        """A point in plan view."""
        return _value(self.x, v), _value(self.y, v)

    def vector(self, v: Vector) -> Point:
        """The image of a direction, seen from above."""
        return _slope(self.x, v), _slope(self.y, v)

    def inside(self, matrix: Any) -> "Frame":
        """The frame of a block that an insert places by `matrix` (ezdxf's, vectors are rows)."""
        ux, uy, uz, origin = (
            (row[0], row[1], row[2]) for row in (matrix.get_row(k) for k in range(4))
        )

        def composed(row: Row) -> Row:
            return _slope(row, ux), _slope(row, uy), _slope(row, uz), _value(row, origin)

        return Frame(composed(self.x), composed(self.y), composed(self.z))

    def plane(self, axes: Axes, elevation: float) -> Matrix:
        """The map of the plane of the first two axes at `elevation` along the third, to mm."""
        ux, uy, uz = axes
        base = (uz[0] * elevation, uz[1] * elevation, uz[2] * elevation)
        x, y = ((_slope(row, ux), _slope(row, uy), _value(row, base)) for row in (self.x, self.y))
        return x, y


def in_world(axes: Axes, point: Vector) -> Vector:
    """A point of an entity's own plane in the coordinates of the drawing."""
    if axes is FROM_ABOVE:
        return point
    (ux, uy, uz), (x, y, z) = axes, point
    return (
        ux[0] * x + uy[0] * y + uz[0] * z,
        ux[1] * x + uy[1] * y + uz[1] * z,
        ux[2] * x + uy[2] * y + uz[2] * z,
    )


def scaled(mm: float) -> Frame:
    """The frame of a drawing whose unit is `mm` long."""
    return Frame((mm, 0.0, 0.0, 0.0), (0.0, mm, 0.0, 0.0), (0.0, 0.0, mm, 0.0))


def _value(row: Row, v: Vector) -> float:
    return row[0] * v[0] + row[1] * v[1] + row[2] * v[2] + row[3]


def _slope(row: Row, v: Vector) -> float:
    return row[0] * v[0] + row[1] * v[1] + row[2] * v[2]
