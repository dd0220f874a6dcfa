"""Rules for inputs whose format is not known yet."""

from beamcam.errors import error, warning

# fmt: off

EMPTY = error("read-empty",
    "found an empty file; expected a part or a drawing",
    "An export that failed often leaves a file without content.")
UNKNOWN_FORMAT = error("read-format",
    "found content of no known format; expected a file of one of {expected}",
    "The suffix is not known and the content looks like none of the formats.")
CORELDRAW = error("read-coreldraw",
    "found a CorelDRAW file ({found}); expected a drawing as SVG or DXF: export it as SVG",
    "CDR is a closed format; CorelDRAW writes SVG and DXF.")
OTHER_FORMAT = error("read-other-format",
    "found {found}; expected {expected}",
    "What other programs keep their work in says nothing of holes and cuts that could be trusted.")
PROGRAM = error("read-program",
    "found a program; expected parts (`beamcam verify`, `plot`, `report`, `simulate` and `recover` "
    "take programs)",
    "A program says what a machine does, and not what the part is.")
UNREADABLE = error("read-file",
    "found no file that can be read ({found}); expected one",
    "The file does not exist, or the system does not let it be read.")
FOLDER = error("read-folder",
    "found a folder; expected a file (`beamcam batch {found} -o OUT` posts the files of a folder, "
    "`check` its golden programs, `diff` compares two folders)",
    "This command takes files one by one.")
NOT_A_FILE = error("read-not-a-file",
    "found {found}; expected a plain file, or `-` for standard input",
    "A pipe or a device may have no end, or none that comes.")
ZEROS = error("read-zeros",
    "found {found} bytes that are all zero; expected a part, a drawing or a program",
    "A copy that was broken off leaves such a file; copy it again.")
ENCODING = error("read-encoding",
    "found bytes that are no {encoding} text; expected the alphabet that the file was written in, "
    "by --encoding",
    "Marks and names would show other characters than meant.")
OSCILLATION = warning("polynomial-oscillates",
    "found that {found}",
    "Between many nodes a polynomial swings; take fewer nodes, or several curves of up to five.")
NODES_LOST = error("polynomial-lost",
    "found a polynomial through {nodes} nodes that misses them by {found:.3g} mm, expected at most "
    "{expected:g} mm; take fewer nodes",
    "Its values cancel each other until no digit of them is left.")

RULES = (
    EMPTY,
    UNKNOWN_FORMAT,
    CORELDRAW,
    OTHER_FORMAT,
    PROGRAM,
    UNREADABLE,
    FOLDER,
    NOT_A_FILE,
    ZEROS,
    ENCODING,
    OSCILLATION,
    NODES_LOST,
)
