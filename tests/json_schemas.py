"""Validates JSON output against the schemas in rtgen's wheel."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from jsonschema import Draft202012Validator

SCHEMAS = Path(__file__).parents[1] / "src" / "rtgen" / "cli" / "schemas"


@cache
def validator(name: str, part: str | None = None) -> Draft202012Validator:
    """Return the validator of a schema file, or of one of its definitions."""
    # Its import compiles a grammar, which each process that collects tests would wait for.
    from jsonschema import Draft202012Validator
    from referencing import Registry, Resource

    schemas = {path.name: json.loads(path.read_text()) for path in SCHEMAS.iterdir()}
    for schema in schemas.values():
        Draft202012Validator.check_schema(schema)
    resources = ((key, Resource.from_contents(s)) for key, s in schemas.items())
    wanted = schemas[name] if part is None else {"$ref": f"{name}#/$defs/{part}"}
    return Draft202012Validator(wanted, registry=Registry().with_resources(resources))


def valid(text: str, name: str, part: str | None = None) -> Any:
    """Return the content of a JSON text. Raises jsonschema.ValidationError."""
    content = json.loads(text)
    validator(name, part).validate(content)
    return content
