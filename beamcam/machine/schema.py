"""The JSON schema of a machine file, for editors that complete and check TOML."""

from beamcam.conversion.schema import Schema, schema_of
from beamcam.machine.formula import Formula
from beamcam.machine.machine import MachineFile

#: Keys of a file that are not the machine's own.
BASE: Schema = {"type": "string", "description": "machine that this file is laid over"}
ARITHMETIC: Schema = {"type": ["string", "number"], "description": "arithmetic"}


def machine_schema() -> Schema:
    """JSON schema of a machine file. One that has a base need not repeat what is required."""
    schema = schema_of(MachineFile, {Formula: ARITHMETIC})
    records, whole = schema["$defs"], schema["$defs"]["MachineFile"]
    for record in records.values():
        record["properties"] = {k: _no_null(v) for k, v in record["properties"].items()}
    whole["properties"] = {"base": BASE, **whole["properties"]}
    required = [name for name in whole.pop("required") if name != "name"]  # or the file's own
    tables = {}
    for name, value in whole["properties"].items():
        record = records.get(value.get("$ref", "").rpartition("/")[2], {})
        if "required" in record:  # of a table, which is laid over that of the base
            tables[name] = {"required": record.pop("required")}
    whole["if"] = {"not": {"required": ["base"]}}
    whole["then"] = {"required": required, "properties": tables}
    return schema


def _no_null(value: Schema) -> Schema:
    """The schema of a value that may be left out; TOML has no null."""
    choices = value.get("anyOf", [])
    if {"type": "null"} not in choices:
        return value
    (choice,) = (choice for choice in choices if choice != {"type": "null"})
    return {**choice, **{k: v for k, v in value.items() if k not in ("anyOf", "default")}}
