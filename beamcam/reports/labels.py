"""Labels: one for each piece, with a QR code or DataMatrix that a scanner at the machine reads.

The code holds the part's mark and the program's name, a line each. PDF by reportlab, one label a
page; ZPL II for Zebra printers, whose own codes are used (commands ^BQ and ^BX).
"""

import codecs
import io
import json
from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from typing import Literal

import msgspec
from msgspec import Struct

from beamcam.errors import Diagnostic, ReadError, Source, error
from beamcam.plain_text import json_text, terminal_text

Code = Literal["qr", "datamatrix"]
CODES: tuple[Code, ...] = ("qr", "datamatrix")

SCHEMA = "beamcam/labels/1"
MM = 72 / 25.4  #: points of PDF
DOTS = 8  #: a millimetre of a Zebra printer of 203 dpi
MARGIN = 4.0  #: mm
QUIET = 3.0  #: mm free above the code, whose reader needs four modules
#: Bytes of the largest code: QR version 40 with error level M, DataMatrix of 144 by 144 with ECI.
MOST_BYTES: Mapping[Code, int] = {"qr": 2331, "datamatrix": 1553}
MAX_LINES = 5
MAX_LETTERS = 60  #: of a line; longer ones would leave the label


CODE = error("label-code",
    "found {found} bytes for the code of a label, the mark and the program's name; expected at "
    "most {expected}",
    "No larger code of that kind is defined. Give the part a shorter mark; the labels of the other "
    "parts are made.")  # fmt: skip
NO_LABELS = error("label-file",
    "found a file of labels that cannot be read ({found}); expected it as `batch` over stock or "
    "`labels --json` wrote it",
    "The file was cut off or edited. Run the batch again; it writes the labels anew.")  # fmt: skip


class Label(Struct, frozen=True):
    """Content of the label of one piece."""

    mark: str
    lines: tuple[str, ...]  #: below the mark, the most important first
    program: str  #: file that makes it

    @property
    def code(self) -> str:
        """Content of the code: the mark and the program's name, a line each."""
        return f"{terminal_text(self.mark)}\n{terminal_text(self.program)}"


class LabelSize(Struct, frozen=True):
    """Of a label, mm."""

    width: float = 100.0
    height: float = 60.0

    @property
    def mark(self) -> float:
        """Height of the mark's line, across the top of the label."""
        return min(12.0, 0.22 * self.height)

    @property
    def code(self) -> float:
        """Edge of the code, in the lower right corner below the mark and beside the lines."""
        below = self.height - 2 * MARGIN - self.mark - QUIET
        return min(below, self.width / 2 - 2 * MARGIN)

    @property
    def line(self) -> float:
        """Height of a line below the mark, beside the code."""
        return min(6.0, (self.height - 2 * MARGIN - self.mark - QUIET) / MAX_LINES)


def as_pdf(labels: Iterable[Label], size: LabelSize, code: Code = "qr") -> bytes:
    """A page for each label; the same labels give the same bytes. Raises ImportError."""
    from reportlab.pdfbase import pdfmetrics
    from reportlab.pdfbase.ttfonts import TTFont
    from reportlab.pdfgen.canvas import Canvas

    out = io.BytesIO()
    canvas = Canvas(out, (size.width * MM, size.height * MM), invariant=1)
    canvas.setTitle("Labels")
    canvas.setCreator("beamcam")
    # A letter that is not in this font of reportlab is a box; the code has it all.
    pdfmetrics.registerFont(TTFont("Vera", "Vera.ttf"))
    font = "Vera"
    codes: dict[str, str] = {}
    for label in labels:
        canvas.scale(MM, MM)
        left, top = MARGIN, size.height - MARGIN
        free = size.width - 3 * MARGIN - size.code
        mark = terminal_text(label.mark)[:MAX_LETTERS]
        high = _fitting(mark, font, size.mark, size.width - 2 * MARGIN)
        canvas.setFont(font, high)
        canvas.drawString(left, top - 0.75 * size.mark, mark)
        for number, text in enumerate(label.lines[:MAX_LINES]):
            shown = terminal_text(text)[:MAX_LETTERS]
            canvas.setFont(font, _fitting(shown, font, 0.8 * size.line, free))
            base = top - size.mark - QUIET - (number + 0.7) * size.line
            canvas.drawString(left, base, shown)
        if label.code not in codes:  # the labels of one part have one code
            codes[label.code] = f"code{len(codes)}"
            canvas.beginForm(codes[label.code], 0, 0, size.width, size.height)
            _draw_code(canvas, code_rows(label.code, code), size)
            canvas.endForm()
        canvas.doForm(codes[label.code])
        canvas.showPage()
    canvas.save()
    return out.getvalue()


def code_fault(label: Label, code: Code, source: Source) -> Diagnostic | None:
    """Why no code can hold what is on a label; None if one can."""
    size = len(label.code.encode("utf-8"))
    if size <= MOST_BYTES[code]:
        return None
    return CODE.at(source, found=size, expected=MOST_BYTES[code])


def _fitting(text: str, font: str, high: float, width: float) -> float:
    """The size of letters, mm, by which a text is at most `width` mm long."""
    from reportlab.pdfbase.pdfmetrics import stringWidth

    return min(high, width / max(float(stringWidth(text, font, 1.0)), 1e-9))


def _draw_code(canvas: object, rows: Sequence[Sequence[int]], size: LabelSize) -> None:
    """The code in the lower right corner, a module as a square; those in a row are one strip."""
    module = size.code / len(rows)
    x0, y0 = size.width - MARGIN - size.code, MARGIN
    for row, modules in enumerate(rows):
        column, y = 0, y0 + (len(rows) - 1 - row) * module
        for dark, strip in groupby(modules):
            x, width = x0 + column * module, len(tuple(strip))
            if dark:
                canvas.rect(x, y, width * module, module, stroke=0, fill=1)  # type: ignore[attr-defined]
            column += width


def code_rows(text: str, code: Code = "qr") -> tuple[tuple[int, ...], ...]:
    """The modules of a text's code, its quiet zone left to the label. Raises ImportError."""
    if code == "datamatrix":
        from ppf.datamatrix import DataMatrix

        matrix = DataMatrix(text)
        if not text.isascii():
            matrix.codecs = [UTF_8_CODEC]
        return tuple(map(tuple, matrix.matrix))
    import segno

    return tuple(map(tuple, segno.make_qr(text, error="m").matrix))


def as_zpl(labels: Iterable[Label], size: LabelSize, code: Code = "qr") -> str:
    """ZPL II for a printer of 203 dpi: each label between ^XA and ^XZ."""
    return "".join(_zpl(label, size, code) for label in labels)


def as_json(labels: Iterable[Label]) -> str:
    """The labels as data: mark, program, lines and the text of the code of each."""
    rows = [
        {"mark": one.mark, "program": one.program, "lines": one.lines, "code": one.code}
        for one in labels
    ]
    record = {"schema": SCHEMA, "labels": rows}
    return json_text(json.dumps(record, ensure_ascii=False, indent=1)) + "\n"


class _LabelFile(Struct, frozen=True):
    """What `as_json` writes."""

    labels: tuple[Label, ...]


def labels_in(data: bytes, name: str) -> tuple[Label, ...]:
    """The labels that `as_json` wrote. Raises ReadError."""
    try:
        return msgspec.json.decode(data, type=_LabelFile).labels
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise ReadError(NO_LABELS.at(Source(name), found=error)) from error


def _zpl(label: Label, size: LabelSize, code: Code) -> str:
    width, height, margin = (round(v * DOTS) for v in (size.width, size.height, MARGIN))
    x = width - margin - round(size.code * DOTS)
    y = height - margin - round(size.code * DOTS)
    fields = [f"^XA^CI28^PW{width}^LL{height}", _field(margin, margin, size.mark, label.mark)]
    first = MARGIN + size.mark + QUIET
    fields += (
        _field(margin, round((first + k * size.line) * DOTS), 0.8 * size.line, text)
        for k, text in enumerate(label.lines[:MAX_LINES])
    )
    dots, content = size.code * DOTS, _escaped(label.code)
    if code == "qr":
        field = f"^BQN,2,{max(1, min(10, round(dots / 33)))}^FH^FDMA,{content}"
    else:
        # The last value is the sign that the printer's own escapes begin with: one that is not
        # there.
        escape = next(sign for sign in "~|#@$" if sign not in label.code)
        field = f"^BXN,{max(1, min(20, round(dots / 24)))},200,,,6,{escape}^FH^FD{content}"
    return "\n".join([*fields, f"^FO{x},{y}{field}^FS", "^XZ"]) + "\n"


def _field(x: int, y: int, high: float, text: str) -> str:
    shown, dots = _escaped(terminal_text(text)[:MAX_LETTERS]), round(high * DOTS)
    return f"^FO{x},{y}^A0N,{dots},{dots * 9 // 10}^FH^FD{shown}^FS"


def _escaped(text: str) -> str:
    """A text for a field after ^FH: what the printer obeys, and all but ASCII, as hex digits."""
    return "".join(
        chr(byte) if 32 <= byte < 127 and chr(byte) not in "^~_,\\" else f"_{byte:02X}"
        for byte in text.encode("utf-8")
    )


# --- modules of a DataMatrix code (ISO/IEC 16022), by ppf.datamatrix ------------------------------

# That library has codecs for ASCII alone. A text with other letters goes as bytes of UTF-8 in base
# 256, behind the word that says so (ECI 26).


ECI, UTF_8, BASE_256 = 241, 27, 231  #: codewords; ECI numbers are written one higher
SHORT = 249  #: bytes up to which one codeword says how many there are
UTF_8_CODEC = "datamatrix.utf8"


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


_CODEC = codecs.CodecInfo(_in_utf_8, codecs.utf_8_decode, name=UTF_8_CODEC)
codecs.register({UTF_8_CODEC: _CODEC}.get)
