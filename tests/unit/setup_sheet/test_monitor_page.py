"""What the page of a controller draws besides its axes: what is known of the work, and no more."""

from pathlib import Path

import pytest

from beamcam.machine import load
from beamcam.pictures import ReadProgram
from beamcam.pipeline import post, read_file
from beamcam.setup_sheet.study_page import KnownWork, monitor_data, monitor_page
from tests.runs import call

DSTV = Path(__file__).resolve().parents[3] / "samples" / "dstv"
CHANNEL, GUSSET = str(DSTV / "channel.nc1"), str(DSTV / "gusset.nc1")


def program_of(path: str, name: str, known: bool) -> ReadProgram:
    machine, parts = load(name), read_file(path).parts
    data = b"".join(post(parts, machine).pieces())
    return ReadProgram(data, machine, "job" + machine.suffix, parts=parts if known else ())


def test_without_anything_the_section_is_an_assumed_one_and_the_page_says_so() -> None:
    machine = load("beamline")
    data = monitor_data(machine, 0.1, KnownWork())
    assert data["section"]["assumed"]
    assert (data["section"]["height"], data["section"]["width"]) == (300.0, 100.0)
    assert "a dashed one of 300 x 100 mm stands for it" in monitor_page(
        machine, 0.1, "h", KnownWork()
    )


def test_a_part_says_the_section() -> None:
    machine = load("beamline")
    work = KnownWork(read_file(CHANNEL).parts[0].profile)
    section = monitor_data(machine, 0.1, work)["section"]
    assert (section["height"], section["width"], section["assumed"]) == (200.0, 75.0, False)
    assert "stands for it" not in monitor_page(machine, 0.1, "h", work)


def test_a_program_draws_its_parts_its_cuts_and_its_holes() -> None:
    work = KnownWork(program=program_of(CHANNEL, "beamline", known=False))
    data = monitor_data(load("beamline"), 0.1, work)
    assert len(data["bores"]) == 14
    assert len(data["cuts"]) == 2
    assert not data["section"]["assumed"]
    assert work.program is not None
    assert work.program.sha256 in monitor_page(load("beamline"), 0.1, "h", work)


def test_a_program_that_says_no_width_takes_the_part_s() -> None:
    """The annex dialect says the height twice."""
    machine = load("beamline-annex")
    for known, width in ((False, 100.0), (True, 75.0)):
        work = KnownWork(program=program_of(CHANNEL, machine.name, known))
        section = monitor_data(machine, 0.1, work)["section"]
        assert (section["height"], section["width"]) == (200.0, width)
        assert section["assumed"] is not known


def test_a_table_has_the_way_of_its_program() -> None:
    machine = load("plate-linuxcnc")
    assert monitor_data(machine, 0.1, KnownWork())["path"] == []
    work = KnownWork(program=program_of(GUSSET, machine.name, known=True))
    path = monitor_data(machine, 0.1, work)["path"]
    assert len(path) == 6
    assert max(x for way in path for x, _ in way) == pytest.approx(270.75, abs=0.01)


def test_a_part_of_another_kind_is_wrong_usage() -> None:
    done = call("monitor", "127.0.0.1:1", "--part", GUSSET, status=2)
    assert "expected a part for beamline" in " ".join(done.output.split())
