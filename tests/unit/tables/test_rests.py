"""A laser that rests switched on burns: rests of step tables, in every place of a stroke."""

import numpy as np
import pytest

from beamcam.checks.steps import verify_table
from beamcam.emitters.step_table import FORMS
from beamcam.machine import load
from beamcam.machine.overlay import with_torch
from beamcam.model.part import Part
from beamcam.motion.steps import step_table
from beamcam.planning.sheet import plan_sheet
from tests.conftest import sampled
from tests.unit.sheets.parts import box, circle, contour, drawing

PART = drawing(contour(circle(30, 20, 16)), contour(box(5, 5, 60, 30)), thickness=8.0)


def written(thickness: float) -> tuple[list[str], Part]:
    part = drawing(*PART.features, thickness=thickness)
    machine = load("laser-stepper")
    table = step_table(plan_sheet([part], machine), machine, "JOB")
    return b"".join(FORMS[".steps"](table)).decode().splitlines(), part


def rested(lines: list[str], k: int, ms: float) -> bytes:
    """The table with a rest before line `k`."""

    def later(line: str) -> str:
        return f"{int(line[:12]) + round(1000 * ms):012d}{line[12:]}"

    return ("\n".join([*lines[:k], *map(later, lines[k:])]) + "\n").encode()


def codes(data: bytes, part: Part) -> set[str]:
    machine = with_torch(load("laser-stepper"))
    return {said.code for said in verify_table(".steps", (data,), [part], machine, (), "a")}


@pytest.mark.parametrize(
    ("thickness", "ms"), sampled([(8.0, 5.0), (8.0, 8.0), (4.0, 5.0), (2.0, 5.0)], 2)
)
def test_a_rest_at_a_steady_speed_is_refused(thickness: float, ms: float) -> None:
    lines, part = written(thickness)
    assert codes(rested(lines, len(lines) - 1, 0.0), part) == set()
    on = [k for k, line in enumerate(lines) if line.endswith(",1")]
    lit = set(on)
    ends = [k for k in on if k + 1 not in lit or k - 1 not in lit]
    rng = np.random.default_rng(1)
    asked = [k for k in rng.choice(on, 14) if min(abs(k - end) for end in ends) > 1000]
    found = [codes(rested(lines, int(k), ms), part) for k in asked]
    assert len(asked) > 6
    # In a corner, where the head turns, its ramps take longer than that between two steps.
    missed = sum(not one for one in found)
    assert missed <= 1, [lines[k] for k, one in zip(asked, found, strict=True) if not one]
    assert set().union(*found) <= {"steps-laser", "steps-acceleration", "steps-speed"}


@pytest.mark.parametrize("where", [0, 1, -1])
def test_a_laser_that_waits_where_it_starts_or_stops_is_refused(where: int) -> None:
    lines, part = written(8.0)
    on = [k for k, line in enumerate(lines) if line.endswith(",1")]
    first = on[where] + 1
    assert codes(rested(lines, first, 60.0), part) == {"steps-laser"}
