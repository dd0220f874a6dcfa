"""The shop's configuration: `beamcam.toml` beside the job, or the file given by `--config`.

    command line  over  beamcam.toml  over  the defaults

    machine = "beamline"                # name, or a path from the file's own folder
    stock_lengths = [6000, 12000]       # a part takes the shortest bar that it fits on
    allow_skips = ["cope"]
    name = "{mark}_{quantity}.gcode"    # of a batch's outputs

    [tolerances]                        # over those of the machine
    merge = 0.1

    [map]                               # what is done with a layer or a colour of a drawing
    "red" = "cut"
    "ENGRAVE" = "engrave"

Every key has a default, an unknown one is an error, and each value knows where it was set.
"""

from beamcam.config.apply import apply_map, apply_tolerances
from beamcam.config.keys import KEYS, TOLERANCES
from beamcam.config.load import CONFIG_NAME, Config, ConfigError, Setting, find, load

__all__ = [
    "CONFIG_NAME", "KEYS", "TOLERANCES", "Config", "ConfigError", "Setting", "apply_map",
    "apply_tolerances", "find", "load",
]  # fmt: skip
