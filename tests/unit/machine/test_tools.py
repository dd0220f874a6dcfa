"""Tools and stations of machine files: what several keys have to agree on, speeds and feeds."""

from math import isclose, pi
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from beamcam.errors import MachineError
from beamcam.machine import load
from beamcam.machine.stations import Tool, ToolSet, inch_size, speed_and_feed
from tests.conftest import examples

#: Lines laid over a shipped machine, and what the message has to say.
FAULTS = [
    ("beamline", "[drill]\nx = -1", "'drill.x'; expected at least saw.x"),
    ("beamline-pusher", "[drill]\nx = 2000", "'drill.x'; expected at most saw.x"),
    ("beamline", "[saw]\nmin_angle = 70", "'saw.min_angle'; expected at most"),
    ("beamline", "[saw]\nmin_tilt = 1", "'saw.min_tilt'; expected at most"),
    ("beamline", "[saw]\nmax_tilt = 10", "'words.saw'; expected a word with {tilt}"),
    ("beamline", "[[tools]]\nkind = 'drill'", "'tools.0.diameters'; expected at least one"),
    ("beamline", "[[tools]]\nkind = 'drill'\ninches = ['1/0']", "expected inches such as"),
    ("beamline", "[[tools]]\nkind = 'drill'\ninches = ['half']", "found 'half' for"),
    ("beamline", "[[tools]]\nkind = 'drill'\ninches = ['-1/2']", "expected inches such as"),
    ("beamline", "[[tools]]\nkind = 'drill'\ndiameters = [8]\npoint_deg = 190", "at most 180"),
    ("beamline", "[[tools]]\nkind = 'mill'\ndiameters = [8]", "'words.mill'; expected a template"),
    (
        "beamline-pusher",
        "[[tools]]\nkind = 'tap'\ndiameters = [8]\npitches = [1.25]",
        "'tools.0.pre_drills'; expected 1, one for each diameter",
    ),
    (
        "beamline-pusher",
        "[[tools]]\nkind = 'tap'\ndiameters = [8]\npitches = [0]\npre_drills = [6.8]",
        "'tools.0.pitches.0'; expected more than 0",
    ),
    (
        "beamline-pusher",
        "[[tools]]\nkind = 'tap'\ndiameters = [8]\npitches = [1.25]\npre_drills = [8]",
        "'tools.0.pre_drills'; expected less than the thread's 8",
    ),
    (
        "beamline-pusher",
        "[layout]\norder = 'saw-drill'\n[drill]\nx = 3000",
        "expected a tool for strokes, since X only grows",
    ),
    (
        "beamline-pusher",
        "[[drill.cutting]]\nup_to = 20\nspeed_m_min = 1\nfeed_per_turn = 1",
        "'drill.cutting'; expected a row with kind = 'tap'",
    ),
    (
        "beamline",
        "[[axes]]\nname = 'stop'\nmoves = 'X'\nspeed = 0\nacceleration = 5",
        "'axes.0.speed'; expected more than 0",
    ),
    (
        "beamline",
        "[[axes]]\nname = 'stop'\nmoves = 'X'\nspeed = 1\nacceleration = 5\njerk = 0",
        "'axes.0.jerk'; expected more than 0",
    ),
    (
        "plate-codesys",
        "[[axes]]\nname = 'b'\nmoves = 'X'\nspeed = 1\nacceleration = 5",
        "'axes'; expected an axis for X and one for Y",
    ),
    (
        "plate-codesys",
        "[torch]\nacceleration = 2000",
        "'torch.acceleration'; expected less than the 2000 of bridge, for the curves",
    ),
    ("plate-codesys", "[torch]\nacceleration = -1", "'torch.acceleration'; expected 0 or more"),
    ("plate-codesys", "[torch]\ncorner = -1", "'torch.corner'; expected 0 or more"),
    (
        "plate-codesys",
        "[torch]\nacceleration = 0",
        "'words.modal'; expected torch.acceleration and axes X and Y for {acceleration}",
    ),
]


@pytest.mark.parametrize(("base", "text", "says"), FAULTS, ids=[f[1][:40] for f in FAULTS])
def test_refused(tmp_path: Path, base: str, text: str, says: str) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(f'base = "{base}"\n{text}\n')
    with pytest.raises(MachineError) as caught:
        load(str(path))
    said = caught.value.diagnostics[0]
    assert said.code == "machine-value"
    assert says in said.message


@pytest.mark.parametrize(
    ("text", "size"), [("13/16", 20.6375), ("1 1/16", 26.9875), ("1/2", 12.7), ("2", 50.8)]
)
def test_inches(text: str, size: float) -> None:
    assert isclose(inch_size(text), size)
    assert ToolSet("drill", (9.0,), (text,)).sizes == (9.0, inch_size(text))


def test_a_flat_tool_has_no_tip() -> None:
    assert Tool("mill", 16, 180).tip == 0
    assert isclose(Tool("countersink", 20, 90).tip, 10)


@settings(max_examples=examples(200), deadline=None)
@given(
    kind=st.sampled_from(["drill", "tap", "countersink", "mill"]),
    diameter=st.floats(2, 60),
    grade=st.sampled_from(["", "S355JR", "s235"]),
    max_feed=st.floats(50, 20000),
)
def test_speed_and_feed_stay_within_the_machine(
    kind: str, diameter: float, grade: str, max_feed: float
) -> None:
    drill = load("beamline-pusher").drill
    assert drill is not None
    drill = replace(drill, max_feed_mm_min=max_feed)
    tool = Tool(kind, diameter, pitch=1.5)  # type: ignore[arg-type]
    speed, feed = speed_and_feed(tool, drill, grade)
    assert feed <= drill.max_feed_mm_min + 1e-9
    assert speed <= drill.max_speed_rpm
    if kind == "tap":
        assert isclose(feed, speed * 1.5)
    else:
        assert speed >= drill.min_speed_rpm


def test_speed_and_feed_of_a_row() -> None:
    drill = load("beamline-pusher").drill
    assert drill is not None
    speed, feed = speed_and_feed(Tool("drill", 22), drill, "S355")
    assert isclose(speed, 25000 / (pi * 22))
    assert isclose(feed, 0.25 * speed)
    assert speed_and_feed(Tool("scribe", 1), drill, "S355") == (0, 4000)
    rows = (replace(drill.cutting[0], grade="s355*", up_to=50, speed_m_min=12), *drill.cutting)
    slow, _ = speed_and_feed(Tool("drill", 22), replace(drill, cutting=rows), "S355J2")
    assert isclose(slow, 12000 / (pi * 22))
