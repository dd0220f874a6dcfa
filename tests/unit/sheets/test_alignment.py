"""Programs of one drawing read back against another that it meets at places equally far apart."""

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from beamcam.errors import Diagnostic, errors_in
from beamcam.model.part import Contour, Part
from beamcam.model.request import Request
from beamcam.pipeline import whole_job
from beamcam.posts import post_of
from tests.conftest import examples, sampled
from tests.unit.sheets.parts import contour, drawing, lines, table

MACHINES = {
    name: table(name, **values)
    for name, values in {
        "plate-linuxcnc": {"kerf_by": "none", "lead": "none"},
        "laser-grbl": {"material": "wood"},
        "table-simotion": {},
        "laser-stepper": {"material": "wood"},
    }.items()
}
GRBL = "laser-grbl"


def line(a: tuple[float, float], b: tuple[float, float]) -> Contour:
    return contour(lines(a, b, closed=False))


def ring(*corners: tuple[float, float]) -> Contour:
    return contour(lines(*corners))


def grid(count: int, pitch: float, high: float) -> list[Contour]:
    return [line((20 + k * pitch, 20), (20 + k * pitch, 20 + high)) for k in range(count)]


def broken(count: int, dash: float, gap: float) -> list[Contour]:
    return [
        line((20 + k * (dash + gap), 20), (20 + k * (dash + gap) + dash, 20)) for k in range(count)
    ]


def read_back(made: Part, wanted: Part, name: str) -> tuple[Diagnostic, ...]:
    """Errors of the program of one drawing where another was wanted."""
    post, machine = post_of(MACHINES[name]), MACHINES[name]
    job = whole_job(Request((made,), machine))
    plan = post.plan(job)
    written = post.emit(post.motion(plan, machine, "JOB"), job)
    return errors_in(post.verify(written, whole_job(Request((wanted,), machine))))


def assert_seen(few: Part, many: Part, name: str) -> None:
    assert read_back(few, few, name) == read_back(many, many, name) == ()
    assert read_back(many, few, name)
    assert read_back(few, many, name)


@settings(max_examples=examples(25))
@given(
    steps=st.integers(1, 6), pitch=st.sampled_from((0.4, 0.5, 1.0, 1.5, 2.0, 4.0)),
    high=st.floats(1.0, 30.0), name=st.sampled_from((GRBL, "plate-linuxcnc")),
)  # fmt: skip
def test_a_ring_across_lines_is_seen(steps: int, pitch: float, high: float, name: str) -> None:
    """Samples of each of its sides may all lie on lines."""
    wide, lines_across = steps * pitch, grid(2 * steps + 1, pitch, 60)
    corners = (20, 50), (20 + wide, 50 + high), (20 + 2 * wide, 50), (20 + wide, 50 - high)
    assert_seen(drawing(*lines_across), drawing(*lines_across, ring(*corners)), name)


@settings(max_examples=examples(25))
@given(
    count=st.integers(3, 30), pitch=st.sampled_from((0.5, 1.0, 2.0, 4.0)),
    rise=st.floats(0.0, 20.0), name=st.sampled_from((GRBL, "plate-linuxcnc")),
)  # fmt: skip
def test_a_line_across_lines_is_seen(count: int, pitch: float, rise: float, name: str) -> None:
    """It ends on the outermost of them, as what another stroke has made may."""
    lines_across = grid(count, pitch, 60)
    across = line((20, 40), (20 + (count - 1) * pitch, 40 + rise))
    assert_seen(drawing(*lines_across), drawing(*lines_across, across), name)


@settings(max_examples=examples(25))
@given(
    count=st.integers(2, 12), dash=st.sampled_from((1.0, 2.0, 3.0)), gap=st.floats(0.8, 3.0),
    ticks=st.booleans(), name=st.sampled_from((GRBL, "plate-linuxcnc")),
)  # fmt: skip
def test_a_broken_line_that_is_joined_is_seen(
    count: int, dash: float, gap: float, ticks: bool, name: str
) -> None:
    """Samples of the line may all lie on dashes; their ends may lie on other lines."""
    dashes = broken(count, dash, gap)
    ends = sorted({x for d in dashes for x in (d.curves[0].start[0], d.curves[0].end[0])})
    others = [line((x, 15), (x, 25)) for x in ends] if ticks else []
    assert_seen(
        drawing(*others, *dashes), drawing(*others, line((ends[0], 20), (ends[-1], 20))), name
    )


@settings(max_examples=examples(25))
@given(
    first=st.integers(1, 11), last=st.integers(1, 11), pitch=st.sampled_from((1.0, 1.5, 2.0)),
    name=st.sampled_from((GRBL, "plate-linuxcnc")),
)  # fmt: skip
def test_a_piece_of_a_line_between_two_others_is_seen(
    first: int, last: int, pitch: float, name: str
) -> None:
    assume(first < last)
    across, a, b = grid(13, pitch, 60), 20 + first * pitch, 20 + last * pitch
    whole = line((15, 40), (60, 40))
    two = [line((15, 40), (a, 40)), line((b, 40), (60, 40))]
    assert_seen(drawing(*across, *two), drawing(*across, whole), name)


@pytest.mark.parametrize("name", sampled(["table-simotion", "laser-stepper"], 2))
def test_tables_are_read_back_as_closely(name: str) -> None:
    across = grid(13, 1.0, 60)
    corners = (20, 50), (26, 56), (32, 50), (26, 44)
    assert_seen(drawing(*across), drawing(*across, ring(*corners)), name)
    assert_seen(drawing(*across), drawing(*across, line((20, 40), (32, 40))), name)
    assert_seen(drawing(*broken(7, 2.0, 2.0)), drawing(line((20, 20), (46, 20))), name)


def test_the_message_names_what_the_path_runs_across() -> None:
    across = grid(13, 1.0, 60)
    corners = (20, 50), (26, 56), (32, 50), (26, 44)
    found = read_back(drawing(*across, ring(*corners)), drawing(*across), GRBL)
    extra = [d for d in found if d.code == "verify-sheet-extra"]
    assert "across the contour of sheet.dxf:1; expected it along one" in extra[0].message
