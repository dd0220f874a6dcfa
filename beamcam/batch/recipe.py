"""The options of a batch as kept in its record, so that `check` uses the same again.

Paths are kept from the folder of the outputs, so that they hold where the folder, its inputs and
its machines lie together on another system.
"""

import os
from collections.abc import Mapping
from hashlib import sha256
from typing import Any

from msgspec import Struct, field

from beamcam.config.values import Config, ConfigFiles
from beamcam.reports.run import dumped
from beamcam.system import portable_path

MACHINE, MACHINES = "machine", "machines"  #: the options that may be paths
#: Options that say nothing of the programs, or are kept in another way.
_APART = ("config_file", "trust", "jobs", "as_json")
#: Values of options that are as if they were not given.
_DEFAULTS = {"order": "given", "mark_from": "mark", "rest_as": "nc1"}
#: Options whose value means something though it is empty: `--allow-skips none`, `--tree`.
_MAY_BE_NOTHING = ("skips", "strict", "flat")


class Recipe(Struct, frozen=True, forbid_unknown_fields=True):
    """The configuration of a run and the options that it was given."""

    configs: tuple[str, ...] = ()  #: its files, the nearest first
    own: tuple[str, ...] = ()  #: those of them that were followed in full
    asked: Mapping[str, Any] = field(default_factory=dict)  #: by the names of the options' values

    @property
    def name(self) -> str:
        """What lines of a record call it by."""
        return sha256(dumped(self)).hexdigest()[:16]


def recipe_of(config: Config, options: Mapping[str, Any], folder: str) -> Recipe:
    """The recipe of a run into `folder`; `options` holds the values of its options."""
    given = {
        name: value
        for name, value in options.items()
        if name not in _APART and value is not None and value != _DEFAULTS.get(name)
        and (value not in ((), False) or name in _MAY_BE_NOTHING)
    }  # fmt: skip
    machine = config.machine if MACHINE in given else None
    if machine is not None and machine.endswith(".toml"):
        given[MACHINE] = path_from(folder, portable_path(machine))
    if MACHINES in given:
        given[MACHINES] = [
            path_from(folder, portable_path(name)) if name.endswith(".toml") else name
            for name in config.split
        ]
    files, own = ([path_from(folder, p) for p in paths] for paths in (config.files, config.own))
    return Recipe(tuple(files), tuple(own), given)


def asked_again(recipe: Recipe, folder: str) -> tuple[ConfigFiles, dict[str, Any]]:
    """The configuration's files and the options of a recipe, as they hold from here.

    What is never kept in a record is not taken from one either.
    """
    options = {
        name: tuple(value) if isinstance(value, list) else value
        for name, value in recipe.asked.items()
        if name not in _APART
    }
    machine = options.get(MACHINE)
    if isinstance(machine, str) and machine.endswith(".toml"):
        options[MACHINE] = path_below(folder, machine)
    if MACHINES in options:
        options[MACHINES] = tuple(
            path_below(folder, name) if name.endswith(".toml") else name
            for name in map(str, options[MACHINES])
        )
    beside = tuple(path_below(folder, p) for p in recipe.configs if p not in recipe.own)
    return ConfigFiles(beside, tuple(path_below(folder, p) for p in recipe.own)), options


def path_from(folder: str, path: str) -> str:
    """A path as it is reached from a folder, with "/"; in full where it lies on another drive."""
    whole = os.path.abspath(path)
    try:
        return os.path.relpath(whole, os.path.abspath(folder)).replace(os.sep, "/")
    except ValueError:
        return whole


def path_below(folder: str, path: str) -> str:
    """The path that `path_from` made of it, from here."""
    return os.path.normpath(os.path.join(folder, path))
