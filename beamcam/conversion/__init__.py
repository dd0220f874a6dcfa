"""Values as they stand in a file: a record's, checked by msgspec against its own types, and
arithmetic written as text.

msgspec stops at the first fault and says what it expected. `Fault` adds what it leaves out: the key
of a table's row, the value that was found, the words that may stand there, the nearest known key.
"""

import ast
import math
import operator
import re
from collections.abc import Callable, Collection, Iterable, Mapping
from math import isfinite
from reprlib import Repr
from threading import Lock
from types import UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin

from msgspec import Meta, Struct, UnsetType, ValidationError, convert
from msgspec.structs import fields

# --- fault ----------------------------------------------------------------------------------------

Path = tuple[str | int, ...]
Hook = Callable[[Any, Any], Any]  #: type and value: the value as that type, or ValueError


class Fault(ValueError):
    """A value that a record does not take."""

    def __init__(
        self, kind: Literal["unknown", "missing", "type", "value"], path: Path, found: object,
        expected: str, known: tuple[str, ...] = (),
    ) -> None:  # fmt: skip
        super().__init__(kind, path, found, expected)
        self.kind = kind
        self.path = path  #: keys and indices from the top; of a missing key its own
        self.found = found
        self.expected = expected
        self.known = known  #: of an unknown key, those that there are


def nearest(word: str, known: Iterable[str]) -> str:
    """The known word most like `word`, as a suggestion; all of them where none is like it."""
    from difflib import get_close_matches

    names = sorted(known)
    close = get_close_matches(word, names, 1, 0.6)
    return repr(close[0]) if close else "one of " + ", ".join(names)


_SAID = re.compile(r"(.*?)(?: - at (`key` in )?`\$([^`]*)`)?", re.DOTALL)
_STEP = re.compile(r"([^.\[\]]+)|\[([^\]]+)\]")
_KEY = re.compile(r"(Object contains unknown|Object missing required) field `(.*)`", re.DOTALL)
_BOUND = re.compile(r"Expected `(?:float|int)[^`]*` (>=|>|<=|<) (\S+)")
_TEXT = re.compile(r"Expected `str[^`]*` of length")
_LENGTH = re.compile(r"Expected `array` of length (>= )?(\d+)")
_KIND = re.compile(r"Expected `([^`]+)`")

_BOUNDS = {">": "more than {}", ">=": "{} or more", "<": "less than {}", "<=": "at most {}"}
_KINDS = {
    "float": "a number", "int": "a whole number", "str": "a text", "bool": "true or false",
    "object": "a table",
}  # fmt: skip
_MANY = {float: " of numbers", str: " of texts"}


def fault_of(message: str, value: Any, hint: Any, hook: Hook | None, above: Path = ()) -> Fault:
    """The fault behind a message of msgspec about `value`, which should have been a `hint`."""
    match = _SAID.fullmatch(message)
    assert match is not None  # as it matches any text
    what, is_key, steps = match[1], match[2], _STEP.findall(match[3] or "")
    path = above
    for name, index in steps:
        inner = inner_hint(hint, name)
        if index == "...":
            return _fault_of_row(value, inner, hook, path) or Fault("type", path, value, what)
        key = int(index) if index else name
        hint, value, path = inner, value[key], (*path, key)
    if is_key:
        names = plain(get_args(plain(hint))[0])
        if get_origin(names) is Literal:
            key = next(key for key in value if key not in get_args(names))
            return Fault("unknown", (*path, key), key, nearest(key, get_args(names)))
        fault = _fault_of_row({key: key for key in value}, names, hook, path)
        return fault or Fault("type", path, value, what)
    field = _KEY.fullmatch(what)
    if field is None:
        kind: Literal["type", "value"] = "type" if ", got " in what else "value"
        return Fault(kind, path, value, _expected(what, hint, value))
    if field[1].endswith("required"):
        return Fault("missing", (*path, field[2]), None, field[2])
    known = tuple(f.encode_name for f in fields(plain(hint, dict)))
    return Fault("unknown", (*path, field[2]), field[2], nearest(field[2], known), known)


def _fault_of_row(rows: Any, hint: Any, hook: Hook | None, path: Path) -> Fault | None:
    """The fault of the first row of a table that is no `hint`; msgspec does not name its key."""
    for key, item in rows.items():
        try:
            convert(item, hint, dec_hook=hook)
        except ValidationError as error:
            return fault_of(str(error), item, hint, hook, (*path, key))
    return None


def plain(hint: Any, holder: type = object) -> Any:
    """A type without None beside it and without limits.

    Of several types it is the first one, or the one that a dict or a list becomes: the `holder`.
    """
    origin = get_origin(hint)
    if origin is Annotated:
        return plain(get_args(hint)[0], holder)
    if origin in (Union, UnionType):
        kinds = [plain(a) for a in _alternatives(hint)]
        return next((kind for kind in kinds if _holds(kind) is holder), kinds[0])
    return hint


def _holds(kind: Any) -> type | None:
    """Whether a type is read from a dict or a list; None for a single value."""
    origin = get_origin(kind)
    if origin is tuple:
        return list
    is_record = isinstance(kind, type) and issubclass(kind, Struct)
    return dict if is_record or (isinstance(origin, type) and issubclass(origin, Mapping)) else None


def inner_hint(hint: Any, name: str) -> Any:
    """The type of a record's field; without a name, that of a list's or table's values."""
    if name:
        return next(f.type for f in fields(plain(hint, dict)) if f.encode_name == name)
    hint = plain(hint, list)
    return get_args(hint)[1 if issubclass(get_origin(hint), Mapping) else 0]


def _expected(what: str, hint: Any, found: object) -> str:
    """Values allowed in place of `found`, in words."""
    if what == "Number out of range" or (isinstance(found, float) and not isfinite(found)):
        return "a finite number"
    choices = plain(hint)
    if get_origin(choices) is Literal:
        words = ["one of " + ", ".join(map(repr, get_args(choices)))]
        for kind in _alternatives(hint)[1:]:  # with its least value, if it has one
            least = getattr(next(iter(getattr(kind, "__metadata__", ())), None), "ge", None)
            least = "" if least is None else f", {_BOUNDS['>='].format(least)}"
            words.append(_KINDS.get(getattr(plain(kind), "__name__", ""), "a table") + least)
        return ", or ".join(words)
    if bound := _BOUND.match(what):
        limits = [m for k in _alternatives(hint) for m in getattr(k, "__metadata__", ())]
        units = [limit.extra["unit"] for limit in limits if limit.extra]
        return _BOUNDS[bound[1]].format(" ".join([f"{float(bound[2]):g}", *units]))
    if _TEXT.match(what):
        return "a text"
    if length := _LENGTH.match(what):
        return f"a list of {length[2]}{' or more' if length[1] else ''}"
    kind = _KIND.match(what)
    if kind and kind[1].startswith("array"):
        return "a list" + _MANY.get(plain(inner_hint(hint, "")), "")
    if kind:
        return " or ".join(_KINDS[k] for k in kind[1].split(" | ") if k in _KINDS)
    return what  # a hook's own words, in its own words


def _alternatives(hint: Any) -> list[Any]:
    """The types that a value may have, without None."""
    if get_origin(hint) not in (Union, UnionType):
        return [hint]
    return [kind for kind in get_args(hint) if kind not in (type(None), UnsetType)]


_REPR = Repr()
_REPR.maxlevel, _REPR.maxlist, _REPR.maxdict = 4, 12, 12
_REPR.maxstring = _REPR.maxother = 80


def shown(value: object) -> str:
    """A value for a message, however long or deep it is."""
    try:
        return _REPR.repr(value)
    except ValueError:  # more digits than Python prints
        return "a number of thousands of digits"


__all__ = [
    "MAX_NUMBER", "Count", "Fault", "Keys", "NotNegative", "Positive", "PositiveCount", "Text",
    "converted", "nearest",
]  # fmt: skip

Record = TypeVar("Record")

Text = Annotated[str, Meta(min_length=1)]
Positive = Annotated[float, Meta(gt=0)]
NotNegative = Annotated[float, Meta(ge=0)]
Count = Annotated[int, Meta(ge=0)]
PositiveCount = Annotated[int, Meta(ge=1)]


class Keys(Struct, frozen=True, forbid_unknown_fields=True):
    """A record whose fields are the keys of a table, and all that it may have."""


#: msgspec works out what it knows of a type at its first use, and lets another thread take the half
#: of it: the process ends with a segmentation fault.
_ONE_AT_A_TIME = Lock()
#: No length in mm is greater, 10,000 km; squares and sums of such stay numbers.
MAX_NUMBER = 1e10
MOST_BITS = 63  #: of a whole number; no machine counts further


def converted(value: object, record: type[Record], hook: Hook | None = None) -> Record:
    """`value`, as a parser of TOML or JSON gives it, as a record. Raises Fault."""
    with _ONE_AT_A_TIME:
        try:
            result = convert(value, record, dec_hook=hook)
        except ValidationError as error:
            raise fault_of(str(error), value, record, hook) from None
    odd = _odd_number(value)
    if odd is not None:
        raise odd
    return result


def _odd_number(value: object) -> Fault | None:
    """The first number that is not finite, or too large to reckon with."""
    waiting: list[tuple[Path, Any]] = [((), value)]
    while waiting:
        path, holder = waiting.pop()
        for key, item in holder.items() if isinstance(holder, dict) else enumerate(holder):
            expected = ""
            if isinstance(item, dict | list):
                waiting.append(((*path, key), item))
            elif isinstance(item, float) and not isfinite(item):
                expected = "a finite number"
            elif isinstance(item, int) and item.bit_length() > MOST_BITS:
                expected = "a number of at most 18 digits"
            elif isinstance(item, int | float) and abs(item) > MAX_NUMBER:
                expected = f"a number between -{MAX_NUMBER:g} and {MAX_NUMBER:g}"
            if expected:
                return Fault("value", (*path, key), item, expected)
    return None


# --- arithmetic -----------------------------------------------------------------------------------

# Arithmetic written as text: `"height / 2 - y"`, `"25 * sin(x)"`.
#
# Python's own grammar parses the text; only the node types below are evaluated, by closures of
# this module. Nothing is ever handed to `eval`, so an expression in a file can compute a number
# and do nothing else.


#: Operations inside each other; no drawing needs more, and Python's own stack ends somewhere.
MOST_NESTED = 100
MANY = 100
#: A formula is worked out thousands of times for a curve; no drawing's has a tenth of that.
MOST_CHARACTERS = 1000
Expression = Callable[[Mapping[str, float]], float]
_OPERATORS: dict[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul,
    ast.Div: operator.truediv, ast.Pow: math.pow,
}  # fmt: skip
FUNCTIONS: dict[str, Callable[..., float]] = {
    "abs": abs, "min": min, "max": max, "sqrt": math.sqrt, "exp": math.exp, "log": math.log,
    "sin": math.sin, "cos": math.cos, "tan": math.tan, "asin": math.asin, "acos": math.acos,
    "atan": math.atan, "atan2": math.atan2, "hypot": math.hypot, "radians": math.radians,
    "degrees": math.degrees, "floor": math.floor, "ceil": math.ceil,
}  # fmt: skip
#: Minimum and maximum number of arguments of the functions that do not take one.
_COUNTS: dict[str, tuple[int, int]] = {
    "min": (2, MANY), "max": (2, MANY), "hypot": (1, MANY), "atan2": (2, 2), "log": (1, 2),
}  # fmt: skip
CONSTANTS = {"pi": math.pi, "e": math.e}


def compile_expression(text: str, names: Collection[str]) -> Expression:
    """A function from the values of `names` to the value of `text`; angles are radians.

    `^` is read as a power, as in most drawings programs. Raises ValueError, with the part that
    is not understood, for anything but numbers, `names`, + - * / ^, parentheses and `FUNCTIONS`.
    The function that comes back raises ArithmeticError or ValueError where the expression has
    no value (division by zero, root of a negative number).
    """
    if len(text) > MOST_CHARACTERS:
        raise ValueError(
            f"{text[:40]!r}... has {len(text)} characters, expected at most {MOST_CHARACTERS}"
        )
    try:
        tree = ast.parse(text.strip().replace("^", "**"), mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise ValueError(f"{text!r} is no arithmetic expression") from error
    level: list[ast.AST] = [tree.body]
    for _ in range(MOST_NESTED):  # without recursion
        children = (child for node in level for child in ast.iter_child_nodes(node))
        level = [child for child in children if isinstance(child, ast.expr)]
    if level:
        raise ValueError(f"{text[:40]!r}... is nested more than {MOST_NESTED} deep")
    return _compile(tree.body, frozenset(names))


def _compile(node: ast.expr, names: frozenset[str]) -> Expression:
    match node:
        case ast.Constant(value=int() | float() as value) if (  # True and False are no numbers
            isinstance(value, float) or (type(value) is int and value.bit_length() <= 1023)
        ):
            number = float(value)
            return lambda _: number
        case ast.Name(id=name) if name in names:
            return operator.itemgetter(name)
        case ast.Name(id=name) if name in CONSTANTS:
            constant = CONSTANTS[name]
            return lambda _: constant
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            inner = _compile(operand, names)
            return lambda values: -inner(values)
        case ast.UnaryOp(op=ast.UAdd(), operand=operand):
            return _compile(operand, names)
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _OPERATORS:
            first, second = _compile(left, names), _compile(right, names)
            apply = _OPERATORS[type(op)]
            return lambda values: apply(first(values), second(values))
        case ast.Call(func=ast.Name(id=name), args=args, keywords=[]) if name in FUNCTIONS:
            least, most = _COUNTS.get(name, (1, 1))
            if not least <= len(args) <= most:
                some = f"{least}" if least == most else f"{least} or more"
                raise ValueError(f"{name!r} takes {some}, found {len(args)} values")
            function, arguments = FUNCTIONS[name], [_compile(a, names) for a in args]
            return lambda values: float(function(*[a(values) for a in arguments]))
    known = ", ".join(sorted(names))
    text = ast.unparse(node)
    raise ValueError(f"{text!r} is not understood; names known here: {known or 'none'}")
