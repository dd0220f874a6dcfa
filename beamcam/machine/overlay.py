"""A cutting table with one job's settings: the command line overrides the machine file."""

import re
from collections.abc import Mapping, Sequence
from typing import Any, Literal

from msgspec.structs import replace

from beamcam.conversion import Fault, converted
from beamcam.machine.faults import KERF_STEPS, TABLE_CONTROLLERS
from beamcam.machine.machine import Machine
from beamcam.machine.torch import OTHERS, LayerSettings, Torch, TorchRow

Meaning = Literal["cut", "mark", "engrave", "ignore"]
MEANINGS: tuple[Meaning, ...] = ("cut", "mark", "engrave", "ignore")


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
        torch = replace(torch, rows=_chosen(torch, machine.name, amps, nozzle))
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
        given = {**_kerf_values(machine, torch, kerf), **given}
    changed: Torch = replace(torch, **given)
    if changed.kerf_by == "machine" and machine.words.left and torch.lead == "arc":
        # A controller takes up its compensation along a line.
        changed = replace(changed, lead="line")
    _check(machine, changed)
    return replace(machine, torch=changed)


def _chosen(
    torch: Torch, name: str, amps: float | None, nozzle: str | None
) -> tuple[TorchRow, ...]:
    """The rows of a chart for a current and a nozzle or gas, and those of other processes."""
    cuts = [row for row in torch.rows if row.process == "cut"]
    fitting = [
        row for row in cuts
        if (not amps or row.amps == amps)
        and (not nozzle or row.nozzle.casefold() == nozzle.casefold())
    ]  # fmt: skip
    if not fitting:
        asked = " and ".join(
            [*([f"{amps:g} A"] if amps else []), *([f"the nozzle {nozzle!r}"] if nozzle else [])]
        )
        has = sorted({f"{row.amps:g} A {row.nozzle}".strip() for row in cuts})
        raise ValueError(f"{asked}; the rows of {name} are for {', '.join(has)}")
    return tuple(row for row in torch.rows if row.process != "cut" or row in fitting)


def _kerf_values(machine: Machine, torch: Torch, kerf: float) -> dict[str, Any]:
    """The fields of a torch that follow from the kerf of a job."""
    least = KERF_STEPS * machine.format.resolution
    if 0.0 < kerf < least:
        takes = f"{machine.name} takes 0, or {least:g} mm or more"
        raise ValueError(f"a kerf of {kerf:g} mm; {takes}")
    kerf_values: dict[str, Any] = {
        "rows": tuple(
            replace(row, kerf=kerf) if row.process == "cut" else row for row in torch.rows
        )
    }
    if kerf == 0.0:
        kerf_values["kerf_by"] = "none"
    elif torch.kerf_by == "none":
        kerf_values["kerf_by"] = "offset"
    return kerf_values


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


# --- more rows ------------------------------------------------------------------------------------

# Rows of a cut chart that a machine file adds to those of its base: `[[torch.more_rows]]`.
#
# A list in a machine file takes the place of the whole list of its base, so that a row more would
# need all of them again. Rows under `more_rows` are set among the others by their thickness; one of
# the same process, material and thickness takes the place of the other. One that names no material
# is of that of the base's rows of its process, if these are all of one.


ANY = "*"


def with_more_rows(table: dict[str, Any]) -> dict[str, Any]:
    """The table of a machine with its added rows among the others.

    The table itself where nothing is added, or where a row cannot be read: what is wrong with it is
    reported with its own key.
    """
    torch = table.get("torch")
    if not isinstance(torch, dict) or "more_rows" not in torch:
        return table
    rows, more = torch.get("rows", []), torch["more_rows"]
    if (
        not isinstance(rows, list)
        or not isinstance(more, list)
        or not all(_is_row(row) for row in (*rows, *more))
    ):
        return table
    others = {key: value for key, value in torch.items() if key != "more_rows"}
    return {**table, "torch": {**others, "rows": _merged(rows, more)}}


def _is_row(row: object) -> bool:
    try:
        converted(row, TorchRow)
    except Fault:
        return False
    return True


def _merged(rows: Sequence[dict[str, Any]], more: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """The rows in the order in which the first that fits counts."""
    rows_of_both = list(rows)
    for row in more:
        # A chart of one material is not left by a row that names none.
        own = {_key(other)[1]: other for other in rows if _key(other)[0] == _key(row)[0]}
        is_of_one = "material" not in row and len(own) == 1
        new = (
            row | {"material": next(iter(own.values())).get("material", ANY)} if is_of_one else row
        )
        same = [k for k, row in enumerate(rows_of_both) if _key(row) == _key(new)]
        if same:
            rows_of_both[same[0]] = new
        else:
            behind = (k for k, row in enumerate(rows_of_both) if _counts_before(new, row))
            rows_of_both.insert(next(behind, len(rows_of_both)), new)
    return rows_of_both


def _key(row: dict[str, Any]) -> tuple[str, str, float]:
    return row["process"], row.get("material", ANY).upper(), float(row["up_to"])


def _counts_before(new: dict[str, Any], row: dict[str, Any]) -> bool:
    """Whether a new row must precede another, which would match first otherwise."""
    process, material, up_to = _key(new)
    other, its_material, its_up_to = _key(row)
    if process != other:
        return False
    if material == its_material:
        return up_to < its_up_to
    return its_material == ANY


# --- former keys ----------------------------------------------------------------------------------

# Renamed keys of machine files: still read for one minor version, with a warning.
#
# `least_x` became `min_x` and `greatest_x` became `max_x`, in every table; others by name.


_FORMER = re.compile(r"^(least|greatest)(_|$)")
_PRESENT = {"least": "min", "greatest": "max"}
_WAS = re.compile(r"^(min|max)(_|$)")
_FORMERLY = {present: former for former, present in _PRESENT.items()}
#: Table and former key -> present key.
_RENAMED = {
    ("drill", "twin"): "same_tool_tolerance",
    ("times", "reload_s"): "manual_change_s",
    ("stroke", "start"): "retract",
    ("stroke", "near"): "approach",
    ("saw", "square"): "zero_angle",
}
_RENAMED_FROM = {(table, present): former for (table, former), present in _RENAMED.items()}
#: Tables whose keys are names that the user chooses.
_FREE = frozenset({"sections", "colours", "names", "default_for"})


class KeyTwice(ValueError):
    """A table has a key under both its former and its present name."""

    def __init__(self, former: str, present: str) -> None:
        super().__init__(former)
        self.former, self.present = former, present


def former_name(dotted: str) -> str:
    """A dotted key as it was called in the version before."""
    table, dot, key = dotted.rpartition(".")
    was = _RENAMED_FROM.get((table.rpartition(".")[2], key))
    was = was or _WAS.sub(lambda match: _FORMERLY[match[1]] + match[2], key, count=1)
    return f"{table}{dot}{was}"


def with_present_keys(table: dict[str, Any]) -> tuple[dict[str, Any], list[tuple[str, str]]]:
    """The table with its keys as this version names them, and (former, present) for each renamed.

    Former keys are dotted, as `axes.0.least`. Raises KeyTwice where both names stand in one table.
    """
    renamed: list[tuple[str, str]] = []
    return _table(table, "", renamed), renamed


def _table(table: dict[str, Any], prefix: str, renamed: list[tuple[str, str]]) -> dict[str, Any]:
    present: dict[str, Any] = {}
    of = prefix.rstrip(".").rpartition(".")[2]
    for key, value in table.items():
        name = _RENAMED.get((of, key))
        name = name or _FORMER.sub(lambda match: _PRESENT[match[1]] + match[2], key, count=1)
        if name != key:
            if name in table:
                raise KeyTwice(prefix + key, prefix + name)
            renamed.append((prefix + key, name))
        present[name] = value if key in _FREE else _value(value, f"{prefix}{key}.", renamed)
    return present


def _value(value: Any, prefix: str, renamed: list[tuple[str, str]]) -> Any:
    if isinstance(value, dict):
        return _table(value, prefix, renamed)
    if isinstance(value, list):
        return [_value(item, f"{prefix}{k}.", renamed) for k, item in enumerate(value)]
    return value
