"""The pictures of the documentation are those that the samples give now."""

import importlib.util
from pathlib import Path
from xml.etree import ElementTree

import pytest

from tests.conftest import ROOT, Golden

FOLDER = ROOT / "docs" / "pictures"
SPEC = importlib.util.spec_from_file_location("draw", FOLDER / "draw.py")
assert SPEC is not None
assert SPEC.loader is not None
DRAW = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(DRAW)


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pictures")
    DRAW.draw(folder)
    return folder


@pytest.mark.parametrize("name", DRAW.PICTURES)
def test_a_picture_is_as_the_samples_give_it(name: str, drawn: Path, golden: Golden) -> None:
    text = (drawn / name).read_text(encoding="utf-8")
    assert ElementTree.fromstring(text).tag.endswith("svg")
    assert str(ROOT) not in text
    golden.check(FOLDER / name, text)


def test_each_picture_stands_in_the_readme_or_a_page() -> None:
    pages = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
    text = "".join(page.read_text(encoding="utf-8") for page in pages)
    assert {p.name for p in FOLDER.glob("*.svg")} >= set(DRAW.PICTURES)
    assert all(f"pictures/{name})" in text for name in DRAW.PICTURES)
