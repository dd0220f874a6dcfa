"""Values of many records of a class, by column.

    #7=IFCBOOLEANRESULT(.DIFFERENCE.,#3,#5);      ('DIFFERENCE', <#3>, <#5>)
    #9=IFCBOOLEANRESULT(.DIFFERENCE.,#7,#6);      ('DIFFERENCE', <#7>, <#6>)
    #8=IFCCOMPOSITECURVE((#1,#2,#3),.F.);         ((<#1>, <#2>, <#3>), False)

The records of a class are mostly written alike: the same commas and brackets in the same order, or
one list that is longer in some of them. Then arrays over the characters tell where each value
stands, and values are looked up a column at a time; where records are written in a few ways, each
of these is read by itself. What is written in another way is left to `Tokens.values`, which gives
the same record by record.
"""

from collections.abc import Callable
from itertools import islice, pairwise
from typing import Any

import numpy as np
from msgspec import Struct

from beamcam.readers.ifc.characters import Places, numbers_at, same_word
from beamcam.readers.ifc.step import Inners, Malformed, Typed, pieces
from beamcam.readers.ifc.values import Tokens, Values

_HASH, _OPENING, _CLOSING, _COMMA = b"#(),"

#: What invalid values end in, and references to points that do not exist.
NOT_READ = (ArithmeticError, LookupError, TypeError, ValueError)

Column = list[Any]

MOST_WAYS = 4  #: in which the records of a class are written, to be read together


class Alike(Struct, frozen=True):
    """Reads records that are written alike.

    `referred` gives what stands for the records of some numbers, or None if one is not there.
    """

    tokens: Tokens
    referred: Callable[[Places], Column | None]

    def values(self, inners: Inners) -> list[Values] | None:
        """The values by what is in the brackets of each record, as of `Tokens.values`.

        None if the records are written in more than a few ways or have no values, or if there are
        empty lists among these, or strings with commas, brackets or doubled quotes.
        """
        try:
            return list(zip(*self._columns(inners), strict=True))
        except NOT_READ:  # some of them may be well, which is seen one by one
            return self._by_size(inners)

    def _by_size(self, of: Inners) -> list[Values] | None:
        """The values of records that are written in few ways, each with so many commas."""
        sizes = of.closed - of.opened
        found: list[Values] = [()] * len(sizes)
        ways = set(sizes.tolist())
        if not 1 < len(ways) <= MOST_WAYS:
            return None
        for way in ways:
            which = np.flatnonzero(sizes == way)
            values = self.values(of.some(which))
            if values is None:
                return None
            for k, row in zip(which.tolist(), values, strict=True):
                found[k] = row
        return found

    def _columns(self, of: Inners) -> list[Column]:
        """The first values of all records, the second, and so on. Raises Malformed."""
        count = int(of.closed[0] - of.opened[0])
        if (of.closed - of.opened == count).all():
            edges = [of.marks[of.opened + place] for place in range(count + 1)]
            signs = [of.codes[at] for at in edges[1:-1]]
            if all((sign == sign[0]).all() for sign in signs):
                return self._nested(of, edges, [int(sign[0]) for sign in signs])
        return self._around_lists(of)

    def _nested(self, of: Inners, edges: list[Places], signs: list[int]) -> list[Column]:
        """The values between the edges, of which those inside a stretch are these signs."""
        stack: list[list[Column]] = [[]]
        kinds: list[list[str] | None] = []
        before = _COMMA
        for place, sign in enumerate([*signs, _COMMA]):
            start, end = edges[place] + 1, edges[place + 1]
            if sign == _OPENING:
                _refuse(before == _CLOSING)
                typed = bool((end > start).any())
                kinds.append(_types(of.text, start, end) if typed else None)
                stack.append([])
            elif before == _CLOSING:
                _refuse((end > start).any())
            else:
                stack[-1].append(self._column(of, start, end))
            if sign == _CLOSING:
                _refuse(len(stack) == 1)
                many: Column = list(zip(*stack.pop(), strict=True))
                types = kinds.pop()
                if types is not None:
                    many = [Typed(kind, v[0]) for kind, v in zip(types, many, strict=True)]
                stack[-1].append(many)
            before = sign
        _refuse(len(stack) > 1)
        return stack[0]

    def _around_lists(self, of: Inners) -> list[Column]:
        """The values of records with one list each, before which equally many values stand."""
        counts = of.closed - of.opened - 1
        ranks = np.repeat(of.opened + 1 + counts - np.cumsum(counts), counts)
        ranks += np.arange(len(ranks))
        signs = of.codes[of.marks[ranks]]
        opening, closing = ranks[signs == _OPENING], ranks[signs == _CLOSING]
        _refuse(not len(opening) == len(closing) == len(counts))
        _refuse(((opening <= of.opened) | (closing <= opening) | (closing >= of.closed)).any())
        before, behind = opening - of.opened, of.closed - closing
        _refuse((before != before[0]).any() or (behind != behind[0]).any())
        left = [of.marks[of.opened + place] for place in range(int(before[0]) + 1)]
        right = [of.marks[closing + place] for place in range(int(behind[0]) + 1)]
        for start, end in (left[-2:], right[:2]):  # the list is a value of its own
            _refuse((start + 1 != end).any())
        inside = (ranks >= np.repeat(opening, counts)) & (ranks < np.repeat(closing, counts))
        rest = iter(self._column(of, of.marks[ranks[inside]] + 1, of.marks[ranks[inside] + 1]))
        listed: Column = [tuple(islice(rest, count)) for count in (closing - opening).tolist()]
        return [*self._between(of, left[:-1]), listed, *self._between(of, right[1:])]

    def _between(self, of: Inners, edges: list[Places]) -> list[Column]:
        """The values between edges that are commas."""
        return [self._column(of, start + 1, end) for start, end in pairwise(edges)]

    def _column(self, of: Inners, start: Places, end: Places) -> Column:
        """The value of each of the stretches, of which none has a comma or bracket."""
        _refuse((start >= end).any())
        if (of.codes[start] == _HASH).all():
            numbers, behind = numbers_at(of.codes, start + 1)
            if (behind == end).all() and (behind > start + 1).all():
                found = self.referred(numbers)
                if found is not None:
                    return found
        if same_word(of.codes, start, end):  # half of all values, as `.AREA.` and `$`
            return [self.tokens[of.text[start[0] : end[0]]]] * len(start)
        return list(map(self.tokens.__getitem__, pieces(of.text, start, end)))


def _types(text: str, first: Places, last: Places) -> list[str]:
    """The types that are written before values, in capitals; Malformed for what is not a type."""
    found = pieces(text, first, last)
    _refuse(not all(kind.isalnum() and kind[0].isalpha() for kind in found))
    return [kind.upper() for kind in found]


def _refuse(odd: Any) -> None:
    """Raises Malformed if so."""
    if odd:
        raise Malformed("records that are not alike")
