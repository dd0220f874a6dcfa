"""Rules for what a torch that goes round a profile cannot make."""

from beamcam.errors import error, note, warning

# fmt: off


ALONE = error("plan-coping-alone",
    "found {found} parts for one program; expected one, {machine} copes a bar for each part",
    "Post them one by one, with `batch` or with --quantity file.")
CROSSED = error("plan-coping-crossed",
    "found skew ends that cross on face {face}; expected some of the wall between them",
    "Lengths of a header go from the outermost corner of one end to that of the other.")
BEYOND = error("plan-coping-beyond",
    "found an outline on face {face} that goes on {found} mm beyond the skew end of the header; "
    "expected it within",
    "Header and outline describe different ends, and only one can be right.")
ROOT = error("plan-coping-root",
    "found {what} at x {x} on face {face}; expected {expected}",
    "Over the web the torch comes no nearer to a flange than its width and the root fillet allow. "
    "The rest of a cut is made from outside of the flange, which takes web and flange at one x, as "
    "deep as its row of the cut chart: with a row between (`coper.rows`, `between_rows`) a cope "
    "may come nearer. What would be cut otherwise there has to be made by hand.")
FLANGE_ALONE = error("plan-coping-flange-alone",
    "found no outline on face {face}, so that its flange is {found:g} mm long, and a web that is "
    "cut away from it along all of that; expected an outline on face {face}, or a web up to y "
    "{expected:g}",
    "A wall without an outline is as long as the part. Some exporters leave out the outline of a "
    "flange that is cut away: it has to be drawn, or the section to be a T, or the header's height "
    "that of what stays.")
LEDGE = warning("plan-coping-ledge",
    "found a hole of the web at x {x} right under face {face}; it is cut up to {found} mm off the "
    "flange",
    "Over the web the torch comes no nearer to a flange than its width and the root fillet allow. "
    "The steel that stays along the flange has to be taken by hand.")
STEP = warning("plan-coping-step",
    "found a cut that is slanted or round at the root of face {face}, at x {x}; web and flange are "
    "cut square there, up to {found} mm too long",
    "The root is cut from outside of the flange, square to the bar, and the corner of a cope ends "
    "in it. What is too much has to be ground off; no steel is missing.")
K_AREA = error("plan-coping-k-area",
    'found a cut through the root at x {x} on face {face}; expected none, coper.k_area is "refuse"',
    'With k_area = "pass" in the machine file the root is cut from outside of the flange, by a row '
    "of the cut chart that is deep enough.")
NARROW = error("plan-coping-narrow",
    "found {what} at x {x}, y {y} on face {face}; expected {expected}",
    "The torch needs room in the scrap to pierce and to turn. A sharp corner is rounded as far as "
    "there is room, with a kerf at least: half of it remains for the torch's own way.")
OFF = error("plan-coping-off",
    "found {what}, where nothing is left of the part; expected it in steel that stays",
    "A hole in scrap is a mistake in the drawing.")
SHORT = error("plan-coping-short",
    "found an outline on face {face} that goes on {found} mm beyond the end of the piece; expected "
    "it within the piece, which comes cut",
    "What the machine before has cut off cannot be made again. The ends of a piece stand in the "
    "header of its file.")
TUBE_END = error("plan-coping-tube-end",
    "found {what} of a tube that comes cut; expected cuts that go from its end into the steel",
    "Beside an end that is there an arc has steel on one side only, and goes out. An end that is "
    "new all round is cut from a bar, with all of the part.")
OPEN = warning("plan-coping-open",
    "found a hole that is there across a cut at x {x}, y {y} on face {face}; the torch goes over "
    "it with its arc on",
    "A hole that is drilled into the corner of a cope before makes it round, but an arc may go out "
    "over it, and what lies behind it is not cut then. Stay beside the machine, or have the hole "
    "smaller than the arc bridges.")
ORIGIN = error("plan-coping-origin",
    "found a cut at x {x} on face {face}, before the bar, which begins {trim} mm before x 0; "
    "expected the part from x 0 on",
    "DSTV counts x from the leading end of the part. The outlines of such a file begin before it: "
    "their x is wrong, or the bar is longer before it (coper.trim).")
SUPPORT = error("plan-coping-support",
    "found a cut at X {x} on face {face}, over the support from X {least} to {most}; expected none "
    "there",
    "What holds the bar would be cut. coper.trim shifts the part along the bar.")
CHUCK = error("plan-coping-chuck",
    "found a cut at x {x} on face {face} of a piece that comes cut; expected none beyond x "
    "{expected}, as the chuck holds the last {chuck} mm",
    "A piece is held by its own far end, half the torch's width included. What is there goes to a "
    "coper whose torch turns, or all of the part is cut from a bar, which is longer by the chuck.")
DEEP = error("plan-coping-deep",
    "found the web {found} mm below the edges of the flanges; expected at most {expected} mm",
    "The torch is slim only from its tip to its holder (`coper.torch_length`).")
THICK = error("plan-coping-thick",
    "found {found} mm of {material} to cut on face {face}; expected {expected}",
    "No row of the cut chart (`coper.rows`) is that deep, or for steel of that grade. Through a "
    "root the flange, the root and `coper.root_over` count together.")
ROUNDED = note("plan-coping-rounded",
    "found {count} sharp re-entrant corner(s) on face {face}, cut with a radius of {radius} mm",
    "A notch that ends in a sharp corner cracks there. `coper.corner_radius` says how round it is "
    "cut, or in a slot that is narrower than two radii half its width; the steel in the corner "
    "stays.")
BAR = note("plan-coping-bar",
    "the part is cut from a bar of at least {found} mm, its x 0 at {trim} mm from the leading end",
    "Leads and pierces of both ends lie in the scrap before and behind the part.")
TEE = note("plan-coping-tee",
    "the T lies on its side: its flange upright, face h outwards, its stem across, face u up; here "
    "and in the program face u is the flange and v the stem",
    "So the torch comes to the outside of the flange, from where the root is cut. The program's "
    "first comment says it to the operator.")
LIPS = note("plan-coping-lips",
    "the C lies on its lips, face h up, face o {at}; here and in the program face v is its web "
    "from outside, u what the file has on o, and o what it has on u",
    "So the torch comes to all of the web, and to the edges of the lips from outside of the "
    "flanges. The program's first comment says it to the operator.")
NO_LIP = error("plan-coping-lip",
    "found {found} for the lips of {name}; expected their length, {least} to {most} mm, in the "
    "name of the section, by coper.lip or by --lip",
    "Each cut of a flange goes through the lip at its edge, as deep as that is long. No header "
    "line of DSTV has it; a name with four figures does (C200*70*20*2), and so does IFC (Girth). "
    "It is not guessed.")
GIVEN_LIP = note("plan-coping-given-lip",
    "found no length of the lips of {name} in the file; taken as {found} mm, as --lip or coper.lip "
    "has it",
    "Measure the lips of the bar, from the outside of the flange: the torch cuts as deep as this.")
INTO_LIP = error("plan-coping-into-lip",
    "found {what} at x {x} on face {face}; expected one through all of the lip, or clear of it by "
    "half a kerf",
    "At its lip a flange is cut by a pass that is as deep as the lip is long. What runs along the "
    "lip, or ends in it or its bend, cannot be made so.")
PIECE = note("plan-coping-piece",
    "the part comes cut to {found} mm with finished ends; its x 0 end lies at X {trim}{lies}",
    "Another machine has made its ends, and what its file has as made. The program begins with the "
    "same words for the operator.")
PIPE = note("plan-coping-pipe",
    "found a plate {found} {height} mm wide; it is the unrolled surface of a pipe {diameter} mm in "
    "diameter, and is cut as that pipe",
    "Some exporters write a pipe as a plate as wide as its circumference. On a machine for sheets "
    "--unrolled cuts it flat.")
NO_PIPE = error("plan-coping-no-pipe",
    "found a plate {found} {height} mm wide; expected {expected} mm, the circumference of a pipe "
    "{diameter} mm in diameter",
    "Name and width of an unrolled pipe contradict each other, and only one can be right.")
NO_RADIUS = error("plan-coping-radius",
    "found corners of {found} mm on {name}; expected their outer radius, {least} to {most} mm, in "
    "the header of the part, by a row of coper.corners or by --corner",
    "The torch goes round the corners of a tube by their outer radius. Line 14 of a DSTV header "
    "has it, or the machine file by the thickness of the wall, or else --corner (`corner` of "
    "beamcam.toml); it is not guessed.")
GIVEN_RADIUS = note("plan-coping-given-radius",
    "found no outer radius of the corners of {name} in the file; taken as {found} mm outside, as "
    "--corner or coper.corner has it",
    "One smaller than the wall is none. Measure a corner of the bar: the torch follows it by this "
    "radius. What a file says itself goes before --corner, and that before the machine's table.")
TABLE_RADIUS = warning("plan-coping-table-radius",
    "found no outer radius of the corners of {name} in the file; taken as {found} mm outside, "
    "{share}, as coper.corners of the machine file has it; measure a corner of the bar and give "
    "another one by --corner",
    "The table that is shipped is that of EN 10219-2; tubes of a mill differ, and those of other "
    "standards. The torch goes round a corner by this radius, and the program's head says it.")
SEAM = note("plan-coping-seam",
    "found the seam of a tube's outline {found} mm off its place; taken as closed",
    "The outline of an unrolled tube has two long sides along one line of its surface. Some draw "
    "them from the last place of one end to the first of the other.")
CORNER = error("plan-coping-corner",
    "found {found} at the corner between faces {a} and {b}; expected contours of both faces that "
    "go over it and meet at its edge",
    "What is cut over a corner has to be drawn on both faces beside it, up to the edge at which "
    "they meet; holes and slots lie beside the corner.")
TANGENTS = note("plan-coping-tangents",
    "found an outline on face {face} that ends at the tangents of the corners; its lines go "
    "straight on to the edges",
    "Where a face is round its outline counts up to the edge at which it would meet the other "
    "face. One that ends where the face is no longer flat says nothing else of the corners.")
REACHES = warning("plan-coping-reaches",
    "found a line of face {face} that reaches {into} mm into a corner; cut square to its round, up "
    "to {found} mm of steel more at one surface of the wall",
    "A cut-out is as wide as drawn where it is seen square to its face; the edge of a cope lies "
    "where the wall reaches farthest. Beyond the middle of the corner, where the other face "
    "begins, a cut-out has to be drawn on both.")
SLANT = warning("plan-coping-slant",
    "found ends or sides skew through the wall, cut square to the surface; up to {found} mm off at "
    "the inside of the walls {faces}",
    "The torch stands square to the wall. It cuts a skew end where the wall reaches farthest, so "
    "that no steel is missing; what is too much has to be ground off.")
WEDGE = warning("plan-coping-wedge",
    "found bevelled edges cut square through {wall} mm; up to {found} mm left outside or inside",
    "An edge with an angle leans through the wall as the surface does that it is to fit, which a "
    "torch square to the wall does not. The wedges stand on the list of manual work, by edge.")
BEVEL = note("plan-coping-bevel",
    "found a bevel of {found} degrees with a land of {land} mm from x {x}, y {y} on face {face}, "
    "which is left for manual work: {why}",
    "The torch leans over an edge as far as `coper.tilt` and its axes reach, where it is clear of "
    "web and flanges, its arc has steel, and its kerf hurts nothing of the part. Other edges are "
    "cut square, so that no steel is missing.")
SLOW = warning("plan-coping-slow",
    "found axis {axis} too slow for the corners, which are cut at {found} mm/min; expected "
    "{expected} mm/min as on the faces",
    "Round a corner the tube turns fast, and the torch follows it. The controller waits for the "
    "slowest axis, so that the cut gets wider there.")
RULES = (PIPE, NO_PIPE, ALONE, CROSSED, BEYOND, ROOT, LEDGE, STEP, K_AREA, NARROW, OFF, SHORT,
    TUBE_END, OPEN, ORIGIN, SUPPORT, CHUCK, DEEP, THICK, ROUNDED, BAR, TEE, LIPS, NO_LIP, GIVEN_LIP,
    INTO_LIP, PIECE, NO_RADIUS, GIVEN_RADIUS, TABLE_RADIUS, SEAM, CORNER, TANGENTS, REACHES, SLANT,
    WEDGE, BEVEL, SLOW)
