"""A DXF file that ezdxf does not read as it stands, repaired.

Subclass markers (group 100) put into polylines and splines that were written without them.

    0 LWPOLYLINE | 5 1F | 8 0 | 90 4 | 10 ...
    0 LWPOLYLINE | 5 1F | 100 AcDbEntity | 8 0 | 100 AcDbPolyline | 90 4 | 10 ...

Programs that read DXF by group codes alone take the one for the other; ezdxf looks for the markers.
In a file of R12, which has none, it takes what all entities have from what stands before the first.
"""

import io
import re
from itertools import takewhile

from beamcam.errors import Diagnostic, ReadError, Source
from beamcam.readers.dxf import rules
from beamcam.readers.dxf.layers import Document

#: The class that a marker names, of the entities that ezdxf refuses without it.
MARKERS = {b"LWPOLYLINE": b"AcDbPolyline", b"SPLINE": b"AcDbSpline"}
#: Groups of every entity. Source: Autodesk DXF reference, "Common group codes for entities".
IDENTITY = frozenset((b"5", b"330", b"360"))
COMMON = frozenset(
    (b"8", b"6", b"48", b"60", b"62", b"67", b"347", b"370", b"380", b"390", b"410", b"420",
     b"430", b"440", b"284")
)  # fmt: skip
R12 = 1009  #: and below: files without subclasses
VERSION = re.compile(rb"\$ACADVER\s+1\s+AC(\d{4})")
Group = tuple[bytes, bytes]  #: code and value


def with_subclasses(data: bytes) -> tuple[bytes, int]:
    """The text of a DXF file with the markers that were missing, and of how many entities."""
    lines = [line.strip(b"\r") for line in data.replace(b"\r\n", b"\n").split(b"\n")]
    groups = [(lines[k].strip(), lines[k + 1]) for k in range(0, len(lines) - 1, 2)]
    version = VERSION.search(data)
    is_old = version is None or int(version[1]) <= R12
    found: list[Group] = []
    count = k = 0
    while k < len(groups):
        found.append(groups[k])
        code, value = groups[k]
        k += 1
        marker = MARKERS.get(value.strip()) if code == b"0" else None
        if marker is None:
            continue
        own = list(takewhile(lambda group: group[0] != b"0", groups[k:]))
        k += len(own)
        if any(c == b"100" and v.strip() == marker for c, v in own):
            found += own
        else:
            found += _marked(own, marker, is_old)
            count += 1
    return b"".join(b"%b\n%b\n" % group for group in found), count


def _marked(own: list[Group], marker: bytes, is_old: bool) -> list[Group]:
    """The groups of an entity with both of its markers, each behind it what belongs to it."""
    identity: list[Group] = []
    common: list[Group] = []
    rest: list[Group] = []
    in_brackets = False
    for code, value in own:
        if code == b"102":  # names of objects that want to hear of changes
            in_brackets = value.strip().startswith(b"{")
            identity.append((code, value))
        elif in_brackets or code in IDENTITY:
            identity.append((code, value))
        elif code != b"100":
            (common if code in COMMON else rest).append((code, value))
    first = (b"100", b"AcDbEntity")
    head = [*identity, *common, first] if is_old else [*identity, first, *common]
    return [*head, (b"100", marker), *rest]


def recovered(data: bytes, source: Source, first: Exception) -> tuple[Document, Diagnostic]:
    """The document as far as it can be repaired. Raises ReadError if it cannot."""
    from ezdxf import recover

    try:
        document, auditor = recover.read(io.BytesIO(data))
    except Exception as error:  # as above: any kind of error means that repair failed
        raise ReadError(rules.STRUCTURE.at(source, found=said(error))) from error
    count = len(auditor.errors) + len(auditor.fixes)
    return document, rules.RECOVERED.at(source, count=count, found=said(first))


def said(error: Exception) -> str:
    """One line that says what ezdxf stumbled over; ids of unread entities are left out, since
    they are addresses in memory and differ from run to run."""
    text = re.sub(r"\(#\d{9,}\)", "", " ".join(str(error).split()))
    return text[:160] or type(error).__name__
