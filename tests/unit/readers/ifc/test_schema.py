"""The table of entities says what the schemas say."""

import re
from pathlib import Path

import pytest

import beamcam.readers.ifc as reader
from beamcam.readers.ifc.schema import entity_types

SCHEMAS = {"IFC2X3": "IFC2X3", "IFC4": "IFC4", "IFC4X3": "IFC4X3_ADD2"}
FOLDER = Path(reader.__file__).parent


@pytest.mark.parametrize("schema", SCHEMAS)
def test_attributes_and_supertypes_are_the_schemas(schema: str) -> None:
    wrapper = pytest.importorskip("ifcopenshell").ifcopenshell_wrapper
    declared = wrapper.schema_by_name(SCHEMAS[schema])
    compared = 0
    for known in entity_types(schema).values():
        try:
            entity = declared.declaration_by_name(known.name).as_entity()
        except RuntimeError:
            continue  # an entity of another schema, which this file cannot have
        assert list(known.places) == [a.name() for a in entity.all_attributes()], known.name
        above = set()
        while entity is not None:
            above.add(entity.name())
            entity = entity.supertype()
        assert known.kinds == above
        compared += 1
    assert compared > 150


@pytest.mark.parametrize("schema", SCHEMAS)
def test_every_class_that_the_reader_asks_for_is_there_with_its_subtypes(schema: str) -> None:
    wrapper = pytest.importorskip("ifcopenshell").ifcopenshell_wrapper
    declared = wrapper.schema_by_name(SCHEMAS[schema])
    asked = set()
    for path in FOLDER.glob("*.py"):
        asked |= set(re.findall(r'(?:is_a|by_type)\("(Ifc\w+)"\)', path.read_text("utf-8")))
    known = {known.name for known in entity_types(schema).values()}
    for name in sorted(asked):
        try:
            todo = [declared.declaration_by_name(name).as_entity()]
        except RuntimeError:
            continue
        while todo:
            entity = todo.pop()
            if entity is None or entity.name() in ("IfcElementAssembly",):
                continue
            assert entity.name() in known, (name, entity.name())
            todo += entity.subtypes()
