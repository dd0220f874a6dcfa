"""`beamcam convert` into a folder: every member of a model is accounted for."""

import json
from pathlib import Path

import pytest
from click.testing import Result

from beamcam.readers.ifc import read
from tests.runs import call, part
from tests.unit.readers.ifc.models import Small


def convert(*args: str) -> Result:
    done = call("convert", *args)
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    return done


def model(*marks: str, lengths: tuple[float, ...] = ()) -> bytes:
    """Beams of those marks, each longer than the one before unless `lengths` says otherwise."""
    small = Small()
    for place, mark in enumerate(marks):
        length = lengths[place] if lengths else 1000.0 + 10 * place
        small.element(small.extruded(small.ipe300(), length), tag=mark, name="BEAM")
    return small.data


def marks_in(folder: Path) -> dict[str, tuple[str, int]]:
    """Mark and quantity in each file of a folder, by the file's name."""
    texts = {path.name: json.loads(path.read_text()) for path in folder.iterdir()}
    return {name: (text["mark"], text["quantity"]) for name, text in texts.items()}


@pytest.fixture(autouse=True)
def _here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def test_marks_that_are_one_name_are_kept_apart_and_told() -> None:
    Path("m.ifc").write_bytes(model("B/1", "B 1", "b_1", "B1", "B1"))
    done = convert("m.ifc", "-o", "out/", "--to", "part-json")
    assert done.exit_code == 0
    assert marks_in(Path("out")) == {
        "B_1.json": ("B/1", 1),
        "B_1-2.json": ("B 1", 1),
        "b_1-3.json": ("b_1", 1),
        "B1.json": ("B1", 1),
        "B1-2.json": ("B1", 1),
    }
    assert "write-renamed: found mark 'B 1' for the name B_1.json, which a part with" in done.stderr
    assert done.stderr.count("write-renamed") == 3


def test_the_ledger_of_a_model_is_told() -> None:
    small = Small()
    for length in (1000.0, 1000.0, 1200.0):
        small.element(small.extruded(small.ipe300(), length), tag="B1")
    concrete = small.element(small.extruded(small.ipe300(), 900.0), tag="C1")
    small.material(concrete, "Concrete C30/37")
    Path("m.ifc").write_bytes(small.data)
    done = convert("m.ifc", "-o", "out/")
    assert "note ifc-left-out: found 1 members of concrete" in done.stderr
    assert "note ifc-ledger: found 4 members: 3 read, 0 refused, 1 left out" in done.stderr
    assert (
        "out/: note write-folder: found 2 different parts, 3 in all; written 2 files" in done.stderr
    )
    assert "note" not in convert("m.ifc", "-o", "out/", "--quiet").stderr


def test_a_member_that_cannot_be_written_stops_no_other() -> None:
    Path("m.ifc").write_bytes(model("A1", "A\\X\\0A2", "A3"))
    done = convert("m.ifc", "-o", "out/")
    assert done.exit_code == 1
    assert ": error dstv-write-text: found text 'A\\n2' for the mark" in done.stderr
    assert sorted(path.name for path in Path("out").iterdir()) == ["A1.nc1", "A3.nc1"]
    assert "found 3 different parts, 3 in all; written 2 files" in done.stderr


def test_strict_writes_no_member_that_is_warned_of() -> None:
    small = Small()
    named = ("HEB200", "IPE300")  # the first name is not what the section measures
    for tag, name in zip(("A1", "A2"), named, strict=True):
        small.element(small.extruded(small.ipe300(), 1000.0), tag=tag, name=name)
    Path("m.ifc").write_bytes(small.data)
    assert convert("m.ifc", "-o", "both/").exit_code == 0
    assert len(list(Path("both").iterdir())) == 2
    done = convert("m.ifc", "-o", "out/", "--strict")
    assert done.exit_code == 1
    assert ": error ifc-profile-name: " in done.stderr
    assert [path.name for path in Path("out").iterdir()] == ["A2.nc1"]


def test_strict_posts_no_member_that_is_warned_of() -> None:
    small = Small()
    for tag, name in zip(("A1", "A2"), ("HEB200", "IPE300"), strict=True):
        small.element(small.extruded(small.ipe300(), 1500.0), tag=tag, name=name)
    Path("m.ifc").write_bytes(small.data)
    done = call("batch", "m.ifc", "-o", "out", "--strict", "--jobs", "1", status=1)
    assert [path.name for path in Path("out").glob("*.gcode")] == ["m.gcode"]
    assert "1 part" in done.stderr or "refused" in done.stderr


def test_of_a_part_that_is_refused_nothing_is_written() -> None:
    """It would lack the hole whose row cannot be read."""
    Path("bad.nc1").write_text(part("B1").replace("EN\n", "BO\n  v  oops\nEN\n"))
    done = convert("bad.nc1", "-o", "out/")
    assert done.exit_code == 1
    assert ": error dstv-" in done.stderr
    assert not Path("out").exists()


def test_the_input_is_not_written_over_by_a_name_that_nobody_gave() -> None:
    Path("B1.nc1").write_text(part("B1") + "\n")
    before = Path("B1.nc1").read_text()
    done = convert("B1.nc1", "-o", "./")
    assert done.exit_code == 1
    assert "error write-over-input: found the output './B1.nc1', which is" in done.stderr
    assert Path("B1.nc1").read_text() == before


def test_a_long_mark_has_a_name_that_systems_take() -> None:
    Path("m.ifc").write_bytes(model("a" * 250, "a" * 251))
    done = convert("m.ifc", "-o", "out/")
    assert done.exit_code == 0
    assert sorted(path.name for path in Path("out").iterdir()) == [
        "a" * 80 + "-2.nc1",
        "a" * 80 + ".nc1",
    ]


@pytest.mark.parametrize(
    ("words", "error"),
    [
        (["--class", "IfcColumn"], "ifc-selection: found no member with class IfcColumn"),
        (["--mark", "B1", "--guid", "{second}"], "write-no-part: found no part to write"),
    ],
)
def test_a_selection_of_nothing_is_an_error(words: list[str], error: str) -> None:
    data = model("B1", "B2")
    Path("m.ifc").write_bytes(data)
    second = read(data, "m.ifc").parts[1].guid
    done = convert("m.ifc", "-o", "out/", *(word.format(second=second) for word in words))
    assert done.exit_code == 1
    assert f"m.ifc: error {error}; expected" in done.stderr
    assert "2 not selected" in done.stderr


@pytest.mark.parametrize("command", ["post m.ifc -o a.gcode", "plan m.ifc"])
def test_what_was_said_of_a_model_is_told_where_it_cannot_be_posted_too(command: str) -> None:
    """That there is no part to plan would be a riddle without it."""
    small = Small()
    small.material(small.element(small.extruded(small.ipe300(), 900.0)), "Concrete C30/37")
    Path("m.ifc").write_bytes(small.data)
    done = call(*command.split(), status=1)
    assert "m.ifc: warning ifc-no-members: found no steel member" in done.stderr
    assert "beamline: error plan-no-parts" in done.stderr


def test_a_drawing_of_nothing_but_filled_shapes_is_no_part() -> None:
    """Its JSON form would have no length, and could not be read."""
    shape = '<rect width="5" height="5" fill="red"/>'
    page = 'xmlns="http://www.w3.org/2000/svg" width="9mm" height="9mm" viewBox="0 0 9 9"'
    Path("f.svg").write_text(f"<svg {page}>{shape}</svg>")
    done = convert("f.svg", "-o", "f.json")
    assert done.exit_code == 1
    assert "warning svg-fill-only" in done.stderr
    assert "error write-no-part" in done.stderr
    assert not Path("f.json").exists()


def test_diff_tells_what_it_left_out() -> None:
    """Two models without steel are no two models that are the same."""
    Path("a.ifc").write_bytes(Small().data)
    small = Small()
    small.material(small.element(small.extruded(small.ipe300(), 900.0)), "Concrete C30/37")
    Path("b.ifc").write_bytes(small.data)
    done = call("diff", "a.ifc", "b.ifc", status=0)
    assert done.stderr.count("warning ifc-no-members") == 2
    assert "b.ifc: note ifc-left-out: found 1 members of concrete" in done.stderr


def test_twice_the_same_bytes() -> None:
    Path("m.ifc").write_bytes(model("B1", "b1", "C 1"))
    for folder in ("one/", "two/"):
        assert convert("m.ifc", "-o", folder).exit_code == 0
    one, two = ({p.name: p.read_bytes() for p in Path(f).iterdir()} for f in ("one", "two"))
    assert one == two


def test_messages_as_one_list() -> None:
    Path("m.ifc").write_bytes(model("A1", "A\\X\\0A2"))
    done = convert("m.ifc", "-o", "out/", "--json")
    codes = [said["code"] for said in json.loads(done.stderr)]
    assert codes == ["ifc-ledger", "dstv-write-text", "write-folder"]
