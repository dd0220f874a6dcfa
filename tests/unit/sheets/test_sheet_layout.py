"""Parts mirrored, turned, copied, and counted from another point: places by complex numbers."""

import cmath
import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.errors import PlanError
from beamcam.machine import load as load_machine
from beamcam.machine.overlay import with_torch
from beamcam.model.part import Hole, Slot, TextMark
from beamcam.model.request import Request
from beamcam.pipeline import post, read_back
from tests.conftest import examples
from tests.unit.sheets.parts import S, contour, lines, plate

GRBL = load_machine("laser-grbl")
CORNERS = [(0, 0), (60, 0), (60, 20), (35, 40), (0, 40)]
OUTLINE = contour(lines(*CORNERS), None)
HOLE, SLOT = Hole("v", 12, 10, 8.0, S), Slot("v", 40, 15, 6.0, 10.0, 0.0, 30.0, S)
PART = replace(plate(OUTLINE, HOLE, SLOT), length=60.0)
POINT = re.compile(r"^G[0123] X(\S+) Y(\S+)", re.MULTILINE)


def points_of(text: str) -> list[complex]:
    return [complex(float(x), float(y)) for x, y in POINT.findall(text)]


def turned(corner: complex, mirror: str, rotate: float) -> complex:
    corner = {"none": corner, "x": -corner.conjugate(), "y": corner.conjugate()}[mirror]
    return corner * cmath.exp(1j * cmath.pi * rotate / 180)


angles = st.sampled_from([0.0, 90.0, -90.0, 180.0]) | st.floats(-180, 180).map(
    lambda a: round(a, 1)
)


@settings(max_examples=examples(25), deadline=None)
@given(
    mirror=st.sampled_from(["none", "x", "y"]), rotate=angles,
    copies=st.tuples(st.integers(1, 3), st.integers(1, 2)), spacing=st.sampled_from([2.0, 7.5]),
)  # fmt: skip
def test_every_corner_of_every_copy_is_where_it_belongs(
    mirror: str, rotate: float, copies: tuple[int, int], spacing: float
) -> None:
    machine = with_torch(
        GRBL, thickness=3.0, mirror=mirror, rotate=rotate, copies=copies, spacing=spacing
    )
    text = post((PART,), machine).text
    assert read_back(text, Request((PART,), machine)) == ()
    found = [turned(complex(*corner), mirror, rotate) for corner in CORNERS]
    low = complex(min(p.real for p in found), min(p.imag for p in found))
    size = complex(max(p.real for p in found), max(p.imag for p in found)) - low
    written = points_of(text)
    for k in range(copies[0]):
        for n in range(copies[1]):
            step = complex(k * (size.real + spacing), n * (size.imag + spacing))
            for corner in found:
                place = corner - low + step + complex(2, 2)  # the margin
                assert min(abs(place - p) for p in written) < 0.002
    assert text.count("M4") == 3 * copies[0] * copies[1]


ORIGINS = {
    "lower-left": 0, "lower-right": 60, "upper-left": 40j, "upper-right": 60 + 40j,
    "centre": 30 + 20j,
}  # fmt: skip


@pytest.mark.parametrize("origin", ORIGINS)
def test_the_origin_is_a_point_of_the_work(origin: str) -> None:
    machine = with_torch(GRBL, thickness=3.0, origin=origin)
    text = post((PART,), machine).text
    assert read_back(text, Request((PART,), machine)) == ()
    for corner in CORNERS:
        place = complex(*corner) - ORIGINS[origin]
        assert min(abs(place - p) for p in points_of(text)) < 0.002
    other = with_torch(GRBL, thickness=3.0)
    assert read_back(text, Request((PART,), other)) != ()


def test_a_program_of_another_layout_is_refused() -> None:
    asked = {"mirror": "x", "rotate": 90.0, "copies": (2, 1), "origin": "centre"}
    plain = with_torch(GRBL, thickness=3.0)
    text = post((PART,), plain).text
    for name, value in asked.items():
        machine = with_torch(plain, **{name: value})
        assert read_back(text, Request((PART,), machine)) != ()


def test_what_cannot_be_turned_or_does_not_fit_is_refused() -> None:
    text = TextMark("v", 20, 20, 0.0, 5.0, "A", S)
    lettered = replace(PART, features=(*PART.features, text))
    with pytest.raises(PlanError, match=r"plan-sheet-layout.*read from behind"):
        post((lettered,), with_torch(GRBL, thickness=3.0, mirror="x"))
    with pytest.raises(PlanError, match="plan-sheet-size"):
        post((PART,), with_torch(GRBL, thickness=3.0, copies=(100000, 100000)))
    with pytest.raises(ValueError, match="leave origin out"):
        with_torch(load_machine("laser-stepper"), origin="centre")


@pytest.mark.parametrize("name", ["laser-stepper", "plate-linuxcnc", "plate-codesys"])
def test_other_tables_copy_and_turn_too(name: str) -> None:
    asked = {"thickness": 3.0, "rotate": 90.0, "copies": (2, 1), "spacing": 20.0, "place": "corner"}
    machine = with_torch(load_machine(name), **asked)
    big = replace(PART, features=(OUTLINE, replace(HOLE, diameter=12.0)))
    assert post((big,), machine).text


def test_a_quantity_counts_the_copies_of_a_program() -> None:
    machine = with_torch(GRBL, thickness=3.0, copies=(2, 2), spacing=5.0)
    said = post((replace(PART, quantity=9),), machine).remarks
    assert [one.message for one in said if one.code == "plan-sheet-quantity"] == [
        "found a quantity of 9; this program makes 4, --quantity file makes all"
    ]
