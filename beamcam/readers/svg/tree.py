"""XML to elements that know their line; names of SVG without prefix, others left out."""

import re
from xml.parsers import expat

from msgspec import Struct, field

from beamcam.errors import ReadError, Source
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
