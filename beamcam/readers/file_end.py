"""Whether a file has come to its end, by what the last of it has to be in its format.

    M58.nc1  EN            a line of its own
    hall.ifc END-ISO-10303-21;
    P7.json  } or ]        the one that closes the whole text
    cut.dxf  EOF           the value of its last group, 0
    cut.svg  </svg>        the one that closes the drawing

A writer may pause in mid file for any time, so that a file which stays the same is not complete
for that alone.
"""

import os
import re

import msgspec

from beamcam.readers import FORMATS

TAIL_BYTES = 1 << 17  #: that are looked at; some writers leave remarks behind the end
_LAST_OF_NAME = {
    ".nc": re.compile(rb"^[ \t]*EN[ \t\x1a]*$", re.MULTILINE | re.IGNORECASE),
    ".ifc": re.compile(rb"END-ISO-10303-21\s*;"),
    ".ifczip": re.compile(rb"PK\x05\x06"),  # end of the directory, PKWARE APPNOTE 4.3.16
    ".json": re.compile(rb"[}\]]\s*$"),
    ".dxf": re.compile(rb"(?:^|\n)[ \t]*0\s*\n\s*EOF[\s\x1a]*$"),
    ".svg": re.compile(rb"(?:/|</(?:[\w.-]+:)?svg\s*)>(?:\s|<!--.*?-->|<\?.*?\?>)*$", re.DOTALL),
}
#: A DXF of bytes: its beginning, and the value EOF of its last group.
_BINARY_DXF = b"AutoCAD Binary DXF\r\n\x1a\0"
_BINARY_EOF = re.compile(rb"\0\0EOF\0+$")
_COMMENT = re.compile(rb"<!--.*?-->", re.DOTALL)
_SVG_TAG = re.compile(rb"<(/?)(?:[\w.-]+:)?svg\b[^>]*?(/?)>")
_LAST = {
    suffix: _LAST_OF_NAME.get(suffix, _LAST_OF_NAME.get(known.suffixes[0]))
    for known in FORMATS
    for suffix in known.suffixes
}


def has_end(path: str) -> bool:
    """Whether the end of a file's format stands in it; True of a format that has no certain end.

    A file that cannot be read counts as complete: its reader says what is wrong with it.
    """
    suffix = os.path.splitext(path)[1].lower()
    last = _LAST.get(suffix)
    if last is None:
        return True
    try:
        with open(path, "rb") as file:
            file.seek(max(0, file.seek(0, os.SEEK_END) - TAIL_BYTES))
            tail = file.read()
            file.seek(0)
            if suffix == ".dxf" and file.read(len(_BINARY_DXF)) == _BINARY_DXF:
                return _BINARY_EOF.search(tail) is not None
            if suffix != ".ifczip":
                tail = tail.replace(b"\0", b"").replace(b"\r", b"\n")  # of UTF-16, of old Macs
            if last.search(tail) is None:
                return False
            file.seek(0)
            torn = _TORN.get(suffix)
            return torn is None or not torn(file.read())
    except OSError:
        return True


def _is_torn(text: bytes) -> bool:
    """Whether a JSON text ends before its outermost bracket is closed."""
    try:
        msgspec.json.decode(text, type=msgspec.Raw)
    except msgspec.DecodeError as error:
        return "truncated" in str(error)
    return False


def _is_unclosed(drawing: bytes) -> bool:
    """Whether an SVG ends within its outermost element; drawings may stand in each other."""
    plain = _COMMENT.sub(b"", drawing.replace(b"\0", b""))
    tags = [(tag[1], tag[2]) for tag in _SVG_TAG.finditer(plain)]
    closed = sum(1 for closing, _ in tags if closing)
    opened = sum(1 for closing, alone in tags if not (closing or alone))
    return not tags or closed < opened or b"<!--" in plain


_TORN = {".json": _is_torn, ".svg": _is_unclosed}
