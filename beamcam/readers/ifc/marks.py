"""Data of a member besides its geometry: marks, grade, weights."""

import re
from collections.abc import Iterable

from msgspec import Struct, field

from beamcam.caches import cached
from beamcam.model import section
from beamcam.model.part import Profile
from beamcam.readers.ifc.entities import Entity, Model, tied
from beamcam.readers.ifc.text import Typed

Value = str | float

_SETS = re.compile(
    r"AISC|Tekla|Common$|^Qto_|Quantit|Fabrication|PieceIdent|SteelFab|Cutout", re.IGNORECASE
)
_MARKS = ("PieceMark", "Piece Mark", "Part Mark", "PartMark", "Part position", "Position number")
_ASSEMBLY_MARKS = ("Assembly/Cast unit Mark", "Assembly mark", "AssemblyMark", "Assembly Mark")
_NOT_STEEL = (
    ("concrete", re.compile(r"concrete|beton|b[ée]ton|hormig|\bC\d\d/\d\d|precast", re.IGNORECASE)),
    ("timber", re.compile(r"timber|wood|holz|glulam|lumber|\bGL\d\d|bois|plywood", re.IGNORECASE)),
    ("masonry", re.compile(r"masonry|brick|mauerwerk", re.IGNORECASE)),
)
_PROFILES = ("Profile", "ProfileName", "Profile name")
_GRADES = ("Grade", "Material grade", "MaterialGrade")
LENGTHS = ("Length", "NetLength")
WEIGHTS = ("NetWeight", "Net weight", "Weight (net)")
VOLUMES = ("NetVolume", "Net volume", "Volume (net)")
CUTOUTS = "cutout"  #: in the name of a property set that lists copes and mitres
#: The names of the properties that matter.
_WANTED = frozenset((*_MARKS, *_ASSEMBLY_MARKS, *_PROFILES, *_GRADES, *LENGTHS, *WEIGHTS, *VOLUMES,
                     "Reference", "Phase"))  # fmt: skip
_GUID_TAG = re.compile(r"^(ID)?[0-9A-Fa-f]{8}-|^ID[0-9a-zA-Z]{6,}|^\d{5,}$")
_GRADE = re.compile(r"\b(?:S ?\d{3}|A\d{2,3}|Q\d{3}|C\d{3})[A-Z0-9+]*")
_PROFILE = re.compile(r"^[A-Za-z]{1,8}[ _.\-]?\d|^\d[\d./xX*]*[ ]?[A-Za-z]{1,4}")


class Data(Struct, frozen=True, gc=False):
    """The property sets of a member that matter here, by set and property."""

    sets: tuple[str, ...] = ()
    rows: dict[str, list[tuple[str, Value]]] = field(default_factory=dict)  #: set, value; by name

    def text(self, *names: str) -> str:
        """The first of the properties `names` that some set has and that is not empty."""
        if self.rows.keys().isdisjoint(names):
            return ""
        for name in names:
            for _, value in self.rows.get(name, ()):
                text = str(value).strip()
                if text:
                    return text
        return ""

    def has(self, word: str) -> str | None:
        """The name of a property set that has a word in it and that is not empty."""
        return next((of for of in self.sets if word in of.lower()), None)

    def number(self, *names: str) -> tuple[str, float] | None:
        """The first property that is a number above 0, and its source."""
        if self.rows.keys().isdisjoint(names):
            return None
        for name in names:
            for of, value in self.rows.get(name, ()):
                if isinstance(value, (int, float)) and value > 0:
                    return f"{of}.{name}", float(value)
        return None


def data_of(model: Model, element: Entity) -> Data:
    """The property sets and quantities of an element."""
    sets: list[str] = []
    rows: dict[str, list[tuple[str, Value]]] = {}
    for definition in tied(element, "definitions"):
        of, values = model.once("set", definition, _set_of, model, definition)
        if of not in sets and (values or CUTOUTS in of.lower()):
            sets.append(of)
            for key, value in values.items():
                rows.setdefault(key, []).append((of, value))
    return Data(tuple(sets), rows)


def _set_of(model: Model, definition: Entity) -> tuple[str, dict[str, Value]]:
    """The name of a property set and those of its values that matter here."""
    named = definition.is_a("IfcPropertySetDefinition")
    name = definition.file.peek(definition, 2) or "" if named else ""
    found: dict[str, Value] = {}
    if _SETS.search(name) is None:
        return name, found
    if definition.is_a("IfcPropertySet"):
        properties = definition.type.places["HasProperties"]
        for one in definition.file.listed(definition, properties, _WANTED):
            if one.is_a("IfcPropertySingleValue") and one.NominalValue is not None:
                found[one.Name] = _value(model, one.NominalValue)
    elif definition.is_a("IfcElementQuantity"):
        for one in definition.Quantities:
            if one.is_a("IfcQuantityLength"):
                found[one.Name] = one.LengthValue * model.mm
            elif one.is_a("IfcQuantityWeight"):
                found[one.Name] = one.WeightValue * model.kilograms
            elif one.is_a("IfcQuantityVolume"):
                found[one.Name] = one.VolumeValue
    return name, found


def _value(model: Model, value: Typed) -> Value:
    raw = value.value
    if value.is_a("IfcLengthMeasure") or value.is_a("IfcPositiveLengthMeasure"):
        return float(raw) * model.mm
    if value.is_a("IfcMassMeasure"):
        return float(raw) * model.kilograms
    return float(raw) if isinstance(raw, (int, float)) and not isinstance(raw, bool) else str(raw)


def mark_of(element: Entity, data: Data) -> str:
    """The piece mark.

    Fabrication sets come first, then a Tag that is not a database key, a Reference that is not a
    section, and the Name.
    """
    mark = data.text(*_MARKS)
    if mark:
        return mark
    tag = (getattr(element, "Tag", None) or "").strip()
    if tag and not _GUID_TAG.search(tag) and tag != element.guid:
        return tag
    reference = data.text("Reference")
    plain = not _PROFILE.search(reference.replace("(?)", ""))
    if reference and (plain or re.fullmatch(r"[A-Za-z]{1,3}/?\d{1,5}(\(\?\))?", reference)):
        return reference
    return tag or (element.Name or "").strip() or element.guid


def assembly_of(element: Entity, data: Data) -> str:
    """The mark of the assembly that an element is part of; empty if there is none."""
    mark = data.text(*_ASSEMBLY_MARKS)
    if mark:
        return mark
    for whole in tied(element, "wholes"):
        if whole.is_a("IfcElementAssembly"):
            return str(whole.Tag or whole.Name or whole.guid).strip()
    return ""


def material_of(model: Model, element: Entity) -> str:
    """The name of an element's material, or of its type's; empty if it has none."""
    for one in (element, *tied(element, "types")):
        for material in tied(one, "materials"):
            return model.once("material", material, _name_of, material)
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


def not_steel(material: str) -> str | None:
    """Kind of a non-steel material: concrete, timber, masonry."""
    for what, words in _NOT_STEEL:
        if words.search(material):
            return what
    return None


def grade_of(material: str, data: Data) -> str:
    """The steel grade: what follows the slash in Tekla's STEEL/S235JR."""
    grade = data.text(*_GRADES)
    if grade:
        return grade
    tekla = material.upper().startswith("STEEL/")
    return material.rsplit("/", 1)[-1].strip() if tekla else material


def grades_apart(material: str, data: Data) -> tuple[str, str] | None:
    """The steel of a material and that of a grade property, where they are two of one family.

    S355 is no other steel than S355JR.
    """
    grade = data.text(*_GRADES)
    if not grade:
        return None
    (one, other) = (_GRADE.search(text.upper()) for text in (material, grade))
    if one is None or other is None or one[0][0] != other[0][0]:
        return None
    apart = not (one[0].startswith(other[0]) or other[0].startswith(one[0]))
    return (grade_of(material, Data()), grade) if apart else None


def profile_set_names(model: Model, element: Entity) -> tuple[str, ...]:
    """The names of sections that the profile set of an element's material states."""
    for material in tied(element, "materials"):
        return model.once("profile set", material, _profile_names, material)
    return ()


def _profile_names(material: Entity) -> tuple[str, ...]:
    if material.is_a("IfcMaterialProfileSetUsage"):
        material = material.ForProfileSet
    if not material.is_a("IfcMaterialProfileSet"):
        return ()
    found = [material.Name]
    for one in material.MaterialProfiles:
        found += [one.Name, one.Profile and one.Profile.ProfileName]
    return tuple(dict.fromkeys(filter(None, (_section_name(text or "") for text in found))))


def label_of(element: Entity, profile: Entity | None, data: Data) -> str:
    """The file's label of the section; empty if nothing looks like a section name."""
    named = (getattr(profile, "ProfileName", None) or "").strip() if profile is not None else ""
    others = (element.ObjectType or "", element.Description or "", element.Name or "")
    candidates = (named, data.text(*_PROFILES), *others)
    return next(filter(None, map(_section_name, candidates)), named)


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
    said = _said_measures(label)
    if profile.code not in ("B", "RO", "M", "L") or len(said) < 2 or max(said) < LARGEST_INCHES:
        return False
    thick = profile.web_thickness or 0.0
    if profile.code == "B":  # of a plate the other numbers may be those of a larger blank
        return all(abs(one - thick) > WALL_OFF for one in said)
    sizes = (profile.height,) if profile.code == "RO" else (profile.height, profile.width)
    if len(said) == 2 and len(sizes) == 2:  # K100*5 is square
        sizes = sizes if abs(sizes[0] - sizes[1]) <= SIZE_OFF else (0.0, 0.0)
        said = (said[0], *said)
    if len(said) != len(sizes) + 1:
        return False
    *outer, wall = sorted(said, reverse=True)
    off = (abs(a - b) for a, b in zip(outer, sorted(sizes, reverse=True), strict=True))
    return max(off) > SIZE_OFF or abs(wall - thick) > WALL_OFF


@cached("ifc.said_measures")
def _said_measures(label: str) -> tuple[float, ...]:
    """The numbers of a name that is made of measures, in mm; none of another name."""
    found = _MEASURES.fullmatch(label.strip().upper())
    if found is None:
        return ()
    return tuple(float(n.replace(",", ".")) for n in _NUMBER.findall(found[1]))


def name_of(profile: Profile) -> str:
    """The catalogue's name of a section, or one made of its measures."""
    return section.name_of(profile) or measured_name(profile)


def measured_name(profile: Profile) -> str:
    """A name made of the measures: I300x150x7.1x10.7, PL10x200."""
    p = profile
    sizes = p.height, p.width, p.flange_thickness, p.web_thickness or 0
    h, b, t, w = (f"{v:.1f}".removesuffix(".0") for v in sizes)
    named = {
        "B": f"PL{w}x{h}", "L": f"L{h}x{b}x{w}", "M": f"RHS{h}x{b}x{w}", "RO": f"CHS{h}x{w}",
        "RU": f"RD{h}",
    }  # fmt: skip
    return named.get(p.code, f"{p.code}{h}x{b}x{w}x{t}")
