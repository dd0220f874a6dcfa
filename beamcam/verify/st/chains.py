"""The structure of a trigger chain: each latch set once, behind its predecessor.

A chain that works by luck, because no point is passed twice, is told apart from one that is right.

    IF active[k - 1] AND NOT active[k] AND arrived THEN active[k] := TRUE; ... END_IF;
"""

from collections.abc import Iterator, Sequence

from beamcam.errors import Diagnostic, Source
from beamcam.verify.st import rules
from beamcam.verify.st.syntax import (
    Array,
    Assign,
    Binary,
    Case,
    Constant,
    Element,
    Expression,
    For,
    If,
    Name,
    Statement,
    Unary,
    Unit,
)

Latch = tuple[str, int]  #: array and index


def check_chains(units: Sequence[Unit], name: str) -> list[Diagnostic]:
    """What is wrong with the latches of a program; nothing for one without them."""
    return list(_faults(units, name))


def _faults(units: Sequence[Unit], name: str) -> Iterator[Diagnostic]:
    bounds = {
        v.name.upper(): v.type
        for u in units
        for v in u.variables
        if isinstance(v.type, Array) and v.type.of.upper() == "BOOL"
    }
    sets: dict[Latch, int] = {}

    def wrong(line: int, found: str, expected: str) -> Diagnostic:
        return rules.TRIGGER.at(Source(name, line), found=found, expected=expected)

    for unit in units:
        for block in unit.blocks:
            for condition, body, line in _guarded(block.body):
                wanted, barred = _latches(condition, False), _latches(condition, True)
                for array, k in _set(body):
                    if (array, k) in sets:
                        yield wrong(line, f"trigger {k} set twice", "each once")
                    sets[array, k] = line
                    first = array in bounds and bounds[array].low == k
                    if first:
                        continue
                    if (array, k - 1) not in wanted:
                        yield wrong(line, f"trigger {k} without {k - 1}", f"{k - 1} to be active")
                    if (array, k) not in barred:
                        yield wrong(line, f"trigger {k} without its latch", f"NOT {k}")
                for array, k in wanted:
                    if array not in bounds:
                        continue
                    if k < bounds[array].high and (array, k + 1) not in barred:
                        yield wrong(line, f"a test of trigger {k} alone", f"NOT {k + 1} as well")
                    if len(wanted) > 1:
                        yield wrong(line, "two triggers that are waited for", "one")
    for array, type_ in bounds.items():
        for k in range(type_.low, type_.high + 1):
            if sets and (array, k) not in sets:
                yield wrong(1, f"no operation that sets trigger {k} of {array}", "one")


def _guarded(
    body: Sequence[Statement], outer: tuple[Expression, ...] = ()
) -> Iterator[tuple[tuple[Expression, ...], Sequence[Statement], int]]:
    """Every body of an IF with all conditions that lead to it."""
    for one in body:
        if isinstance(one, If):
            for condition, inner in one.branches:
                yield (*outer, condition), inner, one.line
                yield from _guarded(inner, (*outer, condition))
            yield from _guarded(one.otherwise, outer)
        elif isinstance(one, Case):
            for _, inner in one.branches:
                yield from _guarded(inner, outer)
            yield from _guarded(one.otherwise, outer)
        elif isinstance(one, For):
            yield from _guarded(one.body, outer)


def _latches(conditions: Sequence[Expression], negated: bool) -> set[Latch]:
    found = set()
    for condition in conditions:
        for one in _conjuncts(condition):
            if negated and isinstance(one, Unary) and one.operator == "NOT":
                one = one.value
            elif negated:
                continue
            latch = _latch(one)
            if latch is not None:
                found.add(latch)
    return found


def _conjuncts(value: Expression) -> Iterator[Expression]:
    if isinstance(value, Binary) and value.operator == "AND":
        yield from _conjuncts(value.left)
        yield from _conjuncts(value.right)
    else:
        yield value


def _latch(value: Expression) -> Latch | None:
    if (
        isinstance(value, Element)
        and isinstance(value.base, Name)
        and isinstance(value.index, Constant)
    ):
        return value.base.name.upper(), int(value.index.value)
    return None


def _set(body: Sequence[Statement]) -> Iterator[Latch]:
    for one in body:
        if isinstance(one, Assign) and isinstance(one.value, Constant) and one.value.value is True:
            latch = _latch(one.target)
            if latch is not None:
                yield latch
