"""Inputs that took a command too long, too much memory, or into a traceback."""

import json
import time
from pathlib import Path

import pytest
from click.testing import CliRunner

from beamcam.cli import main
from beamcam.geometry.bezier import MAX_DEGREE
from tests.conftest import SAMPLES

HOSTILE = Path(__file__).parent / "hostile"
MOST_S = 5.0
FILES = sorted(path for path in HOSTILE.iterdir() if path.suffix != ".toml")
PART = {
    "schema": "beamcam/part/1", "mark": "A", "length": 200,
    "profile": {"code": "B", "height": 100, "web_thickness": 6},
}  # fmt: skip


def call(*words: object) -> str:
    """What a command prints, which has to end by itself, in time and in plain text."""
    begun = time.process_time()
    result = CliRunner().invoke(main, [str(word) for word in words])
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    assert result.exit_code in (0, 1), result.output
    assert time.process_time() - begun < MOST_S
    text = result.stdout + result.stderr
    assert all(line.isprintable() for line in text.split("\n"))
    return text


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_commands_end(path: Path, tmp_path: Path) -> None:
    call("inspect", path)
    for suffix in (".nc1", ".json", ".dxf"):
        call("convert", path, "-o", tmp_path / f"out{suffix}")
    drawn = path.suffix in (".svg", ".dxf")
    colours = ("--map", "red=cut", "--map", "black=cut", "--map", "white=cut") if drawn else ()
    machine = "beamline" if path.suffix in (".nc1", ".ifc") else "plate-linuxcnc"
    batch = ("--machine", machine, *colours, "-o", tmp_path / "out", "-v")
    call("batch", path, *batch)


def test_machine_files(tmp_path: Path) -> None:
    deep = tmp_path / "deep.toml"
    deep.write_text(f"x = {'[' * 100_000}{']' * 100_000}\n")
    long = tmp_path / "long.toml"
    long.write_text(f"x = {'9' * 5000}\n")
    huge = tmp_path / "huge.toml"
    huge.write_text("# " + "x" * 600_000)
    far = tmp_path / "far.toml"
    far.write_text('base = "beamline"\n[layout]\norder = "saw-drill"\ngreatest_bar = 1e300\n')
    sample = SAMPLES / "dstv" / "channel.nc1"
    for path, said in (
        (deep, "no TOML"),
        (long, "no TOML"),
        (huge, "600002 bytes; expected at most 500000"),
        (far, "expected a number between -1e+10 and 1e+10"),
        (HOSTILE / "m3.toml", "with a width of two digits"),
    ):
        text = call("post", sample, "--machine", path, "-o", tmp_path / "o.gcode")
        assert said in text, text
    assert "no TOML" in call("post", sample, "--config", deep, "-o", tmp_path / "o.gcode")
    assert not (tmp_path / "o.gcode").exists()


def posted(tmp_path: Path, curve: dict[str, object]) -> str:
    """What is said of a part with one curve."""
    path = tmp_path / "part.json"
    path.write_text(json.dumps({**PART, "contours": [{"kind": "open", "curves": [curve]}]}))
    return call("inspect", path)


def spline(degree: int, count: int) -> dict[str, object]:
    inner = list(range(1, count - degree))
    knots = [0] * (degree + 1) + inner + [count - degree] * (degree + 1)
    control = [[x / 10, x % 7] for x in range(count)]
    return {"bspline": {"degree": degree, "control": control, "knots": knots}}


@pytest.mark.parametrize(
    ("curve", "said"),
    [
        ({"bezier": [[x, x % 7] for x in range(3000)]}, "has degree 25 at most, found 2999"),
        (spline(1000, 1100), "a spline has degree 25 at most, found 1000"),
        (spline(25, 60), "degree 25 has at most 56 control points, found 60"),
        (spline(3, 16_000), "degree 3 has at most 15625 control points, found 16000"),
        ({"newton": [[x, 0] for x in range(27)]}, "at most 26 nodes, found 27"),
        ({"line": [[0, 0], [1e11, 0]]}, "found 100000000000.0, expected at most 1e+10"),
        ({"line": [[0, 0], [10**400, 0]]}, "expected a finite number"),
        (
            {"function": {"y": "sin(x * 1000)", "from": 0, "to": 100}},
            "takes more than 1000 curves",
        ),
        (
            {"function": {"y": "+".join(["x"] * 600), "from": 0, "to": 100}},
            "has 1199 characters, expected at most 1000",
        ),
        ({"function": {"y": "9^9^9^9^9", "from": 0, "to": 1}}, "has no value"),
    ],
)
def test_work_is_bounded(curve: dict[str, object], said: str, tmp_path: Path) -> None:
    assert said in posted(tmp_path, curve)


def test_the_greatest_that_is_allowed_is_in_time(tmp_path: Path) -> None:
    posted(tmp_path, {"bezier": [[8 * x, x % 7] for x in range(MAX_DEGREE + 1)]})
    posted(tmp_path, {"newton": [[8 * x, x % 2] for x in range(MAX_DEGREE + 1)]})


def test_nothing_nests_without_end(tmp_path: Path) -> None:
    texts = {
        "deep.json": f'{{"mark": {"[" * 100_000}',
        "deep.svg": '<svg xmlns="http://www.w3.org/2000/svg">' + "<g>" * 50_000,
        "deep.ifc": (HOSTILE / "cyc.ifc").read_text().replace("ENDSEC;\nEND-ISO", "")
        + f"#99999=IFCBEAM({'(' * 50_000}{')' * 50_000});\nENDSEC;\nEND-ISO-10303-21;\n",
    }
    for name, text in texts.items():
        path = tmp_path / name
        path.write_text(text)
        assert " error " in call("inspect", path)


def test_an_archive_is_measured_before_it_is_unpacked(tmp_path: Path) -> None:
    import zipfile

    path = tmp_path / "bomb.ifczip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("model.ifc", b"ISO-10303-21;" + bytes(70_000_000))
    assert "bytes that unpack to 70000013, expected at most 64000000" in call("inspect", path)


def test_many_messages_are_counted(tmp_path: Path) -> None:
    lines = (SAMPLES / "dstv" / "channel.nc1").read_text().splitlines()
    at = lines.index("BO") + 1
    path = tmp_path / "many.nc1"
    path.write_text("\n".join([*lines[:at], *["  v oops"] * 500, *lines[at:]]) + "\n")
    text = call("inspect", path)
    assert text.count("error dstv-hole-fields") == 20
    assert "note more-messages: found 480 more messages dstv-hole-fields, 500 in all" in text
    assert len(json.loads(call("inspect", path, "--json"))["diagnostics"]) >= 500


@pytest.mark.parametrize(
    "style",
    [
        "/*" * 30_000,
        "a{" * 30_000,
        "@import " * 20_000,
        "." * 60_000,
        ".a" * 30_000 + "{stroke:red}",
        "a" * 60_000 + "!",
        "x{stroke:red" + " " * 60_000 + "!}",
        "#" * 60_000 + "{stroke:red}",
        "a," * 30_000 + "{stroke:red}",
        "-" * 60_000 + "{}",
    ],
    ids=lambda style: style[:12],
)
def test_styles_take_no_quadratic_time(style: str, tmp_path: Path) -> None:
    path = tmp_path / "a.svg"
    path.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="9mm" height="9mm" viewBox="0 0 9 9">'
        f'<style>{style}</style><path stroke="red" style="{style.replace("&", "")}" '
        f'd="M0 0 L5 5" transform="{" " * 60_000}"/></svg>'
    )
    call("inspect", path)
