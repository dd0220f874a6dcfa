"""Round tubes with any cuts in any place: the contours that are read are where the wall is cut.

Points of the outside are held against the cutters' own formulas, which know of no reader.
"""

from collections.abc import Sequence
from math import cos, pi, sin
from random import Random

import numpy as np
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import affinity

from beamcam.errors import Severity, Source
from beamcam.geometry.array_types import Floats
from beamcam.model.part import Contour
from beamcam.readers.ifc import Options, read
from beamcam.readers.ifc.body import body_of
from beamcam.readers.ifc.finish import Shaped
from beamcam.readers.ifc.semantic import read_swept
from beamcam.solid.stock_solid import shape_of
from tests.conftest import PROFILE, examples
from tests.property.ifc_builder import Vec
from tests.property.ifc_cuts import Bar, Box, Cuts, Cutter, Half, Round
from tests.unit.readers.ifc.models import opened

AT = Source("m.ifc")
FAR = 1e4
NEAR = 0.03  #: mm beside a contour, where a point says nothing
TUBES = ((168.3, 8.0), (88.9, 5.0), (273.0, 12.5), (60.3, 2.9))  #: diameters and walls


class Turned(Cuts):
    """Members that lie anywhere, their seam anywhere: the cutters are turned about the axis."""

    def __init__(self, random: Random) -> None:
        super().__init__()
        self.about = random.uniform(0.0, 2 * pi)
        axes, _ = np.linalg.qr(np.array([[random.gauss(0, 1) for _ in range(3)] for _ in range(3)]))
        self.axes = axes * np.sign(np.linalg.det(axes))
        self.at = np.array([random.uniform(-3e3, 3e3) for _ in range(3)])

    def point(self, bar: Bar, p: Vec) -> Vec:
        x, y, z = (self.axes @ super().point(bar, self.turned(bar, p)) + self.at).tolist()
        return x, y, z

    def turned(self, bar: Bar, p: Vec) -> Vec:
        """A point of the cutters, of the tube."""
        r, c, s = bar.sizes[0] / 2, cos(self.about), sin(self.about)
        y, z = p[1] - r, p[2] - r
        return p[0], r + c * y - s * z, r + s * y + c * z

    def model(self, bar: Bar, cutters: Sequence[Cutter]) -> bytes:
        o, along, across = (
            self.axes @ v + self.at * by
            for v, by in (((0, 0, 0), 1.0), ((1, 0, 0), 0.0), ((0, 1, 0), 0.0))
        )
        at = self.step.axes(tuple(o), tuple(along), tuple(across))
        body = self.small.extruded(self.profile(bar), bar.length, at)
        self.small.element(self.small.minus(body, *(self.cutter(bar, c) for c in cutters)))
        return self.small.data


def holds(cutter: Cutter, points: Floats) -> Floats:
    """Whether points (n, 3) of (x, Y, Z) lie in a cutter."""
    match cutter:
        case Half():
            return (points - cutter.at) @ np.array(cutter.normal) > 0.0
        case Round():
            axis = np.zeros(3)
            axis[cutter.along], axis[0] = cos(cutter.lean), sin(cutter.lean)
            off = points - cutter.at
            along = off @ axis
            apart = np.linalg.norm(off - along[:, None] * axis, axis=1)
            return (apart < cutter.diameter / 2) & (along > 0.0) & (along < cutter.depth)
        case Box():
            about_y, about_z = cutter.tilt
            up = np.array([about_y, 0.0, 1.0]) / np.hypot(about_y, 1.0)
            along = np.array([1.0, about_z, -about_y])
            along = along - (along @ up) * up
            along /= np.linalg.norm(along)
            low, high = np.array(cutter.low), np.array(cutter.high)
            off = points - (low + high) / 2
            sizes = (high - low) / 2
            inside = [np.abs(off @ way) < size for way, size in
                      zip((along, np.cross(up, along), up), sizes, strict=True)]  # fmt: skip
            return np.logical_and.reduce(inside)


def stays(bar: Bar, cutters: Sequence[Cutter], x: Floats, turn: Floats) -> Floats:
    """Whether the outside is steel at places of it."""
    r = bar.sizes[0] / 2
    points = np.column_stack((x, r - r * np.cos(turn), r + r * np.sin(turn)))
    gone = np.logical_or.reduce([holds(one, points) for one in cutters])
    return (x > 0.0) & (x < bar.length) & ~gone


def steel_of(shaped: Shaped) -> shapely.Geometry:
    """What the contours leave of the unrolled outside, on three turns."""
    turn = pi * shaped.section.height
    contours = [f for f in shaped.features if isinstance(f, Contour)]
    shapes = {kind: [shape_of(c.curves) for c in contours if c.kind == kind]
              for kind in ("outer", "inner")}  # fmt: skip
    whole = shapely.union_all(shapes["outer"] or [shapely.box(-9.0, 0.0, FAR, turn)])
    several = [
        shapely.union_all([affinity.translate(one, 0.0, k * turn)
                           for one in of for k in range(-2, 4)])
        for of in ([whole], shapes["inner"])
    ]  # fmt: skip
    return several[0].difference(several[1])


def some_cuts(random: Random, bar: Bar) -> list[Cutter]:
    """An end each, and windows between them, far apart."""
    d = bar.sizes[0]
    cutters: list[Cutter] = []
    for end in (False, True):
        at, way = (bar.length, 1.0) if end else (0.0, -1.0)
        kind = random.choice(("square", "slot", "saddle", "mitre", "roof", "cope", "mitred slot"))
        long, wide = random.uniform(20.0, 150.0), random.uniform(0.1, 0.7) * d
        x = sorted((at - way * long, at + way * 20.0))
        if "slot" in kind:
            cutters.append(
                Box((x[0], -9.0, (d - wide) / 2), (x[1], d + 9.0, (d + wide) / 2),
                    (0.0, random.choice((0.0, random.uniform(-0.1, 0.1)))))
            )  # fmt: skip
        if kind == "saddle":
            lean, wide = (
                random.choice((0.0, random.uniform(-0.7, 0.7))),
                random.uniform(1.05, 3) * d,
            )
            beside = random.choice((0.0, random.uniform(-0.1, 0.1))) * d
            middle = at + way * (wide / 2 - random.uniform(0.3, 0.45) * wide)
            cutters.append(
                Round((middle - 3 * d * sin(lean), d / 2 - 3 * d * cos(lean), d / 2 + beside), 1,
                      wide, 6 * d, lean)
            )  # fmt: skip
        for _ in range({"mitre": 1, "mitred slot": 1, "roof": 2}.get(kind, 0)):
            turn, lean = random.uniform(-0.8, 0.8), random.uniform(-0.8, 0.8)
            normal = way * cos(turn) * cos(lean), sin(turn) * cos(lean), sin(lean)
            cutters.append(Half((at - way * 20.0, d / 2, d / 2), normal))
        if kind == "cope":
            up = random.uniform(0.1, 0.7) * d
            cutters.append(Box((x[0], up, -9.0), (x[1], d + 9.0, d + 9.0)))
    for x in (1100.0, 1400.0)[: random.randrange(3)]:
        wide = random.uniform(0.1, 0.6) * d
        if random.random() < 0.5:
            cutters.append(Box((x, -9.0, (d - wide) / 2), (x + 80.0, d / 2, (d + wide) / 2)))
        else:
            beside = random.uniform(-0.15, 0.15) * d
            lean = random.uniform(-0.6, 0.6)
            deep = random.choice((0.9, 2.0)) * d
            cutters.append(Round((x, d / 2, d / 2 + beside), 1, wide, deep, lean))
    return cutters


def random_tube(seed: int) -> tuple[Turned, Bar, list[Cutter], bytes]:
    random = Random(seed)
    d, wall = random.choice(TUBES)
    bar = Bar("RO", 2500.0, (d, d, wall, wall, 0.0))
    made, cutters = Turned(random), some_cuts(random, bar)
    return made, bar, cutters, made.model(bar, cutters)


def shaped_of(data: bytes) -> Shaped:
    model = opened(data)
    (element,) = model.file.by_type("IfcBeam")
    return read_swept(model, element, body_of(model, element), AT)


def wrong_places(made: Turned, bar: Bar, cutters: list[Cutter], shaped: Shaped) -> list[Vec]:
    """Places of the outside where cutters and contours disagree, beyond their chords."""
    rng, r = np.random.default_rng(1), bar.sizes[0] / 2
    xs = np.concatenate([rng.uniform(low, high, 3000) for low, high in
                         ((-5.0, 400.0), (1000.0, 1600.0), (2200.0, 2505.0))])  # fmt: skip
    turns = rng.uniform(0.0, 2 * pi, len(xs))
    back, corner = shaped.frame.inverse(), made.point(bar, (0.0, 0.0, 0.0))
    ways = [np.array(made.vector(bar, v)) for v in ((1, 0, 0), (0, 1, 0), (0, 0, 1))]
    on_tube = (xs, r - r * np.cos(turns), r + r * np.sin(turns))
    points = corner + sum(n[:, None] * way for n, way in zip(on_tube, ways, strict=True))
    rows = np.array([back.point((x, y, z)) for x, y, z in points.tolist()])
    us = np.arctan2(rows[:, 2] - r, r - rows[:, 1]) * r
    steel, places = steel_of(shaped), shapely.points(rows[:, 0], us)
    shapely.prepare(steel)
    near = shapely.dwithin(steel.boundary, places, NEAR)
    if not any(f.kind == "outer" for f in shaped.features if isinstance(f, Contour)):
        near |= (xs < 900.0) | (xs > 1700.0)  # its ends are planes
    wrong = (shapely.contains(steel, places) != stays(bar, cutters, xs, turns)) & ~near
    return [(x, u, 0.0) for x, u in np.column_stack((rows[:, 0], us))[wrong].tolist()]


@settings(max_examples=examples(5), deadline=None)
@given(st.integers(0, 10**6))
def test_the_contours_are_where_the_cutters_are(seed: int) -> None:
    made, bar, cutters, data = random_tube(seed)
    assert wrong_places(made, bar, cutters, shaped_of(data)) == []


@settings(max_examples=1 if PROFILE == "same" else 2, deadline=None)
@given(st.integers(0, 10**6))
def test_the_kernel_has_nothing_against_it(seed: int) -> None:
    found = read(random_tube(seed)[-1], "m.ifc", options=Options(kernel=True))
    assert [d for d in found.diagnostics if d.severity is not Severity.NOTE
            and d.code != "ifc-square-cut"] == []  # fmt: skip
