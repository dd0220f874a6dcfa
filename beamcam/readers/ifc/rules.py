"""Rules for IFC models and their members."""

from msgspec.structs import replace

from beamcam.errors import Diagnostic, Severity, error, note, warning

# fmt: off

SYNTAX = error("ifc-syntax",
    "found no IFC model ({found}); expected one STEP file with a DATA section",
    "The file is cut short, or is a pointer or an archive of none or several instead of the model.")
SCHEMA = error("ifc-schema",
    "found schema {found}; expected IFC2X3, IFC4 or IFC4X3",
    "Files of other schemas have other entities. Export the model again.")
NO_MEMBERS = warning("ifc-no-members",
    "found no steel member; expected beams, columns, members, plates or accessories",
    "The model holds other things only. Proxies are read on request, by --class.")
NOT_FOUND = error("ifc-selection",
    "found no member with {kind} {found}; expected one of the file's, such as {expected}",
    "The selection names a member that is not there, perhaps a typing error.")
LEDGER = note("ifc-ledger",
    "found {found} members: {read} read, {refused} refused, {left_out} left out, {unselected} not "
    "selected",
    "Every member of the file is in one of the four numbers.")
LEFT_OUT = note("ifc-left-out",
    "found {found} members of {what} ({classes}); expected steel, they are left out",
    "Concrete and timber share the classes of steel and are recognised by their material. A solid "
    "section thicker than 160 mm without a material could be any of them.")
OTHER_CLASSES = note("ifc-other-classes",
    "found {found} elements of other classes ({classes}); expected beams, columns, members, plates "
    "and accessories, nothing else is read",
    "Slabs, walls, fasteners and the like are no steel members. Proxies are read by --class.")
UNKNOWN_CLASS = warning("ifc-unknown-class",
    "found {found} records of classes that the schema has not ({classes}); expected those of "
    "{expected}, no member is read from them",
    "A misspelt class, or one of a later schema than the file says, may be a member that is lost.")
CURVED = error("ifc-curved",
    "found a curved member ({found}); expected a straight one",
    "A saw line takes straight bars. Bend the member by other means, and cut it beforehand.")
TAPERED = error("ifc-tapered",
    "found a tapered member ({found}); expected one section from end to end",
    "A member of changing section is welded of plates; its plates are the parts.")
GEOMETRY = error("ifc-geometry",
    "found {found}; expected a straight member with holes and cuts square to its faces",
    "The reader takes no geometry that it does not understand as a whole.")
SECTION = error("ifc-section",
    "found {found}; expected a rolled section, a tube or a plate",
    "A casting, a welded group or a coarse mesh has no section that a bar of stock could have.")
ODD_CUT = error("ifc-odd-cut",
    "found {found}; expected a round tube with saw cuts, holes and cuts that go through its wall",
    "The unrolled outside of a tube says where its wall is cut, from outside to inside. What ends "
    "within the wall is milled: model it as a part of its own, or make it manually.")
SOLID_CUT = error("ifc-solid-cut",
    "found {found} in a solid round bar; expected saw cuts, and holes through its axis: it has no "
    "wall that a torch could cut through, and no unrolled contour says how deep a flat lies in it",
    "Flats, notches and slots of a solid bar are milled. Make them manually from the model.")
SPECIAL_CUT = error("ifc-special-cut",
    "found {found} in a special section; expected saw cuts: it has no face that a contour or a "
    "hole could lie on",
    "DSTV has faces for rolled sections and tubes only. Make such cuts manually from the model.")
SQUARE_CUT = warning("ifc-square-cut",
    "found a wall that is not cut square to its outside in the model; cut square along the contour "
    "up to {stays} mm stay inside that the model has not, and up to {takes} mm go that it has",
    "A contour says how a tube is cut at its outside, and a torch goes through the wall square to "
    "that. Where the inside matters, as for a plate in a slot or a saddle, grind it or draw the "
    "slot wider.")
OUTLINE = error("ifc-outline",
    "found a section of {found} cm2 by the geometry kernel; expected {expected} cm2 by its outline",
    "A special section is its outline, and two ways of reading it disagree.")
PROFILE_NAME = warning("ifc-profile-name",
    "found the name {found} on a section of {size}; expected {expected} by its measures",
    "The element's name is often left from an earlier section; the geometry counts.")
GRADE = warning("ifc-grade",
    "found the material {found} and the grade {expected}; expected one steel",
    "The grade of the property set is taken. Which of the two is ordered is for the designer to "
    "say.")
LENGTH = error("ifc-length",
    "found a length of {found} mm in {where}; expected {expected} mm as modelled",
    "The model's data and its geometry contradict each other. --force takes the geometry.")
WEIGHT = error("ifc-weight",
    "found a net weight of {found} kg in {where}; expected {expected} kg by the volume",
    "The weight differs by more than what roundings explain. --force takes the geometry.")
WEIGHT_NEAR = warning("ifc-weight-near",
    "found a net weight of {found} kg in {where}; expected {expected} kg by the volume",
    "The weight differs by more than 3 %, as tables of sections and geometry may at most.")
NET_VOLUME = warning("ifc-net-volume",
    "found a net volume of {found} cm3 in {where}; expected {expected} cm3 as modelled",
    "The model's data and its geometry contradict each other by more than 1 %.")
CUTOUT = warning("ifc-cutout",
    "found cut-outs in {where}; expected a contour or a skew end, and the solid has neither",
    "The exporter lists copes and mitres beside the solid, and the solid has none.")
KERNEL = error("ifc-kernel",
    "found {found} by the geometry kernel; expected {expected} by the definition of the member",
    "Two ways of reading the member disagree. --force takes its definition.")
KERNEL_LOG = error("ifc-kernel-log",
    "found an error of the geometry kernel ({found}); expected a solid without one",
    "The kernel leaves out what it cannot build. --force takes the member as defined.")
KERNEL_DIED = error("ifc-kernel-died",
    "found a process dead that worked on this member alone; expected a solid by the geometry "
    "kernel, leave the member out by --mark or --guid of the others",
    "The kernel has crashed, was at it for five times `limits.member_s` of the processor, or the "
    "system ended it for want of memory.")
KERNEL_DENIED = warning("ifc-kernel-denied",
    "found {found} by the geometry kernel; expected what was read, which {witness} confirms",
    "The kernel fails on some solids without saying so; the file's own data decides.")
FITTED = warning("ifc-kernel-fitted",
    "found {found} among the faces of the kernel's solid; expected planes, cylinders and cones",
    "Arcs near such a face were fitted to its facets. Compare the outline with the model.")
UNEXPLAINED = error("ifc-unexplained",
    "found {found} than the features that were read leave; expected the body of the model",
    "Section, end cuts, holes and contours do not add up to the body. --force takes them.")
SECTION_AREA = warning("ifc-section-area",
    "found a section of {found} cm2 in the model; expected {expected} cm2 by its measures",
    "A part holds height, width, thicknesses and a radius: no slopes of flanges, no edge radii.")
KINKED = error("ifc-kinked",
    "found {found}; expected a straight one",
    "Two pieces that are cut and welded, or a bar that is bent. Model each piece by itself.")
ROOT_FILLET = warning("ifc-root-fillet",
    "found {found} in the model; a contour on a flange or web cannot say how the fillet is cut",
    "The fillet between web and flange is cut otherwise in the model than the walls beside it.")
ROOT_CUT = error("ifc-root-cut",
    "found {found} in the model; a contour on a flange or web cannot say how the fillet is cut, "
    "expected less than {share} % of the member",
    "So much of the fillet between web and flange is cut otherwise than the walls beside it, as by "
    "a groove along them. --force takes the part without that cut.")
LIPS = note("ifc-lips",
    "found a channel of {found} cm2 with lips of no single length in the model; the part holds its "
    "height, width, wall and radius, {expected} cm2",
    "The lips count in the weight. No hole, cut or text is held against them, and no torch cuts "
    "them. Lips of one length are the part's own.")
LEANING = warning("ifc-leaning-edge",
    "found {found} in the model; a cut square to the face leaves that steel standing",
    "The edge does not go square through its wall, as where a tube is saddled. Grind it off.")
VOLUME = warning("ifc-volume",
    "found a volume of {found} cm3 in the model; expected {expected} cm3 by what was read",
    "The difference is spread over the member, so that no place can be named.")
VOLUME_OFF = error("ifc-volume-off", VOLUME.message,
    "The difference is above 0.5 %. --force takes the member as read.")
PROJECTION = error("ifc-projection",
    "found {found} projections, steel that is added to the member; expected none, for they are not "
    "read",
    "Stiffeners and lugs that are modelled so are parts by themselves. --force takes the member "
    "without them.")
PIECES = warning("ifc-pieces",
    "found {found}; expected one piece",
    "A cut goes through a wall from edge to edge. Look whether the cut is meant.")
BOLT_HOLES = warning("ifc-bolt-holes",
    "found no holes but {found} bolts through the member; made {made} holes of {sizes}",
    "The exporter writes bolts and no holes. Their diameter is the bolt's with clearance.")
BOLT_AIR = warning("ifc-bolt-air",
    "found {found} bolts whose holes leave the steel of face {face} ({places}); expected them "
    "within the outline and clear of openings, no hole is made for them",
    "The bolt goes through a slot or a notch that is there already, or beside the part.")
BOLT_SHANK = warning("ifc-bolt-shank",
    "found {found} fasteners without a shank that can be read ({which}); expected a round "
    "extrusion or a line, no hole is made for them",
    "Nuts and washers have none, which is harmless. A bolt of another form leaves its hole out.")
BOLTS = note("ifc-bolts",
    "found {found} fasteners: {drilled} made holes, {idle} made none, {without} without a shank",
    "A bolt makes a hole only in a member whose solid has no holes of its own.")
BOLT_SKEW = error("ifc-bolt-skew",
    "found a bolt {found} at {angle} degrees to face {face}; expected it square to the face",
    "A drill comes square to the face; where the bolt is meant to go cannot be guessed.")


#: What cuts of sections without faces are refused by, which no other way of reading takes.
NOT_CUT = ODD_CUT, SOLID_CUT, SPECIAL_CUT


def of_the_solid(diagnostic: Diagnostic) -> str:
    """What a message finds in the solid of a member, as a part of another message."""
    unit = " cm3 in all" if diagnostic.code == VOLUME_OFF.code else ""
    return f"{diagnostic['found']}{unit}"


def forced(diagnostic: Diagnostic) -> Diagnostic:
    """An error as the warning that it becomes where the member is wanted all the same."""
    if diagnostic.severity is not Severity.ERROR:
        return diagnostic
    return replace(diagnostic, severity=Severity.WARNING)
