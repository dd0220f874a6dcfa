"""Circles as drawing programs write them, as four cubics with rounded numbers."""

from itertools import pairwise
from math import pi, tan

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from beamcam.controllers import table_run
from beamcam.controllers.moves import Moves
from beamcam.geometry.curves import Bezier, Curve
from beamcam.geometry.polylines import points_at
from beamcam.pipeline import post
from tests.conftest import examples
from tests.distances import distances
from tests.unit.sheets.parts import contour, drawing, table

#: mm that a program may be off what is drawn, whatever is drawn.
MOST = 0.03


def cubics(radius: float, decimals: int, size: float, handle: float) -> tuple[Curve, ...]:
    """A circle, its coordinates rounded to decimals of a unit that is drawn `size` mm wide."""

    def place(x: float, y: float) -> tuple[float, float]:
        return tuple(round((2 * radius + v) / size, decimals) * size for v in (x, y))  # type: ignore[return-value]

    r, k = radius, radius * handle
    ends = [(r, 0.0), (0.0, r), (-r, 0.0), (0.0, -r), (r, 0.0)]
    return tuple(
        Bezier((
            place(ax, ay), place(ax - k * ay / r, ay + k * ax / r),
            place(bx + k * by / r, by - k * bx / r), place(bx, by),
        ))
        for (ax, ay), (bx, by) in pairwise(ends)
    )  # fmt: skip


def path_of(moves: Moves) -> shapely.LineString:
    """The feeds of a program, arcs as chords no farther off than 0.0002 mm."""
    found = []
    for k in np.flatnonzero(~moves.rapid):
        found.append(moves.start[k : k + 1])
        if moves.is_arc[k]:
            x, y, radius, first, sweep = moves.arcs[k]
            turns = np.radians(first + sweep * np.linspace(0, 1, 2000))
            found.append(np.stack((x + radius * np.cos(turns), y + radius * np.sin(turns)), 1))
        found.append(moves.end[k : k + 1])
    return shapely.LineString(np.concatenate(found))


@pytest.mark.parametrize("name", ["laser-grbl", "plate-linuxcnc"])
@settings(max_examples=examples(15), deadline=None)
@given(
    st.floats(3.0, 140.0),
    st.sampled_from((2, 3, 6)),
    st.sampled_from((2.0, 8.333, 12.5)),
    st.sampled_from((4 / 3 * tan(pi / 8), 0.55, 0.553)),
)
def test_what_is_cut_lies_within_the_tolerance_of_what_is_drawn(
    name: str, radius: float, decimals: int, size: float, handle: float
) -> None:
    drawn = cubics(radius, decimals, size, handle)
    machine = table(name, kerf_by="none", lead="none")
    posted = post((drawing(contour(drawn)),), machine)  # the read-back takes it
    done, _ = table_run(posted.text, machine, "JOB")
    places = np.concatenate([points_at(curve, np.linspace(0, 1, 100)) for curve in drawn])
    shift = np.array(posted.plan.shift)
    away = distances(places + shift, path_of(done.moves))
    assert np.max(away) < MOST
