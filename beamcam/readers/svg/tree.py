"""XML to elements that know their line; names of SVG without prefix, others left out."""

import re
from collections.abc import Iterable, Iterator, Mapping
from itertools import pairwise
from xml.parsers import expat

from msgspec import Struct, field

from beamcam.errors import ReadError, Source
from beamcam.model.colour import is_transparent
from beamcam.readers.svg import rules

SVG = "http://www.w3.org/2000/svg"

#: Deeper than this nothing is nested but by mistake.
MOST_DEEP = 200


class Element(Struct):
    """One element of the SVG namespace, or of none."""

    tag: str
    attributes: dict[str, str]
    line: int
    children: "list[Element]" = field(default_factory=list)
    parent: "Element | None" = None  #: where it stands in the file

    def get(self, name: str) -> str | None:
        return self.attributes.get(name)


class Document(Struct):
    """The tree of a file and what it says about the program that wrote it."""

    root: Element
    comments: list[str]
    foreign: set[str]  #: names of elements and attributes of other namespaces
    ids: dict[str, Element]
    styles: list[str]  #: the texts of the elements `style`


def looks_like(data: bytes) -> bool:
    """Whether the bytes are XML with an element svg near the beginning, in UTF-8 or UTF-16."""
    head = data[:65536]
    if head[:2] in (b"\xff\xfe", b"\xfe\xff"):
        head = head.decode("utf-16", "replace").encode()
    head = head.removeprefix(b"\xef\xbb\xbf").lstrip()
    return head.startswith(b"<") and re.search(rb"<(?:\w+:)?svg[\s>]", head) is not None


def parse(data: bytes, name: str) -> Document:
    """The elements of an SVG file. Raises ReadError for what is neither XML nor SVG."""
    builder = _Builder(name)
    # A byte order mark tells the encoding better than a declaration that was copied along.
    encoding = "utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else None
    parser = expat.ParserCreate(encoding)
    parser.buffer_text = True
    parser.StartElementHandler = builder.start
    parser.EndElementHandler = builder.end
    parser.CharacterDataHandler = builder.characters
    parser.CommentHandler = builder.comments.append
    builder.parser = parser
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        found = expat.ErrorString(error.code)
        raise ReadError(rules.XML.at(Source(name, error.lineno), found=found)) from error
    except (LookupError, ValueError) as error:  # an encoding that Python does not know
        raise ReadError(rules.XML.at(Source(name, 1), found=str(error))) from error
    root = builder.root
    if root is None or root.tag != "svg":
        raise ReadError(rules.NOT_SVG.at(Source(name, 1), found=builder.first))
    return Document(root, builder.comments, builder.foreign, builder.ids, builder.styles)


class _Builder:
    """Callbacks of the XML parser."""

    def __init__(self, name: str) -> None:
        self.name = name
        self.root: Element | None = None
        self.first = ""
        self.comments: list[str] = []
        self.foreign: set[str] = set()
        self.ids: dict[str, Element] = {}
        self.styles: list[str] = []
        self.open: list[Element] = []
        self.skipping = 0  #: depth inside an element of another namespace
        self.prefixes = {""}  #: those that stand for SVG
        self.parser: expat.XMLParserType

    def start(self, name: str, attributes: dict[str, str]) -> None:
        self.first = self.first or name
        for key, value in attributes.items():
            if value == SVG and key.startswith("xmlns:"):
                self.prefixes.add(key[6:])
            elif ":" in key:
                self.foreign.add(f"{key}={value}")
        prefix, _, tag = name.rpartition(":")
        elsewhere = attributes.get("xmlns", SVG) not in (SVG, "") and prefix == ""
        if self.skipping or prefix not in self.prefixes or elsewhere:
            self.skipping += 1
            self.foreign.add(name)
            return
        element = Element(tag, attributes, self.parser.CurrentLineNumber)
        if self.open:
            self.open[-1].children.append(element)
            element.parent = self.open[-1]
        elif self.root is None:
            self.root = element
        if len(self.open) >= MOST_DEEP:
            raise ReadError(rules.DEPTH.at(Source(self.name, element.line), expected=MOST_DEEP))
        self.open.append(element)
        if tag == "style":
            self.styles.append("")
        if "id" in attributes:
            self.ids.setdefault(attributes["id"], element)

    def end(self, name: str) -> None:
        if self.skipping:
            self.skipping -= 1
        else:
            self.open.pop()

    def characters(self, text: str) -> None:
        if self.open and not self.skipping and self.open[-1].tag == "style":
            self.styles[-1] += text


# --- css ------------------------------------------------------------------------------------------

# Style sheets as drawing programs write them, and the style of one element below another.
#
# Selectors are element names, classes and ids, also joined (`rect.fil0`), in lists, and below
# others (`g path`, `g > path`). What holds under a pointer alone (`:hover`) is named and left out;
# any other rule (`path[id]`, `:not(.cut)`) too, unless it could hide a contour: then the file is
# refused.


#: Properties that this reader looks at and that an element passes on to its content.
INHERITED = (
    "stroke", "stroke-width", "stroke-opacity", "stroke-dasharray", "fill", "fill-opacity",
    "color", "visibility",
)  # fmt: skip
OWN = ("display", "opacity", "clip-path", "mask")

#: Default values. Source: SVG 1.1, property index.
INITIAL: Mapping[str, str] = {
    "stroke": "none", "stroke-width": "1", "stroke-opacity": "1", "stroke-dasharray": "none",
    "fill": "black", "fill-opacity": "1", "color": "black", "visibility": "visible",
}  # fmt: skip

Style = Mapping[str, str]

# No pattern here looks ahead without end from more than one place: a sheet of many beginnings would
# take the square of its length.
_STATEMENT = re.compile(r"@(?:import|charset|namespace)")
_STATEMENT_END = re.compile(r"[;{]")
_BRACE = re.compile(r"([{}])")
#: Of an element that is pointed at, or of a part of a text: no drawing lies so.
_PASSING = re.compile(r"::|:(hover|active|focus|visited|link|target|selection)\b")
_SELECTOR = re.compile(r"(\*|[A-Za-z][\w-]*)?((?:[.#][^\s.#:>+~\[\]*]+)*)\Z")


class Compound(Struct, frozen=True):
    """What a selector asks of one element."""

    tag: str  #: "" for any
    identity: str
    classes: tuple[str, ...]  #: as often as they are written, which is how much they weigh

    @classmethod
    def of(cls, selector: re.Match[str]) -> "Compound":
        parts = re.findall(r"([.#])([^.#]+)", selector[2])
        classes = tuple(name for mark, name in parts if mark == ".")
        identity = next((name for mark, name in parts if mark == "#"), "")
        return cls("" if selector[1] in (None, "*") else selector[1], identity, classes)

    def fits(self, element: Element) -> bool:
        """Whether an element has all of it."""
        return (
            self.tag in ("", element.tag)
            and self.identity in ("", element.get("id"))
            and {*self.classes}.issubset((element.get("class") or "").split())
        )


class CssRule(Struct, frozen=True):
    """One selector and what it sets."""

    compounds: tuple[Compound, ...]  #: the outermost first, the element's own last
    is_child: tuple[bool, ...]  #: whether each but the first stands right in the one before
    order: int
    style: tuple[tuple[str, str, bool], ...]  #: property, value, important

    @property
    def weight(self) -> tuple[int, int, int, int]:
        """Order of precedence: ids before classes before names, later ones before earlier."""
        return (
            sum(bool(c.identity) for c in self.compounds),
            sum(len(c.classes) for c in self.compounds),
            sum(bool(c.tag) for c in self.compounds), self.order,
        )  # fmt: skip

    def fits(self, element: Element) -> bool:
        """Whether an element is one that the selector names."""
        if not self.compounds[-1].fits(element):
            return False
        above: list[Element] = []
        while element.parent is not None:
            element = element.parent
            above.append(element)
        places = {-1}  #: in `above`, of what may stand for the compound before
        for compound, is_child in zip(self.compounds[-2::-1], self.is_child[::-1], strict=True):
            after = {k + 1 for k in places} if is_child else range(min(places) + 1, len(above))
            places = {k for k in after if k < len(above) and compound.fits(above[k])}
            if not places:
                return False
        return True


class StyleSheet(Struct):
    """The rules of a file, found by the class, id or name that they ask for."""

    by_key: dict[str, list[CssRule]] = field(default_factory=dict)
    ignored: list[str] = field(default_factory=list)  #: selectors that are not understood
    hiding: list[str] = field(default_factory=list)  #: such ones that could hide a contour
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
        steps = re.sub(r"\s*>\s*", " > ", selector).split()
        matches = [_SELECTOR.fullmatch(step) for step in steps if step != ">"]
        compounds = [Compound.of(match) for match in matches if match is not None]
        places = [k for k, step in enumerate(steps) if step != ">"]
        lone = any(b - a > 2 for a, b in pairwise(places)) or places[:1] != [0]
        if lone or len(compounds) < len(places) or steps[-1] == ">":
            if _PASSING.search(selector) or not any(_hides(name, text) for name, text, _ in style):
                if any(name in INHERITED or name in OWN for name, _, _ in style):
                    self.ignored.append(selector)
            else:
                self.hiding.append(selector)
            return
        self._count += 1
        is_child = tuple(b - a == 2 for a, b in pairwise(places))
        rule = CssRule(tuple(compounds), is_child, self._count, style)
        own = compounds[-1]
        key = f".{min(own.classes)}" if own.classes else own.tag
        self.by_key.setdefault(f"#{own.identity}" if own.identity else key, []).append(rule)

    def rules_for(self, element: Element) -> list[CssRule]:
        """The rules that fit `element`, the weightiest last."""
        classes = (element.get("class") or "").split()
        keys = ["", element.tag, f"#{element.get('id')}", *(f".{name}" for name in classes)]
        css_rules = [
            rule
            for key in dict.fromkeys(keys)
            for rule in self.by_key.get(key, ())
            if rule.fits(element)
        ]
        return sorted(css_rules, key=lambda rule: rule.weight)


#: Values of properties that take what has a stroke out of sight.
_GONE = {"display": ("none",), "visibility": ("hidden", "collapse"), "stroke": ("none",)}


def _hides(name: str, value: str) -> bool:
    """Whether a declaration takes what has a stroke out of sight."""
    if name in ("opacity", "stroke-opacity"):
        return is_nothing(value)
    return value.lower() in _GONE.get(name, ()) or (name == "stroke" and is_transparent(value))


def is_nothing(opacity: str) -> bool:
    """Whether nothing shows at an opacity: 0, 0.0, 0%. A value that browsers ignore is none."""
    try:
        return float(opacity.strip().rstrip("%")) <= 0.0
    except ValueError:
        return False


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
    while (match := _STATEMENT.search(text, begin)) and (
        end := _STATEMENT_END.search(text, match.end())
    ):
        begin = end.end()
        if end[0] == ";":
            kept.append(text[at : match.start()])
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
