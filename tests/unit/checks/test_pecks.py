"""Drills that are drawn back on their way: the depth fed at a time, written and read back."""

import re
from pathlib import Path

import pytest

from beamcam.controllers import cell_events
from beamcam.controllers.events import Move
from beamcam.errors import MachineError
from beamcam.model.request import Request
from beamcam.pipeline import post, read_back
from beamcam.readers import read
from beamcam.simulation.program import simulate_program
from tests.runs import part
from tests.unit.controllers.test_cycles import LINUXCNC, machine

PECKS = """
base = "{base}"
[words]
drill = {words}
[[tools]]
kind = "drill"
diameters = [18]
numbers = [1]
max_peck = {peck}
"""
PECKED = '["M06 T{tool}", "G0 X{x} Y{y} Z{z}", "M03 S{speed}", ' + (
    '"G83 X{x} Y{y} Z{bottom_z} R{near_z} Q{peck} F{feed}", "G80", "M05"]'
)


def test_what_is_written_of_a_peck_is_read_back(tmp_path: Path) -> None:
    text = PECKS.replace("{base}", "base").replace("{words}", PECKED)
    (tmp_path / "base.toml").write_text(LINUXCNC)
    on = machine(tmp_path, text.replace("max_peck = {peck}", "max_peck = 4"))
    parts = read(part("A").encode(), "a.nc1").parts
    posted = post(parts, on)
    assert " Q4 " in posted.text
    events, _ = cell_events(posted.text, on)
    strokes = [e for e in events if isinstance(e, Move) and not e.rapid]
    assert len(strokes) >= 4
    deep, once = posted.text.replace(" Q4 ", " Q9 "), re.sub(r"G83(.*) Q4", r"G81\1", posted.text)
    for changed, fed in ((deep, "9.000"), (once, "15.908")):
        said = read_back(changed, Request(parts, on))
        assert {d.code for d in said} == {"verify-peck"}
        assert str(said[0]).endswith(
            f"error verify-peck: found a drill 18 fed {fed} mm at once; expected at most 4 mm, "
            "then drawn back"
        )
        assert "verify-peck" in {d.code for d in read_back(changed, Request((), on))}
    trace = simulate_program(posted.text, on, parts=parts).trace
    assert trace.duration_s == pytest.approx(posted.time(on).total_s, abs=0.01)


@pytest.mark.parametrize(
    ("tools", "words", "said"),
    [
        ("max_peck = 4", PECKED.replace("Q{peck}", "Q4"), "a word with {peck} in words.drill"),
        ("", PECKED, "found 0.0 for 'tools.0.max_peck'; expected a depth above 0, since"),
        ("max_peck = -1", PECKED, "found -1 for 'tools.0.max_peck'; expected 0 or more"),
        ("max_peck = 4", PECKED.replace(" Q{peck}", ""), "a word with {peck} in words.drill"),
    ],
)  # fmt: skip
def test_pecks_that_contradict_the_words(tmp_path: Path, tools: str, words: str, said: str) -> None:
    (tmp_path / "base.toml").write_text(LINUXCNC)
    text = PECKS.replace("{base}", "base").replace("{words}", words)
    with pytest.raises(MachineError) as caught:
        machine(tmp_path, text.replace("max_peck = {peck}", tools))
    assert said in str(caught.value)
