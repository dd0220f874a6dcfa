"""The JSON schemas: what they hold is what the program takes, by a validator of somebody else's."""

import json
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator
from msgspec.structs import replace

from beamcam import readers
from beamcam.machine import shipped
from beamcam.model.part_json import write
from beamcam.readers.part_json import read
from tests.conftest import ROOT, SAMPLES, sampled
from tests.runs import call

MACHINES = ROOT / "beamcam" / "machines"


def schema_of_machines() -> Any:
    return json.loads(call("machines", "schema").stdout)


def schema_of_parts() -> Any:
    return json.loads(call("convert", "--schema").stdout)


def faults(schema: Any, value: Any) -> list[str]:
    Draft202012Validator.check_schema(schema)
    return [
        f"{'.'.join(map(str, error.absolute_path))}: {error.message}"
        for error in Draft202012Validator(schema).iter_errors(value)
    ]


def test_the_schema_of_machines_is_up_to_date() -> None:
    """Made anew by `beamcam machines schema > docs/machine.schema.json`."""
    stored = (ROOT / "docs" / "machine.schema.json").read_text(encoding="utf-8")
    assert json.loads(stored) == schema_of_machines()


def test_the_schema_of_parts_is_up_to_date() -> None:
    """Made anew by `beamcam convert --schema > docs/part.schema.json`."""
    stored = (ROOT / "docs" / "part.schema.json").read_text(encoding="utf-8")
    assert json.loads(stored) == schema_of_parts()


@pytest.mark.parametrize("path", sorted((SAMPLES / "json").iterdir()), ids=lambda p: p.name)
def test_samples_of_parts_are_valid(path: Path) -> None:
    assert faults(schema_of_parts(), json.loads(path.read_text(encoding="utf-8"))) == []


@pytest.mark.parametrize(
    "path",
    sampled(
        [*sorted((SAMPLES / "dstv").glob("*.nc1")), *sorted((SAMPLES / "dxf").glob("*.dxf"))], 2
    ),
    ids=lambda p: p.name,
)
def test_what_is_written_is_valid_and_comes_back(path: Path) -> None:
    schema = schema_of_parts()
    for part in readers.read(path.read_bytes(), path.name).parts:
        text = write(part)
        assert faults(schema, json.loads(text)) == []
        assert read(text.encode(), "a.json").parts == (replace(part, measures=None),)


LINE = {"line": [[0, 0], [1, 1]]}


@pytest.mark.parametrize(
    ("keys", "says"),
    [
        ({"lenght": 3}, ": Additional properties are not allowed ('lenght'"),
        ({"length": 0}, "length: 0 is less than or equal"),
        ({"schema": "beamcam/part/9"}, "schema: 'beamcam/part/1' was expected"),
        ({"holes": [{"x": 1, "y": 2}]}, "holes.0: 'diameter' is a required property"),
        ({"holes": [{"x": 1, "y": 2, "diameter": -1}]}, "holes.0.diameter: -1 is less than"),
        ({"contours": [{"kind": "all", "curves": [LINE]}]}, "contours.0.kind: 'all' is not one"),
        ({"contours": [{"kind": "open", "curves": [{}]}]}, "contours.0.curves.0: {} "),
        ({"contours": [{"kind": "open", "curves": [{**LINE, "polygon": [[0, 0]] * 3}]}]},
         "contours.0.curves.0: {'line'"),
    ],
)  # fmt: skip
def test_parts_that_are_not_valid(keys: dict[str, Any], says: str) -> None:
    profile = {"code": "B", "height": 10}
    value = {"mark": "P", "length": 3, "profile": profile, **keys}
    assert any(said.startswith(says) for said in faults(schema_of_parts(), value))
    assert read(json.dumps(value).encode(), "a.json").refused


@pytest.mark.parametrize("name", sampled(shipped(), 2))
def test_shipped_machines_are_valid(name: str) -> None:
    table = tomllib.loads((MACHINES / f"{name}.toml").read_text(encoding="utf-8"))
    assert faults(schema_of_machines(), table) == []


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('base = "x"\n[saw]\nkerff = 3', "saw: Additional properties are not allowed ('kerff'"),
        ('base = "x"\n[saw]\nkerf = -3', "saw.kerf: -3 is less than the minimum of 0"),
        (
            'base = "x"\n[drill]\nmax_width = 0',
            "drill.max_width: 0 is less than or",
        ),
        ('base = "x"\n[[pairs]]\nname = "p"\nnumber = 9\nfaces = ["o"]', "pairs.0.faces: ['o'] is"),
        ('base = "x"\n[[spindles]]\nname = "s"', "spindles.0: 'number' is a required property"),
        ('title = "x"', ": 'controller' is a required property"),
        ('title = "x"\n[saw]\nkerf = 3', "saw: 'min_angle' is a required property"),
    ],
)
def test_what_is_not_valid(text: str, says: str) -> None:
    assert any(said.startswith(says) for said in faults(schema_of_machines(), tomllib.loads(text)))


def test_every_key_has_a_meaning_that_is_in_the_schema_too() -> None:
    from beamcam.machine.keys import machine_keys

    assert [key.name for key in machine_keys() if not key.meaning] == []
    assert {key.meaning for key in machine_keys()} <= set(descriptions(schema_of_machines()))


def test_a_comment_of_several_lines_is_told_from_its_first_to_its_last_word() -> None:
    from beamcam.machine.keys import machine_keys

    (bevel,) = (key.meaning for key in machine_keys() if key.name == "torch.bevel")
    assert bevel.startswith("Bevels: refused, or ")
    assert bevel.endswith("tilts yet.")


def descriptions(value: Any) -> Iterator[str]:
    if isinstance(value, dict):
        if isinstance(value.get("description"), str):
            yield value["description"]
        for item in value.values():
            yield from descriptions(item)
    elif isinstance(value, list):
        for item in value:
            yield from descriptions(item)
