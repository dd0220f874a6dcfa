"""The imports point down, as the architecture says, and heavy libraries stay out of the way."""

import ast
import subprocess
import sys
from collections.abc import Collection, Iterator
from functools import cache
from itertools import groupby
from pathlib import Path

import pytest

from tests.conftest import ROOT

PACKAGE = ROOT / "beamcam"

#: A package may import those of lower steps; packages on one step never import each other.
STEPS = (
    ("caches", "conversion", "plain_text", "system", "version"),
    ("errors", "files", "processes"),
    ("budget",),
    ("geometry",),
    ("machine",),
    ("model",),
    ("controllers",),
    ("solid",),
    (
        "readers",
        "writers",
        "planning",
        "motion",
        "emitters",
        "checks",
        "config",
    ),
    ("reconcile",),
    ("posts", "comparison", "recovery", "simulation", "reports"),
    ("self_test",),
    ("arguments",),
    ("pictures",),
    ("setup_sheet",),
    ("pipeline",),
    ("rest_part",),
    ("suggestions", "remainder"),
    ("batch", "api"),
    ("commands",),
    ("cli",),
    ("__main__",),
)  # fmt: skip
STEP = {name: step for step, names in enumerate(STEPS) for name in names}
HEAVY = (
    "numpy", "ezdxf", "ifcopenshell", "shapely", "manifold3d", "jinja2", "svgelements",
    "hypothesis",
)  # fmt: skip

#: What only machines are asked that are not shipped, or stand behind the one that makes the part.
NOT_TRIED = (
    "beamcam.machine.faults", "beamcam.machine.references", "beamcam.machine.coper_faults",
    "beamcam.controllers.machine_words", "beamcam.controllers.rs274.interpreter",
)  # fmt: skip


def room(module: str) -> str | None:
    """The package or module right below `beamcam` that a dotted name lies in."""
    parts = module.split(".")
    return parts[1] if parts[0] == "beamcam" and len(parts) > 1 else None


@cache
def import_statements(text: str) -> tuple[ast.Import | ast.ImportFrom, ...]:
    """Those of a module, wherever in it they stand."""
    nodes = statements(ast.parse(text))
    return tuple(node for node in nodes if isinstance(node, ast.Import | ast.ImportFrom))


def statements(node: ast.AST) -> Iterator[ast.AST]:
    """Those below a node, without their expressions, which are most of a tree."""
    for name in ("body", "orelse", "finalbody", "handlers", "cases"):
        for below in getattr(node, name, ()):
            yield below
            yield from statements(below)


def imports(path: Path) -> set[str]:
    """The rooms that a file imports from, wherever in it the import stands."""
    names: set[str] = set()
    for node in import_statements(path.read_text(encoding="utf-8")):
        if isinstance(node, ast.Import):
            names |= {a.name for a in node.names}
        else:
            assert node.level == 0, f"{path}: relative import"
            names.add(node.module or "")
            if node.module == "beamcam":
                names |= {f"beamcam.{a.name}" for a in node.names}
    return {r for n in names if (r := room(n))}


def modules_under(package: Path) -> dict[str, Path]:
    """The modules of a package by their dotted names."""
    return {
        ".".join(path.relative_to(package.parent).with_suffix("").parts).removesuffix(
            ".__init__"
        ): path
        for path in package.rglob("*.py")
    }


def module_imports(path: Path, known: Collection[str]) -> set[str]:
    """Those of `known` modules that a file imports: inside functions and for types too."""
    names: set[str] = set()
    for node in import_statements(path.read_text(encoding="utf-8")):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif node.module:
            full = [f"{node.module}.{alias.name}" for alias in node.names]
            names |= {name if name in known else node.module for name in full}
    return names & set(known)


def circles_under(package: Path) -> list[str]:
    """The modules of a package that import each other, by whatever detour."""
    modules = modules_under(package)
    waiting = {name: module_imports(path, modules) - {name} for name, path in modules.items()}
    while free := {name for name, others in waiting.items() if not others}:
        waiting = {name: others - free for name, others in waiting.items() if name not in free}
    # What only leads into a circle is none.
    while loose := {n for n in waiting if not any(n in others for others in waiting.values())}:
        waiting = {name: others for name, others in waiting.items() if name not in loose}
    return sorted(waiting)


FILES = sorted(p for p in PACKAGE.rglob("*.py") if p.parent != PACKAGE or p.name != "__init__.py")


def test_imports_point_down() -> None:
    for path in FILES:
        own = path.relative_to(PACKAGE).parts[0].removesuffix(".py")
        assert own in STEP, f"{own} has no step in the architecture"
        for other in imports(path) - {own, "__version__"}:
            assert STEP[other] < STEP[own], f"{path}: {own} must not import {other}"


def test_the_check_sees_an_import_that_points_up(tmp_path: Path) -> None:
    bad = tmp_path / "bad.py"
    bad.write_text("def f():\n    from beamcam.pipeline import post\n")
    assert imports(bad) == {"pipeline"}
    assert STEP["pipeline"] > STEP["readers"]


def test_no_module_imports_itself_by_a_detour() -> None:
    assert circles_under(PACKAGE) == []


@pytest.mark.parametrize("back", [
    "from house import hall\n",
    "import house.hall\n",
    "def f():\n    from house.hall import key\n",
    "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from house.hall import key\n",
])  # fmt: skip
def test_the_check_sees_a_circle_wherever_its_imports_stand(tmp_path: Path, back: str) -> None:
    house = tmp_path / "house"
    house.mkdir()
    (house / "__init__.py").write_text("")
    (house / "door.py").write_text("from house.hall import key\n")
    (house / "hall.py").write_text("from house import stairs\nkey = 1\n")
    (house / "stairs.py").write_text("import os\n")
    assert circles_under(house) == []
    (house / "stairs.py").write_text(back)
    assert circles_under(house) == ["house.hall", "house.stairs"]


def test_spelling_is_compared_only_where_something_is_misspelt() -> None:
    """difflib takes longer to import than a small file to post."""
    modules = sorted(PACKAGE.rglob("*.py"))
    assert modules
    eager = [
        path.relative_to(ROOT).as_posix()
        for path in modules
        if "difflib" in (text := path.read_text(encoding="utf-8"))
        for node in ast.parse(text).body
        if isinstance(node, ast.Import | ast.ImportFrom) and "difflib" in ast.unparse(node)
    ]
    assert eager == []


def test_posting_a_dstv_file_imports_nothing_heavy_and_no_machine_that_is_not_tried() -> None:
    code = (
        "import sys; sys.argv = ['beamcam', 'post', sys.argv[1], '-o', '-']\n"
        "from beamcam.cli import main\n"
        "try:\n    main()\n"
        "except SystemExit as end:\n    assert not end.code, end.code\n"
        f"print([m for m in {(*HEAVY, *NOT_TRIED)} if m in sys.modules], file=sys.stderr)"
    )
    sample = ROOT / "samples" / "dstv" / "channel.nc1"
    run = subprocess.run(
        [sys.executable, "-c", code, str(sample)], capture_output=True, text=True, cwd=ROOT
    )
    assert run.returncode == 0, run.stderr
    assert run.stderr.splitlines()[-1] == "[]"
    assert "M30" in run.stdout


def test_each_pass_of_the_plan_of_a_bar_is_one_call_of_another_room() -> None:
    """As docs/architecture.md lists them; a part does not come back to a room that it left."""
    tree = ast.parse((PACKAGE / "planning" / "beam.py").read_text(encoding="utf-8"))
    room_of = {
        alias.name: node.module.removeprefix("beamcam.planning.")
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("beamcam.planning.")
        for alias in node.names
    }
    (plan_bar,) = (n for n in tree.body if isinstance(n, ast.FunctionDef) and n.name == "plan_bar")
    calls = [node for node in ast.walk(plan_bar) if isinstance(node, ast.Call)]
    passes = [
        room_of[c.func.id] for c in calls if isinstance(c.func, ast.Name) and c.func.id in room_of
    ]
    passes = [one for one, _ in groupby(passes)]
    rooms = set(passes)
    assert len(passes) == len(set(passes))
    assert rooms == {
        "operations.work", "nesting", "axis_limits", "order",
    }  # fmt: skip
    table = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    assert all(f"`planning/{one.replace('.', '/')}.py`" in table for one in rooms)
