"""Name resolution: variables, constants, axes, blocks, and the library."""

from collections.abc import Collection, Iterable, Mapping, Sequence

from beamcam.controllers.simotion import axes, rules, syntax
from beamcam.controllers.simotion.parser import RESERVED
from beamcam.errors import Diagnostic, Rule, Source

UNKNOWN = "?"  #: the type of what has been complained about already


class Names:
    """The names that can be seen from where the checker stands, and what was said so far.

    `objects` are the project's own with their types: axes, path objects, inputs and outputs.
    """

    def __init__(self, units: Sequence[syntax.Unit], objects: Mapping[str, str], name: str) -> None:
        self.name = name
        self.diagnostics: list[Diagnostic] = []
        plain = any(unit.plain for unit in units)
        self.commands: Mapping[str, axes.Command] = {} if plain else axes.COMMANDS
        self.enumerators: Collection[str] = () if plain else axes.ENUMERATORS
        self.reserved = RESERVED if plain else axes.ENUMERATORS
        self.own_types = axes.PLAIN_TYPES if plain else axes.TYPES
        self.structures = {s.name.upper(): s for u in units for s in u.structures}
        self.needs_all = not plain  #: whether a call has to give all inputs of a block
        self.blocks = axes.BLOCKS | {b.name.upper(): b for u in units for b in u.blocks}
        self.objects = {name.upper(): type_ for name, type_ in objects.items()}
        self.globals: dict[str, syntax.Variable] = {}
        self.locals: dict[str, syntax.Variable] = {}

    def say(self, rule: Rule, line: int, **values: object) -> str:
        """Note what is wrong; the type of what cannot be known."""
        self.diagnostics.append(rule.at(Source(self.name, line), **values))
        return UNKNOWN

    def wrong_type(self, line: int, found: str, what: str, expected: str) -> str:
        """Note that something has another type than it should."""
        expected = axes.shown(expected)
        return self.say(rules.TYPE, line, found=axes.shown(found), what=what, expected=expected)

    def unknown(self, line: int, found: str, name: str, known: Collection[str]) -> str:
        """Note a name that is not among those that are known, with the nearest of them."""
        return self.say(rules.NAME, line, found=found, expected=near(name, known))

    def twice(self, name: str, line: int) -> None:
        """Note a name that stands for two things."""
        self.say(rules.DECLARED, line, found=name, how="twice", expected="it once")

    def variable(self, name: str) -> syntax.Variable | None:
        """The variable of a name, if there is one."""
        key = name.upper()
        return self.locals.get(key) or self.globals.get(key)

    def types(self) -> dict[str, str]:
        """The types that a variable may have, by their names in capitals."""
        own = (b.name for b in self.blocks.values() if b.kind == "FUNCTION_BLOCK")
        structures = (s.name for s in self.structures.values())
        return {t.upper(): t for t in (*self.own_types, *structures, *own)}

    def canonical(self, type_: str) -> str:
        """A type as the library writes it."""
        structures = (s.name for s in self.structures.values())
        return spelled(type_, (*self.own_types, *structures, *axes.BLOCKS)) or type_

    def components(self, type_: str) -> dict[str, str] | None:
        """The components of a type with their types; None if it has none."""
        if type_ in axes.COMPONENTS and self.commands:
            return axes.COMPONENTS[type_]
        if (structure := self.structures.get(type_.upper())) is not None:
            return {f.name: self.canonical(f.type) for f in structure.fields
                    if isinstance(f.type, str)}  # fmt: skip
        return self.of_block(type_, "output")

    def of_block(self, type_: str, *sections: syntax.Section) -> dict[str, str] | None:
        """The variables in some sections of a type's function block; None if it has none."""
        block = self.blocks.get(type_.upper())
        if block is None:
            return None
        return {
            v.name: self.canonical(v.type)
            for v in block.variables
            if v.section in sections and isinstance(v.type, str)
        }

    def of_value(self, value: syntax.Name) -> str:
        """The type of a name in an expression."""
        variable = self.variable(value.name)
        if variable is not None:
            if isinstance(variable.type, syntax.Array):
                array = f"the array {value.name}"
                return self.wrong_type(value.line, array, "a value", "one of its elements")
            return self.canonical(variable.type)
        key = value.name.upper()
        if key in self.objects:
            return self.objects[key]
        if key in self.enumerators:
            return f"enum:{key}"
        known = (
            *(v.name for v in self.locals.values()), *(v.name for v in self.globals.values()),
            *self.objects, *self.enumerators,
        )  # fmt: skip
        return self.unknown(value.line, value.name, value.name, known)


def spelled(word: str, known: Iterable[str]) -> str | None:
    """The known name that is `word` but for capitals."""
    return next((name for name in known if name.upper() == word.upper()), None)


def near(word: str, known: Collection[str]) -> str:
    """The nearest known name."""
    from difflib import get_close_matches

    names = {name.upper(): name for name in known}
    close = get_close_matches(word.upper(), list(names), 1, 0.6)
    return names[close[0]] if close else "a name that is"


def text_of(value: syntax.Expression) -> str:
    """What may be written to, as a message says it."""
    match value:
        case syntax.Name():
            return value.name
        case syntax.Member():
            return f"{text_of(value.base)}.{value.name}"
        case syntax.ArrayElement():
            return f"{text_of(value.base)}[...]"
    return "an expression"
