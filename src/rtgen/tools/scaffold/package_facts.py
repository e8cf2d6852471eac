"""Version, maintainers and licence of a project, from `pyproject.toml` and `rtgen.toml`."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final

import msgspec

from rtgen.compiler.diagnostics import ToolError
from rtgen.compiler.kit.toml_text import TomlError, parse
from rtgen.compiler.project import Project, shown
from rtgen.facts import ros_names
from rtgen.facts.files import UnreadableError, is_file, read_file

_NUMBERS: Final = re.compile(r"\d+")
_RELEASE: Final = re.compile(r"(?:\d+!)?(\d+(?:\.\d+)*)")
_PLACEHOLDER: Final = "todo@todo.todo"
"""The address that ros2 pkg create writes for nobody."""
UNKNOWN_LICENSE: Final = "TODO: License declaration"
"""The licence that ros2 pkg create writes."""


class Person(msgspec.Struct, frozen=True):
    """A maintainer."""

    name: str
    email: str


class Facts(msgspec.Struct, frozen=True):
    """What `package.xml` says of a project; `missing` has keys that are to be filled in."""

    name: str
    version: str
    description: str
    maintainers: tuple[Person, ...]
    license: str
    missing: tuple[str, ...]


def package_facts(project: Project) -> Facts:
    """Return the facts of a project. Raises ToolError for a file that is not TOML."""
    table = _table(project.root / "pyproject.toml").get("project", {})
    table = table if isinstance(table, dict) else {}
    name = _text(table, "name") or project.root.name
    own = ros_names.MAINTAINER.fullmatch(project.ros2.maintainer or "")
    people = (Person(own["name"], own["email"]),) if own else tuple(_people(table))
    license_ = project.ros2.license or _license(table)
    missing = [] if people else ["maintainer"]
    missing += [] if license_ else ["license"]
    return Facts(
        name=name,
        version=_version(_text(table, "version")),
        description=_text(table, "description") or f"Systems of {name}",
        maintainers=people or (Person("TODO", _PLACEHOLDER),),
        license=license_ or UNKNOWN_LICENSE,
        missing=tuple(missing),
    )


def _table(path: Path) -> dict[str, Any]:
    if not is_file(path):
        return {}
    try:
        return parse(read_file(path).decode(), shown(path))
    except (OSError, UnreadableError, UnicodeError, TomlError) as error:
        raise ToolError(f"cannot read {shown(path)}: {error}") from error


def _text(table: Mapping[str, Any], key: str) -> str:
    value = table.get(key)
    return " ".join(value.split()) if isinstance(value, str) else ""


def _people(table: Mapping[str, Any]) -> Iterator[Person]:
    """Yield maintainers with an address, else authors."""
    for key in ("maintainers", "authors"):
        entries = table.get(key)
        found = [
            Person(_text(each, "name") or _text(each, "email"), _text(each, "email"))
            for each in (entries if isinstance(entries, list) else ())
            if isinstance(each, dict) and _text(each, "email")
        ]
        if found:
            yield from found
            return


def _license(table: Mapping[str, Any]) -> str:
    """Return the licence: an expression, or the text of a table, if it is one line."""
    value = table.get("license")
    if isinstance(value, dict):
        value = value.get("text")
    return value.strip() if isinstance(value, str) and "\n" not in value.strip() else ""


def _version(text: str) -> str:
    """Return three numbers, as `package.xml` has them, of a version (PEP 440)."""
    match = _RELEASE.match(text)
    numbers = _NUMBERS.findall(match[1]) if match else ["0", "1"]
    return ".".join(str(int(each)) for each in [*numbers, "0", "0"][:3])
