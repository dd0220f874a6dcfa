"""What every part of the reader asks of an IFC file: units, placements, curves' axes.

All lengths that leave this module are millimetres.
"""

from math import pi
from typing import Any

import ifcopenshell
from msgspec import Struct, field

from beamcam.readers.ifc.space import IDENTITY, ORIGIN, Frame, Vec, across, cross, scale, sub, unit

_DIRECT = hasattr(ifcopenshell.entity_instance, "get_argument")  # since ifcopenshell 0.9

Entity = Any  #: an ifcopenshell entity instance; its attributes depend on the file's schema


def argument(entity: Entity, index: int) -> Any:
    """An attribute by its place, which is several times faster than by its name."""
    if _DIRECT:
        return entity.get_argument(index)
    return entity[index]


class Unreadable(Exception):
    """Something in a member's geometry that the reader does not take; the text says what."""


class Model(Struct):
    """An open file with its units and what was already worked out of it."""

    file: Any
    mm: float  #: mm in the file's length unit
    radians: float  #: radians in the file's plane angle unit
    kilograms: float  #: kg in the file's mass unit
    placements: dict[int, Frame] = field(default_factory=dict)
    outlines: dict[int, Any] = field(default_factory=dict)
    sections: dict[int, Any] = field(default_factory=dict)
    plates: dict[Any, Any] = field(default_factory=dict)
    classified: dict[Any, Any] = field(default_factory=dict)  #: sections by their outline
    psets: dict[int, dict[str, str | float]] = field(default_factory=dict)
    materials: dict[int, str] = field(default_factory=dict)

    def point(self, entity: Entity) -> Vec:
        """An IfcCartesianPoint of two or three coordinates."""
        c = argument(entity, 0)
        mm = self.mm
        return (c[0] * mm, c[1] * mm, c[2] * mm if len(c) > 2 else 0.0)

    def axes(self, entity: Entity | None) -> Frame:
        """An IfcAxis2Placement2D or 3D, or the frame itself where there is none."""
        if entity is None:
            return IDENTITY
        known = self.placements.get(entity.id())
        if known is None:
            known = self.placements[entity.id()] = self._axes(entity)
        return known

    def _axes(self, entity: Entity) -> Frame:
        origin = self.point(argument(entity, 0))
        if entity.is_a("IfcAxis2Placement2D"):
            direction = argument(entity, 1)
            x, y = direction[0][:2] if direction is not None else (1.0, 0.0)
            along = unit((x, y, 0.0))
            return Frame(origin, along, (-along[1], along[0], 0.0))
        axis, reference = ratios(argument(entity, 1)), ratios(argument(entity, 2))
        return Frame(origin, *right_handed(axis, reference))

    def placement(self, entity: Entity | None) -> Frame:
        """An IfcObjectPlacement in the world, chained placements included."""
        if entity is None:
            return IDENTITY
        known = self.placements.get(entity.id())
        if known is not None:
            return known
        if not entity.is_a("IfcLocalPlacement"):
            raise Unreadable(f"a placement by {entity.is_a()}")
        chain: list[Entity] = []
        while entity is not None and entity.id() not in self.placements:
            if not entity.is_a("IfcLocalPlacement"):
                raise Unreadable(f"a placement by {entity.is_a()}")
            if any(entity.id() == step.id() for step in chain):
                raise Unreadable("a placement that is relative to itself")
            chain.append(entity)
            entity = entity.PlacementRelTo
        frame = self.placements[entity.id()] if entity is not None else IDENTITY
        for step in reversed(chain):
            frame = frame.times(self.axes(step.RelativePlacement))
            self.placements[step.id()] = frame
        return frame

    def operator(self, entity: Entity) -> Frame:
        """An IfcCartesianTransformationOperator, its scales and mirrors included."""
        flat = entity.is_a("IfcCartesianTransformationOperator2D")
        origin = self.point(entity.LocalOrigin)
        by = entity.Scale if entity.Scale is not None else 1.0
        by_y = by_z = by
        if entity.is_a("IfcCartesianTransformationOperator3DnonUniform"):
            by_y = by if entity.Scale2 is None else entity.Scale2
            by_z = by if entity.Scale3 is None else entity.Scale3
        elif entity.is_a("IfcCartesianTransformationOperator2DnonUniform"):
            by_y = by if entity.Scale2 is None else entity.Scale2
        z: Vec = (0.0, 0.0, 1.0)
        if not flat and entity.Axis3 is not None:
            z = unit(ratios(entity.Axis3) or z)
        x = square_to(ratios(entity.Axis1) or (1.0, 0.0, 0.0), z)
        y = cross(z, x)
        drawn = ratios(entity.Axis2)
        if drawn is not None and sum(a * b for a, b in zip(drawn, y, strict=True)) < 0:
            y = scale(y, -1.0)
        return Frame(origin, scale(x, by), scale(y, by_y), scale(z, by_z))


def ratios(entity: Entity | None) -> Vec | None:
    """The components of an IfcDirection; None where there is none."""
    if entity is None:
        return None
    c = argument(entity, 0)
    return (c[0], c[1], c[2] if len(c) > 2 else 0.0)


def square_to(v: Vec, axis: Vec) -> Vec:
    """The unit vector nearest to `v` that is square to the unit vector `axis`."""
    along = sum(a * b for a, b in zip(v, axis, strict=True))
    rest = sub(v, scale(axis, along))
    if max(map(abs, rest)) < 1e-9:
        return across(axis)
    return unit(rest)


def right_handed(axis: Vec | None, reference: Vec | None) -> tuple[Vec, Vec, Vec]:
    """The axes of an IfcAxis2Placement3D by its Axis (z) and RefDirection (x)."""
    z = (0.0, 0.0, 1.0) if axis is None else unit(axis)
    x = square_to((1.0, 0.0, 0.0) if reference is None else reference, z)
    return x, cross(z, x), z


def open_model(file: Any) -> Model:
    """The file with its units: inches, metres, conversion-based units and degrees included."""
    from ifcopenshell.util.unit import calculate_unit_scale

    mm = calculate_unit_scale(file) * 1000
    angle = calculate_unit_scale(file, "PLANEANGLEUNIT")
    return Model(file, mm, angle if 0 < angle < pi else 1.0, _kilograms(file))


def _kilograms(file: Any) -> float:
    """kg in the mass unit; SI's base is the gram, so that a kilogram has a prefix."""
    for assignment in file.by_type("IfcUnitAssignment"):
        for one in assignment.Units:
            if getattr(one, "UnitType", None) == "MASSUNIT" and one.is_a("IfcSIUnit"):
                return {None: 1e-3, "KILO": 1.0, "MEGA": 1e3}.get(one.Prefix, 1.0)
            if getattr(one, "UnitType", None) == "MASSUNIT" and one.is_a("IfcConversionBasedUnit"):
                factor = one.ConversionFactor
                by = float(factor.ValueComponent.wrappedValue)
                base = factor.UnitComponent
                gram = base.is_a("IfcSIUnit") and base.Prefix is None
                return by * (1e-3 if gram else 1.0)
    return 1.0


__all__ = ["IDENTITY", "ORIGIN", "Entity", "Model", "Unreadable", "open_model", "ratios"]
