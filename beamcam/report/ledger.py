"""The ledger of a part's features as a line of text."""

from collections import Counter
from collections.abc import Iterable, Mapping

from beamcam.model.plan import Outcome

HOW = ("made", "merged", "duplicate", "skipped")


def ledger_of(outcomes: Iterable[Outcome]) -> str:
    """`ledger_line` of what became of each feature."""
    counted = tuple(outcomes)
    how = Counter[str](outcome.how for outcome in counted)
    return ledger_line(how, Counter(o.by for o in counted if o.how == "skipped"))


def ledger_line(how: Mapping[str, int], skipped_by: Mapping[str, int]) -> str:
    """ "12 read = 9 made + 2 merged + 1 skipped (1 plan-slot)"."""
    words = [f"{how[word]} {word}" for word in HOW if how.get(word)]
    reasons = ", ".join(f"{count} {code}" for code, count in sorted(skipped_by.items()))
    total = sum(how.get(word, 0) for word in HOW)
    return f"{total} read = {' + '.join(words) or '0 made'}{f' ({reasons})' if reasons else ''}"
