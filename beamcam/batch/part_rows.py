"""What the account of a batch says of one program."""

from collections import Counter
from collections.abc import Mapping
from hashlib import sha256
from typing import cast

from beamcam.model.plan import ContourOp, stock_used
from beamcam.pipeline import Posted
from beamcam.planning.manual_list import manual_rows
from beamcam.reports.run import Ledger, PartRow, RestRow

#: Outcomes of a feature, as in the ledger.
OUTCOMES = ("made", "merged", "duplicate", "listed", "skipped")


def part_row(
    posted: Posted, name: str, content: bytes, timed: bool, rest: RestRow | None = None
) -> PartRow:
    """The row of a program; `rest` is the file of what it leaves to the next machine."""
    plan, machine, pieces = posted.plan, posted.job.machine, len(posted.job.pieces)
    part = posted.job.parts[0]
    how: list[str] = [outcome.how for outcome in plan.outcomes]
    ledger = {word: how.count(word) for word in OUTCOMES}
    used = stock_used(plan, posted.job.bar)
    bar = 0.0 if used is None or part.made is not None else used.length  # of a piece that comes cut
    mapped: Mapping[str, int] = {}  # curves by the keys of the machine's map of colours and layers
    if machine.torch is not None:
        from beamcam.planning.left_out import curves_by_key

        mapped = curves_by_key((part,), machine.torch.colours)
    passed_on = 0 if rest is None else rest["features"]
    ledger = {"read": len(how) + passed_on, **ledger, "passed_on": passed_on}
    skipped_by = (
        Counter(o.by for o in plan.outcomes if o.how == "skipped") if "skipped" in how else {}
    )
    return {
        "mark": part.mark, "quantity": max(part.quantity, pieces), "pieces": pieces,
        "profile": part.profile.name, "order": part.order, "phase": part.phase,
        "length": part.length, "machine": machine.name, "output": name,
        "sha256": sha256(content).hexdigest(), "rest": rest, "bar": bar,
        "ledger": cast(Ledger, ledger), "by_hand": manual_rows(plan),
        "skipped_by": dict(sorted(skipped_by.items())), "mapped": dict(sorted(mapped.items())),
        "tools": sorted({_tool_name(op) for op in plan.operations}),
        "operations": len(plan.operations), "stock": None,
        "machine_time_s": round(posted.time(machine).total_s, 3) if timed else None,
    }  # fmt: skip


def _tool_name(operation: object) -> str:
    tool = getattr(operation, "tool", None)
    if tool is not None:
        return f"{tool.kind} {tool.diameter:g}"
    return operation.row.process if isinstance(operation, ContourOp) else "saw"
