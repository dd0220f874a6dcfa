"""The shop's configuration: `beamcam.toml` here, above and of the user, or the file of `--config`.

    command line  over  --config  or else  beside the inputs (what is harmless)  over  here
    over  above  over  the user's own    over  the defaults

    machine = "beamline"                # name, or a path from the file's own folder
    stock_lengths = [6000, 12000]       # a bar is the shortest that its parts fit on
    allow_skips = ["cope"]
    name = "{mark}_{quantity}.gcode"    # of a batch's outputs

    [tolerances]                        # over those of the machine
    merge = 0.1

    [map]                               # what is done with a layer or a colour of a drawing
    "red" = "cut"
    "ENGRAVE" = "engrave"

Every key has a default, an unknown one is an error, and each value knows where it was set.
`values` is what a configuration holds and how one is laid over another, `places` where they are
looked for, `trust` what is taken of a stranger's, `load` reads one, `apply` lays it over a machine.
"""
