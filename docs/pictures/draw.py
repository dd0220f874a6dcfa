"""Draws the pictures of this folder from the samples: `python docs/pictures/draw.py [FOLDER]`.

A test runs it and compares; `pytest tests/test_pictures_of_docs.py --update-golden` writes anew.
"""

import sys
import tempfile
from pathlib import Path

from click.testing import CliRunner

from beamcam.cli import main
from beamcam.pictures.faces import faces_scene
from beamcam.pictures.formats import to_svg

ROOT = Path(__file__).resolve().parents[2]
CHANNEL, TIE = "samples/dstv/channel.nc1", "samples/dstv/tie.nc1"
#: Name of each picture, and the call that draws it, run in the root of the project.
PICTURES = {
    "part.svg": f"plot {CHANNEL}",
    "plate.svg": "plot samples/dstv/gusset.nc1",
    "drawing.svg": "plot samples/svg/corel-x6.svg --machine laser-grbl",
    "bar.svg": f"plot {CHANNEL} {TIE} {CHANNEL} --machine beamline-annex",
    "plate-program.svg": "plot samples/dstv/gusset.nc1 --show program --machine plate-codesys",
    "laser-program.svg": "plot samples/json/curves.json --show program --machine laser-grbl",
    "trigger-program.svg": "plot samples/json/shield.json --show program --machine table-simotion",
    "step-program.svg": "plot samples/json/shield-small.json --show program --machine "
    "laser-stepper",
    "profile.svg": "profile --distance 500 --time 4 --jerk 60",
    "difference.svg": f"diff {CHANNEL} {{other}}",
    "line.svg": "machines plot beamline",
    "encoder.svg": "simulate {program} --encoder 512/65",
}

FACES = "faces.svg"  #: has no call: it is drawn from the rules of the faces alone


def draw(folder: Path) -> None:
    """All pictures, into a folder."""
    with tempfile.TemporaryDirectory() as scratch:
        other = Path(scratch) / "revised.nc1"
        other.write_text(revised((ROOT / CHANNEL).read_text(encoding="utf-8")), encoding="utf-8")
        program = Path(scratch) / "shield.st"
        words = ["post", str(ROOT / "samples/json/shield.json"), "--machine", "table-simotion"]
        CliRunner().invoke(main, [*words, "-o", str(program)])
        for name, call in PICTURES.items():
            words = [str(ROOT / w) if w.startswith("samples/") else w
                     for w in call.format(other=other, program=program).split()]  # fmt: skip
            done = CliRunner().invoke(main, [*words, "-o", str(folder / name)])
            if not (folder / name).exists():
                raise SystemExit(f"{call}\n{done.output}")
    (folder / FACES).write_text(to_svg(faces_scene()), encoding="utf-8")


def revised(text: str) -> str:
    """The channel with two holes moved, one gone and one new."""
    text = text.replace("1200.00u    100.00     14.00", "1250.00u    100.00     14.00")
    text = text.replace("2900.00u    140.00     22.00", "2500.00u    140.00     22.00")
    return text.replace("400.00u     45.00", "420.00u     45.00", 1)


if __name__ == "__main__":
    draw(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
