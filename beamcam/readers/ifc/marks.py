"""Data of a member besides its geometry: marks, grade, weights."""

import re
from collections.abc import Iterable, Iterator
from typing import Any

from msgspec import Struct, field

from beamcam.caches import cached
from beamcam.model import section
from beamcam.model.part import Profile
from beamcam.readers.ifc.entities import Entity, Model, tied

Value = str | float

_SETS = re.compile(
    r"AISC|Tekla|Common$|^Qto_|Quantit|Fabrication|PieceIdent|SteelFab|Cutout", re.IGNORECASE
)
#: Names of properties and quantities by what they say of a member; of each row the first counts.
_NAMES = {
    "mark": ("PieceMark", "Piece Mark", "Part Mark", "PartMark", "Part position",
             "Position number"),
    "assembly": ("Assembly/Cast unit Mark", "Assembly mark", "AssemblyMark", "Assembly Mark"),
    "profile": ("Profile", "ProfileName", "Profile name"),
    "grade": ("Grade", "Material grade", "MaterialGrade"),
    "length": ("Length", "NetLength"),
    "weight": ("NetWeight", "Net weight", "Weight (net)"),
    "volume": ("NetVolume", "Net volume", "Volume (net)"),
    "reference": ("Reference",),
    "phase": ("Phase",),
}  # fmt: skip
_WANTED = frozenset(name for names in _NAMES.values() for name in names)
NOT_STEEL = (
    ("concrete", re.compile(r"concrete|beton|b[ée]ton|hormig|\bC\d\d/\d\d|precast", re.IGNORECASE)),
    ("timber", re.compile(r"timber|wood|holz|glulam|lumber|\bGL\d\d|bois|plywood", re.IGNORECASE)),
    ("masonry", re.compile(r"masonry|brick|mauerwerk", re.IGNORECASE)),
)
_CUTOUTS = "cutout"  #: in the name of a property set that lists copes and mitres
#: The units of properties and quantities; others stand as they are.
_UNITS = {
    "IFCLENGTHMEASURE": "mm", "IFCPOSITIVELENGTHMEASURE": "mm", "IFCQUANTITYLENGTH": "mm",
    "IFCMASSMEASURE": "kg", "IFCQUANTITYWEIGHT": "kg",
}  # fmt: skip
_GUID_TAG = re.compile(r"^(ID)?[0-9A-Fa-f]{8}-|^ID[0-9a-zA-Z]{6,}|^\d{5,}$")
_GRADE = re.compile(r"\b(?:S ?\d{3}|A\d{2,3}|Q\d{3}|C\d{3})[A-Z0-9+]*")
_PROFILE = re.compile(r"^[A-Za-z]{1,8}[ _.\-]?\d|^\d[\d./xX*]*[ ]?[A-Za-z]{1,4}")


class Data(Struct, frozen=True, gc=False):
    """The properties of a member that matter here."""

    sets: dict[str, dict[str, Value]] = field(default_factory=dict)  #: values by set and name

    @property
    def cutouts(self) -> str | None:
        """The property set that lists copes and mitres."""
        return next((of for of in self.sets if _CUTOUTS in of.lower()), None)

    def _values(self, what: str) -> Iterator[tuple[str, Value]]:
        """The sources and the values of a row of `_NAMES`."""
        for name in _NAMES[what]:
            yield from ((f"{of}.{name}", v[name]) for of, v in self.sets.items() if name in v)

    def text(self, what: str) -> str:
        """What the sets say of a row of `_NAMES`; empty if they say nothing."""
        return next(filter(None, (str(value).strip() for _, value in self._values(what))), "")

    def number(self, what: str) -> tuple[str, float]:
        """The source and the value, above 0, of a row of `_NAMES`; 0 if there is none."""
        numbers = ((of, v) for of, v in self._values(what) if isinstance(v, float) and v > 0)
        return next(numbers, ("", 0.0))


def data_of(model: Model, element: Entity) -> Data:
    """The properties and quantities of an element that matter here, in mm and kg."""
    sets: dict[str, dict[str, Value]] = {}
    for definition in tied(element, "definitions"):
        of, values = model.once("set", definition, _set_of, model, definition)
        if values or _CUTOUTS in of.lower():
            sets.setdefault(of, values)
    return Data(sets)


def _set_of(model: Model, definition: Entity) -> tuple[str, dict[str, Value]]:
    """The name of a property set and those of its values that matter here."""
    file = definition.file
    named = definition.is_a("IfcPropertySetDefinition")
    of = file.peek(definition, 2) or "" if named else ""
    rows: list[tuple[str, str, Any]] = []
    if _SETS.search(of) is None:
        pass
    elif definition.is_a("IfcPropertySet"):
        for one in file.listed(definition, definition.type.places["HasProperties"], _WANTED):
            if one.is_a("IfcPropertySingleValue") and (value := one.NominalValue) is not None:
                rows.append((one.Name, value.kind, value.value))
    elif definition.is_a("IfcElementQuantity"):
        rows += [(one.Name, one.type.name.upper(), one.values[3]) for one in definition.Quantities]
    units = {"mm": model.mm, "kg": model.kilograms, "": 1.0}
    values: dict[str, Value] = {}
    for name, kind, raw in rows:
        if isinstance(raw, (int, float)) and not isinstance(raw, bool):
            values[name] = raw * units[_UNITS.get(kind, "")]
        elif raw is not None:
            values[name] = str(raw)
    return of, values


def mark_of(element: Entity, data: Data) -> str:
    """The piece mark.

    Fabrication sets come first, then a Tag that is not a database key, a Reference that is not a
    section, and the Name.
    """
    if mark := data.text("mark"):
        return mark
    tag = (getattr(element, "Tag", None) or "").strip()
    if tag and not _GUID_TAG.search(tag) and tag != element.guid:
        return tag
    reference = data.text("reference")
    plain = not _PROFILE.search(reference.replace("(?)", ""))
    if reference and (plain or re.fullmatch(r"[A-Za-z]{1,3}/?\d{1,5}(\(\?\))?", reference)):
        return reference
    return tag or (element.Name or "").strip() or element.guid


def assembly_of(element: Entity, data: Data) -> str:
    """The mark of the assembly that an element is part of; empty if there is none."""
    wholes = (one for one in tied(element, "wholes") if one.is_a("IfcElementAssembly"))
    marks = (str(one.Tag or one.Name or one.guid).strip() for one in wholes)
    return data.text("assembly") or next(marks, "")


def material_of(model: Model, element: Entity) -> str:
    """The name of an element's material, or of its type's; empty if it has none."""
    for one in (element, *tied(element, "types")):
        for material in tied(one, "materials"):
            return _name_of(material)
    return ""


def _name_of(material: Entity) -> str:
    if material.is_a() == "IfcMaterial":
        return (material.Name or "").strip()
    for path in ("ForProfileSet", "ForLayerSet", "MaterialProfiles", "MaterialLayers", "Materials",
                 "MaterialConstituents", "Material"):  # fmt: skip
        inner = getattr(material, path, None)
        if inner:
            return _name_of(inner[0] if isinstance(inner, tuple) else inner)
    return (getattr(material, "Name", None) or "").strip()


def grade_of(material: str, data: Data) -> tuple[str, str | None]:
    """The steel grade, and that of the material where it is another one of the same family.

    Of Tekla's STEEL/S235JR it is what follows the slash. S355 is no other steel than S355JR.
    """
    own = material.rsplit("/", 1)[-1].strip() if material.upper().startswith("STEEL/") else material
    stated = data.text("grade")
    if not stated:
        return own, None
    one, other = (_GRADE.search(text.upper()) for text in (material, stated))
    if one is None or other is None or one[0][0] != other[0][0]:
        return stated, None
    same = one[0].startswith(other[0]) or other[0].startswith(one[0])
    return stated, None if same else own


def labels_of(model: Model, element: Entity, profile: Entity | None, data: Data) -> tuple[str, ...]:
    """The file's label of the section, empty if it has none, and those of its material."""
    own = (getattr(profile, "ProfileName", None) or "").strip()
    texts = own, data.text("profile"), element.ObjectType, element.Description, element.Name
    first = next(filter(None, (_section_name(text or "") for text in texts)), own)
    for material in tied(element, "materials"):
        return first, *_profile_names(material)
    return (first,)


def _profile_names(material: Entity) -> tuple[str, ...]:
    """The names of sections that a material's profile set states."""
    if material.is_a("IfcMaterialProfileSetUsage"):
        material = material.ForProfileSet
    if not material.is_a("IfcMaterialProfileSet"):
        return ()
    texts = [material.Name]
    for one in material.MaterialProfiles:
        texts += [one.Name, one.Profile and one.Profile.ProfileName]
    return tuple(dict.fromkeys(filter(None, (_section_name(text or "") for text in texts))))


@cached("ifc.section_name")
def _section_name(text: str) -> str:
    """The name of a section that stands behind the last colon; empty if it looks like none."""
    text = text.rsplit(":", 1)[-1].strip()
    return text if _PROFILE.search(text) else ""


# --- naming ---------------------------------------------------------------------------------------
# Name of a section, and whether the labels of the file agree with its dimensions.

#: Names that are measures: of tubes, pipes, angles, flat and round bars, as modellers write them.
_MEASURES = re.compile(
    r"(?:RHS|SHS|CHS|QRO|RRO|MSH|VHP|K|KR|KKR|VKR|KCKR|Q|RO|ROR|TUBE|TUBO|PIPE?|O|D|Ø|RD|L|FL|FLT|"
    r"FB|PL|BL)"
    r"[ .-]?(\d+(?:[.,]\d+)?(?:[xX*×/-]\d+(?:[.,]\d+)?)*)"
)
_NUMBER = re.compile(r"\d+(?:[.,]\d+)?")
LARGEST_INCHES = 30.0  #: names whose numbers are all smaller may be in inches
SIZE_OFF = 1.0  #: mm that a size may differ from its name
WALL_OFF = 0.4  #: mm that a thickness may


def named(profile: Profile, labels: Iterable[str]) -> tuple[str, list[str]]:
    """The name of a section, and the labels that its dimensions contradict.

    The first label stands unless the catalogue knows it, or it says itself, by other measures; a
    section without one has the catalogue's name, or one made of its measures.
    """
    first, *others = labels
    wrong = [label for label in (first, *others) if label and _contradicts(label, profile)]
    name = first if first and first not in wrong else name_of(profile)
    return name, [*dict.fromkeys(wrong)]


def _contradicts(label: str, profile: Profile) -> bool:
    known = section.measures_of(label)
    if known is not None:
        # Measures of angles and tubes do not say which side is up.
        return known[0] != profile.code or section.difference(profile, known[1]) > SIZE_OFF
    numbers = _measures_in(label)
    if (
        profile.code not in ("B", "RO", "M", "L")
        or len(numbers) < 2
        or max(numbers) < LARGEST_INCHES
    ):
        return False
    thick = profile.web_thickness or 0.0
    if profile.code == "B":  # of a plate the other numbers may be those of a larger blank
        return all(abs(one - thick) > WALL_OFF for one in numbers)
    sizes = (profile.height,) if profile.code == "RO" else (profile.height, profile.width)
    if len(numbers) == 2 and len(sizes) == 2:  # K100*5 is square
        sizes = sizes if abs(sizes[0] - sizes[1]) <= SIZE_OFF else (0.0, 0.0)
        numbers = (numbers[0], *numbers)
    if len(numbers) != len(sizes) + 1:
        return False
    *outer, wall = sorted(numbers, reverse=True)
    off = (abs(a - b) for a, b in zip(outer, sorted(sizes, reverse=True), strict=True))
    return max(off) > SIZE_OFF or abs(wall - thick) > WALL_OFF


@cached("ifc.said_measures")
def _measures_in(label: str) -> tuple[float, ...]:
    """The numbers of a name that is made of measures, in mm; none of another name."""
    match = _MEASURES.fullmatch(label.strip().upper())
    if match is None:
        return ()
    return tuple(float(n.replace(",", ".")) for n in _NUMBER.findall(match[1]))


def name_of(profile: Profile) -> str:
    """The catalogue's name of a section, or one of its measures: I300x150x7.1x10.7, PL10x200."""
    if (known := section.name_of(profile)) is not None:
        return known
    p = profile
    sizes = p.height, p.width, p.flange_thickness, p.web_thickness or 0
    h, b, t, w = (f"{v:.1f}".removesuffix(".0") for v in sizes)
    named = {
        "B": f"PL{w}x{h}", "L": f"L{h}x{b}x{w}", "M": f"RHS{h}x{b}x{w}", "RO": f"CHS{h}x{w}",
        "RU": f"RD{h}",
    }  # fmt: skip
    return named.get(p.code, f"{p.code}{h}x{b}x{w}x{t}")
