"""`beamcam.toml` and `beamcam config`."""

import json
import os
from pathlib import Path

import pytest
from click.testing import Result

from beamcam import system
from beamcam.config import values
from beamcam.config.load import ConfigError, load, with_tolerances
from beamcam.config.values import Config, ConfigFile, ConfigFiles, config_files, over
from beamcam.machine import load as load_machine
from beamcam.machine.torch import LayerSettings
from beamcam.system import is_windows
from tests.runs import batch, call, counts, fill, part, report

ALL = """# the shop
machine = "beamline-annex"
machines = { sheet = "plate-codesys" }
stock_lengths = [12000, 6000.5]
allow_skips = ["cope"]
strict = true
job = "NIGHT"
jobs = 2
name = "{mark}{suffix}"
flat = true
quantity = "file"
trust = ["/jobs"]

[tolerances]
merge = 0.25

[sheet]
thickness = 3
lead = "arc"

[dask]
scheduler = "tcp://hall:8786"
answer_s = 3.5

[limits]
pieces = 500

[map]
"#F00" = "cut"
ENGRAVE = "engrave"
"""


def run(*args: object) -> Result:
    return call("config", *args)


def write(folder: Path, text: str) -> Path:
    path = folder / "beamcam.toml"
    path.write_text(text)
    return path


def test_every_key_is_read_and_knows_its_line(tmp_path: Path) -> None:
    config = load(write(tmp_path, ALL))
    assert config.machine == "beamline-annex"
    assert config.stock_lengths == (6000.5, 12000.0)
    assert config.tolerances.given() == {"merge": 0.25}
    assert config.map == {"#F00": "cut", "ENGRAVE": "engrave"}
    where = {row.key: row.source and row.source.line for row in config.settings()}
    assert where == {
        "machine": 2, "machines.sheet": 3, "stock_lengths": 4, "allow_skips": 5, "strict": 6,
        "job": 7, "jobs": 8, "name": 9, "flat": 10, "quantity": 11,
        "trust": 12, "tolerances.merge": 15, "sheet.thickness": 18, "sheet.lead": 19,
        "dask.scheduler": 22, "dask.answer_s": 23, "limits.pieces": 26, "limits.features": None,
        "by": None, "split": None, "corner": None, "lip": None, "ends": None,
        "limits.bytes": None, "limits.depth": None, "limits.member_s": None, "map.#F00": 29,
        "map.ENGRAVE": 30,
    }  # fmt: skip


def test_defaults_come_from_nowhere() -> None:
    assert all(row.source is None for row in Config().settings())


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("machin = 'x'", "beamcam.toml:1: error config-key: found unknown key 'machin'; expected"
         " 'machine'"),
        ("[tolerances]\nmerg = 1", ":2: error config-key: found unknown key 'tolerances.merg';"
         " expected 'merge'"),
        ("machine = 3", ":1: error config-value: found 3 for 'machine'; expected a text"),
        ("strict = 1", "found 1 for 'strict'; expected true or false"),
        ("jobs = 0", "found 0 for 'jobs'; expected 1 or more"),
        ("stock_lengths = 6000", "found 6000 for 'stock_lengths'; expected a list of numbers"),
        ("stock_lengths = [0]", "found 0 for 'stock_lengths.0'; expected more than 0"),
        ("allow_skips = 'cope'", "expected a list of texts"),
        ("allow_skips = ['any']", "error config-value: found 'any' for 'allow_skips'; expected"
         " names of"),
        ("name = '{marc}'", "config-value: found '{marc}' for 'name'; expected one of {stem}"),
        ("name = '{stem'", "config-value: found '{stem' for 'name'; expected a template"),
        ('job = "a\\tb"', ":1: error config-value: found 'a\\tb' for 'job'; expected one line of"),
        ("tolerances = 1", "found 1 for 'tolerances'; expected a table"),
        ("[tolerances]\nmerge = -1", ":2: error config-value: found -1 for 'tolerances.merge';"
         " expected 0 mm or more"),
        ("[map]\nred = 'burn'", "expected one of 'cut', 'mark', 'engrave', 'ignore'"),
        ("[map.red]\nspeed = 3", "beamcam.toml:1: error config-value: found nothing for "
         "'map.red.process'; expected one of 'cut', 'mark', 'engrave', 'ignore'"),
        ("quantity = 0", "found 0 for 'quantity'; expected one of 'file', or a whole number, 1 or"),
        ("strict = true\n[a.b.c]\nd = 1", ":2: error config-key: found unknown key 'a'"),
        ("[map]\n'#ff' = 'cut'", "expected a colour such as '#ff0000'"),
        ("\nthickness = 3", "beamcam.toml:2: error config-key: found unknown key 'thickness'; "
         "expected it below [sheet], as sheet.thickness"),
        ("a = ", "beamcam.toml:1: error config-toml: found no TOML (Invalid value"),
    ],
)  # fmt: skip
def test_what_is_wrong(tmp_path: Path, text: str, said: str) -> None:
    result = run("--config", write(tmp_path, text))
    assert result.exit_code == 1
    assert said in result.stderr
    assert result.stdout == ""
    result = batch(tmp_path, "-o", tmp_path / "out")  # found beside the job
    assert result.exit_code == 1
    assert said in result.stderr
    assert not (tmp_path / "out").exists()


def test_no_such_file(tmp_path: Path) -> None:
    result = run("--config", tmp_path / "none.toml")
    assert result.exit_code == 1
    assert (
        "error config-file: found no configuration that can be read (No such file" in result.stderr
    )


def test_where_it_is_looked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "jobs").mkdir()
    monkeypatch.chdir(tmp_path)
    assert config_files(("jobs",)) == ConfigFiles()
    write(tmp_path, "")
    here = ("beamcam.toml",)
    assert config_files(("jobs",)) == config_files(("-",)) == ConfigFiles(own=here)
    write(tmp_path / "jobs", "")
    both = ConfigFiles(("jobs/beamcam.toml",), here)
    assert config_files(("jobs",)) == config_files(("jobs/a.nc1", "jobs/b.nc1")) == both
    assert config_files(("jobs/**/*.nc1",)) == both
    assert config_files(("jobs/a.nc1", "x")).two == ("jobs/beamcam.toml", "beamcam.toml")
    assert config_files(("none/a.nc1",)) == config_files(()) == ConfigFiles(own=here)


def test_a_machine_that_is_none_is_told_where_it_is_named(tmp_path: Path) -> None:
    fill(tmp_path / "in", 1)
    path = write(tmp_path, "jobs = 1\nmachine = 'beamlin'\n")
    result = batch(tmp_path / "in", "-o", tmp_path / "out", "--trust", tmp_path, status=1)
    assert result.stderr.startswith(
        f"{path}:2: error config-value: found 'beamlin' for 'machine'; expected 'beamline' or the"
    )
    write(tmp_path, "[machines]\nbeam = 'none.toml'\n")
    result = batch(tmp_path / "in", "-o", tmp_path / "out", "--trust", tmp_path)
    assert f"{path}:2: error config-value: found " in result.stderr
    assert "none.toml' for 'machines.beam'" in result.stderr
    result = batch(tmp_path / "in", "-o", tmp_path / "out", "--machine", "beamlin")
    assert "error machine-unknown" in result.stderr


def test_a_list_of_machines_has_one(tmp_path: Path) -> None:
    path = write(tmp_path, "jobs = 1\n[machines]\nsheet = 'laser-grbl'\nbeam = []\n")
    with pytest.raises(ConfigError) as refused:
        load(path)
    assert str(refused.value) == (
        f"{path}:4: error config-value: found [] for 'machines.beam'; expected a list of 1 or more"
    )
    assert load(write(tmp_path, "[machines]\nbeam = ['beamline']\n")).machine_names("beam")


def test_it_is_found_in_the_folders_above(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    deep = tmp_path / "jobs" / "4711" / "nc"
    deep.mkdir(parents=True)
    above = str(write(tmp_path / "jobs", ""))
    assert config_files((str(deep / "a.nc1"),)) == config_files((str(deep),))
    assert config_files((str(deep),)) == ConfigFiles((above,))
    near = str(write(tmp_path / "jobs" / "4711", ""))
    assert config_files((str(deep),)) == ConfigFiles((near, above))
    monkeypatch.chdir(deep)
    assert config_files(("a.nc1",)) == config_files(("-",)) == config_files(())
    assert config_files(()) == ConfigFiles(own=(near, above))
    assert config_files((str(tmp_path / "x.nc1"),)) == ConfigFiles(own=(near, above))


@pytest.mark.skipif(is_windows(), reason="no such right")
def test_a_folder_above_in_which_anybody_may_write_is_passed_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "open" / "job").mkdir(parents=True)
    path = str(write(tmp_path / "open", ""))
    assert config_files((str(tmp_path / "open" / "job"),)).beside == (path,)
    (tmp_path / "open").chmod(0o777)
    assert config_files((str(tmp_path / "open" / "job"),)) == ConfigFiles()
    assert config_files((str(tmp_path / "open"),)).beside == (path,)  # it is named
    monkeypatch.chdir(tmp_path / "open")
    assert config_files(("a.nc1",)).own == ("beamcam.toml",)
    monkeypatch.setattr("os.getuid", lambda: 12345)
    os.chown(path, 54321, -1) if os.geteuid() == 0 else monkeypatch.setattr(
        values, "is_ones_own", lambda _: False
    )
    assert config_files(("a.nc1",)) == ConfigFiles(("beamcam.toml",))
    assert config_files(("in/a.nc1",)) == ConfigFiles()


@pytest.mark.parametrize("windows", [False, True])
def test_the_users_own_is_the_last(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, windows: bool
) -> None:
    monkeypatch.setattr(system, "is_windows", lambda: windows)
    monkeypatch.setenv("APPDATA" if windows else "XDG_CONFIG_HOME", str(tmp_path / "user"))
    (tmp_path / "user" / "beamcam").mkdir(parents=True)
    (tmp_path / "in").mkdir()
    own = str(write(tmp_path / "user" / "beamcam", "job = 'MINE'\n"))
    assert config_files((str(tmp_path / "in"),)) == ConfigFiles(own=(own,))
    assert 'job = "MINE"' in run(tmp_path / "in").stdout
    near = str(write(tmp_path / "in", ""))
    assert config_files((str(tmp_path / "in"),)) == ConfigFiles((near,), (own,))
    if not windows:
        monkeypatch.setenv("XDG_CONFIG_HOME", "relative")
        monkeypatch.setenv("HOME", str(tmp_path))
        assert system.user_folder() == str(tmp_path / ".config" / "beamcam")


def test_the_command_shows_values_and_origins(tmp_path: Path) -> None:
    path = write(tmp_path, ALL)
    lines = run(tmp_path, "--trust", tmp_path).stdout.splitlines()
    assert any(
        line.startswith('machine = "beamline-annex"') and line.endswith(f"# {path}:2")
        for line in lines
    )
    assert any(line.startswith('map."#F00" = "cut"') for line in lines)
    record = json.loads(run(tmp_path, "--json", "--trust", tmp_path).stdout)
    assert record["job"] == {"value": "NIGHT", "source": f"{path}:7"}
    assert {key.partition(".")[0] for key in record} == {"settings", *ConfigFile.__struct_fields__}
    plain = run("--config", write(tmp_path, "")).stdout
    assert 'job = "JOB"' in plain
    *plain_rows, used = plain.splitlines()
    assert all(line.endswith("# default") for line in plain_rows)
    assert used.startswith("# configuration ")
    assert set(ConfigFile.__struct_fields__) == {
        line.split()[0] for line in run("--keys").stdout.splitlines()
    }


def test_what_is_shown_is_a_configuration(tmp_path: Path) -> None:
    """What `beamcam config` prints, read again, means the same."""
    first = load(write(tmp_path, ALL))
    shown = run(tmp_path, "--trust", tmp_path).stdout
    again = load(write(tmp_path, shown))
    assert [(r.key, r.value) for r in again.settings()] == [
        (r.key, r.value) for r in first.settings()
    ]


def test_the_command_line_goes_over_it(tmp_path: Path) -> None:
    fill(tmp_path / "in", 2)
    write(tmp_path / "in", 'job = "NIGHT"\nmachine = "beamline-annex"\nname = "n{stem}.nc"\n')
    trust = ("--trust", tmp_path)
    batch(tmp_path / "in", "-o", tmp_path / "1", *trust)
    batch(tmp_path / "in", "-o", tmp_path / "2", *trust, "--job", "DAY", "--machine", "beamline",
          "--name", "{stem}.x")  # fmt: skip
    assert (tmp_path / "1" / "nP000.nc").read_text().startswith("% NIGHT\n")
    assert (tmp_path / "2" / "P000.x").read_text().startswith("% DAY\n")


def test_a_machine_beside_the_configuration(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fill(tmp_path / "in", 1)
    write(tmp_path / "in", 'machine = "mine.toml"\n')
    (tmp_path / "in" / "mine.toml").write_text('base = "beamline"\nsuffix = ".mine"\n')
    monkeypatch.chdir(tmp_path)
    assert counts(batch("in", "-o", "out", "--trust", "in")) == (1, 0, 0, 0)
    assert (tmp_path / "out" / "P000.mine").exists()


def test_tolerances_go_over_the_machine(tmp_path: Path) -> None:
    """Holes of both flanges 0.2 mm apart are one operation only if the tolerance says so."""
    (tmp_path / "in").mkdir()
    text = part("A").replace(
        "EN\n", "BO\n  o  500.00u   40.00   18.00\nBO\n  u  500.20u   40.00   18.00\nEN\n"
    )
    (tmp_path / "in" / "a.nc1").write_text(text)
    merged = []
    for tolerance in (0.1, 0.3):
        write(tmp_path / "in", f"[tolerances]\nmerge = {tolerance}\n")
        said = tmp_path / "r.json"
        result = batch(tmp_path / "in", "-o", tmp_path / "out", "--report", said,
                       "--trust", tmp_path)  # fmt: skip
        assert counts(result) == (1, 0, 0, 0)
        merged.append(report(said)["files"][0]["parts"][0]["ledger"]["merged"])
    assert merged == [0, 1]


def test_tolerances_without_a_drill(tmp_path: Path) -> None:
    """They are for another machine, unless the configuration names none that drills."""
    plate = load_machine("plate-linuxcnc")
    assert with_tolerances(plate, Config()) is plate
    table = "[tolerances]\nmerge = 1\n"
    assert with_tolerances(plate, load(write(tmp_path, table))) is plate
    config = load(write(tmp_path, f'machine = "plate-linuxcnc"\n{table}'))
    with pytest.raises(ConfigError, match=r"3: error config-tolerance: .* plate-linuxcnc has no"):
        with_tolerances(plate, config)
    assert with_tolerances(plate, over(config, {"machine": "plate-linuxcnc"})) is plate


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        ("merge = 1.1", "at most 1 mm"), ("duplicate = 300", "at most 1 mm"),
        ("same_tool = 10", "at most 1 mm"), ("sink = 90", "at most 1 mm"),
        ("path = 5", "at most 1 mm"),
        ("path = 0", "0.001 mm or more"),
    ],
)  # fmt: skip
def test_tolerances_that_no_machine_file_may_have(
    tmp_path: Path, value: str, expected: str
) -> None:
    """By one of 300 mm two holes would be one, with a warning only."""
    with pytest.raises(ConfigError, match=f":2: error config-value: .*; expected {expected}"):
        load(write(tmp_path, f"[tolerances]\n{value}\n"))


def test_a_row_of_the_map_may_be_a_table(tmp_path: Path) -> None:
    file = tmp_path / "beamcam.toml"
    file.write_text('[map]\nblue = "mark"\n[map.red]\nprocess = "cut"\nspeed = 600\npasses = 2\n')
    config = load(file)
    assert config.meanings == {"blue": "mark", "red": "cut"}
    assert config.layer_settings == {"red": LayerSettings(600.0, None, 2)}
    shown = call("config", "--config", file).stdout
    assert 'map.red = { process = "cut", speed = 600.0, passes = 2 }' in shown
    file.write_text("[map.red]\nspeed = 600\n")
    with pytest.raises(ConfigError, match=r"map\.red\.process"):
        load(file)
