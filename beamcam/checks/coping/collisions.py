"""The torch and its holder against the bar, wherever a program takes them.

| holder |          The bar is the whole section along all of X, whatever was cut off
|__    __|          already. The torch is a box across the bar, from its tip outwards,
   |  |             and the holder a wider one behind it.
   |__|  tip
"""

from collections.abc import Iterator, Sequence
from itertools import groupby, pairwise
from math import cos, radians, sin

from beamcam.checks.coping import rules
from beamcam.checks.coping.section import Section, TubeSection
from beamcam.checks.coping.strokes import Way, poses
from beamcam.errors import MAX_OF_A_PROGRAM, Diagnostic, Source
from beamcam.machine.coper import Coper

Corner = tuple[float, float]

TURN_STEP_DEG = 3.0
HOLDER = 400.0  #: mm that it reaches outwards
SLACK = 0.03  #: mm: of figures as programs have them, and of a fillet's chords


def strike_faults(
    ways: Sequence[Way], section: Section | TubeSection, coper: Coper, name: str
) -> Iterator[Diagnostic]:
    """The first place of each move at which the torch comes nearer to the bar than it may."""
    import numpy as np
    from shapely import convex_hull, distance, multipoints

    swept: list[list[Corner]] = []
    poses_of: list[tuple[int, tuple[float, float, float, float]]] = []
    for way in _runs(ways):
        places = list(poses(way, coper, TURN_STEP_DEG))
        for before, after in pairwise(places):
            poses_of.append((way.line, after))
            for one, other in zip(_boxes(*before, coper), _boxes(*after, coper), strict=True):
                swept.append([*one, *other])
    if not swept:
        return
    corners = np.array(swept).reshape(-1, 2)
    hulls = convex_hull(multipoints(corners, indices=np.repeat(np.arange(len(swept)), 8)))
    near = distance(section.steel, hulls).reshape(-1, 2).min(axis=1)
    told: set[int] = set()
    for k in np.flatnonzero(near < coper.play - SLACK).tolist():
        line, (y, z, a, _) = poses_of[k]
        if line not in told and len(told) < MAX_OF_A_PROGRAM:
            told.add(line)
            yield rules.STRIKES.at(
                Source(name, line), found=f"{near[k]:.2f}", a=f"{a:g}", y=f"{y:.1f}",
                z=f"{z:.1f}", expected=f"{coper.play:g}",
            )  # fmt: skip


def _runs(ways: Sequence[Way]) -> Iterator[Way]:
    """The moves across the bar, those that follow one another along Y or along Z as one.

    What the torch sweeps on the way is what it sweeps from the least place to the greatest.
    """
    for (a_deg, b_deg, axis), group in groupby(ways, key=_kind_of):
        run = list(group)
        if axis is None:
            yield from run
            continue
        across = sorted(place[axis] for way in run for place in (way.start, way.end))
        start, end = list(run[0].start), list(run[0].start)
        start[axis], end[axis] = across[0], across[-1]
        yield Way(run[0].line, (*start,), (*end,), a_deg, b_deg)  # type: ignore[arg-type]


def _kind_of(way: Way) -> tuple[tuple[float, float], tuple[float, float], int | None]:
    """A and B at both ends, and the axis across the bar that alone moves; None if more do."""
    (_, ya, za), (_, yb, zb) = way.start, way.end
    if way.a_deg[0] != way.a_deg[1] or way.b_deg[0] != way.b_deg[1] or (ya != yb and za != zb):
        return way.a_deg, way.b_deg, None
    return way.a_deg, way.b_deg, (1 if za == zb else 2)


def _boxes(y: float, z: float, a_deg: float, b_deg: float, coper: Coper) -> list[list[Corner]]:
    """The corners of the torch and of its holder at a place of the tip, in (Y, Z).

    One that is tilted along the bar is as wide as before; its lower edges go down by half its width
    times sin(B).
    """
    a, b = radians(a_deg), abs(radians(b_deg))
    out, side = (-sin(a), cos(a)), (cos(a), sin(a))

    def at(along: float, across: float) -> tuple[float, float]:
        return y + along * out[0] + across * side[0], z + along * out[1] + across * side[1]

    torch, holder = coper.torch_width / 2, coper.head_width / 2
    long = coper.torch_length * cos(b)
    tip, back, far = -torch * sin(b), long - holder * sin(b), long + HOLDER
    return [
        [at(tip, -torch), at(tip, torch), at(long, torch), at(long, -torch)],
        [at(back, -holder), at(back, holder), at(far, holder), at(far, -holder)],
    ]
