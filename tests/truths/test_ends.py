"""Signs of the four angles at the ends of a part, by outlines that are drawn beside them.

DSTV: angle = atan2(x of the lowest y - x of the highest y, height), at either end; of the web in
the view of v, of the flange in the view of u.
"""

import re
from math import atan2, degrees

import pytest

from beamcam import readers
from beamcam.machine import load
from beamcam.pipeline import post
from tests.beam_cell import Section, end_x
from tests.conftest import SAMPLES

I160 = Section("I", 160.0, 82.0, 7.4, 5.0, 9.0)
U200 = Section("U", 200.0, 75.0, 11.5, 8.5, 11.5)


def test_the_outlines_of_the_samples_have_the_angles_of_their_headers() -> None:
    """strut.nc1: 30 and -30, its AK from 92.38 to 1707.62 at y 0 and from 0 to 1800 at y 160."""
    assert degrees(atan2(92.38 - 0.0, 160.0)) == pytest.approx(30, abs=0.002)
    assert degrees(atan2(1707.62 - 1800.0, 160.0)) == pytest.approx(-30, abs=0.002)
    text = (SAMPLES / "dstv" / "strut.nc1").read_text()
    (part,) = readers.read(text.encode(), "strut.nc1").parts
    assert (part.cuts.web_start, part.cuts.web_end) == (30.0, -30.0)
    # Ours, which the tests of bars go by, at both edges of both ends.
    found = [end_x(I160, 1800.0, a, 0.0, last, y, 0.0) for a, last in ((30.0, False), (-30.0, True))
             for y in (0.0, 160.0)]  # fmt: skip
    assert found == pytest.approx([92.376, 0, 1707.624, 1800], abs=0.001)
    # channel.nc1: 15 at the start, from 53.59 at y 0 and 0 at y 200.
    assert end_x(U200, 3000.0, 15.0, 0.0, False, 0.0, 0.0) == pytest.approx(53.59, abs=0.001)


HEAD = """ST
  1
  1
  1
  P
  S235JR
  1
  IPE300
  I
  2000.00
  300.00
  150.00
  10.70
  7.10
  15.00
  42.2
  1.0
  {:.3f}
  {:.3f}
  {:.3f}
  {:.3f}




EN
"""


def cuts(machine: str, *angles: float) -> list[tuple[float, ...]]:
    """X and the angles of each cut of an IPE300 of 2000 mm."""
    parts = readers.read(HEAD.format(*angles).encode(), "p.nc1").parts
    text = post(parts, load(machine)).text
    found = re.findall(r"G00 X(\S+)\nN\d+ M42 K(\S+) (?:L(\S+) )?F", text)
    return [tuple(float(v) for v in row if v) for row in found]


def test_mitres_on_the_beamline() -> None:
    """The bar begins at 20, X counts on the edge of o, the blade takes 4.04 across itself.

    15 at the start: the top edge is the longest, at 20; half a kerf along x is 2.02 / cos 15 =
    2.091, so X 17.909. 15 at the end: the bottom edge ends at 2020, the top one 300 tan 15 = 80.385
    before; X 2020 - 80.385 + 2.091 = 1941.707. -15 at the start: the bottom edge is at 20 and the
    top one at 100.385. -15 at the end: the top edge ends at 2020.
    """
    assert cuts("beamline", 15, 15, 0, 0)[:2] == [
        pytest.approx((17.909, 15), abs=0.001), pytest.approx((1941.707, 15), abs=0.001),
    ]  # fmt: skip
    assert cuts("beamline", -15, -15, 0, 0)[:2] == [
        pytest.approx((98.293, -15), abs=0.001), pytest.approx((2022.091, -15), abs=0.001),
    ]  # fmt: skip


def test_mitres_and_tilts_of_the_pusher() -> None:
    """The bar begins at 15, cuts at 1250; X counts on the edge of u, square is 90, the kerf 1.6.

    15 at the start: the top edge is at 15, the bottom one at 15 + 80.385; less 0.8 / cos 15 =
    0.828: X 1344.557. 15 at the end: the bottom edge at 2015; X 3265.828.
    Flanges of 22.5: the edge at z 0, where X counts, is 150 tan 22.5 = 62.132 behind at the start,
    and the last at the end; half the kerf is 0.8 / cos 22.5 = 0.866.
    """
    assert cuts("beamline-pusher", 15, 15, 0, 0)[:2] == [
        pytest.approx((1344.557, 105, 0), abs=0.001),
        pytest.approx((3265.828, 105, 0), abs=0.001),
    ]
    assert cuts("beamline-pusher", 0, 0, 22.5, 22.5)[:2] == [
        pytest.approx((1326.266, 90, 22.5), abs=0.001),
        pytest.approx((3265.866, 90, 22.5), abs=0.001),
    ]
