"""Which keys of the map of colours and layers a drawing has curves for."""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence

from beamcam.errors import Diagnostic, Rule, Severity, Source
from beamcam.machine.torch import OTHERS
from beamcam.model.colour import colour_name, key_of
from beamcam.model.part import Contour, Part

UNMATCHED = Rule(
    "plan-map-key",
    Severity.ERROR,
    "found --map {found}, a colour or layer that no curve has; expected one of {expected}",
    "A key that matches nothing is misspelt, or meant for another drawing; the curves that it was "
    "meant for would be cut as something else.",
)
IDLE = Rule(
    "plan-map-idle",
    Severity.NOTE,
    "found no curve of colour or layer {found} in any drawing",
    "A key of the map that nothing in the whole run matches may be misspelt.",
)
RULES = (UNMATCHED, IDLE)


def curves_by_key(parts: Iterable[Part], table: Iterable[str]) -> Counter[str]:
    """Number of curves and texts of the parts that each key of the map matches."""
    keys = tuple(table)
    known: dict[tuple[str | None, str | None], str | None] = {}
    found: Counter[str] = Counter()
    for part in parts:
        for feature in part.features:
            if isinstance(feature, Contour):
                look = feature.layer, feature.colour
                if look not in known:
                    known[look] = key_of(feature, keys)
                key = known[look]
                if key is not None:
                    found[key] += len(feature.curves)
        for layer, count in part.measures.lettered if part.measures is not None else ():
            found.update({key: count for key in keys if key.lower() == layer.lower()})
    return found


def unmatched(
    asked: Mapping[str, str], parts: Sequence[Part], table: Iterable[str]
) -> Iterator[Diagnostic]:
    """An error for each requested key that matches no curve of the parts."""
    used = curves_by_key(parts, table)
    for key, process in asked.items():
        if key not in used and key != OTHERS:
            source = parts[0].source if parts else Source("--map")
            expected = ", ".join(_looks(parts)) or "none, no curve has a colour or a layer"
            yield UNMATCHED.at(source, found=f"{key}={process}", expected=expected)


def idle(keys: Iterable[str], used: Iterable[str], source: Source) -> Iterator[Diagnostic]:
    """A note for each key that nothing of a whole run matched."""
    known = set(used)
    return (IDLE.at(source, found=key) for key in keys if key not in known and key != OTHERS)


def _looks(parts: Iterable[Part]) -> list[str]:
    """The layers and colours that contours of the parts have, sorted."""
    contours = [f for part in parts for f in part.features if isinstance(f, Contour)]
    layers = {c.layer for c in contours if c.layer is not None}
    colours = {colour_name(c.colour) for c in contours if c.colour is not None}
    return [*sorted(layers), *sorted(colours)]
