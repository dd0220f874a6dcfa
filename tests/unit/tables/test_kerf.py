"""Tables without G-code keep half a kerf off, and their read-back looks on which side."""

from itertools import pairwise

import pytest

from beamcam.geometry.curves import Line
from beamcam.machine import load
from beamcam.machine.machine import Machine
from beamcam.machine.overlay import with_torch
from beamcam.model.part import Contour, Part
from beamcam.pipeline import post
from tests.conftest import sampled
from tests.unit.sheets.parts import box, circle, contour, drawing

TABLES = [("laser-stepper", ".steps"), ("laser-stepper", ".csv"), ("table-simotion", "chain"),
          ("table-simotion", "table")]  # fmt: skip
KERF = 0.4
WAYS_IN: list[dict[str, object]] = [
    {"lead": "none"}, {"lead": "line", "lead_in": 2.0, "lead_out": 1.0},
]  # fmt: skip

PART = drawing(contour(box(10, 10, 40, 30)), contour(circle(25, 20, 5)), thickness=3.0)
SPIKE = drawing(
    contour((Line((10, 10), (60, 10)), Line((60, 10), (10, 22)), Line((10, 22), (10, 10)))),
    thickness=3.0,
)


def table(name: str, kerf: float, **values: object) -> Machine:
    return with_torch(load(name), kerf=kerf, **values)


@pytest.mark.parametrize("part", [PART, SPIKE], ids=["plate", "spike"])
@pytest.mark.parametrize("way_in", WAYS_IN, ids=["none", "line"])
@pytest.mark.parametrize(("name", "style"), TABLES)
def test_half_a_kerf_is_kept_off(
    name: str, style: str, way_in: dict[str, object], part: Part
) -> None:
    posted = post((part,), table(name, KERF, **way_in), style=style)
    assert posted.text or posted.pieces


@pytest.mark.parametrize(("name", "style"), TABLES)
@pytest.mark.parametrize("other", sampled([0.5 * KERF, 0.0, 1.5 * KERF], 2))
def test_another_kerf_is_refused(name: str, style: str, other: float) -> None:
    program = b"".join(
        p if isinstance(p, bytes) else p.encode()
        for p in post((PART,), table(name, other), style=style).pieces()
    )
    asked = table(name, KERF)
    said = refused(program, asked, style)
    assert said, "cut by another kerf"


@pytest.mark.parametrize(("name", "style"), TABLES)
def test_the_wrong_side_is_refused(name: str, style: str) -> None:
    """The part that is cut is a kerf too small: its contours are moved to the other side."""
    shrunk = drawing(
        contour(box(10 + KERF, 10 + KERF, 40 - KERF, 30 - KERF)), contour(circle(25, 20, 5 + KERF)),
        thickness=3.0,
    )  # fmt: skip
    posted = post((shrunk,), table(name, KERF), style=style)
    program = b"".join(p if isinstance(p, bytes) else p.encode() for p in posted.pieces())
    assert refused(program, table(name, KERF), style)


def refused(program: bytes, machine: Machine, style: str) -> set[str]:
    if style.startswith("."):
        from beamcam.checks.steps import verify_table

        said = verify_table(style, (program,), [PART], machine, (), "a")
    else:
        from beamcam.checks.st import verify_triggers

        said = verify_triggers(program.decode(), [PART], machine, (), "a")
    return {d.code for d in said}


# --- contours that do not quite close -------------------------------------------------------------


def ring(gap: float) -> Contour:
    """A rectangle whose last side ends short of its first corner."""
    corners = ((0.0, 0.0), (60.0, 0.0), (60.0, 40.0), (0.0, 40.0), (0.0, gap))
    return contour(tuple(Line(a, b) for a, b in pairwise(corners)))


@pytest.mark.parametrize("gap", [0.0, 0.004, 0.006, 0.02, 0.04, 0.2])
@pytest.mark.parametrize(
    ("name", "style"),
    [
        ("laser-stepper", ".bin"), ("laser-stepper", ".csv"), ("table-simotion", "chain"),
        ("table-plcopen", "table"),
        ("laser-grbl", None), ("plate-linuxcnc", None), ("plate-codesys", None),
    ],
)  # fmt: skip
def test_a_gap_of_any_size(name: str, style: str | None, gap: float) -> None:
    machine = with_torch(load(name), thickness=3.0, kerf=0.0, lead="none", place="corner")
    posted = post((drawing(ring(gap), thickness=3.0),), machine, style=style)
    assert machine.torch is not None
    closed = gap <= machine.torch.gap
    assert ("plan-open-cut" in {d.code for d in posted.remarks}) is not closed
