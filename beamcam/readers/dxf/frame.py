"""From the coordinates of a drawing or a block, and of an entity's own plane, to mm in X and Y."""

from typing import Any

from msgspec import Struct

from beamcam.geometry.plane import Matrix, Point

Vector = tuple[float, float, float]
Row = tuple[float, float, float, float]  #: x' = a x + b y + c z + d


class Frame(Struct, frozen=True):
    """An affine map of space, as its three rows; the third gives the height above the drawing."""

    x: Row
    y: Row
    z: Row

    def height(self, v: Vector) -> float:
        return _value(self.z, v)

    def point(self, v: Vector) -> Point:
        """Where a point comes to lie, seen from above."""
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

    def plane(self, ux: Vector, uy: Vector, uz: Vector, elevation: float) -> Matrix:
        """The map of the plane that `ux` and `uy` span at `elevation` along `uz`, to mm."""
        base = (uz[0] * elevation, uz[1] * elevation, uz[2] * elevation)
        x, y = ((_slope(row, ux), _slope(row, uy), _value(row, base)) for row in (self.x, self.y))
        return x, y


def scaled(mm: float) -> Frame:
    """The frame of a drawing whose unit is `mm` long."""
    return Frame((mm, 0.0, 0.0, 0.0), (0.0, mm, 0.0, 0.0), (0.0, 0.0, mm, 0.0))


def _value(row: Row, v: Vector) -> float:
    return row[0] * v[0] + row[1] * v[1] + row[2] * v[2] + row[3]


def _slope(row: Row, v: Vector) -> float:
    return row[0] * v[0] + row[1] * v[1] + row[2] * v[2]
