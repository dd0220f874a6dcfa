"""How passages are written: their text with room for numbers, one pattern for all that are known.

    N6 M40 K2 L18                            N.. M40 K(..) L(..)
    N7 G00 X893.56 Y15 Z-5                   N.. G00 X(..) Y(..) Z(..)
    N8 G01 X893.56 Y15 Z107.408 F1.65        N.. G01 X same Y same Z(..) F(..)

X and the place across the bar have to be the same wherever they stand; all other numbers are words
of the passage, as they are written.
"""

import re
from collections.abc import Sequence

MOST_FORMS = 32  #: that one pattern has; a machine has some for each kind of tool
Words = tuple[str, ...]  #: X, place across (of a cut X again), and all others in their order

_NUMBER = "[-+.0-9]{1,15}+"  # all that may be one; a shorter text than the interpreter's limit
_BLOCK_NUMBER = re.compile(r"^N[0-9]+ ")


def body_of(line: str) -> str:
    """A line without its block number."""
    return _BLOCK_NUMBER.sub("", line)


class Forms:
    """The forms that are known; `pattern` matches a passage in any of them.

    A form is known by the last of its groups in `pattern`, and `groups` has those of its words.
    """

    def __init__(self) -> None:
        self.pattern = re.compile(r"(?!)")  # matches nothing
        self.groups: dict[int, tuple[int, ...]] = {}
        self._across: dict[int, str] = {}
        self._patterns: list[str] = []

    def said(self, text: str) -> tuple[int, Words] | None:
        """Form and words of a text that is one passage of a form that is known."""
        match = self.pattern.fullmatch(text)
        if match is None or match.lastindex is None:
            return None
        return match.lastindex, match.group(*self.groups[match.lastindex])

    def learn(self, lines: Sequence[str], across: str) -> tuple[int, Words] | None:
        """Form and words of a passage, from now on a known one; None if it names two places.

        None also where there is no room for another form.
        `across` is the letter of the place across the bar, "" of a cut. Each line is a block as
        `blocks.USUAL` has it, with its number or without.
        """
        text = "".join(f"{line}\n" for line in lines)
        said = self.said(text)
        if said is not None and self._across[said[0]] == across:
            return said
        if self.is_full or not self._add(lines, across):
            return None
        return self.said(text)

    @property
    def is_full(self) -> bool:
        return len(self.groups) >= MOST_FORMS

    def _add(self, lines: Sequence[str], across: str) -> bool:
        """Add the form that the lines have, if X and `across` are the same in all of them."""
        last = self.pattern.groups
        places: dict[str, tuple[str, int]] = {}  #: X and the place across, and their groups
        others: list[int] = []
        pattern = ""
        for line in lines:
            for word in line.split(" "):
                letter = word[0]
                if letter == "N":
                    pattern += "N[0-9]++ "
                elif letter in "GM":
                    pattern += word
                elif letter not in places:
                    last += 1
                    pattern += f" {letter}(?P<_{last}>{_NUMBER})"
                    if letter in ("X", across):
                        places[letter] = word, last
                    else:
                        others.append(last)
                elif word == places[letter][0]:
                    pattern += f" {letter}(?P=_{places[letter][1]})"
                else:
                    return False
            pattern += "\n"
        x = places["X"][1]
        self.groups[last] = (x, places[across][1] if across else x, *others)
        self._across[last] = across
        self._patterns.append(pattern)
        self.pattern = re.compile("^(?:" + "|".join(self._patterns) + ")", re.MULTILINE)
        return True
