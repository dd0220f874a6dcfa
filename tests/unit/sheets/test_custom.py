"""What only custom says of a drawing is asked for: dashed lines that are cut, marks that close."""

from pathlib import Path

import pytest

from beamcam import readers
from beamcam.errors import MachineError
from beamcam.machine import load
from beamcam.model.part import Part
from beamcam.pipeline import StrictError, post
from tests.dxf_text import Pair, block, circle, drawing, insert, line, tags
from tests.unit.sheets.parts import table

SQUARE = "".join(
    line(*a, *b, layer="CUT")
    for a, b in [((0, 0), (90, 0)), ((90, 0), (90, 60)), ((90, 60), (0, 60)), ((0, 60), (0, 0))]
)


def tables(**layers: tuple[int, str]) -> str:
    """Layers with their colour and line type; CENTER has gaps by the table, SOLID has none."""
    text = tags((0, "TABLE"), (2, "LTYPE"), (5, "5"), (100, "AcDbSymbolTable"), (70, 2))
    for name, dashes in (("CENTER", (31.75, -6.35, 6.35, -6.35)), ("SOLID", ())):
        head = ((0, "LTYPE"), (5, "D0"), (100, "AcDbSymbolTableRecord"))
        rows: list[Pair] = [(100, "AcDbLinetypeTableRecord"), (2, name), (70, 0), (3, ""),
                            (72, 65), (73, len(dashes)), (40, sum(map(abs, dashes)))]  # fmt: skip
        for dash in dashes:
            rows += [(49, dash), (74, 0)]
        text += tags(*head, *rows)
    text += tags((0, "ENDTAB"))
    text += tags((0, "TABLE"), (2, "LAYER"), (5, "2"), (100, "AcDbSymbolTable"), (70, 2))
    for name, (colour, line_type) in {"CUT": (7, "Continuous"), **layers}.items():
        text += tags(
            (0, "LAYER"), (5, "C0"), (100, "AcDbSymbolTableRecord"),
            (100, "AcDbLayerTableRecord"), (2, name), (70, 0), (62, colour), (6, line_type),
        )  # fmt: skip
    return text + tags((0, "ENDTAB"))


def part_of(entities: str, blocks: str = "", **layers: tuple[int, str]) -> Part:
    data = drawing(SQUARE + entities, tables=tables(**layers), blocks=blocks)
    reading = readers.read(data, "a.dxf")
    (part,) = reading.parts
    return part


def told(part: Part, **values: object) -> list[str]:
    """What is asked of a drawing, as it reads from "found" on."""
    posted = post((part,), table(thickness=3.0, **values))
    asked = ("plan-dashed", "plan-closed-mark")
    return [d.message.removeprefix("found ") for d in posted.remarks if d.code in asked]


BY_ENTITY = circle(30, 30, 10, layer="CUT", common=((6, "CENTER"),))
BY_LAYER = circle(30, 30, 10, layer="AXES")
IN_BLOCK = insert("B", layer="CUT", common=((6, "CENTER"),))
BLOCK = block("B", circle(30, 30, 10, layer="CUT", common=((6, "ByBlock"),)))
DASHED = [
    (part_of(BY_ENTITY), "white", "CUT"),
    (part_of(BY_LAYER, AXES=(1, "CENTER")), "AXES", "AXES"),
    (part_of(BY_LAYER, AXES=(1, "Nobody's")), "AXES", "AXES"),
    (part_of(IN_BLOCK, BLOCK), "white", "CUT"),
]


@pytest.mark.parametrize(("part", "key", "layer"), DASHED)
def test_lines_with_gaps_that_are_cut_are_told_of(part: Part, key: str, layer: str) -> None:
    (said,) = told(part)
    assert said.startswith("1 contour(s) of colour ")
    assert f"on layer {layer!r} in the line type" in said
    assert told(part, colours={layer: "cut"}) == []
    if layer == "AXES":
        assert "--map 'AXES=ignore'" in said
        assert told(part, colours={"AXES": "ignore"}) == []
        assert told(part, colours={"red": "cut"}) == []


@pytest.mark.parametrize("line_type", ["SOLID", "Continuous", "ByLayer", ""])
def test_lines_without_gaps_are_not(line_type: str) -> None:
    drawn = circle(30, 30, 10, layer="CUT", common=((6, line_type),))
    assert told(part_of(drawn)) == []


def test_nor_are_those_that_are_not_cut() -> None:
    assert told(part_of(BY_LAYER, AXES=(5, "CENTER")), colours={"blue": "ignore"}) == []


HOLES = circle(30, 30, 10, layer="HOLES") + circle(60, 30, 10, layer="HOLES")


def test_marks_that_close_within_a_part_are_told_of() -> None:
    part = part_of(HOLES, HOLES=(5, "Continuous"))
    (said,) = told(part)
    assert said.startswith("2 closed contour(s) of colour blue on layer 'HOLES' within what is cut")
    assert "--map 'HOLES=cut' for openings, 'HOLES=mark' for marks" in said
    for settled in ({"HOLES": "mark"}, {"holes": "cut"}, {"blue": "mark"}, {"HOLES": "ignore"}):
        assert told(part, colours=settled) == []


def test_a_machine_may_settle_a_colour(tmp_path: Path) -> None:
    part = part_of(HOLES, HOLES=(5, "Continuous"))
    assert told(part, settled=("blue",)) == []
    assert told(part, settled=("red",)) != []
    file = tmp_path / "own.toml"
    file.write_text('base = "plate-linuxcnc"\n[torch]\nsettled = ["mauve"]\n')
    with pytest.raises(MachineError, match=r":3: .* found 'mauve' for 'torch.settled'"):
        load(str(file))


def test_marks_beside_a_part_and_open_ones_are_not() -> None:
    beside = circle(130, 30, 10, layer="HOLES") + line(10, 10, 20, 20, layer="HOLES")
    assert told(part_of(beside, HOLES=(5, "Continuous"))) == []


def test_a_layer_of_several_colours_is_settled_by_colour() -> None:
    both = HOLES + circle(45, 15, 5, layer="HOLES", common=((62, 1),))
    (said,) = told(part_of(both, HOLES=(5, "Continuous")))
    assert "--map 'blue=cut'" in said


def test_a_strict_job_asks_before_it_posts() -> None:
    part = part_of(HOLES, HOLES=(5, "Continuous"))
    with pytest.raises(StrictError, match="plan-closed-mark"):
        post((part,), table(thickness=3.0), strict=True)
    post((part,), table(thickness=3.0, colours={"HOLES": "mark"}), strict=True)
