"""Converts profiles between YAML, as written by rtc-template and rtshell, and XML.

A key is an attribute or element in lower camel case; those of an extension's namespace have its
prefix (`rtcDoc::doc`, `rtsExt::visible`), except inside an element of the same namespace.
Elements that may be repeated are lists, dates are mappings of numbers. Every value is a text:
YAML's numbers and booleans are not interpreted. Aliases are rejected.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any
from xml.sax.saxutils import escape, quoteattr

from rtgen.diagnostics import InputError, Rule, Severity, Span
from rtgen.frontends.kit.located_xml import Element

YAML_SUFFIXES = (".yaml", ".yml")

XSI = "http://www.w3.org/2001/XMLSchema-instance"


BAD_YAML = Rule("RTC0545", "not a profile in YAML", Severity.ERROR)
RULES = (BAD_YAML,)

_ACTIONS = (
    "OnInitialize OnFinalize OnStartup OnShutdown OnActivated OnDeactivated OnAborting"
)
_MORE_ACTIONS = (
    "OnError OnReset OnExecute OnStateUpdate OnRateChanged OnAction OnModeChanged"
)
_STEPS = "StartUp ShutDown Activation Deactivation Resetting Initializing Finalizing"


@dataclass(frozen=True, slots=True)
class _Form:
    """A kind of profile: its root, prefixes, and elements in the order of the schema.

    `many` may be repeated, `texts` contain a text, `lower` are the elements whose names start in
    lower case.
    """

    root: str
    key: str
    base: str
    namespaces: Mapping[str, str]
    order: tuple[str, ...]
    many: frozenset[str]
    texts: frozenset[str]
    lower: frozenset[str]
    types: Mapping[str, str]


def _words(*texts: str) -> tuple[str, ...]:
    return tuple(word for text in texts for word in text.split())


_NAMESPACE = "http://www.openrtp.org/namespaces/"
_COMPARISONS = " ".join(
    f"propertyIs{name}"
    for name in (
        *("EqualTo", "NotEqualTo", "LessThan", "GreaterThan", "LessThanOrEqualTo"),
        *("GreaterThanOrEqualTo", "Between", "Like", "NullType"),
    )
)

_RTC = _Form(
    root="RtcProfile",
    key="rtcProfile",
    base="rtc",
    namespaces={
        "rtc": f"{_NAMESPACE}rtc",
        "rtcExt": f"{_NAMESPACE}rtc_ext",
        "rtcDoc": f"{_NAMESPACE}rtc_doc",
    },
    order=_words(
        "BasicInfo Actions ConfigurationSet DataPorts ServicePorts Parameters Language",
        f"{_ACTIONS} {_MORE_ACTIONS} Configuration ServiceInterface TransMethods",
        "Constraint ConstraintUnitType ConstraintListType ConstraintHashType Not And Or",
        f"{_COMPARISONS} Literal LowerBoundary UpperBoundary Event",
        "Doc VersionUpLogs targets osVersions cpus libraries Properties",
    ),
    many=frozenset(
        _words(
            "DataPorts ServicePorts Parameters Configuration ServiceInterface TransMethods",
            "Event VersionUpLogs targets osVersions cpus libraries Properties",
        )
    ),
    texts=frozenset(
        _words("Literal LowerBoundary UpperBoundary VersionUpLogs osVersions cpus")
    ),
    lower=frozenset(_words(f"targets osVersions cpus libraries {_COMPARISONS}")),
    types={
        "BasicInfo": "rtcExt:basic_info_ext",
        "Configuration": "rtcExt:configuration_ext",
        "DataPorts": "rtcExt:dataport_ext",
        "ServicePorts": "rtcExt:serviceport_ext",
        "ServiceInterface": "rtcExt:serviceinterface_ext",
        "Language": "rtcExt:language_ext",
        **dict.fromkeys(_words(_ACTIONS, _MORE_ACTIONS), "rtcDoc:action_status_doc"),
    },
)

_RTS = _Form(
    root="RtsProfile",
    key="rtsProfile",
    base="rts",
    namespaces={"rts": f"{_NAMESPACE}rts", "rtsExt": f"{_NAMESPACE}rts_ext"},
    order=_words(
        f"Components Groups DataPortConnectors ServicePortConnectors {_STEPS}",
        "DataPorts ServicePorts ConfigurationSets ConfigurationData ExecutionContexts",
        "Participants Participant Location Members sourceDataPort targetDataPort",
        "sourceServicePort targetServicePort targets WaitTime Preceding",
        "PrecedingComponents TargetComponent VersionUpLogs Properties",
    ),
    many=frozenset(
        _words(
            "Components Groups DataPortConnectors ServicePortConnectors DataPorts",
            "ServicePorts ConfigurationSets ConfigurationData ExecutionContexts",
            "Participants Members targets PrecedingComponents VersionUpLogs Properties",
        )
    ),
    texts=frozenset(_words("VersionUpLogs")),
    lower=frozenset(
        _words(
            "sourceDataPort targetDataPort sourceServicePort targetServicePort targets"
        )
    ),
    types={
        "Components": "rtsExt:component_ext",
        "DataPorts": "rtsExt:dataport_ext",
        "ServicePorts": "rtsExt:serviceport_ext",
        "ExecutionContexts": "rtsExt:execution_context_ext",
        "DataPortConnectors": "rtsExt:dataport_connector_ext",
        "ServicePortConnectors": "rtsExt:serviceport_connector_ext",
        **dict.fromkeys(
            _words("sourceDataPort targetDataPort sourceServicePort targetServicePort"),
            "rtsExt:target_port_ext",
        ),
        "targets": "rtsExt:condition_ext",
    },
)

_FORMS = (_RTC, _RTS)
_DATES = ("creationDate", "updateDate")
_DATE = re.compile(
    r"(?P<year>\d{4,})-(?P<month>\d\d)-(?P<day>\d\d)"
    r"T(?P<hour>\d\d):(?P<minute>\d\d):(?P<second>\d\d)"
    r"(?P<fraction>\.\d+)?(?P<zone>Z|[+-]\d\d:\d\d)?"
)
_DATE_PARTS = ("year", "month", "day", "hour", "minute", "second")
_DATE_REST = ("fraction", "zone")
_MANY_CONSTRAINTS = ("And", "Or", "ConstraintListType", "ConstraintHashType")
_NAME = re.compile(r"[A-Za-z_][\w.-]*")
_MAX_DEPTH = 60
_MAX_LENGTH = 1024 * 1024


# XML to YAML.


def to_yaml(root: Element) -> str:
    """Convert a profile to YAML. Raises KeyError for an unknown root."""
    import yaml

    [form] = [f for f in _FORMS if root.name == (f.namespaces[f.base], f.root)]
    text = yaml.safe_dump(
        {form.key: _mapping(form, root)},
        sort_keys=False,
        allow_unicode=True,
        default_flow_style=False,
        width=10_000,
    )
    return str(text)


def _mapping(form: _Form, element: Element) -> dict[str, Any]:
    made: dict[str, Any] = {}
    for name, value in element.attributes.items():
        if name[0] != XSI:
            key = _key(form, name, element.name[0])
            made[key] = _date(value) if name[1] in _DATES else value
    for child in element.children:
        key, local = _key(form, child.name, element.name[0]), child.name[1]
        inside = child.text if local in form.texts else _mapping(form, child)
        if _is_many(form, element.name[1], local):
            made.setdefault(key, []).append(inside)
        else:
            made.setdefault(key, inside)
    return made


def _date(text: str) -> object:
    """The parts of a date; those unknown to rtshell only if present."""
    found = _DATE.fullmatch(text)
    if found is None:
        return text
    parts: dict[str, int | str] = {k: int(found[k]) for k in _DATE_PARTS}
    return parts | {k: found[k] for k in _DATE_REST if found[k]}


def _key(form: _Form, name: tuple[str, str], inside: str) -> str:
    """The key of a name; `inside` is the namespace of the element that has it."""
    namespace, local = name
    key = local[:1].lower() + local[1:]
    for prefix, known in form.namespaces.items():
        if namespace == known and namespace != inside:
            return f"{prefix}::{key}"
    return key


def _is_many(form: _Form, parent: str, local: str) -> bool:
    if local == "Constraint":
        return parent in _MANY_CONSTRAINTS
    return local in form.many


# YAML to XML.


def to_xml(text: str, file: str) -> str:
    """Convert a profile in YAML to XML. Raises InputError with one located diagnostic."""
    content = _loaded(text, file)
    for form in _FORMS:
        root = content.get(form.key) if isinstance(content, dict) else None
        if isinstance(root, dict):
            names = [
                f'xmlns:{prefix}="{uri}"' for prefix, uri in form.namespaces.items()
            ]
            names.append(f'xmlns:xsi="{XSI}"')
            try:
                lines = _element(form, f"{form.base}:{form.root}", root, 0, names)
                body = "\n".join(lines)
            except ValueError as error:
                raise _bad(str(error), file) from None
            return f'<?xml version="1.0" encoding="UTF-8" standalone="yes"?>\n{body}\n'
    raise _bad("there is neither `rtcProfile` nor `rtsProfile`", file)


def _bad(message: str, file: str, line: int = 1, column: int = 1) -> InputError:
    span = Span(file, line, column, line, column + 1)
    return InputError([BAD_YAML.at(span, message)])


def _loaded(text: str, file: str) -> Any:
    import yaml

    class Loader(yaml.BaseLoader):
        """Every value is a text; an alias ends the reading."""

        def compose_node(self, parent: Any, index: Any) -> Any:
            reader: Any = self  # whose methods have no types
            if reader.check_event(yaml.AliasEvent):
                mark = reader.peek_event().start_mark
                raise _bad("an alias", file, *_place(mark))
            return super().compose_node(parent, index)

    if len(text) > _MAX_LENGTH:
        raise _bad(f"it is longer than {_MAX_LENGTH:,} characters", file)
    try:
        return yaml.load(text, Loader=Loader)
    except yaml.MarkedYAMLError as error:
        message = f"not YAML: {error.problem or error.context}"
        raise _bad(message, file, *_place(error.problem_mark)) from None
    except (yaml.YAMLError, RecursionError) as error:
        raise _bad(f"not YAML: {error}", file) from None


def _place(mark: Any) -> tuple[int, int]:
    return (1, 1) if mark is None else (mark.line + 1, mark.column + 1)


def _element(
    form: _Form, name: str, content: Any, depth: int, more: Iterable[str] = ()
) -> Iterator[str]:
    """The lines of an element. Raises ValueError for anything that is no profile."""
    if depth > _MAX_DEPTH:
        raise ValueError(f"`{name}` is nested deeper than any profile is")
    margin = "    " * depth
    local = name.partition(":")[2]
    if not isinstance(content, dict):
        if isinstance(content, list):
            raise ValueError(f"`{name}` stands once only")
        yield f"{margin}<{name}>{escape(_clean(content, name))}</{name}>"
        return
    attributes = list(more)
    if (type_ := form.types.get(local)) is not None:
        attributes.append(f'xsi:type="{type_}"')
    children: list[tuple[str, Any]] = []
    for key, value in content.items():
        prefix, inner = _split(form, key, name.partition(":")[0])
        if inner in _DATES and isinstance(value, dict):
            attributes.append(f"{prefix}:{inner}={quoteattr(_date_text(value))}")
        elif isinstance(value, dict | list) or _element_name(form, inner) in form.texts:
            child = f"{prefix}:{_element_name(form, inner)}"
            items = value if isinstance(value, list) else [value]
            children += [(child, item) for item in items]
        else:
            attributes.append(f"{prefix}:{inner}={quoteattr(_clean(value, inner))}")
    head = " ".join((name, *attributes))
    if not children:
        yield f"{margin}<{head}/>"
        return
    yield f"{margin}<{head}>"
    known = {word: place for place, word in enumerate(form.order)}
    children.sort(key=lambda pair: known.get(pair[0].partition(":")[2], len(known)))
    for child, item in children:
        yield from _element(form, child, item, depth + 1)
    yield f"{margin}</{name}>"


def _split(form: _Form, key: str, inside: str) -> tuple[str, str]:
    """Prefix and name of a key. Raises ValueError for an invalid name."""
    prefix, separator, name = key.partition("::")
    if not separator:
        prefix, name = inside, key
    if prefix not in form.namespaces or not _NAME.fullmatch(name):
        raise ValueError(f"{key!r} is no key of a profile")
    return prefix, name


def _element_name(form: _Form, key: str) -> str:
    return key if key in form.lower else key[:1].upper() + key[1:]


def _clean(value: object, name: str) -> str:
    """A text that XML can represent. Raises ValueError."""
    text = str(value)
    if any(ord(c) < 32 and c not in "\t\n\r" for c in text) or "\ufffe" in text:
        raise ValueError(f"`{name}` has a character that XML cannot hold")
    return text


def _date_text(parts: Mapping[str, str]) -> str:
    try:
        year, *rest = (int(parts.get(name) or 0) for name in _DATE_PARTS)
    except (TypeError, ValueError):
        raise ValueError("a date is not made of numbers") from None
    month, day, hour, minute, second = rest
    rest_of_it = "".join(parts.get(name) or "" for name in _DATE_REST)
    return (
        f"{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}{rest_of_it}"
    )
