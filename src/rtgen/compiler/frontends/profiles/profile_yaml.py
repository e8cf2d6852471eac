"""Converts profiles in YAML, as written by rtc-template and rtshell, to a tree, and from and to
XML.

A key is an attribute or element in lower camel case; those of an extension's namespace have its
prefix (`rtcDoc::doc`, `rtsExt::visible`), except inside an element of the same namespace. Elements
that can be repeated are lists, dates are mappings of numbers.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from rtgen.compiler.diagnostics import InputError, Span
from rtgen.compiler.frontends.kit import located_yaml
from rtgen.compiler.frontends.kit.located_xml import Element
from rtgen.compiler.frontends.kit.located_yaml import Node, YamlError
from rtgen.compiler.frontends.profiles.rules import BAD_YAML
from rtgen.compiler.model.profile_elements import XSI

YAML_SUFFIXES = (".yaml", ".yml")

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

    `many` can be repeated, `texts` contain a text, `lower` are the elements whose names start in
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
_CONDITIONS = ("WaitTime", "Preceding")
_CONDITION = "condition"
"""In YAML, the key of `targets` around the condition of a step."""
_MANY_CONSTRAINTS = ("And", "Or", "ConstraintListType", "ConstraintHashType")
_NAME = re.compile(r"[A-Za-z_][\w.-]*")
_MAX_DEPTH = 60


# XML to YAML.


class ProfileTree(Protocol):
    """An element of a profile; names are `(namespace, local name)`."""

    @property
    def name(self) -> tuple[str, str]: ...
    @property
    def attributes(self) -> Mapping[tuple[str, str], str]: ...
    @property
    def children(self) -> Sequence[ProfileTree]: ...
    @property
    def text(self) -> str: ...


def yaml_content(root: ProfileTree) -> dict[str, Any]:
    """Return the content of a profile in YAML. Raises ValueError for an unknown root."""
    [form] = [f for f in _FORMS if root.name == (f.namespaces[f.base], f.root)]
    return {form.key: _mapping(form, root)}


def to_yaml(root: ProfileTree) -> str:
    """Convert a profile to YAML. Raises ValueError for an unknown root."""
    import yaml

    text = yaml.safe_dump(
        yaml_content(root),
        sort_keys=False,
        allow_unicode=True,
        default_flow_style=False,
        width=10_000,
    )
    return str(text)


def _mapping(form: _Form, element: ProfileTree) -> dict[str, Any]:
    mapping: dict[str, Any] = {}
    for name, value in element.attributes.items():
        if name[0] != XSI:
            key = _key(form, name, element.name[0])
            mapping[key] = _date(value) if name[1] in _DATES else value
    for child in element.children:
        key, local = _key(form, child.name, element.name[0]), child.name[1]
        inside = child.text if local in form.texts else _mapping(form, child)
        if element.name[1] == "targets" and local in _CONDITIONS:
            key, inside = _CONDITION, {key: inside}
            local = _CONDITION
        if _is_many(form, element.name[1], local):
            mapping.setdefault(key, []).append(inside)
        else:
            mapping.setdefault(key, inside)
    return mapping


def _date(text: str) -> object:
    """Return the parts of a date; those unknown to rtshell only if present."""
    match = _DATE.fullmatch(text)
    if match is None:
        return text
    parts: dict[str, int | str] = {k: int(match[k]) for k in _DATE_PARTS}
    return parts | {k: match[k] for k in _DATE_REST if match[k]}


def _key(form: _Form, name: tuple[str, str], inside: str) -> str:
    """Return the key of a name; `inside` is the namespace of the parent element."""
    namespace, local = name
    key = local[:1].lower() + local[1:]
    for prefix, uri in form.namespaces.items():
        if namespace == uri and namespace != inside:
            return f"{prefix}::{key}"
    return key


def _is_many(form: _Form, parent: str, local: str) -> bool:
    if local == "Constraint":
        return parent in _MANY_CONSTRAINTS
    return local in form.many


# YAML to XML.


def parse(text: str, file: str) -> Element:
    """Parse a profile in YAML; the tree has the places of the YAML text.

    Raises InputError with one located diagnostic.
    """
    try:
        root = located_yaml.parse(text, file)
        for form in _FORMS:
            content = root.content
            body = content.get(form.key) if isinstance(content, Mapping) else None
            if body is not None and isinstance(body.content, Mapping):
                name = (form.namespaces[form.base], form.root)
                return _element(form, name, body, 0)
        raise YamlError("there is neither `rtcProfile` nor `rtsProfile`", root.span)
    except YamlError as error:
        raise InputError([BAD_YAML.at(error.span, str(error))]) from None


def _element(form: _Form, name: tuple[str, str], node: Node, depth: int) -> Element:
    """Return an element. Raises YamlError for invalid content."""
    namespace, local = name
    content = node.content
    if depth > _MAX_DEPTH:
        raise YamlError(f"`{local}` is nested deeper than any profile is", node.key)
    if isinstance(content, str):
        return Element(name, {}, node.key, text=_text(content, local, node))
    if isinstance(content, tuple):
        raise YamlError(f"`{local}` may occur only once", node.key)
    attributes: dict[tuple[str, str], str] = {}
    places: dict[str, Span] = {}
    children: list[Element] = []
    if (type_ := form.types.get(local)) is not None:
        attributes[XSI, "type"] = type_
    for key, value in _items(content, local):
        inside, inner = _split(form, key, value.key, namespace)
        inner_content = value.content
        child = inner if inner in form.lower else inner[:1].upper() + inner[1:]
        if inner in _DATES and isinstance(inner_content, Mapping):
            text = _date_text(inner_content, value)
        elif not isinstance(inner_content, str) or child in form.texts:
            items = inner_content if isinstance(inner_content, tuple) else (value,)
            children += [_element(form, (inside, child), i, depth + 1) for i in items]
            continue
        else:
            text = _text(inner_content, inner, value)
        if (inside, inner) in attributes:
            raise YamlError(f"`{inner}` is given twice", value.key)
        attributes[inside, inner] = text
        places.setdefault(inner, value.span)
    order = {word: place for place, word in enumerate(form.order)}
    children.sort(key=lambda child: order.get(child.name[1], len(order)))
    return Element(name, attributes, node.key, children, _places=places)


def _items(content: Mapping[str, Node], local: str) -> Iterator[tuple[str, Node]]:
    """Yield the keys and values of an element, without the level around conditions."""
    for key, value in content.items():
        inner = value.content
        if local == "targets" and key == _CONDITION and isinstance(inner, Mapping):
            yield from inner.items()
        else:
            yield key, value


def _split(form: _Form, key: str, span: Span, inside: str) -> tuple[str, str]:
    """Return namespace and name of a key. Raises YamlError for an invalid one."""
    prefix, separator, name = key.partition("::")
    if not separator:
        prefix, name = "", key
    namespace = form.namespaces.get(prefix) if separator else inside
    if namespace is None or not _NAME.fullmatch(name):
        raise YamlError(f"{key!r} is not a key of a profile", span)
    return namespace, name


def _text(text: str, name: str, node: Node) -> str:
    """Return a text, checked for characters that XML cannot represent. Raises YamlError."""
    from rtgen.compiler.kit.xml_text import NOT_IN_XML

    if NOT_IN_XML.search(text):
        raise YamlError(f"`{name}` has a character that XML cannot hold", node.span)
    return text


def _date_text(parts: Mapping[str, Node], node: Node) -> str:
    texts = {
        name: part.content
        for name, part in parts.items()
        if isinstance(part.content, str)
    }
    try:
        year, *rest = (int(texts.get(name) or 0) for name in _DATE_PARTS)
    except ValueError:
        raise YamlError("a date must consist of numbers", node.span) from None
    month, day, hour, minute, second = rest
    more = "".join(texts.get(name) or "" for name in _DATE_REST)
    date = f"{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}{more}"
    return _text(date, "date", node)


def to_xml(text: str, file: str) -> str:
    """Convert a profile in YAML to XML. Raises InputError with one located diagnostic."""
    from rtgen.compiler.kit.xml_text import document

    root = parse(text, file)
    [form] = [f for f in _FORMS if root.name == (f.namespaces[f.base], f.root)]
    prefixes = {uri: prefix for prefix, uri in form.namespaces.items()} | {XSI: "xsi"}
    return document(root, prefixes)
