"""Changes of a drilling machine by a configuration: its tolerances."""

from msgspec.structs import replace

from beamcam.config import rules
from beamcam.config.load import ConfigError
from beamcam.config.values import COMMAND_LINE, Config
from beamcam.machine.machine import Machine
from beamcam.machine.range_faults import slack_faults

#: Key below `[tolerances]` -> field of the machine's drill that it stands for.
TOLERANCES = {
    "merge": "merge_tolerance",
    "duplicate": "duplicate_tolerance",
    "sink": "sink_tolerance",
    "path": "path_tolerance",
    "twin": "twin",
}


def with_tolerances(machine: Machine, config: Config) -> Machine:
    """The machine with the configuration's tolerances in place of its own; itself if none.

    One configuration serves machines of all kinds, so that one that does not drill is left as it
    is. Raises ConfigError where that is the one that the configuration names for all its jobs, and
    for a tolerance that no machine file may have.
    """
    if not config.tolerances:
        return machine
    if machine.drill is None:
        if config.machine is None or config.sources.get("machine") == COMMAND_LINE:
            return machine
        key = f"tolerances.{next(iter(config.tolerances))}"
        source = config.place(key)
        raise ConfigError(rules.NO_DRILL.at(source, key=key, machine=machine.name))
    changed = {TOLERANCES[name]: value for name, value in config.tolerances.items()}
    # The names are those of TOLERANCES, so that they are fields of a drill.
    drill = replace(machine.drill, **changed)
    wrong = {name: rest for name, *rest in slack_faults(drill)}
    for name in config.tolerances:
        if TOLERANCES[name] in wrong:
            found, expected = wrong[TOLERANCES[name]]
            key = f"tolerances.{name}"
            source = config.place(key)
            said = rules.WRONG_VALUE.at(source, key=key, found=f"{found:g}", expected=expected)
            raise ConfigError(said)
    return replace(machine, drill=drill)
