"""Device descriptions as XDD or XDC files (CiA 311 V1.1).

The sections of an EDS, with each key at its place in XML. A variable of a type of IEC 61131-3 has a
parameter; others have their type and values as attributes, since no parameter can have them.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence

import msgspec

from rtgen.compiler.backends.canopen.eds_text import sections
from rtgen.compiler.backends.canopen.portable_eds import LISTS
from rtgen.compiler.backends.kit.quoting.xml import xml_comment
from rtgen.compiler.kit import xml_text
from rtgen.compiler.model.canopen import Access, DataType, Device
from rtgen.compiler.typemap.canopen.xdd import (
    ACCESS,
    BIT_RATES,
    CONTAINER,
    DEVICE_BODY,
    DUMMIES,
    FIELDS,
    NAMESPACES,
    NETWORK_BODY,
    OCTETS,
    PRESET_RATE,
    TYPES,
    XSI,
    Body,
    Field,
    extension,
)

_SPACE = NAMESPACES[0]
_PREFIX = "co"
_OBJECT = re.compile(r"([0-9A-F]{4})(?:sub([0-9A-F]{1,2}))?")
_WORDS = {access: word for word, access in ACCESS.items()}
_TYPES = {int(type_): word for word, type_ in TYPES.items()}
_SDO_ONLY = {Access.RWR: Access.RW, Access.RWW: Access.RW}
_ONE_WAY = {
    Access.RO: "TPDO",
    Access.CONST: "TPDO",
    Access.RWR: "TPDO",
    Access.WO: "RPDO",
    Access.RWW: "RPDO",
}
_DEVICE_ORDER = (
    "vendorName",
    "vendorID",
    "productName",
    "productID",
    "productText",
    "orderNumber",
)
_ATTRIBUTES = (
    ("LowLimit", "lowLimit"),
    ("HighLimit", "highLimit"),
    ("DefaultValue", "defaultValue"),
    ("ParameterValue", "actualValue"),
    ("Denotation", "denotation"),
)


class _Node(msgspec.Struct):
    """An element; attributes without a namespace, except `xsi:type`."""

    name: tuple[str, str]
    attributes: dict[tuple[str, str], str] = {}
    children: list[_Node] = []
    text: str = ""


def xdd_text(device: Device, header: Sequence[str] = ()) -> str:
    """Return the file of a device: an XDC if it has a commissioning; `header` are comments."""
    writer = _Writer(dict(sections(device)))
    comment = "".join(f"<!-- {xml_comment(each)} -->\n" for each in header)
    return xml_text.document(writer.container(), {_SPACE: _PREFIX, XSI: "xsi"}, comment)


def _global(name: str, *children: _Node, text: str = "", **attributes: str) -> _Node:
    return _element(_SPACE, name, children, text, attributes)


def _local(name: str, *children: _Node, text: str = "", **attributes: str) -> _Node:
    return _element("", name, children, text, attributes)


def _element(
    space: str,
    name: str,
    children: Sequence[_Node],
    text: str,
    attributes: Mapping[str, str],
) -> _Node:
    written = {("", key): _clean(value) for key, value in attributes.items()}
    return _Node((space, name), written, list(children), _clean(text))


def _clean(text: str) -> str:
    return xml_text.NOT_IN_XML.sub("", text)


def _label(text: str, kind: str = "label") -> _Node:
    return _local(kind, text=text, lang="en")


class _Writer:
    def __init__(self, found: dict[str, list[tuple[str, str]]]) -> None:
        self._sections = {name: dict(pairs) for name, pairs in found.items()}
        self._others: list[tuple[str, str]] = []

    def container(self) -> _Node:
        values = dict(self._values())
        self._version = self._file_version()
        self._rates, self._dummies = list(self._bit_rates()), list(self._gaps())
        parameters: list[_Node] = []
        objects = list(self._objects(parameters))
        self._further()
        return _global(
            CONTAINER,
            self._profile(Body.DEVICE, values, self._device(values, parameters)),
            self._profile(Body.NETWORK, values, self._network(values, objects)),
        )

    def _values(self) -> Iterator[tuple[Field, str]]:
        """Yield the fields with their texts; note keys that would be read as others."""
        for field in FIELDS:
            if field.section not in self._sections:
                continue
            value = self._take(field.section, field.key)
            text = field.write(value) or field.absent
            if field.read(text or "") != value:
                self._others.append((extension(field.section, field.key), value))
            if text is not None and (text or field.attribute):
                yield field, text

    def _take(self, section: str, key: str) -> str:
        return self._sections.get(section, {}).pop(key, "")

    def _further(self) -> None:
        """Note all keys that remain, which CiA 311 has no element for."""
        for name, pairs in self._sections.items():
            if name not in LISTS:
                self._others += [(extension(name, key), v) for key, v in pairs.items()]

    def _profile(
        self, body: Body, values: Mapping[Field, str], content: list[_Node]
    ) -> _Node:
        is_device = body is Body.DEVICE
        name = "device" if is_device else "communication network"
        class_ = "Device" if is_device else "CommunicationNetwork"
        of_file = {f.attribute: v for f, v in values.items() if not f.path}
        of_file["fileVersion"] = self._version
        node = _local(
            "ProfileBody",
            *content,
            formatName="CANopen",
            formatVersion="1.0",
            supportedLanguages="en",
            **of_file,
        )
        kind = f"{_PREFIX}:{DEVICE_BODY if is_device else NETWORK_BODY}"
        node.attributes = {(XSI, "type"): kind, **node.attributes}
        return _global(
            "ISO15745Profile",
            _local(
                "ProfileHeader",
                _local("ProfileIdentification", text=f"CANopen {name} profile"),
                _local("ProfileRevision", text="1.1"),
                _local("ProfileName"),
                _local("ProfileSource"),
                _local("ProfileClassID", text=class_),
                _local(
                    "ISO15745Reference",
                    _local("ISO15745Part", text="1"),
                    _local("ISO15745Edition", text="1"),
                    _local("ProfileTechnology", text="CANopen"),
                ),
            ),
            node,
        )

    def _file_version(self) -> str:
        """Return the version of the file with its revision, and note which of them is missing."""
        parts = ("FileVersion", "FileRevision")
        version, revision = (self._take("FileInfo", key) for key in parts)
        for key, value in zip(parts, (version, revision), strict=True):
            if not value:
                self._others.append((extension("FileInfo", key), value))
        return f"{version or 0}.{revision}" if revision else version or "0"

    def _device(
        self, values: Mapping[Field, str], parameters: list[_Node]
    ) -> list[_Node]:
        given = {
            field.path[1]: _label(text, field.path[2]) if field.path[2:] else text
            for field, text in values.items()
            if field.path[:1] == ("DeviceIdentity",)
        }
        identity = []
        for name in _DEVICE_ORDER:
            content = given.get(name, "" if name in _DEVICE_ORDER[:4] else None)
            if isinstance(content, _Node):
                identity.append(_global(name, content))
            elif content is not None:
                identity.append(_global(name, text=content))
        listed = [
            _global(
                "characteristic",
                _global("characteristicName", _label(name)),
                _global("characteristicContent", _label(value)),
            )
            for name, value in self._others
        ]
        process = [_global("ApplicationProcess", _global("parameterList", *parameters))]
        return [
            _global("DeviceIdentity", *identity),
            _global(
                "DeviceFunction",
                _global("capabilities", _global("characteristicsList", *listed)),
            ),
            *(process if parameters else []),
        ]

    def _network(
        self, values: Mapping[Field, str], objects: list[_Node]
    ) -> list[_Node]:
        by_element: dict[str, dict[str, str]] = {}
        for field, text in values.items():
            if field.path[:1] == ("NetworkManagement",):
                by_element.setdefault(field.path[1], {})[field.attribute] = text
        by_element.setdefault("CANopenMasterFeatures", {})
        counts = {
            f"{name[0].lower()}{name[1:]}": self._take(name, "SupportedObjects")
            for name in LISTS
        }
        order = (
            "CANopenGeneralFeatures",
            "CANopenMasterFeatures",
            "deviceCommissioning",
        )
        return [
            _local(
                "ApplicationLayers",
                _global("CANopenObjectList", *objects, **counts),
                *([_local("dummyUsage", *self._dummies)] if self._dummies else []),
            ),
            _local(
                "TransportLayers",
                _local("PhysicalLayer", _local("baudRate", *self._rates)),
            ),
            _local(
                "NetworkManagement",
                *(_local(n, **by_element[n]) for n in order if n in by_element),
            ),
        ]

    def _bit_rates(self) -> Iterator[_Node]:
        stated = {
            rate: self._take("DeviceInfo", f"BaudRate_{rate}") for rate in BIT_RATES
        }
        rates = [rate for rate, flag in stated.items() if flag == "1"]
        if not rates:
            rates = [PRESET_RATE]
            name = extension("DeviceInfo", f"BaudRate_{PRESET_RATE}")
            self._others.append((name, stated[PRESET_RATE]))
        for rate in rates:
            yield _local("supportedBaudRate", value=f"{rate} Kbps")

    def _gaps(self) -> Iterator[_Node]:
        for code in DUMMIES:
            allowed = self._take("DummyUsage", key := f"Dummy{code:04X}")
            if allowed:
                yield _local("dummy", entry=f"{key}={allowed}")

    def _objects(self, parameters: list[_Node]) -> Iterator[_Node]:
        """Yield the objects; add their parameters."""
        last: _Node | None = None
        for name in [name for name in self._sections if _OBJECT.fullmatch(name)]:
            match = _OBJECT.fullmatch(name)
            assert match is not None
            index, sub = match.groups()
            pairs = self._sections.pop(name)
            if sub is None:
                if last is not None:
                    yield last
                node = _local("CANopenObject", index=index)
                last = node
            else:
                node = _local("CANopenSubObject", subIndex=f"{int(sub, 16):02X}")
                assert last is not None
                last.children.append(node)
            parameter = self._fill(node, name, pairs)
            parameters += [] if parameter is None else [parameter]
        if last is not None:
            yield last

    def _fill(self, node: _Node, name: str, pairs: dict[str, str]) -> _Node | None:
        """Set the attributes of an object or sub-object; return its parameter, if it has one."""

        def put(attribute: str, value: str) -> None:
            if value:
                node.attributes["", attribute] = _clean(value)

        type_ = pairs.pop("DataType", "")
        label = pairs.pop("ParameterName")
        put("name", label)
        put("objectType", str(int(pairs.pop("ObjectType", "7"), 16)))
        subs = pairs.pop("SubNumber", "")
        flags = pairs.pop("ObjFlags", "")
        is_mapped = pairs.pop("PDOMapping", "0") == "1"
        parameter = None
        if type_:
            access = Access(pairs.pop("AccessType"))
            put("PDOmapping", _ONE_WAY.get(access, "optional") if is_mapped else "no")
            default = pairs.get("DefaultValue", "")
            word = _type_word(int(type_, 16), bool(default))
            if word is not None:
                parameter = self._parameter(name, label, word, access, pairs)
                put("uniqueIDRef", parameter.attributes["", "uniqueID"])
            else:
                code = int(type_, 16)
                put("dataType", f"{code:0{2 if code <= 0xFF else 4}X}")
                put("accessType", _SDO_ONLY.get(access, access).value)
                if access in _SDO_ONLY and not is_mapped:
                    pairs["AccessType"] = access.value
        for key, attribute in _ATTRIBUTES:
            put(attribute, pairs.pop(key, ""))
        if flags:
            number = int(flags, 16)
            put("objFlags", f"{number:0{4 if number <= 0xFFFF else 8}X}")
        if subs:
            put("subNumber", str(int(subs, 16)))
        self._others += [(extension(name, key), value) for key, value in pairs.items()]
        return parameter

    @staticmethod
    def _parameter(
        name: str, label: str, word: str, access: Access, pairs: dict[str, str]
    ) -> _Node:
        """Return the parameter of a variable, and remove what it says from `pairs`."""
        index, _, sub = name.partition("sub")
        identifier = f"UID_SUB_{index}{int(sub, 16):02X}" if sub else f"UID_OBJ_{index}"
        attributes = {"uniqueID": identifier, "access": _WORDS[access]}
        if "Factor" in pairs and float(pairs["Factor"]) != 1:
            attributes["multiplier"] = pairs.pop("Factor")
        children = [_label(label)]
        if text := pairs.pop("Description", ""):
            children.append(_label(text, "description"))
        children.append(_local(word))
        if text := pairs.pop("Denotation", ""):
            children.append(_global("denotation", _label(text)))
        for key, element in (
            ("ParameterValue", "actualValue"),
            ("DefaultValue", "defaultValue"),
        ):
            if text := pairs.pop(key, ""):
                children.append(_global(element, value=text))
        low, high = pairs.get("LowLimit"), pairs.get("HighLimit")
        if low is not None and high is not None:
            ends = [_local("minValue", value=low), _local("maxValue", value=high)]
            children.append(_global("allowedValues", _global("range", *ends)))
            del pairs["LowLimit"], pairs["HighLimit"]
        if text := pairs.pop("Unit", ""):
            children.append(_global("unit", _label(text), multiplier="1"))
        return _global("parameter", *children, **attributes)


def _type_word(code: int, is_valued: bool) -> str | None:
    """Return the type of a parameter that is read as a data type; None without one."""
    octets = DataType.OCTET_STRING if is_valued else DataType.DOMAIN
    return OCTETS if code == octets else _TYPES.get(code)
