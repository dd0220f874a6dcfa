"""Round tubes with cuts through their wall: contours of their outside, what is told, what is not
read, and what the comparison with the solid finds."""

from collections.abc import Callable, Sequence
from math import asin, cos, pi, radians, sin, tan

import numpy as np
import pytest
from msgspec.structs import replace

from beamcam.errors import Diagnostic, Severity, errors_in
from beamcam.geometry.curves import Line, signed_area
from beamcam.model.part import Contour, Hole, Part
from beamcam.readers import dstv
from beamcam.readers.ifc import Options, read, semantic
from beamcam.readers.ifc.cutters import Cutter as ReadCutter
from beamcam.readers.ifc.cutters import Prism
from beamcam.readers.ifc.finish import Shaped
from beamcam.readers.ifc.space import scale, sub
from beamcam.solid.part_solid import part_solid
from beamcam.writers.dstv import write
from tests.property.ifc_cuts import SIZES, Bar, Box, Cutter, Half, Round, model_of

D, WALL = 168.3, 8.0
R, INNER, TURN = D / 2, D / 2 - WALL, pi * D
TUBE = Bar("RO", 1000.0, SIZES["RO"])


def block(x: float, x1: float, y: float, y1: float, z: float, z1: float) -> Box:
    return Box((x, y, z), (x1, y1, z1))


SLOT = block(-9.0, 150.0, -9.0, D + 9.0, R - 5.5, R + 5.5)
#: On one side, as it is not the same seen in a mirror.
WINDOW = block(400.0, 500.0, R + 20.0, R + 60.0, R, D + 9.0)
SADDLE = Round((1000.0, -100.0, R), 1, 219.1, 400.0)
MITRE = Half((1000.0, D, R), (cos(radians(30.0)), -sin(radians(30.0)), 0.0))


def checked(*cutters: Cutter, kernel: bool = True) -> tuple[Part, list[Diagnostic]]:
    """The part of a tube, and what is told of it."""
    found = read(model_of(TUBE, cutters), "m.ifc", options=Options(kernel=kernel))
    said = [d for d in found.diagnostics if d.severity is not Severity.NOTE]
    assert not errors_in(said), said
    (part,) = found.parts
    return part, said


def outside(part: Part) -> float:
    """mm2 of steel by the contours."""
    areas = {kind: sum(abs(signed_area(c.curves)) for c in part.contours if c.kind == kind)
             for kind in ("outer", "inner")}  # fmt: skip
    return (areas["outer"] or part.length * TURN) - areas["inner"]


def places(contour: Contour) -> set[tuple[float, float]]:
    return {(round(c.start[0], 3) + 0.0, round(c.start[1], 3) + 0.0) for c in contour.curves}


def test_a_slot_is_as_wide_as_its_plates_make_it_outside() -> None:
    part, (said,) = checked(SLOT)
    (outline,) = part.contours
    half = R * asin(5.5 / R)
    at_slots = {(x, round(u + by, 3)) for x in (0.0, 150.0) for u in (TURN / 2,)
                for by in (-half, half)}  # fmt: skip
    assert at_slots < places(outline)
    assert {(0.0, 0.0), (150.0, 0.0)} & places(outline) == {(150.0, 0.0)}  # the seam lies in one
    assert part.length == 1000.0
    assert said.code == "ifc-square-cut"
    narrower = INNER * (asin(5.5 / INNER) - asin(5.5 / R))
    assert float(said["stays"]) == pytest.approx(narrower, abs=0.01)
    assert float(said["takes"]) == 0.0


def test_a_saddle_is_its_curve_outside() -> None:
    part, (said,) = checked(SADDLE)
    (outline,) = part.contours
    turns = np.linspace(0.0, 2 * pi, 7201)[:-1]
    x = 1000.0 - np.sqrt((219.1 / 2) ** 2 - (R * np.sin(turns)) ** 2)
    assert part.length == pytest.approx(x.max(), abs=0.01)
    assert outside(part) == pytest.approx(x.mean() * TURN, abs=0.01 * TURN)
    assert len(outline.curves) < 250
    assert float(said["stays"]) > 3.0


def test_a_window_is_a_contour_within_and_ends_stay_planes() -> None:
    part, _ = checked(WINDOW, MITRE, kernel=False)
    (window,) = part.contours
    us = sorted({round(c.start[1], 3) for c in window.curves})
    turns = (asin(20.0 / R), asin(60.0 / R))
    assert us == pytest.approx([TURN / 4 + R * turn for turn in turns], abs=0.002)
    assert (window.kind, part.cuts.web_end) == ("inner", pytest.approx(-30.0))


def test_an_outline_draws_both_ends_and_the_header_keeps_a_plane() -> None:
    """The wall is cut square to the outside all along the plane, on one side in the steel."""
    part, (said,) = checked(SLOT, MITRE)
    (outline,) = part.contours
    ends = [c for c in outline.curves if min(c.start[0], c.end[0]) > 500.0]
    for c in ends:
        for x, u in (c.start, c.end):
            y = R - R * cos(u / R)
            assert x == pytest.approx(1000.0 - (D - y) * tan(radians(30.0)), abs=0.002)
    assert (part.cuts.web_start, part.cuts.web_end) == (0.0, pytest.approx(-30.0))
    assert float(said["takes"]) == pytest.approx(WALL * tan(radians(30.0)), abs=0.05)


def test_holes_stay_holes_beside_contours() -> None:
    hole = Round((300.0, -9.0, R), 1, 22.0, D + 18.0)
    part, _ = checked(SLOT, hole, kernel=False)
    assert {(f.x, round(f.y, 3)) for f in part.features if isinstance(f, Hole)} == {
        (300.0, 0.0), (300.0, round(TURN / 2, 3)),
    }  # fmt: skip
    in_air = Round((75.0, -9.0, R), 1, 8.0, D + 18.0)
    gone, _ = checked(SLOT, in_air, kernel=False)
    assert not [f for f in gone.features if isinstance(f, Hole)]


@pytest.mark.parametrize("cutters", [(SLOT,), (WINDOW, SADDLE), (SLOT, MITRE)])
def test_its_file_is_read_as_the_same_part(cutters: tuple[Cutter, ...]) -> None:
    part, _ = checked(*cutters, kernel=False)
    (again,) = dstv.read(write(part).encode(), "t.nc1").parts
    assert (again.profile.code, again.cuts) == ("RO", part.cuts)
    assert again.length == pytest.approx(part.length, abs=1e-5)
    assert outside(again) == pytest.approx(outside(part), abs=0.1)
    least = part_solid(part) ^ part_solid(again)
    assert part_solid(again).volume() - least.volume() < 1.0


def test_the_seam_is_turned_from_a_side_that_would_be_taken_for_it() -> None:
    """Whoever cuts an outline puts a side up to 2.5 mm beside the seam on it."""
    beside = block(-9.0, 150.0, -9.0, R, R + 0.4, R + 20.0)
    part, _ = checked(beside, kernel=False)
    (outline,) = part.contours
    along = [c.start[1] for c in outline.curves if abs(c.end[0] - c.start[0]) > 100.0]
    off = [min(u, TURN - u) for u in along]
    assert sorted(off)[:2] == [0.0, 0.0]  # the seam itself
    assert min(sorted(off)[2:]) > 10.0


# --- what is not read -----------------------------------------------------------------------------

REFUSED: dict[str, tuple[Cutter, ...]] = {
    "a cut that does not go through the wall": (
        block(400.0, 500.0, D - 4.0, D + 9.0, R - 20.0, R + 20.0),
    ),
    "a cut into the wall from inside": (block(400.0, 500.0, R, D - 4.0, R - 8.0, R + 8.0),),
    "cuts that leave pieces": (block(400.0, 500.0, -9.0, D + 9.0, -9.0, D + 9.0),),
    "cuts that leave the tube open from end to end": (
        block(-9.0, 1009.0, R, D + 9.0, R - 20.0, R + 20.0),
    ),
}


@pytest.mark.parametrize("found", REFUSED)
def test_what_no_contour_says_is_refused_by_its_reason(found: str) -> None:
    said = errors_in(read(model_of(TUBE, REFUSED[found]), "m.ifc").diagnostics)
    assert [(d.code, d["found"]) for d in said] == [("ifc-odd-cut", found)]


def test_a_notch_half_through_the_wall_at_an_end_is_refused() -> None:
    notch = block(-9.0, 40.0, D - 4.0, D + 9.0, R - 20.0, R + 20.0)
    (said,) = errors_in(read(model_of(TUBE, [notch]), "m.ifc").diagnostics)
    assert said["found"] == "a cut that does not go through the wall"


def test_a_solid_bar_is_refused_by_a_reason_of_its_own() -> None:
    bar = Bar("RU", 1000.0, SIZES["RU"])
    flat = block(-9.0, 100.0, 40.0, 70.0, -9.0, 70.0)
    (said,) = errors_in(read(model_of(bar, [flat]), "m.ifc").diagnostics)
    assert said.code == "ifc-solid-cut"
    assert "no wall that a torch could cut through" in said.message


# --- the comparison with the solid ----------------------------------------------------------------

Wrong = Callable[[Shaped], Shaped]


def moved(shaped: Shaped, to: Callable[[float, float], tuple[float, float]]) -> Shaped:
    """Its contours with every place elsewhere."""
    features = tuple(
        replace(f, curves=tuple(Line(to(*c.start), to(*c.end)) for c in f.curves))
        if isinstance(f, Contour) else f
        for f in shaped.features
    )  # fmt: skip
    return replace(shaped, features=features)


WRONG: dict[str, Wrong] = {
    "u off": lambda s: moved(s, lambda x, u: (x, u + 0.5)),
    "x off": lambda s: moved(s, lambda x, u: (x + 0.5, u)),
    "mirrored": lambda s: moved(s, lambda x, u: (x, TURN - u)),
    "missing": lambda s: replace(s, features=()),
    "narrower": lambda s: moved(s, lambda x, u: (x, 170.0 + (u - 170.0) * 0.95)),
}


@pytest.mark.parametrize("what", WRONG)
def test_a_contour_that_is_not_the_cut_is_found(what: str, monkeypatch: pytest.MonkeyPatch) -> None:
    right = semantic.cut_tube
    monkeypatch.setattr(semantic, "cut_tube", lambda *of: WRONG[what](right(*of)))
    found = read(model_of(TUBE, [WINDOW]), "m.ifc", options=Options(kernel=True))
    assert {d.code for d in errors_in(found.diagnostics)} == {"ifc-unexplained"}


def test_a_cut_of_half_the_depth_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """The outside is the same, and no contour would tell."""
    right = semantic.cut_tube

    def through(stock: object, ends: object, general: Sequence[ReadCutter], *of: object) -> Shaped:
        (one,) = general
        assert isinstance(one, Prism)
        f = one.frame
        deeper = replace(one, frame=replace(f, o=sub(f.o, f.z), z=scale(f.z, 2.0)))
        return right(stock, ends, [deeper], *of)  # type: ignore[arg-type]

    monkeypatch.setattr(semantic, "cut_tube", through)
    half = block(400.0, 500.0, R - 20.0, R + 20.0, D - 4.0, D + 9.0)
    found = read(model_of(TUBE, [half]), "m.ifc", options=Options(kernel=True))
    assert {d.code for d in errors_in(found.diagnostics)} == {"ifc-unexplained"}
