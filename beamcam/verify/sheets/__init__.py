"""Programs of cutting tables read back and compared with the sheet that they should make.

Written from the controllers' documentation and the machine file; nothing is shared with planning,
motion or the emitters.

    text -> events (rs274 for LinuxCNC and grbl, codesys) -> strokes -> compared with the contours
"""

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

from beamcam.errors import Diagnostic, errors_in
from beamcam.machine.machine import Machine
from beamcam.model.part import Part

if TYPE_CHECKING:
    from beamcam.verify.sheets.events import Event
    from beamcam.verify.sheets.moves import Run

__all__ = ["events_of", "run", "verify_sheet"]


def events_of(
    text: str, machine: Machine, name: str = "program"
) -> "tuple[list[Event], list[Diagnostic]]":
    """What a program does, event by event, and what is wrong with its blocks."""
    done, said = run(text, machine, name)
    return done.events(), said


def run(text: str, machine: Machine, name: str = "program") -> "tuple[Run, list[Diagnostic]]":
    """What a program does, its moves as arrays, and what is wrong with its blocks."""
    if machine.controller == "codesys":
        from beamcam.verify.sheets import codesys

        per_minute = 60.0 if machine.format.feed_unit == "mm/s" else 1.0
        return codesys.run(text, name, machine.format.resolution, per_minute)
    from beamcam.verify.sheets import rs274
    from beamcam.verify.sheets.grbl import GRBL
    from beamcam.verify.sheets.linuxcnc import LINUXCNC

    dialect = {"linuxcnc": LINUXCNC, "grbl": GRBL}[machine.controller]
    return rs274.run(text, name, dialect)


def verify_sheet(
    text: str,
    parts: Sequence[Part],
    machine: Machine,
    skips: Collection[str] = (),
    name: str = "program",
) -> tuple[Diagnostic, ...]:
    """Everything that is wrong with a program, by itself and against the part of its sheet.

    `skips` are the kinds of features that may be missing, as `--allow-skips` names them. Nothing
    comes back for a program that makes exactly the part. Raises TypeError for a machine without a
    torch.
    """
    from beamcam.verify.sheets.compare import compare
    from beamcam.verify.sheets.need import need_of, rows_of, shift_of
    from beamcam.verify.sheets.strokes import strokes_of

    torch = machine.torch
    if torch is None:
        raise TypeError(f"{machine.name} has no torch")
    done, said = run(text, machine, name)
    if errors_in(said) or not parts:
        return tuple(said)
    (part,) = parts
    strokes, more = strokes_of(
        done,
        machine,
        torch,
        rows_of(part, torch),
        lambda blocks: events_of(blocks, machine)[0],
        name,
    )
    said += more
    need = need_of(part, torch, skips)
    said += need.said
    if need.curves or strokes.each:
        said += compare(strokes, need, machine, torch, shift_of(need, torch), name)
    return tuple(said)
