"""Caches: each by name with a bound and a reason, in one place, and safe in threads."""

import ast
import re
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from beamcam.caches import CACHES, BoundedCache, PerMembers, PerObject, cached

PACKAGE = Path(__file__).resolve().parents[2] / "beamcam"


@pytest.fixture
def hasty() -> Iterator[None]:
    """Threads take turns as often as they can."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(before)


#: How many of its first arguments are names of the table.
NAMES_OF = {"cached": 1, "BoundedCache": 1, "PerObject": 1, "PerMembers": 1, "PerObjectAndKey": 2}


def test_every_cache_has_a_bound_and_a_reason() -> None:
    for name, kept in CACHES.items():
        assert 0 < kept.max_entries <= 4096, name
        assert len(kept.reason) > 20, name


def test_nothing_is_kept_elsewhere() -> None:
    """No other module has a cache of functools, and every cache of the table is used once."""
    used: list[str] = []
    for path in sorted(PACKAGE.rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        if path.name == "caches.py" or not re.search("functools|" + "|".join(NAMES_OF), text):
            continue
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.ImportFrom) and node.module == "functools":
                names = {alias.name for alias in node.names}
                assert not names & {"cache", "lru_cache"}, path
            if isinstance(node, ast.Call):
                names_of = NAMES_OF.get(ast.unparse(node.func).split("[")[0], 0)
                used += map(ast.literal_eval, node.args[:names_of])
    assert set(used) == set(CACHES)


def test_a_full_table_begins_anew() -> None:
    table: BoundedCache[int, int] = BoundedCache("planning.sections")
    bound = CACHES["planning.sections"].max_entries
    for key in range(bound):
        assert table.keep(key, -key) == -key
    assert len(table) == bound
    assert table.keep(0, 5) == 5 or len(table) == 1
    table.keep(bound, 1)
    assert len(table) <= bound


def test_the_first_value_stays() -> None:
    table: BoundedCache[str, object] = BoundedCache("planning.sections")
    first, second = object(), object()
    assert table.keep("a", first) is first
    assert table.keep("a", second) is first


def test_all_threads_have_one_value(hasty: None) -> None:
    class Thing:
        pass

    made = PerObject("planning.library", lambda _: object())
    things = [Thing() for _ in range(CACHES["planning.library"].max_entries)]
    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(lambda k: (k % len(things), made(things[k % len(things)])),
                              range(4000)))  # fmt: skip
    assert len(set(found)) == len(things)


def test_the_oldest_object_goes_first() -> None:
    counts: list[int] = []
    made = PerObject("planning.library", counts.append)
    bound = CACHES["planning.library"].max_entries
    keys = [10_000 + k for k in range(bound + 1)]
    for key in keys:
        made(key)
    made(keys[-1])
    made(keys[0])
    assert counts == [*keys, keys[0]]


def test_a_function_keeps_what_it_gave() -> None:
    calls: list[int] = []

    @cached("sections.name")
    def double(value: int) -> int:
        calls.append(value)
        return 2 * value

    assert [double(2), double(2), double(3)] == [4, 4, 6]
    assert calls == [2, 3]


def test_tuples_are_told_apart_by_their_members() -> None:
    made = PerMembers("curves.table", lambda _: object())
    one, other = 0.0, -0.0  # which are equal
    first = made((one, other))
    assert made((one, other)) is first
    assert made((other, one)) is not first
    assert made((one,)) is not first
