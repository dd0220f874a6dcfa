"""Options of the IFC reader."""

from collections.abc import Callable

from msgspec import Struct

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
