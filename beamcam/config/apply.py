"""What a configuration changes: the machine's tolerances, and what is done with a drawing."""

from collections.abc import Mapping

from msgspec.structs import replace

from beamcam.config import rules
from beamcam.config.keys import TOLERANCES
from beamcam.config.load import Config, ConfigError
from beamcam.errors import Source
from beamcam.machine.machine import Machine
from beamcam.model.colour import process_of
from beamcam.model.part import Contour, Part, Process


def apply_tolerances(machine: Machine, config: Config) -> Machine:
    """The machine with the configuration's tolerances in place of its own; itself if none.

    Raises ConfigError where the machine has nothing that a tolerance could be for.
    """
    if not config.tolerances:
        return machine
    if machine.drill is None:
        key = f"tolerances.{next(iter(config.tolerances))}"
        source = config.sources.get(key, Source(config.file or "configuration"))
        raise ConfigError(rules.NO_DRILL.at(source, key=key, machine=machine.name))
    changed = {TOLERANCES[name]: value for name, value in config.tolerances.items()}
    # The names are those of TOLERANCES, so that they are fields of a drill.
    return replace(machine, drill=replace(machine.drill, **changed))


def apply_map(part: Part, table: Mapping[str, Process]) -> Part:
    """The part with the process of each contour whose layer or colour `table` names."""
    if not table:
        return part
    features = tuple(
        replace(f, process=process_of(f, table) or f.process) if isinstance(f, Contour) else f
        for f in part.features
    )
    return part if features == part.features else replace(part, features=features)
