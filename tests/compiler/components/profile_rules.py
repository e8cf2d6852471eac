"""The rules of the RtcProfile schema, version 0.3, and of its readers: elements, order, attributes.

Source: the facts on RtcProfile XML, part 1.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field

from lxml import etree

NAMESPACES = {
    "rtc": "http://www.openrtp.org/namespaces/rtc",
    "rtcExt": "http://www.openrtp.org/namespaces/rtc_ext",
    "rtcDoc": "http://www.openrtp.org/namespaces/rtc_doc",
    "xsi": "http://www.w3.org/2001/XMLSchema-instance",
}
TEXT = re.compile(r"(?s).*")
FILLED = re.compile(r"(?s).+")
TRUTH = re.compile("true|false")
DATE = re.compile(
    r"-?\d{4,}-(0[1-9]|1[0-2])-(0[1-9]|[12]\d|3[01])"
    r"T([01]\d|2[0-3]):[0-5]\d:[0-5]\d(\.\d+)?(Z|[+-]\d\d:\d\d)?"
)
DOUBLE = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?")
COUNT = re.compile(r"\d{1,10}")
WIDGET = re.compile(
    r"text|(slider|spin)\.(\d+\.?\d*|\.\d+)|spin\.?|radio|checkbox|orde?red_list"
)
MANY = 1_000_000


@dataclass(frozen=True)
class Rule:
    """An element: its `xsi:type`, attributes with their values, children in order with counts.

    An attribute whose name begins with `!` is required.
    """

    type: str = ""
    attributes: dict[str, re.Pattern[str]] = field(default_factory=dict)
    children: dict[str, tuple[int, int]] = field(default_factory=dict)


def one_of(words: str) -> re.Pattern[str]:
    return re.compile("|".join(words.split()))


def texts(names: str) -> dict[str, re.Pattern[str]]:
    return dict.fromkeys(names.split(), TEXT)


ACTIONS = [
    f"On{name}"
    for name in (
        *("Initialize", "Finalize", "Startup", "Shutdown", "Activated", "Deactivated"),
        *("Aborting", "Error", "Reset", "Execute", "StateUpdate", "RateChanged"),
        *("Action", "ModeChanged"),
    )
]
COMPARISONS = [
    f"propertyIs{name}"
    for name in (
        *("EqualTo", "NotEqualTo", "LessThan", "GreaterThan"),
        *("LessThanOrEqualTo", "GreaterThanOrEqualTo"),
    )
]
UNITS = ["Not", "And", "Or", *COMPARISONS]
UNITS += ["propertyIsBetween", "propertyIsLike", "propertyIsNullType"]
KINDS = ["ConstraintUnitType", "ConstraintListType", "ConstraintHashType"]
DOCS = {
    "BasicInfo": "description inout algorithm creator license reference",
    **dict.fromkeys(ACTIONS, "description preCondition postCondition"),
    "Configuration": "dataname defaultValue description unit range constraint",
    "DataPorts": "description type number semantics unit occerrence operation",
    "ServicePorts": "description ifdescription",
    "ServiceInterface": (
        "description docArgument docReturn docException docPreCondition docPostCondition"
    ),
}
PROPERTIES = (0, MANY)
POSITION = {"rtcExt:position": one_of("LEFT RIGHT TOP BOTTOM")}

RULES = {
    "rtc:RtcProfile": Rule(
        attributes={"!rtc:id": FILLED, "!rtc:version": one_of(r"0\.2 0\.3")},
        children={
            "rtc:BasicInfo": (1, 1),
            "rtc:Actions": (1, 1),
            "rtc:ConfigurationSet": (0, 1),
            "rtc:DataPorts": (0, MANY),
            "rtc:ServicePorts": (0, MANY),
            "rtc:Parameters": (0, MANY),
            "rtc:Language": (0, 1),
        },
    ),
    "rtc:BasicInfo": Rule(
        "rtcExt:basic_info_ext",
        {
            "!rtc:name": FILLED,
            "!rtc:componentType": one_of("STATIC UNIQUE COMMUTATIVE"),
            "!rtc:activityType": one_of("PERIODIC SPORADIC EVENTDRIVEN"),
            "!rtc:componentKind": FILLED,
            "!rtc:category": TEXT,
            "!rtc:vendor": TEXT,
            "!rtc:version": FILLED,
            "!rtc:executionType": FILLED,
            "!rtc:creationDate": DATE,
            "!rtc:updateDate": DATE,
            "rtc:executionRate": DOUBLE,
            "rtc:maxInstances": COUNT,
            **texts("rtc:rtcType rtc:description rtc:abstract rtc:hardwareProfile"),
            **texts("rtcExt:saveProject rtcExt:comment"),
        },
        {
            "rtcDoc:Doc": (0, 1),
            "rtcExt:VersionUpLogs": (0, MANY),
            "rtcExt:Properties": PROPERTIES,
        },
    ),
    "rtc:Actions": Rule(children={f"rtc:{name}": (0, 1) for name in ACTIONS}),
    **{
        f"rtc:{name}": Rule(
            "rtcDoc:action_status_doc",
            {"!rtc:implemented": TRUTH},
            {"rtcDoc:Doc": (0, 1)},
        )
        for name in ACTIONS
    },
    "rtc:ConfigurationSet": Rule(children={"rtc:Configuration": (0, MANY)}),
    "rtc:Configuration": Rule(
        "rtcExt:configuration_ext",
        {
            "!rtc:name": FILLED,
            "!rtc:type": FILLED,
            "!rtc:defaultValue": TEXT,
            **texts("rtc:unit rtcExt:variableName rtcExt:comment"),
        },
        {
            "rtc:Constraint": (0, 1),
            "rtcDoc:Doc": (0, 1),
            "rtcExt:Properties": PROPERTIES,
        },
    ),
    "rtc:DataPorts": Rule(
        "rtcExt:dataport_ext",
        {
            "!rtc:portType": one_of("DataInPort DataOutPort EventPort"),
            "!rtc:name": FILLED,
            "!rtc:type": FILLED,
            **texts("rtc:idlFile rtc:interfaceType rtc:dataflowType"),
            **texts("rtc:subscriptionType rtc:unit rtcExt:variableName"),
            **POSITION,
            **texts("rtcExt:comment"),
        },
        {
            "rtc:Constraint": (0, 1),
            "rtc:Event": (0, MANY),
            "rtcDoc:Doc": (0, 1),
            "rtcExt:Properties": PROPERTIES,
        },
    ),
    "rtc:ServicePorts": Rule(
        "rtcExt:serviceport_ext",
        {"!rtc:name": FILLED, **POSITION, **texts("rtcExt:comment")},
        {
            "rtc:ServiceInterface": (0, MANY),
            "rtc:TransMethods": (0, MANY),
            "rtcDoc:Doc": (0, 1),
            "rtcExt:Properties": PROPERTIES,
        },
    ),
    "rtc:ServiceInterface": Rule(
        "rtcExt:serviceinterface_ext",
        {
            "!rtc:name": FILLED,
            "!rtc:direction": one_of("Provided Required"),
            "!rtc:type": FILLED,
            **texts("rtc:instanceName rtc:idlFile rtcExt:variableName"),
        },
        {"rtcDoc:Doc": (0, 1)},
    ),
    "rtc:Language": Rule(
        "rtcExt:language_ext",
        {"!rtc:kind": one_of(r"C\+\+ Python Java Lua Processing")},
        {"rtcExt:targets": (0, MANY)},
    ),
    "rtcExt:Properties": Rule(
        attributes={"!rtcExt:name": FILLED, "rtcExt:value": TEXT}
    ),
    # Constraints: elements with exactly one of several children.
    "rtc:Constraint": Rule(children={f"rtc:{kind}": (0, 1) for kind in KINDS}),
    "rtc:ConstraintUnitType": Rule(
        attributes=texts("rtc:key"), children={f"rtc:{name}": (0, 1) for name in UNITS}
    ),
    "rtc:ConstraintListType": Rule(children={"rtc:Constraint": (0, MANY)}),
    "rtc:ConstraintHashType": Rule(children={"rtc:Constraint": (0, MANY)}),
    "rtc:Not": Rule(children={"rtc:Constraint": (1, 1)}),
    "rtc:And": Rule(children={"rtc:Constraint": (2, MANY)}),
    "rtc:Or": Rule(children={"rtc:Constraint": (2, MANY)}),
    **{
        f"rtc:{name}": Rule(
            attributes={"!rtc:matchCase": TRUTH}, children={"rtc:Literal": (1, 1)}
        )
        for name in COMPARISONS
    },
    "rtc:propertyIsBetween": Rule(
        children={"rtc:LowerBoundary": (1, 1), "rtc:UpperBoundary": (1, 1)}
    ),
    **dict.fromkeys(("rtc:Literal", "rtc:LowerBoundary", "rtc:UpperBoundary"), Rule()),
}
EXACTLY_ONE = ("rtc:Constraint", "rtc:ConstraintUnitType")
_PREFIXES = {uri: prefix for prefix, uri in NAMESPACES.items()}


def check_schema(root: etree._Element) -> None:
    """Assert that a profile satisfies all rules."""
    broken = sorted(set(broken_rules(root)))
    assert not broken, broken


def broken_rules(root: etree._Element) -> Iterable[str]:
    """Yield the violations of the rules, as texts."""
    if dict(root.nsmap) != NAMESPACES:
        yield "the prefixes are not the usual ones"
    if _name(root) != "rtc:RtcProfile":
        yield "the root is another element"
        return
    for element in root.iter("{*}*"):
        if len(element.nsmap) != len(NAMESPACES):
            yield f"{_name(element)} declares a prefix of its own"
        yield from _element(element)
    yield from _whole(root)


def _element(element: etree._Element) -> Iterable[str]:
    name = _name(element)
    rule = _rule(element, name)
    if rule is None:
        yield f"{name} is not an element of a profile"
        return
    found = {_qualified(str(key)): str(value) for key, value in element.attrib.items()}
    if found.pop("xsi:type", "") != rule.type:
        yield f"{name} has not the type {rule.type or 'none'}"
    required = {key[1:] for key in rule.attributes if key.startswith("!")}
    for key in required - found.keys():
        yield f"{name} has no {key}"
    known = {key.lstrip("!"): value for key, value in rule.attributes.items()}
    for key, value in found.items():
        if key not in known:
            yield f"{name} has the attribute {key}"
        elif not known[key].fullmatch(value):
            yield f"{key} of {name} is {value!r}"
    yield from _children(element, name, rule)


def _children(element: etree._Element, name: str, rule: Rule) -> Iterable[str]:
    children = [_name(child) for child in element.iterchildren("{*}*")]
    order = list(rule.children)
    if unknown := set(children) - set(order):
        yield f"{name} holds {', '.join(sorted(unknown))}"
        return
    places = [order.index(child) for child in children]
    if places != sorted(places):
        yield f"the children of {name} are not in order"
    counts = Counter(children)
    for child, (least, most) in rule.children.items():
        if not least <= counts[child] <= most:
            yield f"{name} holds {counts[child]} {child}"
    if name in EXACTLY_ONE and len(children) != 1:
        yield f"{name} holds {len(children)} elements"
    if not rule.children and name.startswith("rtc:") and "Literal" in name:
        yield from [] if (element.text or "").strip() else [f"{name} is empty"]


def _rule(element: etree._Element, name: str) -> Rule | None:
    if name != "rtcDoc:Doc":
        return RULES.get(name)
    parent = element.getparent()
    assert parent is not None
    known = DOCS.get(_name(parent).partition(":")[2])
    if known is None:
        return None
    return Rule(attributes=texts(" ".join(f"rtcDoc:{word}" for word in known.split())))


def _whole(root: etree._Element) -> Iterable[str]:
    """Yield violations of consistency between elements."""
    info = root.find("rtc:BasicInfo", NAMESPACES)
    if info is None:
        return
    parts = [_get(info, word) for word in ("vendor", "category", "name", "version")]
    if _get(root, "id") != ":".join(("RTC", *parts)):
        yield "the id is not that of BasicInfo"
    for element in root.iterfind(".//rtc:Configuration", NAMESPACES):
        yield from _widget(element)
    for element in root.iterfind(".//rtc:ConstraintHashType/*/*", NAMESPACES):
        if not _get(element, "key"):
            yield "a unit in a hash has no key"
    ports = root.findall("rtc:DataPorts", NAMESPACES)
    for what, names in (
        ("data ports", [(_get(p, "portType"), _get(p, "name")) for p in ports]),
        ("service ports", _names(root, "rtc:ServicePorts")),
        ("parameters", _names(root, ".//rtc:Configuration")),
    ):
        if len(set(names)) != len(names):
            yield f"two {what} have one name"


def _widget(element: etree._Element) -> Iterable[str]:
    key = f"{{{NAMESPACES['rtcExt']}}}"
    widgets = [
        each.get(f"{key}value", "")
        for each in element.iterfind("rtcExt:Properties", NAMESPACES)
        if each.get(f"{key}name") == "__widget__"
    ]
    if len(widgets) != 1 or not WIDGET.fullmatch(widgets[0]):
        yield f"the widget is {widgets}"
        return
    text = etree.tostring(element).decode()
    ranged = "propertyIsBetween" in text or "<rtc:And>" in text
    if widgets[0].startswith(("slider", "spin")) and not ranged:
        yield f"{widgets[0]} without a range"
    if widgets[0] in ("radio", "checkbox", "ordered_list"):
        yield from [] if "propertyIsEqualTo" in text else ["a choice of nothing"]


def _names(root: etree._Element, path: str) -> list[tuple[str, str]]:
    return [("", _get(each, "name")) for each in root.iterfind(path, NAMESPACES)]


def _get(element: etree._Element, name: str) -> str:
    return element.get(f"{{{NAMESPACES['rtc']}}}{name}", "")


def _name(element: etree._Element) -> str:
    return _qualified(str(element.tag))


def _qualified(tag: str) -> str:
    namespace, _, local = tag.rpartition("}")
    return f"{_PREFIXES.get(namespace[1:], '?')}:{local}"
