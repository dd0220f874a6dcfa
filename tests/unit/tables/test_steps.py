"""Step tables: laws of every table, the forms against each other, and faults told."""

import re
import struct
from collections.abc import Sequence
from math import hypot, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.sheets.asked_sheet import rows_on
from beamcam.checks.steps import verify_table
from beamcam.emitters import step_table as forms
from beamcam.errors import Diagnostic, Source, errors_in
from beamcam.geometry.array_types import Counts
from beamcam.machine import load
from beamcam.machine.machine import Machine
from beamcam.machine.torch import Torch
from beamcam.model.part import Part, Profile
from beamcam.model.program import StepRows, StepTable
from beamcam.model.request import Request
from beamcam.motion import steps
from beamcam.motion.steps import BACK, FORWARD, MOVE_BITS, MOVES, TIME_BIT, Way, events
from beamcam.pipeline import post, read_back
from beamcam.planning.contours.plate import SheetMaterial
from beamcam.solid.sheet_solid import rows_for
from tests.conftest import examples
from tests.path_samples import positions
from tests.unit.sheets.parts import box, contour, drawing

from .shop import NAMES, part, plan

LASER = load("laser-stepper")
assert LASER.stepper is not None
assert LASER.torch is not None
STEPPER, TORCH = LASER.stepper, LASER.torch


def table(name: str, machine: Machine = LASER) -> StepTable:
    return steps.step_table(plan(name, "laser-stepper"), machine, name)


def codes(text: str, name: str = "shield-small") -> set[str]:
    return {d.code for d in verify_text(text, [part(name)])}


def verify_text(
    text: str, parts: Sequence[Part], machine: Machine = LASER
) -> tuple[Diagnostic, ...]:
    return verify_table(".steps", (text.encode(),), parts, machine, (), "a.steps")


@pytest.mark.parametrize("name", NAMES)
def test_every_sample_makes_its_part_in_every_form(name: str) -> None:
    made = table(name)
    for form, write in forms.FORMS.items():
        assert verify_table(form, write(made), [part(name)], LASER) == ()


def test_another_sequence_and_a_motor_that_turns_back() -> None:
    stepper = replace(STEPPER, sequence=("00", "10", "11", "01"), reversed_axes=("Y",))
    machine = replace(LASER, stepper=stepper)
    text = forms.emit(table("shield-small", machine), machine)
    assert verify_text(text, [part("shield-small")], machine) == ()
    assert "steps-" in " ".join(codes(text))


places = st.floats(0.0, 40.0).map(lambda v: round(v, 3))
corners = st.lists(st.tuples(places, places), min_size=2, max_size=8)


def signs_of(found: Counts, axis: int) -> Counts:
    """+1 and -1 for the events of an axis, which have no other moves."""
    moves = (found & MOVES) >> (axis * MOVE_BITS)
    assert set(moves.tolist()) <= {FORWARD, BACK}
    return np.where(moves == FORWARD, 1, -1)


@given(corners, st.floats(1.0, 60.0))
@settings(max_examples=examples(60), deadline=None)
def test_steps_follow_any_path_within_half_a_step(
    points: list[tuple[float, float]], speed: float
) -> None:
    path = [a for a, b in zip(points, [*points[1:], (-1.0, -1.0)], strict=True) if a != b]
    if len(path) < 2:
        path = [(0.0, 0.0), (1.0, 2.0)]
    way = Way(np.array(path), speed, True, 0.0)
    planned = steps.plan_way(way, STEPPER)
    windows = list(events(planned, STEPPER))
    for axis in (0, 1):
        found = np.concatenate([window[axis] for window in windows])
        times, signs = found >> TIME_BIT, signs_of(found, axis)
        assert (np.diff(times) >= int(1e6 / STEPPER.max_hz)).all()
        at = np.floor(path[0][axis] / STEPPER.step + 0.5) + np.cumsum(signs)
        # Between a step and the next the axis stands; both ends of that time are looked at.
        for moment in (times, np.append(times[1:] - 1, planned.duration_s * 1e6)):
            true = positions(planned, moment / 1e6)[0][:, axis]
            off = np.abs(at * STEPPER.step - true)
            assert off.max(initial=0.0) <= STEPPER.step / 2 + 2e-6 * 120.0
        last = at[-1] if len(at) else np.floor(path[0][axis] / STEPPER.step + 0.5)
        assert abs(last * STEPPER.step - path[-1][axis]) <= STEPPER.step / 2 + 1e-9


@given(st.integers(10, 16))
@settings(max_examples=examples(5), deadline=None)
def test_windows_make_no_difference(bits: int) -> None:
    way = Way(np.array([[0.0, 0.0], [9.0, 4.0], [3.0, 8.0], [3.0, 1.0]]), 30.0, True, 0.0)
    planned = steps.plan_way(way, STEPPER)
    kept = steps.WINDOW_STEPS
    whole = [np.concatenate(w) for w in zip(*events(planned, STEPPER), strict=True)]
    try:
        steps.WINDOW_STEPS = 1 << (bits - 6)
        split = [np.concatenate(w) for w in zip(*events(planned, STEPPER), strict=True)]
    finally:
        steps.WINDOW_STEPS = kept
    for a, b in zip(whole, split, strict=True):
        assert len(a) == len(b)
        assert ((a & MOVES) == (b & MOVES)).all()
        assert np.abs((a >> TIME_BIT) - (b >> TIME_BIT)).max(initial=0) <= 1


@given(
    st.lists(st.tuples(st.integers(0, 300), st.booleans()), max_size=200, unique_by=lambda e: e[0]),
    st.lists(st.tuples(st.integers(0, 300), st.booleans()), max_size=200, unique_by=lambda e: e[0]),
    st.booleans(),
)
def test_rows_are_the_steps_one_by_one(
    x: list[tuple[int, bool]], y: list[tuple[int, bool]], laser: bool
) -> None:
    """Few and many steps of one microsecond, each against a walk through the table."""
    packed = [
        np.array(
            [t << TIME_BIT | (FORWARD if up else BACK) << bit for t, up in sorted(axis)], dtype=int
        )
        for axis, bit in ((x, 0), (y, MOVE_BITS))
    ]
    words = steps._Words(STEPPER)
    words.x, words.y = 3, 1
    rows = words.rows(packed[0], packed[1], 1000, laser)
    steps_at = {t: [0, 0] for t, _ in (*x, *y)}
    for axis, listed in enumerate((x, y)):
        for t, up in listed:
            steps_at[t][axis] = 1 if up else -1
    at, expected = [3, 1], []
    for t in sorted(steps_at):
        at = [a + d for a, d in zip(at, steps_at[t], strict=True)]
        expected.append((1000 + t, at[0] % 4 | at[1] % 4 << 2 | laser << 4))
    assert list(zip(rows.time_us.tolist(), rows.bits.tolist(), strict=True)) == expected


def test_velocities_add_up_and_follow_their_formula() -> None:
    made = table("two-tangents")
    rows = list(made.segments())
    assert (sum(s.steps_x for s in rows), sum(s.steps_y for s in rows)) == (0, 0)
    cut = [s for s in rows if s.laser]
    expected = feed_of(TORCH, 4.0) / 60
    assert all(abs(hypot(s.velocity_x, s.velocity_y) - expected) < 1e-9 for s in cut)
    for s in rows:
        assert s.hz_x == pytest.approx(abs(s.velocity_x) / 2.0 * 200)
        assert s.hz_x <= STEPPER.max_hz
    text = b"".join(forms.as_velocities(made)).decode().splitlines()
    assert text[1] == "x,y,velocity_x,velocity_y,laser,steps_x,steps_y,hz_x,hz_y"
    assert len(text) == 2 + len(rows)


def test_the_forms_hold_the_same_rows() -> None:
    made = table("shield-small")
    data = b"".join(forms.as_bytes(made))
    magic, size, step_nm, *words = struct.unpack("<8sIIIIII", data[:32])
    assert (magic, size, step_nm, words) == (b"BCSTEPS1", 32, 10000, [0, 1, 2, 3])
    packed = np.frombuffer(data[32:], dtype="<u4")
    text = forms.emit(made, LASER).splitlines()[2:]
    times = np.cumsum(packed.astype(np.int64) >> 5)
    for k in (0, 1, len(packed) // 2, len(packed) - 1):
        row = packed[k]
        x, y, laser = row & 3, row >> 2 & 3, row >> 4 & 1
        assert text[k] == f"{times[k]:012d},{x:02b},{y:02b},{laser}"
    header = b"".join(forms.as_header(made)).decode()
    found = re.findall(r"0x([0-9a-f]{8})u", header)
    assert [int(v, 16) for v in found] == packed.tolist()


def test_a_long_wait_is_spread_over_rows_of_the_same_words() -> None:
    long = forms.MAX_WAIT_US * 2 + 7
    rows = [StepRows(np.array([0, long]), np.array([0, 5], dtype=np.uint8))]
    made = StepTable("a", 0.01, STEPPER.sequence, lambda: iter(rows), lambda: iter(()))
    packed = np.frombuffer(b"".join(forms.as_bytes(made))[32:], dtype="<u4")
    assert (packed & 31).tolist() == [0, 0, 0, 5]
    assert int((packed.astype(np.int64) >> 5).sum()) == long


def feed_of(torch: Torch, thickness: float, material: str = "acrylic") -> float:
    """By planner and checker, each by itself."""
    part = Part("P", Profile("B", "", 9.0, 0.0, 0.0, thickness), 9.0, Source("p"), grade=material)
    row = SheetMaterial(part, torch).row("cut")
    assert row is not None
    assert {r.feed_mm_min for r in rows_on(part, torch) if r.process == "cut"} == {row.feed_mm_min}
    assert row.feed_mm_min == rows_for(torch, thickness, material)[0].feed_mm_min
    return row.feed_mm_min


@pytest.mark.parametrize(
    ("thickness", "material", "expected"),
    [(1.0, "acrylic", 25.0), (2.0, "acrylic", 25.0), (3.0, "acrylic", 1100 / 60),
     (8.0, "acrylic", 4.0), (6.0, "Wood", 10.0)],
)  # fmt: skip
def test_speed_lies_between_the_rows(thickness: float, material: str, expected: float) -> None:
    assert feed_of(TORCH, thickness, material) / 60 == pytest.approx(expected)


@pytest.mark.parametrize(
    "name", ["laser-stepper", "laser-grbl", "table-simotion", "plate-linuxcnc"]
)
def test_every_motion_has_one_rule_between_the_rows(name: str) -> None:
    """3 mm between rows for 2 and 4 mm; what is posted is read back, and by the other rule not."""
    machine = load(name)
    assert machine.torch is not None
    cut = next(row for row in machine.torch.rows if row.process == "cut")
    others = tuple(row for row in machine.torch.rows if row.process != "cut")
    thin, thick = (replace(cut, up_to=t, feed_mm_min=f) for t, f in ((2.0, 1500.0), (4.0, 700.0)))
    part = drawing(contour(box(0, 0, 60, 40)), thickness=3.0, grade="")
    for rule, feed in (("row above", 700.0), ("interpolate", 1100.0)):
        torch = replace(
            machine.torch, rows=(thin, thick, *others), between_rows=rule, material=cut.material
        )
        other = replace(torch, between_rows="row above" if rule != "row above" else "interpolate")
        assert feed_of(torch, 3.0, cut.material) == feed
        made = replace(machine, torch=torch)
        text = post((part,), made).text
        request = Request((part,), made)
        assert not errors_in(read_back(text, request))
        assert errors_in(read_back(text, replace(request, machine=replace(machine, torch=other))))


@pytest.mark.parametrize(("thickness", "material"), [(8.1, "acrylic"), (0.0, "wood"), (2.0, "tin")])
def test_no_speed_beyond_the_rows(thickness: float, material: str) -> None:
    part = Part("P", Profile("B", "", 9.0, 0.0, 0.0, thickness), 9.0, Source("p"), grade=material)
    assert SheetMaterial(part, TORCH).row("cut") is None
    assert not [row for row in rows_on(part, TORCH) if row.process == "cut"]


def changed(pattern: str, put: str, count: int = 1) -> str:
    text = forms.emit(table("shield-small"), LASER)
    found = re.sub(pattern, put, text, count=count, flags=re.MULTILINE)
    assert found != text
    return found


@pytest.mark.parametrize(
    ("pattern", "put", "code"),
    [
        (r"^time_us,x,y,laser", "time,x,y,laser", "steps-row"),
        (r",01,01,1\n", ",0x,01,1\n", "steps-row"),
        (r"\n(\d+),01,01,1\n", r"\n000000000001,01,01,1\n", "steps-time"),
        (r",1\n(\d+,\d\d,\d\d),0\n", r",1\n\1,1\n", "steps-laser"),
        (r"\d\Z|.\n\Z", "1\n", "steps-laser"),
    ],
)
def test_a_fault_of_a_table_is_told(pattern: str, put: str, code: str) -> None:
    assert any(c.startswith(code) for c in codes(changed(pattern, put)))


def rows_text(rows: list[tuple[int, int, int, int]]) -> str:
    lines = [f"{t:012d},{x & 3:02b},{y & 3:02b},{laser}" for t, x, y, laser in rows]
    return "time_us,x,y,laser\n" + "\n".join(lines) + "\n"


def test_steps_too_near_and_too_sudden_and_outside() -> None:
    near = [(0, 0, 0, 0), (50, 1, 0, 0), (100, 0, 0, 0)]
    assert "steps-frequency" in {d.code for d in verify_text(rows_text(near), [])}
    jump = [(k * 110, k, 0, 0) for k in range(2000)]
    jump += [(2000 * 110 + k * 110, 2000 - k, 0, 0) for k in range(1, 2001)]
    assert "steps-acceleration" in {d.code for d in verify_text(rows_text(jump), [])}
    skip = [(0, 0, 0, 0), (900, 2, 0, 0)]
    assert "steps-word" in {d.code for d in verify_text(rows_text(skip), [])}
    below = [(k * 20000, -k, 0, 0) for k in range(4)]
    assert "steps-place" in {d.code for d in verify_text(rows_text(below), [])}


def test_a_table_cut_short_is_told() -> None:
    text = forms.emit(table("shield-small"), LASER)
    assert "steps-row" in codes(text[:-5])
    assert "steps-place" in codes(text[: len(text) // 2 // 21 * 21 + text.index("0000")] or text)
    data = b"".join(forms.as_bytes(table("shield-small")))
    assert "steps-row" in {d.code for d in verify_table(".bin", (data[:-1],), [], LASER)}


def test_another_part_is_not_this_one() -> None:
    text = forms.emit(table("shield"), LASER)
    assert "steps-place" in codes(text, "shield-small")


def test_a_place_beside_the_path_is_told_with_the_contour_that_is_nearest() -> None:
    text = forms.emit(table("shield"), LASER)
    said = verify_text(text, [part("shield-small")])
    assert any(
        " mm off it, beside the contour of shield-small.json:contours[0]" in d.message for d in said
    ), said


def test_each_row_is_within_half_a_step_of_the_outline() -> None:
    from beamcam.geometry.curves import Line

    made, outline = table("shield"), next(part("shield").contours).curves
    rows = list(made.rows())
    bits = np.concatenate([r.bits for r in rows])
    places = [
        np.cumsum(((np.diff(bits >> s & 3, prepend=0) + 1) & 3).astype(int) - 1) for s in (0, 2)
    ]
    at = np.stack(places, axis=1)[(bits >> 4) == 1] * STEPPER.step
    away = np.full(len(at), np.inf)
    for curve in outline:
        assert isinstance(curve, Line)
        a, b = np.array(curve.start), np.array(curve.end)
        t = np.clip((at - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
        away = np.minimum(away, np.hypot(*(at - a - t[:, None] * (b - a)).T))
    assert away.max() <= STEPPER.step * sqrt(0.5) + 1e-9
