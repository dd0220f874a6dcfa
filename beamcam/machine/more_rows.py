"""Rows of a cut chart that a machine file adds to those of its base: `[[torch.more_rows]]`.

A list in a machine file takes the place of the whole list of its base, so that a row more would
need all of them again. Rows under `more_rows` are set among the others by their thickness; one of
the same process, material and thickness takes the place of the other. One that names no material
is of that of the base's rows of its process, if these are all of one.
"""

from collections.abc import Sequence
from typing import Any

from beamcam.conversion import Fault, converted
from beamcam.machine.torch import TorchRow

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
    found = list(rows)
    for row in more:
        # A chart of one material is not left by a row that names none.
        own = {_key(other)[1]: other for other in rows if _key(other)[0] == _key(row)[0]}
        is_of_one = "material" not in row and len(own) == 1
        new = (
            row | {"material": next(iter(own.values())).get("material", ANY)} if is_of_one else row
        )
        same = [k for k, row in enumerate(found) if _key(row) == _key(new)]
        if same:
            found[same[0]] = new
        else:
            behind = (k for k, row in enumerate(found) if _counts_before(new, row))
            found.insert(next(behind, len(found)), new)
    return found


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
