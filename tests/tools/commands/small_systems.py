"""Texts of small systems."""

from __future__ import annotations

from collections.abc import Mapping

_COMPONENT = """
  <rts:Components xsi:type="rtsExt:component_ext" rts:id="RTC:v:c:{type}:1.0.0"
      rts:instanceName="{name}" rts:pathUri="localhost/{name}.rtc" rts:compositeType="None"
      rts:isRequired="true"/>"""
_LINK = """
  <rts:{kind}PortConnectors rts:connectorId="{source}-{target}" rts:name="{source}-{target}"
      {more}>
    <rts:source{kind}Port rts:portName="{source}" rts:instanceName="{from_}"
        rts:componentId=""/>
    <rts:target{kind}Port rts:portName="{target}" rts:instanceName="{to}"
        rts:componentId=""/>
  </rts:{kind}PortConnectors>"""
_DATA = """rts:dataType="{type}" rts:interfaceType="corba_cdr"
      rts:dataflowType="push" rts:subscriptionType="flush\""""


def _link(kind: str, source: str, target: str, more: str) -> str:
    ends = {"from_": source.partition(".")[0], "to": target.partition(".")[0]}
    return _LINK.format(kind=kind, source=source, target=target, more=more, **ends)


def data_port(source: str, target: str, type_: str) -> str:
    """Return a connector of data ports, each given as `INSTANCE.PORT`."""
    return _link("Data", source, target, _DATA.format(type=type_))


def service_port(source: str, target: str) -> str:
    """Return a connector of service ports, each given as `INSTANCE.PORT`."""
    return _link("Service", source, target, "")


def system_text(
    components: Mapping[str, str], *connectors: str, **properties: str
) -> str:
    """Return an RtsProfile of instances with their types; `properties` are those of runs."""
    boxes = "".join(
        _COMPONENT.format(name=name, type=type_) for name, type_ in components.items()
    )
    known = "".join(
        f'\n  <rtsExt:Properties rtsExt:name="rtgen.run.{name}" rtsExt:value="{value}"/>'
        for name, value in properties.items()
    )
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<rts:RtsProfile rts:id="RTSystem:v:test:1.0.0" rts:version="0.2"\n'
        '    xmlns:rts="http://www.openrtp.org/namespaces/rts"\n'
        '    xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext"\n'
        '    xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">'
        f"{boxes}{''.join(connectors)}{known}\n</rts:RtsProfile>\n"
    )
