"""Reads and validates `rtgen.toml`, with the place of every key."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

from rtgen.compiler.diagnostics import (
    Diagnostic,
    InputError,
    Span,
    ToolError,
    has_errors,
)
from rtgen.compiler.kit.toml_text import TomlError, parse
from rtgen.compiler.kit.translation import LANGUAGES
from rtgen.compiler.project import checks, ros2_checks
from rtgen.compiler.project_rules import (
    FILE_UNREADABLE,
    NO_PLUGIN,
    PATH_MISSING,
    UNKNOWN_KEY,
    WRONG_TYPE,
)
from rtgen.facts.decoded_text import NAMES
from rtgen.facts.encodings import decode
from rtgen.facts.files import UnreadableError, exists, read_file
from rtgen.facts.numeric import FORMS

_HEADER = re.compile(r"\s*\[\s*([^\[\]]+?)\s*\]")
_MAX_BYTES = 1024 * 1024
_PART = r"(?:\"[^\"]*\"|'[^']*'|[\w-]+)"
_KEY = re.compile(rf"\s*((?:{_PART}\s*\.\s*)*)({_PART})\s*=")

SCHEMA: dict[str, dict[str, checks.Check] | checks.Check] = {
    "rtgen": {"language": checks.one_of(*LANGUAGES)},
    "sources": {
        "paths": checks.paths,
        "include": checks.paths,
        "define": checks.macro_definitions,
        "ignore_case_clashes": checks.flag,
        "prelude": checks.one_of("kernel", "none"),
        "encoding": checks.one_of(*NAMES),
        "kcode": checks.one_of(*NAMES),
    },
    "idl": {"case": checks.one_of("strict", "dds")},
    "output": {
        "dir": checks.path,
        "skeletons": checks.path,
        "package": checks.text,
        "target": checks.one_of("embedded", "openrtm", "small", "typescript"),
        "representation": checks.one_of("cdr", "xcdr2"),
        "extensibility": checks.one_of("final", "appendable", "mutable"),
    },
    "run": {
        "system": checks.path,
        "clock": checks.one_of("sim", "real", "ros"),
        "until": checks.until,
        "transport": checks.transport,
        "partition": checks.partition,
        "record": checks.path,
    },
    "python": {"numeric": checks.one_of(*FORMS)},
    "tecs": {"corba": checks.flag},
    "small": {"sequence": checks.room, "string": checks.room, "buffer": checks.room},
    "components": checks.factory,
    "adapter": checks.adapter,
    "ros2": {
        "node": ros2_checks.name,
        "namespace": ros2_checks.name,
        "domain": checks.number(0, 232),
        "interface": checks.text,
        "zenoh": checks.path,
        "interfaces": checks.flag,
        "managed_nodes": checks.flag,
        "boards": checks.flag,
        "maintainer": ros2_checks.maintainer,
        "license": checks.text,
        "topics": ros2_checks.topics,
        "tf": ros2_checks.transforms,
        "services": partial(ros2_checks.names, 2, "INSTANCE.PORT.OPERATION", "service"),
        "actions": partial(ros2_checks.names, 1, "INSTANCE.PORT", "action"),
    },
    "templates": {"path": checks.path},
    "diff": {"use": checks.breaks, "against": checks.text, "allow": checks.allowances},
    "fmt": {"line-length": checks.number(20, 1000), "indent": checks.number(1, 16)},
    "lint": {
        "ignore": checks.texts,
        "select": checks.texts,
        "per-file-ignores": checks.patterns,
    },
    "plugin": checks.table,
}
"""The keys of each section, or the check for the values of a section with free keys."""


@dataclass(frozen=True, slots=True)
class Settings:
    """The validated content of an rtgen.toml, with its text and the doubts about that."""

    name: str
    source: str
    content: dict[str, Any]
    problems: tuple[Diagnostic, ...] = ()

    def text(self, section: str, key: str, default: str) -> str:
        """Return a string, or the default."""
        value: str = self.content.get(section, {}).get(key, default)
        return value

    def texts(self, section: str, key: str) -> list[str]:
        """Return a list of strings, empty if missing."""
        value: list[str] = self.content.get(section, {}).get(key, [])
        return value

    def number(self, section: str, key: str, default: int) -> int:
        """Return a number, or the default."""
        value: int = self.content.get(section, {}).get(key, default)
        return value

    def flag(self, section: str, key: str) -> bool:
        """Return a boolean, false if missing."""
        value: bool = self.content.get(section, {}).get(key, False)
        return value

    def table(self, section: str) -> dict[str, str]:
        """Return a section with its values as texts, empty if missing."""
        value = self.content.get(section, {})
        return {name: str(item) for name, item in value.items()}

    def tables(self, section: str) -> dict[str, dict[str, Any]]:
        """Return the tables in a section by name, empty if missing."""
        value: dict[str, dict[str, Any]] = self.content.get(section, {})
        return value

    def macros(self) -> dict[str, str]:
        """Return the macros of `[sources] define`."""
        return checks.macros(self.content.get("sources", {}).get("define", []))

    def span(
        self, section: str, key: str | None = None, item: str | None = None
    ) -> Span:
        """Return the place of a section, of a key in it, or of a string in the key's value."""
        current = ""
        lines = self.source.split("\n")
        for number, line in enumerate(lines, start=1):
            if header := _HEADER.match(line):
                current = header[1].replace('"', "")
                if key is None and current.split(".")[0].strip() == section:
                    return self._span(number, header.start(1), header[1])
                if key is not None and current == f"{section}.{key}":
                    return self._span(number, header.start(1), header[1])
            elif match := _KEY.match(line):
                tables = [current, *re.findall(_PART, match[1])]
                table = ".".join(part.strip("\"'") for part in tables if part)
                span = self._span(number, match.start(2), match[2])
                if (table, match[2].strip("\"'")) == (section, key):
                    return (item and self._item(number, item)) or span
                if not table and match[2].strip("\"'") == section:
                    return span
        return self._span(1, 0, "")

    def table_span(self, section: str, key: str, number: int) -> Span:
        """Return the place of `[[section.key]]`, by number; of the section if written otherwise."""
        header = re.compile(rf"\s*\[\[\s*({section}\s*\.\s*{key})\s*\]\]")
        span = (
            self._span(line, match.start(1), match[1])
            for line, text in enumerate(self.source.split("\n"), start=1)
            if (match := header.match(text))
        )
        return next(islice(span, number, None), None) or self.span(section, key)

    def _item(self, start: int, item: str) -> Span | None:
        for number, line in enumerate(
            self.source.split("\n")[start - 1 :], start=start
        ):
            if (
                number > start
                and _HEADER.match(line)
                and "=" not in line
                and '"' not in line
            ):
                return None
            for quote in "\"'":
                column = line.find(quote + item + quote)
                if column >= 0:
                    return self._span(number, column, f"'{item}'")
        return None

    def _span(self, line: int, start: int, text: str) -> Span:
        return Span(self.name, line, start + 1, line, start + 1 + max(len(text), 1))

    def check_paths(self, root: Path) -> Iterator[Diagnostic]:
        """Yield diagnostics for missing paths of `[sources]`."""
        for key in ("paths", "include"):
            for path in self.texts("sources", key):
                if not exists(root / path):
                    yield PATH_MISSING.at(
                        self.span("sources", key, path), f"no file or folder {path!r}"
                    )


def read(file: Path, name: str) -> Settings:
    """Read and validate the file; `name` is its displayed path. Raises InputError."""
    try:
        data = read_file(file, _MAX_BYTES)
    except UnreadableError as error:
        raise ToolError(f"cannot read {name}: {error}") from error
    decoded = decode(data, standard=True)
    try:
        content = parse(decoded.normal, name)
    except TomlError as error:
        raise InputError(
            [FILE_UNREADABLE.at(error.span, str(error), hint=error.hint)]
        ) from None
    problems: Sequence[Diagnostic] = ()
    if decoded.encoding != "utf8" or decoded.doubt is not None:
        # Front ends are imported only if they are needed.
        from rtgen.compiler.frontends.kit import characters

        problems = characters.read(data, name, standard="TOML").problems
    settings = Settings(name, decoded.normal, content, tuple(problems))
    findings = [*_check(settings)] or [*_check_plugins(settings)]
    if has_errors(findings):
        raise InputError(findings)
    return replace(settings, problems=(*problems, *findings))


def _check_plugins(settings: Settings) -> Iterator[Diagnostic]:
    """Yield diagnostics for options of plug-ins that are not installed."""
    tables = settings.tables("plugin")
    if not tables:
        return
    from rtgen.compiler.kit import plugins

    installed = dict.fromkeys(each.name for each in plugins.announced(*plugins.Group))
    for name in tables:
        if name not in installed:
            hint = checks.did_you_mean(name, installed) if installed else None
            is_misspelt = hint is not None and hint.startswith("did")
            rule = UNKNOWN_KEY if is_misspelt else NO_PLUGIN
            message = f"no plug-in {name!r} is installed, so its options do nothing"
            yield rule.at(settings.span("plugin", name), message, hint=hint)


def _check(settings: Settings) -> Iterator[Diagnostic]:
    for section, content in settings.content.items():
        schema = SCHEMA.get(section)
        if schema is None:
            yield UNKNOWN_KEY.at(
                settings.span(section),
                f"unknown section {section!r}",
                hint=checks.did_you_mean(section, SCHEMA),
            )
        elif not isinstance(content, dict):
            yield WRONG_TYPE.at(
                settings.span(section), f"{section!r} must be a section"
            )
        else:
            for key, value in content.items():
                yield from _check_key(settings, section, key, value, schema)


def _check_key(
    settings: Settings,
    section: str,
    key: str,
    value: Any,
    schema: dict[str, checks.Check] | checks.Check,
) -> Iterator[Diagnostic]:
    check = schema.get(key) if isinstance(schema, dict) else schema
    if check is None:
        assert isinstance(schema, dict)
        yield UNKNOWN_KEY.at(
            settings.span(section, key),
            f"unknown key {key!r} in [{section}]",
            hint=checks.did_you_mean(key, schema),
        )
    elif (problem := check(value)) is not None:
        span = settings.span(section, key)
        if isinstance(problem, checks.Problem):
            span = settings.span(f"{section}.{key}", problem.entry, problem.item)
        hint = getattr(problem, "hint", None)
        yield WRONG_TYPE.at(span, f"{key!r} in [{section}] {problem}", hint=hint)
