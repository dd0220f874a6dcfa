"""The parts that a program makes, worked out from the program alone.

    bars     features made (verify/bars) -> pieces between the cuts -> parts
    sheets   strokes (verify/sheets) -> closed contours without leads and kerf -> one part

What comes back was proved: the program, read back against the parts, makes exactly them.
"""

from beamcam.errors import errors_in
from beamcam.machine.machine import Machine
from beamcam.recovery.bars import recover_bars
from beamcam.recovery.found import Recovered, Stock, with_marks

__all__ = ["Recovered", "Stock", "recover", "with_marks"]

STOCK = Stock()  #: of which nothing is known


def recover(text: str, machine: Machine, name: str = "program", stock: Stock = STOCK) -> Recovered:
    """The parts that a program makes, those of a bar in their order along it.

    `stock` is what is known of a bar; of a sheet the machine's file says it. Where an error
    is among what is said there are no parts.
    """
    if machine.torch is None:
        found = recover_bars(text, machine, name, stock)
    else:
        from beamcam.recovery.sheets import recover_sheet

        found = recover_sheet(text, machine, name)
    return Recovered((), found.said) if errors_in(found.said) else found
