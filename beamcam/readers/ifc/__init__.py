"""IFC models: the steel members of a building as parts.

Importing this package costs nothing; ifcopenshell is loaded when a model is read.
"""

from beamcam.model.request import ALL, Options, Progress, Selection
from beamcam.readers import Reading

__all__ = ["ALL", "Options", "Progress", "Selection", "looks_like", "read"]

_STEP = b"ISO-10303-21"
_ZIP = b"PK\x03\x04"


def looks_like(data: bytes) -> bool:
    """Whether the bytes are an IFC model: a STEP file with an IFC schema, or one in a zip."""
    head = data[:60000].upper()
    if head.startswith(_ZIP):
        return b".IFC" in head
    return _STEP in head[:2000] and (b"IFC" in head or b"FILE_SCHEMA" in head)


def read(
    data: bytes,
    name: str,
    *,
    selection: Selection = ALL,
    options: Options | None = None,
    progress: Progress | None = None,
) -> Reading:
    """The steel members of a model, a part each with quantity 1, in the order of the file.

    `selection` says which members; the others are counted. Members that cannot be read, or whose
    data contradict their geometry, are errors that name their GlobalId; `Options.force` turns
    contradictions into warnings. `progress(done, of)` is called whenever some members are done.
    Never raises for bad input.
    """
    from beamcam.readers.ifc.reader import read_model

    return read_model(data, name, selection, options or Options(), progress)
