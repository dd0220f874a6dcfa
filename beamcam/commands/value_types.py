"""What an option takes: numbers within limits, names, addresses, quantities, names of outputs."""

import re
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from math import inf, isfinite, nan
from typing import Any

import click

from beamcam.commands.common import PICTURES, STANDARD, suffix_of


def parsed(parse: Callable[[str], Any], expected: str) -> Callable[..., Any]:
    """A callback that gives what `parse` makes of a text, or of each of several.

    One of which it raises ValueError or LookupError is refused.
    """

    def one(text: str) -> Any:
        try:
            return parse(text)
        except (LookupError, ValueError) as error:
            raise click.BadParameter(f"found {text!r}; expected {expected}") from error

    def callback(ctx: click.Context, param: click.Parameter, value: Any) -> Any:
        if value is None:
            return None
        return tuple(map(one, value)) if isinstance(value, tuple) else one(value)

    return callback


class Number(click.ParamType):  # type: ignore[type-arg]  # older versions take none
    """A number within limits; infinity and nan, which Python takes for numbers, are refused."""

    name = "number"

    def __init__(self, least: float = -inf, above: float = -inf, most: float = inf) -> None:
        self._least, self._above, self._most = least, above, most

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        number = nan
        with suppress(ValueError):
            number = float(value)
        if isfinite(number) and self._above < number and self._least <= number <= self._most:
            return number
        self.fail(f"found {value!r}; expected {self._expected}{_hint(str(value))}.", param, ctx)

    @property
    def _expected(self) -> str:
        limits = [f"above {self._above:g}"] if isfinite(self._above) else []
        limits += [f"{self._least:g} or more"] if isfinite(self._least) else []
        limits += [f"at most {self._most:g}"] if isfinite(self._most) else []
        return " ".join(["a number", ", ".join(limits)]).strip()


#: A number as people write it, with commas or a unit.
_WITH_UNIT = re.compile(r"([+-]?\d[\d.,]*)\s*(mm|cm|m|in|inch|ft|\"|')?")
_MM = {
    "mm": 1.0, "cm": 10.0, "m": 1000.0, "in": 25.4, "inch": 25.4, "ft": 304.8,
    '"': 25.4, "'": 304.8,
}  # fmt: skip


def _hint(text: str) -> str:
    """How a number with a unit or a comma is to be written; empty for any other text."""
    match = _WITH_UNIT.fullmatch(text.strip())
    if match is None:
        return ""
    digits, unit = match.groups()
    if unit is None and "," not in digits and digits.count(".") < 2:
        return ""
    if re.fullmatch(r"[+-]?\d{1,3}(,\d{3})+(\.\d+)?", digits):
        return f", without commas: {digits.replace(',', '')}"
    number = digits.replace(",", ".")
    if number.count(".") > 1:
        return ", without signs between the digits"
    if unit is None:
        return f", with a point: {number}"
    return f", without a unit: {float(number) * _MM[unit]:g} (mm)"


class SkipNames(click.Choice):  # type: ignore[type-arg]  # older versions take none
    """Names of kinds of features, set off by commas."""

    name = "names"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        convert = super().convert
        return ",".join(convert(name.strip(), param, ctx) for name in str(value).split(","))


MODBUS_PORT = 502  #: of Modbus TCP, by the standard


def _address(default_port: int | None, text: str) -> tuple[str, int]:
    if default_port is not None and ":" not in text.rpartition("]")[2]:
        text = f"{text}:{default_port}"
    host, colon, port = text.rpartition(":")
    if not (colon and host and port.isdigit() and 0 < int(port) < 65536):
        raise ValueError(text)
    return host.strip("[]"), int(port)


def address(default_port: int | None = None) -> Callable[..., Any]:
    """The callback of a HOST:PORT; the port may be left out where there is one by default."""
    return parsed(partial(_address, default_port), "HOST:PORT such as localhost:502")


MAX_QUANTITY = 100_000


def quantity(text: str) -> str | int:
    """`file`, or a number of pieces. Raises ValueError."""
    if text != "file" and not (text.isdecimal() and 0 < int(text[:9]) <= MAX_QUANTITY):
        raise ValueError(text)
    return text if text == "file" else int(text)


# --- outputs besides programs ---------------------------------------------------------------------

#: What a command writes besides programs and parts; a name without a suffix is taken too.
KINDS: Mapping[str, tuple[str, ...]] = {
    "batch": (".json", ".csv", ".html"),  # its report
    "diff": (".html", *PICTURES),
    "plan": (".txt", ".json"),
    "plot": PICTURES,
    "profile": (".csv", *PICTURES, ".html"),
    "report": (".html", ".pdf"),
    "simulate": (".csv", ".json", *PICTURES, ".html"),
}

Callback = Callable[[click.Context, click.Parameter, str | None], str | None]


def expected(found: str, kind: str) -> str:
    """The message for an output of another kind."""
    return f"found {found!r}; expected a name in {', '.join(KINDS[kind])}, or -"


def of_kind(kind: str, without: tuple[str, ...] = ("",)) -> Callback:
    """Refuses an output whose suffix says what the command cannot write, or that has none."""

    def check(ctx: click.Context, param: click.Parameter, value: str | None) -> str | None:
        if value not in (None, STANDARD) and suffix_of(value) not in (*without, *KINDS[kind]):
            raise click.BadParameter(expected(value, kind))
        return value

    return check


unit = click.option(
    "--unit", type=click.Choice(["mm", "inch"]), default="mm", show_default=True,
    help="Of the lengths that are shown.",
)  # fmt: skip

paper = click.option(
    "--paper", type=click.Choice(["a4", "a3"]), default="a4", show_default=True,
    help="Of a PDF; what is wide lies on its side.",
)  # fmt: skip


def check_paper(paper: str, suffix: str) -> None:
    """Raises UsageError for a paper where no PDF is written."""
    if paper != "a4" and suffix != ".pdf":
        raise click.UsageError(f"found --paper {paper} with {suffix}; expected it with a .pdf.")


def picture_suffix(output: str) -> str:
    """The format of a picture by its name; standard output is an SVG."""
    suffix = ".svg" if output == STANDARD else suffix_of(output)
    if suffix not in PICTURES:
        raise click.UsageError(expected(output, "plot"))
    return suffix
