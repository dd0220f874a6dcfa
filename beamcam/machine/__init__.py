"""Machines: TOML in, `Machine` out. All that differs from machine to machine is data here."""

from beamcam.machine.load import load, shipped
from beamcam.machine.machine import Machine

__all__ = ["Machine", "load", "shipped"]
