"""The modules of a DataMatrix code (ISO/IEC 16022), by ppf.datamatrix.

That library has codecs for ASCII alone. A text with other letters goes as bytes of UTF-8 in base
256, behind the word that says so (ECI 26).
"""

import codecs

ECI, UTF_8, BASE_256 = 241, 27, 231  #: codewords; ECI numbers are written one higher
SHORT = 249  #: bytes up to which one codeword says how many there are
UTF_8_CODEC = "datamatrix.utf8"


def datamatrix_rows(text: str) -> tuple[tuple[int, ...], ...]:
    """The modules of a square code, its quiet zone left to the label. Raises ImportError."""
    from ppf.datamatrix import DataMatrix

    code = DataMatrix(text)
    if not text.isascii():
        code.codecs = [UTF_8_CODEC]
    return tuple(map(tuple, code.matrix))


def _in_utf_8(text: str, errors: str = "strict") -> tuple[bytes, int]:
    """The codewords of a text: ECI, then its bytes in base 256, randomised by their places."""
    plain = text.encode("utf-8", errors)
    count = len(plain)
    length = [count] if count <= SHORT else [count // 250 + SHORT, count % 250]
    begun = [ECI, UTF_8, BASE_256]
    place = len(begun)
    words = [
        (word + 149 * (place + k) % 255 + 1) % 256 for k, word in enumerate((*length, *plain), 1)
    ]
    return bytes([*begun, *words]), len(text)


def _found(name: str) -> codecs.CodecInfo | None:
    if name != UTF_8_CODEC:
        return None
    return codecs.CodecInfo(_in_utf_8, codecs.utf_8_decode, name=UTF_8_CODEC)


codecs.register(_found)
