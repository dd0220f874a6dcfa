"""What a grade is made of, so that rows of a cut chart may name a material.

    S355J2, A36, 1.0038, MS        mild steel: unalloyed structural steel up to S460
    1.4301, X5CrNi18-10, 304       stainless steel
    EN AW-5754, AlMg3, 6082        aluminium
    NA, unknown, <unnamed>, -      nothing: what offices write where they know no grade

A grade that is none of these is a material of its own: a row has to name it. High-strength steels
(S500 and above) are alloyed, and have rows of their own.
"""

import re
from fnmatch import fnmatchcase

MILD_STEEL, STAINLESS, ALUMINIUM = "mild steel", "stainless steel", "aluminium"

#: By EN 10025, 10027-2, 10111, 10130, 10088 and 573, DIN 17100, ASTM, JIS, GB; spaces do not count.
_GRADES = (
    (MILD_STEEL,
     r"(METAL)?(MILD|STRUCTURAL|CARBON)?STEEL(\d+MPA)?|STAHL|BAUSTAHL|MS|CS"
     r"|S(185|195|235|275|355|420|450|460)\D.*|S(185|195|235|275|355|420|450|460)"
     r"|R?S?ST(33|37|44|50|52|60|70).*|(RST|UST)\d\d.*|FE(310|360|430|490|510).*|E(24|28|36).*"
     r"|A(36|53|283|500|501|516|529|572|992|1011)(\D.*)?|A572(42|50|55|60|65)"
     r"|Q(195|215|235|275|345|355|390|420|460).*"
     r"|SS(330|400|490)|SM(400|490|520).*|P(235|265|355)GH|D[CD]0[1-6].*|1\.0\d{3}.*|C10|C15|C22"
     r"|GR\.?(36|42|50).*|(300|350)(WT?|LA)?"),
    (STAINLESS,
     r"STAINLESS(STEEL)?|INOX|EDELSTAHL|V[24]A|1\.4\d{3}.*|X\d+CR.*|(AISI|SUS|TP|SS)?(3(01|03|04|09|10"
     r"|16|17|21|47)|4(09|10|20|30|40))(L|LN|H|TI|S)?"),
    (ALUMINIUM,
     r"ALU(MINI?UM)?|ENAW.*|AL(MG|SI|CU|ZN|99|9).*|3\.\d{4}.*|[1-7]0\d\d(-?[HTOF]\d*)?"
     r"|(5[0-9]|6[0-9]|7[0-9])\d\d(-?[HTOF]\d*)?"),
)  # fmt: skip
_NOTHING = re.compile(
    r"N\.?/?A\.?|NONE|NIL|NULL|UNKNOWN|UNDEFINED|<?UNNAMED>?|DEFAULT|TBD|[?.X*/]*"
)
_MATCHERS = tuple((name, re.compile(pattern)) for name, pattern in _GRADES)


def material_of(grade: str) -> str:
    """What a grade is made of; the grade itself, without its case, if that is not known."""
    plain = _plain(grade)
    return next((name for name, pattern in _MATCHERS if pattern.fullmatch(plain)), grade.casefold())


def material_said(grade: str, otherwise: str) -> str:
    """The grade of a part, or what a sheet is made of otherwise where that says nothing."""
    return otherwise if _NOTHING.fullmatch(_plain(grade)) else grade


def _plain(grade: str) -> str:
    return re.sub(r"[\s_-]|ASTM", "", grade.upper())


def is_row_for(material: str, grade: str) -> bool:
    """Whether a row of a cut chart is for sheets of a grade.

    `material` is that of the row: a grade as a shell pattern, or a material. A sheet of which
    nothing is known is of any.
    """
    if not grade or fnmatchcase(grade.upper(), material.upper()):
        return True
    return material_of(grade) == material_of(material)
