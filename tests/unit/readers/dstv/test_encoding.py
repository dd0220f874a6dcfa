"""The alphabet of old DSTV files is told from their letters, or asked for."""

from pathlib import Path

import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from beamcam.cli import main
from beamcam.readers import read
from beamcam.readers.dstv.blocks import decode, guessed
from tests.runs import part

WORDS = {
    "cp1251": ["Балка", "КОЛОННА", "Ферма-1", "стойка", "Связь", "ригель", "С255"],
    "cp850": ["Träger", "STÜTZE", "Kopfplatte Süd", "poutre latérale", "mitjà", "Øst", "bjælke",
              "viga señal", "Köln", "GRÖSSE"],
    "latin-1": ["Träger", "STÜTZE", "Straße", "pièce d'appui", "señal", "Ø20", "bjælke", "Köln"],
}  # fmt: skip
CASES = [(name, word) for name, words in WORDS.items() for word in words]
#: Single letters that two alphabets have as well as each other; Latin-1 is what they are taken for.
UNDECIDED = {("cp850", "bjælke"), ("cp850", "viga señal"), ("cp1251", "С255")}


@pytest.mark.parametrize(("encoding", "word"), CASES)
def test_a_word_tells_its_alphabet(encoding: str, word: str) -> None:
    found = guessed(word.encode(encoding))
    assert found == ("latin-1" if (encoding, word) in UNDECIDED else encoding)


@given(st.sampled_from(sorted(WORDS)).flatmap(
    lambda name: st.tuples(
        st.just(name),
        st.lists(st.sampled_from([w for w in WORDS[name] if (name, w) not in UNDECIDED]),
                 min_size=1, max_size=4),
    )
))  # fmt: skip
def test_a_file_with_such_words_is_read_as_it_was_written(case: tuple[str, list[str]]) -> None:
    encoding, words = case
    text = part("M1").replace("  TEST\n", f"  {' '.join(words)}\n")
    reading = read(text.encode(encoding), "a.nc1")
    assert reading.parts[0].order == " ".join(words)
    (said,) = (d for d in reading.diagnostics if d.code == "dstv-encoding")
    assert said.source.line == 3
    assert "--encoding names another" in said.message


def test_plain_text_and_unicode_are_not_guessed() -> None:
    assert decode(b"plain") == ("plain", None)
    assert decode("Балка".encode()) == ("Балка", "UTF-8")
    assert decode("Балка".encode("utf-16")) == ("Балка", "UTF-16")


def test_what_is_asked_for_holds(tmp_path: Path) -> None:
    path = tmp_path / "a.nc1"
    path.write_bytes(part("М1").replace("TEST", "å æ").encode("cp866", "replace"))
    call = ["inspect", str(path), "--json", "--encoding"]
    done = CliRunner().invoke(main, [*call, "cp866"])
    assert done.exit_code == 0
    assert '"mark": "М1"' in done.stdout
    assert "dstv-encoding" not in done.stdout
    done = CliRunner().invoke(main, [*call, "utf-8"])
    assert done.exit_code == 1
    assert "found bytes that are no utf-8 text; expected the alphabet" in done.stdout
    for wrong in ("none", "hex"):
        done = CliRunner().invoke(main, [*call, wrong])
        assert done.exit_code == 2
        assert f"found '{wrong}'; expected one such as cp1251, cp850" in done.stderr


def test_a_batch_and_its_check_know_the_encoding(tmp_path: Path) -> None:
    (tmp_path / "in").mkdir()
    (tmp_path / "in" / "a.nc1").write_bytes(part("Балка").encode("cp866"))
    out = tmp_path / "out"
    call = ["batch", str(tmp_path / "in"), "-o", str(out), "--encoding", "cp866"]
    assert CliRunner().invoke(main, [*call, "--name", "{mark}{suffix}"]).exit_code == 0
    assert (out / "Балка.gcode").is_file()
    assert CliRunner().invoke(main, ["check", str(out)]).exit_code == 0
