"""What blocks of RS274 do to the head of a table besides moving it in X and Y.

    G0 Z25                     up or down by itself; with X or Y only where all of it is clear
    G53 G0 Z0                  the same by the machine's own Z, whose top is known
    G38.2 Z-50 F300, G31       down until the torch touches the sheet
    G92 Z-3, G10 L20 P1 Z0     the place where it stands is called Z; G92.1 takes G92 back
    T1 M6, G43 H0              places are those of a tool beside the torch
    #<holes>=0, o<p> call      what `[codes]` says of such a name
    (o=0, ph=3.1, fr=3000 ..)  the cutting data of a material, by QtPlasmaC's filter

Source: LinuxCNC documentation, "G-Codes" and "QtPlasmaC User Guide"; Mach3 Mill, "G and M codes".
"""

import re
from abc import abstractmethod
from math import isnan, nan

from msgspec.structs import replace

from beamcam.controllers.dialect import HEAD_ACTIONS, MAGIC, Dialect, event_of
from beamcam.controllers.events import Heights, Material, ToolOffset
from beamcam.controllers.interpreter import Interpreter
from beamcam.controllers.rs274.blocks import Block, Variant

_NAME = re.compile(r"\s*(#<[^<>]+>)\s*=(.*)|\s*(o<[^<>]+>)\s*call\b(.*)", re.IGNORECASE)
_HAL_FEED = re.compile(r"#<_hal\[plasmac\.cut-feed-rate\]>", re.IGNORECASE)
_PAIR = re.compile(r"([a-z]{1,2})\s*=\s*([^,()]*)")
#: What QtPlasmaC's comment calls the figures of a row.
MATERIAL_WORDS = {
    "ph": "pierce_height", "pd": "pierce_s", "ch": "cut_height", "fr": "feed_mm_min", "kw": "kerf",
    "ca": "amps", "cv": "volts", "th": "thc",
}  # fmt: skip
_NEEDED = ("ph", "pd", "ch", "fr")


class HeadWords(Interpreter):
    """The words of a table's head; `Rs274` has those of all machines."""

    _variant: Variant
    _material_feed = nan  #: mm/min of the material that the controller has taken
    _offset: str | None = None  #: of the workpiece
    _ready = False  #: whether a move has come

    def __init__(self, dialect: Dialect, name: str) -> None:
        super().__init__(dialect, name)
        self._tools = [0.0, 0.0]  #: of a table's head: the one in it, the one that was prepared
        self._seen: set[str] = set()  #: settings

    def _check_settings(self, line: int) -> None:
        """Says once what is not set when the first move comes."""
        if not self._ready:
            missing = [code for code in self._variant.needed if code not in self._seen]
            if missing:
                self._say(line, self._rules.setting, found=", ".join(missing))
            self._ready = True

    @abstractmethod
    def _travel(self, line: int, block: Block) -> None:
        """The move of a block in X and Y."""

    def _without_names(self, line: int, text: str) -> str:
        """A line without what stands by a name in it, which is carried out."""
        if self._dialect.magic and MAGIC.match(text.strip()):
            self._take_material(line, text)
            return ""
        if "<" not in text:
            return text
        if self._dialect.magic and _HAL_FEED.search(text):
            if isnan(self._material_feed):
                expected = "M190 with the number of a row, or a material in a comment, before it"
                self._wrong(line, "the feed of a material that is not chosen", expected)
            return _HAL_FEED.sub(f"{self._material_feed:.6f}", text)
        match = _NAME.fullmatch(text.partition(";")[0].split("(")[0])
        if match is None or not self._variant.named:
            return text
        name = (match[1] or match[3]).casefold()
        codes = self._dialect.codes
        whole = f"{name}={''.join((match[2] or '').split())}"
        meaning = codes.get(whole) or codes.get(name)
        if meaning is None:
            expected = f'codes."{name}" = "none" in the machine file, if it neither moves nor '
            expected += 'switches, or what it does, such as "touch off"'
            self._wrong(line, f"{name}, which beamcam does not know", expected)
        elif meaning in HEAD_ACTIONS:
            self._act(line, meaning, 0.0)
        elif meaning != "none":
            self._event(replace(event_of(0, meaning, {}, 0.0), line=line))
        return ""

    def _take_material(self, line: int, text: str) -> None:
        """A comment that QtPlasmaC's filter makes a material of."""
        pairs = {key: value.strip() for key, value in _PAIR.findall(text.strip().strip("()"))}
        values: dict[str, float] = {}
        for key, name in MATERIAL_WORDS.items():
            try:
                if key in pairs:
                    values[name] = float(pairs[key])
            except ValueError:
                self._wrong(line, f"{key}={pairs[key]} of a material", "a number")
        missing = [key for key in _NEEDED if key not in pairs]
        if missing or pairs.get("o") not in ("0", "1", "2"):
            expected = "o=0, ph, pd, ch and fr, which the controller's filter needs"
            self._wrong(line, f"a material without {', '.join(missing) or 'o=0'}", expected)
        self._material_feed = values.get("feed_mm_min", nan)
        self._event(Material(line, values))

    def _act(self, line: int, action: str, value: float) -> None:
        """An action of a block before its move."""
        heights = self._heights
        if action == "tool":
            self._tools[1] = value
        elif action == "offset":
            self._offset_tool(line, int(value or self._tools[0]))
        elif action == "offset off":
            self._offset_tool(line, 0)
        elif action == "system":
            if value and self._offset not in (None, "G54"):
                self._wrong(line, f"G10 of G54 while {self._offset} holds", "P0, what holds")
        elif heights is None:
            expected = 'torch.z = "program" in the machine file'
            self._wrong(line, f"a word for {action!r} where the controller moves Z", expected)
        elif action == "height":
            self._event(heights.to(line, False, value, nan))
        elif action == "touch off":
            for event in heights.touch_off(line):
                self._event(event)
        elif action == "take back":
            self._event(heights.take_back(line))
        else:
            self._event(heights.count_from(line, value, action == "zero"))

    def _offset_tool(self, line: int, number: int) -> None:
        """Places are those of a tool, which stands elsewhere than the one before."""
        if self._dialect.shares:
            self._event(ToolOffset(line, number))
            self._place = (nan, nan, self._place[2])

    def _move_z(self, line: int, block: Block, heights: Heights | None) -> None:
        """A block with Z: a move up or down, or until the torch touches."""
        values = dict(block.values)
        z = values.pop("Z", nan)
        motion = self._motion if block.motion is None else block.motion
        feed = self._feed * self.per_minute
        if heights is None:
            return
        if block.probe:
            self._motion = -1
            if isnan(z) or values:
                self._wrong(line, "a touch in X, Y or nothing", "one in Z")
            self._event(heights.touch(line, feed))
            return
        if motion not in (0, 1):
            self._wrong(line, "Z without a straight motion", "G0 or G1 before")
            return
        self._check_settings(line)
        was_clear, self._motion = heights.is_clear, motion
        if "G53" in block.settings:
            lift = heights.to_machine_z(line, motion == 0, z, feed)
        else:
            lift = heights.lift(line, motion == 0, z, self._absolute, feed)
        in_plane = values.keys() & set("XY")
        if in_plane and not (motion == 0 and was_clear and heights.is_clear):
            expected = "Z by itself, or a traverse that is clear of the sheet from end to end"
            self._wrong(line, "X or Y together with Z", expected)
            return
        self._event(lift)
        if in_plane:
            self._travel(line, Block(motion=motion, values=values))
        elif values:
            self._wrong(line, f"the letter {min(values)} in that block", "no such word there")
