"""The ledger of a part's features as a line of text."""

from collections import Counter
from collections.abc import Iterable, Mapping

from beamcam.model.plan import Outcome
from beamcam.report.run import Ledger


def ledger_of(outcomes: Iterable[Outcome]) -> str:
    """`ledger_line` of what became of each feature."""
    counted = tuple(outcomes)
    how = Counter(outcome.how for outcome in counted)
    ledger: Ledger = {
        "read": len(counted), "made": how["made"], "merged": how["merged"],
        "duplicate": how["duplicate"], "listed": how["listed"], "skipped": how["skipped"],
    }  # fmt: skip
    return ledger_line(ledger, Counter(o.by for o in counted if o.how == "skipped"))


def ledger_line(ledger: Ledger, skipped_by: Mapping[str, int]) -> str:
    """ "12 read = 9 made + 2 merged + 1 skipped (1 plan-slot)"."""
    counts = {
        "made": ledger["made"], "merged": ledger["merged"], "duplicate": ledger["duplicate"],
        "listed": ledger["listed"], "skipped": ledger["skipped"],
    }  # fmt: skip
    words = [f"{count} {how}" for how, count in counts.items() if count]
    reasons = ", ".join(f"{count} {code}" for code, count in sorted(skipped_by.items()))
    shown = f" ({reasons})" if reasons else ""
    return f"{ledger['read']} read = {' + '.join(words) or '0 made'}{shown}"
