"""What lies beside a stranger's parts is data: nothing of it runs, and no machine comes with it."""

import json
import re
import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from hashlib import sha256
from pathlib import Path

import pytest

from beamcam.batch.record import RECORD_NAME
from beamcam.config import NOT_FOLLOWED, NOT_REPEATED
from beamcam.config.load import HARMLESS
from beamcam.machine.load import SHIPPED
from tests.runs import BAD, call, fill, part, report

OTHER_DRILL = 'base = "beamline"\nname = "{}"\n[drill]\nx = 999.0\n'


@pytest.fixture
def shop(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of a shop, with a folder `in` that came by mail."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "user"))
    monkeypatch.setenv("APPDATA", str(tmp_path / "user"))
    (tmp_path / "shop").mkdir()
    monkeypatch.chdir(tmp_path / "shop")
    fill(Path("in"), 1)
    return tmp_path / "shop"


def mailed(text: str, folder: str = "in") -> None:
    Path(folder, "beamcam.toml").write_text(text)


@contextmanager
def scheduler() -> Iterator[tuple[str, list[object]]]:
    """A stranger's scheduler on loopback: its address, and who has come."""
    come: list[object] = []
    with socket.create_server(("127.0.0.1", 0)) as server:

        def take() -> None:
            with suppress(OSError):
                while True:
                    caller, address = server.accept()
                    come.append(address)
                    caller.close()

        thread = threading.Thread(target=take, daemon=True)
        thread.start()
        yield f"tcp://127.0.0.1:{server.getsockname()[1]}", come
        with suppress(OSError):
            server.shutdown(socket.SHUT_RDWR)
    thread.join(5)


@pytest.mark.parametrize("command", ["batch", "watch --once --settle 0"])
def test_a_strangers_scheduler_is_never_connected_to(shop: Path, command: str) -> None:
    with scheduler() as (address, come):
        mailed(f'[dask]\nscheduler = "{address}"\nanswer_s = 0.5\n')
        done = call(*command.split(), "in", "-o", "out")
        assert (done.exit_code, come) == (0, [])
        assert Path("out/P000.gcode").is_file()
        said = [line for line in done.stderr.splitlines() if NOT_FOLLOWED.code in line]
        assert len(said) == 1
        assert (
            "in/beamcam.toml:2: warning config-trust: found 'dask.scheduler', 'dask.answer_s' "
            "in a configuration beside the inputs, not followed" in said[0].replace("\\", "/")
        )
        assert said[0].endswith("accept all of it by --trust in")
        if call("batch", "in", "-o", "out", "--force", "--trust", "in").exit_code:
            assert come  # that is a scheduler which would have been found


@pytest.mark.parametrize("name", ["beamline", "annex", "beamline-pusher"])
def test_a_strangers_machine_file_makes_no_program(shop: Path, name: str) -> None:
    call("post", "in/P000.nc1", "-o", "ours.gcode", status=0)
    Path("in/m.toml").write_text(OTHER_DRILL.format(name))
    for line in ('machine = "m.toml"', 'machines.beam = "m.toml"', 'machines.beam = ["m.toml"]'):
        mailed(line)
        done = call("post", "in/P000.nc1", "-o", "theirs.gcode", status=0)
        assert NOT_FOLLOWED.code in done.stderr
        assert Path("theirs.gcode").read_text() == Path("ours.gcode").read_text()
        assert call("batch", "in", "-o", "out", "--force").exit_code == 0
        assert Path("out/P000.gcode").read_text() == Path("ours.gcode").read_text()
        trusted = call("post", "in/P000.nc1", "-o", "trusted.gcode", "--trust", "in")
        shipped = name != "annex"
        assert (trusted.exit_code, "machine-name-twice" in trusted.stderr) == (shipped, shipped)
    assert Path("trusted.gcode").exists() == (name == "annex")


def test_nor_does_verify_pass_a_program_by_it(shop: Path) -> None:
    Path("in/m.toml").write_text(OTHER_DRILL.format("annex"))
    mailed('machine = "m.toml"')
    call("post", "in/P000.nc1", "-o", "in/P000.gcode", "--machine", "in/m.toml")
    assert call("verify", "in/P000.gcode", "--against", "in/P000.nc1").exit_code == 1
    call("verify", "in/P000.gcode", "--against", "in/P000.nc1", "--trust", "in", status=0)


def test_machines_beside_it_are_not_known_by_name(shop: Path) -> None:
    Path("in/machines").mkdir()
    Path("in/machines/hall.toml").write_text('base = "beamline"\n')
    mailed("jobs = 1\n")
    done = call("post", "in/P000.nc1", "-o", "-", "--machine", "hall")
    assert "machine-unknown" in done.stderr
    assert call("post", "in/P000.nc1", "-o", "-", "--machine", "hall", "--trust", "in").stdout


def test_it_does_not_take_the_shops_own_away(shop: Path) -> None:
    """By key, the nearest of those that may say it."""
    Path("beamcam.toml").write_text('strict = true\njob = "SHOP"\nquantity = 2\n')
    users = shop.parent / "user" / "beamcam"
    users.mkdir(parents=True)
    (users / "beamcam.toml").write_text('job = "MINE"\n[sheet]\nkerf = 1.5\nthickness = 4\n')
    mailed("strict = false\nquantity = 3\n[sheet]\nthickness = 6\nkerf = 9\n")
    rows = json.loads(call("config", "in", "--json").stdout)
    found = {key: rows[key] for key in ("strict", "job", "quantity", "sheet.thickness")}
    assert found == {
        "strict": {"value": True, "source": "beamcam.toml:1"},
        "job": {"value": "SHOP", "source": "beamcam.toml:2"},
        "quantity": {"value": 3, "source": f"{Path('in/beamcam.toml')}:2"},
        "sheet.thickness": {"value": 6.0, "source": f"{Path('in/beamcam.toml')}:4"},
    }
    assert rows["sheet.kerf"]["value"] == 1.5
    said = call("config", "in").stderr
    assert "found 'strict', 'sheet.kerf' in" in said


def test_nearer_machines_go_over_farther_ones(shop: Path) -> None:
    Path("beamcam.toml").write_text('[machines]\nbeam = "beamline-annex"\nsheet = "laser-grbl"\n')
    mailed('machine = "beamline"\n')
    rows = json.loads(call("config", "in", "--json", "--trust", "in").stdout)
    assert rows["machine"]["value"] == "beamline"
    assert "machines.beam" not in rows
    mailed('[machines]\nbeam = "beamline-pusher"\n')
    rows = json.loads(call("config", "in", "--json", "--trust", ".").stdout)
    assert rows["machines.beam"]["value"] == "beamline-pusher"
    assert rows["machines.sheet"]["value"] == "laser-grbl"


def test_what_is_harmless_is_followed_without_a_word(shop: Path) -> None:
    text = (
        'name = "{mark}{suffix}"\njob = "J"\nquantity = 2\n'
        '[map]\nred = "cut"\n[sheet]\nthickness = 3\nmaterial = "S235"\n'
    )
    mailed(text)
    done = call("config", "in", "--json")
    assert done.stderr == ""
    rows = json.loads(done.stdout)
    followed = {key for key, row in rows.items() if row["source"]}
    assert {key.replace("map.red", "map") for key in followed} == set(HARMLESS)
    mailed('[map]\nred = "cut"\n[map.blue]\nprocess = "mark"\npower = 100\n')
    done = call("config", "in")
    assert "in/beamcam.toml:4" not in done.stderr
    assert "found 'map.blue.power' in a configuration" in done.stderr
    assert 'map.blue = "mark"' in done.stdout


def test_skips_of_a_stranger_leave_nothing_out(shop: Path) -> None:
    Path("in/bad.nc1").write_text(BAD)
    mailed('allow_skips = ["all"]\nflat = true\ntolerances.merge = 1.0\ntrust = ["."]\n')
    call("batch", "in", "-o", "out", "--report", "r.json", status=1)
    rows = {row["file"]: row["status"] for row in report(Path("r.json"))["files"]}
    assert rows == {str(Path("in/P000.nc1")): "posted", str(Path("in/bad.nc1")): "refused"}
    (said,) = [m for m in report(Path("r.json"))["messages"] if m["code"] == NOT_FOLLOWED.code]
    keys = re.findall(r"'(\S+)'", said["message"].partition(" in a conf")[0])
    assert keys == ["allow_skips", "flat", "trust", "tolerances.merge"]


def test_a_folder_is_trusted_for_good_only_by_ones_own_file(shop: Path) -> None:
    mailed("strict = true\n")
    done = call("config", "in", "--trust", "in", "--remember")
    own = shop.parent / "user" / "beamcam" / "beamcam.toml"
    assert done.exit_code == 0, done.output
    assert f"# {Path('in', 'beamcam.toml')}:1" in done.stdout
    assert NOT_FOLLOWED.code not in call("post", "in/P000.nc1", "-o", "-").stderr
    fill(Path("two"), 1)
    mailed("strict = true\n", "two")
    assert NOT_FOLLOWED.code in call("post", "two/P000.nc1", "-o", "-").stderr
    own.write_text(f'# mine\n{own.read_text()}job = "ME"\n\n[sheet]\nkerf = 1\n')
    for _ in range(2):
        assert call("config", "--trust", "two", "--remember").exit_code == 0
    text = own.read_text()
    assert text.count("trust = ") == 1
    assert text.startswith("# mine\n")
    assert text.endswith('job = "ME"\n\n[sheet]\nkerf = 1\n')
    rows = json.loads(call("config", "--json").stdout)
    assert rows["trust"]["value"] == [str(shop / "in"), str(shop / "two")]
    assert NOT_FOLLOWED.code not in call("post", "two/P000.nc1", "-o", "-").stderr


def test_a_remembered_folder_has_to_be_there(shop: Path) -> None:
    assert call("config", "--trust", "none", "--remember").exit_code == 2
    assert call("config", "--remember").exit_code == 2


def test_the_record_of_a_strangers_folder_chooses_no_machine(shop: Path) -> None:
    """A folder of programs with its record, as a batch of the stranger's made it."""
    their = Path("theirs")
    their.mkdir()
    (their / "m.toml").write_text(OTHER_DRILL.format("annex"))
    assert call("batch", "in", "-o", their, "--machine", their / "m.toml").exit_code == 0
    refused = call("check", their)
    assert (refused.exit_code, NOT_REPEATED.code in refused.output) == (1, True)
    assert call("check", their, "--trust", their).exit_code == 0
    (their / RECORD_NAME).unlink()
    (their / "shop.toml").write_text('machine = "m.toml"\n')
    assert call("batch", "in", "-o", their, "--config", their / "shop.toml").exit_code == 0
    refused = call("check", their)
    assert (refused.exit_code, NOT_REPEATED.code in refused.output) == (1, True)
    assert call("check", their, "--config", their / "shop.toml").exit_code == 0
    record = (their / RECORD_NAME).read_text()
    more = '"asked":{"config_file":"theirs/shop.toml","trust":["."]}'
    for cheat in (record, record.replace('"own":["shop.toml"]', '"own":[]')):
        cheated = cheat.replace('"asked":{}', more)
        assert more in cheated
        (their / RECORD_NAME).write_text(cheated)
        checked = call("check", their)
        assert (checked.exit_code, "1 of 1" in checked.stdout) == (1, False)


def test_a_record_repeats_what_was_followed(shop: Path) -> None:
    mailed('machine = "none.toml"\njob = "THEIRS"\n')
    assert call("batch", "in", "-o", "out").exit_code == 0
    assert Path("out/P000.gcode").read_text().startswith("% THEIRS\n")
    assert "1 of 1 programs are the same" in call("check", "out").stdout


def test_a_link_to_ones_own_file_brings_no_machine(shop: Path) -> None:
    Path("beamcam.toml").write_text('machine = "hall"\n')
    Path("machines").mkdir()
    Path("machines/hall.toml").write_text('base = "beamline"\nsuffix = ".ours"\n')
    Path("in/machines").mkdir()
    Path("in/machines/hall.toml").write_text('base = "beamline"\nsuffix = ".theirs"\n')
    try:
        Path("in/beamcam.toml").symlink_to(Path("beamcam.toml").resolve())
    except OSError:
        pytest.skip("no links here")
    assert call("batch", "in", "-o", "out").exit_code == 0
    assert Path("out/P000.ours").is_file()
    assert call("batch", "in", "-o", "out2", "--trust", "in").exit_code == 0
    assert Path("out2/P000.ours").is_file()


def test_standard_input_lies_here(shop: Path) -> None:
    Path("beamcam.toml").write_text('job = "HERE"\n')
    done = call("post", "-", "-o", "-", stdin=part("A"))
    assert done.stdout.startswith("% HERE\n")


def sha(path: Path | str) -> str:
    return sha256(Path(path).read_bytes()).hexdigest()[:12]


def test_every_run_says_whose_settings_it_uses(shop: Path) -> None:
    """Under -v, by `config`, in reports and in JSON, the same line."""
    Path("beamcam.toml").write_text('[machines]\nbeam = "hall"\n')
    Path("machines").mkdir()
    Path("machines/hall.toml").write_text('base = "beamline"\n')
    mailed('job = "THEIRS"\nstrict = true\n')
    base = sha(SHIPPED / "beamline.toml")
    hall = Path("machines", "hall.toml")
    line = (
        f"configuration {Path('in', 'beamcam.toml')} (beside the inputs, harmless keys only), "
        f"beamcam.toml (here or above); machine hall ({hall.resolve()}, sha256 {sha(hall)} over "
        f"beamline.toml as shipped, sha256 {base})"
    )
    for words in ("post in/P000.nc1 -o p.gcode", "plan in/P000.nc1 -o plan.txt",
                  "verify p.gcode --against in/P000.nc1", "simulate p.gcode -o s.csv",
                  "report in/P000.nc1 -o r.html", "batch in -o out --report r.json",
                  "watch in -o out --once --settle 0", "list in -o l.csv"):  # fmt: skip
        done = call(*words.split(), "-v", status=0)
        if not words.startswith("list"):  # of no machine
            shown = line if "in" in words.replace("/", " ").split() else line.partition("; ")[2]
            assert done.stderr.count(f"{shown} (") == 1, words  # and the time
    assert line in call("config", "in").stdout
    assert line in json.loads(call("config", "in", "--json").stdout)["settings"]["value"]
    assert json.loads(call("plan", "in/P000.nc1", "--json").stdout)["settings"] == line
    assert any(line in m["message"] for m in report(Path("r.json"))["messages"])
    page = Path("r.html").read_text(encoding="utf-8")
    assert f"sha256 {sha(hall)}" in page
    assert "harmless keys only" in page


def test_a_machine_file_of_nobody_is_said(shop: Path) -> None:
    """On standard error, of each program that it makes."""
    text = 'base = "beamline"\n'
    Path("mine.toml").write_text(text)
    users = shop.parent / "user" / "beamcam" / "machines"
    users.mkdir(parents=True)
    (users / "own.toml").write_text(text)
    for words in ("post in/P000.nc1 -o p.gcode", "batch in -o out", "plan in/P000.nc1 -o -",
                  "verify p.gcode --against in/P000.nc1"):  # fmt: skip
        for machine, told in (("mine.toml", 1), ("own", 0), ("beamline", 0)):
            done = call(*words.split(), "--machine", machine)
            assert done.stderr.count("note machine-elsewhere: found the machine mine (") == told
            if told:
                assert f"sha256 {sha('mine.toml')} over beamline.toml as shipped" in done.stderr
    quiet = call("post", "in/P000.nc1", "-o", "p.gcode", "--machine", "mine.toml", "-q")
    assert quiet.stderr == ""
