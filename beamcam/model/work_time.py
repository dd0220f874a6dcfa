"""Work time of a plan."""

from msgspec import Struct


class WorkTime(Struct, frozen=True):
    """Seconds of each operation in order of work, and of what is between and after them."""

    operations: tuple[float, ...]
    reloads_s: float = 0.0  #: tools put into stations manually during the work
    home_s: float = 0.0  #: from the last operation to where the next work begins

    @property
    def total_s(self) -> float:
        return sum(self.operations) + self.reloads_s + self.home_s


def clock(seconds: float) -> str:
    """A time as minutes and seconds, or hours where there are any."""
    whole = round(seconds)
    if whole < 3600:
        return f"{whole // 60}:{whole % 60:02d} min"
    return f"{whole // 3600}:{whole % 3600 // 60:02d}:{whole % 60:02d} h"
