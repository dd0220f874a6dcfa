"""A cutting table with one job's settings: the command line overrides the machine file."""

from collections.abc import Mapping
from typing import Any, Literal, get_args

from msgspec.structs import replace

from beamcam.machine.machine import Machine
from beamcam.machine.tables import TABLE_CONTROLLERS
from beamcam.machine.torch import KERF_STEPS, OTHERS, LayerSettings, Torch

Meaning = Literal["cut", "mark", "engrave", "ignore"]
MEANINGS: tuple[Meaning, ...] = get_args(Meaning)


def with_section(machine: Machine, corner: float | None, lip: float | None) -> Machine:
    """A coper with what a file may not say of its sections: of rectangular tubes the outer radius
    of their corners, of C sections the length of their lips.

    A machine that does not take such sections stays as it is.
    """
    coper = machine.coper
    if coper is not None and corner and "M" in coper.profiles:
        coper = replace(coper, corner=corner)
    if coper is not None and lip and "C" in coper.profiles:
        coper = replace(coper, lip=lip)
    return machine if coper is machine.coper else replace(machine, coper=coper)


def with_torch(
    machine: Machine, colours: Mapping[str, Meaning] | None = None, kerf: float | None = None,
    settings: Mapping[str, LayerSettings] | None = None,
    sheet_size: tuple[float, float] | None = None, amps: float | None = None,
    nozzle: str | None = None, **values: Any,
) -> Machine:  # fmt: skip
    """The machine with other values of its torch; itself if nothing is given.

    `sheet_size` is the length and width of the sheet, no larger than the table. `colours` are laid
    over those of the machine, before them, each with its `settings` or with none; `kerf` replaces
    that of every row to cut, and 0 turns compensation off. Of the rows to cut those with `amps` and
    of `nozzle` are left. `values` are fields of `Torch`; those
    that are None count as not given. Raises ValueError for a machine without a torch, without words
    for what is asked, or whose numbers cannot write it.
    """
    given = {name: value for name, value in values.items() if value is not None}
    if not (colours or given or sheet_size or kerf is not None or amps or nozzle):
        return machine
    torch = machine.torch
    if torch is None:
        raise ValueError(f"{machine.name} has no torch, so the option has no effect")
    if amps or nozzle:
        cuts = [row for row in torch.rows if row.process == "cut"]
        fitting = [
            row for row in cuts
            if row.amps == (amps or row.amps)
            and row.nozzle.casefold() == (nozzle or row.nozzle).casefold()
        ]  # fmt: skip
        if not fitting:
            wished = [f"{amps:g} A"] if amps else []
            wished += [f"the nozzle {nozzle!r}"] if nozzle else []
            has = ", ".join(sorted({f"{row.amps:g} A {row.nozzle}".strip() for row in cuts}))
            of = machine.name
            raise ValueError(f"{' and '.join(wished)}; the rows of {of} are for {has}")
        others = (row for row in torch.rows if row.process != "cut" or row in fitting)
        torch = replace(torch, rows=tuple(others))
    if sheet_size:
        if sheet_size[0] > torch.length or sheet_size[1] > torch.width:
            size = " x ".join(f"{v:g}" for v in sheet_size)
            raise ValueError(
                f"a sheet of {size} mm on the table of {machine.name}, which takes "
                f"{torch.length:g} x {torch.width:g} mm"
            )
        given["length"], given["width"] = sheet_size
    if colours:
        given["colours"] = {
            **{k: v for k, v in colours.items() if k != OTHERS},
            **{k: v for k, v in colours.items() if k == OTHERS},  # what none of them names
            **{k: v for k, v in torch.colours.items() if k not in colours},
        }
        given["settled"] = (*torch.settled, *(k for k in colours if k not in torch.settled))
        kept = {k: v for k, v in torch.settings.items() if k not in colours}
        given["settings"] = {**(settings or {}), **kept}
    if kerf is not None:
        least = KERF_STEPS * machine.format.resolution
        if 0.0 < kerf < least:
            takes = f"{machine.name} takes 0, or {least:g} mm or more"
            raise ValueError(f"a kerf of {kerf:g} mm; {takes}")
        cuts = [replace(row, kerf=kerf) if row.process == "cut" else row for row in torch.rows]
        kerf_by = "offset" if torch.kerf_by == "none" else torch.kerf_by
        given = {"rows": tuple(cuts), "kerf_by": kerf_by if kerf else "none", **given}
    changed: Torch = replace(torch, **given)
    if changed.kerf_by == "machine" and machine.words.left and torch.lead == "arc":
        # A controller takes up its compensation along a line.
        changed = replace(changed, lead="line")
    _check(machine, changed)
    return replace(machine, torch=changed)


def _check(machine: Machine, changed: Torch) -> None:
    """Raise ValueError where a machine cannot do what a job asks of its torch."""
    if changed.kerf_by == "machine" and not machine.words.left:
        raise ValueError(f"{machine.name} has no words to keep beside a contour; use offset")
    if changed.chain_cuts and machine.controller in TABLE_CONTROLLERS:
        raise ValueError(f"{machine.name} begins each contour by itself; leave chain cuts out")
    if changed.chain_cuts and changed.kerf_by != "offset":
        raise ValueError(
            f"chain cuts on {machine.name}, whose kerf is kept off by {changed.kerf_by}; expected "
            "it by offset, which knows where the torch goes"
        )
    if changed.lead != "none" and not changed.lead_in:
        raise ValueError(f"{machine.name} has no length of a lead-in; give one by --lead-in")
    if changed.origin != "table" and machine.controller in TABLE_CONTROLLERS:
        raise ValueError(
            f"{machine.name} begins at the switches in the corner of its table and counts from "
            "there, so that its origin is table; leave origin out"
        )
