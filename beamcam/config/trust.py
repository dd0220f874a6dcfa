"""What is taken of a configuration that came with the parts.

The sender of parts says what they are: how many, how thick, what a colour means, what they are
called. The shop decides which machine makes them, what may be left out, where programs are written
and how strict the run is.
"""

import os
from collections.abc import Iterator

from beamcam.config import rules
from beamcam.config.values import Config, MapRow, Sheet
from beamcam.errors import Diagnostic

#: Keys that are followed wherever a configuration lies; of rows of the map the process only.
HARMLESS = ("name", "job", "quantity", "map", "sheet.thickness", "sheet.material")


def harmless(config: Config) -> Config:
    """The harmless part of a configuration, with a remark that names the rest of it."""
    if not (said := not_followed(config)):
        return config
    sources = {key: at for key, at in config.sources.items() if _is_harmless(key)}
    given = {key: getattr(config, key) for key in sources if key in HARMLESS and "." not in key}
    if "map" in given:
        given["map"] = config.meanings
    sheet = {row: config.rows("sheet")[row] for row in config.rows("sheet")
             if f"sheet.{row}" in HARMLESS}  # fmt: skip
    if sheet:
        sources["sheet"] = config.sources["sheet"]
    return Config(**given, sheet=Sheet(**sheet), files=config.files, sources=sources, remarks=said)


def not_followed(config: Config) -> tuple[Diagnostic, ...]:
    """The message about the keys of a configuration that are more than harmless, if it has any."""
    keys = tuple(_more(config))
    if not keys:
        return ()
    source = min((config.place(key, _parent(key)) for key in keys), key=lambda at: at.line or 0)
    folder = os.path.dirname(config.files[0]) or os.curdir
    found = ", ".join(map(repr, keys))
    return (rules.NOT_FOLLOWED.at(source, found=found, known=", ".join(HARMLESS), folder=folder),)


def _more(config: Config) -> Iterator[str]:
    """The keys that are not harmless, with their rows."""
    for key in config.sources:
        if key == "map":
            for name, row in config.map.items():
                if isinstance(row, MapRow):
                    yield from (f"map.{name}.{key}" for key in row.said() if key != "process")
        elif not _is_harmless(key) and not (config.sources.keys() & _rows_of(config, key)):
            yield key


def _rows_of(config: Config, key: str) -> frozenset[str]:
    """The dotted rows of a key that is a table."""
    return frozenset(other for other in config.sources if other.startswith(f"{key}."))


def _is_harmless(key: str) -> bool:
    return key in HARMLESS or key.startswith("map.")


def _parent(key: str) -> str:
    return key.rpartition(".")[0]
