"""Layers and colours: what is read, what is hidden, and how a contour looks."""

import subprocess
import sys
from pathlib import Path

import pytest

from beamcam.model.lengths import total_length
from beamcam.readers import dxf
from beamcam.readers.dxf.layers import colour_of_number
from tests.dxf_text import (
    Pair,
    block,
    circle,
    codes,
    drawing,
    entity,
    insert,
    layer_table,
    length_of,
    line,
    tags,
)

LAYERS = layer_table(
    ("0", 7, 0, 1),
    ("CUT", 1, 0, 1),
    ("OFF", -2, 0, 1),
    ("FROZEN", 3, 1, 1),
    ("NOPLOT", 4, 0, 0),
    ("Defpoints", 7, 0, 1),
)
NAMES = ("CUT", "OFF", "FROZEN", "NOPLOT", "Defpoints")
ONE_EACH = "".join(line(0, i, 10**i, i, layer=name) for i, name in enumerate(NAMES))


def looks(entities: str, blocks: str = "") -> list[tuple[str | None, str | None]]:
    reading = dxf.read(drawing(entities, tables=LAYERS, blocks=blocks), "a.dxf")
    return [(c.layer, c.colour) for c in reading.parts[0].contours]


def test_only_what_shows_and_plots_is_read() -> None:
    data = drawing(ONE_EACH + line(0, 9, 7, 9, layer="CUT", common=((60, 1),)), tables=LAYERS)
    assert length_of(data) == 1
    (part,) = dxf.read(data, "a.dxf").parts
    assert part.measures is not None
    assert total_length(part.measures.hidden) == 10 + 100 + 1000 + 10000 + 7
    assert [d.message for d in dxf.read(data, "a.dxf").diagnostics] == [
        "found 5 curves on layers that are off, frozen, not plotting or not chosen: 1 CUT, "
        "1 Defpoints, 1 FROZEN, 1 NOPLOT, 1 OFF"
    ]


@pytest.mark.parametrize(
    ("layers", "length"),
    [(("OFF",), 10), (("cut", "Frozen"), 101), (("NOPLOT", "DEFPOINTS"), 11000)],
)
def test_the_user_chooses_layers(layers: tuple[str, ...], length: float) -> None:
    assert length_of(drawing(ONE_EACH, tables=LAYERS), layers=layers) == length


def test_a_layer_that_there_is_not_is_an_error_with_the_nearest() -> None:
    reading = dxf.read(drawing(ONE_EACH, tables=LAYERS), "a.dxf", layers=("FROZE", "CUT"))
    assert reading.refused
    assert str(reading.diagnostics[0]) == (
        "a.dxf: error drawing-layer-option: found no layer 'FROZE'; "
        "expected one of the drawing's: 'FROZEN'"
    )


def test_a_layer_without_entry_shows() -> None:
    assert looks(line(0, 0, 1, 0, layer="NEW")) == [("NEW", "#ffffff")]


@pytest.mark.parametrize(
    ("common", "colour"),
    [
        ((), "#ff0000"),
        (((62, 256),), "#ff0000"),
        (((62, 5),), "#0000ff"),
        (((62, 0),), "#ffffff"),
        (((62, 5), (420, 0x12AB34)), "#12ab34"),
    ],
)
def test_colours(common: tuple[Pair, ...], colour: str) -> None:
    assert looks(line(0, 0, 1, 0, layer="CUT", common=common)) == [("CUT", colour)]


def test_layer_0_and_byblock_take_after_the_insert() -> None:
    content = line(0, 0, 1, 0) + line(0, 1, 1, 1, common=((62, 0),))
    content += line(0, 2, 1, 2, layer="CUT") + line(0, 3, 1, 3, layer="CUT", common=((62, 4),))
    blocks = block("B", content) + block("A", insert("B", common=((62, 0),)))
    assert looks(insert("A", layer="FAR", common=((62, 3),)), blocks) == [
        ("FAR", "#ffffff"),  # by the layer FAR, which has no entry
        ("FAR", "#00ff00"),
        ("CUT", "#ff0000"),
        ("CUT", "#00ffff"),
    ]


def test_an_insert_on_a_hidden_layer_hides_what_inherits_it() -> None:
    content = circle(0, 0, 1) + line(0, 0, 5, 0, layer="CUT")
    data = drawing(insert("B", layer="OFF"), tables=LAYERS, blocks=block("B", content))
    assert length_of(data) == 5
    assert codes(data) == ["dxf-frozen-insert", "dxf-hidden"]
    unseen = drawing(
        insert("B", layer="CUT", common=((60, 1),)) + line(0, 0, 1, 0),
        tables=LAYERS,
        blocks=block("B", content),
    )
    assert length_of(unseen) == 1


def test_what_is_no_curve_is_counted_and_named() -> None:
    text = entity("TEXT", "AcDbText", (10, 0), (20, 0), (40, 1), (1, "A"))
    hidden = entity("TEXT", "AcDbText", (10, 0), (20, 0), (40, 1), (1, "A"), layer="OFF")
    point = entity("POINT", "AcDbPoint", (10, 0), (20, 0))
    ray = entity("RAY", "AcDbRay", (10, 0), (20, 0), (11, 1), (21, 0))
    data = drawing(line(0, 0, 1, 0) + text * 2 + hidden + point + ray, tables=LAYERS)
    reading = dxf.read(data, "a.dxf")
    assert dict(reading.parts[0].measures.not_cut) == {"TEXT": 2, "POINT": 1, "RAY": 1}
    assert [str(d) for d in reading.diagnostics] == [
        "a.dxf: warning dxf-not-cut: found 1 POINT, 1 RAY, 2 TEXT, which no tool follows; "
        "expected curves only"
    ]


def test_attributes_are_counted_with_the_insert_not_with_the_block() -> None:
    own = ((10, 0), (20, 0), (40, 1), (1, "7"), (100, "AcDbAttributeDefinition"), (3, "No?"))
    definition = entity("ATTDEF", "AcDbText", *own, (2, "NO"), (70, 0))
    attribute = entity("ATTRIB", "AcDbText", (10, 0), (20, 0), (40, 1), (1, "7"))
    attribute = attribute + tags((100, "AcDbAttribute"), (2, "NO"), (70, 0))
    with_one = insert("B", 0, 0, (66, 1)) + attribute + tags((0, "SEQEND"), (5, "E"), (8, "0"))
    data = drawing(with_one, blocks=block("B", line(0, 0, 1, 0) + definition))
    reading = dxf.read(data, "a.dxf")
    assert dict(reading.parts[0].measures.not_cut) == {"ATTRIB": 1}


def test_nothing_to_cut_refuses_the_file() -> None:
    reading = dxf.read(drawing(line(0, 0, 1, 0, layer="OFF"), tables=LAYERS), "a.dxf")
    assert str(reading.diagnostics[-1]) == (
        "a.dxf: error drawing-empty: found no curve that a tool could follow (1 hidden curves), "
        "expected at least one"
    )


def test_colours_are_those_of_the_palette() -> None:
    from ezdxf.colors import aci2rgb

    assert [colour_of_number(n) for n in range(1, 256)] == [
        aci2rgb(n).to_hex() for n in range(1, 256)
    ]
    assert colour_of_number(300) == "#ffffff"


@pytest.mark.parametrize(("name", "needed"), [("layers.dxf", False), ("blocks.dxf", True)])
def test_ezdxf_is_imported_for_what_it_reads(name: str, needed: bool) -> None:
    (path,) = (Path(__file__).parents[4] / "samples").rglob(name)
    code = (
        "import sys\nfrom pathlib import Path\nfrom beamcam.readers import dxf\n"
        "assert dxf.read(Path(sys.argv[1]).read_bytes(), 'a.dxf').parts\n"
        "print('ezdxf' in sys.modules)"
    )
    run = subprocess.run([sys.executable, "-c", code, str(path)], capture_output=True, text=True)
    assert run.stdout == f"{needed}\n", run.stderr
