"""Tables that were changed in one place: the read-back catches each, whatever the form."""

import random
import re
import struct
from collections.abc import Callable

import numpy as np
import pytest

from beamcam.checks.steps import FORMS, verify_table
from beamcam.emitters import step_table as forms
from beamcam.machine import load
from beamcam.motion.steps import step_table

from .shop import part, plan

NAME = "shield-small"
LASER = load("laser-stepper")
TABLE = step_table(plan(NAME, "laser-stepper"), LASER, NAME)
WRITTEN = {form: b"".join(forms.FORMS[form](TABLE)) for form in FORMS}
TIMES = 6  #: that each kind of mutation is tried on each form

#: Time in microseconds, word of X, word of Y, laser.
Row = tuple[int, int, int, int]
Rows = list[Row]


def codes(form: str, data: bytes, name: str = NAME) -> set[str]:
    return {d.code for d in verify_table(form, (data,), [part(name)], LASER, (), "a" + form)}


# -- the forms, written anew ----------------------------------------------------------------


def rows_of() -> Rows:
    """The rows of the sample."""
    found = []
    for line in WRITTEN[".steps"].decode().splitlines()[2:]:
        time, x, y, laser = line.split(",")
        found.append((int(time), int(x, 2), int(y, 2), int(laser)))
    return found


def as_steps(rows: Rows) -> bytes:
    lines = "".join(f"{t:012d},{x:02b},{y:02b},{laser}\n" for t, x, y, laser in rows)
    return b"time_us,x,y,laser\n" + lines.encode()


def packed(rows: Rows) -> list[int]:
    before = [0, *(row[0] for row in rows)]
    return [
        (t - b) << 5 | laser << 4 | y << 2 | x
        for b, (t, x, y, laser) in zip(before, rows, strict=False)
    ]


def as_bin(rows: Rows) -> bytes:
    return WRITTEN[".bin"][:32] + struct.pack(f"<{len(rows)}I", *packed(rows))


def as_h(rows: Rows) -> bytes:
    head = WRITTEN[".h"].partition(b"= {\n")
    lines = "".join(f"0x{row:08x}u,\n" for row in packed(rows))
    return head[0] + head[1] + lines.encode() + b"};\n\n#endif\n"


WRITE: dict[str, Callable[[Rows], bytes]] = {".steps": as_steps, ".bin": as_bin, ".h": as_h}


# -- what may be wrong with rows ------------------------------------------------------------


def shift(rows: Rows, k: int, x: int = 0, y: int = 0) -> Rows:
    """From one row on all words are others: steps are missing, or too many."""
    return rows[:k] + [(t, wx + x & 3, wy + y & 3, laser) for t, wx, wy, laser in rows[k:]]


def turn(rows: Rows, k: int, x: int = 0, y: int = 0, laser: int = 0) -> Rows:
    """One row with other words."""
    t, was_x, was_y, was_laser = rows[k]
    return [*rows[:k], (t, was_x + x & 3, was_y + y & 3, was_laser ^ laser), *rows[k + 1 :]]


def later(rows: Rows, k: int, us: int) -> Rows:
    return rows[:k] + [(t + us, *rest) for t, *rest in rows[k:]]  # type: ignore[misc]


def swap(rows: Rows, k: int) -> Rows:
    """Two rows with their words exchanged."""
    (t, *words), (u, *others) = rows[k], rows[k + 1]
    return [*rows[:k], (t, *others), (u, *words), *rows[k + 2 :]]  # type: ignore[list-item]


def under_way(rows: Rows, rng: random.Random) -> int:
    """A row with the laser on that steps, and is followed by one that steps otherwise."""
    while True:
        k = rng.randrange(3, len(rows) - 3)
        before, this, behind = (row[1:] for row in rows[k - 1 : k + 2])
        if this[2] and before != this != behind and before[2] and behind[2]:
            return k


def of_stroke(rows: Rows, share: float) -> Rows:
    """The stroke slower or faster."""
    first = next(k for k, row in enumerate(rows) if row[3])
    start = rows[first][0]
    return [
        (t if k < first else start + round((t - start) * share), *rest)
        for k, (t, *rest) in enumerate(rows)
    ]  # type: ignore[misc]


MUTATIONS: dict[str, Callable[[Rows, random.Random], Rows]] = {
    "X a step more": lambda r, g: shift(r, under_way(r, g), x=1),
    "X a step less": lambda r, g: shift(r, under_way(r, g), x=-1),
    "Y a step more": lambda r, g: shift(r, under_way(r, g), y=1),
    "both a step less": lambda r, g: shift(r, under_way(r, g), x=-1, y=-1),
    "X two steps": lambda r, g: turn(r, under_way(r, g), x=2),
    "Y two steps": lambda r, g: turn(r, under_way(r, g), y=2),
    "the laser off for a row": lambda r, g: turn(r, under_way(r, g), laser=1),
    "the laser on too early": lambda r, g: turn(r, g.randrange(1, 400), laser=1),
    "the laser on behind the stroke": lambda r, g: turn(r, g.randrange(len(r) - 400, len(r)),
                                                        laser=1),
    "words exchanged": lambda r, g: swap(r, under_way(r, g)),
    "a row before the last one": lambda r, g: [
        (max(0, t - 500_000) if k == len(r) // 2 else t, *w) for k, (t, *w) in enumerate(r)],
    "a halt under way": lambda r, g: later(r, under_way(r, g), 900_000),
    "the stroke at half its speed": lambda r, g: of_stroke(r, 2.0),
    "the stroke at a tenth more": lambda r, g: of_stroke(r, 1 / 1.1),
    "X turned round": lambda r, g: [(t, -x & 3, y, la) for t, x, y, la in r],
    "X and Y exchanged": lambda r, g: [(t, y, x, la) for t, x, y, la in r],
    "cut off": lambda r, g: r[: under_way(r, g)],
    "without its start": lambda r, g: r[under_way(r, g) :],
    "the laser always off": lambda r, g: [(t, x, y, 0) for t, x, y, _ in r],
    "the laser always on": lambda r, g: [(t, x, y, 1) for t, x, y, _ in r],
    "no rows": lambda r, g: [],
}  # type: ignore[dict-item]  # fmt: skip


@pytest.mark.parametrize("form", WRITE)
def test_rows_written_anew_are_the_sample(form: str) -> None:
    assert codes(form, WRITE[form](rows_of())) == set()
    assert WRITE[form](rows_of()).endswith(WRITTEN[form][-60_000:][-40:])


@pytest.mark.parametrize("form", WRITE)
@pytest.mark.parametrize("kind", MUTATIONS)
def test_a_changed_row_is_caught(kind: str, form: str) -> None:
    rng = random.Random(kind)
    for _ in range(TIMES):
        rows = rows_of()
        changed = MUTATIONS[kind](rows, rng)
        if kind == "a row before the last one" and form != ".steps":
            continue  # a wait has no sign
        assert changed != rows
        assert codes(form, WRITE[form](changed)), kind


@pytest.mark.parametrize("form", FORMS)
def test_another_part_is_not_this_one(form: str) -> None:
    assert codes(form, WRITTEN[form], "shield")


@pytest.mark.parametrize("form", FORMS)
def test_a_table_that_was_cut_off_is_caught(form: str) -> None:
    rng = random.Random(form)
    for size in (0, 1, 7, 33, *(rng.randrange(40, len(WRITTEN[form])) for _ in range(20))):
        assert codes(form, WRITTEN[form][:size]), size


@pytest.mark.parametrize("form", FORMS)
def test_something_behind_the_end_is_caught(form: str) -> None:
    for more in (b"x", b"\n", b"00\n"):
        assert codes(form, WRITTEN[form] + more)


# -- what may be wrong with the frame of a form ---------------------------------------------


@pytest.mark.parametrize("at", range(32))
def test_each_byte_of_the_binary_head_counts(at: int) -> None:
    data = bytearray(WRITTEN[".bin"])
    data[at] ^= 0x21
    assert codes(".bin", bytes(data)) & {"steps-row", "steps-head"}


def test_each_line_of_a_header_counts() -> None:
    lines = WRITTEN[".h"].split(b"\n")
    for k, line in enumerate(lines[:13]):
        if line.startswith(b"/*"):
            continue
        for other in (line + b" ", line.replace(b"2", b"3"), line.replace(b"u", b"l"), b"#"):
            if other != line:
                changed = b"\n".join([*lines[:k], other, *lines[k + 1 :]])
                assert codes(".h", changed) & {"steps-head"}, other
        assert codes(".h", b"\n".join(lines[:k] + lines[k + 1 :])) & {"steps-head"}, line


def test_each_sign_of_a_row_of_a_header_counts() -> None:
    begin = WRITTEN[".h"].index(b"= {\n") + 4
    row = begin + 13 * 1500
    assert WRITTEN[".h"][row : row + 2] == b"0x"
    for at in (0, 1, *range(9, 13)):  # between them is the time
        data = bytearray(WRITTEN[".h"])
        data[row + at] ^= 1
        assert codes(".h", bytes(data)), at


# -- velocities -----------------------------------------------------------------------------

CSV = WRITTEN[".csv"].decode().splitlines()
HEAD = CSV[:2]
COLUMNS = CSV[1].split(",")


def csv(lines: list[str]) -> bytes:
    return ("\n".join([*HEAD, *lines]) + "\n").encode()


def number(value: float) -> str:
    text = f"{value:.4f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


FIELD_CHANGES: dict[str, Callable[[float], float]] = {
    "a little more": lambda v: v + 0.05,
    "a little less": lambda v: v - 0.05,
    "one more": lambda v: v + 1,
    "ten times": lambda v: 10 * v,
    "another sign": lambda v: -v,
}


@pytest.mark.parametrize("change", FIELD_CHANGES)
@pytest.mark.parametrize("column", [c for c in COLUMNS if c != "laser"])
def test_each_number_of_a_velocity_table_counts(column: str, change: str) -> None:
    at = COLUMNS.index(column)
    for k, line in enumerate(CSV[2:]):
        fields = line.split(",")
        value = number(FIELD_CHANGES[change](float(fields[at])))
        if value == fields[at]:
            continue  # 0 has no other sign
        fields[at] = value
        assert codes(".csv", csv([*CSV[2 : 2 + k], ",".join(fields), *CSV[3 + k :]])), line


ROW_CHANGES: dict[str, Callable[[list[str], int], list[str]]] = {
    "missing": lambda r, k: r[:k] + r[k + 1 :],
    "twice": lambda r, k: r[: k + 1] + r[k:],
    "exchanged with the next": lambda r, k: [*r[:k], *r[k : k + 2][::-1], *r[k + 2 :]],
    "without a field": lambda r, k: [*r[:k], r[k].rpartition(",")[0], *r[k + 1 :]],
    "with a word": lambda r, k: [*r[:k], r[k].replace(",", ",x", 1), *r[k + 1 :]],
    "empty": lambda r, k: [*r[:k], "", *r[k:]],
}


@pytest.mark.parametrize("change", ROW_CHANGES)
def test_each_row_of_a_velocity_table_counts(change: str) -> None:
    rows = CSV[2:]
    for k in range(len(rows)):
        changed = ROW_CHANGES[change](rows, k)
        if changed != rows:
            assert codes(".csv", csv(changed)), changed


def test_the_laser_of_each_row_counts() -> None:
    for k, line in enumerate(CSV[2:]):
        fields = line.split(",")
        fields[4] = "10"[int(fields[4])]
        assert codes(".csv", csv([*CSV[2 : 2 + k], ",".join(fields), *CSV[3 + k :]])), line


@pytest.mark.parametrize("share", [0.5, 0.99, 1.01, 2.0])
def test_a_stretch_at_another_speed_is_caught(share: float) -> None:
    """Velocity and frequencies agree, but the machine's table has another speed."""
    for k, line in enumerate(CSV[2:]):
        x, y, vx, vy, laser, nx, ny, _, _ = line.split(",")
        speeds = [number(float(v) * share) for v in (vx, vy)]
        hz = [number(abs(float(v)) / 0.01) for v in speeds]
        changed = ",".join((x, y, *speeds, laser, nx, ny, *hz))
        found = codes(".csv", csv([*CSV[2 : 2 + k], changed, *CSV[3 + k :]]))
        assert found & {"steps-speed", "steps-velocity"}, changed


def test_a_table_for_another_lead_screw_is_caught() -> None:
    for form in (".csv", ".steps"):
        data = re.sub(rb"step 0.01 mm", b"step 0.02 mm", WRITTEN[form])
        assert codes(form, data) == {"steps-head"}


def test_the_last_line_has_an_end() -> None:
    assert codes(".csv", WRITTEN[".csv"][:-1]) == {"steps-row"}


def test_rows_are_the_same_in_any_cut() -> None:
    rng = np.random.default_rng(3)
    for form, data in WRITTEN.items():
        cuts = np.sort(rng.integers(0, len(data), 40)).tolist()
        pieces = [data[a:b] for a, b in zip([0, *cuts], [*cuts, len(data)], strict=True)]
        assert verify_table(form, pieces, [part(NAME)], LASER, (), form) == ()
