"""A saw and drilling line that LinuxCNC runs: the default one, told by other words.

M140 chooses a spindle, M142 saws, M143 and M144 describe the bar, M106 stops for a tool.
"""

from msgspec.structs import replace

from beamcam.machine import load
from beamcam.machine.machine import Machine

HEADER = ("G21 G17 G90 G91.1 G40 G94", "M144 P{width} Q{height}", "M143 P{section}")


def linuxcnc_cell(header: tuple[str, ...] = HEADER) -> Machine:
    """The machine, with the first words of its programs."""
    cell = load("beamline")
    words = replace(
        cell.words,
        header=header,
        saw=("G0 X{x}", "M142 P{angle} Q{feed}"),
        drill=(
            "M140 P{spindle} Q{diameter}",
            "G0 X{x} Y{y} Z{z}",
            "G0 X{x} Y{near_y} Z{near_z}",
            "M3 S{speed}",
            "M8",
            "G1 X{x} Y{bottom_y} Z{bottom_z} F{feed}",
            "G0 X{x} Y{y} Z{z}",
            "M9",
            "M5",
        ),
        footer=("M2",),
        change=("M106 P{spindle} Q{diameter}",),
    )
    form = replace(cell.format, feed_unit="mm/min")
    return replace(cell, name="linuxcnc-cell", controller="linuxcnc", words=words, format=form)
