"""The values of many records of a class, all at once.

    #7=IFCBOOLEANRESULT(.DIFFERENCE.,#3,#5);      ('DIFFERENCE', <#3>, <#5>)
    #9=IFCBOOLEANRESULT(.DIFFERENCE.,#7,#6);      ('DIFFERENCE', <#7>, <#6>)
    #8=IFCCOMPOSITECURVE((#1,#2,#3),.F.);         ((<#1>, <#2>, <#3>), False)

The records of a class are mostly written alike: so many values, one of them a list or none. Then
their texts are cut at the commas together, and references are looked up a column at a time. What
is written in another way is left to `Tokens.values`, which gives the same record by record.
"""

from collections.abc import Callable, Sequence
from itertools import islice
from typing import Any

from msgspec import Struct

from beamcam.readers.ifc.step import Malformed
from beamcam.readers.ifc.values import Tokens, Values

_BETWEEN = ";"  #: as a value of its own between two records

#: What values that are none end in, and references to points that are none.
NOT_READ = (ArithmeticError, LookupError, TypeError, ValueError)

Column = list[Any]


class Alike(Struct, frozen=True):
    """Reads records that are written alike.

    `referred` gives what stands for the records of some numbers, or None if one is not there.
    """

    tokens: Tokens
    referred: Callable[[list[int]], Column | None]

    def values(self, inners: Sequence[str]) -> list[Values] | None:
        """The values by the texts in the brackets of each record, as of `Tokens.values`.

        None if the records are not alike or have no values, or if there are lists in lists among
        these, types, or strings with commas, brackets or doubled quotes.
        """
        try:
            if "(" not in "".join(inners):
                columns = self._columns(inners)
            else:
                before, listed, behind = zip(*map(_around_list, inners), strict=True)
                columns = [*self._columns(before), self._lists(listed), *self._columns(behind)]
        except NOT_READ:  # some of them may be well; which, is seen one by one
            return None
        return list(zip(*columns, strict=True)) if columns else None

    def _columns(self, texts: Sequence[str]) -> list[Column]:
        """The first values of all texts, the second, and so on; Malformed if not equally many."""
        if not any(texts):
            return []
        tokens = f",{_BETWEEN},".join(texts).split(",")
        width = texts[0].count(",") + 2  # with what stands between
        between = tokens[width - 1 :: width]
        if len(tokens) != len(texts) * width - 1 or between != [_BETWEEN] * (len(texts) - 1):
            raise Malformed("records that are not alike")
        return [self._column(tokens[place::width]) for place in range(width - 1)]

    def _lists(self, texts: Sequence[str]) -> list[Values]:
        """The values of each text."""
        values = iter(self._column(",".join(texts).split(",")))
        return [tuple(islice(values, text.count(",") + 1)) for text in texts]

    def _column(self, tokens: list[str]) -> Column:
        """The value of each token, of which none has a comma."""
        if tokens[0][:1] == "#":
            digits = ",".join(tokens)[1:].split(",#")
            if len(digits) == len(tokens) and all(map(str.isdecimal, digits)):
                found = self.referred(list(map(int, digits)))
                if found is not None:
                    return found
        return list(map(self.tokens.__getitem__, tokens))


def _around_list(inner: str) -> tuple[str, str, str]:
    """What stands before the one list of a record, in it and behind it, without the commas between.

    Raises Malformed where there is none, a type before it, or a bracket more.
    """
    before, opening, rest = inner.partition("(")
    listed, closing, behind = rest.partition(")")
    apart = before[-1:] in ("", ",") and behind[:1] in ("", ",") and before != "," != behind
    if not (opening and closing and apart) or "(" in listed or "(" in behind or ")" in behind:
        raise Malformed("no list, or more than one")
    return before[:-1], listed, behind[1:]
