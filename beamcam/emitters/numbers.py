"""Numbers as controllers read them."""


def number(value: float, decimals: int) -> str:
    """`value` with at most `decimals` places: no trailing zeros, no `-0`, never an exponent."""
    text = "%.*f" % (decimals, value)  # noqa: UP031  half the time of an f-string's
    if "." in text:
        text = text.rstrip("0").rstrip(".")
    return "0" if text == "-0" else text
