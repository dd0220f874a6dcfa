"""Small holes: pierced in their middle, run over their start, by figures of the test."""

import re
from math import dist

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.sheets.compare import verify_sheet
from beamcam.errors import VerifyError
from beamcam.geometry.curves import Arc
from beamcam.machine import Machine, load
from beamcam.machine.torch_faults import torch_faults
from beamcam.pipeline import post
from beamcam.planning.contours import kerf
from tests.conftest import examples
from tests.unit.sheets.parts import box, circle, contour, drawing, table

HALF_KERF = 0.75  #: of the row for 6 mm
STARTED = re.compile(
    r"G0 X(\S+) Y(\S+)\nM3 S1\n(?:G4 \S+\n)?(?:F\S+\n)?G3 X(\S+) Y(\S+) I(\S+) J(\S+)"
)
TABLES = ("plate-linuxcnc", "plate-oxyfuel", "plate-codesys", "plate-mach3", "plate-qtplasmac")
PART = drawing(
    contour(box(0, 0, 200, 120)), contour(circle(40, 40, 20), line=2),
    contour(circle(120, 60, 60), line=3), contour(box(160, 20, 8, 8), line=4),
)  # fmt: skip


def small(name: str = "plate-linuxcnc", widest: float = 32.0, **torch: object) -> Machine:
    """A table whose holes below 32 mm are small; it lays a part 10 mm from its corner."""
    machine = table(name, **torch)
    assert machine.torch is not None
    rows = tuple(
        replace(row, hole_diameter=widest) if row.process == "cut" else row
        for row in machine.torch.rows
    )
    return replace(machine, torch=replace(machine.torch, rows=rows))


def test_a_round_hole_is_pierced_in_its_middle_and_entered_along_it() -> None:
    """Half a circle of half the path's radius, 9.25 mm: its middle lies halfway to the path."""
    text = post((PART,), small(hole_lead="middle")).text
    assert isinstance(text, str)
    started = [tuple(map(float, found)) for found in STARTED.findall(text)]
    (begin,) = [s for s in started if dist(s[:2], (50.0, 50.0)) < 1e-3]
    assert dist(begin[2:4], (50.0, 50.0)) == pytest.approx(20 / 2 - HALF_KERF, abs=1e-3)
    assert dist(begin[4:6], (0.0, 0.0)) == pytest.approx((20 / 2 - HALF_KERF) / 2, abs=1e-3)
    plain = post((PART,), small()).text
    assert isinstance(plain, str)
    others = [s for s in started if s != begin]  # the square one and the wide one as they were
    assert {s[:2] for s in others} < {
        tuple(map(float, found[:2])) for found in STARTED.findall(plain)
    }


def test_a_hole_entered_from_elsewhere_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kerf, "from_middle", lambda curves: ())
    with pytest.raises(VerifyError) as refused:
        post((PART,), small(hole_lead="middle"))
    assert {d.code for d in refused.value.diagnostics} == {"verify-sheet-hole-lead"}
    assert "off its middle" in refused.value.diagnostics[0].message


def test_a_line_from_the_middle_is_refused() -> None:
    machine = small(hole_lead="middle")
    text = post((PART,), machine).text
    assert isinstance(text, str)
    straight = re.sub(
        r"(X50 Y50\nM3 S1\n(?:\S.*\n)*?)G3 (X\S+ Y\S+) I\S+ J\S+", r"\1G1 \2", text, count=1
    )
    assert straight != text
    said = verify_sheet(straight, (PART,), machine)
    assert "verify-sheet-hole-lead" in {d.code for d in said}
    assert any("another way from its middle" in d.message for d in said)


def test_a_part_in_the_middle_of_a_hole_leaves_the_usual_lead() -> None:
    part = drawing(
        contour(box(0, 0, 100, 100)), contour(circle(50, 50, 30), line=2),
        contour(circle(50, 50, 8), line=3),
    )  # fmt: skip
    text = post((part,), small(hole_lead="middle")).text
    assert isinstance(text, str)
    assert not re.search(r"G0 X60 Y60\n", text)


@pytest.mark.parametrize(
    "name", ["plate-linuxcnc", "plate-oxyfuel", "plate-codesys", "plate-mach3"]
)
@settings(max_examples=examples(30), deadline=None)
@given(
    diameter=st.one_of(st.floats(1.9, 4.0), st.floats(4.0, 40.0)), over=st.floats(0.0, 9.0),
    usual=st.sampled_from([0.0, 1.5]), widest=st.floats(0.0, 45.0),
    lead=st.sampled_from(["line", "arc"]),
    tabs=st.sampled_from([0, 1]), start=st.sampled_from(["nearest", "straight", "drawn"]),
    lead_out=st.sampled_from([0.0, 1.0, 4.0]),
)  # fmt: skip
def test_whatever_is_asked_of_holes_is_read_back(
    name: str, diameter: float, over: float, usual: float, widest: float, lead: str, tabs: int,
    start: str, lead_out: float,
) -> None:  # fmt: skip
    part = drawing(
        contour(box(0, 0, 120, 120)), contour(circle(60, 60, diameter), line=2), thickness=3.0
    )
    machine = small(
        name, widest, hole_lead="middle", hole_overcut=over, overcut=usual, lead=lead, tabs=tabs,
        inner_tabs=bool(tabs), start=start, lead_out=lead_out, min_hole=0.0, min_hole_share=0.0,
    )  # fmt: skip
    post((part,), machine)


@pytest.mark.parametrize(("made", "asked"), [(4.0, 0.0), (None, 4.0), (2.0, 4.0)])
def test_another_overcut_of_a_hole_is_refused(made: float | None, asked: float) -> None:
    text = post((PART,), small(hole_overcut=made)).text
    assert isinstance(text, str)
    said = verify_sheet(text, (PART,), small(hole_overcut=asked))
    assert said
    assert {d.code for d in said} <= {
        "verify-sheet-overcut", "verify-sheet-edge", "verify-sheet-twice",
    }  # fmt: skip
    assert all("sheet.dxf:2" in d.message or "sheet.dxf:4" in d.message for d in said)


def test_the_arc_goes_out_on_the_overcut_of_holes_only() -> None:
    """On plate-qtplasmac, by M62 P3, where small holes are closed."""
    machine = load("plate-qtplasmac")
    text = post((PART,), machine).text
    assert isinstance(text, str)
    assert text.count("M62 P3") == 2
    assert text.count("M3 $0") == text.count("M65 P3") == 4
    early = text.replace("M62 P3\n", "", 1)
    assert {d.code for d in verify_sheet(early, (PART,), machine)} == {"verify-sheet-dark"}
    at = text.rindex("\nG3 X", 0, text.rindex("M5 $0"))
    wrong = f"{text[:at]}\nM62 P3{text[at:]}"  # on the way off the outline
    assert {d.code for d in verify_sheet(wrong, (PART,), machine)} == {"verify-sheet-dark"}


def test_tables_without_words_have_no_leads_of_holes() -> None:
    machine = load("table-simotion")
    assert machine.torch is not None
    other = replace(machine, torch=replace(machine.torch, hole_lead="middle", hole_overcut=2.0))
    found = {key for key, _ in torch_faults(other)}
    assert {"torch.hole_lead", "torch.hole_overcut"} <= found


def test_half_a_circle_is_tangent() -> None:
    """By hand: a circle of 10 mm about 0, 0 begun at 10, 0 counter-clockwise heads up there."""
    from beamcam.planning.contours.kerf import from_middle

    (half,) = from_middle((Arc((0.0, 0.0), 10.0, 0.0, 360.0),))
    assert half.start == pytest.approx((0.0, 0.0), abs=1e-9)
    assert half.end == pytest.approx((10.0, 0.0), abs=1e-9)
    assert half.tangent(1.0) == pytest.approx((0.0, 1.0), abs=1e-9)
    (other,) = from_middle((Arc((0.0, 0.0), 10.0, 0.0, -360.0),))
    assert other.tangent(1.0) == pytest.approx((0.0, -1.0), abs=1e-9)


@pytest.mark.parametrize("lead_out", [0.0, 1.0])
@pytest.mark.parametrize("diameter", [2.2, 3.0, 3.8])
def test_the_arc_goes_out_where_the_overcut_is_half_of_the_hole(
    diameter: float, lead_out: float
) -> None:
    """Its end is a place where the ring of two halves closes as well."""
    part = drawing(
        contour(box(0, 0, 60, 60)), contour(circle(30, 30, diameter), line=2), thickness=3.0
    )
    machine = table("plate-qtplasmac", lead_out=lead_out, min_hole=0.0, min_hole_share=0.0)
    text = post((part,), machine).text
    assert isinstance(text, str)
    assert text.count("M62 P3") == 1
    said = verify_sheet(text.replace("M62 P3\n", ""), (part,), machine)
    assert "verify-sheet-dark" in {d.code for d in said}
