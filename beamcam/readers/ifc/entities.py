"""A model: its file opened, and common queries of it: units, placements, relations.

All lengths that leave this module are millimetres.
"""

import io
import re
import struct
import zipfile
import zlib
from collections import defaultdict
from collections.abc import Callable
from itertools import chain
from math import pi
from pathlib import PurePosixPath
from typing import Any, TypeVar

from msgspec import UNSET, Struct, UnsetType, field
from msgspec.structs import replace

from beamcam.budget import InForce
from beamcam.errors import Diagnostic, Rule, Source
from beamcam.plain_text import fault_text
from beamcam.readers.ifc import rules
from beamcam.readers.ifc.records import Entity as Entity
from beamcam.readers.ifc.records import File, Missing
from beamcam.readers.ifc.space import IDENTITY, Frame, Vec, across, cross, dot, scale, sub, unit
from beamcam.readers.ifc.text import Malformed

_DEEPEST = 8  #: of units that are defined by others


def scale_of(file: File, kind: str) -> float:
    """The model's unit of a kind in SI: LENGTHUNIT in m, PLANEANGLEUNIT in rad, MASSUNIT in kg.

    1 where the file has none of the kind; inches and degrees are so many of another unit. Raises
    ValueError, LookupError, TypeError or AttributeError for a unit that is not well formed.
    """
    projects = file.by_type("IfcProject")
    assignment = projects[0].UnitsInContext if projects else None
    units = assignment.Units if assignment is not None else ()
    named = (one for one in units if one.is_a("IfcNamedUnit") and one.UnitType == kind)
    if (unit := next(named, None)) is None:
        return 1.0
    by = 1.0
    for _ in range(_DEEPEST):
        if unit.is_a("IfcSIUnit"):
            from ifcopenshell.util.unit import prefixes

            # The base of mass is the gram, so that a kilogram has a prefix.
            base = 1e-3 if unit.Name == "GRAM" else 1.0
            return by * base * (1.0 if unit.Prefix is None else prefixes[unit.Prefix])
        by *= float(unit.ConversionFactor.ValueComponent.value)
        unit = unit.ConversionFactor.UnitComponent
    raise ValueError("a unit that is defined by itself")


Coordinates = tuple[float, ...]  #: an IfcCartesianPoint or an IfcDirection
Placement = tuple[Any, ...]  #: an IfcAxis2Placement: location, and one direction or two
Known = TypeVar("Known")


#: What a reference that is missing, or to the wrong kind of entity, ends in.
NOT_WELL_FORMED = (
    ArithmeticError, AttributeError, LookupError, RuntimeError, TypeError, ValueError,
)  # fmt: skip


class Unreadable(Exception):
    """Something in a member's geometry that the reader does not take; the text says what.

    `final` says that the solid of the kernel would be no other, so that it is not asked for.
    """

    def __init__(self, found: str, rule: Rule = rules.GEOMETRY, *, final: bool = False) -> None:
        super().__init__(found)
        self.rule = rule
        self.final = final


class Model(Struct):
    """An open file with its units and what was already worked out of it."""

    file: File
    data: bytes  #: for other processes, which open the file by themselves
    mm: float  #: mm in the file's length unit
    radians: float  #: radians in the file's plane angle unit
    kilograms: float  #: kg in the file's mass unit
    known: dict[Any, Any] = field(default_factory=dict)  #: by what it is and its key; see `once`

    def once(self, what: str, key: Any, made: Callable[..., Known], *of: Any) -> Known:
        """What a key stands for: `made(*of)`, worked out when it is first asked for."""
        at = what, key
        value: Known | UnsetType = self.known.get(at, UNSET)
        if value is UNSET:
            value = self.known[at] = made(*of)
        return value

    def point(self, c: Coordinates) -> Vec:
        """An IfcCartesianPoint of two or three coordinates, in mm."""
        mm = self.mm
        return (c[0] * mm, c[1] * mm, c[2] * mm if len(c) > 2 else 0.0)

    def axes(self, placement: Placement | None) -> Frame:
        """An IfcAxis2Placement2D or 3D, or the frame itself where there is none."""
        if placement is None:
            return IDENTITY
        return self.once("axes", placement, self._axes, placement)

    def _axes(self, placement: Placement) -> Frame:
        origin, ways = self.point(placement[0]), placement[1:]
        if len(ways) == 1:
            along = ratios(ways[0]) or (1.0, 0.0, 0.0)
            x = unit((*along[:2], 0.0))
            axes: tuple[Vec, ...] = x, (-x[1], x[0], 0.0)
        else:
            axis, reference = map(ratios, ways)
            z = (0.0, 0.0, 1.0) if axis is None else unit(axis)
            x = square_to((1.0, 0.0, 0.0) if reference is None else reference, z)
            axes = x, cross(z, x), z
        frame = Frame(origin, *axes)
        return IDENTITY if frame == IDENTITY else frame  # which costs nothing to multiply with

    def placement(self, entity: Entity | None) -> Frame:
        """An IfcObjectPlacement in the world, chained placements included."""
        if entity is None:
            return IDENTITY
        # A damaged file refers to numbers in its place.
        if not isinstance(entity, Entity) or not entity.is_a("IfcLocalPlacement"):
            raise Unreadable("a placement by something else")
        try:
            return self.once("placement", entity, self._placed, entity)
        except RecursionError:
            raise Unreadable("a placement that is relative to itself") from None

    def _placed(self, entity: Entity) -> Frame:
        above = self.placement(entity.PlacementRelTo)
        return above.times(self.axes(entity.RelativePlacement))

    def operator(self, entity: Entity) -> Frame:
        """An IfcCartesianTransformationOperator, its scales and mirrors included."""
        by = entity.Scale if entity.Scale is not None else 1.0
        # Of two dimensions it has no third axis, and if it is uniform no other scales.
        by_y, by_z = (
            by if (stated := getattr(entity, name, None)) is None else stated
            for name in ("Scale2", "Scale3")
        )
        z = unit(ratios(getattr(entity, "Axis3", None)) or (0.0, 0.0, 1.0))
        x = square_to(ratios(entity.Axis1) or (1.0, 0.0, 0.0), z)
        y = cross(z, x)
        drawn = ratios(entity.Axis2)
        if drawn is not None and dot(drawn, y) < 0:
            y = scale(y, -1.0)
        return Frame(self.point(entity.LocalOrigin), scale(x, by), scale(y, by_y), scale(z, by_z))


def ratios(c: Coordinates | None) -> Vec | None:
    """The components of an IfcDirection; None where there is none."""
    return None if c is None else (c[0], c[1], c[2] if len(c) > 2 else 0.0)


def square_to(v: Vec, axis: Vec) -> Vec:
    """The unit vector nearest to `v` that is square to the unit vector `axis`."""
    x, y, z = rest = sub(v, scale(axis, dot(v, axis)))
    if abs(x) < 1e-9 and abs(y) < 1e-9 and abs(z) < 1e-9:
        return across(axis)
    return unit(rest)


# --- relations ------------------------------------------------------------------------------------
# Objects related to elements: property sets, types, materials, assemblies.
#
# #9=IFCRELDEFINESBYPROPERTIES('guid',#5,$,$,(#49,#50),#58);     #58 to #49 and to #50
# #8=IFCRELAGGREGATES('guid',#5,$,$,#61,(#49,#50));              #61 to #49 and to #50

#: The relations by what they tie to elements, and which of their values that is; features are
#: openings and what is added.
RELATIONS = {
    "openings": (("IfcRelVoidsElement",), 5),
    "projections": (("IfcRelProjectsElement",), 5),
    "definitions": (("IfcRelDefinesByProperties",), 5),
    "types": (("IfcRelDefinesByType",), 5),
    "materials": (("IfcRelAssociatesMaterial",), 5),
    "wholes": (("IfcRelAggregates", "IfcRelNests"), 4),
}


def tied(element: Entity, what: str) -> list[Any]:
    """What relations tie to an element: its definitions, types, materials, wholes or features.

    Raises LookupError for an element that is not in the file, Malformed or LookupError if some
    relation of the kind is not well formed.
    """
    if isinstance(element, Missing):
        raise LookupError(f"a reference to {element.name}, which is not in the file")
    known = element.file.tied.get(what)
    if known is None:
        known = defaultdict(list)
        classes, place = RELATIONS[what]
        for relation in chain.from_iterable(map(element.file.by_type, classes)):
            values = relation.values
            near = values[9 - place]
            # None where a relation is cut short, so that only what is near it suffers.
            one = values[place] if place < len(values) else None
            for end in near if isinstance(near, tuple) else (near,):
                if isinstance(end, Entity):
                    known[end.number].append(one)
        element.file.tied[what] = known
    return known.get(element.number, [])


def features_of(element: Entity, what: str) -> list[Entity]:
    """The openings or projections of an element: its own, and those of its wholes.

    An opening in an assembly goes through all that it is made of.
    """
    if not tied(element, what) and not element.file.tied[what]:  # as of most models
        return []
    hosts = [element]
    for host in hosts:
        hosts += [whole for whole in tied(host, "wholes") if whole not in hosts]
    return [feature for host in hosts for feature in tied(host, what)]


# --- opening --------------------------------------------------------------------------------------

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
    except NOT_WELL_FORMED as fault:
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
            most, whole = min(most, InForce.limits.bytes), bytearray()
            with archive.open(one) as file:  # the size that the directory says may be a lie
                while piece := file.read(_PIECE):
                    whole += piece
                    if len(whole) > most:
                        return f"an archive that unpacks to more than {most} bytes"
            return bytes(whole)
    except (zipfile.BadZipFile, zlib.error, struct.error, EOFError, OSError, ValueError) as fault:
        return f"a damaged archive, {fault}"
    except (RuntimeError, NotImplementedError) as fault:  # a password, an unknown compression
        return f"an archive that cannot be unpacked, {fault}"
