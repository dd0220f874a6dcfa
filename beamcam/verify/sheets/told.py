"""What the head of a table's program says of its sheet and parts, held against those asked."""

from collections.abc import Collection, Iterator, Sequence

from beamcam.errors import Diagnostic
from beamcam.machine.machine import Machine
from beamcam.model.part import Part
from beamcam.verify.head import head_of, part_faults, stock_faults
from beamcam.verify.sheets.need import need_of, shift_of, thickness_of
from beamcam.verify.sheets.shared import places_of


def told_faults(
    text: str, parts: Sequence[Part], machine: Machine, skips: Collection[str], name: str
) -> Iterator[Diagnostic]:
    """All differences of the head that `text` begins with from the parts as they have to lie."""
    head = head_of(text)
    if head is None or machine.torch is None:
        return
    yield from stock_faults(
        head, parts, float(thickness_of(parts[0], machine.torch)), machine, name
    )
    if len(parts) == 1:
        places = [shift_of(need_of(parts[0], machine, machine.torch, skips), machine.torch)]
    else:
        places = [place for place, _ in places_of(parts, machine, machine.torch, skips)]
    lie = [*zip(parts, places, strict=True)]
    yield from part_faults(head, lie, machine.torch.tolerance, False, name)
