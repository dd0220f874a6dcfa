"""Programs of profiles that turn below an upright torch, read back wall by wall.

The middle of the section's height and width lies at Y 0, Z 0. Seen from the bar the torch goes
round it: where the bar has turned by A, so has the torch, and looks at the faces at the same A.

       A 0               A -90
    |   | torch        ____|____ o
    |   |   |              |
  u |___v___| o          v +          +: the axis
    |   +   |              |
    |       |          ____|____ u
"""

from collections.abc import Sequence
from math import cos, dist, radians, sin

from beamcam.checks.coping import rules
from beamcam.checks.coping.chart import row_at, row_for
from beamcam.checks.coping.profile_torch import ProfileTorch
from beamcam.controllers.events import Move, Place
from beamcam.errors import Source
from beamcam.machine.torch import TorchRow

SPEED_SHARE = 0.01  #: of a block's way that its time may be off by, besides how it is written
#: by which the speed of a whole cut may be off by its figures, where there are speeds between rows
MEAN_SHARE = 5e-4


class TurnedTorch(ProfileTorch):
    """An upright torch over an I, a U, an L or a T that turns."""

    def _tip_of(self, place: Place, a_deg: float, b_deg: float = 0.0) -> Place:
        """Where the tip is in the section's axes."""
        (x, y, z), (at_y, at_z) = place, self._section.axis
        c, s = cos(radians(a_deg)), sin(radians(a_deg))
        return x, at_y + y * c - z * s, at_z + y * s + z * c

    def _row(
        self, source: Source, moves: Sequence[Move[Place]], feet: Sequence[tuple[float, float]]
    ) -> TorchRow | None:
        """The row at whose feed every block goes; where each has its own time, within what its
        figures leave open."""
        ways = [dist(move.start, move.end) for move in moves]
        minutes = [
            move.minutes or (way / move.feed_mm_min if move.feed_mm_min > 0.0 else 0.0)
            for move, way in zip(moves, ways, strict=True)
        ]
        mean = sum(ways) / sum(minutes) if sum(minutes) > 0.0 else 0.0
        walls = self._section.web, self._section.flange
        known = [*self._rows, *(row_for(self._rows, self._coper, wall) for wall in walls)]
        share = SPEED_SHARE if self._coper.between_rows == "row above" else MEAN_SHARE
        near = [row for row in known if row and abs(row.feed_mm_min - mean) <= share * mean]
        row = min(near, key=lambda one: abs(one.feed_mm_min - mean), default=None)
        row = row or row_at(self._rows, self._coper, mean)
        written = 2 * self._machine.format.resolution
        if row is not None and all(
            abs(way - row.feed_mm_min * time) <= SPEED_SHARE * way + written
            for way, time in zip(ways, minutes, strict=True)
        ):
            return row
        speeds = [way / time if time else 0.0 for way, time in zip(ways, minutes, strict=True)]
        self._say(rules.FEED.at(
            source, found=f"{min(speeds):.0f} to {max(speeds):.0f}", thickness="steel",
            expected=", ".join(f"{one.feed_mm_min:g}" for one in self._rows),
        ))  # fmt: skip
        return None
