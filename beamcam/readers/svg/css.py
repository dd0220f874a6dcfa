"""Style sheets as drawing programs write them, and the style of one element below another.

Selectors are element names, classes and ids, also joined (`rect.fil0`) and in lists; rules with
others (`g > path`, `:hover`) are named and left out.
"""

import re
from collections.abc import Iterable, Iterator, Mapping

from msgspec import Struct, field

from beamcam.readers.svg.tree import Element

#: Properties that this reader looks at and that an element passes on to its content.
INHERITED = (
    "stroke",
    "stroke-width",
    "stroke-opacity",
    "stroke-dasharray",
    "fill",
    "fill-opacity",
    "color",
    "visibility",
)
OWN = ("display", "clip-path", "mask")

#: Default values. Source: SVG 1.1, property index.
INITIAL: Mapping[str, str] = {
    "stroke": "none",
    "stroke-width": "1",
    "stroke-opacity": "1",
    "stroke-dasharray": "none",
    "fill": "black",
    "fill-opacity": "1",
    "color": "black",
    "visibility": "visible",
}

Style = Mapping[str, str]

# No pattern here looks ahead without end from more than one place: a sheet of many beginnings would
# take the square of its length.
_STATEMENT = re.compile(r"@(?:import|charset|namespace)")
_STATEMENT_END = re.compile(r"[;{]")
_BRACE = re.compile(r"([{}])")
_SELECTOR = re.compile(r"(\*|[A-Za-z][\w-]*)?((?:[.#][^\s.#:>+~\[\]*]+)*)\Z")


class CssRule(Struct, frozen=True):
    """One selector and what it sets."""

    tag: str  #: "" for any
    identity: str
    classes: frozenset[str]
    order: int
    style: tuple[tuple[str, str, bool], ...]  #: property, value, important

    @property
    def weight(self) -> tuple[bool, int, bool, int]:
        """Order of precedence: ids before classes before names, later ones before earlier."""
        return bool(self.identity), len(self.classes), bool(self.tag), self.order


class StyleSheet(Struct):
    """The rules of a file, found by the class, id or name that they ask for."""

    by_key: dict[str, list[CssRule]] = field(default_factory=dict)
    ignored: list[str] = field(default_factory=list)  #: selectors that are not understood
    _count: int = 0

    def add(self, text: str) -> None:
        """Take in the rules of one element `style`."""
        for head, body in _rules(_without_statements(_without_comments(text))):
            if "@" in head:  # @font-face: nothing that a shape could look like
                continue
            style = tuple(declarations(body))
            for selector in head.split(","):
                self._add_rule(selector.strip(), style)

    def _add_rule(self, selector: str, style: tuple[tuple[str, str, bool], ...]) -> None:
        found = _SELECTOR.match(selector)
        if not selector or found is None:
            if any(name in INHERITED or name in OWN for name, _, _ in style):
                self.ignored.append(selector)
            return
        tag = "" if found[1] in (None, "*") else found[1]
        parts = re.findall(r"([.#])([^.#]+)", found[2])
        classes = frozenset(name for mark, name in parts if mark == ".")
        identity = next((name for mark, name in parts if mark == "#"), "")
        self._count += 1
        rule = CssRule(tag, identity, classes, self._count, style)
        key = f"#{identity}" if identity else f".{min(classes)}" if classes else tag
        self.by_key.setdefault(key, []).append(rule)

    def rules_for(self, element: Element) -> list[CssRule]:
        """The rules that fit `element`, the weightiest last."""
        classes = (element.get("class") or "").split()
        keys = ["", element.tag, f"#{element.get('id')}", *(f".{name}" for name in classes)]
        found = [
            rule
            for key in dict.fromkeys(keys)
            for rule in self.by_key.get(key, ())
            if rule.tag in ("", element.tag)
            and rule.identity in ("", element.get("id"))
            and rule.classes.issubset(classes)
        ]
        return sorted(found, key=lambda rule: rule.weight)


def _without_comments(text: str) -> str:
    """A sheet with a blank for each comment; one that does not end stays."""
    kept: list[str] = []
    at = 0
    while (begin := text.find("/*", at)) >= 0 and (end := text.find("*/", begin + 2)) >= 0:
        kept.append(text[at:begin])
        at = end + 2
    kept.append(text[at:])
    return " ".join(kept).replace("<!--", " ").replace("-->", " ")


def _without_statements(text: str) -> str:
    """A sheet without `@import ...;` and the like."""
    kept: list[str] = []
    at = begin = 0
    while (found := _STATEMENT.search(text, begin)) and (
        end := _STATEMENT_END.search(text, found.end())
    ):
        begin = end.end()
        if end[0] == ";":
            kept.append(text[at : found.start()])
            at = begin
    kept.append(text[at:])
    return " ".join(kept)


def _rules(text: str) -> Iterator[tuple[str, str]]:
    """Head and body of each rule; of braces inside one another the innermost."""
    pieces = _BRACE.split(text)
    at = 0
    while at + 3 < len(pieces):
        if pieces[at + 1] == "{" and pieces[at + 3] == "}":
            yield pieces[at], pieces[at + 2]
            at += 2
        at += 2


def declarations(text: str) -> Iterable[tuple[str, str, bool]]:
    """Property, value and importance of "stroke:red; fill: none !important"."""
    for part in text.split(";"):
        name, colon, value = part.partition(":")
        if colon:
            plain = value.strip()
            marked = plain[-9:].lower() == "important" and plain[:-9].rstrip()[-1:] == "!"
            if marked:
                plain = plain[:-9].rstrip()[:-1].rstrip()
            yield name.strip().lower(), plain, marked


def style_of(element: Element, above: Style, sheet: StyleSheet) -> Style:
    """The style of `element` in an element of style `above`.

    Attributes weigh least, then the style sheet, then the attribute `style`; what is important
    weighs most. What is not said is inherited.
    """
    style = {name: above[name] for name in INHERITED}
    settings: list[tuple[str, str, bool]] = [
        (name, value, False) for name, value in element.attributes.items()
    ]
    for rule in sheet.rules_for(element):
        settings += rule.style
    if inline := element.get("style"):
        settings += declarations(inline)
    for important in (False, True):
        for name, value, marked in settings:
            if marked == important and (name in INHERITED or name in OWN):
                plain = value.strip()
                style[name] = above.get(name, "") if plain == "inherit" else plain
    return style
