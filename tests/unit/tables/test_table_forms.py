"""Step tables decoded by readers of their own, from what docs/step-tables.md says of each form.

A binary table is taken apart byte by byte, a header by its own macros as a C compiler would expand
them; the head then goes step by step along the sequence of its motors.
"""

import re
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import shapely

from beamcam.machine import load
from beamcam.pipeline import post

from .shop import part

SEQUENCE = (0b00, 0b01, 0b10, 0b11)
STEP = 0.01
SHIELD = [(5, 5), (7, 8), (7, 12), (6, 13), (4, 13), (3, 12), (3, 8), (5, 5)]

Row = tuple[int, int, int, int]  #: microseconds, word of X, word of Y, laser


def read_bin(data: bytes) -> Iterator[Row]:
    """The 32 bytes of the header, then little-endian words of 32 bits."""
    assert data[:8] == b"BCSTEPS1"
    numbers = [int.from_bytes(data[k : k + 4], "little") for k in range(8, 32, 4)]
    assert numbers == [32, round(STEP * 1e6), *SEQUENCE]
    assert len(data) % 4 == 0
    time_us = 0
    for at in range(32, len(data), 4):
        row = data[at] | data[at + 1] << 8 | data[at + 2] << 16 | data[at + 3] << 24
        time_us += row >> 5
        yield time_us, row & 3, row >> 2 & 3, row >> 4 & 1


def read_h(data: bytes) -> Iterator[Row]:
    """Comments and the frame of the header go; its macros are arithmetic in C and Python alike."""
    text = re.sub(r"/\*.*?\*/", "", data.decode("ascii"), flags=re.DOTALL)
    lines = [line for line in text.split("\n") if line]
    assert lines[:3] == ["#ifndef BEAMCAM_STEPS_H", "#define BEAMCAM_STEPS_H",
                         "#include <stdint.h>"]  # fmt: skip
    assert lines[-1] == "#endif"
    plain = dict(re.findall(r"#define (\w+) (\d+)u", text))
    assert plain == {"BEAMCAM_STEP_NM": str(round(STEP * 1e6))}
    macros: dict[str, Callable[[int], int]] = {}
    for name, body in re.findall(r"#define BEAMCAM_(\w+)\(row\) (.+)", text):
        macros[name] = eval(f"lambda row: {re.sub(r'(?<=[0-9])u', '', body)}")
    assert set(macros) == {"X", "Y", "LASER", "WAIT_US"}
    frame = re.search(r"static const uint32_t beamcam_steps\[\] = \{\n(.*?)\};", text, re.DOTALL)
    assert frame is not None
    time_us = 0
    for literal in frame[1].replace("\n", "").rstrip(",").split(","):
        assert re.fullmatch(r"0x[0-9a-f]{8}u", literal)
        row = int(literal[2:-1], 16)
        time_us += macros["WAIT_US"](row)
        yield time_us, macros["X"](row), macros["Y"](row), macros["LASER"](row)


def read_steps(data: bytes) -> Iterator[Row]:
    lines = [line for line in data.decode("ascii").split("\n") if line and line[0] != "#"]
    assert lines[0] == "time_us,x,y,laser"
    for line in lines[1:]:
        time, x, y, laser = line.split(",")
        yield int(time), int(x, 2), int(y, 2), int(laser)


READERS = {".bin": read_bin, ".h": read_h, ".steps": read_steps}


def written(form: str, name: str = "shield-small") -> bytes:
    pieces = post((part(name),), load("laser-stepper"), style=form).pieces()
    return b"".join(p.encode() if isinstance(p, str) else p for p in pieces)


def turns(words: list[int]) -> np.ndarray:
    """Places of a motor in steps, from the words that it was sent."""
    at = [0]
    for before, behind in pairwise([SEQUENCE[0], *words]):
        way = (SEQUENCE.index(behind) - SEQUENCE.index(before)) % 4
        assert way != 2, "a word was skipped"
        at.append(at[-1] + (0, 1, 0, -1)[way])
    return np.array(at[1:])


@pytest.mark.parametrize("form", READERS)
def test_a_table_draws_the_part(form: str) -> None:
    time, x, y, laser = (list(column) for column in zip(*READERS[form](written(form)), strict=True))
    assert (time[0], x[0], y[0], laser[0]) == (0, *SEQUENCE[:1] * 2, 0)
    assert all(a <= b for a, b in pairwise(time))
    places = STEP * np.column_stack((turns(x), turns(y)))
    assert places[-1].tolist() == [0.0, 0.0]
    on = np.array(laser, dtype=bool)
    drawing = shapely.LineString(SHIELD)
    # Within half a step of both axes, and the tolerance of the drawing.
    assert shapely.distance(shapely.points(places[on]), drawing).max() <= 0.5**0.5 * STEP + 0.01
    drawn = shapely.LineString(places[on])
    assert shapely.hausdorff_distance(drawing, drawn, densify=0.01) <= 2 * STEP
    assert places[on][0].tolist() == pytest.approx([5, 5])
    assert places[on][-1].tolist() == pytest.approx([5, 5])
    # No two steps of a motor sooner than its greatest frequency allows: 10 kHz.
    for words in (x, y):
        steps = [t for t, (a, b) in zip(time[1:], pairwise(words), strict=True) if a != b]
        assert min(b - a for a, b in pairwise(steps)) >= 100


def test_all_forms_hold_the_same_rows(tmp_path: Path) -> None:
    rows = {form: list(read(written(form))) for form, read in READERS.items()}
    assert rows[".bin"] == rows[".h"]
    # A wait that is longer than a packed row can tell is spread; without these they are the same.
    changes = {
        form: [b for a, b in pairwise([(0, -1, -1, -1), *found]) if a[1:] != b[1:]]
        for form, found in rows.items()
    }
    assert changes[".bin"] == changes[".steps"]


def test_velocities_add_up_to_the_steps() -> None:
    lines = [line for line in written(".csv").decode().split("\n") if line and line[0] != "#"]
    columns = lines[0].split(",")
    rows = [dict(zip(columns, map(float, line.split(",")), strict=True)) for line in lines[1:]]
    assert sum(r["steps_x"] for r in rows) == sum(r["steps_y"] for r in rows) == 0
    here = np.zeros(2)
    for r in rows:
        way = np.array([r["x"], r["y"]]) - here
        speed = np.array([r["velocity_x"], r["velocity_y"]])
        assert [r["steps_x"], r["steps_y"]] == pytest.approx((way / STEP).tolist())
        assert way[0] * speed[1] == pytest.approx(way[1] * speed[0], abs=1e-3)
        assert [r["hz_x"], r["hz_y"]] == pytest.approx((abs(speed) / 2 * 200).tolist(), abs=0.01)
        here = here + way
    cut = [(r["x"], r["y"]) for r in rows if r["laser"]]
    assert cut == SHIELD[1:]
