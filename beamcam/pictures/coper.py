"""The picture of a program whose torch goes round a profile, or over a tube that turns.

o  [====(2)=======]   grey: the part, where it is known
v  [=(1)====(3)===]   in colours: the path of the torch on each face, a colour for each feed
u  [==============]   numbers: order of the cuts; a tube is one face, unrolled
"""

from collections.abc import Iterator, Sequence

from msgspec.structs import replace

from beamcam.checks.coping.box_tube import box_outlines
from beamcam.checks.coping.lying import lying
from beamcam.checks.coping.program import head_part, head_profile
from beamcam.checks.coping.program import strokes_of as stroke_list
from beamcam.checks.coping.strokes import TorchStroke
from beamcam.checks.coping.tube import tube_section
from beamcam.checks.job import head_of
from beamcam.errors import Source, VerifyError, errors_in
from beamcam.machine.coper import Coper
from beamcam.model.description import face_title, runs_down
from beamcam.model.part import Face, Part
from beamcam.model.rounds import rolled
from beamcam.pictures import SECTION, ReadProgram
from beamcam.pictures.features import feature_shapes
from beamcam.pictures.part import face_of
from beamcam.pictures.scene import TOOL_COLOURS, Labels, Polyline, Scene, Shape, Text, Unit, shown
from beamcam.pictures.views import (
    WIDTH,
    View,
    datum,
    edges_of,
    figures,
    footing,
    head_height,
    heading,
    laid_out,
    legend,
    titles,
    unshown,
)
from beamcam.recovery.box_tube import corner_radius

NUMBER_SIZE = 9.0
#: Of a T, which lies on its side, and of a C, which lies on its lips.
LYING_TITLES: dict[str, dict[Face, str]] = {
    "T": {
        "v": "v   stem, seen from above; y = 0 is at the flange",
        "u": "u   flange, seen from outside; y = 0 is the edge on the rollers",
    },
    "C": {
        "o": "o   flange, u in the file, seen from outside; y = 0 is the edge on the rollers",
        "v": "v   web, h in the file, seen from above; y = 0 is at flange u",
        "u": "u   flange, o in the file, seen from outside; y = 0 is the edge on the rollers",
    },
}


def coper_scene(program: ReadProgram, unit: Unit = "mm") -> Scene:
    """The faces of the part with what the torch cuts on them.

    Raises VerifyError for a program that is not understood, is wrong by itself, or names no section
    of the catalogue while its part is not known.
    """
    part = part_of(program)
    strokes = strokes_of(program, part)
    coper = program.machine.needed(program.machine.coper, "coper")
    is_tube = coper.unrolls(part.profile.code)
    strokes = on_views(strokes, is_tube)
    views = tuple(face_view(part, face, strokes, coper) for face in faces_of(part, is_tube))
    ends = [x for view in views for x in (view.box[0], view.box[2])]
    views = tuple(
        replace(view, box=(min(ends), view.box[1], max(ends), view.box[3])) for view in views
    )
    lines = [
        program.name,
        f"{program.machine.name}, {part.profile.name}, {len(strokes)} cuts",
        f"part: {part.mark or 'without a mark'}, {shown(part.length, unit)} {unit} long",
    ]
    views, bottom = laid_out(views, head_height(lines))
    feeds = list(dict.fromkeys(stroke.row.feed_mm_min for stroke in strokes))
    drawn: list[Shape] = [*heading(lines), *titles(views)]
    for view in views:
        end, high = part.length, max(view.heights[-1], 0.0)
        corners = ((0.0, 0.0), (end, 0.0), (end, high), (0.0, high))
        drawn.append(Polyline("face", view.frame.all(corners), True))
        if is_tube and part.profile.code == "M":
            drawn += _box_tube(program, view)
        else:
            for feature in part.features if program.parts else ():
                if face_of(feature) == view.name:
                    for shape in feature_shapes(feature, view.frame):
                        style = "same-text" if isinstance(shape, Text) else "same"
                        drawn.append(replace(shape, classes=style))
        drawn += datum(view)
        drawn += _cuts(strokes, view, feeds)
        drawn += figures(view, unit)
    y = bottom + 10.0
    rows = [(f"path-{k % len(TOOL_COLOURS)}", f"cut at {feed:g} mm/min")
            for k, feed in enumerate(feeds)]  # fmt: skip
    rows += [("same", "the part as it is asked for")] if program.parts else []
    drawn += legend([*rows, ("datum", "y = 0; arrow: x = 0")], y)
    notes = [f"{program.name}   sha-256 {program.sha256}",
             f"lengths in {unit} from the part's x 0, which is at X {coper.trim:g} of the machine; "
             "they are those of the torch, whose kerf lies half on each side",
             *(row for view in views for row in unshown(view, unit))]  # fmt: skip
    drawn += footing(notes, y + 20.0)
    about = f"program {program.name} as interpreted: {len(strokes)} cuts; sha-256 {program.sha256}"
    return Scene(program.name, about, WIDTH, y + 46.0 + 13.0 * len(notes), tuple(drawn))


def part_of(program: ReadProgram) -> Part:
    """The part as it lies, or one of the section and length that the program's head names."""
    if program.parts:
        return lying(program.parts[0])
    head = head_of(program.text)
    profile = head_profile(head)
    if profile is not None and profile.code == "M":  # whose corners no head has
        radius = corner_radius(program.text, program.machine, profile)
        profile = replace(profile, radius=radius) if radius else None
    if profile is None:
        stock = head.stock if head is not None and head.stock else "none"
        raise VerifyError(
            SECTION.at(Source(program.name), found=stock, machine=program.machine.name)
        )
    return head_part(head, profile, program.name)


def strokes_of(program: ReadProgram, part: Part) -> list[TorchStroke]:
    """What the torch cuts, in its order.

    Raises VerifyError for a program that is not understood, or wrong by itself.
    """
    strokes, diagnostics = stroke_list(program.text, part, program.machine, program.name)
    if errors_in(diagnostics):
        raise VerifyError(diagnostics)
    return strokes


def on_views(strokes: Sequence[TorchStroke], is_tube: bool) -> list[TorchStroke]:
    """Strokes by the view that shows them: a tube has one, whichever face they are on."""
    return [replace(one, face="v") if is_tube else one for one in strokes]


def faces_of(part: Part, is_tube: bool) -> tuple[Face, ...]:
    """The faces that a torch looks at, from the uppermost one; a tube is one."""
    if is_tube:
        return ("v",)
    return ("o", "v", "u") if part.profile.code in ("I", "U", "C") else ("v", "u")


def face_view(part: Part, face: Face, strokes: Sequence[TorchStroke], coper: Coper) -> View:
    """A face from x 0 to the part's end, or as far as it is cut; of a tube all of its surface."""
    points = [place for stroke in strokes if stroke.face == face for place in stroke.points]
    xs, ys = [x for x, _ in points], [y for _, y in points]
    turned = LYING_TITLES.get(part.profile.code)
    high, title = part.profile.face_width(face), face_title(face, part.profile.code)
    if turned is not None:
        title = turned[face]
    box = (min(0.0, *xs, 0.0), min(0.0, *ys, 0.0), max(part.length, *xs, 1.0), max(high, *ys, 0.0))
    ends = {round(end, 1) for s in strokes if s.face == face
            for xs in ([x for x, _ in s.points],) for end in (min(xs), max(xs))}  # fmt: skip
    rises = {round(end, 1) for s in strokes if s.face == face
             for ys in ([y for _, y in s.points],) for end in (min(ys), max(ys))}  # fmt: skip
    view = View(
        face, title, box, tuple(ends | {part.length}), (*(rises - {high}), high),
        runs_down(face), edges=("", "") if turned else edges_of(face, part.profile.code),
    )  # fmt: skip
    if not coper.unrolls(part.profile.code):
        return view
    section = tube_section(rolled(part), coper)
    title = "v   surface of the tube, unrolled, from outside; y = 0 is its lowest line"
    if part.profile.code == "M":
        title = ("u, v, o, h, u   surface of the tube, unrolled, from outside; y = 0 is the middle "
                 "of its lowest face")  # fmt: skip
    left, bottom, right, top = view.box
    lost = part.profile.face_width("v")
    return replace(
        view, title=title, box=(left, bottom, right, max(top, section.turn)),
        heights=(*(y for y in view.heights if y != lost), section.turn), down=False,
        edges=("", ""),
    )  # fmt: skip


def _box_tube(program: ReadProgram, view: View) -> Iterator[Shape]:
    """What stays of a rectangular tube, in grey, and where its faces end."""
    frame, part = view.frame, part_of(program)
    coper = program.machine.needed(program.machine.coper, "coper")
    section = tube_section(part, coper)
    for face in "uvoh":
        for y in (section.radius, part.profile.face_width(face) - section.radius):
            s = section.around(face, y) % section.turn
            yield Polyline("same", frame.all(((0.0, s), (part.length, s))), False)
    if program.parts:
        for ring in box_outlines(part, coper, section):
            yield Polyline("same", frame.all(ring), True)


def _cuts(strokes: Sequence[TorchStroke], view: View, feeds: Sequence[float]) -> Iterator[Shape]:
    """The paths of the torch on a face, and their numbers in the order of the work."""
    labels = Labels()
    for number, stroke in enumerate(strokes, 1):
        if stroke.face != view.name:
            continue
        points = view.frame.all(stroke.points)
        colour = feeds.index(stroke.row.feed_mm_min) % len(TOOL_COLOURS)
        tip = f"{number}: cut on face {stroke.face} at {stroke.row.feed_mm_min:g} mm/min"
        tip += f", tilted to B {stroke.b_deg:g}" if stroke.b_deg and not stroke.leans else ""
        tip += ", A and B off square to the face" if stroke.leans else ""
        yield Polyline(f"path-{colour}", points, False, tip, stroke.line)
        at = labels.place(points[0], 2.0, str(number), NUMBER_SIZE, 3)
        yield Text("number order", at or points[0], str(number), NUMBER_SIZE, line=stroke.line)
