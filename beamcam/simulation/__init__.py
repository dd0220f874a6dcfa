"""The axes of a machine over time, from the events of a program.

text -> events (controllers) -> trace (program) -> rows of it, or registers sent by Modbus
                                bars by way of the segments of motion of the cell
"""

from beamcam.errors import error, note, warning

# fmt: off

LIMIT = warning("simulate-limit",
    "at {time} s found {axis} at {found} {unit}; expected {expected}",
    "The program drives an axis beyond the limits of the machine's file; the machine would stop.")
REACH = warning("simulate-reach",
    "at {time} s found {axis} at {found} {unit}; expected {expected}",
    "The head leaves the table, or the section is larger than the blade reaches across.")
COLLISION = warning("simulate-collision",
    "at {time} s found {one} and {other} overlapping by {found} mm, until {until} s; expected them "
    "apart",
    "Bodies of the machine file collide on the path of the program.")
TIPS = warning("simulate-tips",
    "at {time} s found the tips of {one} and {other} {first} and {second} mm deep from faces "
    "{size} mm apart; expected them not to meet",
    "Two drills that stroke from opposite faces at once, each as far as the middle, touch at their "
    "points; a hole through a wall needs no more than its thickness and the drill's point.")
ENDLESS = error("simulate-endless",
    "found a move that takes no time that is a number; expected a section and places that an axis "
    "can have",
    "A section of negative size, for one, gives the saw a way that has no length.")
PRECISION = note("simulate-precision",
    "one count of the encoder is {count} mm: corners are read up to {corner} mm off; the smallest "
    "step is {step} mm; {lost} of {moves} moves are below one count",
    "The controller cannot see anything smaller than one count of the encoder.")
MODBUS = error("verify-modbus",
    "found {found}; expected a Modbus TCP server that takes the registers",
    "The trace could not be sent; the server may be down, or its register map too small.")
CONTROLLER = error("monitor-controller",
    "found {found}; expected a controller that shows its axes over Modbus TCP",
    "The controller may be down, or its registers lie elsewhere (table `[modbus]`).")
PORT = error("simulate-port",
    "found {found}; expected an address of this machine with a port that is free",
    "Ports below 1024 belong to the administrator on most systems; 5020 is free as a rule.")
REGISTER = error("simulate-register",
    "found {axis} at {found}, beyond its register; expected {expected} at the scale {scale}",
    "A position that overflows its register would be shown elsewhere. Take a larger "
    '`modbus.scale`, or `modbus.values = "int32"` or "float".')
