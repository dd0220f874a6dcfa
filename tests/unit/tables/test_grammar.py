"""The units against a grammar of Structured Text that somebody else wrote."""

import re

import pytest

from beamcam.emitters import simotion

from .shop import NAMES, program, table_machine

tree_sitter = pytest.importorskip("tree_sitter", reason="no tree-sitter")
grammar = pytest.importorskip("tree_sitter_iec61131_3_st", reason="no grammar of ST")

EXPORT = re.compile(r"(FUNCTION_BLOCK|PROGRAM) \w+;")


def without_frame(unit: str) -> str:
    """A unit without the lines that only SIMOTION has, its lines kept in their places."""
    inside, found = False, []
    for line in unit.splitlines():
        word = line.strip()
        if word in ("INTERFACE", "END_INTERFACE"):
            inside = word == "INTERFACE"
            line = ""
        elif (
            word in ("IMPLEMENTATION", "END_IMPLEMENTATION")
            or word.startswith(("USEPACKAGE ", "USES "))
            or (inside and EXPORT.fullmatch(word))
        ):
            line = ""
        found.append(line)
    return "\n".join(found)


def faults(text: str) -> list[int]:
    """Lines that the grammar does not accept."""
    parser = tree_sitter.Parser(tree_sitter.Language(grammar.language()))
    found, nodes = [], [parser.parse(text.encode()).root_node]
    while nodes:
        node = nodes.pop()
        if node.type == "ERROR" or node.is_missing:
            found.append(node.start_point.row + 1)
        nodes += [child for child in node.children if child.has_error or child.is_missing]
    return found


@pytest.mark.parametrize("style", ["chain", "table"])
@pytest.mark.parametrize("path_objects", [False, True])
@pytest.mark.parametrize("name", NAMES)
def test_the_grammar_accepts_every_unit(name: str, path_objects: bool, style: str) -> None:
    machine = table_machine(path_objects=path_objects, max_data=1024)
    for _, unit in simotion.units(program(name, style, machine)):
        assert faults(without_frame(unit)) == []


def test_the_grammar_can_refuse() -> None:
    text = without_frame(program("shield", "chain"))
    assert faults(text.replace("THEN", "THAN", 1))
