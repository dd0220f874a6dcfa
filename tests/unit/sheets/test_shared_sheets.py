"""Several parts on one sheet: in rows, each compared at its place, each once."""

import re
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace
from shapely import box as rectangle

from beamcam.cli import main
from beamcam.errors import PlanError
from beamcam.geometry.curves import Arc
from beamcam.model.part import Hole, Part, Profile, TextMark
from beamcam.model.request import Request
from beamcam.pipeline import post, read_back, shares_of
from beamcam.planning.sheet_rows import places_of
from tests.conftest import SAMPLES, examples
from tests.unit.sheets.parts import NESTED, S, contour, drawing, table

GUSSET, PLATE = str(SAMPLES / "dstv" / "gusset.nc1"), str(SAMPLES / "dstv" / "plate.nc1")


def sized(length: float, width: float, *features: Hole | TextMark, mark: str = "P1") -> Part:
    profile = Profile("B", f"PL6*{width:g}", width, 0.0, 0.0, 6.0)
    return Part(mark, profile, length, S, features=features)


def call(*words: object) -> Result:
    done = CliRunner().invoke(main, [*map(str, words)])
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    return done


SIZES = st.tuples(st.integers(20, 400), st.integers(20, 300))


@settings(max_examples=examples(30), deadline=None)
@given(st.lists(SIZES, min_size=1, max_size=12))
def test_parts_lie_apart_and_on_the_sheet_each_once(sizes: list[tuple[int, int]]) -> None:
    machine = table(length=1000.0, width=500.0)
    parts = [sized(x, y, mark=f"P{k}") for k, (x, y) in enumerate(sizes)]
    shares = shares_of(Request(tuple(parts), machine))
    assert [place for share in shares for place in share.pieces] == [*range(len(parts))]
    for share in shares:
        there = [parts[place] for place in share.pieces]
        boxes = [
            rectangle(x, y, x + part.length, y + part.profile.height)
            for part, (x, y) in zip(there, places_of(there, machine, ()), strict=True)
        ]
        assert len(boxes) == len(there)
        assert all(rectangle(10, 10, 990, 490).covers(one) for one in boxes)
        for k, one in enumerate(boxes):
            assert all(one.distance(other) >= 10.0 - 1e-9 for other in boxes[:k])


MIXED = (
    sized(200, 100, Hole("v", 50, 50, 20.0, S), TextMark("v", 100, 50, 0.0, 10.0, "X1", S)),
    NESTED,
    sized(150, 80, Hole("v", 40, 40, 3.0, S)),
    NESTED,
)


@pytest.mark.parametrize("name", ["plate-linuxcnc", "plate-codesys"])
def test_each_part_is_compared_at_its_place(name: str) -> None:
    machine = table(name, length=900.0)
    parts = tuple(replace(part, grade="") for part in MIXED)
    made = post(list(parts), machine)
    assert len(made.plan.pieces) == 4
    features = [(k, f) for k, part in enumerate(parts) for f in range(len(part.features))]
    assert [o.feature for o in made.plan.outcomes] == features

    def codes(*others: Part) -> set[str]:
        found = read_back(made.text, Request(others, machine))
        return {d.code for d in found if d.severity.value == "error"}

    assert codes(*parts) == set()
    assert codes(*parts[:3]) >= {"verify-sheet-extra"}
    assert codes(*parts, parts[2]) >= {"verify-sheet-missing"}
    assert codes(parts[1], parts[0], *parts[2:]) >= {"verify-sheet-missing"}
    moved = replace(parts[2], features=(Hole("v", 41, 40, 3.0, S),))
    assert codes(*parts[:2], moved, parts[3]) >= {"verify-sheet-missing"}
    other = replace(parts[3], grade="S355")
    assert codes(*parts[:3], other) >= {"verify-sheet-other"}


def test_tables_without_g_code_share_sheets_too() -> None:
    one = drawing(contour((Arc((20, 20), 15, 0.0, 360.0),), "#ff0000"), thickness=3.0)
    for name in ("table-simotion", "laser-stepper"):
        machine = table(name)
        machine = replace(machine, torch=replace(machine.torch, colours={"red": "cut"}))
        made = post([one, one], machine)
        assert len(made.plan.pieces) == 2
        short = read_back(made.text, Request((one,), machine))
        assert "error" in {d.severity.value for d in short}


def test_a_part_that_no_sheet_holds_is_refused_as_it_is() -> None:
    machine = table(length=300.0, width=200.0)
    parts = (sized(100, 100), sized(900, 50))
    assert [share.pieces for share in shares_of(Request(parts, machine))] == [(0,), (1,)]
    with pytest.raises(PlanError, match="found a sheet of 9"):
        post([parts[1]], machine)


def test_sheets_are_posted_with_quantities_and_read_back(tmp_path: Path) -> None:
    out = tmp_path / "a.ngc"
    done = call("post", GUSSET, "--quantity", 30, "--sheet", "1500x1000", "-o", out)
    assert done.exit_code == 0, done.stderr
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == ["a-1.ngc", "a-2.ngc"]
    first = (tmp_path / "a-1.ngc").read_text()
    count = sum(
        call("verify", tmp_path / "a-1.ngc", "--machine", "plate-linuxcnc", "--sheet", "1500x1000",
             "--against", *[GUSSET] * n).exit_code == 0
        for n in (24, 25, 26)
    )  # fmt: skip
    assert count == 1
    assert max(float(x) for x in re.findall(r"X([\d.]+)", first)) < 1500
    plan = call("plan", GUSSET, GUSSET, "--machine", "plate-linuxcnc")
    assert plan.stdout.count("its x 0, y 0 at X") == 2
    assert call("plan", GUSSET, GUSSET, "--machine", "plate-linuxcnc", "--json").exit_code == 0


@pytest.mark.parametrize("size", ["3000", "0x10", "axb", "-1x5"])
def test_a_size_of_a_sheet_is_two_lengths(size: str) -> None:
    done = call("post", GUSSET, "--sheet", size, "-o", "-")
    assert done.exit_code == 2
    assert "expected length x width in mm" in done.stderr


def test_a_sheet_is_no_larger_than_the_table() -> None:
    done = call("post", GUSSET, "--machine", "plate-linuxcnc", "--sheet", "6000x2000", "-o", "-")
    assert done.exit_code == 1
    assert "which takes 3000 x 1500 mm" in done.stderr


def test_a_pipe_that_is_unrolled_is_cut_flat_only_if_asked(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe.nc1"
    text = Path(PLATE).read_text()
    name = next(line.strip() for line in text.split("\n") if line.strip().startswith("PL"))
    pipe.write_text(text.replace(name, "PIPE114.3*5"))
    for skips in ((), ("--allow-skips", "all")):
        refused = call("post", pipe, *skips, "-o", "-")
        assert refused.exit_code == 1
        assert "plan-unrolled" in refused.stderr
        assert "--unrolled" in refused.stderr
    assert call("post", pipe, "--unrolled", "-o", tmp_path / "a.ngc").exit_code == 0
