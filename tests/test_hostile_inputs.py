"""Inputs that took a command too long, too much memory, or into a traceback."""

import json
import sys
import time
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from click.testing import CliRunner

from beamcam.cli import main
from beamcam.conversion import MAX_NUMBER
from beamcam.geometry.bezier import MAX_DEGREE
from beamcam.model import part_json
from beamcam.readers import read
from tests.conftest import SAMPLES

HOSTILE = Path(__file__).parent / "hostile"
HANG_S = 120.0  #: processor time that none takes, on a slow machine either, unless it hangs
FILES = sorted(path for path in HOSTILE.iterdir() if path.suffix != ".toml")
PART = {
    "schema": "beamcam/part/1", "mark": "A", "length": 200,
    "profile": {"code": "B", "height": 100, "web_thickness": 6},
}  # fmt: skip


class Outcome(NamedTuple):
    """What came of a command."""

    printed: str
    faults: list[str]  #: a traceback, another exit status, no end, text that steers

    @property
    def text(self) -> str:
        """What a command printed that held; nothing of one that did not."""
        return "" if self.faults else self.printed


def call(*words: object) -> Outcome:
    """What comes of a command."""
    begun = time.process_time()
    result = CliRunner().invoke(main, [str(word) for word in words])
    took = time.process_time() - begun
    printed = result.stdout + result.stderr
    faults = []
    if not isinstance(result.exception, SystemExit | None):
        faults.append(repr(result.exception))
    if result.exit_code not in (0, 1):
        faults.append(f"exit status {result.exit_code}: {printed}")
    if took >= HANG_S:
        faults.append(f"{took:.1f} s")
    faults += [repr(line) for line in printed.split("\n") if not line.isprintable()]
    return Outcome(printed, faults)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_commands_end(path: Path, tmp_path: Path) -> None:
    assert call("inspect", path).faults == []
    for suffix in (".nc1", ".json", ".dxf"):
        assert call("convert", path, "-o", tmp_path / f"out{suffix}").faults == []
    drawn = path.suffix in (".svg", ".dxf")
    colours = ("--map", "red=cut", "--map", "black=cut", "--map", "white=cut") if drawn else ()
    machine = "beamline" if path.suffix in (".nc1", ".ifc") else "plate-linuxcnc"
    batch = ("--machine", machine, *colours, "-o", tmp_path / "out", "-v")
    assert call("batch", path, *batch).faults == []


def test_machine_files(tmp_path: Path) -> None:
    deep = tmp_path / "deep.toml"
    deep.write_text(f"x = {'[' * 100_000}{']' * 100_000}\n")
    long = tmp_path / "long.toml"
    long.write_text(f"x = {'9' * 5000}\n")
    huge = tmp_path / "huge.toml"
    huge.write_text("# " + "x" * 600_000)
    far = tmp_path / "far.toml"
    far.write_text('base = "beamline"\n[layout]\norder = "saw-drill"\nmax_bar = 1e300\n')
    sample = SAMPLES / "dstv" / "channel.nc1"
    for path, said in (
        (deep, "no TOML"),
        (long, "no TOML"),
        (huge, "more bytes than one has; expected at most 500000"),
        (far, "expected a number between -1e+10 and 1e+10"),
        (HOSTILE / "m3.toml", "with a width of two digits"),
    ):
        text = call("post", sample, "--machine", path, "-o", tmp_path / "o.gcode").text
        assert said in text, text
    assert "no TOML" in call("post", sample, "--config", deep, "-o", tmp_path / "o.gcode").text
    assert not (tmp_path / "o.gcode").exists()


def posted(tmp_path: Path, curve: dict[str, object]) -> Outcome:
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
    assert said in posted(tmp_path, curve).text


def test_the_greatest_that_is_allowed_is_in_time(tmp_path: Path) -> None:
    assert (
        posted(tmp_path, {"bezier": [[8 * x, x % 7] for x in range(MAX_DEGREE + 1)]}).faults == []
    )
    assert (
        posted(tmp_path, {"newton": [[8 * x, x % 2] for x in range(MAX_DEGREE + 1)]}).faults == []
    )


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
        assert " error " in call("inspect", path).text


def test_an_archive_is_measured_before_it_is_unpacked(tmp_path: Path) -> None:
    import zipfile

    path = tmp_path / "bomb.ifczip"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("model.ifc", b"ISO-10303-21;" + bytes(70_000_000))
    assert "bytes that unpack to 70000013, expected at most 64000000" in call("inspect", path).text


def test_many_messages_are_counted(tmp_path: Path) -> None:
    lines = (SAMPLES / "dstv" / "channel.nc1").read_text().splitlines()
    at = lines.index("BO") + 1
    path = tmp_path / "many.nc1"
    path.write_text("\n".join([*lines[:at], *["  v oops"] * 500, *lines[at:]]) + "\n")
    text = call("inspect", path).text
    assert text.count("error dstv-hole-fields") == 20
    assert "note more-messages: found 480 more messages dstv-hole-fields, 500 in all" in text
    assert len(json.loads(call("inspect", path, "--json").text)["diagnostics"]) >= 500


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
    assert call("inspect", path).faults == []


@pytest.mark.parametrize(
    "length",
    ["0" * 50_000 + "!", "1" + " " * 50_000 + "!", "1" + "a" * 50_000 + "!", "1" * 50_000 + "e"],
    ids=["digits", "blanks", "letters", "exponent"],
)
def test_lengths_take_no_quadratic_time(length: str, tmp_path: Path) -> None:
    path = tmp_path / "a.svg"
    path.write_text(
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{length}" height="9mm" '
        f'viewBox="0 0 9 9"><rect x="{length}" width="5" height="5" stroke="red" '
        f'stroke-width="{length}" stroke-opacity="{length}"/></svg>'
    )
    assert call("inspect", path).faults == []


@pytest.mark.parametrize(
    "head",
    [b"999\n\n\n" * 30, b"999\n" + b"\n" * 4000, b"999 \n\r\n" * 30, b"\t\n" * 2000, b"\r" * 4000],
    ids=["empty comments", "line ends", "mixed line ends", "blanks", "carriage returns"],
)
def test_line_ends_are_parted_in_one_way(head: bytes, tmp_path: Path) -> None:
    """Which format a file has is asked of every file; the head of a DXF has comments in it."""
    path = tmp_path / "a.dat"
    path.write_bytes(head + b"x")
    assert " error " in call("inspect", path).text
    path.write_bytes(b"999\n\n" + b"999\r\na comment\r\n  0\r\nSECTION\r\n")
    assert "dxf-" in call("inspect", path).text


@pytest.mark.parametrize("digits", [1, 400, 5000])
def test_numbers_of_any_length(digits: int, tmp_path: Path) -> None:
    """Python itself refuses to read more than 4,300 digits."""
    long = "9" * digits
    for variable in ("$INSUNITS", "$MEASUREMENT"):
        head = f"0\nSECTION\n2\nHEADER\n9\n{variable}\n70\n{long}\n0\nENDSEC\n0\nEOF\n"
        (tmp_path / "a.dxf").write_text(head)
        assert call("inspect", tmp_path / "a.dxf").faults == []
    (tmp_path / "a.svg").write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="10" height="10" '
        'xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" '
        f'inkscape:version="{long}.{long}"><path d="M0 0h9v9z" stroke="red"/></svg>'
    )
    assert call("inspect", tmp_path / "a.svg").faults == []


def test_what_is_computed_is_not_read(tmp_path: Path) -> None:
    """A curve may be longer than the greatest number that a file may give."""
    nodes = [[1e9, 5], [60, 20], [40, 22], [10, 11]]
    curves = [{"newton": nodes}, {"line": [[10, 11], [1e9, 5]]}]
    given = PART | {"contours": [{"kind": "outer", "curves": curves}]}
    (part,) = read(json.dumps(given).encode(), "a.json").parts
    written = part_json.write(part)
    assert json.loads(written)["path_length"] > MAX_NUMBER
    again = read(written.encode(), "a.json")
    assert not again.refused, again.diagnostics
    assert again.parts[0].features[0].curves == part.features[0].curves  # type: ignore[union-attr]
    huge = json.loads(written) | {"length": 1e11}
    assert read(json.dumps(huge).encode(), "a.json").refused


def outcome_of_crowd(contours: list[dict[str, Any]], machine: str, made: Path) -> Outcome:
    """What comes of a part with these openings; half of them take more than a third of the calls.

    Of quadratic work they would take a quarter. Calls are the same on a busy machine.
    """
    path, counts = made.with_suffix(".json"), list[int]()
    for some in (contours[: len(contours) // 2], contours):
        path.write_text(json.dumps(PART | {"length": 100, "contours": some}))
        made.unlink(missing_ok=True)
        counts.append(0)
        sys.setprofile(lambda _frame, event, _: counts.append(counts.pop() + (event == "call")))
        try:
            outcome = call("post", path, "--machine", machine, "-o", made)
        finally:
            sys.setprofile(None)
    assert counts[1] < 3 * counts[0], counts
    assert outcome.faults == []
    assert made.exists(), outcome.printed
    return outcome


def test_curves_on_each_other_take_no_quadratic_time(tmp_path: Path) -> None:
    """Each circle is cut once; the read-back of a step table has one band around all."""
    circle = {"circle": {"centre": [50, 50], "radius": 10}}
    contours = [{"kind": "inner", "curves": [circle]}] * 100
    outcome_of_crowd(contours, "laser-stepper", tmp_path / "a.steps")


@pytest.mark.parametrize("apart", [0.0, 1e-7])
def test_free_curves_on_each_other_take_no_quadratic_time(apart: float, tmp_path: Path) -> None:
    """Equal contours are known by their numbers, nearly equal ones by where they lie."""
    contours = [
        {"kind": "inner", "curves": [
            {"bezier": [[20 + k * apart, 50], [20, 80], [60, 80], [60, 50]]},
            {"line": [[60, 50], [20 + k * apart, 50]]},
        ]}
        for k in range(100)
    ]  # fmt: skip
    outcome = outcome_of_crowd(contours, "plate-codesys", tmp_path / "a.gcode")
    assert "plan-overlap" in outcome.printed


@pytest.mark.parametrize(
    ("sample", "old", "new", "said"),
    [
        ("bolted", "'IPE300',#15,", "'IPE300',#15000,", "a reference to #15000, which is not in"),
        ("beam_inch", "#80,0.354", "#80,-0.354", "found a circle of radius -9"),
        ("beam_inch", "#23,5.9", "#23,9999999995.9", "a section with a measure of 2.54e+11 mm"),
        ("bolted", "#21,2500.0", "#21,25" + "0" * 200 + ".0", "found a length of 2.5e+201 mm"),
    ],
)
def test_members_of_a_damaged_model_are_refused(
    sample: str, old: str, new: str, said: str, tmp_path: Path
) -> None:
    text = (SAMPLES / "ifc" / f"{sample}.ifc").read_text()
    assert old in text
    path = tmp_path / "a.ifc"
    path.write_text(text.replace(old, new))
    assert said in call("inspect", path).text
    assert said in call("convert", path, "-o", tmp_path / "out.json").text


def test_weights_of_a_spline_are_bounded(tmp_path: Path) -> None:
    text = (SAMPLES / "dxf" / "splines.dxf").read_text()
    assert "0.7071067811865476" in text
    path = tmp_path / "a.dxf"
    path.write_text(text.replace("0.7071067811865476", "7071067811865476"))
    said = "SPLINE that cannot be read (a coordinate that is no number up to"
    assert said in call("inspect", path).text


def test_slots_on_each_other_are_told_apart_by_their_numbers(tmp_path: Path) -> None:
    slot = {"face": "v", "x": 100, "y": 50, "diameter": 20, "length": 30, "height": 0, "angle": 0}
    path = tmp_path / "a.json"
    path.write_text(json.dumps(PART | {"slots": [slot] * 200}))
    said = call("post", path, "--machine", "plate-linuxcnc", "-o", tmp_path / "a.ngc")
    assert said.faults == []
    assert (tmp_path / "a.ngc").exists(), said.printed


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("tiny", [1e-200, 5e-324, -1e-300])
def test_a_place_of_next_to_nothing_takes_no_way_of_its_own(tiny: float, tmp_path: Path) -> None:
    corners = [[0, 0], [40, 0], [40, 30], [0, 30], [tiny, 0]]
    lines = [{"line": [a, b]} for a, b in pairwise(corners)]
    contour = {"face": "v", "kind": "outer", "process": "cut", "curves": lines}
    path = tmp_path / "a.json"
    path.write_text(json.dumps(PART | {"contours": [contour]}))
    for suffix in ("steps", "csv", "ngc", "nc"):
        said = call("post", path, "-o", tmp_path / f"a.{suffix}")
        assert said.faults == []


@pytest.mark.parametrize("kind", ["slots", "contours"])
def test_thousands_of_copies_are_refused_before_they_are_compared(
    kind: str, tmp_path: Path
) -> None:
    slot = {"face": "v", "x": 100, "y": 50, "diameter": 20, "length": 30, "height": 0, "angle": 0}
    free = {"face": "v", "kind": "open", "curves": [{"line": [[20, 20], [50, 20]]}]}
    path = tmp_path / "a.json"
    path.write_text(json.dumps(PART | {kind: [slot if kind == "slots" else free] * 2000}))
    said = call("post", path, "--machine", "plate-linuxcnc", "-o", tmp_path / "a.ngc")
    assert "error plan-copies: found one curve 2000 times, and " in said.printed


@pytest.mark.exhaustive
def test_a_contour_on_itself_many_times_over_is_refused_in_time(tmp_path: Path) -> None:
    """Exact noding of such a ring takes minutes."""
    sides: list[dict[str, object]] = [
        {"bezier": [[10, 10], [40, 0], [80, 20], [100, 10]]},
        {"bezier": [[100, 10], [110, 40], [90, 60], [100, 90]]},
        {"bezier": [[100, 90], [80, 80], [40, 100], [10, 90]]},
        {"bezier": [[10, 90], [0, 60], [20, 40], [10, 10]]},
    ]
    path = tmp_path / "a.json"
    contour = {"kind": "outer", "curves": sides * 30}
    path.write_text(json.dumps(PART | {"length": 110, "contours": [contour]}))
    said = call("post", path, "--machine", "plate-linuxcnc", "-o", tmp_path / "a.ngc")
    assert said.faults == []
    assert "error plan-" in said.printed


@pytest.mark.exhaustive
def test_a_hole_beyond_all_measure_beside_a_text_takes_no_memory(tmp_path: Path) -> None:
    text = (SAMPLES / "dstv" / "lettered.nc1").read_text()
    path = tmp_path / "a.nc1"
    path.write_text(text.replace("40.00      18.00", "40.00 999999999.00"))
    assert call("post", path, "--machine", "plate-linuxcnc", "-o", tmp_path / "a.ngc").faults == []
