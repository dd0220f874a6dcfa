"""Rolled sections by name and by their measures.

The measures are facts of the standards: I and H of EN 10365 (IPE, HE A, B, M), channels of
EN 10365 (UPN of DIN 1026-1, UPE of DIN 1026-2), angles of EN 10056-1, hollow sections of
EN 10210-2 and EN 10219-2.
"""

import json
import re
from bisect import bisect_left, bisect_right
from importlib.resources import files

from beamcam.caches import cached
from beamcam.model.part import Profile, ProfileCode

TOLERANCE = 0.3  #: mm that a section may differ from the standard's measures in any of them

Sizes = tuple[float, float, float, float, float]  #: height, width, flange, web, radius


@cached("sections.table")
def sections() -> dict[str, tuple[ProfileCode, Sizes]]:
    """Code and measures of every section, by its name in capitals without blanks."""
    text = files("beamcam.model").joinpath("sections.json").read_text("utf-8")
    return {
        plain_name(name): (group["code"], (h, b, tf, tw, r))
        for group in json.loads(text)["groups"]
        for name, (h, b, tf, tw, r) in group["sections"].items()
    }


@cached("sections.by_code")
def _by_code() -> dict[str, tuple[tuple[Sizes, str], ...]]:
    """Measures and name of the sections of each code, ascending by height; as given if equal."""
    grouped: dict[str, list[tuple[Sizes, str]]] = {}
    for name, (code, sizes) in sections().items():
        grouped.setdefault(code, []).append((sizes, name))
    return {code: tuple(sorted(rows, key=_height)) for code, rows in grouped.items()}


def _height(row: tuple[Sizes, str]) -> float:
    return row[0][0]


def plain_name(name: str) -> str:
    """A section's name in one spelling: HE 200 B, HEB-200 and heb200 are HEB200."""
    text = name.upper().replace(",", ".").replace("*", "X").replace("×", "X")
    text = re.sub(r"[\s_-]", "", text)
    swapped = re.fullmatch(r"HE(\d+)([ABM])", text)
    return f"HE{swapped[2]}{swapped[1]}" if swapped else text


def measures_of(name: str) -> tuple[ProfileCode, Sizes] | None:
    """Code and measures of a section by its name; None if the catalogue has none of that name."""
    return sections().get(plain_name(name))


@cached("sections.name")
def name_of(profile: Profile) -> str | None:
    """The catalogue's name of a section with these measures, the nearest within the tolerance."""
    rows = _by_code().get(profile.code, ())
    # Twice as far up and down as a section may be, so that no rounding decides.
    first = bisect_left(rows, profile.height - 2 * TOLERANCE, key=_height)
    last = bisect_right(rows, profile.height + 2 * TOLERANCE, key=_height)
    off = [(difference(profile, sizes), name) for sizes, name in rows[first:last]]
    near = [row for row in off if row[0] <= TOLERANCE]
    return min(near, key=lambda row: row[0])[1] if near else None


def difference(profile: Profile, sizes: Sizes) -> float:
    """The largest difference in mm of a profile from height, width and thicknesses of a section.

    The radius does not count: exporters leave fillets out.
    """
    h, b, tf, tw, _ = sizes
    return max(
        abs(profile.height - h),
        abs(profile.width - b),
        abs(profile.flange_thickness - tf),
        abs((profile.web_thickness or 0.0) - tw),
    )
