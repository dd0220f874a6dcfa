"""The parts that a program makes, worked out from the program alone.

    bars     machined features (verify/bars) -> pieces between the cuts -> parts
    sheets   strokes (verify/sheets) -> closed contours without leads and kerf -> one part
    copers   strokes (verify/coping) -> what falls out of each wall without its scrap -> one part

What comes back was proved: the program, read back against the parts, makes exactly them.
"""

from beamcam.checks.job import head_of, head_remarks
from beamcam.errors import Source, errors_in
from beamcam.machine.machine import Machine
from beamcam.recovery import rules
from beamcam.recovery.bars import recover_bars
from beamcam.recovery.recovered import KnownStock, Recovered, with_marks

__all__ = ["KnownStock", "Recovered", "recover", "with_marks"]

STOCK = KnownStock()  #: of which nothing is known


def recover(
    text: str, machine: Machine, name: str = "program", stock: KnownStock = STOCK
) -> Recovered:
    """The parts that a program makes, those of a bar in their order along it.

    `stock` is what is known of the bar or the sheet. Where an error is among what is said there are
    no parts. A program that was made for another machine is remarked upon first.
    """
    head = head_of(text)
    diagnostics = tuple(head_remarks(head, machine, name))
    if machine.stock == "profile":
        from beamcam.recovery.copers import recover_coped

        recovered = recover_coped(text, machine, name, stock)
    elif machine.torch is None:
        recovered = recover_bars(text, machine, name, stock)
    else:
        from beamcam.recovery.sheets import recover_sheet

        recovered = recover_sheet(text, machine, name, stock.has_thickness)
    diagnostics += recovered.diagnostics
    if errors_in(diagnostics):
        return Recovered((), diagnostics)
    if head is not None and head.manual_work:
        diagnostics = (*diagnostics, rules.MANUAL_WORK.at(Source(name), found=head.manual_work))
    if head is not None and head.left_out:
        diagnostics = (*diagnostics, rules.LEFT_OUT.at(Source(name), found=head.left_out))
    return Recovered(recovered.parts, diagnostics, recovered.marked)
