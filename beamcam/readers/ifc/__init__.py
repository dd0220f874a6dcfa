"""IFC models: the steel members of a building as parts.

Importing this package costs nothing; ifcopenshell is loaded when a model is read.
"""

from collections.abc import Callable

from msgspec import Struct

from beamcam.readers.content import Reading

__all__ = ["ALL", "Options", "Progress", "Selection", "looks_like", "read"]

Progress = Callable[[int, int], None]  #: members done, members in all


class Selection(Struct, frozen=True):
    """Which members are meant; of each kind any of the values, and every kind that is given."""

    marks: frozenset[str] = frozenset()
    guids: frozenset[str] = frozenset()
    classes: frozenset[str] = frozenset()  #: IfcBeam or beam; naming a class also reads proxies
    assemblies: frozenset[str] = frozenset()

    @property
    def everything(self) -> bool:
        return not (self.marks or self.guids or self.classes or self.assemblies)


ALL = Selection()


class Options(Struct, frozen=True):
    """Options for reading members."""

    force: bool = False  #: contradictions are warnings
    kernel: bool = False  #: every distinct member is also built by the geometry kernel and compared
    bolts: bool = True  #: holes from bolts where the solids have none
    clearance: float | None = None  #: mm of a hole over its bolt; None is by the bolt's standard
    letter: bool = False  #: every member gets its mark as a text
    workers: int = 1  #: processes that read the members of a large model side by side
    apart: bool = False  #: the kernel builds in another process, which ends when its time is up


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
