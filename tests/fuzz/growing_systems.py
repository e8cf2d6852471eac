"""Systems and profiles, in XML and YAML, with many or deep elements."""

from __future__ import annotations

from growth import Files, Kinds, chain, lines

SYSTEM = (
    ("graph", "-o", "a.svg", "a.xml"),
    ("inspect", "a.xml"),
    ("convert", "--to", "rts-yaml", "a.xml"),
)
PROFILE = (
    ("inspect", "RTC.xml"),
    ("convert", "--to", "idl", "RTC.xml"),
    ("generate", "-q", "--no-cache", "-o", "o", "RTC.xml"),
)
YAML = (
    ("inspect", "RTC.yaml"),
    ("convert", "--to", "rtc-xml", "RTC.yaml"),
    ("convert", "--to", "rts-xml", "a.yaml"),
    ("inspect", "a.yaml"),
)

KINDS = Kinds(PROFILE)


_RTS = """\
<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id="RTSystem:Lab:S:1.0" rts:version="0.2"
    xmlns:rts="http://www.openrtp.org/namespaces/rts"
    xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext"
    xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
{0}
</rts:RtsProfile>
"""
_MEMBER = (
    '<rts:Components rts:instanceName="C{0}" rts:id="RTC:Lab:Test:C{0}:1.0.0"'
    ' rts:pathUri="localhost/C{0}.rtc" rts:compositeType="None" rts:isRequired="true">'
    '<rts:DataPorts rts:name="C{0}.in"/><rts:DataPorts rts:name="C{0}.out"/>'
    "</rts:Components>"
)
_CONNECTOR = (
    '<rts:DataPortConnectors rts:connectorId="{2}" rts:name="n{2}" rts:dataType="T"'
    ' rts:interfaceType="corba_cdr" rts:dataflowType="push" rts:subscriptionType="flush">'
    '<rts:sourceDataPort rts:portName="C{0}.out" rts:instanceName="C{0}"'
    ' rts:componentId="RTC:Lab:Test:C{0}:1.0.0"/>'
    '<rts:targetDataPort rts:portName="C{1}.in" rts:instanceName="C{1}"'
    ' rts:componentId="RTC:Lab:Test:C{1}:1.0.0"/></rts:DataPortConnectors>'
)


@KINDS.add(50, 400, commands=SYSTEM)
def system_in_a_row(size: int) -> Files:
    members = lines(size, lambda i: _MEMBER.format(i))
    links = lines(size - 1, lambda i: _CONNECTOR.format(i, i + 1, i))
    return {"a.xml": _RTS.format(members + links)}


@KINDS.add(50, 400, commands=SYSTEM)
def system_at_random(size: int) -> Files:
    members = lines(size, lambda i: _MEMBER.format(i))
    links = lines(
        3 * size, lambda i: _CONNECTOR.format(i % size, (i * 7919 + 13) % size, i)
    )
    return {"a.xml": _RTS.format(members + links)}


@KINDS.add(400, commands=SYSTEM)
def system_as_a_star(size: int) -> Files:
    members = lines(size, lambda i: _MEMBER.format(i))
    links = lines(size - 1, lambda i: _CONNECTOR.format(0, i, i), 1)
    return {"a.xml": _RTS.format(members + links)}


@KINDS.add(20, 70, commands=SYSTEM)
def system_of_all_with_all(size: int) -> Files:
    members = lines(size, lambda i: _MEMBER.format(i))
    links = lines(size * size, lambda i: _CONNECTOR.format(i // size, i % size, i))
    return {"a.xml": _RTS.format(members + links)}


@KINDS.add(2000, commands=SYSTEM)
def system_of_parallel_links(size: int) -> Files:
    members = lines(2, lambda i: _MEMBER.format(i))
    links = lines(size, lambda i: _CONNECTOR.format(0, 1, i))
    return {"a.xml": _RTS.format(members + links)}


_RTC = """\
<?xml version="1.0" encoding="UTF-8"?>
<rtc:RtcProfile rtc:version="0.3" rtc:id="RTC:Lab:Test:Part:1.0.0"
    xmlns:rtc="http://www.openrtp.org/namespaces/rtc"
    xmlns:rtcExt="http://www.openrtp.org/namespaces/rtc_ext"
    xmlns:rtcDoc="http://www.openrtp.org/namespaces/rtc_doc"
    xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
  <rtc:BasicInfo rtc:name="Part" rtc:componentType="STATIC" rtc:activityType="PERIODIC"
      rtc:componentKind="DataFlowComponent" rtc:category="Test" rtc:vendor="Lab"
      rtc:version="1.0.0" rtc:executionType="PeriodicExecutionContext" rtc:executionRate="10.0"
      rtc:maxInstances="1"/>
{0}
</rtc:RtcProfile>
"""


@KINDS.add(1000, 5000)
def profile_with_ports(size: int) -> Files:
    line = '<rtc:DataPorts rtc:name="same{1}" rtc:portType="DataInPort" rtc:type="A::T{0}"/>'
    return {
        "RTC.xml": _RTC.format(lines(size, lambda i: line.format(i, " " * i + "x")))
    }


@KINDS.add(5000)
def profile_with_equal_ports(size: int) -> Files:
    line = '<rtc:DataPorts rtc:name="a-{0}" rtc:portType="DataInPort" rtc:type="T"/>'
    names = ["".join("-+"[int(b)] for b in f"{i:014b}") for i in range(size)]
    return {"RTC.xml": _RTC.format("".join(line.format(n) for n in names))}


@KINDS.add(3000)
def profile_with_parameters(size: int) -> Files:
    line = '<rtc:Configuration rtc:name="p{0}" rtc:type="int" rtc:defaultValue="{0}"/>'
    text = lines(size, lambda i: line.format(i))
    return {
        "RTC.xml": _RTC.format(f"<rtc:ConfigurationSet>{text}</rtc:ConfigurationSet>")
    }


@KINDS.add(50, 5000, 200000)
def deep_elements(size: int) -> Files:
    return {"RTC.xml": _RTC.format("<a>" * size + "</a>" * size)}


@KINDS.add(50000)
def many_attributes(size: int) -> Files:
    return {
        "RTC.xml": _RTC.format(
            f"<a {lines(size, lambda i: f'x{i}={chr(34)}1{chr(34)}')}/>"
        )
    }


@KINDS.add(1_000_000)
def one_long_attribute(size: int) -> Files:
    return {
        "RTC.xml": _RTC.format(
            f'<rtc:DataPorts rtc:name="{"n" * size}" rtc:portType="{"k" * size}" rtc:type="T"/>'
            f'<rtc:DataPorts rtc:name="{"n" * size}" rtc:portType="DataInPort"'
            f' rtc:type="{"T" * size}"/>'
        )
    }


@KINDS.add(12, 40, commands=YAML)
def yaml_aliases_that_double(size: int) -> Files:
    text = chain(size, "a0: &a0 [x, x]", "a{0}: &a{0} [*a{1}, *a{1}]")
    text += f"\nrtcProfile: *a{size}\nrtsProfile: *a{size}\n"
    return {"RTC.yaml": text, "a.yaml": text}


@KINDS.add(12, 24, commands=YAML)
def yaml_profile_of_aliases(size: int) -> Files:
    line = "a{0}: &a{0} {{y: *a{1}, z: *a{1}}}"
    text = chain(size, "a0: &a0 {rtc: x, y: x}", line)
    rtc = f"{text}\nrtcProfile:\n  version: '0.3'\n  id: x\n  basicInfo: *a{size}\n"
    rts = f"{text}\nrtsProfile:\n  version: '0.2'\n  id: x\n  components: [*a{size}]\n"
    return {"RTC.yaml": rtc, "a.yaml": rts}


@KINDS.add(90, 5000, 50000, commands=YAML)
def yaml_nesting(size: int) -> Files:
    text = f"rtcProfile: {'[' * size}{']' * size}\n"
    return {"RTC.yaml": text, "a.yaml": text.replace("rtc", "rts")}
