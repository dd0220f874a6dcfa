"""Expressions of Structured Text: operators by their levels, literals, names and calls."""

import re
from collections.abc import Callable
from typing import TypeVar

from beamcam.controllers.simotion import axes, syntax
from beamcam.controllers.simotion.syntax import Expression, Token

_WORDS = """
    ACTION AND ARRAY AT BEGIN BY CASE CONFIGURATION CONSTANT DATE DO DT ELSE ELSIF END_ACTION
    END_CASE END_FOR END_FUNCTION END_FUNCTION_BLOCK END_IF END_IMPLEMENTATION END_INTERFACE
    END_PROGRAM END_REPEAT END_STRUCT END_TYPE END_VAR END_WHILE EXIT FALSE FOR FROM FUNCTION
    FUNCTION_BLOCK IF IMPLEMENTATION INTERFACE MOD NOT OF ON OR PROGRAM READ_ONLY REPEAT RETAIN
    RETURN STEP STRUCT TASK THEN TIME TO TOD TRANSITION TRUE TYPE UNTIL USELIB USEPACKAGE USES VAR
    VAR_GLOBAL VAR_INPUT VAR_IN_OUT VAR_OUTPUT VAR_TEMP WAITFORCONDITION WHILE WITH XOR
    R S LD ST N LDN STN JMP CAL RET ADD SUB MUL DIV GT GE EQ NE LE LT"""
KEYWORDS = frozenset(_WORDS.split())
_PLAIN_WORDS = """
    CONFIGURATION END_CONFIGURATION END_RESOURCE EN ENO F_EDGE INITIAL_STEP NON_RETAIN RESOURCE
    R_EDGE READ_WRITE TASK VAR_ACCESS VAR_CONFIG VAR_EXTERNAL CONCAT DELETE EXPT FIND INSERT LEFT
    LEN LIMIT LN LOG MAX MID MIN MOVE MUX REPLACE RIGHT ROL ROR SEL SHL SHR SIN COS TAN ASIN ACOS
    ATAN EXP TRUNC ABS SQRT BOOL BYTE WORD DWORD LWORD SINT INT DINT LINT USINT UINT UDINT ULINT
    REAL LREAL STRING WSTRING TON TOF TP CTU CTD CTUD SR RS R_TRIG F_TRIG SEMA RTC ANY"""
#: Words that are no names in plain IEC 61131-3 either: of configurations, types and functions.
RESERVED = frozenset(_PLAIN_WORDS.split())

_TIME = re.compile(r"(?<![\d.])(\d++(?:\.\d++)?)(ms|s|m|h|d)", re.IGNORECASE)
_TIME_S = {"ms": 0.001, "s": 1.0, "m": 60.0, "h": 3600.0, "d": 86400.0}
#: How tightly each operator between two values binds.
_LEVELS = {
    "OR": 0, "XOR": 1, "AND": 2, "&": 2, "=": 3, "<>": 3, "<": 4, ">": 4, "<=": 4, ">=": 4,
    "+": 5, "-": 5, "*": 6, "/": 6, "MOD": 6,
}  # fmt: skip
Item = TypeVar("Item")


class Stop(Exception):
    """A parse error."""

    def __init__(self, token: Token, expected: str) -> None:
        self.token, self.expected = token, expected


class TokenStream:
    """Tokens that are taken one by one."""

    def __init__(self, tokens: list[Token]) -> None:
        self.tokens, self.at = tokens, 0

    # -- words ------------------------------------------------------------------------------

    @property
    def here(self) -> Token:
        return self.tokens[self.at]

    def is_word(self, *words: str) -> bool:
        return self.here.kind in ("name", "sign") and self.here.text.upper() in words

    def take(self, *words: str) -> Token:
        if not self.is_word(*words):
            raise Stop(self.here, " or ".join(words))
        self.at += 1
        return self.tokens[self.at - 1]

    def accept(self, *words: str) -> bool:
        if self.is_word(*words):
            self.at += 1
            return True
        return False

    def of_kind(self, kind: str, expected: str) -> Token:
        token = self.here
        if token.kind != kind:
            raise Stop(token, expected)
        self.at += 1
        return token

    def identifier(self, what: str) -> Token:
        if self.here.text.upper() in KEYWORDS:
            raise Stop(self.here, what)
        return self.of_kind("name", what)

    def separated(self, item: Callable[[], Item]) -> list[Item]:
        """Items with commas between them, one or more."""
        items = [item()]
        while self.accept(","):
            items.append(item())
        return items


class Expressions(TokenStream):
    """Takes expressions, one function a construct."""

    def expression(self, level: int = 0) -> Expression:
        """Values with operators of a level or tighter ones between them."""
        left = self.unary()
        while (own := _LEVELS.get(self.here.text.upper(), -1)) >= level:
            token = self.take(*_LEVELS)
            operator = "AND" if token.text == "&" else token.text.upper()
            left = syntax.Binary(token.line, operator, left, self.expression(own + 1))
        return left

    def unary(self) -> Expression:
        token = self.here
        if self.accept("NOT", "-"):
            return syntax.Unary(token.line, token.text.upper(), self.unary())
        if self.accept("("):
            inner = self.expression()
            self.take(")")
            return inner
        if token.kind in ("number", "typed") or self.is_word("TRUE", "FALSE"):
            self.at += 1
            return _literal(token)
        return self.postfix()

    def postfix(self) -> Expression:
        token = self.identifier("a name or a value")
        expression: Expression = syntax.Name(token.line, token.text)
        if self.is_word("("):
            return self.call(token)
        while True:
            if self.accept("["):
                index = self.expression()
                self.take("]")
                expression = syntax.ArrayElement(token.line, expression, index)
            elif self.accept("."):
                member = self.of_kind("name", "a component")
                expression = syntax.Member(member.line, expression, member.text)
            else:
                return expression

    def call(self, callee: Token) -> Expression:
        # name(a := 1, b := 2) or name(1, 2)
        self.take("(")
        named, placed = [], []
        while not self.is_word(")"):
            token, after = self.here, self.tokens[self.at + 1]
            if token.kind == "name" and after.text == ":=":
                self.at += 2
                named.append((token.text, self.expression(), token.line))
            else:
                placed.append(self.expression())
            if not self.accept(","):
                break
        self.take(")")
        return syntax.Call(callee.line, callee.text, tuple(named), tuple(placed))


def _literal(token: Token) -> syntax.Constant:
    word, _, text = token.text.upper().partition("#")
    if word in ("TRUE", "FALSE"):
        return syntax.Constant(token.line, "BOOL", word == "TRUE")
    if token.kind == "number":
        plain = float(word) if "." in word else int(word)
        return syntax.Constant(token.line, "real" if "." in word else "integer", plain)
    if word in ("T", "TIME"):
        pieces = _TIME.findall(text)
        if "".join(a + b for a, b in pieces) != text or not pieces:
            raise Stop(token, "a time such as T#300ms")
        value = sum(float(a) * _TIME_S[b.lower()] for a, b in pieces)
        return syntax.Constant(token.line, "TIME", value)
    try:
        if word in ("LREAL", "REAL"):
            if "." not in text:
                raise ValueError(text)
            return syntax.Constant(token.line, word, float(text))
        if word == "BOOL":
            return syntax.Constant(token.line, word, bool(int(text)))
        low, high = axes.INTEGERS[word]
        if not low <= int(text) <= high:
            raise ValueError(text)
        return syntax.Constant(token.line, word, int(text))
    except ValueError:
        raise Stop(token, f"a value of {word}") from None
