"""Addresses in a network, as options of the commands take them."""

import click

MODBUS_PORT = 502  #: of Modbus TCP, by the standard


class Address(click.ParamType):  # type: ignore[type-arg]  # older versions take none
    """HOST:PORT; the port may be left out where there is one by default."""

    name = "host:port"

    def __init__(self, port: int | None = None) -> None:
        self._port = port

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, int]:
        text = str(value)
        if self._port is not None and ":" not in text.rpartition("]")[2]:
            text = f"{text}:{self._port}"
        host, colon, port = text.rpartition(":")
        if not (colon and host and port.isdigit() and 0 < int(port) < 65536):
            self.fail(f"found {value!r}; expected HOST:PORT such as localhost:502", param, ctx)
        return host.strip("[]"), int(port)
