"""The machines that the tests check and prove, by the texts of their files.

A machine whose files have these texts is not checked again where it is loaded: its keys, its words
and the part that proves it would say the same as in the tests. Written by
`pytest tests/test_machine_proof.py --update-golden`.
"""

#: CRC-32 of a machine's file and its bases.
PROVED = {
    "beamline": "7b736c1e",
    "beamline-annex": "63ae07f1",
    "beamline-pusher": "8e97319d",
    "coper-linuxcnc": "8e779be4",
    "coper-tilt-linuxcnc": "dd72c301",
    "laser-grbl": "29c1e9ee",
    "laser-stepper": "c10dd2c8",
    "plate-codesys": "35031317",
    "plate-linuxcnc": "57f2e3ad",
    "plate-mach3": "6665ed9b",
    "plate-oxyfuel": "f8caa062",
    "plate-qtplasmac": "3b1495d4",
    "table-plcopen": "bd3ea136",
    "table-simotion": "a29e2ce2",
    "tube-linuxcnc": "14134d75",
    "tube-surface": "fa09bc8a",
}
