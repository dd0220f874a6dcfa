"""Parts and machines that the tests of the planner share."""

from typing import Any

from msgspec.structs import replace

from beamcam.errors import Source
from beamcam.machine import load
from beamcam.machine.machine import Machine
from beamcam.model.part import Feature, Hole, Part, Profile
from beamcam.model.plan import Plan
from beamcam.planning.beam import plan_oriented

SOURCE = Source("p.nc1", 7)
BEAM = Profile("I", "IPE300", 300.0, 150.0, 10.7, 7.1, 15.0)
CHANNEL = Profile("U", "UPN200", 200.0, 75.0, 11.5, 8.5, 11.5)
ANGLE = Profile("L", "L150*100*12", 150.0, 100.0, 12.0, 12.0, 12.0)
TUBE = Profile("M", "RHS200*120*8", 200.0, 120.0, 8.0, 8.0, 8.0)


def hole(x: float, y: float = 150.0, diameter: float = 18.0, face: str = "v", **more: Any) -> Hole:
    return Hole(face, x, y, diameter, more.pop("source", SOURCE), **more)


def part(*features: Feature, profile: Profile = BEAM, length: float = 3000.0, **more: Any) -> Part:
    return Part("P1", profile, length, SOURCE, features=tuple(features), **more)


def pusher(**more: Any) -> Machine:
    return replace(load("beamline-pusher"), **more)


def plan(*parts: Part, machine: str = "beamline-pusher", **more: Any) -> Plan:
    return plan_oriented(parts, load(machine), **more)
