"""Every refusal of a plan names its ways out, and each works; or says that there is none."""

import re
import shlex
from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import cos, pi, sin
from pathlib import Path

import pytest
from click.testing import Result
from msgspec.structs import replace

from beamcam import suggestions
from beamcam.errors import ReadError, Source, errors_in
from beamcam.geometry.curves import Line
from beamcam.machine import Machine, load, shipped
from beamcam.model.part import Contour, Hole, Measures, Part, Profile
from beamcam.model.request import Job, Request, stock_of
from beamcam.pipeline import read_file
from beamcam.posts import Post, post_of
from beamcam.writers.dstv import write
from tests.conftest import CORPUS, SAMPLES, rules_of
from tests.runs import call

FOUND, END = "plan-ways-out: with ", " it can be made"


OURS = (SAMPLES / "bad", SAMPLES / "dstv", SAMPLES / "coping")
#: The folders of each test, which of their files, and how many at least are of its kind.
REFUSED = [
    (OURS, 6, 2, 0),
    pytest.param(OURS, 1, 8, 3, marks=pytest.mark.alike),
    pytest.param((CORPUS / "dstv",), 1, 1, 1, marks=pytest.mark.third_party),
]
UNREADABLE = [
    (OURS, 10),
    pytest.param((CORPUS / "dstv",), 5, marks=pytest.mark.third_party),
]


def inputs(*folders: Path) -> Iterator[Path]:
    for folder in folders:
        yield from (p for p in sorted(folder.rglob("*")) if p.suffix.lower() in (".nc", ".nc1"))


def is_refused_by_the_plan(done: Result) -> bool:
    errors = [line for line in done.stderr.splitlines() if ": error " in line]
    return bool(errors) and all(": error plan-" in line for line in errors)


def is_read(path: Path) -> bool:
    try:
        return not errors_in(read_file(str(path)).diagnostics)
    except ReadError:
        return False


def is_of_sheets(path: Path) -> bool:
    reading = read_file(str(path))
    return bool(reading.parts) and stock_of(reading.parts) == "sheet"


@pytest.mark.parametrize(("folders", "every", "ways", "none"), REFUSED)
def test_each_way_out_of_each_refusal_works(
    folders: tuple[Path, ...], every: int, ways: int, none: int, tmp_path: Path
) -> None:
    seen = {"ways": 0, "none": 0}
    for path in [*inputs(*folders)][::every]:
        for machine in (None, "beamline") if path.is_relative_to(SAMPLES) else (None,):
            if machine and is_of_sheets(path):
                continue
            asked = ("post", path, "-o", "-", *(("--machine", machine) if machine else ()))
            done = call(*asked)
            if not is_refused_by_the_plan(done):
                continue
            (note,) = [line for line in done.stderr.splitlines() if ": note plan-ways-out" in line
                       or ": note plan-no-way-out" in line]  # fmt: skip
            if "plan-no-way-out" in note:
                seen["none"] += 1
                assert call(*asked, "--allow-skips", "all").exit_code == 1, path
                continue
            for way in note[note.index(FOUND) + len(FOUND) :].removesuffix(END).split(" or "):
                seen["ways"] += 1
                words = list(asked)
                if way.startswith("`beamcam split "):
                    names = way.split("`")[1].split()[-1]
                    call("split", path, "--machines", names, "-o", tmp_path / path.stem, status=0)
                    continue
                if way.startswith("--machine") and machine:
                    words = [*asked[:4]]
                call(*words, *shlex.split(way), status=0)
    assert seen["ways"] >= ways
    assert seen["none"] >= none


def test_the_fewest_kinds_are_left_out_and_none_that_a_shipped_machine_makes() -> None:
    header = SAMPLES / "coping" / "header.nc1"
    for words in ((), ("--machine", "beamline"), ("--machine", "coper-linuxcnc")):
        said = call("post", header, "-o", "-", *words).stderr
        assert "`beamcam split --machines beamline-pusher,coper-linuxcnc`" in said
        assert "--allow-skips" not in said
    slot = SAMPLES / "bad" / "slot.nc1"
    said = call("post", slot, "-o", "-", "--machine", "beamline").stderr
    names = ("beamline-pusher", "coper-linuxcnc", "coper-tilt-linuxcnc", "tube-linuxcnc")
    assert f"{FOUND}{' or '.join(f'--machine {name}' for name in names)}{END}" in said


def test_a_flat_that_is_too_long_for_a_table_is_sawn(tmp_path: Path) -> None:
    profile = Profile("B", "FL50*5", 50.0, 0.0, 0.0, 5.0)
    hole = Hole("v", 100.0, 25.0, 14.0, Source("a"))
    flat = tmp_path / "flat.nc1"
    flat.write_text(write(Part("F1", profile, 9980.0, Source("a"), features=(hole,))))
    done = call("post", flat, "-o", "-", "--machine", "plate-linuxcnc")
    assert f"{FOUND}--machine beamline-pusher{END}" in done.stderr, done.stderr
    assert "MACHINE beamline-pusher " in call("post", flat, "-o", "-", status=0).stdout


def test_no_way_out_is_none_on_any_machine() -> None:
    path = SAMPLES / "bad" / "section-too-large.nc1"
    assert "plan-no-way-out" in call("post", path, "-o", "-").stderr
    beams = [name for name in shipped() if load(name).stock == "beam"]
    assert all(call("post", path, "-o", "-", "--machine", name).exit_code == 1 for name in beams)
    assert {rule.code for rule in rules_of(suggestions)} == {
        "plan-ways-out", "plan-no-way-out", "plan-ways-untried", "read-ways-out",
        "read-no-way-out",
    }  # fmt: skip


def test_a_large_drawing_is_planned_a_few_times_only(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of what is planned again and again no more than MOST_WORK curves and features are."""
    planned: list[int] = []

    def counted(machine: Machine) -> Post:
        post = post_of(machine)

        def plan(job: Job) -> object:
            planned.append(sum(len(c.curves) for part in job.parts for c in part.contours))
            return post.plan(job)

        return replace(post, plan=plan)

    monkeypatch.setattr(suggestions, "post_of", counted)
    table = load("plate-linuxcnc")
    for corners, is_tried in ((4, False), (900, True)):
        ring = [(200.0 + 90.0 * cos(k), 200.0 + 90.0 * sin(k)) for k in
                (2 * pi * n / corners for n in range(corners))]  # fmt: skip
        lines = tuple(Line(a, b) for a, b in pairwise([*ring, (250.0, 250.0)]))
        part = Part("P", Profile("B", "PL8", 500.0, 0.0, 0.0, 8.0), 500.0, Source("a"),
                    features=(Contour("v", "open", lines, Source("a"), closed=False),),
                    measures=Measures())  # fmt: skip
        planned.clear()
        said = suggestions.suggestions(
            Request((part,), table), [table], [load("plate-oxyfuel")] * 30
        )
        assert (said.code == "plan-ways-untried") == is_tried
        assert sum(planned) <= suggestions.MOST_WORK


@pytest.mark.parametrize(("code", "status", "says"), [
    ("plan-cope", 0, "plan-cope  error"), ("plan-coep", 1, "plan-cope"),
])  # fmt: skip
def test_one_code_is_explained(code: str, status: int, says: str) -> None:
    done = call("codes", code)
    assert done.exit_code == status
    assert says in done.output
    assert done.output.count("\n") <= 8


@pytest.mark.parametrize(("words", "way"), [
    (("layers.dxf", "--machine", "table-simotion", "--thickness", "3"), "--place corner"),
    (("plate.dxf", "--machine", "laser-stepper", "--map", "CUT=cut"), "--thickness 2"),
])  # fmt: skip
def test_a_drawing_is_told_the_option_that_it_lacks(words: tuple[str, ...], way: str) -> None:
    name, *more = words
    asked = ("post", SAMPLES / "dxf" / name, *more, "-o", "-")
    said = call(*asked).stderr
    assert f"{FOUND}{way}" in said, said
    assert call(*asked, *way.split()).exit_code == 0


def saved(tmp_path: Path, units: int, *shapes: Sequence[tuple[float, float]]) -> Path:
    """A drawing of red polylines; closed where they end at their first place."""
    from tests.dxf_text import drawing, polyline

    text = "".join(
        polyline(list(shape[:-1] if shape[0] == shape[-1] else shape), shape[0] == shape[-1])
        for shape in shapes
    )
    path = tmp_path / "part.dxf"
    path.write_bytes(drawing(text.replace("8\n0\n", "8\n0\n62\n1\n"), units=units))
    return path


def ring(width: float, height: float) -> list[tuple[float, float]]:
    return [(0, 0), (width, 0), (width, height), (0, height), (0, 0)]


@pytest.mark.parametrize(("units", "shape", "way"), [
    (4, [(0, 0), (80, 0), (80, 60), (0, 60), (0, 0.15)], "--gap 0.2"),
    (4, [(0, 0), (20, -20), (1620, 1580), (1600, 1600), (0, 0)], "--rotate 105"),
    (1, ring(300, 200), "--units mm"),
    (4, [(0, 0), (80, 0), (80, 60)], "--allow-open"),
])  # fmt: skip
def test_a_drawing_is_told_what_closes_opens_turns_or_scales_it(
    tmp_path: Path, units: int, shape: list[tuple[float, float]], way: str
) -> None:
    path = saved(tmp_path, units, shape)
    asked = ("post", path, "--thickness", "3", "--sheet", "2000x1500", "-o", tmp_path / "a.ngc")
    done = call(*asked, status=1)
    assert f"{FOUND}{way}" in done.stderr, done.stderr
    assert call(*asked, *way.split()).exit_code == 0


def test_parts_that_touch_are_told_to_share_their_cut(tmp_path: Path) -> None:
    """Two trapezoids with one slanting side."""
    one = [(0, 0), (80, 0), (60, 60), (0, 60), (0, 0)]
    path = saved(tmp_path, 4, one, [(80, 0), (150, 0), (150, 60), (60, 60), (80, 0)])
    asked = ("post", path, "--thickness", "3", "--machine", "plate-qtplasmac")
    done = call(*asked, "-o", tmp_path / "a.ngc")
    assert f"{FOUND}--common-cuts{END}" in done.stderr, done.stderr
    assert call(*asked, "--common-cuts", "-o", tmp_path / "a.ngc").exit_code == 0


def test_a_machine_that_keeps_no_kerf_off_is_no_way_out(tmp_path: Path) -> None:
    """A slit between two parts is as wide as no kerf; a table without one would cut both edges."""
    path = saved(tmp_path, 4, ring(80, 60), [(81, 0), (150, 0), (150, 60), (81, 60), (81, 0)])
    asked = ("post", path, "--thickness", "3", "-o", tmp_path / "a")
    done = call(*asked, "--machine", "plate-linuxcnc", status=1)
    for name in ("table-simotion", "laser-stepper", "laser-grbl"):
        assert name not in done.stderr


def test_a_colour_that_the_map_lacks_is_no_dead_end(tmp_path: Path) -> None:
    """White lines on a laser: the error names the colour, the way out all that is left."""
    path = saved(tmp_path, 4, ring(80, 60))
    path.write_text(path.read_text().replace("\n62\n1\n", "\n62\n7\n"))
    asked = ("post", path, "--thickness", "3", "--material", "acrylic", "-o", tmp_path / "a.nc",
             "--machine", "laser-grbl")  # fmt: skip
    done = call(*asked)
    assert "or --map white=cut" in done.stderr
    assert f"{FOUND}--map '*=cut'{END}" in done.stderr
    assert call(*asked, "--map", "*=cut").exit_code == 0


def test_star_in_the_map_is_everything_else() -> None:
    asked = ("post", SAMPLES / "dxf" / "plate.dxf", "--thickness", "3", "--allow-open", "-o", "-")
    done = call(*asked, "--map", "*=cut", status=0)
    assert done.output == call(*asked, "--map", "CUT=cut", "--map", "ETCH=cut").output
    mixed = call(*asked, "--map", "*=cut", "--map", "ETCH=mark")
    assert mixed.output == call(*asked, "--map", "CUT=cut", "--map", "ETCH=mark").output


def test_other_machines_are_tried_with_the_options_of_the_job() -> None:
    """A key of the map that no curve has is refused by all machines."""
    asked = ("post", SAMPLES / "dxf" / "plate.dxf", "--machine", "plate-linuxcnc", "-o", "-")
    done = call(*asked, "--thickness", "3", "--map", "pink=cut")
    assert "plan-map-key" in done.stderr
    assert "plan-ways-out" not in done.stderr


@pytest.mark.parametrize(("folders", "least"), UNREADABLE)
def test_a_file_that_cannot_be_read_says_that_no_option_helps(
    folders: tuple[Path, ...], least: int
) -> None:
    """And none does: with all of them the same errors come."""
    options = ("--allow-skips", "all", "--turn", "--bar", "18000", "--machine", "beamline-pusher")
    seen = 0
    for path in inputs(*folders):
        if is_read(path):
            continue
        done = call("post", path, "-o", "-")
        errors = [line for line in done.stderr.splitlines() if ": error " in line]
        if not errors or not all(": error dstv-" in line or "read-" in line for line in errors):
            continue
        if any("dstv-cut-angle" in line for line in errors):
            continue  # settled by --ends
        seen += 1
        assert done.stderr.splitlines()[-1].startswith(f"{path}: note read-no-way-out: "), path
        again = call("post", path, "-o", "-", *options)
        assert [line for line in again.stderr.splitlines() if ": error " in line] == errors
    assert seen >= least, seen


def test_a_drawing_that_cannot_be_read_names_the_option_that_reads_it() -> None:
    seen = {"ways": 0, "none": 0}
    for path in sorted((SAMPLES / "bad").glob("*/*.*")):
        if path.suffix not in (".dxf", ".svg"):
            continue
        said = call("post", path, "-o", "-").stderr
        if not any(code in said for code in (": error dxf-", ": error svg-", ": error drawing-")):
            continue
        last = said.splitlines()[-1]
        if "read-no-way-out" in last:
            seen["none"] += 1
            continue
        _, found, way = last.partition("read-ways-out: with ")
        assert found, said
        seen["ways"] += 1
        again = call("post", path, "-o", "-", *way.removesuffix(" it can be read").split()).stderr
        assert not re.search(": error (dxf|svg)-", again), again
    assert seen["ways"] >= 5
    assert seen["none"] >= 5
