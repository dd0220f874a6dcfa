"""Members of a model with their marks as texts, if that is asked for."""

from pathlib import Path

from click.testing import CliRunner

from beamcam.cli import main
from beamcam.model.part import TextMark
from beamcam.pipeline import read_file
from beamcam.readers.ifc import Options
from tests.conftest import SAMPLES

MODEL = str(SAMPLES / "ifc" / "beam_openings.ifc")


def test_every_member_gets_its_mark() -> None:
    plain, asked = (read_file(MODEL, options=Options(letter=on)).parts for on in (False, True))
    assert len(plain) == len(asked) >= 1
    for one, other in zip(plain, asked, strict=True):
        (text,) = (f for f in other.features if isinstance(f, TextMark))
        assert other.features[:-1] == one.features
        assert (text.face, text.text, text.height) == ("v", one.mark, 10.0)
        assert 0.0 < text.y < one.profile.height


def test_a_model_is_lettered_from_the_command_line(tmp_path: Path) -> None:
    (first, *_) = read_file(MODEL).parts
    target = tmp_path / "a.gcode"
    words = ["post", MODEL, "--letter", "mark", "--guid", str(first.guid), "-o", str(target)]
    done = CliRunner().invoke(
        main, [*words, "--machine", "beamline-pusher", "--allow-skips", "all"]
    )
    assert done.exit_code == 0, done.output
    assert "M50 K2" in target.read_text()  # the scribe of the web
