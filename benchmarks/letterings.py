"""Letterings that are not what the part asks for, all to be refused by `post`.

The planner is made to write another character, one too few or too many, two in each other's place,
upside down, mirrored, on its side, over a hole or an edge, elsewhere, smaller or larger; a text on
another face is held against the part that has it on its own.
"""

import random
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any
from unittest.mock import patch

from msgspec.structs import replace

from beamcam.errors import PlanError, Source, VerifyError, errors_in
from beamcam.machine import Machine, load
from beamcam.model.part import Hole, Part, Profile, TextMark
from beamcam.model.request import Request
from beamcam.pipeline import post, read_back
from beamcam.planning import lettering
from beamcam.planning.lettering import Lettered

#: Machines of samples that are told their texts.
TOLD = Path(__file__).parents[1] / "samples" / "machines"
MACHINES = (
    "beamline-pusher", "plate-linuxcnc", "plate-codesys", "laser-grbl", "table-simotion",
    "table-plcopen",
    str(TOLD / "beamline-stamp.toml"), str(TOLD / "beamline-printer.toml"),
)  # fmt: skip
#: Of letters that look alike one only.
SIGNS = "ABCDEFGHJKLMNPQRSTUVWXYZ0123456789-/"
HOLE = 150.0, 60.0  #: its middle
SOURCE = Source("lettered.nc1", 1)
Change = Callable[[Lettered, random.Random], Lettered]


def another_character(one: Lettered, rng: random.Random) -> Lettered:
    k = rng.randrange(len(one.text))
    other = rng.choice([sign for sign in SIGNS if sign != one.text[k]])
    return replace(one, text=one.text[:k] + other + one.text[k + 1 :])


def missing_character(one: Lettered, rng: random.Random) -> Lettered:
    k = rng.randrange(len(one.text))
    return replace(one, text=one.text[:k] + one.text[k + 1 :])


def doubled_character(one: Lettered, rng: random.Random) -> Lettered:
    k = rng.randrange(len(one.text))
    return replace(one, text=one.text[: k + 1] + one.text[k:])


def swapped_characters(one: Lettered, rng: random.Random) -> Lettered:
    return replace(one, text=one.text[1] + one.text[0] + one.text[2:])


def upside_down(one: Lettered, rng: random.Random) -> Lettered:
    along = one.height * one.extent[2]
    return replace(one, x=one.x + along, y=one.y + one.height, angle=one.angle + 180.0)


def mirrored(one: Lettered, rng: random.Random) -> Lettered:
    return replace(one, y=one.y + one.height, mirrored=not one.mirrored)


def on_its_side(one: Lettered, rng: random.Random) -> Lettered:
    return replace(one, angle=one.angle + 90.0)


def turned_a_little(one: Lettered, rng: random.Random) -> Lettered:
    return replace(one, angle=one.angle + rng.choice((-1, 1)) * rng.uniform(2.0, 10.0))


def over_a_hole(one: Lettered, rng: random.Random) -> Lettered:
    return replace(one, x=HOLE[0] - rng.uniform(0.0, 15.0), y=HOLE[1] - one.height / 2)


def over_an_edge(one: Lettered, rng: random.Random) -> Lettered:
    return replace(one, x=rng.uniform(-0.5, 0.5) - one.height * one.extent[0] + 1.0)


def elsewhere(one: Lettered, rng: random.Random) -> Lettered:
    return replace(one, x=one.x + rng.uniform(0.1, 4.0))


def smaller(one: Lettered, rng: random.Random) -> Lettered:
    return replace(one, height=one.height * rng.uniform(0.6, 0.98))


def larger(one: Lettered, rng: random.Random) -> Lettered:
    return replace(one, height=one.height * rng.uniform(1.02, 1.3))


CHANGES: tuple[Change, ...] = (
    another_character, missing_character, doubled_character, swapped_characters, upside_down,
    mirrored, on_its_side, turned_a_little, over_a_hole, over_an_edge, elsewhere, smaller, larger,
)  # fmt: skip
ANGLES = (on_its_side, turned_a_little)


def lettered_part(machine: Machine, rng: random.Random, face: str = "v") -> Part:
    """A part with a hole and a text that stands free of it."""
    words = "".join(rng.sample(SIGNS, rng.randint(3, 6)))
    text = TextMark(face, rng.uniform(20.0, 40.0), 20.0, 0.0, rng.uniform(6.0, 10.0), words, SOURCE)
    hole = Hole("v", *HOLE, 18.0, SOURCE)
    if machine.torch is None:
        profile = Profile("I", "IPE300", 300.0, 150.0, 10.7, 7.1, 15.0)
        text = replace(text, y=60.0)
        hole = replace(hole, y=150.0) if face == "v" else hole
        return Part("B1", profile, 1200.0, SOURCE, features=(hole, text))
    return Part("P1", Profile("B", "PL3", 100.0, 0.0, 0.0, 3.0), 220.0, SOURCE,
                features=(hole, text))  # fmt: skip


def letterings(
    each: int, seed: int, machines: Sequence[str] = MACHINES
) -> Iterator[tuple[str, bool]]:
    """The name of each change to a lettering, and whether the program was refused for it."""
    rng = random.Random(seed)
    for name in machines:
        machine = load(name)
        for _ in range(each):
            part = lettered_part(machine, rng)
            assert not errors_in(post([part], machine).remarks)
            for change in CHANGES:
                if change in ANGLES and machine.marks.is_told and len(machine.marks.angles) == 1:
                    continue  # a program has no word by which it could be turned
                yield change.__name__, _is_refused(part, machine, change, rng)
        if machine.torch is None:
            part, other = lettered_part(machine, rng), lettered_part(machine, rng, "o")
            program = post([other], machine).text
            asked = replace(other, features=(other.features[0], replace(
                other.features[1], face="v"),))  # fmt: skip
            found = read_back(program, Request((asked,), machine))
            yield "another_face", bool(errors_in(found))


def _is_refused(part: Part, machine: Machine, change: Change, rng: random.Random) -> bool:
    place = lettering.place_text

    def lying(*asked: Any) -> Lettered | str:
        found = place(*asked)
        return found if isinstance(found, str) else change(found, rng)

    users = ("beamcam.planning.contours.assign_process", "beamcam.planning.lettering")
    with patch(f"{users[0]}.place_text", lying), patch(f"{users[1]}.place_text", lying):
        try:
            post([part], machine)
        except (VerifyError, PlanError):
            return True
    return False


def lettered_otherwise(each: int = 8, seed: int = 1) -> tuple[Counter[str], Counter[str]]:
    """How many letterings of each kind there were, and how many of them were refused."""
    made: Counter[str] = Counter()
    refused: Counter[str] = Counter()
    for name, is_refused in letterings(each, seed):
        made[name] += 1
        refused[name] += is_refused
    return made, refused
