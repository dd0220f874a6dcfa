"""What one table of a machine file names in another has to be there; the key is told."""

from pathlib import Path

import pytest

from beamcam.errors import MachineError
from beamcam.machine import load

AXIS = '[[axes]]\nname = "{}"\nmoves = "{}"\nspeed = 1\nacceleration = 1\n'
BODY = '[[bodies]]\nname = "b"\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n'
SPINDLES = "spindles = []\npairs = []\ntools = []\ndrill = false\n"
#: Base of the machine, what is laid over it, and what is said.
WRONG = [
    ("beamline", AXIS.format("a", "Y") + "spindle = 7\n",
     "found 7 for 'axes.0.spindle'; expected the number of a spindle: 1, 2, 3"),
    ("beamline", SPINDLES + AXIS.format("a", "Y") + "spindle = 1\n",
     "found 1 for 'axes.0.spindle'; expected the number of a spindle: none, there are no spindles"),
    ("laser-grbl", AXIS.format("a", "Y") + "spindle = 1\n", "for 'axes.0.spindle'; expected the"),
    ("beamline", AXIS.format("a", "Y"), "found None for 'axes.0.spindle'; expected the number of"),
    ("beamline", AXIS.format("a", "X") + "spindle = 1\n",
     "found 'X' for 'axes.0.moves'; expected Y or Z, which move a spindle"),
    ("beamline", "saw = false\n" + AXIS.format("a", "angle"),
     "found 'angle' for 'axes.0.moves'; expected another motion, or a [saw] table for it"),
    ("beamline", AXIS.format("a", "X") + AXIS.format("a", "saw"),
     "found 'a' for 'axes.1.name'; expected a name once"),
    ("hall", '[[tools]]\nkind = "drill"\ndiameters = [18]\nnumbers = [1]\nfaces = ["o", "u"]\n',
     "found ['o', 'u'] for 'tools.0.faces'; expected a face that has a spindle: v"),
    ("beamline", BODY + 'x = "none"\n', "found 'none' for 'bodies.0.x'; expected an axis: left"),
    ("beamline", BODY + 'z = "-saw rotation"\n',
     "found '-saw rotation' for 'bodies.0.z'; expected an axis in millimetres"),
    ("beamline", BODY + 'turn = "stop"\n',
     "found 'stop' for 'bodies.0.turn'; expected an axis in degrees"),
    ("laser-grbl", "[torch.settings.GREEN]\nspeed = 100\n",
     "found 'GREEN' for 'torch.settings.GREEN'; expected a key of torch.colours: "),
    ("table-simotion", '[triggers.outputs]\nweld = "%Q62.1"\n',
     "found '%Q62.1' for 'triggers.outputs.weld'; expected one of cut, mark, engrave"),
]  # fmt: skip
HALL = 'base = "beamline"\npairs = []\n[[spindles]]\nname = "s"\nnumber = 1\nface = "v"\n' + (
    'across = { axis = "Y", position = "y" }\n'
    'stroke = { axis = "Z", retract = "-clearance", bottom = "face_depth + depth + tip" }\n'
)


@pytest.mark.parametrize(("base", "text", "said"), WRONG, ids=[said[:40] for *_, said in WRONG])
def test_what_is_not_there_is_refused(tmp_path: Path, base: str, text: str, said: str) -> None:
    (tmp_path / "hall.toml").write_text(HALL)
    (tmp_path / "own.toml").write_text(f'base = "{base}"\n{text}')
    with pytest.raises(MachineError) as caught:
        load(str(tmp_path / "own.toml"))
    message = str(caught.value)
    assert said in message
    assert "own.toml:" in message
    assert " error machine-value: " in message


@pytest.mark.parametrize("taken", [SPINDLES, "saw = false\n", HALL.split("\n", 1)[1]])
def test_axes_of_a_base_stay_in_their_registers(tmp_path: Path, taken: str) -> None:
    """Whose station is taken away over them; register k is axis k all the same."""
    (tmp_path / "own.toml").write_text(f'base = "beamline"\n{taken}')
    assert load(str(tmp_path / "own.toml")).axes == load("beamline").axes
