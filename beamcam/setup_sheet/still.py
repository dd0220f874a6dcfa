"""The solid of a setup sheet as a still picture for paper: shaded triangles, each pixel by depth.

It is seen as the page shows it first (static/solid.js): from the front, somewhat from the right and
from above, by a parallel projection.
"""

import base64
import zlib
from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import cos, sin
from typing import Any

import numpy as np
from msgspec import Struct

from beamcam.geometry.array_types import Counts, Floats
from beamcam.setup_sheet.solid_data import GRID

YAW, PITCH = -0.45, 0.45  #: rad
SUN = np.array((-0.395, 0.543, 0.741))  #: where the light comes from: right, up, to the viewer
STEEL, INK = (159.0, 182.0, 209.0), (28, 37, 48)  #: red, green, blue
SHARP = 0.8  #: cosine of the angle between two triangles whose edge is drawn, at most
FINER = 2  #: pixels drawn for one of the picture, each way
MARGIN = 0.04  #: share of the picture that stays free on each side

#: Right, up and towards the viewer, in axes of the solid: x along the bar, y up, z to the front.
TURN = np.array((
    (cos(YAW), 0.0, sin(YAW)),
    (sin(PITCH) * sin(YAW), cos(PITCH), -sin(PITCH) * cos(YAW)),
    (-cos(PITCH) * sin(YAW), sin(PITCH), cos(PITCH) * cos(YAW)),
))  # fmt: skip
#: Where along a face its letter may stand, the best before the others; its radius in pixels.
SHARES = (0.5, 0.45, 0.55, 0.4, 0.6, 0.35, 0.65, 0.3, 0.7)
LETTER = 18
#: Which side of the box the letter of a face stands on: axis, and its greater or lesser end.
SIDES = {"v": (2, 1), "h": (2, -1), "o": (1, 1), "u": (1, -1)}


class Still(Struct, frozen=True):
    """A picture: its pixels from above, and the letters of the faces that are seen."""

    pixels: Any  #: (rows, columns, 3) bytes
    letters: tuple[tuple[str, float, float], ...]  #: letter, shares of the width and the height


def still_of(pieces: Sequence[dict[str, Any]], faces: str, wide: int, high: int) -> Still:
    """The packed pieces of a solid in a picture of `wide` and at most `high` pixels."""
    meshes = [_unpacked(piece) for piece in pieces]
    low = np.min([points.min(axis=0) for points, _ in meshes], axis=0)
    top = np.max([points.max(axis=0) for points, _ in meshes], axis=0)
    seen = np.concatenate([points for points, _ in meshes]) @ TURN.T
    least, most = seen.min(axis=0), seen.max(axis=0)
    span = np.maximum(most - least, 1e-6)
    room = 1 - 2 * MARGIN
    scale = min(wide * room / span[0], high * room / span[1])
    high = min(high, round(span[1] * scale / room))
    middle = (least + most) / 2

    def placed(points: Floats) -> Floats:
        at = (points @ TURN.T - middle) * scale * FINER
        at[:, :2] *= (1.0, -1.0)
        at[:, :2] += np.array((wide, high)) * FINER / 2
        pixels: Floats = at
        return pixels

    canvas = _Canvas(wide * FINER, high * FINER)
    for points, triangles in meshes:
        canvas.draw(placed(points), points, triangles)
    pixels = canvas.smaller()

    def differing(place: Floats) -> float:
        """How much of the picture about a place is not as there: no letter hides a hole."""
        x, y = (int(v) for v in place)
        about = pixels[max(y - LETTER, 0) : y + LETTER + 1, max(x - LETTER, 0) : x + LETTER + 1]
        return float((about != pixels[y, x]).any(axis=2).mean()) if about.size else 1.0

    letters = []
    for face in faces:
        axis, side = SIDES[face]
        if side * TURN[2, axis] > 0.12:
            along = np.tile((low + top) / 2, (len(SHARES), 1))
            along[:, 0] = low[0] + np.array(SHARES) * (top[0] - low[0])
            along[:, axis] = (top if side > 0 else low)[axis]
            x, y = min(placed(along)[:, :2] / FINER, key=differing)
            letters.append((face, float(x / wide), float(y / high)))
    return Still(pixels, tuple(letters))


def _unpacked(piece: dict[str, Any]) -> tuple[Floats, Counts]:
    """Points in mm and triangles of a piece; the form: solid_data.py."""
    data = zlib.decompress(base64.b64decode(piece["data"]))
    count, wide = piece["points"], piece["wide"]
    columns = [_numbers(data[2 * count * k :], count, 2) for k in range(3)]
    box = np.array(piece["box"])
    points: Floats = box[:3] + np.stack(columns, axis=1) / GRID * box[3:]
    return points, _numbers(data[6 * count :], 3 * piece["triangles"], wide).reshape(-1, 3)


def _numbers(data: bytes, count: int, wide: int) -> Counts:
    planes = np.frombuffer(data[: count * wide], dtype=np.uint8).reshape(wide, count)
    steps = sum(planes[k].astype(np.int64) << 8 * k for k in range(wide))
    numbers: Counts = np.cumsum(steps) % 256**wide
    return numbers


class _Canvas:
    """Pixels with the depth of what they show."""

    def __init__(self, wide: int, high: int) -> None:
        self.colours = np.full((high, wide, 3), 255.0)
        self.depth = np.full((high, wide), -np.inf)

    def draw(self, at: Floats, points: Floats, triangles: Counts) -> None:
        """A piece: its points in pixels and in mm."""
        corners = points[triangles]
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
        facing = normals @ TURN.T
        light = 0.5 + 0.5 * np.maximum(0.0, facing @ SUN)
        for k in np.flatnonzero(facing[:, 2] > 0):
            self._fill(at[triangles[k]], np.array(STEEL) * light[k])
        for a, b in _edges(triangles, normals):
            self._line(at[a], at[b])

    def _fill(self, corners: Floats, colour: Floats) -> None:
        a, b, c = corners
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        first, last = np.ceil(corners[:, 0].min()), np.floor(corners[:, 0].max())
        if not area or first > last:
            return
        # Column by column, as triangles of a bar are long and thin: a box would be mostly empty.
        columns = np.arange(int(first), int(last) + 1)
        low, high = np.full(len(columns), np.inf), np.full(len(columns), -np.inf)
        for p, q in ((a, b), (b, c), (c, a)):
            if p[0] == q[0]:
                continue
            share = (columns - p[0]) / (q[0] - p[0])
            on_side = (share >= 0) & (share <= 1)
            y = p[1] + share * (q[1] - p[1])
            low[on_side] = np.minimum(low, y)[on_side]
            high[on_side] = np.maximum(high, y)[on_side]
        top = np.ceil(np.where(np.isfinite(low), low, 0.0)).astype(int)
        counts = np.where(low <= high, np.floor(np.maximum(high, -1.0)).astype(int) - top + 1, 0)
        counts = np.maximum(counts, 0)
        x = np.repeat(columns, counts)
        y = np.repeat(top - np.cumsum(counts) + counts, counts) + np.arange(len(x))
        u = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / area
        v = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area
        near = a[2] + u * (b[2] - a[2]) + v * (c[2] - a[2])
        shown = near > self.depth[y, x]
        self.depth[y[shown], x[shown]] = near[shown]
        self.colours[y[shown], x[shown]] = colour

    def _line(self, a: Floats, b: Floats) -> None:
        steps = int(np.abs(b - a)[:2].max()) + 2
        at = a + np.linspace(0.0, 1.0, steps)[:, None] * (b - a)
        x, y = np.rint(at[:, :2]).astype(int).T
        seen = at[:, 2] > self.depth[y, x] - 2.0 * FINER
        self.colours[y[seen], x[seen]] = INK

    def smaller(self) -> Any:
        """The pixels of the picture, each the mean of those drawn for it."""
        high, wide, _ = self.colours.shape
        parts = self.colours.reshape(high // FINER, FINER, wide // FINER, FINER, 3)
        return np.rint(parts.mean(axis=(1, 3))).astype(np.uint8)


def _edges(triangles: Counts, normals: Floats) -> Iterator[tuple[int, int]]:
    """The points at the ends of each sharp edge."""
    sides = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    order = np.lexsort((sides[:, 1], sides[:, 0]))
    for one, other in pairwise(order):
        if (sides[one] == sides[other]).all() and normals[one // 3] @ normals[other // 3] < SHARP:
            yield int(sides[one, 0]), int(sides[one, 1])
