"""Where the configurations of a job are looked for, and whose they are.

    shop/beamcam.toml         here, where the command is called, or above: one's own
    shop/jobs/beamcam.toml    beside the inputs, further down or elsewhere: came with the parts
    ~/.config/beamcam/        the user's own, the farthest of all

What came with the parts is a stranger's as the parts are; `trust` says what is taken of it. Every
command comes by here, so that this module needs next to nothing.
"""

import json
import os
import os.path
import tomllib
from collections.abc import Iterable, Iterator, Sequence

from msgspec import Struct

from beamcam.config import NOT_FOLLOWED
from beamcam.config.values import Config, MapRow, Sheet, load
from beamcam.errors import Diagnostic
from beamcam.files import write_whole
from beamcam.machine.toml import line_of, toml_text
from beamcam.system import is_ones_own, is_open_to_all, user_folder

CONFIG_NAME = "beamcam.toml"
MACHINES = "machines"  #: folder of machine files that are known by name
_MAGIC = frozenset("*?[")


class ConfigFiles(Struct, frozen=True):
    """The configurations of a job, each list with the nearest first."""

    beside: tuple[str, ...] = ()  #: of the folders of the inputs and those above
    own: tuple[str, ...] = ()  #: of the folder of the command, those above, and the user
    #: the nearest of two inputs of the job, where these are different ones
    two: tuple[str, str] | None = None


def config_files(inputs: Iterable[str]) -> ConfigFiles:
    """The configurations that hold for a job on `inputs`. It costs a look at each folder.

    Each stands once, and what is one's own is not beside. Standard input lies in the folder that
    the command is called in.
    """
    own = own_files()
    known = {os.path.realpath(path): path for path in own}
    near: dict[str, tuple[str, ...]] = {}
    for folder in dict.fromkeys(map(_folder, inputs)):
        if chain := tuple(_upwards(folder)):
            near.setdefault(os.path.realpath(chain[0]), chain)
    first, *others = near.values() or [()]
    beside = {real: path for path in first if (real := os.path.realpath(path)) not in known}
    return ConfigFiles(tuple(beside.values()), own, (first[0], others[0][0]) if others else None)


def own_files() -> tuple[str, ...]:
    """The configurations here, in the folders above, and the user's own, the nearest first.

    In a folder that anybody may write to one has to belong to the user, or to the system's owner.
    """
    paths = [path for path in _upwards("") if path != CONFIG_NAME or _is_safe_here()]
    users = os.path.join(user_folder(), CONFIG_NAME)
    if os.path.isfile(users):
        paths.append(users)
    return tuple({os.path.realpath(path): path for path in reversed(paths)}.values())[::-1]


def is_ones_own_place(path: str) -> bool:
    """Whether a file lies where one's own configurations do, or their machines.

    That is in the folder of the command, in one above it, in the user's, or in `machines` of one.
    """
    folder = os.path.dirname(os.path.realpath(path))
    above, name = os.path.split(folder)
    places = (folder, above) if name == MACHINES else (folder,)
    here = os.path.join(os.path.abspath(""), CONFIG_NAME)
    users = _key(user_folder())
    return any(_key(place) == users or is_in(here, [place]) for place in places)


def is_in(path: str, folders: Iterable[str]) -> bool:
    """Whether a file lies in one of the folders, or anywhere below it; links are followed."""
    real = _key(path)
    return any(real.startswith(os.path.join(_key(folder), "")) for folder in folders)


def _key(path: str) -> str:
    return os.path.normcase(os.path.realpath(path))


def _is_safe_here() -> bool:
    return not is_open_to_all(os.curdir) or is_ones_own(CONFIG_NAME)


def _upwards(folder: str) -> Iterator[str]:
    """The configurations in a folder and in those above it.

    A folder above in which anybody may put a file is passed over.
    """
    path = os.path.join(folder, CONFIG_NAME)
    if os.path.isfile(path):
        yield path
    below, here = os.path.abspath(folder), os.path.abspath("")
    while (above := os.path.dirname(below)) != below:
        path = os.path.join(above, CONFIG_NAME)
        if os.path.isfile(path) and not is_open_to_all(above):
            yield CONFIG_NAME if above == here else path
        below = above


def _folder(name: str) -> str:
    """The folder of an input: itself if it is one; of a pattern as far as it has no magic."""
    if os.path.isdir(name):
        return name
    folder = os.path.dirname(name)
    while not _MAGIC.isdisjoint(folder) and not os.path.isdir(folder):
        folder = os.path.dirname(folder)
    return folder


# --- trust ----------------------------------------------------------------------------------------

# What is taken of a configuration that came with the parts.
#
# The sender of parts says what they are: how many, how thick, what a colour means, what they are
# called. The shop decides which machine makes them, what may be left out, where programs are
# written and how strict the run is.


#: Keys that are followed wherever a configuration lies; of rows of the map the process only.
HARMLESS = ("name", "job", "quantity", "map", "sheet.thickness", "sheet.material")


def harmless(config: Config) -> Config:
    """The harmless part of a configuration, with a remark that names the rest of it."""
    if not (diagnostics := not_followed(config)):
        return config
    sources = {key: at for key, at in config.sources.items() if _is_harmless(key)}
    given = {key: getattr(config, key) for key in sources if key in HARMLESS and "." not in key}
    if "map" in given:
        given["map"] = config.meanings
    sheet = {row: config.rows("sheet")[row] for row in config.rows("sheet")
             if f"sheet.{row}" in HARMLESS}  # fmt: skip
    if sheet:
        sources["sheet"] = config.sources["sheet"]
    return Config(
        **given, sheet=Sheet(**sheet), files=config.files, sources=sources, remarks=diagnostics
    )


def not_followed(config: Config) -> tuple[Diagnostic, ...]:
    """The message about the keys of a configuration that are more than harmless, if it has any."""
    keys = tuple(_more(config))
    if not keys:
        return ()
    places = (config.place(key, key.rpartition(".")[0]) for key in keys)
    source = min(places, key=lambda at: at.line or 0)
    folder = os.path.dirname(config.files[0]) or os.curdir
    found = ", ".join(map(repr, keys))
    return (NOT_FOLLOWED.at(source, found=found, known=", ".join(HARMLESS), folder=folder),)


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


# --- remember -------------------------------------------------------------------------------------

# Folders that the user trusts for good: the key `trust` of the user's own configuration.


KEY = "trust"


def remember(folders: Sequence[str]) -> str:
    """Add folders to those that the user's own configuration trusts, and give its path.

    The rest of the file is kept. Raises ConfigError for a file that is no configuration, and
    OSError.
    """
    path = os.path.join(user_folder(), CONFIG_NAME)
    text = ""
    known: Sequence[str] = ()
    if os.path.exists(path):
        known = load(path).trust
        with open(path, "rb") as file:
            text = toml_text(file.read())
    every = tuple(dict.fromkeys((*known, *map(os.path.abspath, folders))))
    os.makedirs(os.path.dirname(path), exist_ok=True)
    write_whole(path, with_trust(text, every))
    return path


def with_trust(text: str, folders: Sequence[str]) -> str:
    """The text of a configuration with these folders as its `trust`, and nothing else changed."""
    line = f"{KEY} = {json.dumps(list(folders), ensure_ascii=False)}\n"
    table = tomllib.loads(text)
    if KEY not in table:
        return line + text
    rest = {key: value for key, value in table.items() if key != KEY}
    lines = text.splitlines(keepends=True)
    begin = (line_of(text, KEY) or 1) - 1
    for end in range(begin + 1, len(lines) + 1):  # the value may go on over several lines
        try:
            if tomllib.loads("".join(lines[:begin] + lines[end:])) == rest:
                return "".join([*lines[:begin], line, *lines[end:]])
        except tomllib.TOMLDecodeError:
            continue
    raise AssertionError("a key that stands in a text stands in one of its lines")
