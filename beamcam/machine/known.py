"""What is worked out once for a machine and kept.

Machines are few and live as long as the process; they are told apart by identity, because a
record that holds a table has no hash.
"""

from collections.abc import Callable
from typing import Generic, TypeVar

from beamcam.machine.machine import Machine

Value = TypeVar("Value")

MOST_MACHINES = 16


class OncePerMachine(Generic[Value]):
    """Calls `make` once for each machine, and gives what came of it from then on."""

    def __init__(self, make: Callable[[Machine], Value]) -> None:
        self._make = make
        self._known: list[tuple[Machine, Value]] = []

    def __call__(self, machine: Machine) -> Value:
        for known, value in self._known:
            if known is machine:
                return value
        value = self._make(machine)
        self._known.insert(0, (machine, value))
        del self._known[MOST_MACHINES:]
        return value


Key = TypeVar("Key")


class Kept(dict[Key, Value]):
    """A table of what was worked out before, `most` entries at most: then it begins anew."""

    def __init__(self, most: int) -> None:
        super().__init__()
        self._most = most

    def keep(self, key: Key, value: Value) -> Value:
        """Note `value` under `key`, and give it back."""
        if len(self) >= self._most:
            self.clear()
        self[key] = value
        return value
