"""Writing a part and reading it back gives the same part."""

from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from msgspec.structs import replace

from beamcam.errors import Source
from beamcam.model import part_json as json_writer
from beamcam.model.part import Part
from beamcam.readers import part_json
from beamcam.readers.dstv import read, read_with_account
from beamcam.writers import dstv as dstv_writer
from tests.conftest import examples
from tests.property.part_strategies import parts

SAMPLES = sorted((Path(__file__).parents[2] / "samples" / "dstv").glob("*.nc1"))
NOWHERE = Source("")

SETTINGS = settings(
    max_examples=examples(120),
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much],
)


def without_places(part: Part) -> Part:
    """The part without the files and lines that it came from."""
    return replace(
        part,
        source=NOWHERE,
        cut_lines=None,
        features=tuple(replace(feature, source=NOWHERE) for feature in part.features),
        planes=tuple(replace(plane, source=NOWHERE) for plane in part.planes),
    )


def through_of(lines: set[int]):
    """What a feature that is read on one of these lines was: blind, and is through."""

    def of(feature, again):
        if again.source.line not in lines:
            return feature
        assert feature.kind == "blind"
        return replace(feature, kind="through", depth=None)

    return of


@SETTINGS
@given(parts())
def test_reading_what_was_written_gives_the_part(part):
    text = dstv_writer.write(part)
    reading, account = read_with_account(text.encode(), "written.nc1")
    (again,) = reading.parts
    deep = {d.source.line for d in reading.diagnostics if d.code == "dstv-hole-through"}
    if deep:  # as deep as the wall is: a hole through it, and written as one from then on
        part = replace(part, features=tuple(map(through_of(deep), part.features, again.features)))
    assert without_places(again) == without_places(part)
    assert dstv_writer.write(again) == (dstv_writer.write(part) if deep else text)
    assert account.lost == []


@SETTINGS
@given(parts())
def test_json_gives_the_part_to_the_last_bit(part):
    reading = part_json.read(json_writer.write(part).encode(), "part.json")
    assert reading.diagnostics == ()
    assert reading.parts == (part,)


@pytest.mark.parametrize("path", SAMPLES, ids=lambda path: path.stem)
def test_samples_come_back(path):
    (part,) = read(path.read_bytes(), path.name).parts
    (again,) = read(dstv_writer.write(part).encode(), "written.nc1").parts
    assert without_places(again) == without_places(part)
    assert part_json.read(json_writer.write(part).encode(), "part.json").parts == (part,)
