"""Validates an RtsProfile by rules written from the description of its format."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator

from lxml import etree

RTS = "http://www.openrtp.org/namespaces/rts"
EXT = "http://www.openrtp.org/namespaces/rts_ext"
XSI = "http://www.w3.org/2001/XMLSchema-instance"
PREFIXES = {RTS: "rts", EXT: "rtsExt", XSI: "xsi"}

ANY = re.compile(r"(?s).*")
SOME = re.compile(r"(?s).+")
DATE = re.compile(r"-?\d{4,}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d+)?(Z|[+-]\d\d:\d\d)?")
DOUBLE = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?|-?INF|NaN")
INTEGER = re.compile(r"[+-]?\d+")
FLAG = re.compile("true|false|1|0")
SYSTEM_ID = re.compile(r"RTSystem:[^:]+(:[^:]+){2,}|RTSystem:[^:]+:[^:]+")
COMPONENT_ID = re.compile(r"RTC:[^:]*:[^:]*:[^:]+:[^:]+|RTC:[^:]+:[^:]+")
COMPOSITES = re.compile(
    "None|PeriodicECShared|PeriodicStateShared|Grouping|FsmECShared|FsmStateShared"
)
DIRECTION = re.compile("UP|DOWN|LEFT|RIGHT")
TIMING = re.compile("SYNC|ASYNC")

TARGET = {"rts:componentId": (True, SOME), "rts:instanceName": (True, SOME)}
TARGET_OF_CONTEXT = {**TARGET, "rts:id": (True, INTEGER)}
TARGET_PORT = {**TARGET, "rts:portName": (True, SOME)}
SHOWN = {"rtsExt:visible": (False, FLAG), "rtsExt:comment": (False, ANY)}
STEPS = (
    *("StartUp", "ShutDown", "Activation", "Deactivation", "Resetting"),
    *("Initializing", "Finalizing"),
)

ATTRIBUTES: dict[str, dict[str, tuple[bool, re.Pattern[str]]]] = {
    "rts:RtsProfile": {
        "rts:id": (True, SYSTEM_ID),
        "rts:version": (True, re.compile(r"0\.2")),
        # The reader of rtsprofile 4.1 refuses a system with an empty one.
        "rts:abstract": (True, SOME),
        "rts:creationDate": (True, DATE),
        "rts:updateDate": (True, DATE),
        "rtsExt:comment": (False, ANY),
    },
    "rts:Components": {
        "rts:id": (True, COMPONENT_ID),
        "rts:instanceName": (True, SOME),
        "rts:pathUri": (True, re.compile(r"[^/].*")),
        "rts:compositeType": (True, COMPOSITES),
        "rts:activeConfigurationSet": (False, ANY),
        "rts:isRequired": (True, FLAG),
        **SHOWN,
    },
    "rts:DataPorts": {"rts:name": (True, SOME), **SHOWN},
    "rts:ServicePorts": {"rts:name": (True, SOME), **SHOWN},
    "rts:ConfigurationSets": {"rts:id": (True, SOME)},
    "rts:ConfigurationData": {"rts:name": (True, SOME), "rts:data": (True, ANY)},
    "rts:ExecutionContexts": {
        "rts:id": (True, INTEGER),
        "rts:kind": (True, re.compile("PERIODIC|EVENT_DRIVEN|OTHER")),
        "rts:rate": (False, DOUBLE),
    },
    "rtsExt:Location": {
        **{f"rtsExt:{name}": (True, INTEGER) for name in ("x", "y", "width", "height")},
        "rtsExt:direction": (True, DIRECTION),
    },
    "rtsExt:Properties": {"rtsExt:name": (True, SOME), "rtsExt:value": (False, ANY)},
    "rtsExt:VersionUpLogs": {},
    "rts:Groups": {"rts:groupId": (True, SOME)},
    "rts:Members": TARGET,
    "rts:DataPortConnectors": {
        "rts:connectorId": (True, SOME),
        "rts:name": (True, SOME),
        "rts:dataType": (True, ANY),
        "rts:interfaceType": (True, SOME),
        "rts:dataflowType": (True, re.compile("push|pull|duplex")),
        "rts:subscriptionType": (False, re.compile("|flush|new|periodic")),
        "rts:pushInterval": (False, DOUBLE),
        **SHOWN,
    },
    "rts:ServicePortConnectors": {
        "rts:connectorId": (True, SOME),
        "rts:name": (True, SOME),
        "rts:transMethod": (False, ANY),
        **SHOWN,
    },
    **{
        f"rts:{end}{kind}Port": TARGET_PORT
        for end in ("source", "target")
        for kind in ("Data", "Service")
    },
    **{f"rts:{step}": {} for step in STEPS},
    "rts:targets": {"rts:sequence": (True, INTEGER)},
    "rts:TargetComponent": TARGET_OF_CONTEXT,
    "rts:WaitTime": {"rts:waitTime": (True, re.compile(r"\d+"))},
    "rts:Preceding": {
        "rts:timeout": (False, re.compile(r"\d+")),
        "rts:sendingTiming": (False, TIMING),
    },
    "rts:PrecedingComponents": TARGET_OF_CONTEXT,
}

MANY = (0, 10**9)
ONE = (1, 1)
MAYBE = (0, 1)
PROPERTIES = ("rtsExt:Properties", MANY)
CHILDREN: dict[str, tuple[tuple[str, tuple[int, int]], ...]] = {
    "rts:RtsProfile": (
        ("rts:Components", MANY),
        ("rts:Groups", MANY),
        ("rts:DataPortConnectors", MANY),
        ("rts:ServicePortConnectors", MANY),
        *((f"rts:{step}", MAYBE) for step in STEPS),
        ("rtsExt:VersionUpLogs", MANY),
        PROPERTIES,
    ),
    "rts:Components": (
        ("rts:DataPorts", MANY),
        ("rts:ServicePorts", MANY),
        ("rts:ConfigurationSets", MANY),
        # A component without one is never activated by rtshell.
        ("rts:ExecutionContexts", (1, 10**9)),
        ("rtsExt:Location", ONE),
        PROPERTIES,
    ),
    "rts:DataPorts": (PROPERTIES,),
    "rts:ServicePorts": (PROPERTIES,),
    "rts:ConfigurationSets": (("rts:ConfigurationData", MANY),),
    "rts:ExecutionContexts": (PROPERTIES,),
    "rts:Groups": (("rts:Members", (1, 10**9)),),
    "rts:DataPortConnectors": (
        ("rts:sourceDataPort", ONE),
        ("rts:targetDataPort", ONE),
        PROPERTIES,
    ),
    "rts:ServicePortConnectors": (
        ("rts:sourceServicePort", ONE),
        ("rts:targetServicePort", ONE),
        PROPERTIES,
    ),
    **{
        f"rts:{end}{kind}Port": (PROPERTIES,)
        for end in ("source", "target")
        for kind in ("Data", "Service")
    },
    **{f"rts:{step}": (("rts:targets", MANY),) for step in STEPS},
    "rts:targets": (
        ("rts:WaitTime", MAYBE),
        ("rts:Preceding", MAYBE),
        ("rts:TargetComponent", ONE),
    ),
    "rts:Preceding": (("rts:PrecedingComponents", (1, 10**9)),),
}

TYPES = {
    "rts:RtsProfile": "rts_profile_ext",
    "rts:Components": "component_ext",
    "rts:DataPorts": "dataport_ext",
    "rts:ServicePorts": "serviceport_ext",
    "rts:ExecutionContexts": "execution_context_ext",
    "rts:DataPortConnectors": "dataport_connector_ext",
    "rts:ServicePortConnectors": "serviceport_connector_ext",
    **{
        f"rts:{end}{kind}Port": "target_port_ext"
        for end in ("source", "target")
        for kind in ("Data", "Service")
    },
    "rts:targets": "condition_ext",
}


def broken_rules(text: str) -> list[str]:
    """Return the violations of an RtsProfile, one line each; empty for a valid one."""
    root = etree.fromstring(text.encode())
    if named(root.tag) != "rts:RtsProfile":
        return [f"the root is {root.tag}"]
    found = [rule for element in root.iter(etree.Element) for rule in of(element)]
    return [*found, *references(root)]


def named(tag: str) -> str:
    """Convert `{namespace}name` to the prefix that tools write."""
    name = etree.QName(tag)
    return f"{PREFIXES.get(name.namespace or '', '?')}:{name.localname}"


def of(element: etree._Element) -> Iterator[str]:
    """Yield violations of one element: prefix, attributes, type, children and their order."""
    name = named(element.tag)
    if name not in ATTRIBUTES:
        yield f"unknown element {name}"
        return
    if element.prefix != name.partition(":")[0]:
        yield f"{name} is written with the prefix {element.prefix!r}"
    known = ATTRIBUTES[name]
    given = {named(key): value for key, value in element.attrib.items()}
    type_ = given.pop("xsi:type", None)
    wanted = TYPES.get(name)
    if type_ != (None if wanted is None else f"rtsExt:{wanted}"):
        yield f"{name} has the type {type_!r}"
    for key, (required, form) in known.items():
        if key not in given and required:
            yield f"{name} has no {key}"
        elif key in given and not form.fullmatch(given[key]):
            yield f"{key} of {name} is {given[key]!r}"
    yield from (f"unknown attribute {key} of {name}" for key in given.keys() - known)
    children = [named(child.tag) for child in element.iterchildren(etree.Element)]
    order = CHILDREN.get(name, ())
    places = [child for child, _ in order]
    yield from (f"unknown child {c} of {name}" for c in children if c not in places)
    numbers = [places.index(child) for child in children if child in places]
    if numbers != sorted(numbers):
        yield f"the children of {name} are out of order"
    for child, (least, most) in order:
        if not least <= children.count(child) <= most:
            yield f"{name} has {children.count(child)} {child}"
    if name == "rts:targets" and len(children) != 2:
        yield "rts:targets has no condition, or two"


def references(root: etree._Element) -> Iterator[str]:
    """Yield violations of references: each needs the id and instance name of a component."""
    key: Callable[[etree._Element, str], str] = lambda e, name: e.get(  # noqa: E731
        f"{{{RTS}}}{name}", ""
    )
    components = [
        (key(c, "id"), key(c, "instanceName"))
        for c in root.iterfind(f"{{{RTS}}}Components")
    ]
    if len({instance for _, instance in components}) < len(components):
        yield "two components of one instance name"
    for element in root.iter(etree.Element):
        if f"{{{RTS}}}componentId" in element.attrib:
            reference = (key(element, "componentId"), key(element, "instanceName"))
            if reference not in components:
                yield f"{named(element.tag)} refers to {reference}"
    ids = [key(e, "connectorId") for e in root if "Connectors" in str(e.tag)]
    if len(set(ids)) < len(ids):
        yield "two connectors of one id"
