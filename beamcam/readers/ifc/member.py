"""One member of a model after another: each is read, refused or left out, and counted."""

from collections import Counter
from collections.abc import Hashable, Iterable
from contextlib import suppress
from typing import Any

from msgspec import Struct, field
from msgspec.structs import replace
from shapely.errors import ShapelyError

from beamcam.budget import MEMBER, OverTimeError, begin_member, limits
from beamcam.errors import Diagnostic, Severity, Source
from beamcam.geometry.plane import MAX_COORDINATE
from beamcam.model.part import Part
from beamcam.model.request import Options, Selection
from beamcam.readers.ifc import rules
from beamcam.readers.ifc.body import Body, Swept, body_of, refuse_bent
from beamcam.readers.ifc.checks import (
    STEEL,
    Compared,
    check_data,
    check_kernel,
    check_stock,
    form_of,
    settled,
)
from beamcam.readers.ifc.entities import (
    NOT_WELL_FORMED,
    Bent,
    Entity,
    Model,
    OddCut,
    OddSection,
    Unreadable,
    features_of,
)
from beamcam.readers.ifc.finish import Shaped
from beamcam.readers.ifc.geometric import read_kernel, read_shell
from beamcam.readers.ifc.kernel import load
from beamcam.readers.ifc.marks import (
    Data,
    assembly_of,
    data_of,
    grade_of,
    grades_apart,
    label_of,
    mark_of,
    material_of,
    name_of,
    named,
    not_steel,
    profile_set_names,
)
from beamcam.readers.ifc.opening import elements_of, open_file
from beamcam.readers.ifc.semantic import read_swept

SOLID_STEEL = 160.0  #: mm; a solid rectangle thicker than this without a material is not steel


class Ledger(Struct):
    """Account of every member of the file."""

    read: int = 0
    refused: int = 0
    unselected: int = 0
    left_out: Counter[tuple[str, str]] = field(default_factory=Counter)  #: by kind and class

    @property
    def total(self) -> int:
        return self.read + self.refused + self.unselected + sum(self.left_out.values())

    def add(self, other: "Ledger") -> None:
        self.read += other.read
        self.refused += other.refused
        self.unselected += other.unselected
        self.left_out.update(other.left_out)


class Taken(Struct):
    """Results of some members, in order."""

    members: list[tuple[int, Part, Shaped]] = field(default_factory=list)  #: behind their places
    said: list[Diagnostic] = field(default_factory=list)
    ledger: Ledger = field(default_factory=Ledger)
    seen: dict[str, set[str]] = field(default_factory=dict)  #: marks, GlobalIds, assemblies

    def add(self, other: "Taken") -> None:
        """Take over the results of the members that follow these."""
        self.members += other.members
        self.said += other.said
        self.ledger.add(other.ledger)
        for key, values in other.seen.items():
            self.seen.setdefault(key, set()).update(values)


class KernelNeeded(Exception):
    """A member that only the kernel understands, where it may not build."""


class Members(Struct):
    """The members of one model, and how they are to be read."""

    model: Model
    elements: list[Entity]
    name: str
    selection: Selection
    options: Options
    may_build: bool = True  #: whether the kernel may, which does not come back when its time is up
    taken: Taken = field(default_factory=Taken)
    compared: dict[Hashable, Compared] = field(default_factory=dict)  #: by their forms
    shells: dict[Hashable, Shaped | Unreadable] = field(default_factory=dict)  #: likewise

    @classmethod
    def of(cls, model: Model, name: str, selection: Selection, options: Options) -> "Members":
        """The members of a model that is open."""
        return cls(model, [*elements_of(model, selection)], name, selection, options)

    @classmethod
    def opened(cls, data: bytes, name: str, selection: Selection, options: Options) -> "Members":
        """The members of a model that was opened before, for a process that was started afresh."""
        model = open_file(data, Source(name))
        if isinstance(model, Diagnostic):
            raise AssertionError("a model that cannot be opened a second time")
        return cls.of(model, name, selection, options)

    def __reduce__(self) -> tuple[Any, ...]:
        """How another process has them: it opens the model again."""
        return Members.opened, (self.model.data, self.name, self.selection, self.options)

    def prepare(self) -> None:
        """Work out what the members have in common, so that processes need not each do so."""
        if self.options.kernel:
            with suppress(Unreadable):
                load(self.model)
        first = replace(self, options=replace(self.options, kernel=False), taken=Taken())
        first.may_build = False
        with suppress(KernelNeeded):
            first.share(range(min(1, len(self.elements))))

    def build_here(self) -> None:
        """Let the kernel build in this process: it is one of those that end when time is up."""
        self.may_build = True

    def died(self, place: int) -> Taken:
        """The result of an element at which worker processes die."""
        self.taken = taken = Taken()
        element = self.elements[place]
        data = data_of(self.model, element)
        self._selected(element, mark_of(element, data), assembly_of(element, data))
        where = Source(self.name, where=element.guid)
        self._refuse(rules.KERNEL_DIED.at(where))
        return taken

    def share(self, places: Iterable[int]) -> Taken:
        """The results of the elements at these indices."""
        self.taken = taken = Taken()
        for place in places:
            made = self._whole_member(self.elements[place])
            if made is not None:
                taken.members.append((place, *made))
        return taken

    def _whole_member(self, element: Entity) -> tuple[Part, Shaped] | None:
        """As `_member`; a file that is not well formed refuses the member and no other."""
        before, source = self.taken.ledger.total, Source(self.name, where=element.guid)
        begin_member()
        try:
            return self._member(element, source)
        except Unreadable as reason:
            self._refuse(reason.rule.at(source, found=str(reason)))
        except OverTimeError:
            expected = f"{limits().member_s:g} s of the processor"
            self._refuse(MEMBER.at(source, expected=expected))
        except (*NOT_WELL_FORMED, ShapelyError) as fault:
            if self.taken.ledger.total != before:
                raise  # it was counted already, so that the fault is ours
            found = f"data that are not well formed ({type(fault).__name__}: {fault})"
            self._refuse(rules.GEOMETRY.at(source, found=found))
        return None

    def _member(self, element: Entity, source: Source) -> tuple[Part, Shaped] | None:
        """The part of one element, if it is selected and steel. Raises Unreadable."""
        data = data_of(self.model, element)
        mark = mark_of(element, data)
        assembly = assembly_of(element, data)
        if not self._selected(element, mark, assembly):
            self.taken.ledger.unselected += 1
            return None
        material = material_of(self.model, element)
        what = not_steel(material)
        if what is None and element.Representation is None:
            accessory = element.is_a("IfcDiscreteAccessory")
            what = f"{'accessories' if accessory else 'elements'} without geometry"
        if what is not None:
            self._leave_out(what, element)
            return None
        body: Body | None = None
        profile: Entity | None = None
        try:
            body = body_of(self.model, element)
            shaped, profile = self._shape(element, body, source)
        except Unreadable as reason:
            shaped, body = self._by_kernel(element, source, reason), None
        if not shaped.length <= MAX_COORDINATE:
            raise Unreadable(f"a length of {shaped.length:g} mm")
        thick = shaped.section.code in ("B", "RU") and shaped.section.width > SOLID_STEEL
        if thick and not material:
            self._leave_out("solid sections without a material", element)
            return None
        part = self._part(element, shaped, profile, data, (mark, assembly, material), source)
        said = self._checked(element, body, part, shaped, profile, data)
        self.taken.said += said
        if any(d.severity is Severity.ERROR for d in said):
            self.taken.ledger.refused += 1
            return None
        self.taken.ledger.read += 1
        return part, shaped

    def _checked(
        self,
        element: Entity,
        body: Body | None,
        part: Part,
        shaped: Shaped,
        profile: Entity | None,
        data: Data,
    ) -> list[Diagnostic]:
        """What the file's data, the kernel and the reading itself have against a part."""
        source = part.source
        said = [*check_data(part, shaped, data, source), *shaped.said]
        if self.options.kernel and body is not None:
            compared = self._compared(element, body, shaped, profile, source)
            said += settled(compared, shaped, data)
        said += [rules.FITTED.at(source, found=kind) for kind in shaped.fitted]
        said += [rules.PIECES.at(source, found=text) for text in shaped.remarks]
        if projections := features_of(element, "IfcRelProjectsElement"):
            said.append(rules.PROJECTION.at(source, found=len(projections)))
        return [*map(rules.forced, said)] if self.options.force else said

    def _shape(self, element: Entity, body: Body, source: Source) -> tuple[Shaped, Entity | None]:
        if isinstance(body.base, Swept):
            return read_swept(self.model, element, body, source), body.base.profile
        if body.removed:
            raise Unreadable("cuts in a body that is given by its faces")
        form = self._form(element)
        if form not in self.shells:  # a model has most of its accessories many times
            try:
                self.shells[form] = read_shell(body.base, source)
            except Unreadable as reason:
                # A closed shell of planar faces is all that the kernel would have.
                reason.final |= body.base.volume is not None
                self.shells[form] = reason
        known = self.shells[form]
        if isinstance(known, Unreadable):
            raise known.with_traceback(None)
        return known.at(source), None

    def _by_kernel(self, element: Entity, source: Source, reason: Unreadable) -> Shaped:
        """The member as the kernel builds it, where its definition is not understood."""
        refuse_bent(element)
        if reason.final:
            raise reason
        if not self.may_build:
            raise KernelNeeded
        try:
            found = read_kernel(self.model, element, source)
        except Bent:
            raise
        except Unreadable as second:
            if isinstance(reason, OddCut) or str(reason) == str(second):
                raise reason from None
            kind = OddSection if isinstance(second, OddSection) else Unreadable
            raise kind(f"{reason}; by the kernel {second}") from None
        denied = [d for d in found.said if d.severity is Severity.ERROR]
        if denied and not isinstance(reason, OddCut):
            kind = type(reason)
            reason = kind(f"{reason}; by the kernel {rules.of_the_solid(denied[0])} than was read")
        if denied:
            raise reason
        return found

    def _leave_out(self, what: str, element: Entity) -> None:
        self.taken.ledger.left_out[what, str(element.is_a())] += 1

    def _refuse(self, said: Diagnostic) -> None:
        self.taken.said.append(said)
        self.taken.ledger.refused += 1

    def _selected(self, element: Entity, mark: str, assembly: str) -> bool:
        chosen = self.selection
        if chosen.everything:
            return True
        kind = element.is_a()
        values = {"mark": mark, "guid": element.guid, "class": kind, "assembly": assembly}
        for key, value in values.items():
            self.taken.seen.setdefault(key, set()).add(value)
        classes = {c.lower().removeprefix("ifc") for c in chosen.classes}
        return (
            (not chosen.marks or mark in chosen.marks)
            and (not chosen.guids or element.guid in chosen.guids)
            and (not classes or bool(classes & class_names(kind)))
            and (not chosen.assemblies or assembly in chosen.assemblies)
        )

    def _part(
        self,
        element: Entity,
        shaped: Shaped,
        profile: Entity | None,
        data: Data,
        names: tuple[str, str, str],
        source: Source,
    ) -> Part:
        mark, assembly, material = names
        section = shaped.section
        bare, flat = section.profile(""), section.code == "B"  # whose weight is in kg/m2
        labels = label_of(element, profile, data), *profile_set_names(self.model, element)
        label, wrong = named(bare, labels)
        size = f"{bare.height:.1f} x {bare.width:.1f} mm"
        self.taken.said += (
            rules.PROFILE_NAME.at(source, found=one, size=size, expected=name_of(bare))
            for one in wrong
        )
        grades = grades_apart(material, data)
        if grades is not None:
            self.taken.said.append(rules.GRADE.at(source, found=grades[0], expected=grades[1]))
        if section.lips:
            areas = f"{section.area / 100:.2f}", f"{(section.area - section.lips) / 100:.2f}"
            self.taken.said.append(rules.LIPS.at(source, found=areas[0], expected=areas[1]))
        return Part(
            mark=mark,
            profile=replace(bare, name=label),
            length=shaped.length,
            source=source,
            drawing=assembly,
            phase=data.text("Phase"),
            grade=grade_of(material, data),
            cuts=shaped.cuts,
            features=shaped.features,
            weight=STEEL * (1e6 * section.width if flat else 1e3 * section.area),
            guid=element.guid,
            section=section.points,
        )

    def _compared(
        self, element: Entity, body: Body, shaped: Shaped, profile: Entity | None, source: Source
    ) -> Compared:
        """What section and solid of the kernel have against a member, worked out once for a form.

        A shell that is taken as it stands was held against its own faces.
        """
        form = self._form(element)
        if form not in self.compared:
            solid = Compared()
            if isinstance(body.base, Swept):
                solid = check_kernel(self.model, element, shaped, profile, source)
            if profile is not None:
                stock = check_stock(self.model, element, shaped, profile, source)
                solid = replace(solid, said=(*stock, *solid.said))
            self.compared[form] = solid
        known = self.compared[form]
        fault = known.disputed and replace(known.disputed, source=source)
        said = tuple(replace(d, source=source) for d in known.said)
        return replace(known, said=said, disputed=fault)

    def _form(self, element: Entity) -> Hashable:
        """The form of an element; itself where that cannot be told."""
        try:
            return form_of(self.model, element)
        except (Unreadable, RecursionError):
            return element


def class_names(kind: str) -> set[str]:
    """The names by which a class is meant: itself, and without StandardCase."""
    name = kind.lower().removeprefix("ifc")
    names = {name, name.removesuffix("standardcase")}
    return names | {"proxy"} if name == "buildingelementproxy" else names
