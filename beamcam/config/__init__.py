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
`values` is what a configuration holds and where one lies, `load` reads it and says what is taken of
a stranger's; here are the rules of both.
"""

from beamcam.errors import error, warning

# fmt: off

UNREADABLE = error("config-file",
    "found no configuration that can be read ({found}); expected a TOML file",
    "The file given by --config does not exist, or the system does not let it be read.")
NOT_TOML = error("config-toml",
    "found no TOML ({found}); expected key = value, or a [table]",
    "The file breaks the rules of TOML at that line.")
UNKNOWN_KEY = error("config-key",
    "found unknown key {found!r}; expected {expected}",
    "A misspelt key would leave its default in force, so no key is ignored.")
WRONG_VALUE = error("config-value",
    "found {found} for {key!r}; expected {expected}",
    "The value is of the wrong kind, out of its range, or names something that does not exist.")
NO_DRILL = error("config-tolerance",
    "found a value for {key!r}, but {machine} has no drill; expected none",
    "A tolerance without effect would promise what is not done.")
TWO = error("config-two",
    "found {found} beside another input of the same job; expected one configuration for all of "
    "them, name it by --config",
    "Which of the two holds for the job would be a guess.")
UNUSED = warning("config-unused",
    "found a configuration in a folder below the inputs, which is not used; expected one beside "
    "the job",
    "All files of a run are made alike. Run that folder by itself, or name the file by --config.")

NOT_FOLLOWED = warning("config-trust",
    "found {found} in a configuration beside the inputs, not followed; expected {known} only. If "
    "the folder is yours, accept all of it by --trust {folder}",
    "What lies beside the inputs came with them. Machines, skips, clusters and the like come from "
    "the command line, --config, the folder that the command is called in and those above, or the "
    "user's own file. `beamcam config --trust FOLDER --remember` accepts a folder for good.")
NOT_REPEATED = error("config-trust-record",
    "found {found!r} in the record of a batch, which lies in another folder than yours; expected "
    "one in the folder of the command, above it, or among the user's own. If it is yours, accept "
    "it by --trust {folder}",
    "The record lies in the folder that is checked. If it were followed, the folder's author would "
    "choose the machine that its programs are compared by.")
