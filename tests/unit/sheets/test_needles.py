"""Notches beside a needle of the part, whose tip the beam passes on both sides."""

import re
from collections.abc import Iterator

import numpy as np
import pytest
import shapely
from hypothesis import event, example, given, settings
from hypothesis import strategies as st
from shapely.geometry.base import BaseGeometry

from beamcam.checks.sheets.compare import verify_sheet
from beamcam.errors import Diagnostic, PlanError
from beamcam.geometry.curves import Bezier, Curve, Line
from beamcam.model.part import Part
from beamcam.pipeline import RefusedProgram, post
from beamcam.planning.contours import kerf as kerfs
from beamcam.planning.contours import left_waste, running_back
from tests.conftest import examples
from tests.unit.sheets.notches import Notch, left_at_best, left_in_program
from tests.unit.sheets.parts import box, contour, drawing, lines, table

MACHINE = table("plate-linuxcnc")
KERF = 1.9  #: of 8 mm of steel
OFF = 0.12  #: that figures of two measurements may differ by


def sheet(curves: tuple[Curve, ...]) -> Part:
    return drawing(contour(curves), thickness=8.0)


def notched(mouth: float, tip: float, depth: float) -> Part:
    """A plate with a V notch in its top, left of a needle that ends as high as the plate."""
    return Notch(mouth, depth, tip).part()


HOOK = (
    Line((10.16, 60.8), (101.6, 60.8)), Line((101.6, 60.8), (101.6, 10.0)),
    Line((101.6, 10.0), (10.16, 10.0)), Line((10.16, 10.0), (10.16, 58.26)),
    Bezier(((10.16, 58.26), (10.16, 59.657), (11.303, 60.8), (10.16, 60.8))),
)  # fmt: skip
SHIELD = lines((5, 4.995), (7, 8), (7, 12), (6, 7), (4, 130), (3, 12), (3, 8))


def depths(said: tuple[Diagnostic, ...], code: str) -> list[float]:
    """How deep what is told of by messages of a code is."""
    found = (
        re.search(r"(\S+) mm (?:of it|in a corner)", d.message) for d in said if d.code == code
    )
    return [float(one[1]) for one in found if one]


@pytest.mark.parametrize("part", [sheet(HOOK), notched(1.2, 0.02, 1.0)], ids=["hook", "notch"])
def test_what_lies_beside_a_needle_passes(part: Part) -> None:
    assert not depths(post((part,), MACHINE).remarks, "plan-left-in-corner")


@pytest.mark.parametrize(("part", "depth"), [
    (sheet(SHIELD), 5.049), (notched(1.2, 0.02, 5.0), 4.786), (notched(1.2, 15.0, 5.0), 4.786),
], ids=["shield", "notch", "no needle"])  # fmt: skip
def test_a_slot_behind_a_needle_is_as_deep_as_any(part: Part, depth: float) -> None:
    """The path on the needle's other side is no nearer to what is waste."""
    with pytest.raises(PlanError) as refused:
        post((part,), MACHINE)
    (found,) = depths(refused.value.diagnostics, "plan-narrow")
    assert found == pytest.approx(depth, abs=0.01)


@pytest.mark.parametrize("neck", [1.7, 1.86, 1.89])
@pytest.mark.parametrize("pocket", [1.95, 2.4, 6.0])
def test_a_pocket_behind_a_neck_is_refused_by_name(neck: float, pocket: float) -> None:
    """The beam has room in it and does not get there, so that it is no corner."""
    a, b = 5 - neck / 2, 5 + neck / 2
    c, d = 5 - pocket / 2, 5 + pocket / 2
    hole = lines(
        (0, 0), (20, 0), (20, a), (21, a), (21, c), (21 + pocket, c), (21 + pocket, d), (21, d),
        (21, b), (20, b), (20, 10), (0, 10),
    )  # fmt: skip
    part = drawing(contour(box(-20, -20, 80, 60)), contour(hole), thickness=8.0)
    with pytest.raises(PlanError, match="plan-narrow"):
        post((part,), MACHINE)


def test_a_sliver_is_measured_that_shapely_makes_nothing_of() -> None:
    """Valid, and empty once its sides are divided as a polygon."""
    corners = [
        (30.25, 85.9),
        (30.25, 85.35259275292748),
        (30.239423623278157, 85.49395489788482),
        (30.207929987311708, 85.63216946536998),
        (30.156220331170804, 85.76415896204792),
        (30.08544602496808, 85.88698450236028),
        (29.997182933386963, 85.99791124591675),
        (29.893396327389976, 86.09446929160497),
        (29.776397125384914, 86.1745086725476),
        (29.394836415991552, 86.39566806461637),
    ]
    apex, mouth = corners[:1], shapely.LineString(corners[1:])
    walls = shapely.LineString([corners[-1], *apex, corners[1]])
    beam = shapely.Point(29.3, 85.35).buffer(0.01).exterior
    left = left_waste._left(shapely.Polygon(corners), mouth, beam, walls, 0.95, 0.02)
    assert left is not None
    assert left.depth == pytest.approx(shapely.Point(apex).distance(mouth), abs=1e-6)


notches = st.builds(
    Notch, st.floats(0.3, 6.0), st.floats(0.5, 15.0), st.floats(0.06, 1.5),
    st.sampled_from(["lines", "arcs", "curves"]), st.floats(0.0, 0.1), st.booleans(), st.booleans(),
)  # fmt: skip


def doubled(said: tuple[Diagnostic, ...]) -> float:
    """Length in mm for which a notch is too narrow to be told from a doubled line; 0 of others."""
    codes = {d.code: d.message for d in said}
    found = re.search(r"for (\S+) mm", codes.get("plan-doubles-back-kerf", ""))
    return float(found[1]) if found else 0.0


def slit(steel: BaseGeometry) -> float:
    """Length in mm over which the waste in a plate is narrower than a doubled line may be."""
    half = running_back.NEEDLE * MACHINE.needed(MACHINE.torch, "torch").tolerance / 2
    closed = steel.buffer(half, join_style="mitre").buffer(-half, join_style="mitre")
    sizes = shapely.bounds(shapely.get_parts(closed.difference(steel)))
    return float(np.hypot(*(sizes[:, 2:] - sizes[:, :2]).T).max(initial=0.0))


@settings(deadline=None, max_examples=examples(25))
@given(notches)
@example(Notch(0.3046875, 15.0, 0.25))
def test_what_is_left_in_a_notch_is_told_as_deep_as_it_is(notch: Notch) -> None:
    """Measured by the areas that the beam sweeps, and that a beam could sweep."""
    steel = notch.steel()
    try:
        posted = post((notch.part(),), MACHINE)
    except PlanError as error:
        event("refused")
        if length := doubled(error.diagnostics):  # before anything is said of what is left in it
            assert length < 1.1 * slit(steel)
            return
        (found,) = depths(error.diagnostics, "plan-narrow")
        assert found == pytest.approx(left_at_best(steel, KERF), abs=OFF)
        assert found > KERF
        return
    told = max(depths(posted.remarks, "plan-left-in-corner"), default=0.0)
    left = left_in_program(steel, posted.text, KERF)
    event(f"made, {'told' if told else 'nothing told'}")
    assert told == pytest.approx(left, abs=OFF) if told else left < 0.55 * KERF + OFF


@settings(deadline=None, max_examples=examples(15))
@given(notches)
def test_the_read_back_refuses_what_is_left_untold(notch: Notch) -> None:
    """The planner keeps silent about all that it leaves."""
    left = left_at_best(notch.steel(), KERF)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(kerfs, "left_diagnostics", silent)
        try:
            post((notch.part(),), MACHINE)
        except RefusedProgram as refused:
            codes = {said.code for said in refused.diagnostics}
            event("refused")
            assert codes <= {"verify-sheet-untold", "verify-sheet-missing"}
            told = [str(d) for d in refused.diagnostics if d.code == "verify-sheet-untold"]
            assert all("error verify-sheet-untold: found " in one for one in told)
            assert left > KERF - OFF
            return
        except PlanError as error:
            event("too narrow at its end")
            if not 0.0 < doubled(error.diagnostics) < 1.1 * slit(notch.steel()):
                raise
            return
    event("made")
    assert left < KERF + OFF


def silent(*_: object) -> Iterator[Diagnostic]:
    return iter(())


@settings(deadline=None, max_examples=examples(8))
@given(st.floats(0.0, 1.0), st.floats(2.5, 8.0), st.floats(0.1, 1.0))
def test_a_notch_that_the_beam_enters_may_not_be_left(
    narrow: float, mouth: float, tip: float
) -> None:
    """The program of the plate with the notch almost closed does not make the one with it open."""
    without = lines(
        (0, 0), (40, 0), (40, 20), (25 + tip, 20), (25 + tip, 40), (25, 40),
        (25 - mouth, 40), (0, 40),
    )  # fmt: skip
    text = post((sheet(without),), MACHINE).text
    part = notched(mouth, tip, 5.0 + narrow)
    assert "verify-sheet-missing" in {said.code for said in verify_sheet(text, (part,), MACHINE)}
