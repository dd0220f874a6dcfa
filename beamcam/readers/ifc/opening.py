"""Opening a model: its bytes, zipped or not."""

import io
import re
import struct
import zipfile
import zlib
from math import pi
from pathlib import PurePosixPath

from msgspec.structs import replace

from beamcam.budget import limits
from beamcam.errors import Diagnostic, Source
from beamcam.plain_text import fault_text
from beamcam.readers.ifc import rules
from beamcam.readers.ifc.entities import Model, scale_of
from beamcam.readers.ifc.records import File
from beamcam.readers.ifc.text import Malformed

_SCHEMA = re.compile(rb"FILE_SCHEMA\s*\(\s*\(\s*'([^']*)'", re.IGNORECASE)
#: Bytes that an archive may unpack to whatever its size, and how many times its size beyond: STEP
#: text packs to a tenth, a bomb to a thousandth.
MAX_UNPACKED = 64_000_000
MAX_RATIO = 50
_PIECE = 1 << 20
_PACKED = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_NO_MODEL = "an archive without a model"
_KNOWN = re.compile(r"IFC(2X3(_TC1)?|4|4X3(_ADD[12]|_TC1)?)$", re.IGNORECASE)


def open_file(data: bytes, source: Source) -> Model | Diagnostic:
    """The model of its bytes, or what is wrong with them."""
    if data.startswith(b"PK"):
        unzipped = _unzip(data)
        if isinstance(unzipped, str):
            return rules.SYNTAX.at(source, found=unzipped)
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
    try:  # STEP is plain ASCII, and exporters that are not write UTF-8 or Latin
        text = data.decode("utf-8")
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    try:
        file = File(text, name.upper().split("_")[0])
        # A length unit that is not well formed makes all measures void.
        units = [scale_of(file, kind) for kind in ("LENGTHUNIT", "PLANEANGLEUNIT", "MASSUNIT")]
    except Malformed as fault:
        return rules.SYNTAX.at(replace(source, line=fault.line), found=str(fault))
    except RecursionError:
        return rules.SYNTAX.at(source, found="values too deep inside one another")
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as fault:
        return rules.SYNTAX.at(source, found=fault_text(fault))
    metres, radians, kilograms = units
    return Model(file, data, metres * 1000, radians if 0 < radians < pi else 1.0, kilograms)


def _unzip(data: bytes) -> bytes | str:
    """The model in an .ifczip, or why there is none.

    Of two models one would be dropped. A Mac puts a file that begins with a dot beside each.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            names = [
                name for name in archive.namelist()
                if name.lower().endswith(".ifc") and not PurePosixPath(name).name.startswith(".")
            ]  # fmt: skip
            if len(names) != 1:
                return f"an archive with {len(names)} models" if names else _NO_MODEL
            one = archive.getinfo(names[0])
            if (way := one.compress_type) not in _PACKED:
                return f"an archive that cannot be unpacked, compression {way}, expected deflation"
            size, packed = one.file_size, len(data)
            if size > (most := max(MAX_UNPACKED, MAX_RATIO * packed)):
                return f"{packed} bytes that unpack to {size}, expected at most {most}"
            most, found = min(most, limits().bytes), bytearray()
            with archive.open(one) as file:  # the size that the directory says may be a lie
                while piece := file.read(_PIECE):
                    found += piece
                    if len(found) > most:
                        return f"an archive that unpacks to more than {most} bytes"
            return bytes(found)
    except (zipfile.BadZipFile, zlib.error, struct.error, EOFError, OSError, ValueError) as fault:
        return f"a damaged archive, {fault}"
    except (RuntimeError, NotImplementedError) as fault:  # a password, an unknown compression
        return f"an archive that cannot be unpacked, {fault}"
