"""What an archive may hold: one model, whole."""

import io
import zipfile

import pytest

from beamcam.readers import read
from tests.unit.readers.ifc.models import Small


def plain() -> bytes:
    small = Small()
    small.element(small.extruded(small.ipe300(), 1000.0))
    return small.data


def zipped(way: int = zipfile.ZIP_DEFLATED, **members: bytes) -> bytes:
    held = io.BytesIO()
    with zipfile.ZipFile(held, "w", way) as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    return held.getvalue()


def broken(at: int, by: bytes) -> bytes:
    data = zipped(**{"a.ifc": plain()})
    return data[:at] + by + data[at + len(by) :]


def test_what_lies_beside_the_model_does_no_harm() -> None:
    data = zipped(**{"__MACOSX/._a.ifc": b"x", "read.me": b"y", "folder/A.IFC": plain()})
    assert len(read(data, "m.ifczip").parts) == 1


@pytest.mark.parametrize(
    ("data", "found"),
    [
        (zipped(**{"a.ifc": plain(), "b.ifc": plain()}), "an archive with 2 models"),
        (zipped(**{"a.ifcxml": b"<x/>"}), "an archive without a model"),
        (zipped(**{"a.ifc": plain()})[:200], "a damaged archive, "),
        (broken(60, b"\xff\xff\xff\xff"), "a damaged archive, "),
        (
            zipped(**{"a.ifc": plain()})[:40] + zipped(**{"a.ifc": plain()})[140:],
            "a damaged archive, ",
        ),
        (zipped(**{"a.ifc": b""}), "no STEP header"),
    ],
)
def test_an_archive_of_anything_but_one_model_is_refused(data: bytes, found: str) -> None:
    reading = read(data, "m.ifczip")
    (said,) = reading.diagnostics
    assert said.code == "ifc-syntax"
    assert said.message.startswith(f"found no IFC model ({found}")
    assert reading.parts == ()


def test_a_locked_archive_and_an_unknown_compression_are_refused() -> None:
    data = zipped(**{"a.ifc": plain()})
    central = data.rindex(b"PK\x01\x02")
    locked = bytearray(data)
    locked[6] = locked[central + 8] = 1
    packed = bytearray(data)
    packed[8] = packed[central + 10] = 99
    other = zipped(zipfile.ZIP_LZMA, **{"a.ifc": plain()})
    for case in (locked, packed, other):
        (said,) = read(bytes(case), "m.ifczip").diagnostics
        assert "(an archive that cannot be unpacked, " in said.message
