"""Arithmetic written as text: `"height / 2 - y"`, `"25 * sin(x)"`.

Python's own grammar parses the text; only the node types below are evaluated, by closures of
this module. Nothing is ever handed to `eval`, so an expression in a file can compute a number
and do nothing else.
"""

import ast
import math
import operator
from collections.abc import Callable, Collection, Mapping

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
    if _depth(tree.body) > MOST_NESTED:
        raise ValueError(f"{text[:40]!r}... is nested more than {MOST_NESTED} deep")
    return _compile(tree.body, frozenset(names))


def _depth(tree: ast.expr) -> int:
    """Nesting depth of the nodes, found without recursion."""
    deepest, waiting = 0, [(tree, 1)]
    while waiting:
        node, depth = waiting.pop()
        deepest = max(deepest, depth)
        waiting += ((child, depth + 1) for child in ast.iter_child_nodes(node)
                    if isinstance(child, ast.expr))  # fmt: skip
    return deepest


def _compile(node: ast.expr, names: frozenset[str]) -> Expression:
    match node:
        case ast.Constant(value=int() | float() as value) if _is_number(value):
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
            first, second, apply = (
                _compile(left, names),
                _compile(right, names),
                _OPERATORS[type(op)],
            )
            return lambda values: apply(first(values), second(values))
        case ast.Call(func=ast.Name(id=name), args=args, keywords=[]) if name in FUNCTIONS:
            least, most = _COUNTS.get(name, (1, 1))
            if not least <= len(args) <= most:
                some = f"{least}" if least == most else f"{least} or more"
                raise ValueError(f"{name!r} takes {some}, found {len(args)} values")
            function, arguments = FUNCTIONS[name], [_compile(a, names) for a in args]
            return lambda values: float(function(*[a(values) for a in arguments]))
    known = ", ".join(sorted(names))
    raise ValueError(
        f"{ast.unparse(node)!r} is not understood; names known here: {known or 'none'}"
    )


def _is_number(value: object) -> bool:
    """Whether a constant is a number that a float can hold; True and False are not numbers."""
    return isinstance(value, float) or (type(value) is int and value.bit_length() <= 1023)
