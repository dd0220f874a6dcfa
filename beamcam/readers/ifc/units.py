"""The units of a model: what its numbers are in metres, radians and kilograms."""

from beamcam.readers.ifc.records import Entity, File

_PREFIXES = {
    None: 1.0, "EXA": 1e18, "PETA": 1e15, "TERA": 1e12, "GIGA": 1e9, "MEGA": 1e6, "KILO": 1e3,
    "HECTO": 1e2, "DECA": 1e1, "DECI": 1e-1, "CENTI": 1e-2, "MILLI": 1e-3, "MICRO": 1e-6,
    "NANO": 1e-9, "PICO": 1e-12, "FEMTO": 1e-15, "ATTO": 1e-18,
}  # fmt: skip
_DEEPEST = 8  #: of units that are defined by others


def scale_of(file: File, kind: str) -> float:
    """The model's unit of a kind in SI: LENGTHUNIT in m, PLANEANGLEUNIT in rad, MASSUNIT in kg.

    1 where the file has none of the kind. Raises ValueError, LookupError, TypeError or
    AttributeError for a unit that is not well formed.
    """
    projects = file.by_type("IfcProject")
    assignment = projects[0].UnitsInContext if projects else None
    for unit in assignment.Units if assignment is not None else ():
        if unit.is_a("IfcNamedUnit") and unit.UnitType == kind:
            return _scale(unit)
    return 1.0


def _scale(unit: Entity) -> float:
    """A named unit in SI units; inches and degrees are so many of another unit."""
    by = 1.0
    for _ in range(_DEEPEST):
        if unit.is_a("IfcSIUnit"):
            # The base of mass is the gram, so that a kilogram has a prefix.
            base = 1e-3 if unit.Name == "GRAM" else 1.0
            return by * _PREFIXES[unit.Prefix] * base
        factor = unit.ConversionFactor
        by *= float(factor.ValueComponent.value)
        unit = factor.UnitComponent
    raise ValueError("a unit that is defined by itself")
