"""Texts of drawings on layers that are mapped to a mark."""

import io
from pathlib import Path

import pytest
from click.testing import CliRunner

from beamcam.cli import main
from beamcam.model.part import TextMark
from beamcam.readers.dxf import read
from tests.letters import read as read_letters
from tests.rs274 import needs_rs274
from tests.test_rs274 import traced

ezdxf = pytest.importorskip("ezdxf")


def drawn(add: object, unit: int = 4) -> bytes:
    """A drawing of a plate with what `add` puts into it."""
    document = ezdxf.new("R2010")
    document.units = unit
    space = document.modelspace()
    space.add_lwpolyline([(0, 0), (200, 0), (200, 100), (0, 100)], close=True)
    add(space)  # type: ignore[operator]
    out = io.StringIO()
    document.write(out)
    return out.getvalue().encode()


def texts(data: bytes) -> list[TextMark]:
    (part,) = read(data, "a.dxf", letters=("Etch",)).parts
    return [f for f in part.features if isinstance(f, TextMark)]


def test_a_text_on_a_mapped_layer_is_lettered() -> None:
    data = drawn(
        lambda s: s.add_text(
            "P-12", height=8, rotation=30, dxfattribs={"layer": "ETCH", "insert": (20, 30)}
        )
    )
    (found,) = texts(data)
    assert (found.text, found.x, found.y, found.height) == ("P-12", 20.0, 30.0, 8.0)
    assert found.angle == pytest.approx(30.0)
    (plain,) = read(data, "a.dxf").parts
    assert plain.measures is not None
    assert dict(plain.measures.not_cut) == {"TEXT": 1}
    assert not any(isinstance(f, TextMark) for f in plain.features)


def test_it_stays_where_a_layer_becomes_polynomials() -> None:
    def add(space: object) -> None:
        space.add_text("P-12", height=8, dxfattribs={"layer": "ETCH"})  # type: ignore[attr-defined]
        space.add_lwpolyline([(20, 20), (40, 30), (60, 25)], dxfattribs={"layer": "CAM"})  # type: ignore[attr-defined]

    (part,) = read(drawn(add), "a.dxf", letters=("Etch",), fit=("CAM",)).parts
    assert [f.text for f in part.texts] == ["P-12"]


def test_a_unit_and_a_block_move_and_scale_it() -> None:
    def add(space: object) -> None:
        block = space.doc.blocks.new("B")  # type: ignore[attr-defined]
        block.add_text("X", height=2, dxfattribs={"layer": "ETCH", "insert": (1, 0)})
        space.add_blockref("B", (5, 5), {"rotation": 90, "xscale": 2, "yscale": 2})  # type: ignore[attr-defined]

    (found,) = texts(drawn(add, unit=5))  # centimetres
    assert (found.x, found.y) == (pytest.approx(50.0), pytest.approx(70.0))
    assert (found.height, found.angle) == (pytest.approx(40.0), pytest.approx(90.0))


def test_where_a_text_is_held() -> None:
    from ezdxf.enums import TextEntityAlignment

    def add(space: object) -> None:
        for how in (TextEntityAlignment.RIGHT, TextEntityAlignment.MIDDLE_CENTER):
            text = space.add_text("HH", height=21, dxfattribs={"layer": "ETCH"})  # type: ignore[attr-defined]
            text.set_placement((100, 50), align=how)

    right, middle = texts(drawn(add))
    assert (right.x, right.y) == (pytest.approx(100 - 44.0), 50.0)
    assert (middle.x, middle.y) == (pytest.approx(100 - 22.0), pytest.approx(50 - 10.5))


def test_the_lines_of_an_mtext_are_texts_of_their_own() -> None:
    def add(space: object) -> None:
        space.add_mtext(  # type: ignore[attr-defined]
            r"\LP-1\l\PQ2",
            {"layer": "ETCH", "char_height": 6, "insert": (10, 60), "attachment_point": 1},
        )

    first, second = texts(drawn(add))
    assert (first.text, first.x, first.y) == ("P-1", 10.0, 54.0)
    assert (second.text, second.y) == ("Q2", 44.0)


@needs_rs274
def test_a_drawing_is_lettered_from_the_command_line(tmp_path: Path) -> None:
    source, target = tmp_path / "a.dxf", tmp_path / "a.ngc"
    source.write_bytes(
        drawn(
            lambda s: s.add_text("K-7", height=10, dxfattribs={"layer": "ETCH", "insert": (20, 30)})
        )
    )
    words = ("post", source, "-o", target, "--thickness", 3, "--map", "ETCH=mark")
    done = CliRunner().invoke(main, [*map(str, words)])
    assert done.exit_code == 0, done.output
    assert read_letters(traced(target), 10.0) == "K-7"
