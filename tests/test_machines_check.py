"""`beamcam machines check`: a mirrored face is seen before the first part."""

import re
from pathlib import Path

import pytest
from click.testing import Result

from beamcam.machine import load, shipped
from beamcam.pictures.line import line_scene
from beamcam.pictures.scene import Circle, Polyline, Text
from beamcam.planning.held_up import held_up
from beamcam.solid.bar_solid import reaches
from beamcam.solid.kernel import walls
from tests.conftest import ROOT
from tests.runs import call

SPINDLES = """
[[spindles]]
name = "top"
number = 1
face = "o"
across = {{ axis = "Z", position = "{o}" }}
stroke = {{ axis = "Y", retract = "-clearance", bottom = "depth + tip" }}

[[spindles]]
name = "front"
number = 2
face = "v"
across = {{ axis = "Y", position = "height / 2 - y" }}
stroke = {{ axis = "Z", retract = "-clearance", bottom = "face_depth + depth + tip" }}

[[spindles]]
name = "{third}"
number = 3
face = "{face}"
across = {{ axis = "{axis}", position = "{position}" }}
stroke = {{ axis = "{stroke}", retract = "{start}", bottom = "{into}" }}
"""
RIGHT, MIRRORED = "188.6 - y", "188.6 - (width - y)"  # y from the far edge, and from v's edge
BOTTOM = {"third": "bottom", "face": "u", "axis": "Z", "position": RIGHT, "stroke": "Y",
          "into": "depth + tip", "start": "-clearance"}  # fmt: skip
BACK = {"third": "back", "face": "h", "axis": "Y", "position": "height / 2 - y", "stroke": "Z",
        "into": "width - face_depth - depth - tip", "start": "width + clearance"}  # fmt: skip


def check(*words: str) -> Result:
    return call("machines", *words)


def machine(folder: Path, o: str, third: dict[str, str]) -> str:
    text = 'base = "beamline"\npairs = []\nbodies = []\n' + SPINDLES.format(o=o, **third)
    path = folder / "mine.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


@pytest.mark.parametrize("name", shipped())
def test_shipped_machines_hold_up(name: str) -> None:
    done = check("check", name)
    assert (done.exit_code, done.stderr) == (0, "")
    assert len(done.stdout.splitlines()) == max(1, len(load(name).spindles))


@pytest.mark.parametrize("name", ["beamline", "beamline-pusher"])
def test_the_sentences_are_those_of_the_solid(name: str) -> None:
    """The tool's point lies on the wall of the solid, 30 mm from the edge that is named."""
    told = check("check", name).stdout.splitlines()
    line = load(name)
    for one, sentence in zip(held_up(line), told, strict=True):
        (reach,) = reaches(line, one.profile)[one.spindle.number]
        figures = dict(re.findall(r"\b([XYZ]) (-?[\d.]+)", sentence.partition("is drilled at")[2]))
        place = tuple(float(figures.get(axis, 0.0)) for axis in "XYZ")
        tip = reach.tip(float(figures["X"]) - line.drill.x, place)  # type: ignore[union-attr, arg-type]
        width = one.profile.height if one.spindle.face == "v" else one.profile.width
        assert tip.depth == pytest.approx(0.0, abs=1e-3)
        assert (tip.x, tip.y) == (100.0, 30.0 if one.spindle.face == "v" else width - 30.0)
        through = float(re.findall(r"through at (-?[\d.]+)", sentence)[0])
        assert through - one.enters == pytest.approx(reach.wall.thickness)


def test_a_hole_at_the_webs_front_is_where_a_hand_would_measure_it() -> None:
    """The line's Z 0 is the top of the bar as it lies, 30 mm above it is the edge: by the cell's
    papers Z = 188.6 - y, and y counts from the edge below, 150 - 30 for an IPE300."""
    first = check("check", "beamline").stdout.splitlines()[0]
    assert first.startswith("left flange, spindle 1: a hole in the top flange (o) of IPE300, 30 mm")
    assert "30 mm from the edge at the web's front (y 120 of 150)" in first
    assert "X 878.56, Z 68.6; the point enters at Y 0 and is through at 10.7" in first


@pytest.mark.parametrize(("o", "third", "blamed"), [
    (RIGHT, BOTTOM, []),
    (RIGHT, BACK, []),
    # What the page on machine files once said of o: y from the edge beside v.
    (MIRRORED, BOTTOM, ["top", "bottom"]),
    (MIRRORED, BACK, ["top"]),
    # Both flanges: the stroke of the front spindle tells.
    (MIRRORED, BOTTOM | {"position": MIRRORED}, ["top", "bottom"]),
    # And h upside down, as one sees it who walks round the part and turns it.
    (RIGHT, BACK | {"position": "y - height / 2"}, ["back"]),
    (MIRRORED, BACK | {"position": "y - height / 2"}, ["top", "back"]),
])  # fmt: skip
def test_a_mirrored_face_is_caught(
    o: str, third: dict[str, str], blamed: list[str], tmp_path: Path
) -> None:
    done = check("check", machine(tmp_path, o, third))
    said = re.findall(r"error machine-hand: found that [YZ] grows .*? at the spindle (\w+) and",
                      done.stderr)  # fmt: skip
    assert done.exit_code == bool(blamed), done.stderr
    assert set(said) <= set(blamed)
    assert bool(said) == bool(blamed)


def test_a_new_machine_is_held_up_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    done = check("new", "mine")
    assert done.exit_code == 0, done.stderr
    assert "beamcam machines check mine" in done.stdout
    assert done.stdout.count("is drilled at X") == 3
    assert check("check", str(ROOT / "samples" / "machines" / "hall-drill.toml")).exit_code == 0


def test_a_line_is_drawn_with_its_stations_and_each_hole_where_the_solid_has_it() -> None:
    line = load("beamline-pusher")
    scene = line_scene(line)
    assert line.saw is not None
    assert line.drill is not None
    stations = {s.tip: s.points[0][0] for s in scene.shapes if isinstance(s, Polyline) and s.tip}
    axis = {
        s.text: s.at[0] for s in scene.shapes if isinstance(s, Text) and s.text.startswith("X ")
    }
    # The pusher's line drills before it saws: upstream, at the smaller X.
    assert (line.drill.x, line.saw.x) == (0, 1250)
    assert stations["drills"] == axis["X 0"] < axis["X 1250"] == stations["saw"]
    (section,) = [s for s in scene.shapes if isinstance(s, Polyline) and s.classes == "section"]
    left, low = min(p[0] for p in section.points), max(p[1] for p in section.points)
    scale = (max(p[0] for p in section.points) - left) / 150.0  # IPE300
    for one in held_up(line):
        face = one.spindle.face
        (circle,) = [s for s in scene.shapes if s.classes.endswith(f"held-{face}")]
        assert isinstance(circle, Circle)
        z, y = (circle.at[0] - left) / scale, (low - circle.at[1]) / scale
        wall = walls(one.profile)[face]
        row = [a * 100.0 + b * one.y + d for a, b, _, d in wall.frame]  # on the surface, depth 0
        assert (y, z) == pytest.approx((row[1], row[2]), abs=0.1)


@pytest.mark.parametrize("name", ["beamline", "beamline-annex", "hall-drill"])
def test_plot_draws_each_line(name: str, tmp_path: Path) -> None:
    place = str(ROOT / "samples" / "machines" / "hall-drill.toml") if name == "hall-drill" else name
    done = check("plot", place, "-o", str(tmp_path / "line.svg"))
    assert done.exit_code == 0, done.stderr
    text = (tmp_path / "line.svg").read_text(encoding="utf-8")
    assert text.count("held-") == len(held_up(load(place)))
    table = check("plot", "plate-linuxcnc", "-o", str(tmp_path / "x.svg"))
    assert (table.exit_code, "expected a saw or drilling line" in table.stderr) == (2, True)
