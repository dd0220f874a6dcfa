"""The JSON schemas: what they hold is what the program takes, by a validator of somebody else's."""

import json
import tomllib
from collections.abc import Iterator
from typing import Any

import pytest
from click.testing import CliRunner
from jsonschema import Draft202012Validator

from beamcam.cli import main
from beamcam.machine import shipped
from tests.conftest import ROOT

MACHINES = ROOT / "beamcam" / "machines"


def schema_of_machines() -> Any:
    return json.loads(CliRunner().invoke(main, ["machines", "schema"]).stdout)


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


@pytest.mark.parametrize("name", shipped())
def test_shipped_machines_are_valid(name: str) -> None:
    table = tomllib.loads((MACHINES / f"{name}.toml").read_text(encoding="utf-8"))
    assert faults(schema_of_machines(), table) == []


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ('base = "x"\n[saw]\nkerff = 3', "saw: Additional properties are not allowed ('kerff'"),
        ('base = "x"\n[saw]\nkerf = -3', "saw.kerf: -3 is less than the minimum of 0"),
        (
            'base = "x"\n[drill]\ngreatest_width = 0',
            "drill.greatest_width: 0 is less than or",
        ),
        ('base = "x"\n[[pairs]]\nname = "p"\nnumber = 9\nfaces = ["o"]', "pairs.0.faces: ['o'] is"),
        ('base = "x"\n[[spindles]]\nname = "s"', "spindles.0: 'number' is a required property"),
        ('title = "x"', ": 'controller' is a required property"),
        ('title = "x"\n[saw]\nkerf = 3', "saw: 'least_angle' is a required property"),
    ],
)
def test_what_is_not_valid(text: str, says: str) -> None:
    assert any(said.startswith(says) for said in faults(schema_of_machines(), tomllib.loads(text)))


def test_every_key_with_a_meaning_has_it_in_the_schema() -> None:
    from beamcam.machine.keys import machine_keys

    told = set(descriptions(schema_of_machines()))
    assert {key.meaning for key in machine_keys() if key.meaning} <= told


def descriptions(value: Any) -> Iterator[str]:
    if isinstance(value, dict):
        if isinstance(value.get("description"), str):
            yield value["description"]
        for item in value.values():
            yield from descriptions(item)
    elif isinstance(value, list):
        for item in value:
            yield from descriptions(item)
