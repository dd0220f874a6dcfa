"""SVG pictures read by a parser of XML that knows nothing of how they were made."""

from xml.etree import ElementTree

NAMESPACE = "{http://www.w3.org/2000/svg}"


class Drawing:
    """The shapes of a picture by the classes that they carry."""

    def __init__(self, text: str) -> None:
        self.root = ElementTree.fromstring(text)

    def all(self, *classes: str) -> list[ElementTree.Element]:
        """The shapes that carry all of the classes, legends left out."""
        wanted = set(classes)
        return [
            e
            for e in self.root.iter()
            if wanted <= set(e.get("class", "").split()) and "legend" not in e.get("class", "")
        ]

    def count(self, *classes: str) -> int:
        return len(self.all(*classes))

    @property
    def texts(self) -> list[str]:
        return ["".join(e.itertext()) for e in self.root.iter(f"{NAMESPACE}text")]


def corners(path: ElementTree.Element) -> list[tuple[float, float]]:
    """The corners of a path of one start and relative lines."""
    words = path.get("d", "").removesuffix("z").replace("l", " ").removeprefix("M").split()
    figures = [float(w) for w in words]
    x, y = figures[:2]
    found = [(x, y)]
    for dx, dy in zip(figures[2::2], figures[3::2], strict=True):
        x, y = x + dx, y + dy
        found.append((x, y))
    return found
