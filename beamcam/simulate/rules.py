"""What can go wrong while a trace is sent."""

from beamcam.errors import Rule, Severity

MODBUS = Rule(
    "verify-modbus",
    Severity.ERROR,
    "found {found}; expected a Modbus TCP server that takes the registers",
    "The trace could not be sent; the server may be down, or its register map too small.",
)

RULES = (MODBUS,)
