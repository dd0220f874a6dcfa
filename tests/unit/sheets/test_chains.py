"""Chain cuts: parts that are cut in one go keep their size, and links lie in metal."""

import re

import pytest
import shapely

from beamcam.checks.sheets.compare import verify_sheet
from beamcam.errors import PlanError, errors_in
from beamcam.machine import Machine, load
from beamcam.machine.overlay import with_torch
from beamcam.model.plan import SheetPlan
from beamcam.model.request import Request
from beamcam.pipeline import Posted, post, read_back
from beamcam.remainder import rest_of_sheet
from beamcam.solid.opinion import solid_faults
from tests.conftest import sampled
from tests.unit.sheets.parts import box, circle, contour, drawing, lines
from tests.unit.sheets.test_common_cuts import KERF, parts_are_exact, random_nest
from tests.unit.sheets.test_feeds import strokes

NUMBER = re.compile(r"(?<=[XYIJ])-?\d+(?:\.\d+)?")
TABLES = ("plate-linuxcnc", "plate-codesys", "plate-qtplasmac", "plate-mach3", "plate-oxyfuel")
PLATE = drawing(contour(box(0, 0, 80, 50), line=1), contour(circle(20, 25, 12), line=2),
                thickness=3.0)  # fmt: skip


def chaining(name: str = "plate-linuxcnc", longest: float = 40.0, **values: object) -> Machine:
    asked = {"chain_cuts": longest, "thickness": 3.0, **values}
    return with_torch(load(name), **asked)  # type: ignore[arg-type]


def linked(posted: Posted) -> list[int]:
    assert isinstance(posted.plan, SheetPlan)
    return [k for k, op in enumerate(posted.plan.operations) if op.is_linked]


def pierces(text: str) -> int:
    return len(re.findall(r"^(?:N\d+ )?M0?3\b", text, re.M))


@pytest.mark.parametrize("name", TABLES)
def test_two_parts_beside_each_other_are_pierced_once(name: str) -> None:
    machine = chaining(name)
    each = post((PLATE,) * 4, with_torch(load(name), thickness=3.0))
    posted = post((PLATE,) * 4, machine)
    assert len(linked(posted)) >= 2
    assert pierces(posted.text) == pierces(each.text) - len(linked(posted))
    assert not verify_sheet(posted.text, (PLATE,) * 4, machine)


@pytest.mark.parametrize("seed", sampled(range(40), 4))
def test_parts_of_random_nests_are_exact(seed: int) -> None:
    parts = random_nest(seed)
    posted = post(parts, chaining())
    parts_are_exact(posted)
    text = post(parts, chaining(longest=0.0)).text
    assert pierces(posted.text) == pierces(text) - len(linked(posted))


def test_a_link_lies_in_metal() -> None:
    """By the band of the beam up to there: it has not been where a link goes."""
    found = 0
    for seed in range(12):
        posted = post(random_nest(seed), chaining(longest=80.0))
        count = len(linked(posted))
        found += count
        burnt = shapely.Polygon()
        for stroke in strokes(posted.text):
            points = [p for part, _ in stroke for p in part]
            burnt = burnt.union(shapely.LineString(points).buffer(KERF / 2))
        assert len(shapely.get_parts(burnt)) <= len(strokes(posted.text))
    assert found > 10


def test_links_that_are_too_long_or_not_asked_for_are_refused() -> None:
    parts = (PLATE,) * 4
    text = post(parts, chaining()).text
    for machine in (chaining(longest=5.0), with_torch(load("plate-linuxcnc"), thickness=3.0)):
        assert errors_in(verify_sheet(text, parts, machine))
    said = verify_sheet(text, parts, chaining(longest=5.0))
    assert {d.code for d in said} == {"verify-sheet-link"}
    assert "expected at most 5 mm" in said[0].message


def test_a_link_through_a_part_is_refused() -> None:
    """The way from the first plate to the third crosses the second."""
    parts = (PLATE,) * 3
    machine = chaining(longest=200.0, spacing=20.0)
    text = post(parts, machine).text
    assert not verify_sheet(text, parts, machine)
    lines_of = text.split("\n")
    on = [k for k, line in enumerate(lines_of) if line.startswith("M3")]
    # The last stroke follows the one before without the tool off between.
    last = on[-1]
    off = max(k for k in range(last) if lines_of[k].startswith("M5"))
    joined = "\n".join([*lines_of[:off], *lines_of[last + 1 :]])
    said = errors_in(verify_sheet(joined, parts, machine))
    assert said


@pytest.mark.parametrize("count", [2, 3, 6])
def test_a_torch_that_goes_out_on_a_link_or_stays_on_elsewhere_is_refused(count: int) -> None:
    parts = (PLATE,) * count
    machine = chaining()
    posted = post(parts, machine)
    assert linked(posted)
    text = posted.text.split("\n")
    changes = 0
    for k, line in enumerate(text):
        if line.startswith("M5") and any(t.startswith("M3") for t in text[k:]):
            then = next(n for n in range(k, len(text)) if text[n].startswith("M3"))
            changed = "\n".join([*text[:k], *text[then + 1 :]])
            assert errors_in(verify_sheet(changed, parts, machine)), k
            changes += 1
    assert changes >= count


def test_what_cannot_be_chained_is_not() -> None:
    island = drawing(
        contour(box(0, 0, 200, 100), line=1), contour(box(20, 20, 60, 60), line=2),
        contour(box(30, 30, 20, 20), line=3), contour(box(55, 30, 20, 20), line=4), thickness=3.0,
    )  # fmt: skip
    posted = post((island,), chaining())
    assert not errors_in(posted.remarks)
    assert isinstance(posted.plan, SheetPlan)
    for k in linked(posted):
        assert posted.plan.operations[k].depth == posted.plan.operations[k - 1].depth
    for values in ({"tabs": 2}, {"chain_cuts": 0.0}):
        assert linked(post((PLATE,) * 4, chaining(**values))) == []
    far = post((PLATE,) * 4, chaining(longest=5.0, spacing=20.0))
    assert linked(far) == []
    touching = drawing(contour(lines((0, 0), (40, 0), (20, 20), (40, 40), (0, 40), (20, 20))))
    assert linked(post((touching, touching), chaining(thickness=6.0, kerf=0.0, kerf_by="offset",
                                                      longest=0.0))) == []  # fmt: skip


@pytest.mark.parametrize("name", ["table-simotion", "table-plcopen", "laser-stepper"])
def test_a_table_that_begins_each_contour_by_itself_takes_none(name: str) -> None:
    with pytest.raises(ValueError, match="begins each contour by itself"):
        with_torch(load(name), chain_cuts=40.0)


def test_a_controller_that_keeps_off_by_itself_takes_none() -> None:
    with pytest.raises(ValueError, match="by offset"):
        with_torch(load("plate-linuxcnc"), chain_cuts=40.0, kerf_by="machine")


def test_the_rest_begins_where_the_torch_pierces() -> None:
    posted = post((PLATE,) * 4, chaining())
    at = linked(posted)[0] + 1
    with pytest.raises(PlanError, match=f"found contour {at}, which .*; expected {at - 1}"):
        rest_of_sheet(posted, at)
    rest = rest_of_sheet(posted, at - 1)
    assert rest.text.count("M3") < posted.text.count("M3")


def test_the_solid_agrees() -> None:
    parts = (PLATE,) * 4
    request = Request(parts, chaining(), name="a.ngc")
    text = post(parts, chaining()).text
    assert not errors_in(solid_faults(text, request))
    assert not errors_in(read_back(text, request))


@pytest.mark.parametrize("every", [7, pytest.param(1, marks=pytest.mark.exhaustive)])
def test_every_other_number_is_refused(every: int) -> None:
    """Of a move or a start in a program with links: half a millimetre aside."""
    parts = (PLATE,) * 4
    machine = chaining()
    text = post(parts, machine).text
    line_of = {m: text[text.rfind("\n", 0, m.start()) + 1 :] for m in NUMBER.finditer(text)}
    numbers = [m for m, line in line_of.items() if not line.startswith(("(", "G0 X0"))]
    assert len(numbers) > 80
    for found in numbers[::every]:
        other = f"{float(found[0]) + 0.5:g}"
        changed = text[: found.start()] + other + text[found.end() :]
        assert errors_in(verify_sheet(changed, parts, machine)), changed[
            found.start() - 30 : found.end() + 10
        ]
