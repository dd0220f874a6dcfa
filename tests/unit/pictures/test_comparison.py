"""Two things over each other: what moved, what is new, what is gone, and what stayed."""

from pathlib import Path

import pytest
from click.testing import Result
from msgspec.structs import replace

from beamcam.machine import load
from beamcam.model.part import Hole, Part, TextMark
from beamcam.pictures import ReadProgram
from beamcam.pictures.comparison import compared_parts, compared_programs
from beamcam.pictures.formats import to_svg
from beamcam.pictures.overlay import Overlay
from beamcam.pipeline import post, read_file
from tests.conftest import SAMPLES
from tests.runs import call
from tests.unit.pictures.drawings import Drawing


def channel() -> Part:
    return read_file(str(SAMPLES / "dstv" / "channel.nc1")).parts[0]


def drawn(compared: Overlay) -> Drawing:
    return Drawing(to_svg(compared.scene))


def counts(compared: Overlay) -> tuple[int, int, int, int]:
    return compared.same, compared.changed, compared.gone, compared.new


def test_a_part_is_the_same_as_itself() -> None:
    part = channel()
    found = compared_parts(part, part)
    assert counts(found) == (len(part.features), 0, 0, 0)
    assert not drawn(found).count("gone") + drawn(found).count("new")


def test_moved_new_and_gone_holes_are_told_apart() -> None:
    part = channel()
    holes = [f for f in part.features if isinstance(f, Hole)]
    moved = replace(holes[0], x=holes[0].x + 20.0)
    others = tuple(f for f in part.features if f not in holes[:2])
    new = replace(holes[1], x=1700.0)
    text = TextMark("v", 500.0, 50.0, 0.0, 20.0, "M1", part.source)
    other = replace(part, features=(*others, moved, new, text))
    found = compared_parts(part, other)
    assert counts(found) == (len(part.features) - 2, 1, 1, 2)
    picture = drawn(found)
    assert picture.count("moved", "arrow") == 1
    assert picture.count("gone", "hole-of") == picture.count("new", "hole-of") == 2
    assert picture.count("new-text") == 1
    assert picture.count("same", "hole-of") == len(holes) - 2
    assert {f"{h.x:g}" for h in (holes[0], moved, holes[1], new)} <= set(picture.texts)


def test_what_differs_is_called_by_its_size_in_both() -> None:
    """A leader goes up from each; what is the same has none."""
    part = channel()
    first, second, third, *_ = (f for f in part.features if isinstance(f, Hole) and f.face == "v")
    others = tuple(f for f in part.features if f not in (first, second, third))
    wider, moved = replace(first, diameter=30.0), replace(second, x=second.x + 15.0)
    new = Hole("v", 1700.0, 50.0, 13.0, part.source, kind="thread", depth=5.0)
    found = drawn(compared_parts(part, replace(part, features=(*others, wider, moved, new))))
    sizes = [f"{one.diameter:g}" for one in (first, second, third)]
    assert sorted("".join(e.itertext()) for e in found.all("callout")) == sorted([
        f"A Ø{sizes[0]}, B Ø30",
        f"Ø{sizes[1]}",
        f"only A: Ø{sizes[2]}", "only B: M13, 5 deep",
    ])  # fmt: skip
    assert found.count("leader") == 4
    machine = load("beamline")
    other = replace(part, features=(*others, second, third, replace(first, diameter=22.0)))
    texts = [post((one,), machine).text for one in (part, other)]
    a, b = (ReadProgram(text.encode(), machine, "p") for text in texts)
    programs = [text for text in drawn(compared_programs(a, b)).texts if "22" in text]
    assert any(text.startswith(("A Ø18, B Ø22", "only B: Ø22")) for text in programs)


def test_programs_of_bars_are_compared_by_what_they_make() -> None:
    machine = load("beamline")
    text = post((channel(),), machine).text
    other = text.replace("X3698.56", "X3668.56")
    assert text != other
    a, b = (ReadProgram(t.encode(), machine, n) for t, n in ((text, "a"), (other, "b")))
    assert counts(compared_programs(a, a))[1:] == (0, 0, 0)
    found = compared_programs(a, b)
    assert found.changed == 2  # the two holes of the right end
    picture = drawn(found)
    assert picture.count("moved", "arrow") == 2
    assert {"3698.6", "3668.6"} <= set(picture.texts)  # where the stop is for them
    assert a.sha256 in " ".join(picture.texts)
    assert b.sha256 in " ".join(picture.texts)


@pytest.mark.parametrize("name", ["plate-linuxcnc", "plate-codesys"])
def test_ways_of_a_head_are_compared_move_by_move(name: str) -> None:
    machine = load(name)
    part = read_file(str(SAMPLES / "dstv" / "gusset.nc1")).parts[0]
    hole = next(part.holes)
    other = replace(part, features=tuple(f for f in part.features if f != hole))
    a, b = (
        ReadProgram(post((p,), machine).text.encode(), machine, "job", "", (p,))
        for p in (part, other)
    )
    assert counts(compared_programs(a, a))[1:] == (0, 0, 0)
    found = compared_programs(a, b)
    assert found.new == 0
    assert found.gone > 10  # the chords of its circle and its leads
    assert drawn(found).count("gone", "way-of") >= 1


def run(*words: str) -> Result:
    return call("diff", *words)


def test_the_command_writes_a_page_or_a_picture(tmp_path: Path) -> None:
    a = tmp_path / "a.nc1"
    text = (SAMPLES / "dstv" / "channel.nc1").read_text()
    a.write_text(text)
    b = tmp_path / "b.nc1"
    b.write_text(text.replace("400.00u     45.00", "400.00u     50.00"))
    for suffix, start in ((".html", b"<!doctype html>"), (".svg", b"<svg"), (".png", b"\x89PNG")):
        out = tmp_path / f"diff{suffix}"
        assert run(str(a), str(b), "-o", str(out)).exit_code == 1
        assert out.read_bytes().startswith(start)
        assert run(str(a), str(a), "-o", str(out)).exit_code == 0
    page = tmp_path / "diff.html"
    run(str(a), str(b), "-o", str(page))
    content = page.read_text()
    same = len(channel().features) - 2
    assert f"2 differences; {same} the same, 2 changed, 0 gone, 0 new" in content
    assert "<li>hole o at x 400.0 moved by 5.0 mm across" in content
    assert run(str(a), str(b), "-o", str(tmp_path / "x.txt")).exit_code == 2
    assert run(str(tmp_path), str(tmp_path), "-o", str(page)).exit_code == 2
