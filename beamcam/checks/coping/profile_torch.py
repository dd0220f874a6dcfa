"""Strokes of a torch that goes round a profile: the wall of each, its angle to that, its row.

Or of an upright torch over a profile that turns about the middle of its height and width, Y 0, Z 0.
Seen from the bar the torch goes round it: where the bar has turned by A, so has the torch, and
looks at the faces at the same A.

       A 0               A -90
    |   | torch        ____|____ o
    |   |   |              |
  u |___v___| o          v +          +: the axis
    |   +   |              |
    |       |          ____|____ u
"""

from collections.abc import Sequence
from math import atan, cos, degrees, dist, hypot, inf, radians, sin

from msgspec import Struct

from beamcam.checks.coping import rules
from beamcam.checks.coping.chart import CoperJob
from beamcam.checks.coping.section import CoperSection
from beamcam.checks.coping.strokes import (
    ANGLE_SLACK_DEG,
    ANGLES,
    HEIGHT_SLACK,
    TorchFollower,
    TorchStroke,
    below,
)
from beamcam.controllers.events import Move, Place
from beamcam.errors import Source
from beamcam.geometry.plane import Point
from beamcam.machine.torch import TorchRow

SHARES = (0.25, 0.5, 0.75)  #: of such a block, where the torch is looked at besides its ends
SPEED_SHARE = 0.01  #: of its way that its time may be off by, besides how it is written
#: by which the speed of a whole cut may be off by its figures, where there are speeds between rows
MEAN_SHARE = 5e-4
TURNED = 0.002  #: mm that its way may be off as A and B are written


class ProfileTorch(TorchFollower):
    """A torch that goes round an I, a U, an L or a T."""

    def __init__(self, job: CoperJob, section: CoperSection) -> None:
        super().__init__(job)
        self._section = section

    @property
    def sizes(self) -> tuple[float, float]:
        return self._section.high, self._section.wide

    def _take(self, line: int, moves: Sequence[Move[Place]]) -> None:
        """A stroke: its wall, its heights, its row."""
        source, coper = self._job.at(line), self._coper
        poses, ends = self._poses(moves)
        face = self._face_of(poses[0])
        if face is None:
            self._say(rules.ANGLE.at(source, found=f"{poses[0].a_deg:g}"))
            return
        of_turns: dict[Point, Point] = {}
        for turned in {pose.turned for pose in poses}:
            # How far the head is over along x and y of the face, by mm of height over it; without
            # an end where it looks along the face or away from it.
            x, y, z = below((0.0, 0.0, 0.0), -1.0, *turned)
            along, out = (y, z) if face == "v" else (z, y if face == "o" else -y)
            of_turns[turned] = (x / out, along / out) if out > 0.0 else (inf, inf)
        leans = [of_turns[pose.turned] for pose in poses]
        leaning = [atan(hypot(*lean)) for lean in leans]
        for pose, angle in zip(poses, leaning, strict=True):
            if degrees(angle) > coper.tilt + ANGLE_SLACK_DEG:
                found = f"{pose.b_deg:g}" if pose.is_on(face) else f"{pose.b_deg:g}, A off its face"
                self._say(rules.TILT.at(source, found=found, expected=f"{coper.tilt:g}"))
                return
        over = [self._section.over(face, *pose.tip[1:]) for pose in poses]
        feet = [
            pose.foot(face, height, lean)
            for pose, height, lean in zip(poses, over, leans, strict=True)
        ]
        row = self._row(source, moves, [feet[k] for k in ends])
        if row is None:
            return
        # The tip is wide; its lower edge keeps the height of the row.
        lowest = [
            height - coper.torch_width / 2 * sin(angle)
            for height, angle in zip(over, leaning, strict=True)
        ]
        self._heights(source, face, row, [lowest[k] for k in ends], lowest[ends[1] :])
        if dist(feet[0], feet[ends[1]]) > HEIGHT_SLACK or poses[0].turned != poses[ends[1]].turned:
            self._wrong(line, "a slanting way down to the steel", "one straight along the torch")
        places = tuple(pose.tip[1:] for pose in poses)
        cut = poses[ends[1] :]
        each_turn = {pose.turned: pose for pose in cut}.values()
        stands = all(pose.is_on(face) and pose.b_deg == cut[0].b_deg for pose in each_turn)
        moving = () if stands else tuple(leans[ends[1] :])
        points = tuple(feet[ends[1] :])
        self.strokes.append(TorchStroke(line, face, points, places, row, cut[0].b_deg, moving))

    def _poses(self, moves: Sequence[Move[Place]]) -> "tuple[list[_Pose], list[int]]":
        """The torch at the start of some moves and at the end of each, and on the way of those on
        which it turns; and which of them are at ends of moves."""
        poses = [self._pose(moves[0], 0.0)]
        ends = [0]
        for move in moves:
            is_steady = move.a_deg[0] == move.a_deg[1] and (
                not self._tilts or move.b_deg[0] == move.b_deg[1]
            )
            poses += [self._pose(move, share) for share in (() if is_steady else SHARES)]
            poses.append(self._pose(move, 1.0))
            ends.append(len(poses) - 1)
        return poses, ends

    def _pose(self, move: Move[Place], share: float) -> "_Pose":
        """The torch on the way of a move, which turns and goes evenly."""
        (x0, y0, z0), (x1, y1, z1) = move.start, move.end
        place = x0 + share * (x1 - x0), y0 + share * (y1 - y0), z0 + share * (z1 - z0)
        a_deg = move.a_deg[0] + share * (move.a_deg[1] - move.a_deg[0])
        b_deg = move.b_deg[0] + share * (move.b_deg[1] - move.b_deg[0]) if self._tilts else 0.0
        x, y, z = self._tip_of(place, a_deg, b_deg)
        return _Pose((x - self._coper.trim, y, z), a_deg, b_deg)

    def _face_of(self, pose: "_Pose") -> str | None:
        """The wall that the torch looks at: A is that of its face, or off it by what it may tilt,
        and its tip is in front of it, nearest of those."""
        most = self._coper.tilt + ANGLE_SLACK_DEG
        faces = [face for a, face in ANGLES.items()
                 if face in self._section.faces and abs(a - pose.a_deg) <= most]  # fmt: skip
        exact = [face for face in faces if pose.is_on(face)]
        return min(exact or faces, default=None,
                   key=lambda face: abs(self._section.over(face, *pose.tip[1:])))  # fmt: skip

    def _row(
        self, source: Source, moves: Sequence[Move[Place]], feet: Sequence[Point]
    ) -> TorchRow | None:
        """The row whose feed all moves have, those of inverse time along the face."""
        feeds = {m.feed_mm_min for m in moves if not m.minutes}
        row = self._job.row_at(min(feeds, default=0.0))
        slack = 2 * self._job.machine.format.resolution + TURNED
        speeds = []
        for move, way in zip(moves, map(dist, feet, feet[1:]), strict=True):
            expected = row.feed_mm_min * move.minutes if row is not None else 0.0
            if move.minutes and abs(way - expected) > SPEED_SHARE * way + slack:
                speeds.append(way / move.minutes)
        if len(feeds) > 1 or row is None or speeds:
            shown = ", ".join(f"{feed:g}" for feed in sorted({*feeds, *speeds[:1]}))
            of_chart = ", ".join(f"{row.feed_mm_min:g}" for row in self._job.rows)
            self._say(rules.FEED.at(source, found=shown, thickness="steel", expected=of_chart))
            return None
        return row


class TurnedTorch(ProfileTorch):
    """An upright torch over an I, a U, an L or a T that turns."""

    def _tip_of(self, place: Place, a_deg: float, b_deg: float = 0.0) -> Place:
        """Where the tip is in the section's axes."""
        (x, y, z), (at_y, at_z) = place, self._section.axis
        c, s = cos(radians(a_deg)), sin(radians(a_deg))
        return x, at_y + y * c - z * s, at_z + y * s + z * c

    def _row(
        self, source: Source, moves: Sequence[Move[Place]], feet: Sequence[Point]
    ) -> TorchRow | None:
        """The row at whose feed every block goes, within what its figures leave open."""
        ways = [dist(move.start, move.end) for move in moves]
        minutes = [
            move.minutes or (way / move.feed_mm_min if move.feed_mm_min > 0.0 else 0.0)
            for move, way in zip(moves, ways, strict=True)
        ]
        mean = sum(ways) / sum(minutes) if sum(minutes) > 0.0 else 0.0
        walls = self._section.web, self._section.flange
        known = [*self._job.rows, *map(self._job.row_for, walls)]
        share = SPEED_SHARE if self._coper.between_rows == "row above" else MEAN_SHARE
        near = [row for row in known if row and abs(row.feed_mm_min - mean) <= share * mean]
        row = min(near, key=lambda one: abs(one.feed_mm_min - mean), default=None)
        row = row or self._job.row_at(mean)
        written = 2 * self._job.machine.format.resolution
        if row is not None and all(
            abs(way - row.feed_mm_min * time) <= SPEED_SHARE * way + written
            for way, time in zip(ways, minutes, strict=True)
        ):
            return row
        speeds = [way / time if time else 0.0 for way, time in zip(ways, minutes, strict=True)]
        self._say(rules.FEED.at(
            source, found=f"{min(speeds):.0f} to {max(speeds):.0f}", thickness="steel",
            expected=", ".join(f"{one.feed_mm_min:g}" for one in self._job.rows),
        ))  # fmt: skip
        return None


class _Pose(Struct, frozen=True, gc=False):
    """Tip, A and B of the torch, X from the part's start."""

    tip: Place
    a_deg: float
    b_deg: float

    @property
    def turned(self) -> tuple[float, float]:
        return self.a_deg, self.b_deg

    def is_on(self, face: str) -> bool:
        """Whether A is that of a face."""
        return any(f == face and abs(a - self.a_deg) <= ANGLE_SLACK_DEG for a, f in ANGLES.items())

    def foot(self, face: str, height: float, lean: Point) -> Point:
        """Where the torch points at on a face, from so high over it, with its head so far over."""
        x, y, z = self.tip
        return x - height * lean[0], (y if face == "v" else z) - height * lean[1]
