"""A machine's words, tried on its controller before any program is made of them.

The templates of a machine file, with figures in their braces, are put together to one program,
which the controller's interpreter reads as it reads any other. What it would not take is a fault of
the file. So is what the templates of a saw and drilling line never do: choose the spindle, feed,
draw the tool back, switch off what they switched on.
"""

from collections.abc import Iterator

from msgspec.structs import replace

from beamcam.caches import PerObject
from beamcam.controllers import cell_events, interpreter_of
from beamcam.controllers.dialect import (
    DOCUMENTED,
    FIELD,
    IDLE_SWITCHES,
    SETTING,
    SHEET_SETTING,
    STOPS,
    TELLS,
    Dialect,
    dialect_of,
    role_of,
    tool_words,
)
from beamcam.controllers.events import BarEvent, Lettering, Move, Switch
from beamcam.machine.faults import words_of
from beamcam.machine.machine import Machine, key_for, plain_code
from beamcam.machine.tables import DIALECTS, TABLE_CONTROLLERS
from beamcam.model.description import PART_DATA

#: Of the tools of a bar; `scribe` and `punch` do not turn.
_TOOLS = ("drill", "tap", "countersink", "mill", "punch", "scribe")
#: What stands in the braces: a stroke from 11 or 12 to 33 or 44, figures that fit any other word.
_STROKE = {
    "y": "11", "z": "12", "near_y": "21", "near_z": "22", "bottom_y": "33", "bottom_z": "44",
}  # fmt: skip
#: The other way round, where Z grows out of the steel, as RS274 has it for its cycles.
_STROKE_DOWN = {
    "y": "44", "z": "43", "near_y": "33", "near_z": "32", "bottom_y": "12", "bottom_z": "11",
}  # fmt: skip
_FIGURES = {
    **PART_DATA, "job": "JOB", "text": "TEXT", "tool": "1",
    "section": "1", "width": "100", "height": "200", "spindle": "1",
    "station": "1", "diameter": "20", "pitch": "2", "angle": "30", "tilt": "0", "feed": "600",
    "speed": "300", "peck": "5", "power": "1", "pierce": "0.5", "kerf": "1.5", "half_kerf": "0.75",
    "pierce_height": "4", "cut_height": "2", "preheat": "5", "amps": "45", "volts": "120",
    "share": "60", "number": "1", "clearance": "20", "touch_height": "-1",
    "material_name": "mild steel", "thickness": "6", "nozzle": "45 A",
    "acceleration": "100", "ratio": "0.5", "string": "A1", "face": "1",
    "tool_name": "drill 20",
}  # fmt: skip
#: Where curves that begin at 0, 0 end, and what I and J are, from there as from the start.
_CURVES = {
    "arc_cw": ("10", "0", "5", "0"), "arc_ccw": ("10", "0", "5", "0"),
    "parabola": ("10", "0", "5", "5"),
    "ellipse_cw": ("20", "0", "10", "0"), "ellipse_ccw": ("20", "0", "10", "0"),
}  # fmt: skip

TEXT_X = 300.0  #: machine X of the text that is tried

Line = tuple[str, str, str]  #: key of the template, its text, the block that it becomes
WordFault = tuple[str, str, str]  #: key, text of its line, what is wrong with it


def word_faults(machine: Machine) -> tuple[WordFault, ...]:
    """The first thing that is wrong with each template of a machine."""
    if machine.controller in DIALECTS:
        from beamcam.controllers.simotion.trial import trial

        return tuple(("triggers", "", one.message) for one in trial(machine)[:1])
    if machine.controller in TABLE_CONTROLLERS:
        return ()
    if machine.startup_code:
        own = replace(machine, startup_code="")
        _, diagnostics = cell_events(f"{machine.startup_code}\nM2", own, "")
        if diagnostics:
            return (("startup_code", machine.startup_code, diagnostics[0].message),)
    if unknown := tuple(_allowed_faults(machine)):
        return unknown[:1]
    if machine.torch is not None:  # in laser mode a word by itself switches nothing
        machine = replace(machine, torch=replace(machine.torch, laser_mode=False))
    faults = {"beam": _bar_faults, "sheet": _table_faults, "profile": _coper_faults}
    first = {fault[0]: fault for fault in reversed([*faults[machine.stock](machine)])}
    return tuple(first[key] for key in sorted(first))


def _allowed_faults(machine: Machine) -> Iterator[WordFault]:
    """Each word of `allowed_codes` that nothing gives a meaning."""
    interpreter, own = interpreter_of(machine, ""), dialect_of(machine)
    telling = own.text_word.codes if own.text_word else ()
    for text in machine.allowed_codes:
        code = plain_code(text) or text
        known = code in telling or code in own.codes
        if code[0] == "G" and code not in telling and not interpreter.knows(code):
            expected = "a word of the controller's, or one of [codes]"
        elif code[0] == "M" and not known and int(code[1:]) not in {*DOCUMENTED, *own.m_words}:
            expected = "a word of a template, or one of [codes]"
        else:
            continue
        yield fault_in("allowed_codes", text, text, expected)


known_faults = PerObject("machine.words", word_faults)


def _filled(machine: Machine, key: str, **more: str) -> Iterator[Line]:
    template = getattr(machine.words, key)
    values = {**_FIGURES, **more}
    for text in (template,) if isinstance(template, str) else template:
        # A footer has no placeholders, and is written unchanged.
        filled = text if key == "footer" else text.format_map(values)
        for block in filled.split("\n"):
            yield f"words.{key}", text, block


# --- saw and drilling lines -----------------------------------------------------------------------


def _bar_faults(machine: Machine) -> Iterator[WordFault]:
    stroke = _STROKE_DOWN if machine.controller == "linuxcnc" else _STROKE
    unit = machine.marks.unit if machine.marks.is_told else ""
    lines = list(_bar_lines(machine, unit, stroke))
    dialect = dialect_of(machine)
    events, faults = _run(lines, machine)
    yield from faults
    yield from _double_words(lines)
    if faults:
        return
    of: dict[str, list[BarEvent]] = {}
    for event in events:
        of.setdefault(lines[event.line - 1][0].removeprefix("words."), []).append(event)
    for tool in _TOOLS:
        if getattr(machine.words, tool):
            own = [event for key in words_of(tool) for event in of.get(key, [])]
            first, last = words_of(tool)[0], words_of(tool)[-1]
            stands = tool in ("punch", "scribe")
            for key, tool_faults in zip(
                (first, last), _tool_faults(own, dialect, stands, stroke), strict=True
            ):
                for found, expected in tool_faults:
                    yield fault_in(f"words.{key}", "", found, expected)
    if machine.saw is not None and not _with_role(of.get("saw", []), dialect, "saw"):
        yield fault_in("words.saw", "", "no cut", "an M word with {angle}")
    if unit:
        texts = [event for event in of.get(unit, []) if isinstance(event, Lettering)]
        moves = [event for event in of.get(unit, []) if isinstance(event, Move)]
        if not texts:
            expected = "a line with {string} that is one by itself"
            yield fault_in(f"words.{unit}", "", "no text", expected)
        elif not moves or moves[-1].line > texts[0].line or moves[-1].end[0] != TEXT_X:
            expected = "a move to X{x} before {string}"
            yield fault_in(f"words.{unit}", "", "a text elsewhere", expected)
    for name in (*_TOOLS, "saw") if dialect.feeds else ():
        keys = words_of(name)
        feeds = [e for key in keys for e in of.get(key, []) if isinstance(e, Move) and not e.rapid]
        if feeds and not any("F" in line for key in keys for line in getattr(machine.words, key)):
            expected = "F{feed}, as other templates have"
            yield fault_in(f"words.{name}", "", "a feed without an F word", expected)


def _bar_lines(machine: Machine, unit: str, stroke: dict[str, str]) -> Iterator[Line]:
    """The blocks of all templates, as a program of each kind of work has them."""
    yield from (*_filled(machine, "header"), *_filled(machine, "comment"))
    for tool in _TOOLS:
        for key in words_of(tool):
            yield from _filled(machine, key, x="100", **stroke)
    if unit:
        number = str(next(iter(machine.marks.faces.values())))
        yield from _filled(machine, unit, x=f"{TEXT_X:g}", y="20", face=number)
    yield from _filled(machine, "change")
    if machine.saw is not None:
        yield from _filled(machine, "saw", x="200")
    yield from _filled(machine, "footer")


def _double_words(lines: list[Line]) -> Iterator[WordFault]:
    """Each M word that is to mean two things."""
    roles: dict[int, str] = dict(DOCUMENTED)
    for key, text, _ in lines:
        if TELLS in text:
            continue
        number, role = role_of(text, key == "words.change")
        carried = [field for _, field in FIELD.findall(text)]
        meaning = f"section ({', '.join(carried)})" if role == "section" else role
        if number is not None and roles.setdefault(number, meaning) != meaning:
            expected = f"another word, as that one stands for {roles[number]} already"
            yield fault_in(key, text, f"M{number:02} for {meaning}", expected)


def _with_role(events: list[BarEvent], dialect: Dialect, role: str) -> list[Switch]:
    return [e for e in events if isinstance(e, Switch) and _role(e, dialect) == role]


def _role(event: Switch, dialect: Dialect) -> str:
    word = dialect.m_words.get(event.number)
    return word.role if word else DOCUMENTED.get(event.number, "other")


def _tool_faults(
    events: list[BarEvent], dialect: Dialect, stands: bool, stroke: dict[str, str]
) -> tuple[list[tuple[str, str]], list[tuple[str, str]]]:
    """What the blocks of one tool leave out before they feed, or altogether; and the states that
    they must not leave behind."""
    bottom = {float(stroke["bottom_y"]), float(stroke["bottom_z"])}
    deep = turns = fed = cools = False
    begin, end = [], []
    for event in events:
        if isinstance(event, Switch):
            role = _role(event, dialect)
            if role == "off" and deep:
                end.append(("the spindle stopped in the steel", "a move to {y} and {z} before M05"))
            turns = role == "on" or (turns and role != "off")
            cools = role == "coolant-on" or (cools and role != "coolant-off")
        elif isinstance(event, Move):
            deep = not bottom.isdisjoint(event.end[1:])
            fed = fed or (deep and not event.rapid)
            if deep and not event.rapid and not (turns or stands):
                begin.append(("a feed with the spindle at rest", "M03 or M04 before it"))
    chosen = [dialect.m_words[e.number] for e in _with_role(events, dialect, "choose")]
    expected = "an M word with {spindle}, or {tool} of the only spindle"
    if chosen:
        expected = "an M word with {spindle}, as there are several"
    says = any(field == "spindle" for word in chosen for _, field in word.fields)
    if not chosen or (dialect.only_spindle is None and not says):
        begin.append(("no choice of a spindle", expected))
    if not fed:
        begin.append(("no feed into the steel", "G01 with {bottom_y} and {bottom_z}"))
    for is_left, found, expected in (
        (deep, "the tool left in the steel", "a move to {y} and {z} at the end"),
        (turns, "the spindle left turning", "M05 at the end"),
        (cools, "the coolant left on", "M09 at the end"),
    ):
        if is_left:
            end.append((found, expected))
    return begin, end


# --- cutting tables -------------------------------------------------------------------------------


def _table_faults(machine: Machine) -> Iterator[WordFault]:
    words = machine.words
    start = [*_filled(machine, "traverse", x="0", y="0")]
    feed = [*_filled(machine, "feed", x="10", y="0")]
    lines = [*_filled(machine, "header"), *_filled(machine, "comment"), *start]
    lines += _filled(machine, "material")
    for process in ("cut", "mark", "engrave", "spot"):
        if getattr(words, f"{process}_on"):
            lines += (*_filled(machine, f"choose_{process}"), *start)
            lines += (*_filled(machine, f"{process}_on"), *feed)
            lines += _filled(machine, f"{process}_off")
    for key, (x, y, i, j) in _CURVES.items():
        if getattr(words, key):
            lines += (*start, *_filled(machine, key, x=x, y=y, i=i, j=j, angle="0"))
    for key in ("slow", "full", "close"):
        lines += _filled(machine, key)
    if words.modal:
        block = " ".join([feed[-1][2], *(block for _, _, block in _filled(machine, "modal"))])
        lines.append(("words.modal", "", block))
    for side in ("left", "right"):
        if getattr(words, side):
            lines += (*_filled(machine, side), *feed, *_filled(machine, "straight"))
    lines += _filled(machine, "footer")
    events, faults = _run(lines, machine)
    yield from faults
    yield from _unexplained(lines, events)
    yield from _still_faults(lines, events)
    torch = machine.needed(machine.torch, "torch")
    low_x, low_y = torch.area[:2]
    for event in events:
        key, text, _ = lines[event.line - 1]
        at_x, at_y = event.end[:2] if isinstance(event, Move) else (low_x, low_y)
        if not (low_x <= at_x <= torch.length and low_y <= at_y <= torch.width):
            expected = f"one within the table of {torch.length:g} x {torch.width:g} mm"
            yield fault_in(key, text, f"a move to X {at_x:g}, Y {at_y:g}", expected)


def _unexplained(lines: list[Line], events: list[BarEvent]) -> Iterator[WordFault]:
    """Each M word beside the one that switches a tool of which nothing says what it does."""
    of: dict[str, list[Switch]] = {}
    for event in events:
        if isinstance(event, Switch) and event.number not in (2, 30):
            of.setdefault(lines[event.line - 1][0].removeprefix("words."), []).append(event)
    for name, switches in of.items():
        known = {*DOCUMENTED, *STOPS, *IDLE_SWITCHES}
        switching = name.endswith(("_on", "_off"))
        tool = tool_words(switches, name.endswith("_on"))[:1] if switching else []
        for switch in switches:
            if switch.does or switch.number in known or switch in tool:
                continue
            key, text, _ = lines[switch.line - 1]
            own = key_for(f"M{switch.number}", switch.words)
            expected = f'codes.{own} = "none", or what it does, such as "thc on"'
            yield fault_in(key, text, f"{switch}, which beamcam does not know", expected)


# --- copers ---------------------------------------------------------------------------------------

_MEASURED = {"measured_height": 201.0, "measured_width": 101.0}  #: templates, and what they carry


def _coper_faults(machine: Machine) -> Iterator[WordFault]:
    coper = machine.needed(machine.coper, "coper")
    lines = [*_filled(machine, "header"), *_filled(machine, "comment")]
    for name in _MEASURED:
        lines += _filled(machine, name, height="201", width="101")
    lines += _filled(machine, "turn", x="0", y="0", z="50", a="-90", b="10")
    lines += (*_filled(machine, "traverse", x="10", y="20", z="30"), *_filled(machine, "cut_on"))
    lines += _filled(machine, "feed", x="11", y="21", z="31", a="-90", inverse="100")
    lines += (*_filled(machine, "cut_off"), *_filled(machine, "footer"))
    events, faults = _run(lines, machine)
    yield from faults
    yield from _still_faults(lines, events)
    for name, figure in _MEASURED.items():
        own = [e for e in events if lines[e.line - 1][0] == f"words.{name}"]
        carried = [v for e in own if isinstance(e, Switch) for v in e.words.values()]
        if (template := getattr(machine.words, name)) and figure not in carried:
            found = "no M word with the figure"
            yield fault_in(f"words.{name}", template[0], found, "one of M100 to M199")
    for event in events:
        if isinstance(event, Move):
            key, text, _ = lines[event.line - 1]
            place, a_deg = event.end, event.a_deg[1]
            if key == "words.turn" and a_deg != -90.0:
                yield fault_in(key, text, f"A at {a_deg:g}", "a move to {a}")
            if key == "words.turn" and coper.tilt and event.b_deg[1] != 10.0:
                yield fault_in(key, text, f"B at {event.b_deg[1]:g}", "a move to {b}")
            for name, feeds in (("traverse", (10.0, 20.0, 30.0)), ("feed", (11.0, 21.0, 31.0))):
                if coper.y == "fixed":
                    place, feeds = (place[0], 0.0, place[2]), (feeds[0], 0.0, feeds[2])
                if key == f"words.{name}" and place != feeds:
                    expected = "a move to {x}, {y} and {z}" if coper.y == "follows" else (
                        "a move to {x} and {z}")  # fmt: skip
                    yield fault_in(key, text, "another place", expected)


def _still_faults(lines: list[Line], events: list[BarEvent]) -> Iterator[WordFault]:
    """Each template of a move or a switch that does not make that move or switch."""
    moving = {lines[event.line - 1][0] for event in events if isinstance(event, Move)}
    switching = {lines[event.line - 1][0] for event in events if isinstance(event, Switch)}
    for key in dict.fromkeys(key for key, _, _ in lines):
        name = key.removeprefix("words.")
        if name in ("traverse", "turn", "feed", *_CURVES) and key not in moving:
            yield fault_in(key, "", "no move", "one to {x} and {y}")
        if name.endswith(("_on", "_off")) and key not in switching:
            expected = f"one that switches the tool {name.rpartition('_')[2]}"
            yield fault_in(key, "", "no M word", expected)
    for event in events:
        if isinstance(event, Move):
            key, text, _ = lines[event.line - 1]
            name = key.removeprefix("words.")
            if name in ("feed", *_CURVES) and event.rapid:
                yield fault_in(key, text, "a traverse", "a move at the feed, such as G1")
            if name.endswith(("_on", "_off")):
                x, y = event.end[:2]
                found = f"a move to X {x:g}, Y {y:g}"
                yield fault_in(key, text, found, "the tool switched where it stands")


def _run(lines: list[Line], machine: Machine) -> tuple[list[BarEvent], list[WordFault]]:
    """The events of a program, and what is wrong with it as faults of its templates.

    What has to be set before the first move belongs into the header.
    """
    program = "\n".join(block for _, _, block in lines) + "\n"
    events, diagnostics = cell_events(program, machine, "")
    faults: list[WordFault] = []
    for one in diagnostics:
        key, text, _ = lines[min(one.source.line or len(lines), len(lines)) - 1]
        if one.code in (SETTING.code, SHEET_SETTING.code):
            key, text = "words.header", ""
        faults.append((key, text, one.message))
    return events, faults


def fault_in(key: str, text: str, found: str, expected: str) -> WordFault:
    """A fault of a template, said as the read-back says those that it finds."""
    return key, text, f"found {found}; expected {expected}"
