"""Projects of one input language, with texts of `Texts` wherever the language allows texts."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from xml.sax.saxutils import quoteattr

from hostile_texts import Texts

Files = dict[str, str]
Maker = Callable[[Texts, int], Files]

_XML_SPACE = {"\n": "&#10;", "\r": "&#13;", "\t": "&#9;"}


def _idl_string(text: str) -> str:
    plain = {chr(n) for n in range(32, 127)} - set('\\"')
    return (
        '"'
        + "".join(
            c if c in plain or ord(c) > 0xFF else f"\\x{ord(c):02x}" for c in text
        )
        + '"'
    )


def _doc(text: str) -> str:
    text = "".join(c for c in text if c.isprintable() or c in "\t\n\r")
    return f"/** {text.replace('*/', '* /').replace('/*', '/ *')} */"


def _line(text: str) -> str:
    text = "".join(c if c.isprintable() else " " for c in text)
    return f"{' '.join(text.split())}."


def idl(texts: Texts, count: int) -> Files:
    """Return components with annotations, types with documentation, constants with strings."""
    t = texts.text

    def q(*, keep: bool = True, conf: bool = False) -> str:
        return _idl_string(t(keep=keep, printable=True, conf=conf))

    files = {}
    for n in range(count):
        files[f"idl/part{n}.idl"] = f"""
{_doc(t(keep=False))}
module M{n} {{
    {_doc(t(keep=False))}
    struct Data {{
        {_doc(t(keep=False))}
        long number; ///< {_line(t(keep=False))}
        @unit({q(keep=False)}) string word;
    }};
    const string TEXT = {_idl_string(t())};
    enum Tone {{ {_doc(t(keep=False))} DO, RE }};
    union Choice switch (long) {{ case 1: {_doc(t(keep=False))} long one; default: Data other; }};
    exception Failed {{ string reason; }};
    interface Works {{
        {_doc(t(keep=False))}
        void go(in Data given) raises (Failed);
        {_doc(t(keep=False))}
        readonly attribute long state;
    }};
    typedef sequence<Data> Several;
}};
{_doc(t(keep=False))}
@rtc(category={q(conf=True)}, vendor={q(conf=True)}, description={q(keep=False)},
    kind={q()}, rate=10.0)
component Part{n} {{
    {_doc(t(keep=False))}
    @name({q()}) @unit({q()}) publishes M{n}::Data out_data;
    @name({q()}) consumes M{n}::Choice in_data;
    @port({q()}) @instance({q()}) @type_name({q()}) provides M{n}::Works works;
    @port({q()}) @instance({q()}) uses M{n}::Works others;
    {_doc(t(keep=False))}
    @name({q()}) @unit({q()}) @default({q()}) attribute string word;
    @name({q()}) @min(1) @default(2) attribute long number;
    @default(RE) attribute M{n}::Tone tone;
}};
"""
    return files


def _attributes(**named: str) -> str:
    pairs = (
        (key.replace("__", ":"), quoteattr(value, _XML_SPACE))
        for key, value in named.items()
    )
    return " ".join(f"{key}={value}" for key, value in pairs)


def profile(texts: Texts, count: int) -> Files:
    """Return components as RTC.xml, with every attribute that holds a text."""

    def t(*, keep: bool = True, conf: bool = False) -> str:
        return texts.text(keep=keep, xml=True, conf=conf, printable=keep)

    files = {}
    for n in range(count):
        basic = _attributes(
            rtc__name=f"Part{n}",
            rtc__componentType="STATIC",
            rtc__activityType="PERIODIC",
            rtc__componentKind=t(keep=False),
            rtc__category=t(keep=False, conf=True),
            rtc__vendor=t(keep=False),
            rtc__version=t(keep=False),
            rtc__description=t(keep=False),
            rtc__abstract=t(keep=False),
            rtc__executionRate="10.0",
            rtc__executionType=t(keep=False, conf=True),
            rtc__maxInstances="1",
            rtc__creationDate="2024-05-06T07:08:09+09:00",
            rtc__updateDate="2024-05-06T07:08:09+09:00",
        )
        ports = "".join(
            "<rtc:DataPorts "
            + _attributes(
                xsi__type="rtcExt:dataport_ext",
                rtc__portType=kind,
                rtc__name=t(),
                rtc__type="RTC::TimedLong",
                rtc__idlFile=t(keep=False),
                rtc__unit=t(),
                rtcExt__variableName=t(keep=False),
                rtcExt__position="LEFT",
            )
            + f"><rtcDoc:Doc {_attributes(rtcDoc__description=t(keep=False))}/>"
            "</rtc:DataPorts>"
            for kind in ("DataInPort", "DataOutPort", "DataInPort")
        )
        service = (
            f"<rtc:ServicePorts {_attributes(xsi__type='rtcExt:serviceport_ext', rtc__name=t())}>"
            "<rtc:ServiceInterface "
            + _attributes(
                xsi__type="rtcExt:serviceinterface_ext",
                rtc__name=t(),
                rtc__direction="Provided",
                rtc__instanceName=t(keep=False),
                rtc__type="OpenRTM::InPortCdr",
                rtcExt__variableName=t(keep=False),
            )
            + "/></rtc:ServicePorts>"
        )
        parameters = "".join(
            "<rtc:Configuration "
            + _attributes(
                xsi__type="rtcExt:configuration_ext",
                rtc__name=t(),
                rtc__type=kind,
                rtc__defaultValue=t() if kind == "string" else "3",
                rtc__unit=t(),
                rtcExt__variableName=t(keep=False),
            )
            + f"><rtcDoc:Doc {_attributes(rtcDoc__description=t(keep=False))}/>"
            f"<rtcExt:Properties {_attributes(rtcExt__name='__widget__', rtcExt__value='text')}/>"
            "</rtc:Configuration>"
            for kind in ("string", "double", "int")
        )
        files[f"xml/Part{n}/RTC.xml"] = f"""<?xml version="1.0" encoding="UTF-8"?>
<rtc:RtcProfile rtc:version="0.3" {_attributes(rtc__id=t(keep=False))}
    xmlns:rtc="http://www.openrtp.org/namespaces/rtc"
    xmlns:rtcExt="http://www.openrtp.org/namespaces/rtc_ext"
    xmlns:rtcDoc="http://www.openrtp.org/namespaces/rtc_doc"
    xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
<rtc:BasicInfo xsi:type="rtcExt:basic_info_ext" {basic}>
<rtcDoc:Doc {_attributes(rtcDoc__description=t(keep=False))}/></rtc:BasicInfo>
<rtc:ConfigurationSet>{parameters}</rtc:ConfigurationSet>
{ports}{service}
</rtc:RtcProfile>
"""
    return files


def profile_yaml(texts: Texts, count: int) -> Files:
    """Return the same components in YAML."""
    from rtgen.compiler.frontends.kit import located_xml
    from rtgen.compiler.frontends.profiles.profile_yaml import to_yaml

    return {
        f"xml/part{n}.yaml": to_yaml(located_xml.parse(text, "RTC.xml"))
        for n, text in enumerate(profile(texts, count).values())
    }


def cdl(texts: Texts, count: int) -> Files:
    """Return boards with a join through RTCPlugin: documentation, strings, options."""

    def line() -> str:
        text = texts.text(keep=False, one_line=True)
        return "".join(c for c in text if c.isprintable() and c not in "\",'\\")

    def option() -> str:
        text = texts.text(keep=False, one_line=True)
        text = "".join(c for c in text if c.isprintable() and c not in '",!')
        return text.rstrip("\\ ").replace("\\", "\\\\") or "port"

    files = {}
    for n in range(count):
        doc = [_doc(texts.text(keep=False)) for _ in range(5)]
        files[f"cdl/board{n}.cdl"] = f"""
const char_t *const TEXT{n} = "{line()}";
{doc[0]}
struct tagState{n} {{ {doc[1]} int32_t count; double64_t speed[2]; }};
{doc[2]}
signature sWorks{n} {{
    {doc[3]}
    ER go( [in] int32_t speed, [out] struct tagState{n} *state );
    void name( [in,string] const char_t *text );
}};
celltype tWorks {{ entry sWorks{n} eWorks; attr {{ char_t *label = "{line()}"; }}; }};
{doc[4]}
[active] celltype tUser {{ call sWorks{n} cWorks; }};
region rBoard {{ cell tWorks Works {{ }}; }};
[to_through( rBoard, RTCPlugin,
    "port={8931 + n},address={line()},name=Client{n},device=!{option()}!" )]
region rPc {{ cell tUser User {{ cWorks = rBoard::Works.eWorks; }}; }};
"""
    return files


def ros(texts: Texts, count: int) -> Files:
    """Return ROS 2 interface files with comments, constants, defaults, and components with them."""

    def line() -> str:
        text = texts.text(keep=False, one_line=True)
        return "".join(c for c in text if c.isprintable())

    def quoted() -> str:
        # A hash starts a comment, even in a text; constants and defaults have one line.
        text = texts.text(keep=False, printable=True, one_line=True).replace("#", "")
        return "'" + text.replace("\\", "\\\\").replace("'", "\\'") + "'"

    files = {}
    for n in range(count):
        files[f"lab/msg/Load{n}.msg"] = f"""# {line()}
string TEXT={quoted()}
float64 mass  # {line()}
# {line()}
string<=400 word {quoted()}
int32[<=3] codes
"""
        files[f"lab/srv/Weigh{n}.srv"] = f"""# {line()}
string what {quoted()}
---
# {line()}
lab/Load{n} load
"""
        files[f"lab/action/Lift{n}.action"] = f"""# {line()}
float64 height
---
string why {quoted()}
---
# {line()}
float64 now
"""
        files[f"lab/part{n}.idl"] = f"""#include "lab/msg/Load{n}.idl"
component Part{n} {{ publishes lab::msg::Load{n} out_data; }};
"""
    return files


def _eds(texts: Texts, n: int) -> str:
    def t() -> str:
        text = texts.text(keep=False, one_line=True)
        return "".join(c for c in text if c >= " ")

    return f"""; {t()}
[FileInfo]
FileName=part{n}.eds
FileVersion=1
FileRevision=0
EDSVersion=4.0
Description={t()}
CreatedBy={t()}
[DeviceInfo]
VendorName={t()}
VendorNumber=0x1
ProductName={t()}
ProductNumber=0x2
OrderCode={t()}
BaudRate_500=1
SimpleBootUpSlave=1
Granularity=8
NrOfRXPDO=0
NrOfTXPDO=1
[Comments]
Lines=2
Line1={t()}
Line2={t()}
[MandatoryObjects]
SupportedObjects=3
1=0x1000
2=0x1001
3=0x1018
[1000]
ParameterName={t()}
ObjectType=0x7
DataType=0x0007
AccessType=ro
DefaultValue=0x0
[1001]
ParameterName={t()}
ObjectType=0x7
DataType=0x0005
AccessType=ro
PDOMapping=1
[1018]
ParameterName=Identity
ObjectType=0x9
SubNumber=2
[1018sub0]
ParameterName=Highest sub-index supported
ObjectType=0x7
DataType=0x0005
AccessType=const
DefaultValue=1
[1018sub1]
ParameterName=Vendor-ID
ObjectType=0x7
DataType=0x0007
AccessType=ro
DefaultValue=0x1
[OptionalObjects]
SupportedObjects=2
1=0x1800
2=0x1A00
[1800]
ParameterName={t()}
ObjectType=0x9
SubNumber=3
[1800sub0]
ParameterName=Highest
ObjectType=0x7
DataType=0x0005
AccessType=const
DefaultValue=2
[1800sub1]
ParameterName=COB-ID
ObjectType=0x7
DataType=0x0007
AccessType=rw
DefaultValue=$NODEID+0x180
[1800sub2]
ParameterName=Type
ObjectType=0x7
DataType=0x0005
AccessType=rw
DefaultValue=254
[1A00]
ParameterName={t()}
ObjectType=0x9
SubNumber=2
[1A00sub0]
ParameterName=Number
ObjectType=0x7
DataType=0x0005
AccessType=rw
DefaultValue=1
[1A00sub1]
ParameterName=First
ObjectType=0x7
DataType=0x0007
AccessType=rw
DefaultValue=0x20010010
[ManufacturerObjects]
SupportedObjects=3
1=0x2000
2=0x2001
3=0x2002
[2000]
ParameterName={t()}
ObjectType=0x7
DataType=0x0009
AccessType=rw
DefaultValue={t()}
Denotation={t()}
[2001]
ParameterName={t()}
ObjectType=0x7
DataType=0x0003
AccessType=rw
PDOMapping=1
Unit={t()}
Description={t()}
[2002]
ParameterName={t()}
ObjectType=0x9
SubNumber=2
[2002sub0]
ParameterName=Highest
ObjectType=0x7
DataType=0x0005
AccessType=const
DefaultValue=1
[2002sub1]
ParameterName={t()}
ObjectType=0x7
DataType=0x0008
AccessType=rw
DefaultValue=1.5
UploadFile={t()}
[Tools]
Items=1
[S{t().strip("[]").replace("]", "") or "x"}]
K{t().replace("=", "")}={t()}
"""


def eds(texts: Texts, count: int) -> Files:
    """Return device descriptions, all of them nodes of one bus."""
    files = {f"eds/part{n}.eds": _eds(texts, n) for n in range(count)}
    nodes = "".join(
        f'[device.part{n}]\neds = "part{n}.eds"\n[node.node{n}]\ndevice = "part{n}"\nid = {n + 1}\n'
        f'[device.part{n}.units]\n"2001" = {_toml(texts.text(keep=False))}\n'
        for n in range(count)
    )
    files["eds/bus.toml"] = f"[bus]\nbit_rate = 500\n{nodes}"
    return files


def _toml(text: str) -> str:
    return (
        '"'
        + "".join(c if " " <= c not in '"\\\x7f' else f"\\U{ord(c):08X}" for c in text)
        + '"'
    )


def _toml_string(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _folder(text: str, number: int) -> str:
    """Return a name that is valid in a file system; the number makes it unique."""
    return f"{text.replace('/', ':')[:60]} {number}"


def project(texts: Texts, count: int) -> Files:
    """Return IDL in folders of any name, with macros and factories from rtgen.toml."""
    files = {}
    paths, macros, factories = [], [], []
    for n in range(count):
        folder = _folder(texts.text(keep=False), n)
        paths.append(_toml_string(f"{folder}/part{n}.idl"))
        macros += [
            f"{name}{n} = {_toml_string(_idl_string(texts.text(printable=True)))}"
            for name in ("TEXT", "NAME", "WORD")
        ]
        factories.append(
            f'{_toml_string(texts.text(keep=False))} = "fuzzednodes.part{n}:Part{n}"'
        )
        files[f"{folder}/part{n}.idl"] = f"""
module M{n} {{
    const string TEXT = TEXT{n};
    struct Data {{ long number; }};
}};
component Part{n} {{
    @name(NAME{n}) publishes M{n}::Data out_data;
    @default(WORD{n}) attribute string word;
}};
"""
    files["rtgen.toml"] = f"""
[sources]
paths = [{", ".join(paths)}]
define = {{ {", ".join(macros)} }}
[output]
package = "fuzzed"
skeletons = "src/fuzzednodes"
target = "TARGET"
[components]
{chr(10).join(factories)}
"""
    return files


MAKERS: Mapping[str, Maker] = {
    "idl": idl,
    "profile": profile,
    "yaml": profile_yaml,
    "cdl": cdl,
    "eds": eds,
    "ros": ros,
    "project": project,
}

DEFINITIONS: Mapping[str, int] = {
    "idl": 15,
    "profile": 8,
    "yaml": 8,
    "cdl": 8,
    "eds": 10,
    "ros": 10,
    "project": 5,
    "system": 8,
    "python": 5,
    "convert": 8,
}
"""Number of definitions of a file that have hostile texts of their own.

These are modules, types, members, constants, operations, components, ports and parameters;
signatures, functions, celltypes, attributes and joins; devices, objects and sections; messages,
requests, replies, goals, results, feedback and their fields; folders, macros and factories.
"""
