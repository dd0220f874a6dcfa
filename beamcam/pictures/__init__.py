"""Pictures of parts, programs and profiles.

part (model)                         -> scene -> SVG, PDF (reportlab) or PNG (Pillow)
machined features (verify), trace (simulate)

A scene is data: lines, circles and texts on paper, each of a named style. A picture of a program is
drawn from what the read-back's interpreter found in its text, and carries the hash of that text.
"""

from hashlib import sha256

from msgspec import Struct

from beamcam.errors import error
from beamcam.machine.machine import Machine
from beamcam.model.part import Part

# fmt: off

NEEDS = error("picture-needs",
    "found {found}; expected it for {what}: pip install beamcam[pictures]",
    "The library that writes the format is not installed; SVG and HTML need none.")

SECTION = error("picture-section",
    "found the section {found} in the program's head; expected one of the catalogue, or the part: "
    "plot PART --show program --machine {machine}",
    "Where the torch is over the steel depends on the section, which a program does not say.")

# fmt: on


class ReadProgram(Struct, frozen=True):
    """A program as bytes, and what is known of the job besides."""

    data: bytes
    machine: Machine
    name: str
    style: str = ""  #: suffix of a step table
    parts: tuple[Part, ...] = ()  #: in their order along the bar, as far as they are known
    bar: float | None = None  #: its length

    @property
    def text(self) -> str:
        """The program; bytes that are not text become U+FFFD."""
        return self.data.decode("utf-8", "replace")

    @property
    def sha256(self) -> str:
        """Of the bytes, in hexadecimal digits."""
        return sha256(self.data).hexdigest()

    @property
    def marks(self) -> tuple[str, ...]:
        """Names of the parts."""
        return tuple(part.mark or f"part {k}" for k, part in enumerate(self.parts, 1))
