"""Places where three ends or more meet: what closes there, what branches off, and what goes on.

    --o--      of the ring and the branch that meet at o, the ring closes and the branch ends;
     / \\       of two rings both close; of a contour and a branch the contour goes on.
     \\_/

A chain that leads back to its place is a ring of its own. Of the others, those that lead to
nowhere are branches, unless all of them do. Two that are left go on into one another. Each of
these steps may make more rings or branches elsewhere, so they are repeated until nothing changes.
"""

from collections.abc import Callable, Iterable, Sequence

from msgspec import Struct


class Resolved(Struct, frozen=True):
    """What becomes of the ends that meet."""

    joins: list[tuple[int, int]]  #: ends that meet one another, the two of a ring among them
    left: list[tuple[list[int], bool]]  #: three ends or more that stop, and whether rings do


def resolve(
    nodes: Sequence[Sequence[int]], partner: list[int], is_small: Callable[[int], bool]
) -> Resolved:
    """The joints of ends that meet in nodes; links are numbered as `chains` has them.

    `partner` is what each end meets so far, -1 for nothing; the joints are put into it.
    `is_small` says whether the chain from an end on is no larger than the tolerance: if it leads
    back, it is not a ring, and nothing.
    """
    work = _Work(nodes, partner, is_small)
    which: Iterable[int] = range(len(nodes))
    while which:
        which = work.close_rings(which) | work.prune(which)
    return Resolved(work.joins, [(node, work.is_ringed(node)) for node in work.left if node])


class _Work:
    def __init__(
        self, nodes: Sequence[Sequence[int]], partner: list[int], is_small: Callable[[int], bool]
    ) -> None:
        self._partner = partner
        self._is_small = is_small
        self._place = {end: n for n, node in enumerate(nodes) for end in node}
        self.left = [list(node) for node in nodes]
        self.joins: list[tuple[int, int]] = []
        self._far: dict[int, int] = {}  #: of an end that of the chain which begins with it
        for end in self._place:
            at = end ^ 1
            while partner[at] >= 0:
                at = partner[at] ^ 1
            self._far[end] = at

    def close_rings(self, which: Iterable[int]) -> set[int]:
        """Closes the chains that lead back to their place; the places that this changes."""
        changed: set[int] = set()
        for n in sorted(which):
            back = [e for e in self.left[n] if self._place.get(self._far[e]) == n]
            for end in back:
                if end < self._far[end] and not self._is_small(end):
                    self._join(end, self._far[end])
            if back:
                gone = set(back)
                changed |= self._keep(n, [e for e in self.left[n] if e not in gone])
        return changed

    def prune(self, which: Iterable[int]) -> set[int]:
        """Takes away branches; the places that this changes."""
        kept = {n: [e for e in self.left[n] if not self._is_dead(e)] for n in which}
        changed: set[int] = set()
        for n in sorted(kept):
            if 0 < len(kept[n]) < len(self.left[n]):
                changed |= self._keep(n, kept[n])
        return changed

    def is_ringed(self, node: Sequence[int]) -> bool:
        """Whether any of those that stop leads somewhere."""
        return not all(map(self._is_dead, node))

    def _is_dead(self, end: int) -> bool:
        return self._far[end] not in self._place

    def _keep(self, n: int, rest: list[int]) -> set[int]:
        """Leaves only some of the ends at a place; the places at the other ends of these."""
        kept = set(rest)
        for end in self.left[n]:
            if end not in kept:
                del self._place[end]
        self.left[n] = rest
        if len(rest) > 2:
            return set()
        self.left[n] = []
        fars = [self._far[end] for end in rest]
        for end in rest:
            del self._place[end]
        if len(rest) == 2:
            self._join(*rest)
            self._far[fars[0]], self._far[fars[1]] = fars[1], fars[0]
        return {self._place[far] for far in fars if far in self._place}

    def _join(self, a: int, b: int) -> None:
        self._partner[a], self._partner[b] = b, a
        self.joins.append((a, b))
