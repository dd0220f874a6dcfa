"""Does the rest of the file agree with what was read of a member?"""

from collections.abc import Hashable, Iterator
from itertools import chain
from math import log
from typing import Any

from msgspec import Struct
from msgspec.structs import replace

from beamcam.errors import Diagnostic, Rule, Severity, Source
from beamcam.model.part import EndCuts, Part
from beamcam.model.section import STEEL_KG_MM3
from beamcam.readers.ifc import kernel, rules
from beamcam.readers.ifc.body import body_representation, relative_placement
from beamcam.readers.ifc.entities import Entity, Model, Unreadable, features_of
from beamcam.readers.ifc.finish import Shaped, part_of
from beamcam.readers.ifc.marks import Data
from beamcam.readers.ifc.profiles import definition
from beamcam.readers.ifc.same_solid import Fineness, differences
from beamcam.readers.ifc.section import BareStock, area_by_measures, plain_stock
from beamcam.readers.ifc.shell import extent
from beamcam.readers.ifc.solid_body import across
from beamcam.readers.ifc.space import Frame
from beamcam.solid.kernel import outline

LENGTH_SLACK = 1.0  #: mm; property sets are rounded
WEIGHT_SLACK = 0.06  #: share; of 177 real members all but two are within 0.03
WEIGHT_NEAR = 0.03  #: deviation from which on a weight is reported
VOLUME_NEAR = 0.01  #: deviation from which on a net volume is reported
CUBES = (1e9, 1e6, 1e3, 1.0, 25.4**3, 304.8**3)  #: mm3 in m3, dm3, cm3, mm3, cubic inch and foot
SMALL_WEIGHT = 0.1  #: kg below which a rounded weight says nothing
WITNESS_SLACK = 0.01  #: share by which the weight may be off for it to be a witness
SECTION_SLACK = 0.005  #: share of a section's area that its measures may leave out
FILM = 0.15  #: mm, half of what facets of a section may be off
LENGTH_SAME = 0.1  #: mm
FINE = Fineness(slack=0.13, facet_rad=kernel.ANGLE, chord=kernel.FINE_CHORD * 1e3)


def check_data(part: Part, shaped: Shaped, data: Data, source: Source) -> Iterator[Diagnostic]:
    """Contradictions of length, weight or volume in the property sets to the geometry."""

    def contradiction(rule: Rule, stated: float, expected: float) -> Diagnostic:
        texts = {"found": f"{stated:.2f}", "expected": f"{expected:.2f}"}
        return rule.at(source, where=where, **texts)

    where, length = data.number("length")
    extents = [part.length, shaped.gross, part.profile.height, part.profile.width]
    if length and part.profile.code != "B" and all(abs(length - e) > LENGTH_SLACK for e in extents):
        yield contradiction(rules.LENGTH, length, part.length)
    where, weight = data.number("weight")
    if weight > SMALL_WEIGHT:
        weights = [v * STEEL_KG_MM3 for v in (shaped.volume, shaped.section.area * shaped.gross)]
        near, far = (
            all(abs(weight - w) > SMALL_WEIGHT + share * w for w in weights)
            for share in (WEIGHT_NEAR, WEIGHT_SLACK)
        )
        if near:
            yield contradiction(rules.WEIGHT if far else rules.WEIGHT_NEAR, weight, weights[0])
    where, stated = data.number("volume")
    if stated:
        # Exporters write m3, mm3 or a cube of the file's own unit, whatever unit they declare: of
        # these the nearest counts. A figure of few digits is as good as its last one.
        digits = repr(stated).partition(".")[2]
        rounding = 0.5 * 0.1 ** len(digits) if "e" not in digits else 0.0
        cube = min(CUBES, key=lambda by: abs(log(stated * by / shaped.volume)))
        off = abs(stated * cube - shaped.volume)
        if off > VOLUME_NEAR * shaped.volume + rounding * cube:
            yield contradiction(rules.NET_VOLUME, stated * cube / 1e3, shaped.volume / 1e3)
    if data.cutouts is not None and not any(part.contours) and part.cuts == EndCuts():
        yield rules.CUTOUT.at(source, where=data.cutouts)


class KernelVerdict(Struct, frozen=True):
    """What the kernel has against a form that was read."""

    diagnostics: tuple[Diagnostic, ...] = ()
    disputed: Diagnostic | None = None  #: unless the net weight is the part's and not the solid's
    volume: float = 0.0  #: mm3 of the solid; 0 where there is none

    def against(self, shaped: Shaped, data: Data, source: Source) -> Iterator[Diagnostic]:
        """What it has against a member of the form, whose data may say that the solid is wrong."""
        for one in self.diagnostics:
            yield replace(one, source=source)
        if self.disputed is None:
            return
        where, weight = data.number("weight")
        own, its = (volume * STEEL_KG_MM3 for volume in (shaped.volume, self.volume))
        off = abs(weight - own)
        if weight and off <= WITNESS_SLACK * own and off < abs(weight - its) / 3:
            solid = rules.of_the_solid(self.disputed)
            yield rules.KERNEL_DENIED.at(source, found=solid, witness=where)
        else:
            yield replace(self.disputed, source=source)


def check_kernel(
    model: Model, element: Entity, shaped: Shaped, profile: Entity, source: Source
) -> KernelVerdict:
    """What section and solid of the kernel have against what was read of a swept member."""
    remarks: tuple[Diagnostic, ...] = ()
    try:
        stock = stock_of(model, element, shaped, profile)
        remarks = section_diagnostics(shaped, stock, source, True)
        built = kernel.built(model, element, kernel.FINEST if shaped.cutters else kernel.FINE)
    except Unreadable as reason:
        fault = rules.KERNEL.at(source, found=f"no solid ({reason})", expected="a solid")
        return KernelVerdict(remarks, fault)
    if built.error is not None:
        return KernelVerdict((*remarks, rules.KERNEL_LOG.at(source, found=built.error)))
    body = built.shell.moved(shaped.frame.inverse())
    low, high = extent(body, (1.0, 0.0, 0.0))
    if abs(high - low - shaped.length) > LENGTH_SAME:
        found, expected = f"a length of {high - low:.2f} mm", f"{shaped.length:.2f} mm"
        fault = rules.KERNEL.at(source, found=found, expected=expected)
        return KernelVerdict(remarks, fault, built.volume)
    diagnostics = differences(shaped, body, stock, FINE, built.volume).diagnostics(source)
    if any(d.severity is Severity.ERROR for d in diagnostics):
        return KernelVerdict(remarks, diagnostics[0], built.volume)
    return KernelVerdict((*remarks, *diagnostics), None, built.volume)


def section_diagnostics(
    shaped: Shaped, stock: BareStock, source: Source, swept: bool = False
) -> tuple[Diagnostic, ...]:
    """Whether the section that a body was cut from is the one that its part holds.

    Of open sections rounded toes and missing fillets count, but not slopes about the thickness
    that is given. Of others no figure of a part gives the inner roundings and the lips.
    """
    section, area, expected = shaped.section, stock.area, shaped.section.area
    if section.code in ("I", "U", "L", "T"):
        drawn = outline(part_of(shaped))
        more, less = (
            float(one.buffer(-FILM).buffer(FILM).area)
            for one in (stock.shape.difference(drawn), drawn.difference(stock.shape))
        )
        expected = area_by_measures(section.code, *section.sizes)
        area = expected + more - less
    if abs(area - expected) <= SECTION_SLACK * area:
        return ()
    rule = rules.OUTLINE if swept and section.code == "SO" else rules.SECTION_AREA
    return (rule.at(source, found=f"{area / 100:.2f}", expected=f"{expected / 100:.2f}"),)


def stock_of(model: Model, element: Entity, shaped: Shaped, profile: Entity) -> BareStock:
    """The section of a member's stock as the kernel builds it. Raises Unreadable."""
    section = shaped.section
    if section.code == "B" and abs(section.area - section.height * section.width) < 0.01:
        return plain_stock(section)
    key = definition(profile), section
    return model.once("stock", key, _built_stock, model, element, shaped.frame)


def _built_stock(model: Model, element: Entity, frame: Frame) -> BareStock:
    built = kernel.built(model, element, kernel.STOCK)
    body = built.shell.moved(frame.inverse())
    low, high = extent(body, (1.0, 0.0, 0.0))
    return BareStock(across(body, (low + high) / 2), built.volume / (high - low))


# --- form -----------------------------------------------------------------------------------------
# What a file says of a member's geometry, as a key: members of one form are one solid.
#
# What is worked out of a solid is kept under this key, never under what was read of it: two solids
# may be read alike, and only one of them be right.


def form_of(model: Model, element: Entity) -> Hashable:
    """Key of an element's class, its solid and its openings, in its own coordinates.

    Equal to the last digit or not equal; the element itself where it cannot be told.
    """
    try:
        openings = tuple(
            (relative_placement(model, element, one), *_solids(model, one))
            for one in features_of(element, "openings")
        )
        return element.type.name, *_solids(model, element), openings
    except (Unreadable, RecursionError):
        return element


def _solids(model: Model, element: Entity) -> list[int]:
    """The numbers of all that items say, down to their coordinates; equal ones share a number."""
    numbers: dict[Entity, int] = model.once("numbers of items", None, dict)
    number_of: dict[Hashable, int] = model.once("number_of of items", None, dict)

    def replaced(value: Any) -> Hashable:
        if isinstance(value, tuple):
            return tuple(map(replaced, value))
        return ("item", numbers.get(value, value)) if isinstance(value, Entity) else value

    items: tuple[Entity, ...] = body_representation(element).values[3]
    for one in chain.from_iterable(item.below(numbers) for item in items):
        named = "IfcProfileDef" in one.type.kinds  # of a profile its name does not matter
        key = one.type.name, replaced(one.values[2:] if named else one.values)
        numbers[one] = number_of.setdefault(key, len(number_of))
    return [numbers[item] for item in items]
