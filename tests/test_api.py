"""The Python API: what it gives, what it raises, and that importing it costs nothing."""

import json
import pickle
import re
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from inspect import signature
from io import BytesIO, StringIO
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner
from msgspec.structs import replace

import beamcam
from beamcam import api
from beamcam.arguments import AskError
from beamcam.cli import main
from beamcam.errors import BeamcamError, MachineError, PlanError, ReadError
from beamcam.machine import load
from beamcam.pipeline import RefusedProgram
from tests.conftest import ROOT, SAMPLES, sampled
from tests.runs import BAD, part

CHANNEL = SAMPLES / "dstv" / "channel.nc1"


def test_read_plan_post_verify() -> None:
    reading = beamcam.read(CHANNEL)
    assert reading.format == "dstv"
    (channel,) = reading.parts
    plan = beamcam.plan(channel, bar=6000.0)
    assert plan.bar.length == 6000.0
    posted = beamcam.post(reading.parts, "beamline", job="J1", bar=6000.0)
    assert posted.text.startswith("% J1\n")
    assert posted.plan == plan
    assert beamcam.verify(posted.text, channel) == ()
    wrong = posted.text.replace("L18", "L22", 1)
    assert [d.code for d in beamcam.verify(wrong, channel, load("beamline"), name="j.gcode")] != []
    assert beamcam.verify(wrong, channel, name="j.gcode")[0].source.file == "j.gcode"


def test_machines_by_name_path_and_record(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('base = "beamline"\n')
    parts = beamcam.read(CHANNEL).parts
    machines = ("beamline", path, str(path), load("beamline"))
    texts = [beamcam.post(parts, machine).text for machine in machines]
    # Only the head says what the machine's file is called.
    assert "MACHINE mine" in texts[1]
    assert {text.replace("MACHINE mine", "MACHINE beamline") for text in texts} == {texts[0]}


def test_bytes_are_read_too() -> None:
    reading = beamcam.read(part("A").encode(), name="a.nc1")
    assert reading.parts[0].source.file == "a.nc1"
    assert beamcam.read(CHANNEL.read_bytes()).parts[0].mark == beamcam.read(CHANNEL).parts[0].mark


def test_errors_are_raised(tmp_path: Path) -> None:
    with pytest.raises(ReadError, match="read-file"):
        beamcam.read(tmp_path / "none.nc1")
    with pytest.raises(ReadError, match="read-empty"):
        beamcam.read(b"")
    bad = beamcam.read(BAD.encode(), name="bad.nc1").parts
    with pytest.raises(PlanError, match=r"bad\.nc1:28: error plan-tool"):
        beamcam.post(bad)
    assert "M40" not in beamcam.post(bad, skips=("tool",)).text
    with pytest.raises(MachineError, match="machine-unknown"):
        beamcam.plan(bad, "beamlime")


def test_strict_makes_warnings_errors() -> None:
    data = part("A").replace("  v  100.00u   60.00", "  v  100.00u  600.00").encode()
    assert [d.severity.value for d in beamcam.read(data, name="a.nc1").diagnostics] == ["warning"]
    with pytest.raises(ReadError, match="error dstv-hole-outside"):
        beamcam.read(data, name="a.nc1", strict=True)


def test_no_read_back_is_said() -> None:
    parts = beamcam.read(CHANNEL).parts
    assert beamcam.post(parts, read_back=False).text != beamcam.post(parts).text


ORDERS = (
    "import beamcam; f = beamcam.verify",
    "import beamcam.pipeline, beamcam; f = beamcam.verify",
    "import beamcam.checks; f = beamcam.verify",
    "from beamcam import verify as f",
    "import beamcam; beamcam.read; f = beamcam.verify",
    "import beamcam.checks.bars, beamcam.simulation; import beamcam; f = beamcam.verify",
    "from beamcam.api import verify as f",
)


@pytest.mark.parametrize("order", sampled(ORDERS, 4))
def test_verify_is_a_function_whatever_was_imported_before(order: str) -> None:
    code = (
        f"{order}\nimport beamcam\n"
        f"parts = beamcam.read({str(CHANNEL)!r}).parts\n"
        "assert f(beamcam.post(parts).text, parts, 'beamline') == ()\n"
        "from beamcam.checks.bars import run, verify\nassert callable(run) and callable(verify)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_importing_it_costs_nothing() -> None:
    code = (
        "import sys; before = set(sys.modules); import beamcam\n"
        "print(sorted(m for m in set(sys.modules) - before if m.startswith('beamcam')))\n"
        "import beamcam.api\n"
        "print([m for m in ('numpy', 'ezdxf', 'ifcopenshell', 'shapely') if m in sys.modules])\n"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.stdout == "['beamcam', 'beamcam.version']\n[]\n", done.stderr


def test_names() -> None:
    assert set(api.__all__) <= set(dir(beamcam))
    assert (ROOT / "beamcam" / "py.typed").exists()
    with pytest.raises(AttributeError, match="has no attribute 'nothing'"):
        beamcam.nothing  # type: ignore[attr-defined]  # noqa: B018


@pytest.mark.exhaustive
def test_it_is_typed(tmp_path: Path) -> None:
    """A caller's mistakes are found by mypy, and the examples of the documentation have none."""
    source = tmp_path / "use.py"
    page = (ROOT / "docs" / "api.md").read_text(encoding="utf-8")
    examples = re.findall(r"^```python\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    assert len(examples) == 5
    files = [tmp_path / f"example_{k}.py" for k in range(len(examples))]
    for file, text in zip(files, examples, strict=True):
        file.write_text(text, encoding="utf-8")
    source.write_text(
        "import beamcam\n"
        "reading = beamcam.read('a.nc1')\n"
        "text: str = beamcam.post(reading.parts).text\n"
        "count: int = len(beamcam.plan(reading.parts, 'beamline').operations)\n"
        "codes: list[str] = [d.code for d in beamcam.verify(text, reading.parts)]\n"
        "beamcam.post(reading.parts, bar='long')\n"
    )
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--strict", "--follow-imports=silent",
         "--cache-dir", str(tmp_path / "cache"), str(source), *map(str, files)],
        cwd=ROOT, capture_output=True, text=True,
    )  # fmt: skip
    assert "use.py:6: error" in done.stdout
    assert done.stdout.count("use.py:") == 1, done.stdout
    assert "example_" not in done.stdout, done.stdout


NAN, INF = float("nan"), float("inf")


@pytest.mark.parametrize("bar", [NAN, INF, -INF, 0, -6000.0])
def test_a_bar_has_a_length(bar: float) -> None:
    parts = beamcam.read(CHANNEL).parts
    for call in (beamcam.plan, beamcam.post):
        with pytest.raises(AskError, match="error ask-bar: found a bar of"):
            call(parts, bar=bar)


@pytest.mark.parametrize("job", ["A\nG00 X0", "A\rB", "A\u2028B", "A\x0bB", "A\x85B", "\x1b[2J"])
def test_a_job_is_one_line(job: str, tmp_path: Path) -> None:
    parts = beamcam.read(CHANNEL).parts
    for machine in ("beamline", "beamline-annex"):
        with pytest.raises(AskError, match="error ask-job: found the job name"):
            beamcam.post(parts, machine, job=job)
    asked = [str(CHANNEL), "--job", job, "-o", str(tmp_path / "o")]
    for command in ("post", "batch"):
        result = CliRunner().invoke(main, [command, *asked])
        assert result.exit_code == 1
        assert "error ask-job" in result.stderr


@pytest.mark.parametrize("skips", [("slots",), ("Slot",), {"none"}, [1], [None]])
def test_skips_are_known_names(skips: Any) -> None:
    parts = beamcam.read(CHANNEL).parts
    text = beamcam.post(parts).text
    for call in (beamcam.plan, beamcam.post, partial(beamcam.verify, text)):
        with pytest.raises(AskError, match="error ask-skip"):
            call(parts, skips=skips)


@pytest.mark.parametrize(
    "call",
    [
        lambda parts: beamcam.post(parts, skips="slot"),
        lambda parts: beamcam.post(parts, skips=None),
        lambda parts: beamcam.post(parts, job=5),
        lambda parts: beamcam.post(parts, job=None),
        lambda parts: beamcam.post(parts, bar="6000"),
        lambda parts: beamcam.post(parts, bar=True),
        lambda parts: beamcam.post(parts, bar=1j),
        lambda parts: beamcam.post(parts, 5),
        lambda parts: beamcam.post(parts, None),
        lambda parts: beamcam.post(parts, read_back="no"),
        lambda parts: beamcam.post("M58.nc1"),
        lambda parts: beamcam.post(b"ST"),
        lambda parts: beamcam.post(5),
        lambda parts: beamcam.post([*parts, None]),
        lambda parts: beamcam.plan([1]),
        lambda parts: beamcam.verify(5, parts),
        lambda parts: beamcam.verify(None, parts),
        lambda parts: beamcam.verify("M30", parts, name=5),
        lambda parts: beamcam.verify("M30", parts, skips="slot"),
        lambda parts: beamcam.read(5),
        lambda parts: beamcam.read(None),
        lambda parts: beamcam.read(CHANNEL, strict=1),
        lambda parts: beamcam.read(b"ST", name=None),
    ],
)
def test_wrong_types_are_told(call: Callable[[Any], object]) -> None:
    with pytest.raises(AskError, match="error ask-type: found") as told:
        call(beamcam.read(CHANNEL).parts)
    assert isinstance(told.value, BeamcamError)


@pytest.mark.parametrize("number", [NAN, INF])
def test_numbers_of_a_part_are_finite(number: float) -> None:
    (channel,) = beamcam.read(CHANNEL).parts
    hole = next(iter(channel.holes))
    odd = replace(channel, features=(replace(hole, x=number),))
    with pytest.raises(AskError, match=r"error ask-number: found \w+ as features.x of the part"):
        beamcam.post(odd)
    with pytest.raises(AskError, match="as length of the part"):
        beamcam.plan(replace(channel, length=number))


def test_a_number_of_numpy_is_a_number() -> None:
    import numpy as np

    assert beamcam.plan(beamcam.read(CHANNEL).parts, bar=np.float64(6000)).bar.length == 6000.0


def test_load_is_the_machine_as_the_commands_take_it(tmp_path: Path) -> None:
    """The same program as `post` writes with the options of the same names."""
    plate = SAMPLES / "dxf" / "plate.dxf"
    out = tmp_path / "a.ngc"
    options = "--thickness 3 --kerf 1.2 --lead arc --tabs 2 --map CUT=cut --machine plate-linuxcnc"
    done = CliRunner().invoke(main, ["post", str(plate), "-o", str(out), *options.split()])
    assert done.exit_code == 0, done.output
    table = beamcam.load(
        "plate-linuxcnc", thickness=3, kerf=1.2, lead="arc", tabs=2, map={"CUT": "cut"}
    )
    assert (
        beamcam.post(beamcam.read(plate.read_bytes(), name="plate").parts, table).text
        == out.read_text()
    )


def test_load_takes_tolerances_and_rows_of_a_map() -> None:
    drill = beamcam.load("beamline", tolerances={"merge": 0.3}).drill
    assert drill is not None
    assert drill.merge_tolerance == 0.3
    torch = beamcam.load("laser-grbl", map={"red": {"process": "mark", "passes": 3}}).torch
    assert torch is not None
    assert (torch.colours["red"], torch.settings["red"].passes) == ("mark", 3)
    assert beamcam.load("beamline") == load("beamline")


@pytest.mark.parametrize(
    ("machine", "options", "code", "names"),
    [
        ("plate-linuxcnc", {"kerf": -1}, "ask-value", "sheet.kerf"),
        ("plate-linuxcnc", {"kerff": 1}, "ask-value", "kerff"),
        ("plate-linuxcnc", {"lead": "spiral"}, "ask-value", "sheet.lead"),
        ("plate-linuxcnc", {"map": {"red": "burn"}}, "ask-value", "map"),
        ("beamline", {"tolerances": {"merge": -1}}, "ask-value", "tolerances"),
        ("beamline", {"tolerances": {"same_tool": 2}}, "ask-value", "tolerances"),
        ("plate-linuxcnc", {"kerf": 1e-4}, "plan-sheet-option", "a kerf of 0.0001 mm"),
        ("beamline", {"kerf": 1}, "plan-sheet-option", "beamline has no torch"),
        ("plate-linuxcnc", {"tolerances": {"merge": 1}}, "config-tolerance", "tolerances.merge"),
        (5, {}, "ask-type", "machine"),
    ],
)
def test_load_refuses_what_cannot_be_meant(
    machine: Any, options: dict[str, Any], code: str, names: str
) -> None:
    with pytest.raises(BeamcamError) as error:
        beamcam.load(machine, **options)
    (said,) = error.value.diagnostics
    assert said.code == code
    assert names in f"{said.source} {said.message}"


def test_read_takes_what_readers_take() -> None:
    plate = SAMPLES / "dxf" / "plate.dxf"
    in_mm, in_inches = (beamcam.read(plate, units=u).parts[0].length for u in ("mm", "in"))
    assert in_inches == pytest.approx(25.4 * in_mm)
    text = part("A").replace("TEST", "T\u0416").encode("cp1251")
    assert "\u0416" in repr(beamcam.read(text, name="a.nc1", encoding="cp1251").parts)
    for options in ({"encoding": "none-such"}, {"layers": 5}, {"units": 5}):
        with pytest.raises(AskError):
            beamcam.read(plate, **options)  # type: ignore[arg-type]


@pytest.mark.parametrize("to", ["dstv", "part-json"])
def test_convert_is_read_again(to: str) -> None:
    (channel,) = beamcam.read(CHANNEL).parts
    (again,) = beamcam.read(beamcam.convert(channel, to).encode(), name="a").parts
    assert beamcam.post(again).text.splitlines()[5:] == beamcam.post(channel).text.splitlines()[5:]


def test_convert_says_what_it_can_write() -> None:
    (plate,) = beamcam.read(SAMPLES / "dxf" / "plate.dxf").parts
    text = beamcam.convert(plate, "part-json", thickness=3)
    assert beamcam.read(text.encode()).parts[0].profile.web_thickness == 3.0
    with pytest.raises(AskError, match="expected dstv, part-json, faces-dxf"):
        beamcam.convert(plate, "step")
    with pytest.raises(AskError, match="thickness"):
        beamcam.convert(plate, thickness=-3)


def test_the_time_of_a_machine_by_name_path_and_record(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text('base = "beamline"\n')
    posted = beamcam.post(beamcam.read(CHANNEL).parts)
    times = {posted.time(m).total_s for m in ("beamline", path, str(path), load("beamline"))}
    assert len(times) == 1


#: Options of commands that are of the command line alone, or have another name here.
ELSEWHERE = {
    "output", "config_file", "trust", "quiet", "verbose", "as_json", "quantity", "exit_left_out",
    "schema", "against", "colours", "no_verify", "first", "inputs", "program", "a", "b", "show",
    "help", "every", "contour", "frame", "encoder", "name", "modbus", "serve", "pace", "machine",
    "source", "rest_name", "by",
}  # fmt: skip
CALLED = {
    "no_verify": "read_back", "first": "from_operation", "contour": "from_contour",
    "colours": "map",
}  # fmt: skip


@pytest.mark.parametrize("command", [
    "post", "verify", "plan", "inspect", "convert", "diff", "recover", "plot", "report", "simulate",
    "list", "labels",
])  # fmt: skip
def test_what_a_command_takes_can_be_asked_from_python(command: str) -> None:
    from beamcam.api.inputs import ReadOptions, SheetOptions

    function = getattr(api, {"inspect": "read", "list": "lists"}.get(command, command))
    names = {*signature(function).parameters, *ReadOptions.__annotations__, "map"}
    names |= {*SheetOptions.__annotations__, *signature(beamcam.post).parameters}
    names |= {*signature(beamcam.convert).parameters, *signature(beamcam.load).parameters}
    names |= {"bars", "table"} if command == "list" else set()  # called lengths; all three tables
    context = main.make_context("beamcam", [], resilient_parsing=True)
    asked = {p.name for p in main.get_command(context, command).params}  # type: ignore[union-attr]
    missing = {name for name in asked - ELSEWHERE if name not in names}
    assert missing == set()
    assert set(CALLED.values()) <= names


def test_what_comes_back_and_what_is_raised_can_be_pickled() -> None:
    def again(value: Any) -> Any:
        return pickle.loads(pickle.dumps(value))

    parts = beamcam.read(CHANNEL).parts
    posted = beamcam.post(parts)
    for value in (parts, beamcam.read(CHANNEL), beamcam.plan(parts), posted, load("beamline")):
        assert again(value) == value
    plate = beamcam.read(SAMPLES / "dxf" / "plate.dxf").parts
    steps = beamcam.post(plate, beamcam.load("laser-stepper", thickness=3))
    assert again(steps).text == steps.text
    calls: tuple[Callable[[], object], ...] = (
        lambda: beamcam.read(b""), lambda: beamcam.plan(parts, "beamlime"),
        lambda: beamcam.post(parts, "plate-linuxcnc"), lambda: beamcam.post(parts, bar=-1),
    )  # fmt: skip
    for call in calls:
        with pytest.raises(BeamcamError) as told:
            call()
        other = again(told.value)
        assert (type(other), str(other)) == (type(told.value), str(told.value))
        assert other.diagnostics == told.value.diagnostics
    refused = again(RefusedProgram(told.value.diagnostics, "M30"))
    assert (refused.written, refused.diagnostics) == ("M30", told.value.diagnostics)


def test_a_file_is_its_path_its_bytes_or_open(tmp_path: Path) -> None:
    data = CHANNEL.read_bytes()
    texts = StringIO(data.decode())
    forms = (data, bytearray(data), memoryview(data), BytesIO(data), CHANNEL.open("rb"), texts)
    marks = [beamcam.read(form, name="a.nc1").parts[0].mark for form in forms]
    assert set(marks) == {"C1"}
    posted = beamcam.post(beamcam.read(CHANNEL).parts)
    path = tmp_path / "a.gcode"
    path.write_text(posted.text)
    for program in (posted.text, posted.text.encode(), path, BytesIO(posted.text.encode())):
        assert beamcam.verify(program, beamcam.read(CHANNEL).parts) == ()
    with pytest.raises(ReadError, match="read-file"):
        beamcam.verify(tmp_path / "none.gcode", ())


def test_members_of_a_model_are_chosen() -> None:
    model = SAMPLES / "ifc" / "beam_openings.ifc"
    every = beamcam.read(model).parts
    one = beamcam.read(model, guids=[every[0].guid], check=False).parts
    assert [part.guid for part in one] == [every[0].guid]
    lettered = beamcam.read(model, letter="mark", check=False).parts[0]
    assert any(type(feature).__name__ == "TextMark" for feature in lettered.features)
    for options in ({"clases": ["x"]}, {"letter": "name"}, {"workers": 0}, {"marks": 5}):
        with pytest.raises(AskError, match="ask-value"):
            beamcam.read(model, **options)  # type: ignore[arg-type]


def test_order_turn_style_and_strict() -> None:
    strut = beamcam.read(SAMPLES / "dstv" / "strut.nc1").parts * 3
    best = beamcam.post(strut, order="best", turn=True)
    assert beamcam.verify(best.text, strut, order="best", turn=True) == ()
    assert best.plan == beamcam.plan(strut, order="best", turn=True)
    plate = beamcam.read(SAMPLES / "dxf" / "plate.dxf").parts
    table = beamcam.load("table-simotion", thickness=3)
    texts = [beamcam.post(plate, table, style=style).text for style in ("chain", "table")]
    assert texts[0] != texts[1]
    tie = beamcam.read(SAMPLES / "dstv" / "tie.nc1").parts
    warned = str(SAMPLES / "machines" / "hall-drill.toml")
    assert beamcam.post(tie, warned).remarks
    calls: tuple[Callable[[], object], ...] = (
        lambda: beamcam.post(strut, order="beast"),  # type: ignore[arg-type]
        lambda: beamcam.post(strut, turn=1),  # type: ignore[arg-type]
        lambda: beamcam.post(plate, table, style=".bin"),
        lambda: beamcam.post(strut, style="chain"),
        lambda: beamcam.verify(best.text, strut, from_operation="3"),  # type: ignore[arg-type]
        lambda: beamcam.post(plate, table, from_operation=3),
    )
    for call in calls:
        with pytest.raises(AskError):
            call()


def test_a_remainder_is_posted_and_verified() -> None:
    (channel,) = beamcam.read(CHANNEL).parts
    whole, rest = beamcam.post(channel), beamcam.post(channel, from_operation=8)
    assert beamcam.verify(rest.text, channel, from_operation=8) == ()
    assert beamcam.verify(rest.text, channel, from_operation=8, after=whole.text) == ()
    assert beamcam.verify(rest.text, channel, from_operation=9)
    with pytest.raises(PlanError, match="plan-operation"):
        beamcam.post(channel, from_operation=99)


def test_a_program_is_simulated_compared_recovered_and_drawn() -> None:
    (channel,) = beamcam.read(CHANNEL).parts
    posted = beamcam.post(channel)
    run = beamcam.simulate(posted.text, parts=channel)
    assert run.trace.duration_s == pytest.approx(posted.time("beamline").total_s, rel=0.01)
    assert beamcam.diff(posted.text, posted.text).differences == ()
    changed = posted.text.replace("L14", "L16")
    assert len(beamcam.diff(posted.text, changed).differences) >= 4
    assert beamcam.diff(channel, [channel]).differences == ()
    found = beamcam.recover(posted.text, profile="UPN200").parts
    assert len([*found[0].holes]) == len([*channel.holes])
    assert beamcam.recover(posted.text, profile=channel).parts[0].grade == channel.grade
    assert str(beamcam.plot(channel)).startswith("<svg")
    assert str(beamcam.plot(posted.text, "beamline")).startswith("<svg")
    pages = [beamcam.report(channel), beamcam.report(channel, program=posted)]
    assert pages[0] == pages[1]
    given = beamcam.report(channel, program=posted.text, name="x.gcode")
    assert str(given).startswith("<!doctype html>")
    calls: tuple[Callable[[], object], ...] = (
        lambda: beamcam.diff(channel, posted.text),
        lambda: beamcam.plot(channel, to="jpg"),  # type: ignore[arg-type]
        lambda: beamcam.report(channel, unit="m"),  # type: ignore[arg-type]
        lambda: beamcam.recover(posted.text, profile="XYZ"),
        lambda: beamcam.recover(posted.text, "table-simotion"),
        lambda: beamcam.recover(posted.text, "laser-stepper"),
        lambda: beamcam.simulate(5),  # type: ignore[arg-type]
    )
    for call in calls:
        with pytest.raises(AskError):
            call()


def test_lists_and_labels_are_those_of_the_commands(tmp_path: Path) -> None:
    parts = beamcam.read(CHANNEL).parts
    out = tmp_path / "list.json"
    words = ["list", str(CHANNEL), "--quantity", "5", "--bar", "6000", "-o", str(out)]
    assert CliRunner().invoke(main, [*words, "--remnant", "UPN200=4300"]).exit_code == 0
    tables = beamcam.lists(parts, lengths=[6000], remnants=["UPN200=4300"], quantity=5)
    written = json.loads(out.read_text())
    for key, table in zip(("part_list", "bars", "cutting_list"),
                          (tables.parts, tables.bars, tables.cuts), strict=True):  # fmt: skip
        assert [tuple(row.values()) for row in written[key]] == [*table.cells()]
    assert tables.diagnostics == ()
    assert beamcam.lists(parts, lengths=[1500]).diagnostics[0].code == "plan-bar-full"
    zpl = str(beamcam.labels(parts, to="zpl", quantity=2, programs=["c.gcode"]))
    assert (zpl.count("^XA"), "c.gcode" in zpl) == (2, True)
    assert bytes(beamcam.labels(parts)).startswith(b"%PDF")  # type: ignore[arg-type]
    calls: tuple[Callable[[], object], ...] = (
        lambda: beamcam.lists(parts, quantity=0),
        lambda: beamcam.lists(parts, lengths=[-1]),
        lambda: beamcam.lists(parts, remnants=["UPN200="]),
        lambda: beamcam.labels(parts, to="svg"),  # type: ignore[arg-type]
        lambda: beamcam.labels(parts, code="bar"),  # type: ignore[arg-type]
        lambda: beamcam.labels(parts, programs=["a", "b"]),
    )
    for call in calls:
        with pytest.raises(AskError):
            call()
