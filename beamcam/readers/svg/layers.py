"""The name of the layer that a group is, as drawing programs write it."""

import re

from beamcam.readers.svg.tree import Element

_ESCAPED = re.compile(r"_x([0-9A-Fa-f]{4})_")
_NUMBER = re.compile(r"_?\d+\Z")


def layer_of(group: Element, depth: int) -> str | None:
    """The layer's name if `group` is a layer, None if not.

    Inkscape marks layers. CorelDRAW begins one with a `metadata` element and escapes its name
    (`Layer_x0020_1`). Elsewhere a named group at the top is one; a number is not a name.
    """
    if group.get("inkscape:groupmode") == "layer":
        return group.get("inkscape:label") or _name(group)
    marked = bool(group.children) and (group.children[0].get("id") or "").startswith("CorelCorpID")
    if marked or depth == 0:
        return _name(group)
    return None


def _name(group: Element) -> str | None:
    identity = group.get("id")
    if identity is None or _NUMBER.match(identity):
        return None
    return unescape(identity)


def unescape(name: str) -> str:
    """ "Layer 1" of "Layer_x0020_1"."""
    return _ESCAPED.sub(lambda found: chr(int(found[1], 16)), name)
