"""The writer of the JSON form of a part."""

import json

from beamcam.model.part import Part
from beamcam.model.part_json import PART_SCHEMA, part_to_json
from beamcam.plain_text import json_text


def write(part: Part) -> str:
    """The part as JSON text of the schema `beamcam/part/1`, with a line end; numbers to the bit."""
    value = {"schema": PART_SCHEMA, **part_to_json(part)}
    return json_text(json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False)) + "\n"
