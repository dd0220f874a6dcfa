"""One member of a model after another: each is read, refused or left out, and counted."""

from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import suppress
from typing import Any

from msgspec import Struct, field
from msgspec.structs import replace
from shapely.errors import ShapelyError

from beamcam.errors import Diagnostic, Rule, Severity, Source
from beamcam.geometry.plane import MAX_COORDINATE
from beamcam.model.part import Part, Profile
from beamcam.readers.ifc import rules
from beamcam.readers.ifc.body import Body, Swept, body_of
from beamcam.readers.ifc.candidates import elements_of
from beamcam.readers.ifc.checks import STEEL, check_data, check_kernel, check_stock
from beamcam.readers.ifc.entities import (
    NOT_WELL_FORMED,
    Entity,
    Kinked,
    Model,
    NoSection,
    OddCut,
    Unreadable,
)
from beamcam.readers.ifc.finish import Shaped
from beamcam.readers.ifc.geometric import read_kernel, read_shell
from beamcam.readers.ifc.kernel import load
from beamcam.readers.ifc.marks import (
    Data,
    assembly_of,
    data_of,
    grade_of,
    label_of,
    mark_of,
    material_of,
    not_steel,
)
from beamcam.readers.ifc.naming import named, remark_at
from beamcam.readers.ifc.opening import open_file
from beamcam.readers.ifc.options import Options, Selection
from beamcam.readers.ifc.relations import features_of
from beamcam.readers.ifc.semantic import read_swept
from beamcam.readers.ifc.space import IDENTITY

SOLID_STEEL = 160.0  #: mm; a solid rectangle thicker than this without a material is not steel
CURVED = ("IfcRevolvedAreaSolid", "IfcSurfaceCurveSweptAreaSolid", "IfcSweptDiskSolid",
          "IfcFixedReferenceSweptAreaSolid", "IfcDirectrixCurveSweptAreaSolid",
          "IfcSweptDiskSolidPolygonal")  # fmt: skip
TAPERED = ("IfcExtrudedAreaSolidTapered", "IfcRevolvedAreaSolidTapered", "IfcSectionedSpine",
           "IfcSectionedSolidHorizontal")  # fmt: skip


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


class Members(Struct):
    """The members of one model, and how they are to be read."""

    model: Model
    elements: list[Entity]
    name: str
    selection: Selection
    options: Options
    taken: Taken = field(default_factory=Taken)
    kernel_done: dict[Any, tuple[Diagnostic, ...]] = field(default_factory=dict)

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
        first.share(range(min(1, len(self.elements))))

    def died(self, place: int) -> Taken:
        """The result of an element at which worker processes die."""
        self.taken = taken = Taken()
        element = self.elements[place]
        data = data_of(self.model, element)
        self._selected(element, mark_of(element, data)[0], assembly_of(element, data))
        self._refuse(rules.KERNEL_DIED, Source(self.name, where=element.guid), "two processes")
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
        before = self.taken.ledger.total
        try:
            return self._member(element)
        except (*NOT_WELL_FORMED, ShapelyError) as fault:
            if self.taken.ledger.total != before:
                raise  # it was counted already, so that the fault is ours
            found = f"data that are not well formed ({type(fault).__name__}: {fault})"
            self._refuse(rules.GEOMETRY, Source(self.name, where=element.guid), found)
            return None

    def _member(self, element: Entity) -> tuple[Part, Shaped] | None:
        """The part of one element, if it is selected, steel and readable."""
        source = Source(self.name, where=element.guid)
        data = data_of(self.model, element)
        mark, _ = mark_of(element, data)
        assembly = assembly_of(element, data)
        if not self._selected(element, mark, assembly):
            self.taken.ledger.unselected += 1
            return None
        material = material_of(self.model, element)
        what = not_steel(material)
        if element.is_a("IfcDiscreteAccessory") and element.Representation is None:
            what = what or "accessories without geometry"
        if what is not None:
            self._leave_out(what, element)
            return None
        try:
            body = body_of(self.model, element)
            shaped, profile = self._shape(element, body, source)
        except Unreadable as reason:
            found = self._by_kernel(element, source, reason)
            if found is None or self._denied(found, source, reason):
                return None
            shaped, profile, body = found, None, None
        if not shaped.length <= MAX_COORDINATE:
            self._refuse(rules.GEOMETRY, source, f"a length of {shaped.length:g} mm")
            return None
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
            said += self._kernel_check(element, body, part, shaped, profile, data)
        said += [rules.FITTED.at(source, found=kind) for kind in shaped.fitted]
        said += [rules.PIECES.at(source, found=text) for text in shaped.remarks]
        if projections := features_of(element, "IfcRelProjectsElement"):
            said.append(rules.PROJECTION.at(source, found=len(projections)))
        return [*map(rules.forced, said)] if self.options.force else said

    def _shape(self, element: Entity, body: Body, source: Source) -> tuple[Shaped, Entity | None]:
        if isinstance(body.base, Swept):
            return read_swept(self.model, element, body, source), body.base.profile
        taken = body.cutters(self.model, IDENTITY)
        return read_shell(body.base, taken, source, self.model.precision), None

    def _by_kernel(self, element: Entity, source: Source, reason: Unreadable) -> Shaped | None:
        """The member as the kernel builds it, where its definition is not understood."""
        kinds = {i.is_a() for i in _items_below(element) if not _is_straight(i)}
        for rule, names in ((rules.CURVED, CURVED), (rules.TAPERED, TAPERED)):
            for kind in names:
                if kind in kinds:
                    self._refuse(rule, source, kind)
                    return None
        if element.Representation is None:
            self._leave_out("elements without geometry", element)
            return None
        if isinstance(reason, NoSection):  # the kernel may take minutes to say the same
            self._refuse(rules.SECTION, source, str(reason))
            return None
        try:
            return read_kernel(self.model, element, source)
        except Kinked as kink:
            self._refuse(rules.KINKED, source, str(kink))
            return None
        except Unreadable as second:
            if isinstance(reason, OddCut):
                self._refuse(rules.ODD_CUT, source, str(reason))
                return None
            text = (
                str(reason) if str(reason) == str(second) else f"{reason}; by the kernel {second}"
            )
            rule = rules.SECTION if "section" in str(second) else rules.GEOMETRY
            self._refuse(rule, source, text)
            return None

    def _leave_out(self, what: str, element: Entity) -> None:
        self.taken.ledger.left_out[what, str(element.is_a())] += 1

    def _denied(self, found: Shaped, source: Source, reason: Unreadable) -> bool:
        """Refuse a member whose definition is not understood and whose solid is not explained."""
        denied = [d for d in found.said if d.severity is Severity.ERROR]
        if denied and isinstance(reason, OddCut):
            self._refuse(rules.ODD_CUT, source, str(reason))
        elif denied:
            text = denied[0].message.removeprefix("found ").split(" than the features")[0]
            rule = rules.SECTION if "section" in str(reason) else rules.GEOMETRY
            self._refuse(rule, source, f"{reason}; by the kernel {text} than was read")
        return bool(denied)

    def _refuse(self, rule: Rule, source: Source, found: str) -> None:
        self.taken.said.append(rule.at(source, found=found))
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
        bare = section.profile("")
        label, remark = named(bare, label_of(element, profile, data))
        if remark is not None:
            self.taken.said.append(remark_at(remark, bare, source))
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
            weight=_weight(bare, section.area),
            guid=element.guid,
            section=section.points,
        )

    def _kernel_check(
        self,
        element: Entity,
        body: Body,
        part: Part,
        shaped: Shaped,
        profile: Entity | None,
        data: Data,
    ) -> tuple[Diagnostic, ...]:
        """Kernel check of members with cuts, and of every section.

        A shell that is taken as it stands was held against its own faces.
        """
        from beamcam.readers.ifc.quantities import geometry_key

        key = geometry_key(part), round(shaped.section.area, 1)
        if key not in self.kernel_done:
            found: tuple[Diagnostic, ...] = ()
            if profile is not None:
                found += check_stock(self.model, element, part, shaped, profile)
            if body.removed:
                found += check_kernel(self.model, element, part, shaped, profile, data)
            self.kernel_done[key] = found
        return tuple(replace(d, source=part.source) for d in self.kernel_done[key])


def class_names(kind: str) -> set[str]:
    """The names by which a class is meant: itself, and without StandardCase."""
    name = kind.lower().removeprefix("ifc")
    names = {name, name.removesuffix("standardcase")}
    return names | {"proxy"} if name == "buildingelementproxy" else names


def _items_below(element: Entity) -> Iterator[Entity]:
    """All representation items of an element, through maps and booleans."""
    todo = []
    if element.Representation is not None:
        for representation in element.Representation.Representations:
            if representation.RepresentationIdentifier not in ("Axis", "Box", "FootPrint"):
                todo += list(representation.Items)
    seen = set[Entity]()
    while todo:
        item = todo.pop()
        if item in seen:  # shared, or geometry that contains itself
            continue
        seen.add(item)
        yield item
        if item.is_a("IfcMappedItem"):
            todo += list(item.MappingSource.MappedRepresentation.Items)
        elif item.is_a("IfcBooleanResult"):
            todo.append(item.FirstOperand)
        elif item.is_a("IfcCsgSolid"):
            todo.append(item.TreeRootExpression)


def _is_straight(item: Entity) -> bool:
    """Whether a solid is a disc or a ring that is swept along one line: a rod or a pipe."""
    if not item.is_a("IfcSweptDiskSolid"):
        return False
    line = item.Directrix
    return (line.is_a("IfcPolyline") and len(line.Points) == 2) or (
        line.is_a("IfcTrimmedCurve") and bool(line.BasisCurve.is_a("IfcLine"))
    )


def _weight(profile: Profile, area: float) -> float:
    """kg/m, of a plate kg/m2."""
    if profile.code == "B":
        return (profile.web_thickness or 0.0) * STEEL * 1e6
    return area * STEEL * 1e3
