"""Command line over --config over beamcam.toml beside the job over defaults, in every command."""

import shlex
import shutil
from pathlib import Path

import pytest
from click.testing import CliRunner
from msgspec import Struct

from beamcam.batch.pool import Here
from beamcam.batch.work import BatchSettings
from beamcam.cli import main
from beamcam.config.values import ConfigFile
from tests.conftest import SAMPLES, sampled
from tests.runs import BAD, part

#: Two pairs of flange holes, 0.2 and 0.4 mm apart: how many are one depends on the tolerance.
PAIRS = part("G").replace(
    "EN\n",
    "BO\n  o  500.00u   40.00   18.00\n  o  800.00u   40.00   18.00\n"
    "BO\n  u  500.20u   40.00   18.00\n  u  800.40u   40.00   18.00\nEN\n",
)
#: Its reader warns, and it can be made all the same.
WARNED = (SAMPLES / "dstv" / "channel.nc1").read_text().replace("     15.000\n", "0.000\n", 1)

#: Each command on the input `{i}`, or on a program of it; what it makes lies in `out`.
CALLS = {
    "post": "post job/{i} -o out/{i}{suffix} -v",
    "plan": "plan job/{i} -v",
    "inspect": "inspect job/{i} -v",
    "convert": "convert job/{i} -o - --to dstv -v",
    "verify": "verify job/{i}.gcode --against job/{i} -v",
    "diff": "diff job/{i}.gcode job/{i}.gcode -v",
    "diff parts": "diff job/{i} job/{i} -v",
    "simulate": "simulate job/{i}.gcode -o - -v",
    "check": "check job/beamline --samples job -v",
    "batch": "batch job/{i} -o out -v --force --report r.json",
    "watch": "watch job -o out -v --once --settle 0",
}
MAKING = ("post", "batch", "watch")


class Case(Struct, frozen=True):
    """One key: its value beside the job and by --config, the option, and what tells each."""

    beside: str
    config: str
    option: str  #: "" where there is none
    marks: tuple[str, str, str, str]  #: of the default, and of the three; "" is told by nothing
    commands: tuple[str, ...]
    input: str = "g.nc1"


CASES = {
    "machine": Case(
        'machine = "m-one.toml"', 'machine = "m-two.toml"', "--machine job/m-three.toml",
        ("", "m-one", "m-two", "m-three"),
        ("post", "plan", "verify", "diff", "simulate", "check"),
    ),
    "machines": Case(
        'machines.sheet = "plate-codesys"', 'machines.sheet = "m-tap.toml"',
        "--machine plate-linuxcnc",
        ("<d.ngc>", "<d.gcode>", "<d.tap>", "<d.ngc>"), ("batch", "watch"), "d.dxf",
    ),
    "stock_lengths": Case(
        "stock_lengths = [100, 7001]", "stock_lengths = [8002, 9000]", "--bar 9003",
        ("", " 4976.960", " 5977.960", " 6978.960"), ("plan", *MAKING),
    ),
    "job": Case(
        'job = "JOB-ONE"', 'job = "JOB-TWO"', "--job JOB-THREE",
        ("% JOB\n", "% JOB-ONE\n", "% JOB-TWO\n", "% JOB-THREE\n"), MAKING,
    ),
    "name": Case(
        'name = "one{suffix}"', 'name = "two{suffix}"', "--name three{suffix}",
        ("<g.gcode>", "<one.gcode>", "<two.gcode>", "<three.gcode>"), ("batch", "watch"),
    ),
    "quantity": Case(
        "quantity = 2", 'quantity = 3', "--quantity 4",
        (" 5 read", " 10 read", " 15 read", " 20 read"), MAKING,
    ),
    "tolerances": Case(
        "tolerances.merge = 0.3", "tolerances.merge = 0.5", "",
        ("read = 5 made", "1 merged", "2 merged", ""), ("post", "plan", "batch", "watch"),
    ),
    "sheet": Case(
        "sheet.thickness = 2", "sheet.thickness = 3", "--thickness 4",
        ("is 6 mm", "is 2 mm", "is 3 mm", "is 4 mm"), MAKING, "d.dxf",
    ),
    "map": Case(
        'map.ETCH = "ignore"', 'map.CUT = "ignore"', "--map CUT=mark --map ETCH=mark",
        ("7 made", "1 map-ignore", "6 map-ignore", "8 made"), MAKING, "d.dxf",
    ),
}  # fmt: skip

#: Keys that decide whether there is a result: the input that is refused and taken, its value that
#: takes it and that refuses it, and the options for both.
REFUSALS = {
    "allow_skips": ("bad.nc1", '["tool"]', "[]", "--allow-skips tool", "--allow-skips none",
                    ("post", "plan", "verify", "check", *MAKING[1:])),
    "strict": ("w.nc1", "false", "true", "--no-strict", "--strict",
               ("post", "plan", "inspect", "convert", "verify", "diff parts", "check",
                *MAKING[1:])),
}  # fmt: skip


@pytest.fixture
def shop(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a job that has every input, and no configuration yet."""
    job = tmp_path / "job"
    job.mkdir()
    (tmp_path / "out").mkdir()
    monkeypatch.chdir(tmp_path)
    for name in ("m-one", "m-two", "m-three"):
        (job / f"{name}.toml").write_text('base = "beamline"\n')
    (job / "m-tap.toml").write_text('base = "plate-linuxcnc"\nsuffix = ".tap"\n')
    return tmp_path


def put(name: str) -> None:
    """Lay the input of that name into the job, and a program of it."""
    path = Path("job", name)
    if name == "d.dxf":
        path.write_bytes((SAMPLES / "dxf" / "plate.dxf").read_bytes())
        return
    path.write_text({"g.nc1": PAIRS, "bad.nc1": BAD, "w.nc1": WARNED}[name])
    Path("job", "beamline").mkdir()
    for target in (f"job/{name}.gcode", f"job/beamline/{path.stem}.gcode"):
        skips = " --allow-skips tool" if name == "bad.nc1" else ""
        call(f"post job/{name} -o {target}{skips}")


def call(line: str) -> tuple[int, str]:
    """The status of a call, and all that it prints and writes into `out`."""
    shutil.rmtree("out")
    Path("out").mkdir()
    done = CliRunner().invoke(main, shlex.split(line))
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    files = (f"<{p.name}>\n{p.read_text()}" for p in sorted(Path("out").iterdir()) if p.is_file())
    return done.exit_code, done.output + "\n" + "".join(files)


def line_of(command: str, name: str) -> str:
    suffix = ".ngc" if name == "d.dxf" else ".gcode"
    return CALLS[command].format(i=name, suffix=suffix) + " --trust job"


def configure(command: str, text: str) -> None:
    """Write the configuration beside the job, which of a check is the folder of programs."""
    folder = Path("job", "beamline") if command == "check" else Path("job")
    (folder / "beamcam.toml").write_text(text.replace('"m-', '"../m-' if command == "check"
                                                      else '"m-'))  # fmt: skip


@pytest.mark.parametrize(
    ("key", "command"),
    sampled([(key, command) for key, case in CASES.items() for command in case.commands], 2),
)
def test_each_place_goes_over_the_next(shop: Path, key: str, command: str) -> None:
    case = CASES[key]
    put(case.input)
    line = line_of(command, case.input)

    def told(more: str = "") -> set[str]:
        text = call(f"{line} {more}")[1]
        return {mark for mark in case.marks if mark and mark in text}

    default, beside, config, option = ({mark} - {""} for mark in case.marks)
    assert told() == default
    configure(command, case.beside)
    assert told() == beside
    Path("job", "shop.toml").write_text(case.config)
    assert told("--config job/shop.toml") == config
    if case.option:
        assert told(f"--config job/shop.toml {case.option}") == option
        assert told(case.option) == option


@pytest.mark.parametrize(
    ("key", "command"), sampled([(key, c) for key, row in REFUSALS.items() for c in row[-1]], 2)
)
def test_what_is_refused_is_settled_the_same_way(shop: Path, key: str, command: str) -> None:
    name, takes, refuses, taking, refusing, _ = REFUSALS[key]
    put(name)
    line = line_of(command, name)
    default = call(line)[0]
    # A program that leaves something out says so itself, which `verify` takes.
    assert default == (1 if key == "allow_skips" and command != "verify" else 0)
    for beside, config, option, status in (
        (takes, None, "", 0), (refuses, None, "", 1), (refuses, takes, "", 0),
        (takes, refuses, "", 1), (refuses, None, taking, 0), (takes, None, refusing, 1),
        (refuses, refuses, taking, 0), (takes, takes, refusing, 1),
    ):  # fmt: skip
        configure(command, f"{key} = {beside}\n")
        if config is not None:
            Path("job", "shop.toml").write_text(f"{key} = {config}\n")
            option += " --config job/shop.toml"
        found = call(f"{line} {option}")
        assert found[0] == status, f"{beside} {config} {option}\n{found[1]}"


@pytest.mark.parametrize("command", ["batch", "watch"])
def test_flat_and_jobs(shop: Path, command: str, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []

    def processes(made: BatchSettings, count: int) -> Here:
        asked.append(count)
        return Here(made)

    monkeypatch.setattr("beamcam.batch.pool.Processes", processes)
    for folder in "AB":
        Path("job", folder).mkdir()
        for k in range(4):
            Path("job", folder, f"{folder}{k}.nc1").write_text(part(f"{folder}{k}"))
    line = f"{command} job -o made -v --trust job" + (
        " --once --settle 0" if command == "watch" else ""
    )
    configure(command, "flat = true\njobs = 2\n")
    assert "posted A0.gcode" in call(line)[1]
    Path("job", "shop.toml").write_text("flat = false\njobs = 3\n")
    assert "posted A/A0.gcode" in call(f"{line} --config job/shop.toml")[1]
    assert "posted A0.gcode" in call(f"{line} --config job/shop.toml --flat --jobs 4 --job J")[1]
    assert "posted A/A0.gcode" in call(f"{line} --tree --job K")[1]
    assert asked == [2, 3, 4, 2]


def test_every_key_is_tried() -> None:
    # test_batch, test_batch_cluster, test_budget, test_trust, test_machine_choice,
    # test_batch_machines, unit/coping/test_box_tubes, unit/readers/dstv/test_ends
    elsewhere = {"flat", "jobs", "dask", "limits", "trust", "by", "split", "corner", "lip", "ends"}
    assert {*CASES, *REFUSALS, *elsewhere} == set(ConfigFile.__struct_fields__)


@pytest.mark.parametrize("command", CALLS)
def test_an_unknown_key_stops_every_command(shop: Path, command: str) -> None:
    put("g.nc1")
    configure(command, "# of the shop\nmachin = 'x'\n")
    status, text = call(line_of(command, "g.nc1"))
    assert status == 1
    assert "beamcam.toml:2: error config-key: found unknown key 'machin'" in text
    assert not list(Path("out").iterdir())


@pytest.mark.parametrize("command", CALLS)
def test_a_configuration_that_is_not_there(shop: Path, command: str) -> None:
    put("g.nc1")
    status, text = call(f"{line_of(command, 'g.nc1')} --config none.toml")
    assert status == 1
    assert "none.toml: error config-file: found no configuration that can be read (No such" in text


def test_inputs_beside_two_configurations(shop: Path) -> None:
    put("g.nc1")
    Path("two").mkdir()
    Path("two", "h.nc1").write_text(part("H"))
    for folder in ("job", "two"):
        Path(folder, "beamcam.toml").write_text("")
    for line in ("post job/g.nc1 two/h.nc1 -o out/a.gcode", "batch job two -o out"):
        status, text = call(line)
        assert status == 1
        assert (
            "two/beamcam.toml: error config-two: found job/beamcam.toml beside another input"
            in text
        )
        assert call(f"{line} --config job/beamcam.toml")[0] == 0


@pytest.mark.parametrize("command", ["batch", "watch --once --settle 0"])
def test_a_configuration_below_the_inputs_is_pointed_out(shop: Path, command: str) -> None:
    put("g.nc1")
    configure(command, "")
    Path("job", "beamline", "beamcam.toml").write_text('job = "OTHER"\n')
    _, text = call(f"{command} job -o out")
    assert text.count("warning config-unused") == 1
    assert "job/beamline/beamcam.toml: warning config-unused: found a configuration in a" in text
    assert "OTHER" not in text


def test_options_for_sheets_ask_for_a_torch(shop: Path) -> None:
    """Of a machine without one; of the map of a configuration nothing is asked."""
    put("g.nc1")
    configure("post", 'map.red = "cut"\nsheet.kerf = 1\n')
    assert call("post job/g.nc1 -o out/a.gcode")[0] == 0
    status, text = call("post job/g.nc1 -o out/a.gcode --kerf 2")
    assert status == 1
    assert "error plan-sheet-option: " in text
    assert "beamline has no torch" in text
    configure("post", 'sheet.kerf_by = "machine"\n')
    put_drawing = "post job/d.dxf -o out/a.nc --machine laser-grbl --thickness 3"
    put("d.dxf")
    assert (
        "laser-grbl has no words to keep beside a contour" in call(f"{put_drawing} --trust job")[1]
    )


def test_one_program_by_post_and_by_batch(shop: Path) -> None:
    """Drawings are read, mapped and cut alike."""
    put("d.dxf")
    how = "--map ETCH=ignore --thickness 3 --kerf 0 --lead none --units cm"
    post = call(f"post job/d.dxf -o out/d.ngc {how}")[1]
    assert "G01" in post or "G1" in post
    assert (
        post.partition("<d.ngc>")[2]
        == call(f"batch job/d.dxf -o out {how}")[1].partition("<d.ngc>")[2]
    )


def test_names_of_step_tables_have_their_suffix(shop: Path) -> None:
    put("d.dxf")
    line = "batch job/d.dxf -o made --machine laser-stepper --thickness 3 --name"
    status, text = call(f"{line} '{{stem}}.csv'")
    assert status == 2
    assert "expected them to end with .steps" in " ".join(text.split())
    assert call(f"{line} '{{stem}}{{suffix}}' --material acrylic")[0] == 0
