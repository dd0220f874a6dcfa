"""Machines of one's own: a file to start from, and how they are known by name."""

import json
import re
from pathlib import Path

import pytest

from beamcam.arguments import load_machine
from beamcam.errors import MachineError
from beamcam.machine import load, shipped
from beamcam.machine.keys import machine_keys, starting_file
from beamcam.machine.load import files_of_machine, machine_folders, merged, own_machines, resolved
from beamcam.machine.machine import DEFAULT_MACHINE, DEFAULTS, default_machines, is_of_sheets
from beamcam.machine.words import WORD_NAMES
from beamcam.readers import is_of_programs
from tests.conftest import ROOT, SAMPLES, sampled
from tests.runs import batch, call, counts, fill

TOOL_WORDS = {"drill", "tap", "countersink", "punch"} | {
    kind + end for kind in ("mill", "scribe") for end in ("", "_to", "_end")
}
PROSE = re.compile(r"^##.*$", re.MULTILINE)
COMMENTED = re.compile(r"^# ", re.MULTILINE)


def table(machine: str) -> dict[str, object]:
    """What a machine's file and its bases say, but for what tells them apart."""
    found = merged(files_of_machine(machine))[0]
    return {
        key: found[key] for key in found if key not in ("name", "title", "default_for", "choice")
    }


@pytest.mark.parametrize("base", sampled(shipped(), 2))
def test_a_new_file_says_what_its_base_says(base: str, tmp_path: Path) -> None:
    """As it is written, and with all comments taken off and no base below it."""
    text = starting_file("mine", base)
    (tmp_path / "mine.toml").write_text(text, encoding="utf-8")
    (tmp_path / "all.toml").write_text(
        COMMENTED.sub("", PROSE.sub("", text)).replace(f'base = "{base}"\n', ""), encoding="utf-8"
    )
    for name in ("mine", "all"):
        assert table(str(tmp_path / f"{name}.toml")) == table(base)
        assert load(str(tmp_path / f"{name}.toml")).controller == load(base).controller


@pytest.fixture
def shop(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A shop with a configuration and a folder of jobs, and a user with settings of their own."""
    (tmp_path / "shop" / "jobs").mkdir(parents=True)
    (tmp_path / "shop" / "beamcam.toml").write_text("jobs = 1\n")
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "user"))
    monkeypatch.setenv("APPDATA", str(tmp_path / "user"))
    monkeypatch.chdir(tmp_path / "shop" / "jobs")
    return tmp_path


def test_new_writes_a_machine_that_is_known_by_name(shop: Path) -> None:
    done = call("machines", "new", "hall-2", "--base", "beamline-annex", status=0)
    path = shop / "shop" / "machines" / "hall-2.toml"
    first, *held_up = done.stdout.splitlines()
    assert first == f"{path}: change what differs, then `beamcam machines check hall-2`:"
    assert [line.split(",")[0] for line in held_up] == ["left flange", "web", "right flange"]
    assert "hall-2 " in call("machines", "list").stdout
    shown = call("machines", "show", "hall-2")
    assert f"# {path}:" in shown.stdout
    fill(Path("in"), 1)
    path.write_text(path.read_text().replace("[saw]\n", "[saw]\nkerf = 3.2\n"))
    assert counts(batch("in", "-o", "out", "--machine", "hall-2")) == (1, 0, 0, 0)
    (shop / "shop" / "beamcam.toml").write_text('machine = "hall-2"\n')
    assert counts(batch("in", "-o", "out")) == (0, 1, 0, 0)
    assert call("check", "out").stdout == "1 of 1 programs are the same\n"
    assert call("post", "in/P000.nc1", "-o", "-").stdout == Path("out/P000.gcode").read_text()


@pytest.mark.parametrize("name", sampled(shipped(), 5))
def test_show_prints_keys_only_and_the_checksum_last(name: str) -> None:
    rows = list(json.loads(call("machines", "show", name, "--json").stdout))
    keys = [key.name for key in machine_keys()]
    named = tuple(f"{key.name}." for key in machine_keys() if key.kind.startswith("table"))
    for row in rows[:-1]:
        key = re.sub(r"\.\d+(?=\.|$)", "[]", row)
        empty = any(other.startswith(f"{key}[].") for other in keys)  # a list without tables
        assert key in keys or key.startswith(named) or empty, row
    assert rows[-1] == "checksum"
    assert call("machines", "show", name).stdout.endswith("  # in the heads of its programs\n")


def test_new_writes_over_nothing(shop: Path) -> None:
    assert call("machines", "new", "mine").exit_code == 0
    done = call("machines", "new", "mine", status=2)
    assert "is there already; expected a name that is free" in done.stderr
    for name in ("beamline", "two words", "../x", ""):
        done = call("machines", "new", name, status=2)
        assert "for the machine's name; expected letters" in done.stderr
    done = call("machines", "new", "other", "--base", "beamlin", status=1)
    assert "error machine-unknown: found no machine 'beamlin'; expected 'beamline'" in done.stderr


def test_a_machine_of_the_user_is_known_in_every_folder(
    shop: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert call("machines", "new", "mine", "--user").exit_code == 0
    assert (shop / "user" / "beamcam" / "machines" / "mine.toml").is_file()
    monkeypatch.chdir(shop)
    assert "mine " in call("machines", "list").stdout
    assert own_machines(()) == {"mine": str(Path(machine_folders(())[-1], "mine.toml"))}


def test_the_nearest_of_two_counts(shop: Path) -> None:
    for folder in machine_folders([str(shop / "shop" / "beamcam.toml")]):
        Path(folder).mkdir(parents=True)
        Path(folder, "mine.toml").write_text('base = "beamline"\n')
    config = [str(shop / "shop" / "beamcam.toml")]
    assert resolved("mine", config) == str(shop / "shop" / "machines" / "mine.toml")
    assert resolved("mine", ()) == str(Path("machines", "mine.toml"))
    assert resolved("other", config) == "other"
    assert resolved("./mine.toml", config) == "./mine.toml"


def test_a_name_of_a_shipped_machine_is_refused(shop: Path) -> None:
    Path("machines").mkdir()
    Path("machines/beamline.toml").write_text('base = "beamline-annex"\n')
    with pytest.raises(MachineError, match="machine-name-twice"):
        resolved("beamline", ())
    fill(Path("in"), 1)
    done = call("post", "in/P000.nc1", "-o", "-", "--machine", "beamline", status=1)
    assert (
        "error machine-name-twice: found a machine of your own with the name 'beam" in done.stderr
    )


@pytest.mark.parametrize("name", ["beamline", "Beamline ", "\uff42eamline"])
def test_no_file_of_ones_own_has_the_name_of_a_shipped_machine(shop: Path, name: str) -> None:
    Path("m.toml").write_text(f'base = "beamline"\nname = "{name}"\ndrill.x = 78.56\n', "utf-8")
    with pytest.raises(MachineError) as refused:
        load("m.toml")
    assert [d.code for d in refused.value.diagnostics] == ["machine-name-twice"]
    assert str(refused.value).startswith(f"{Path('m.toml').resolve()}:2: ")
    fill(Path("in"), 1)
    done = call("post", "in/P000.nc1", "-o", "out.gcode", "--machine", "m.toml", status=1)
    assert "machine-name-twice" in done.stderr
    assert not Path("out.gcode").exists()


def test_nor_by_the_name_of_the_file(shop: Path) -> None:
    Path("beamline.toml").write_text('base = "beamline"\n')
    with pytest.raises(MachineError, match="machine-name-twice"):
        load("beamline.toml")
    Path("beamline.toml").write_text('base = "beamline"\nname = "mine"\n')
    assert load("beamline.toml").name == "mine"


def test_a_machine_that_cannot_be_read_is_told_beside_the_list(shop: Path) -> None:
    Path("machines").mkdir()
    Path("machines/bad.toml").write_text('base = "beamline"\nkerf = 3\n')
    done = call("machines", "list", status=1)
    assert "beamline-annex" in done.stdout
    assert "bad.toml:2: error machine-key: found unknown key 'kerf'" in done.stderr


def test_a_base_of_ones_own(shop: Path) -> None:
    assert call("machines", "new", "mine").exit_code == 0
    folder = shop / "shop" / "machines"
    (folder / "night.toml").write_text('base = "mine"\n[saw]\nkerf = 2.5\n')
    assert call("machines", "show", "night").exit_code == 0
    night = load(str(folder / "night.toml"))
    assert night.saw is not None
    assert night.saw.kerf == 2.5


def test_false_takes_a_table_of_the_base_away(shop: Path) -> None:
    Path("mine.toml").write_text('base = "plate-linuxcnc"\ntorch = false\n')
    done = call("machines", "show", "./mine.toml", status=1)
    assert "error machine-missing: found no key 'torch'" in done.stderr


PAGE = (ROOT / "docs" / "my-machine.md").read_text(encoding="utf-8")


def test_the_page_shows_the_file_that_comes_with_the_samples() -> None:
    blocks = re.findall(r"^```toml\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    assert blocks[0] == (SAMPLES / "machines" / "hall-drill.toml").read_text(encoding="utf-8")


def test_every_machine_of_the_page_is_one(tmp_path: Path) -> None:
    blocks = re.findall(r"^```toml\n(# (\S+)\n.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
    named = {name: text for text, name in blocks if name.endswith(".toml")}
    assert set(named) == {
        "saw.toml", "cycles.toml", "pecks.toml", "sheetcam.toml", "codes.toml",
    }  # fmt: skip
    hall = (SAMPLES / "machines" / "hall-drill.toml").read_text(encoding="utf-8")
    (tmp_path / "hall-drill.toml").write_text(hall)
    for name, text in named.items():
        (tmp_path / name).write_text(text)
        is_line = name in ("pecks.toml", "sheetcam.toml")
        controller = load_machine(str(tmp_path / name)).controller
        assert controller == ("linuxcnc" if is_line else "codesys")


def test_the_page_names_every_placeholder_and_where_it_stands() -> None:
    rows = dict(re.findall(r"^\| `\{(\w+)\}` \|.*\| ([^|]*) \|$", PAGE, re.MULTILINE))
    assert set(rows) == {name for names in WORD_NAMES.values() for name in names}
    for name, where in rows.items():
        told = set(re.findall(r"`(\w+)`", where))
        if "tools" in where:
            told |= TOOL_WORDS
        assert told == {word for word, names in WORD_NAMES.items() if name in names}, name


# --- where none is named --------------------------------------------------------------------------


def test_the_table_is_that_of_the_machine_files() -> None:
    places: dict[tuple[str, str], dict[int, str]] = {}
    for machine in map(load, shipped()):
        for suffix in machine.default_for:
            rows = places.setdefault((machine.stock, suffix), {})
            assert machine.choice not in rows, f"two machines have one place for {suffix}"
            rows[machine.choice] = machine.name
    found = {key: tuple(rows[n] for n in sorted(rows)) for key, rows in places.items()}
    assert found == DEFAULTS


def test_a_machine_of_ones_own_is_no_default(tmp_path: Path) -> None:
    """A file does not take over what its base is the default for, nor is it another program."""
    path = tmp_path / "mine.toml"
    path.write_text('base = "plate-linuxcnc"\n')
    mine, base = load(str(path)), load("plate-linuxcnc")
    assert base.default_for
    assert (mine.default_for, mine.choice) == ((), 1)
    assert mine.checksum == base.checksum


@pytest.mark.parametrize(
    ("stock", "output", "name"),
    [
        ("beam", "a.gcode", "beamline"), ("beam", "a.ngc", "beamline"), ("beam", "", "beamline"),
        ("sheet", "A.NGC", "plate-linuxcnc"), ("sheet", "a.nc", "laser-grbl"),
        ("sheet", "a.gcode", "plate-codesys"), ("sheet", "-", "plate-linuxcnc"),
        ("sheet", "x/a.h", "laser-stepper"), ("sheet", "a.st", "table-simotion"),
    ],
)  # fmt: skip
def test_by_stock_and_suffix(stock: str, output: str, name: str) -> None:
    assert default_machines("sheet" if stock == "sheet" else "beam", output)[0] == name


def test_what_a_suffix_tells() -> None:
    assert DEFAULT_MACHINE == "beamline"
    assert is_of_sheets("a.ngc")
    assert not is_of_sheets("a.gcode")  # which bars have too
    assert is_of_programs("a.gcode")
    assert not is_of_programs("a.nc1")
