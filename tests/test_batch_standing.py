"""What stands in the folder of a batch: links are not followed out of it, edits are not lost."""

import os
from pathlib import Path

import pytest

from beamcam.batch import LINK, NOT_OURS, SAME_NAME, WRITE
from beamcam.batch.record import RECORD_NAME
from beamcam.system import is_windows
from tests.runs import batch, counts, fill, part

pytestmark = pytest.mark.skipif(is_windows(), reason="links and rights are those of POSIX")

WATCH = ("--once", "--settle", "0")


@pytest.fixture
def shop(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "shop").mkdir()
    monkeypatch.chdir(tmp_path / "shop")
    fill(Path("in"), 1)
    Path("out").mkdir()
    return tmp_path / "shop"


def run(*words: object, command: str = "batch") -> tuple[tuple[int, int, int, int], str]:
    more = WATCH if command == "watch" else ()
    done = batch("in", "-o", "out", *words, *more, command=command)
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    return counts(done), done.stderr


@pytest.mark.parametrize("command", ["batch", "watch"])
def test_a_record_that_is_a_link_is_not_added_to(shop: Path, command: str) -> None:
    system = shop.parent / "hosts"
    system.write_text("127.0.0.1 localhost\n")
    Path("out", RECORD_NAME).symlink_to(system)
    done = batch("in", "-o", "out", *(WATCH if command == "watch" else ()), command=command)
    assert (done.exit_code, WRITE.code in done.stderr) == (1, True)
    assert "is a link, or no plain file" in done.stderr
    assert system.read_text() == "127.0.0.1 localhost\n"
    Path("out", RECORD_NAME).unlink()
    Path("out", RECORD_NAME).symlink_to(shop.parent / "new")
    assert batch("in", "-o", "out", "--force").exit_code == 1
    assert not (shop.parent / "new").exists()


def test_a_record_that_another_folder_has_too_is_no_longer_shared(shop: Path) -> None:
    """As after a copy of a folder that is made of links."""
    run()
    os.link(Path("out", RECORD_NAME), shop.parent / "copy")
    before = (shop.parent / "copy").read_bytes()
    fill(Path("in"), 2)
    assert run()[0] == (1, 1, 0, 0)
    assert (shop.parent / "copy").read_bytes() == before
    assert Path("out", RECORD_NAME).read_bytes() != before


@pytest.mark.parametrize("force", [(), ("--force",)])
def test_outputs_stay_in_their_folder(shop: Path, force: tuple[str, ...]) -> None:
    outside = shop.parent / "outside"
    outside.mkdir()
    (outside / "passwd").write_text("root\n")
    Path("out/P000.gcode").symlink_to(outside / "passwd")
    found, said = run(*force)
    assert (found, LINK.code in said) == ((0, 0, 1, 0), True)
    assert str(outside / "passwd") in said
    Path("out/P000.gcode").unlink()
    Path("out/P000.gcode").symlink_to(outside / "new")
    assert run(*force)[0] == (0, 0, 1, 0)
    Path("out/P000.gcode").unlink()
    Path("in/A").mkdir()
    Path("in/P000.nc1").rename("in/A/P000.nc1")
    Path("out/A").symlink_to(outside)
    found, said = run(*force)
    assert (found, LINK.code in said) == ((0, 0, 1, 0), True)
    assert sorted(p.name for p in outside.iterdir()) == ["passwd"]
    assert (outside / "passwd").read_text() == "root\n"
    Path("out/A").unlink()
    (shop / "out" / "B").mkdir()
    Path("out/A").symlink_to("B")  # that stays in the folder
    assert run(*force)[0] == (1, 0, 0, 0)
    assert Path("out/B/P000.gcode").is_file()


@pytest.mark.parametrize("command", ["batch", "watch"])
@pytest.mark.parametrize("text", ["% BY HAND\nG00 X1.\nM30\n", ""])
def test_what_beamcam_did_not_make_is_not_lost(shop: Path, command: str, text: str) -> None:
    Path("out/P000.gcode").write_text(text)
    found, said = run(command=command)
    assert (found, NOT_OURS.code in said) == ((0, 0, 1, 0), True)
    assert "which beamcam did not make; expected a program as a batch made it, `batch --f" in said
    assert Path("out/P000.gcode").read_text() == text
    assert run("--force")[0] == (1, 0, 0, 0)
    assert "BEAMCAM" in Path("out/P000.gcode").read_text()


def test_what_was_edited_is_not_lost(shop: Path) -> None:
    run()
    made = Path("out/P000.gcode").read_text()
    Path("out/P000.gcode").write_text(made + "(checked by Meier)\n")
    found, said = run()
    assert (found, "which was changed since it was made" in said) == ((0, 0, 1, 0), True)
    assert "Meier" in Path("out/P000.gcode").read_text()
    assert run("--force")[0] == (1, 0, 0, 0)
    assert Path("out/P000.gcode").read_text() == made
    assert run("--job", "NIGHT")[0] == (1, 0, 0, 0)  # its own is written over


def test_what_is_locked_is_not_replaced(shop: Path) -> None:
    run()
    Path("out/P000.gcode").chmod(0o444)
    assert run()[0] == (0, 1, 0, 0)
    found, said = run("--job", "NIGHT")
    assert (found, "which is read-only" in said) == ((0, 0, 1, 0), True)
    assert Path("out/P000.gcode").read_text().startswith("% JOB\n")
    assert run("--job", "NIGHT", "--force")[0] == (1, 0, 0, 0)
    assert Path("out/P000.gcode").read_text().startswith("% NIGHT\n")


def test_a_program_of_post_is_beamcams_own(shop: Path) -> None:
    """As are those of a run whose record is lost."""
    run()
    Path("out", RECORD_NAME).unlink()
    assert run("--job", "NIGHT")[0] == (1, 0, 0, 0)


@pytest.mark.parametrize("command", ["batch", "watch"])
def test_two_inputs_of_one_name_are_refused(shop: Path, command: str) -> None:
    for folder, length in (("A", 1500.0), ("B", 2500.0)):
        Path("in", folder).mkdir()
        Path("in", folder, "M.nc1").write_text(part(folder, length))
    Path("in/P000.nc1").unlink()
    found, said = run("--flat", command=command)
    assert (found, SAME_NAME.code in said) == ((1, 0, 1, 0), True)


def test_a_hot_folder_knows_the_names_of_inputs_that_are_done(shop: Path) -> None:
    """After it was started again too: the program of the one before still stands."""
    Path("in/A").mkdir()
    Path("in/P000.nc1").rename("in/A/M.nc1")
    assert run("--flat", "--done", "done", command="watch")[0] == (1, 0, 0, 0)
    first = Path("out/M.gcode").read_bytes()
    Path("in/B").mkdir()
    Path("in/B/M.nc1").write_text(part("B", 2500.0))
    found, said = run("--flat", "--done", "done", command="watch")
    assert (found, SAME_NAME.code in said) == ((0, 0, 1, 0), True)
    assert Path("out/M.gcode").read_bytes() == first
    Path("in/B/M.nc1").rename("in/A/M.nc1")  # a new revision of the first
    assert run("--flat", "--done", "done", command="watch")[0] == (1, 0, 0, 0)


def test_check_updates_nothing_outside_its_folder(shop: Path) -> None:
    run()
    outside = shop.parent / "outside.gcode"
    Path("out/P000.gcode").rename(outside)
    Path("out/P000.gcode").symlink_to(outside)
    outside.write_text("% HERS\n")
    assert batch("out", "--update", command="check").exit_code == 1
    assert outside.read_text() == "% HERS\n"
    Path("out/P000.gcode").unlink()
    record = Path("out", RECORD_NAME)
    record.write_text(record.read_text().replace('"P000.gcode"', '"../../outside.gcode"'))
    assert batch("out", "--update", command="check").exit_code != 0
    assert outside.read_text() == "% HERS\n"
