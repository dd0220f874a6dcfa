"""Opening a model: bytes, zipped or not, to an ifcopenshell file."""

import io
import re
import zipfile
from typing import Any

from beamcam.errors import Diagnostic, Source
from beamcam.readers.ifc import rules

_SCHEMA = re.compile(rb"FILE_SCHEMA\s*\(\s*\(\s*'([^']*)'", re.IGNORECASE)
_KNOWN = re.compile(r"IFC(2X3(_TC1)?|4|4X3(_ADD[12]|_TC1)?)$", re.IGNORECASE)


def open_file(data: bytes, source: Source) -> Any | Diagnostic:
    """The file of a model's bytes, or what is wrong with them."""
    if data.startswith(b"PK"):
        unzipped = _unzip(data)
        if unzipped is None:
            return rules.SYNTAX.at(source, found="an archive without a model")
        data = unzipped
    schema = _SCHEMA.search(data[:200_000])
    if b"ISO-10303-21" not in data[:2000]:
        pointer = data.startswith(b"version https://git-lfs")
        return rules.SYNTAX.at(source, found="a Git LFS pointer" if pointer else "no STEP header")
    if schema is None:
        return rules.SYNTAX.at(source, found="no FILE_SCHEMA")
    name = schema[1].decode("latin-1")
    if not _KNOWN.match(name):
        return rules.SCHEMA.at(source, found=name)
    if re.search(rb"(?m)^\s*DATA\s*;", data) is None or b"END-ISO-10303-21" not in data[-4000:]:
        return rules.SYNTAX.at(source, found="a file that is cut short")
    import ifcopenshell

    from beamcam.readers.ifc.entities import open_model

    try:
        file = ifcopenshell.file.from_string(data.decode("latin-1"))
        open_model(file)  # a length unit that is not well formed makes all measures void
        return file
    except Exception as fault:  # the parser's own errors have no class of their own
        return rules.SYNTAX.at(source, found=str(fault) or type(fault).__name__)


def _unzip(data: bytes) -> bytes | None:
    """The model in an .ifczip."""
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            for name in archive.namelist():
                if name.lower().endswith(".ifc"):
                    return archive.read(name)
    except zipfile.BadZipFile:
        return None
    return None
