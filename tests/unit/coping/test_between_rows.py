"""Feeds between two rows of a coper's cut chart: by hand, read back, by the third opinion."""

import re
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.checks.coping import verify_coping
from beamcam.errors import BeamcamError, PlanError, errors_in
from beamcam.machine import Machine, load
from beamcam.model.part import Part, Profile
from beamcam.model.request import Request
from beamcam.planning.coping.plan import plan_coping
from beamcam.solid.opinion import solid_faults
from tests.conftest import examples
from tests.random_boxes import random_box
from tests.random_copes import random_cope, random_tee
from tests.random_tubes import random_tube
from tests.unit.coping import samples
from tests.unit.coping.test_tubes import tube


def between(name: str) -> Machine:
    machine = load(name)
    coper = machine.needed(machine.coper, "coper")
    return replace(machine, coper=replace(coper, between_rows="interpolate"))


COPER, TUBE = between("coper-linuxcnc"), between("tube-linuxcnc")


def test_a_wall_of_8_goes_half_way_between_6_and_10() -> None:
    """4200 at 6 mm and 3000 at 10; below the thinnest row its feed, at a row its own."""
    for wall, feed in ((8.0, 3600.0), (7.0, 3900.0), (10.0, 3000.0), (4.0, 4200.0)):
        part = tube(profile=Profile("RO", "CHS", 168.3, 168.3, 0.0, wall))
        (row,) = {cut.row for cut in plan_coping((part,), TUBE).operations}
        assert row.feed_mm_min == pytest.approx(feed)
        assert row.kerf == (2.2 if wall > 6.0 else 2.0)


MAKERS = st.sampled_from((
    (random_cope, COPER), (random_tube, TUBE), (random_box, TUBE), (random_cope, TUBE),
    (random_tee, TUBE),
))  # fmt: skip


@given(MAKERS, st.integers(0, 3000))
@settings(max_examples=examples(20))
def test_programs_are_read_back_and_not_by_another_rule(made: tuple, seed: int) -> None:  # type: ignore[type-arg]
    make, machine = made
    part: Part = make(seed)
    try:
        text = samples.program_of(part, machine)
    except PlanError:  # a random cope without room
        return
    assert not errors_in(verify_coping(text, (part,), machine))
    as_rows = load(machine.name)
    (said, *_) = errors_in(verify_coping(text, (part,), as_rows)) or (None,)
    plan = plan_coping((part,), machine)
    feeds = {row.feed_mm_min for row in as_rows.needed(as_rows.coper, "coper").rows}
    own = {cut.row.feed_mm_min for cut in plan.operations}
    assert (said is not None) == (not own <= feeds)


def test_a_feed_of_the_row_above_is_refused() -> None:
    part = samples.sample("coped")
    text = samples.program_of(part, COPER)
    assert not errors_in(verify_coping(text, (part,), COPER))
    feeds = {*re.findall(r"^F([0-9.]+)", text, re.MULTILINE)}
    assert len(feeds) > 2
    for k, feed in enumerate(sorted(feeds)):
        share = (0.97, 1.03)[k % 2]
        wrong = re.sub(rf"^F{feed}\b", f"F{share * float(feed):.3f}", text, flags=re.MULTILINE)
        assert errors_in(verify_coping(wrong, (part,), COPER)), (feed, share)


def test_the_third_opinion_takes_the_depth_by_the_feed() -> None:
    for part, machine in (
        (samples.sample("coped"), COPER), (samples.sample("stub"), TUBE),
    ):  # fmt: skip
        text = samples.program_of(part, machine)
        assert not errors_in(solid_faults(text, Request((part,), machine)))


def test_feeds_that_rise_with_thickness_are_refused(tmp_path: Path) -> None:
    """Of such rows no feed would say how thick its steel is."""
    rows = "".join(
        f'[[coper.rows]]\nprocess = "cut"\nup_to = {deep}\nfeed_mm_min = {feed}\nkerf = 2\n'
        "pierce_s = 1\npierce_height = 6\ncut_height = 3\n"
        for deep, feed in ((6, 3000), (10, 4000))
    )
    text = f'base = "coper-linuxcnc"\n[coper]\nbetween_rows = "{{}}"\n{rows}'
    path = tmp_path / "m.toml"
    path.write_text(text.format("row above"))
    load(str(path))
    path.write_text(text.format("interpolate"))
    with pytest.raises(BeamcamError, match="between_rows is interpolate"):
        load(str(path))
