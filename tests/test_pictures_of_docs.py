"""The pictures of the documentation are those that the samples give now."""

import importlib.util
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

from tests.conftest import ROOT, Golden

FOLDER = ROOT / "docs" / "pictures"
_HASH = re.compile(r"sha-256 [0-9a-f]{64}")
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


@pytest.mark.parametrize("name", [*DRAW.PICTURES, DRAW.FACES])
def test_a_picture_is_as_the_samples_give_it(name: str, drawn: Path, golden: Golden) -> None:
    text = (drawn / name).read_text(encoding="utf-8")
    assert ElementTree.fromstring(text).tag.endswith("svg")
    assert str(ROOT) not in text
    # A program's head has the checksum of its machine's file: another hash, the same picture.
    if golden.update or _HASH.sub("", text) != _HASH.sub("", _kept(name)):
        golden.check(FOLDER / name, text)


def _kept(name: str) -> str:
    path = FOLDER / name
    return path.read_text(encoding="utf-8") if path.exists() else ""


def test_each_picture_stands_in_the_readme_or_a_page() -> None:
    pages = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
    text = "".join(page.read_text(encoding="utf-8") for page in pages)
    assert {p.name for p in FOLDER.glob("*.svg")} >= {*DRAW.PICTURES, DRAW.FACES}
    assert all(f"pictures/{name})" in text for name in (*DRAW.PICTURES, DRAW.FACES))
