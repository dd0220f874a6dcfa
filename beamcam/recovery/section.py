"""The section of a bar, as far as a program gives it."""

from collections.abc import Iterator, Mapping
from math import isnan, nan

from beamcam.errors import Diagnostic, Source
from beamcam.machine.machine import Machine
from beamcam.model.catalogue import sections
from beamcam.model.part import Profile
from beamcam.recovery import rules

SAME = 0.05  #: mm, by which height and width that a program says may differ from the catalogue's
SHOWN = 6  #: sections of one size that are named


def section_of(
    said: Mapping[str, float], machine: Machine, name: str
) -> tuple[Profile, Diagnostic]:
    """The section that a program says, by the catalogue if only one is of that size.

    Without thicknesses where there are several, or none; the remarks on it come second.
    """
    number = said.get("section", nan)
    codes = machine.sections_of(number) or ("SO",)
    height, width = said.get("height", nan), said.get("width", nan)
    same = [p for code in codes for p in _of_size(code, height, width)]
    size = " x ".join(f"{v:g}" for v in (height, width) if not isnan(v))
    figures = {"code": " or ".join(codes), "size": size or "unknown size"}
    if len(same) == 1:
        return same[0], rules.CATALOGUE.at(Source(name), name=same[0].name, **figures)
    known = ", ".join(p.name for p in same[:SHOWN]) or "none of that size in the catalogue"
    if len(same) > SHOWN:
        known += f" and {len(same) - SHOWN} more"
    height, width = (0.0 if isnan(v) else v for v in (height, width))
    profile = Profile(codes[0], "", height, width, 0.0, None)  # type: ignore[arg-type]
    return profile, rules.PROFILE.at(Source(name), known=known, **figures)


def _of_size(code: str, height: float, width: float) -> Iterator[Profile]:
    """The catalogue's sections of a size; any width where none is said."""
    for name, (own, (h, b, flange, web, radius)) in sections().items():
        if own == code and abs(h - height) <= SAME and (isnan(width) or abs(b - width) <= SAME):
            yield Profile(own, name, h, b, flange, web, radius)
