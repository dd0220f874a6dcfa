"""The JSON schema of a part in its JSON form, for editors and for programs that write parts."""

from beamcam.conversion.schema import Schema, schema_of
from beamcam.model.part_forms import PartForm
from beamcam.model.part_json import PART_SCHEMA


def part_schema() -> Schema:
    """JSON schema of the format `beamcam/part/1`."""
    schema = schema_of(PartForm)
    schema["$defs"]["PartForm"]["properties"]["schema"] = {"const": PART_SCHEMA}
    schema["$defs"]["CurveForm"] |= {"minProperties": 1, "maxProperties": 1}
    return schema
