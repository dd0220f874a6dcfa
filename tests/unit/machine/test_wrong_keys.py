"""Wrong keys and values in a machine of one's own: each is told with its file and line."""

import re
from pathlib import Path

import pytest

from beamcam.errors import MachineError
from beamcam.self_test import load_machine
from tests.conftest import SAMPLES

#: A drill, a saw alone, and a saw and drill; each is a file over the machine before it.
MACHINES = {
    "drill": (SAMPLES / "machines" / "hall-drill.toml").read_text(encoding="utf-8"),
    "saw": 'base = "beamline"\ndrill = false\nspindles = []\npairs = []\ntools = []\n',
    "line": 'base = "beamline"\n',
}
SPINDLE = """
pairs = []
[[spindles]]
name = "a"
number = 1
face = "v"
across = {{ axis = "{axis}", position = "{position}" }}
stroke = {{ axis = "Z", retract = "-clearance", bottom = "face_depth + depth + tip" }}
"""
AXIS = '[[axes]]\nname = "x"\nmoves = "{}"\nspeed = {}\nacceleration = 1\n'
#: What is laid over the machine, and what is said of it.
WRONG = [
    ("sawx = 3", "machine-key: found unknown key 'sawx'; expected 'saw'"),
    ("[[", "machine-toml: found no TOML (Invalid initial character for a key part); expected"),
    ('base = "none-such"', "machine-unknown: found no machine 'none-such'; expected"),
    ("base = 5", "machine-value: found 5 for 'base'; expected a machine's name"),
    ('stock = "sheet"', "error machine-"),
    ('controller = "fanuc"', "machine-value: found 'fanuc' for 'controller'; expected one of"),
    ("layout = false", "machine-missing: found no key 'layout'"),
    ("format = false", "machine-missing: found no key 'format'"),
    ('suffix = "../x"', "machine-value: found '../x' for 'suffix'; expected a dot and letters"),
    ('suffix = ""', "machine-value: found '' for 'suffix'"),
    ('allowed_codes = "G1"', "machine-value: found 'G1' for 'allowed_codes'; expected a list"),
    ('[codes]\nG1 = "none"', "machine-value: found 'G1' for 'codes.G1'; expected another word"),
    ("[sections]\nUU = 2", "machine-value: found 'UU' for 'sections.UU'; expected a DSTV code"),
    ('[layout]\nprofiles = ["Q"]', "machine-value: found 'Q' for 'layout.profiles'; expected"),
    ("[layout]\nmin_bar = 19000", "machine-value: found 19000.0 for 'layout.min_bar'; expected at"),
    ('[layout]\norder = "saw"', "machine-value: found 'saw' for 'layout.order'; expected one of"),
    ("[format]\nlength_decimals = 9", "machine-value: found 9 for 'format.length_decimals'"),
    ("[times]\nsaw_s = nan", "machine-value: found nan for 'times.saw_s'"),
    ('[marks]\ntext = "maybe"', "machine-value: found 'maybe' for 'marks.text'; expected one of"),
    ('[words]\nsaw = "G0"', "machine-value: found 'G0' for 'words.saw'; expected a list"),
    ('[words]\nheader = ["{x}"]', "machine-value: found '{x}' for 'words.header'; expected"),
    (AXIS.format("Q", 1), "machine-value: found 'Q' for 'axes.0.moves'; expected one of"),
    (AXIS.format("X", -1), "machine-value: found -1 for 'axes.0.speed'; expected more than 0"),
    (AXIS.format("X", 1) * 2, "machine-value: found 'X' for 'axes.1.moves'; expected one axis"),
    ('[[tools]]\nkind = "reamer"\ndiameters = [3]', "machine-value: found 'reamer' for"),
    (SPINDLE.format(axis="X", position="y"), "machine-value: found 'X' for"),
    (SPINDLE.format(axis="Y", position="y").replace('"Z"', '"X"'), "machine-value: found 'X' for"),
    (SPINDLE.format(axis="Y", position="y +"), "machine-value: found 'y +' for"),
    (SPINDLE.format(axis="Y", position="yy"), "machine-value: found 'yy' for"),
    (SPINDLE.format(axis="Y", position="y / (y - y)"), "machine-value: found 'y / (y - y)' for"),
    ('[[pairs]]\nname = "p"\nnumber = 9\nfaces = ["v", "v"]', "machine-value: found"),
    (
        SPINDLE.format(axis="Y", position="y") + SPINDLE.format(axis="Y", position="y")[12:],
        "machine-value: found 'v' for 'spindles.1.face'; expected another face than that of 'a'",
    ),
    (
        SPINDLE.format(axis="Y", position="y")
        + SPINDLE.format(axis="Y", position="y")[12:].replace('"v"', '"u"'),
        "machine-value: found 1 for 'spindles.1.number'; expected another number than that of 'a'",
    ),
]


@pytest.mark.parametrize("name", MACHINES)
@pytest.mark.parametrize(("text", "said"), WRONG, ids=[text.split("\n")[0] for text, _ in WRONG])
def test_what_is_wrong_is_told_with_its_line(
    tmp_path: Path, name: str, text: str, said: str
) -> None:
    (tmp_path / "below.toml").write_text(MACHINES[name])
    own = text if text.startswith("base") else f'base = "below"\n{text}'
    (tmp_path / "own.toml").write_text(own + "\n")
    with pytest.raises(MachineError) as caught:
        load_machine(str(tmp_path / "own.toml"))
    message = str(caught.value)
    assert re.search(r"(own|beamline)\.toml:[1-9]\d*: error machine-", message), message
    assert said in message
