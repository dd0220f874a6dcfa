"""The JSON schema of a record: its types as msgspec says them, its comments as descriptions."""

import ast
import inspect
import sys
from typing import Any, get_args

from msgspec import Struct, json
from msgspec.structs import fields

DIALECT = "https://json-schema.org/draft/2020-12/schema"

Schema = dict[str, Any]


def schema_of(record: type, others: dict[type, Schema] | None = None) -> Schema:
    """The schema of a record of keys, and under `$defs` of the records in it.

    `others` are the schemas of types that msgspec does not know.
    """
    known = others or {}
    (whole,), defs = json.schema_components((record,), schema_hook=lambda kind: dict(known[kind]))
    for kind in _records(record, {}):
        properties = defs[kind.__name__]["properties"]
        keys = {field.name: field.encode_name for field in fields(kind)}
        for name, (_, meaning) in documented(kind).items():
            if meaning:
                properties[keys[name]]["description"] = meaning
    return {"$schema": DIALECT, **whole, "$defs": defs}


def _records(hint: Any, known: dict[type, None]) -> dict[type, None]:
    """A record and all that its fields hold, each once."""
    if isinstance(hint, type) and issubclass(hint, Struct):
        if hint not in known:
            known[hint] = None
            for field in fields(hint):
                _records(field.type, known)
    else:
        for argument in get_args(hint):
            _records(argument, known)
    return known


def documented(record: type) -> dict[str, tuple[str, str]]:
    """Default and comment of each field, from the record's source.

    A comment stands behind its field, or on the lines before.
    """
    lines = inspect.getsource(sys.modules[record.__module__]).splitlines()
    tree = ast.parse("\n".join(lines))
    body = next(n for n in tree.body if isinstance(n, ast.ClassDef) and n.name == record.__name__)
    documents = {}
    for node in body.body:
        if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            comment = lines[(node.end_lineno or node.lineno) - 1].partition("#: ")[2].strip()
            first = node.lineno - 1
            while not comment and lines[first - 1].strip().startswith("#: "):
                first -= 1
            above = [line.strip().removeprefix("#: ") for line in lines[first : node.lineno - 1]]
            default = "" if node.value is None else ast.unparse(node.value)
            if isinstance(node.value, ast.Call):  # field(default_factory=)
                default = "()"
            documents[node.target.id] = default, comment or " ".join(above)
    return documents
