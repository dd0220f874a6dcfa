"""Formats that are not read, but known by name so that the message says what to export."""

import io
import zipfile

import pytest

from beamcam import readers
from tests.conftest import SAMPLES


def archive(*names):
    data = io.BytesIO()
    with zipfile.ZipFile(data, "w") as file:
        for name in names:
            file.writestr(name, b"content")
    return data.getvalue()


COREL_13 = b"RIFF\x10\0\0\0CDRDvrsn\x02\0\0\0\x14\x05"
COREL_X7 = archive("mimetype", "content/riffData.cdr", "metadata/metadata.xml")


@pytest.mark.parametrize(
    ("data", "name", "found"),
    [
        (COREL_13, "a.cdr", "RIFF CDRD"),
        (COREL_13, "a", "RIFF CDRD"),
        (COREL_13, "a.svg", "RIFF CDRD"),
        (COREL_13, "a.dxf", "RIFF CDRD"),
        (COREL_X7, "a.cdr", "an archive with content/riffData.cdr"),
        (COREL_X7, "a.ifczip", "an archive with content/riffData.cdr"),
        (b"WL\x01\0\0\0", "OLD.CDR", ".cdr"),
    ],
)
def test_coreldraw_is_told_by_name(data, name, found):
    reading = readers.read(data, name)
    (message,) = reading.diagnostics
    assert message.code == "read-coreldraw"
    assert message.message == (
        f"found a CorelDRAW file ({found}); expected a drawing as SVG or DXF: export it as SVG"
    )
    assert reading.refused
    assert not reading.parts


@pytest.mark.parametrize(
    ("data", "name", "code"),
    [
        (b"RIFF\x10\0\0\0WAVEfmt ", "a.wav", "read-format"),
        (archive("word/document.xml"), "a.docx", "read-other-format"),
        (b"", "a.cdr", "read-empty"),
    ],
)
def test_others_are_not_taken_for_coreldraw(data, name, code):
    assert [message.code for message in readers.read(data, name).diagnostics] == [code]


def test_a_drawing_under_a_wrong_suffix_is_read_by_its_content():
    drawing = (
        b'<svg xmlns="http://www.w3.org/2000/svg" width="10mm" height="10mm" viewBox="0 0 10 10">'
        b'<path d="M1 1h2v2h-2z" stroke="black" fill="none"/></svg>'
    )
    reading = readers.read(drawing, "saved.cdr")
    assert reading.parts
    assert not reading.refused


@pytest.mark.parametrize(
    ("data", "name", "found"),
    [
        (archive("word/document.xml"), "a.docx", "a document of Office; expected a part as DSTV"),
        (archive("parts/A.nc1"), "a.zip", "a zip archive; expected its files, unpacked"),
        (b"%PDF-1.7\n", "a.pdf", "a PDF; expected the drawing as DXF or SVG"),
        (
            b"ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('AP203_CONFIGURATION'));\nENDSEC;\n", "a.stp",
            "a STEP model (AP203_CONFIGURATION); expected the model exported as IFC",
        ),
    ],
)  # fmt: skip
def test_files_of_other_programs_are_told_by_name(data, name, found):
    (message,) = readers.read(data, name).diagnostics
    assert message.code == "read-other-format"
    assert message.message.startswith(f"found {found}")


def test_a_program_is_no_part_and_a_part_no_program():
    program = b"%\n( BEAMCAM 1 MACHINE beamline 0 )\nN10 G01 X0\n"
    for name in ("a.gcode", "a.nc", "a.ngc"):
        assert [d.code for d in readers.read(program, name).diagnostics] == ["read-program"]
    part = (SAMPLES / "dstv" / "tie.nc1").read_bytes()
    for name in ("tie.nc", "tie.nc1", "tie.gcode", "tie"):
        assert len(readers.read(part, name).parts) == 1
