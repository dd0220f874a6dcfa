"""Openings in larger ones: planner and read-back agree with shapely, and no machine makes them."""

import csv
from itertools import pairwise, product
from pathlib import Path

import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace
from shapely import affinity

from beamcam.checks.within import needless
from beamcam.geometry.curves import Line
from beamcam.model.part import Contour, Hole, Part, Slot
from beamcam.planning.within import within_larger
from tests.runs import call
from tests.unit.sheets.parts import S, plate

NEAR = 0.3  #: mm; what is as near to the limit is not asked
places = st.integers(0, 40).map(float)
sizes = st.integers(2, 30).map(float)


def cut_out(x: float, y: float, wide: float, high: float) -> Contour:
    corners = [(x, y), (x + wide, y), (x + wide, y + high), (x, y + high), (x, y)]
    sides = tuple(Line(a, b) for a, b in pairwise(corners))
    return Contour("v", "inner", sides, S)


openings = st.one_of(
    st.builds(lambda x, y, d: Hole("v", x, y, d, S), places, places, sizes),
    st.builds(
        lambda x, y, d, u, v, turn: Slot("v", x, y, d, u, v, turn, S),
        places, places, sizes, sizes, st.sampled_from([0.0, 5.0]), st.sampled_from([0.0, 30, 90]),
    ),
    st.builds(cut_out, places, places, sizes, sizes),
)  # fmt: skip


def shape(one: Hole | Slot | Contour) -> shapely.Polygon:
    if isinstance(one, Contour):
        return shapely.Polygon([curve.start for curve in one.curves])
    if isinstance(one, Hole):
        return shapely.Point(one.x, one.y).buffer(one.diameter / 2, 64)
    u, v = one.length / 2, one.height / 2
    core = shapely.MultiPoint([*product((-u, u), (-v, v))]).convex_hull
    turned = affinity.rotate(core.buffer(one.diameter / 2, 64), one.angle, origin=(0, 0))
    return affinity.translate(turned, one.x, one.y)


@given(st.lists(openings, min_size=2, max_size=5))
def test_openings_in_others_are_those_that_shapely_finds(given_: list[Hole | Slot]) -> None:
    part = plate(*given_)
    said, found = set(within_larger(part)), set(needless(part))
    sure, maybe = set[int](), set[int]()
    for (k, small), large in product(enumerate(map(shape, given_)), map(shape, given_)):
        if small.area + 1.5 < large.area and large.buffer(0.02).covers(small):
            sure.add(k)
        if small.area < large.area and large.buffer(NEAR).covers(small):
            maybe.add(k)
    for each in (said, found):
        assert sure <= each <= maybe
    assert {*within_larger(replace(part, features=tuple(reversed(given_))))} == {
        len(given_) - 1 - k for k in said
    }


@pytest.mark.parametrize("rule", [within_larger, needless])
def test_what_stays_of_the_wall_is_no_room(rule: object) -> None:
    """A blind hole, a thread and what goes round another part hold no other hole."""
    small = Hole("v", 20, 20, 8.0, S)
    around = replace(cut_out(0, 0, 40, 40), kind="outer")
    for other in (
        Hole("v", 20, 20, 30.0, S, depth=4.0), Hole("v", 20, 20, 10.0, S, kind="thread"),
        Hole("u", 20, 20, 30.0, S), Hole("v", 20, 20, 8.0, S), around,
    ):  # fmt: skip
        assert not rule(plate(small, other)), other  # type: ignore[operator]
    frame = (around, cut_out(-9, -9, 60, 60), small)
    assert not rule(plate(*frame))  # type: ignore[operator]
    there: Part = replace(plate(small), made=(Hole("v", 21, 20, 20.0, S),))
    assert [*rule(there)] == [0]  # type: ignore[operator]


MACHINES = ("beamline", "beamline-pusher", "coper-linuxcnc", "tube-linuxcnc", "plate-linuxcnc",
            "plate-codesys")  # fmt: skip
HEADS = {"beamline": "I", "beamline-pusher": "I", "coper-linuxcnc": "I", "tube-linuxcnc": "M"}
SIZES = {"I": ("IPE200", 200, 100, 8.5, 5.6, 12), "M": ("SHS100X5", 100, 100, 5, 5, 10),
         "B": ("FL100X3", 100, 0, 0, 3, 0)}  # fmt: skip
NC1 = """ST
  D
  1
  1
  W1
  S235JR
  1
  {0}
  {code}
  600.00
  {1}
  {2}
  {3}
  {4}
  {5}
  0 
  0 
  0 
  0 
  0 
  0 




BO
  v 300.00s 50.00 30.00 0.00
  v 302.00s 50.00 20.00 0.00
EN
"""


@pytest.mark.parametrize("machine", MACHINES)
def test_no_machine_makes_them(machine: str, tmp_path: Path) -> None:
    code = HEADS.get(machine, "B")
    part, out = tmp_path / "w1.nc1", tmp_path / "w1.out"
    part.write_text(NC1.format(*SIZES[code], code=code))
    said = call("post", part, "--machine", machine, "-o", out, status=0).stderr
    told = next(line for line in said.splitlines() if "plan-within" in line)
    assert "w1.nc1:28: warning" in told
    assert "w1.nc1:27 and takes no steel" in told
    (row,) = csv.DictReader(out.with_name("w1.out.hand.csv").open())
    assert (row["why"], row["source"], row["size"]) == ("plan-within", "w1.nc1:28", "20")


def test_openings_that_overlap_are_cut_as_one_and_told(tmp_path: Path) -> None:
    part, out = tmp_path / "w1.nc1", tmp_path / "w1.ngc"
    part.write_text(NC1.format(*SIZES["I"], code="I").replace("302.00s", "312.00s"))
    said = call("post", part, "--machine", "coper-linuxcnc", "-o", out, status=0).stderr
    assert "w1.nc1:28: note plan-opening-overlap: found hole 20 on face v at x 312" in said
    assert not out.with_name("w1.ngc.hand.csv").exists()
