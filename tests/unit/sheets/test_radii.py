"""Arcs that a controller does not take: its least and its greatest radius."""

import re

from hypothesis import assume, given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.sheets.compare import verify_sheet
from beamcam.machine import Machine
from beamcam.pipeline import post
from benchmarks.sheet_liars import MACHINES, told
from tests.conftest import examples

from .parts import circle, contour, drawing, table

NAMES = ("plate-linuxcnc", "plate-codesys", "laser-grbl")


def limited(machine: Machine, **values: float) -> Machine:
    assert machine.torch is not None
    return replace(machine, torch=replace(machine.torch, **values))  # type: ignore[arg-type]


def machine_of(name: str) -> Machine:
    material = "wood" if name == "laser-grbl" else "mild steel"
    return table(name, material=material, kerf_by="none", lead="none")


@settings(deadline=None, max_examples=examples(15))
@given(
    st.sampled_from(NAMES), st.floats(2.0, 60.0), st.floats(2.0, 60.0),
    st.sampled_from(("min_radius", "max_radius")),
)  # fmt: skip
def test_an_arc_out_of_the_range_is_refused_and_the_planner_has_none(
    name: str, radius: float, limit: float, key: str
) -> None:
    assume(abs(radius - limit) > 0.01)
    free = machine_of(name)
    machine, part = limited(free, **{key: limit}), drawing(contour(circle(0.0, 0.0, 2 * radius)))
    post((part,), machine)  # which reads it back
    driven = post((part,), free).text
    found = {said.code for said in verify_sheet(driven, (part,), machine)}
    out = radius < limit if key == "min_radius" else radius > limit
    assert found == ({"verify-sheet-radius"} if out else set())
    alone = {said.code for said in verify_sheet(driven, (), machine)}
    assert alone == found


@settings(deadline=None, max_examples=examples(12))
@given(st.sampled_from(NAMES), st.floats(2.0, 60.0), st.sampled_from(("min_radius", "max_radius")))
def test_an_arc_of_just_that_radius_is_in_range(name: str, radius: float, key: str) -> None:
    part = drawing(contour(circle(0.0, 0.0, 2 * radius)))
    machine = limited(machine_of(name), **{key: radius})
    posted = post((part,), machine)
    assert verify_sheet(posted.text, (part,), machine) == ()


def test_the_message_has_the_line_and_the_range() -> None:
    machine = machine_of("plate-linuxcnc")
    part = drawing(contour(circle(0.0, 0.0, 20.0)))
    text = post((part,), machine).text
    lines = text.splitlines()
    line = next(n for n, block in enumerate(lines, 1) if block.startswith(("G2 ", "G3 ")))
    (first, *_) = verify_sheet(text, (part,), limited(machine, min_radius=10.5), name="p")
    assert re.fullmatch(
        f"p:{line}: error verify-sheet-radius: found an arc of radius 10 mm to "
        r"X -?[\d.]+, Y -?[\d.]+; expected 10\.5 to 10000 mm",
        str(first),
    )


def test_every_arc_that_is_driven_against_the_limits_is_refused() -> None:
    of = [machine for machine in MACHINES if machine[0] in NAMES][::4]
    lies = told(of, every=10**9)
    assert lies.missed == []
    assert set(lies.made) == {"arc too tight", "arc too wide"}
