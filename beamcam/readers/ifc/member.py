"""One member of a model after another: each is read, refused or left out, and counted."""

from collections import Counter
from collections.abc import Iterable
from typing import Any

from msgspec import Struct, field
from msgspec.structs import replace
from shapely.errors import ShapelyError

from beamcam.budget import MEMBER, InForce, OverTimeError, begin_member
from beamcam.errors import Diagnostic, Source, errors_in
from beamcam.geometry.plane import MAX_COORDINATE
from beamcam.model.part import Part
from beamcam.model.request import Options, Selection
from beamcam.model.section import STEEL_KG_MM3
from beamcam.readers.ifc import marks, rules
from beamcam.readers.ifc.body import Body, Swept, body_of
from beamcam.readers.ifc.checks import check_data, check_kernel, form_of
from beamcam.readers.ifc.entities import (
    NOT_WELL_FORMED,
    Entity,
    Model,
    Unreadable,
    features_of,
    open_file,
)
from beamcam.readers.ifc.finish import Shaped, part_of
from beamcam.readers.ifc.geometric import read_kernel, read_shell
from beamcam.readers.ifc.semantic import read_swept
from beamcam.readers.ifc.shell import Shell

SOLID_STEEL = 160.0  #: mm; a solid rectangle thicker than this without a material is not steel


#: The classes whose elements may be steel members, and the one that is read on request.
CLASSES = ("IfcBeam", "IfcColumn", "IfcMember", "IfcPlate", "IfcDiscreteAccessory")
PROXY = "IfcBuildingElementProxy"
VERDICTS = ("read", "refused", "left_out", "unselected")  #: of which each element has one
#: The values of a selection by what they are compared with.
KINDS = {"class": "classes", "mark": "marks", "guid": "guids", "assembly": "assemblies"}


class Taken(Struct):
    """Results of some members, in order."""

    members: list[tuple[int, Part, Shaped]] = field(default_factory=list)  #: behind their places
    diagnostics: list[Diagnostic] = field(default_factory=list)
    verdicts: Counter[str] = field(default_factory=Counter)  #: how many of each
    left_out: Counter[tuple[str, str]] = field(default_factory=Counter)  #: by reason and class
    seen: dict[str, set[str]] = field(default_factory=dict)  #: classes, marks, GlobalIds, ...

    def add(self, other: "Taken") -> None:
        """Take over the results of the members that follow these."""
        self.members += other.members
        self.diagnostics += other.diagnostics
        self.verdicts.update(other.verdicts)
        self.left_out.update(other.left_out)
        for key, values in other.seen.items():
            self.seen.setdefault(key, set()).update(values)


class Member(Struct, frozen=True):
    """An element with what is known of it before its geometry is looked at."""

    element: Entity
    source: Source
    data: marks.Data
    mark: str
    assembly: str


class KernelNeeded(Exception):
    """A member that only the kernel understands, where it may not build."""


class LeftOut(Exception):
    """An element that is no steel member; the text says what it is, none that it is not chosen."""


class Members(Struct):
    """The members of one model, and how they are to be read."""

    model: Model
    elements: list[Entity]
    name: str
    selection: Selection
    options: Options
    may_build: bool = True  #: whether the kernel may, which does not come back when its time is up
    taken: Taken = field(default_factory=Taken)

    @classmethod
    def of(cls, model: Model, name: str, selection: Selection, options: Options) -> "Members":
        """The members of a model that is open, in the order of their classes and of the file."""
        proxies = names_of("class", PROXY).intersection(map(plain_class, selection.classes))
        names = (*CLASSES, PROXY) if proxies else CLASSES  # of which none is above another
        elements = [one for each in names for one in model.file.by_type(each)]
        return cls(model, elements, name, selection, options)

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

    def build_here(self) -> None:
        """Let the kernel build in this process: it is one of those that end when time is up."""
        self.may_build = True

    def died(self, place: int) -> Taken:
        """The result of an element at which worker processes die."""
        self.taken = Taken()
        member = self._known(self.elements[place])
        self._is_selected(member)
        self.taken.diagnostics.append(rules.KERNEL_DIED.at(member.source))
        self.taken.verdicts["refused"] += 1
        return self.taken

    def share(self, places: Iterable[int]) -> Taken:
        """The results of the elements at these indices, each of them counted.

        A file that is not well formed refuses the member and no other.
        """
        self.taken = taken = Taken()
        for place in places:
            element, verdict = self.elements[place], "refused"
            source = Source(self.name, where=element.guid)
            begin_member()
            try:
                part, shaped, against = self._member(self._known(element))
                taken.diagnostics += against
                if not errors_in(against):
                    taken.members.append((place, part, shaped))
                    verdict = "read"
            except LeftOut as reason:
                verdict = "left_out" if (what := str(reason)) else "unselected"
                if what:
                    taken.left_out[what, element.is_a()] += 1
            except Unreadable as reason:
                taken.diagnostics.append(reason.rule.at(source, found=str(reason)))
            except OverTimeError:
                expected = f"{InForce.limits.member_s:g} s of the processor"
                taken.diagnostics.append(MEMBER.at(source, expected=expected))
            except (*NOT_WELL_FORMED, ShapelyError) as fault:
                found = f"data that are not well formed ({type(fault).__name__}: {fault})"
                taken.diagnostics.append(rules.GEOMETRY.at(source, found=found))
            taken.verdicts[verdict] += 1
        return taken

    def _known(self, element: Entity) -> Member:
        data, source = marks.data_of(self.model, element), Source(self.name, where=element.guid)
        return Member(
            element, source, data, marks.mark_of(element, data), marks.assembly_of(element, data)
        )

    def _is_selected(self, member: Member) -> bool:
        """Whether a member is selected; its names are noted."""
        if self.selection.everything:
            return True
        kind = member.element.is_a()
        own = {"class": kind, "mark": member.mark, "guid": member.element.guid}
        own["assembly"] = member.assembly
        meant = True
        for key, name in own.items():
            self.taken.seen.setdefault(key, set()).add(name)
            chosen = getattr(self.selection, KINDS[key])
            if key == "class":
                chosen = {*map(plain_class, chosen)}
            meant &= not chosen or not chosen.isdisjoint(names_of(key, name))
        return meant

    def _member(self, member: Member) -> tuple[Part, Shaped, list[Diagnostic]]:
        """The part of an element that is selected and steel, and what there is against it.

        Raises LeftOut or Unreadable.
        """
        element = member.element
        if not self._is_selected(member):
            raise LeftOut
        material = marks.material_of(self.model, element)
        what = next((one for one, words in marks.NOT_STEEL if words.search(material)), None)
        if what is None and element.Representation is None:
            accessory = element.is_a("IfcDiscreteAccessory")
            what = f"{'accessories' if accessory else 'elements'} without geometry"
        if what is not None:
            raise LeftOut(what)
        body: Body | None = None
        try:
            body = body_of(self.model, element)
            shaped = self._shape(member, body)
        except Unreadable as reason:
            shaped, body = self._by_kernel(member, reason), None
        if not shaped.length <= MAX_COORDINATE:
            raise Unreadable(f"a length of {shaped.length:g} mm")
        thick = shaped.section.code in ("B", "RU") and shaped.section.width > SOLID_STEEL
        if thick and not material:
            raise LeftOut("solid sections without a material")
        profile = body.base.profile if body is not None and isinstance(body.base, Swept) else None
        part = self._part(member, material, shaped, profile)
        return part, shaped, self._against(member, part, shaped, profile)

    def _against(
        self, member: Member, part: Part, shaped: Shaped, profile: Entity | None
    ) -> list[Diagnostic]:
        """What the file's data, the kernel and the reading itself have against a part."""
        source = member.source
        against = [*check_data(part, shaped, member.data, source), *shaped.diagnostics]
        if self.options.kernel and profile is not None:  # a shell is held against its own faces
            arguments = self.model, member.element, shaped, profile, Source(self.name)
            form = form_of(self.model, member.element)
            compared = self.model.once("compared", form, check_kernel, *arguments)
            against += compared.against(shaped, member.data, source)
        against += [rules.FITTED.at(source, found=kind) for kind in shaped.fitted]
        against += [rules.PIECES.at(source, found=text) for text in shaped.remarks]
        if projections := features_of(member.element, "projections"):
            against.append(rules.PROJECTION.at(source, found=len(projections)))
        return [*map(rules.forced, against)] if self.options.force else against

    def _shape(self, member: Member, body: Body) -> Shaped:
        """The member by its definition. Raises Unreadable."""
        if isinstance(body.base, Swept):
            return read_swept(self.model, member.element, body, member.source)
        if body.removed:
            raise Unreadable("cuts in a body that is given by its faces")
        form = form_of(self.model, member.element)
        # A model has most of its accessories many times.
        shaped = self.model.once("shell", form, self._shell, member, body.base)
        if isinstance(shaped, Unreadable):
            raise shaped.with_traceback(None)
        return shaped.at(member.source)

    def _shell(self, member: Member, base: Shell) -> Shaped | Unreadable:
        try:
            return read_shell(base, member.source)
        except Unreadable as reason:
            # A closed shell of planar faces is all that the kernel would have.
            reason.final |= base.volume is not None
            return reason

    def _by_kernel(self, member: Member, reason: Unreadable) -> Shaped:
        """The member as the kernel builds it, where its definition is not understood."""
        if reason.final:
            raise reason
        if not self.may_build:
            raise KernelNeeded
        try:
            shaped = read_kernel(self.model, member.element, member.source)
        except Unreadable as second:
            if second.rule is rules.KINKED:
                raise
            if reason.rule in rules.NOT_CUT or str(reason) == str(second):
                raise reason from None
            raise Unreadable(f"{reason}; by the kernel {second}", second.rule) from None
        denied = errors_in(shaped.diagnostics)
        if not denied:
            return shaped
        if reason.rule in rules.NOT_CUT:
            raise reason
        text = f"{reason}; by the kernel {rules.of_the_solid(denied[0])} than was read"
        raise Unreadable(text, reason.rule)

    def _part(self, member: Member, material: str, shaped: Shaped, profile: Entity | None) -> Part:
        section, source, data = shaped.section, member.source, member.data
        bare = section.profile("")
        label, wrong = marks.named(bare, marks.labels_of(self.model, member.element, profile, data))
        size = f"{bare.height:.1f} x {bare.width:.1f} mm"
        self.taken.diagnostics += (
            rules.PROFILE_NAME.at(source, found=one, size=size, expected=marks.name_of(bare))
            for one in wrong
        )
        grade, other = marks.grade_of(material, data)
        if other is not None:
            self.taken.diagnostics.append(rules.GRADE.at(source, found=other, expected=grade))
        if section.lips and section.lip is None:
            areas = f"{section.area / 100:.2f}", f"{(section.area - section.lips) / 100:.2f}"
            self.taken.diagnostics.append(rules.LIPS.at(source, found=areas[0], expected=areas[1]))
        # Of a plate it is in kg/m2.
        weight = STEEL_KG_MM3 * (1e6 * section.width if bare.code == "B" else 1e3 * section.area)
        return replace(
            part_of(shaped), mark=member.mark, profile=replace(bare, name=label), source=source,
            drawing=member.assembly, phase=data.text("phase"), grade=grade, weight=weight,
            guid=member.element.guid,
        )  # fmt: skip


def plain_class(name: str) -> str:
    """beam, for IfcBeam"""
    return name.lower().removeprefix("ifc")


def names_of(kind: str, value: str) -> set[str]:
    """The names by which a value is meant; a class also without StandardCase."""
    if kind != "class":
        return {value}
    name = plain_class(value)
    names = {name, name.removesuffix("standardcase")}
    return names | {"proxy"} if name == "buildingelementproxy" else names
