"""Reads and validates `rtgen.toml`, with the place of every key."""

from __future__ import annotations

import keyword
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
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
from rtgen.compiler.project.ros2 import MAINTAINER
from rtgen.compiler.project.rules import (
    FILE_UNREADABLE,
    NO_PLUGIN,
    PATH_MISSING,
    UNKNOWN_KEY,
    WRONG_TYPE,
)
from rtgen.compiler.project.transport_names import TRANSPORTS
from rtgen.facts import file_names, ros_names, ros_qos_words, ros_transforms
from rtgen.facts.adapter_constants import constants
from rtgen.facts.decoded_text import NAMES
from rtgen.facts.encodings import decode
from rtgen.facts.files import UnreadableError, read_file
from rtgen.facts.numeric import FORMS
from rtgen.facts.ros_marshaling import parse as parse_marshaling

_HEADER = re.compile(r"\s*\[\s*([^\[\]]+?)\s*\]")
_MAX_BYTES = 1024 * 1024
_PART = r"(?:\"[^\"]*\"|'[^']*'|[\w-]+)"
_KEY = re.compile(rf"\s*((?:{_PART}\s*\.\s*)*)({_PART})\s*=")
_MACRO = re.compile(r"[A-Za-z_]\w*", re.ASCII)

Check = Callable[[Any], str | None]
"""Function that returns the error in a value, or None."""


def is_macro(name: str) -> bool:
    """Return whether the name is a valid macro name."""
    return _MACRO.fullmatch(name) is not None


def _text(value: Any) -> str | None:
    return None if isinstance(value, str) and value else "must be a string"


def _texts(value: Any) -> str | None:
    fine = isinstance(value, list) and all(
        isinstance(item, str) and item for item in value
    )
    return None if fine else "must be a list of strings"


def _path(value: Any) -> str | None:
    if problem := _text(value):
        return problem
    wrong = file_names.problem(value)
    return f"must be a path that a file can have: this {wrong}" if wrong else None


def _paths(value: Any) -> str | None:
    if problem := _texts(value):
        return problem
    wrong = next(filter(None, map(file_names.problem, value)), None)
    return f"must be paths that files can have: one {wrong}" if wrong else None


def _flag(value: Any) -> str | None:
    return None if isinstance(value, bool) else "must be true or false"


def macros(value: list[str] | dict[str, str | int]) -> dict[str, str]:
    """Parse macros `NAME` or `NAME=VALUE` as in `-D`, or a table of them."""
    if isinstance(value, dict):
        return {name: str(item) for name, item in value.items()}
    pairs = (text.partition("=") for text in value)
    return {name: body if equals else "1" for name, equals, body in pairs}


def _macros(value: Any) -> str | None:
    fine = _texts(value) is None or (
        isinstance(value, dict) and all(type(v) in (str, int) for v in value.values())
    )
    if not fine:
        return "must be a list of 'NAME=VALUE', or a table of names to values"
    value = macros(value)
    wrong = next((name for name in value if not is_macro(name)), None)
    return None if wrong is None else f"holds {wrong!r}, which is not an identifier"


def _patterns(value: Any) -> str | None:
    fine = isinstance(value, dict) and all(_texts(v) is None for v in value.values())
    return None if fine else "must be a table of patterns of files to lists of codes"


def _one_of(*choices: str) -> Check:
    def check(value: Any) -> str | None:
        fine = isinstance(value, str) and value in choices
        return None if fine else "must be one of " + ", ".join(map(repr, choices))

    return check


def _number(least: int, greatest: int) -> Check:
    def check(value: Any) -> str | None:
        is_number = isinstance(value, int) and not isinstance(value, bool)
        fine = is_number and least <= value <= greatest
        return None if fine else f"must be a number from {least} to {greatest}"

    return check


_room = _number(1, 65535)


def _until(value: Any) -> str | None:
    is_text = isinstance(value, int | float | str) and not isinstance(value, bool)
    return None if is_text else "must be seconds, or 'INSTANCE=STATE'"


def _transport(value: Any) -> str | None:
    if value in TRANSPORTS:
        return None
    from rtgen.compiler.kit import plugins

    names = [each.name for each in plugins.announced(plugins.Group.TRANSPORTS)]
    return None if value in names else _one_of(*TRANSPORTS, *names)(value)


def _partition(value: Any) -> str | None:
    if problem := _text(value):
        return problem
    from rtgen.runtime.distribution.medium import MediumError, check_name

    try:
        check_name(value)
    except MediumError as error:
        return f"is refused: {error}"
    return None


def _factory(value: Any) -> str | None:
    module, colon, name = value.partition(":") if isinstance(value, str) else ("",) * 3
    parts = [*module.split("."), *name.split(".")]
    fine = colon and all(
        part.isascii() and part.isidentifier() and not keyword.iskeyword(part)
        for part in parts
    )
    return None if fine else "must be 'module:attribute'"


def _adapter(value: Any) -> str | None:
    fine = isinstance(value, dict) and {"from", "to"} <= set(value) <= {
        *("from", "to", "map", "set", "units")
    }
    if fine:
        pairs, fixed, units = (value.get(key, {}) for key in ("map", "set", "units"))
        fine = all(isinstance(each, dict) for each in (pairs, fixed, units))
        fine = fine and all(
            isinstance(v, str) for v in (value["from"], value["to"], *pairs.values())
        )
        fine = fine and _is_constants(fixed)
        fine = fine and all(map(_is_pair, units.values()))
    keys = dict.fromkeys(("from", "to", "map", "set", "units"))
    unknown = (
        [key for key in value if key not in keys] if isinstance(value, dict) else []
    )
    if unknown:
        return f"has an unknown key {unknown[0]!r}; {_did_you_mean(unknown[0], keys)}"
    form = (
        'from = "TYPE", to = "TYPE", map = { "MEMBER" = "MEMBER" }, '
        'set = { "MEMBER" = VALUE }, units = { "MEMBER" = ["UNIT", "UNIT"] }'
    )
    return None if fine else f"must be a table: {form}"


def _is_pair(value: Any) -> bool:
    """Return whether the value is a list of two texts."""
    return isinstance(value, list) and [type(each) for each in value] == [str, str]


def _is_constants(value: Any) -> bool:
    """Return whether the value is a table of constants."""
    try:
        constants(value)
    except ValueError:
        return False
    return True


def _ros_name(value: Any) -> str | None:
    problem = (
        "" if not isinstance(value, str) else ros_names.violation(value.strip("/"))
    )
    if value == "/" or problem is None:
        return None
    return f"must be a name of ROS 2, which {problem or 'is a string'}"


def _maintainer(value: Any) -> str | None:
    fine = isinstance(value, str) and MAINTAINER.fullmatch(value)
    return None if fine else "must be 'NAME <EMAIL>'"


class _Problem(str):
    """An error in an entry of a table, with the key of the entry, perhaps a string in it."""

    entry: str
    hint: str | None
    item: str | None

    def __new__(
        cls, text: str, entry: str, hint: str | None = None, item: str | None = None
    ) -> _Problem:
        problem = super().__new__(cls, text)
        problem.entry = entry
        problem.hint = hint
        problem.item = item
        return problem


_TOPIC_KEYS = ("topic", "qos", "marshaling_type", "set", *ros_qos_words.POLICIES)


def _ros_topics(value: Any) -> str | None:
    """Check topics by port; each is a name, or a table with QoS."""
    if not isinstance(value, dict):
        return "must be a table of INSTANCE.PORT to topics"
    problems = (_ros_topic(port, entry) for port, entry in value.items())
    return next((each for each in problems if each is not None), None)


def _ros_topic(port: str, entry: Any) -> _Problem | None:
    if port.count(".") != 1:
        return _Problem(f"holds {port!r}, which is not INSTANCE.PORT", port)
    table = {"topic": entry} if isinstance(entry, str) else entry
    if not isinstance(table, dict) or not isinstance(table.get("topic"), str):
        return _Problem(
            f"holds {port!r}, which must be 'NAME' or {{ topic = 'NAME', qos = 'PROFILE' }}",
            port,
        )
    for key in table:
        if key not in _TOPIC_KEYS:
            hint = _did_you_mean(key, _TOPIC_KEYS)
            return _Problem(f"gives {port!r} the unknown key {key!r}", port, hint)
    if why := ros_names.violation(table["topic"]):
        return _Problem(
            f"gives {port!r} the topic {table['topic']!r}; a name of ROS 2 {why}", port
        )
    marshaling = table.get("marshaling_type", "ros2:std_msgs/String")
    if not isinstance(marshaling, str) or parse_marshaling(marshaling) is None:
        return _Problem(
            f"gives {port!r} the marshaling_type {marshaling!r}, "
            "which is not ros2:PACKAGE/TYPE",
            port,
        )
    if problem := _set_of(table):
        return _Problem(f"gives {port!r} `set`, {problem}", port)
    return _ros_qos(port, table)


def _ros_qos(port: str, table: dict[str, Any]) -> _Problem | None:
    """Check the QoS of a topic."""
    values: dict[str, Any] = {}
    for key in ("qos", *ros_qos_words.POLICIES):
        if key not in table:
            continue
        try:
            values[key] = ros_qos_words.value_of(key, table[key])
        except ValueError as error:
            known = ros_qos_words.words(key)
            text = table[key]
            is_text = isinstance(text, str)
            message = f"gives {port!r} the {key} {text!r}; " + (
                f"known: {', '.join(known)}" if known else f"it must be {error}"
            )
            hint = _near(text, known) if is_text else None
            return _Problem(message, port, hint, text if is_text else None)
    idle = ros_qos_words.contradiction(values)
    if idle is not None:
        why, what = ros_qos_words.WHY[idle]
        return _Problem(f"gives {port!r} a {idle} without effect: {why}", port, what)
    return None


def _set_of(table: dict[str, Any]) -> str | None:
    """Return what is wrong with the constants of a topic."""
    fixed = table.get("set", {})
    if not (isinstance(fixed, dict) and _is_constants(fixed)):
        return "which must be a table of members to texts, numbers, or lists of them"
    if fixed and "marshaling_type" not in table:
        return "which goes with a marshaling_type: other data are sent as they are"
    return None


def _ros_transforms(value: Any) -> str | None:
    """Check transforms by port, and constant ones."""
    if not isinstance(value, dict):
        return "must be a table of INSTANCE.PORT to frames"
    pairs = []
    for key, entry in value.items():
        if key == ros_transforms.STATIC:
            tables = entry if isinstance(entry, list) else [entry]
            for table in tables:
                if why := ros_transforms.static_violation(table):
                    return _Problem(f"holds a constant transform that {why}", key)
                pairs.append((table["parent"], table["child"]))
            continue
        if key.count(".") != 1:
            return _Problem(f"holds {key!r}, which is not INSTANCE.PORT", key)
        if not isinstance(entry, dict) or not set(entry) <= {"parent", "child"}:
            form = '{ parent = "FRAME", child = "FRAME" }'
            return _Problem(f"holds {key!r}, which must be {form}", key)
        for end, frame in entry.items():
            if why := ros_transforms.frame_violation(frame):
                return _Problem(f"gives {key!r} the {end} {frame!r}, which {why}", key)
        pairs.append((entry.get("parent", ""), entry.get("child", "")))
    return ros_transforms.tree_violation(pairs)


def _ros_names(dots: int, form: str, what: str, value: Any) -> str | None:
    """Check services by operation, or actions by port."""
    if not isinstance(value, dict):
        return f"must be a table of {form} to {what}s"
    for key, name in value.items():
        if key.count(".") != dots:
            return _Problem(f"holds {key!r}, which is not {form}", key)
        if not isinstance(name, str):
            return _Problem(f"holds {key!r}, which must be 'NAME'", key)
        if why := ros_names.violation(name):
            return _Problem(
                f"gives {key!r} the {what} {name!r}; a name of ROS 2 {why}", key
            )
    return None


def _table(value: Any) -> str | None:
    return None if isinstance(value, dict) else "must be a table of a plug-in's options"


_BREAKS = ("wire", "source", "stored", "compatible")


def _breaks(value: Any) -> str | None:
    fine = isinstance(value, list) and all(v in _BREAKS for v in value)
    return None if fine else "must be a list of " + ", ".join(map(repr, _BREAKS))


def _allowances(value: Any) -> str | None:
    """Check the allowed breaks: tables of texts."""
    fine = isinstance(value, list) and all(
        isinstance(each, dict)
        and {"code", "reason"} <= each.keys() <= {"code", "reason", "name", "path"}
        and all(isinstance(text, str) and text for text in each.values())
        for each in value
    )
    form = 'code = "DIF...", reason = "TEXT", and perhaps name = "PATTERN", path = "PATTERN"'
    return None if fine else f"must be tables: {form}"


SCHEMA: dict[str, dict[str, Check] | Check] = {
    "sources": {
        "paths": _paths,
        "include": _paths,
        "define": _macros,
        "ignore_case_clashes": _flag,
        "prelude": _one_of("kernel", "none"),
        "encoding": _one_of(*NAMES),
        "kcode": _one_of(*NAMES),
    },
    "idl": {"case": _one_of("strict", "dds")},
    "output": {
        "dir": _path,
        "skeletons": _path,
        "package": _text,
        "target": _one_of("embedded", "openrtm", "small", "typescript"),
        "representation": _one_of("cdr", "xcdr2"),
        "extensibility": _one_of("final", "appendable", "mutable"),
    },
    "run": {
        "system": _path,
        "clock": _one_of("sim", "real", "ros"),
        "until": _until,
        "transport": _transport,
        "partition": _partition,
        "record": _path,
    },
    "python": {"numeric": _one_of(*FORMS)},
    "tecs": {"corba": _flag},
    "small": {"sequence": _room, "string": _room, "buffer": _room},
    "components": _factory,
    "adapter": _adapter,
    "ros2": {
        "node": _ros_name,
        "namespace": _ros_name,
        "domain": _number(0, 232),
        "interface": _text,
        "zenoh": _path,
        "interfaces": _flag,
        "managed_nodes": _flag,
        "boards": _flag,
        "maintainer": _maintainer,
        "license": _text,
        "topics": _ros_topics,
        "tf": _ros_transforms,
        "services": partial(_ros_names, 2, "INSTANCE.PORT.OPERATION", "service"),
        "actions": partial(_ros_names, 1, "INSTANCE.PORT", "action"),
    },
    "templates": {"path": _path},
    "diff": {"use": _breaks, "against": _text, "allow": _allowances},
    "fmt": {"line-length": _number(20, 1000), "indent": _number(1, 16)},
    "lint": {"ignore": _texts, "select": _texts, "per-file-ignores": _patterns},
    "plugin": _table,
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
        return macros(self.content.get("sources", {}).get("define", []))

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
                if not (root / path).exists():
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
            hint = _did_you_mean(name, installed) if installed else None
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
                hint=_did_you_mean(section, SCHEMA),
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
    schema: dict[str, Check] | Check,
) -> Iterator[Diagnostic]:
    check = schema.get(key) if isinstance(schema, dict) else schema
    if check is None:
        assert isinstance(schema, dict)
        yield UNKNOWN_KEY.at(
            settings.span(section, key),
            f"unknown key {key!r} in [{section}]",
            hint=_did_you_mean(key, schema),
        )
    elif (problem := check(value)) is not None:
        span = settings.span(section, key)
        if isinstance(problem, _Problem):
            span = settings.span(f"{section}.{key}", problem.entry, problem.item)
        hint = getattr(problem, "hint", None)
        yield WRONG_TYPE.at(span, f"{key!r} in [{section}] {problem}", hint=hint)


def _did_you_mean(name: str, keys: Iterable[str]) -> str:
    return _near(name, keys) or "known: " + ", ".join(keys)


def _near(name: str, keys: Iterable[str]) -> str | None:
    from difflib import get_close_matches

    close = get_close_matches(name.lower(), keys, n=1)
    return f"did you mean {close[0]!r}?" if close else None
