"""Groups of what hangs together by pairs."""

from collections.abc import Hashable, Iterable
from typing import TypeVar

Member = TypeVar("Member", bound=Hashable)


def groups_of(pairs: Iterable[tuple[Member, Member]]) -> list[list[Member]]:
    """What hangs together by pairs, group by group, in the order in which each is first named."""
    group_of: dict[Member, list[Member]] = {}
    for a, b in pairs:
        one, other = group_of.setdefault(a, [a]), group_of.setdefault(b, [b])
        if len(one) < len(other):
            one, other = other, one
        if one is not other:
            one += other
            group_of.update(dict.fromkeys(other, one))
    return list({id(group): group for group in group_of.values()}.values())
