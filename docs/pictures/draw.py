"""Draws the pictures of this folder from the samples: `python docs/pictures/draw.py [FOLDER]`.

A test runs it and compares; `pytest tests/test_pictures_of_docs.py --update-golden` writes anew.
"""

import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from click.testing import CliRunner

from beamcam.cli import main
from beamcam.model.description import face_title, runs_down
from beamcam.model.part import FACES as ALL_FACES
from beamcam.model.part import Face, Profile
from beamcam.pictures.features import section_outlines
from beamcam.pictures.formats import to_svg
from beamcam.pictures.scene import Circle, PaperFrame, Point, Polyline, Scene, Shape, Text, arrow
from beamcam.pictures.views import FACES_DOWN

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


# --- the faces: how x and y run on each of them ---------------------------------------------------

# Where a view stands and which way its y runs comes from `model.description`; a test holds it
# against the solid of a part with the holes drawn here.

#: A section with flanges wider than the web is thick, and one hole on each face, off every middle.
EXAMPLE = Profile("U", "U 200 x 120", 200.0, 120.0, 14.0, 10.0)
LENGTH = 420.0
HOLES = {"h": (90.0, 60.0), "o": (150.0, 85.0), "v": (210.0, 130.0), "u": (270.0, 30.0)}
DIAMETER = 22.0
_SCALE = 0.62
_LEFT, _TOP, _GAP = 360.0, 44.0, 56.0
_SECTION = PaperFrame(0.8, 110.0, 330.0)  #: Z to the right and Y up: seen along x


def faces_scene() -> Scene:
    """How x and y run on each face: the section with its letters, and the faces unfolded."""
    drawn: list[Shape] = [*_section()]
    y = _TOP
    for face in FACES_DOWN:
        width = EXAMPLE.face_width(face) * _SCALE
        drawn += _view(face, unfolded(face, y + width))
        y += width + _GAP
    about = "from where each face is seen, how x and y run on it, and which edge is y = 0"
    return Scene("the faces v, o, u and h of a section", about, 900.0, y, tuple(drawn))


def unfolded(face: Face, below: float) -> PaperFrame:
    """The frame of a face whose view ends at a height of the paper."""
    width = EXAMPLE.face_width(face) * _SCALE
    down = runs_down(face)
    return PaperFrame(_SCALE, _LEFT, below - width if down else below, down)


def _view(face: Face, frame: PaperFrame) -> Iterator[Shape]:
    """A face with its hole, the edge y = 0 in bold, and its axes."""
    width = EXAMPLE.face_width(face)
    corners = ((0.0, 0.0), (LENGTH, 0.0), (LENGTH, width), (0.0, width))
    yield Polyline(f"face face-{face}", frame.all(corners), True, f"face {face}")
    yield Polyline("cut datum", frame.all(corners[:2]), False, f"y = 0 of {face}")
    (x0, y0), along, up = frame.at(0.0, 0.0), frame.at(60.0, 0.0), frame.at(0.0, 60.0)
    yield arrow((x0, y0), along, "off axis")
    yield arrow((x0, y0), up, "off axis")
    yield Text("gone-text", (along[0], y0 + (15.0 if frame.down else -7.0)), "x", 12.0)
    yield Text("gone-text", (x0 - 12.0, up[1] + 4.0), "y", 12.0)
    x, y = HOLES[face]
    tip = f"hole {face} at x {x:g}, y {y:g}"
    yield Circle(f"hole hole-{face}", frame.at(x, y), DIAMETER / 2 * _SCALE, tip)
    yield Text("figure", frame.at(x + 18.0, y), f"{face}  x {x:g}, y {y:g}", 10.0)
    y1 = frame.at(0.0, width)[1]
    yield Text("heading", (x0, min(y0, y1) - 16.0), face_title(face, EXAMPLE.code), 12.0)
    right = x0 + LENGTH * _SCALE + 12.0
    if face == "h":
        note = "who stands behind sees x run to the left"
        yield Text("figure", (right, (y0 + y1) / 2), note, 10.0)
        return
    far, near = ("away from v", "meets v") if face in "ou" else ("meets u", "meets o")
    for at, said in ((y0, f"y = 0, {far}"), (y1, f"y = {width:g}, {near}")):
        yield Text("figure", (right, at + 4.0), said, 10.0)


def _section() -> Iterator[Shape]:
    """The section with the direction in which each face is looked at, and where its y = 0 is."""
    frame, h, w = _SECTION, EXAMPLE.height, EXAMPLE.width
    (outline,) = section_outlines(EXAMPLE)
    yield Text("heading", (24.0, 26.0), "section from the start, x away from you", 12.0)
    yield Polyline("section", frame.all(outline), True)
    sides: dict[Face, tuple[Point, Point]] = {
        "v": ((w + 70.0, h / 2), (w * 0.25, h / 2)), "h": ((-70.0, h / 2), (-8.0, h / 2)),
        "o": ((w / 2, h + 70.0), (w / 2, h + 8.0)), "u": ((w / 2, -70.0), (w / 2, -8.0)),
    }  # fmt: skip
    for face in ALL_FACES:
        a, b = (frame.at(*p) for p in sides[face])
        yield arrow(a, b, "new look")
        out = (a[0] + (a[0] - b[0]) * 0.2, a[1] + (a[1] - b[1]) * 0.2 + 6.0)
        yield Text("heading", out, face, 18.0, "middle")
    for height, said, off in ((h, "y = 0 of o", -8.0), (0.0, "y = 0 of u, v and h", 16.0)):
        x, y = frame.at(0.0, height)
        yield Circle("off", (x, y), 3.0)
        yield Text("figure", (x - 8.0, y + off), said, 10.0, "end")


if __name__ == "__main__":
    draw(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
