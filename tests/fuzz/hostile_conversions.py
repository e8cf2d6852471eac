"""Hostile texts in systems, in modules of OpenRTM, and in the input of `rtgen convert`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import chdir
from pathlib import Path
from xml.sax.saxutils import quoteattr

from fuzzing import ViolationError
from hostile_definitions import profile
from hostile_texts import Texts

from rtgen.compiler import compilation
from rtgen.compiler.backends.wiring import render, view_of
from rtgen.compiler.compilation import compile_project
from rtgen.compiler.diagnostics import Diagnostic, has_errors
from rtgen.compiler.frontends import idl
from rtgen.compiler.frontends.kit import located_xml
from rtgen.compiler.frontends.profiles import profile_yaml
from rtgen.compiler.kit.resources import idl_file
from rtgen.compiler.model import Component
from rtgen.compiler.project import load
from rtgen.compiler.systems.reading import read_file
from rtgen.tools.components.adopted import adopted
from rtgen.tools.components.component_text import component_idl, component_profile

Made = tuple[list[str], dict[str, str]]
"""The codes of the findings, and files by their paths; none if there are errors."""

_SPACE = {"\n": "&#10;", "\r": "&#13;", "\t": "&#9;"}
_PARTS = """
#include "BasicDataType.idl"
@rtc(category="Fuzz", vendor="Lab")
component Source { publishes RTC::TimedLong out_data; attribute string word; };
@rtc(category="Fuzz", vendor="Lab")
component Sink { consumes RTC::TimedLong in_data; attribute string word; };
"""
_PROJECT = """[sources]
paths = ["parts.idl", "s.xml"]
[output]
package = "fuzzed"
target = "openrtm"
"""


def _read_again(text: str, folder: Path) -> None:
    """Check that rtgen can read the IDL that it writes."""
    path = folder / "again.idl"
    path.write_text(text, encoding="utf-8")
    found = idl.load(
        [path], root=folder, include=[idl_file("BasicDataType.idl").parent]
    )
    path.unlink()
    wrong = [d for d in found.diagnostics if has_errors([d])]
    if wrong:
        raise ViolationError(f"{wrong[0].code}: {wrong[0].message}")


def _codes(found: tuple[Diagnostic, ...] | list[Diagnostic]) -> list[str]:
    return [d.code for d in found]


def system(texts: Texts, folder: Path) -> Made:
    """Return a system of two components on OpenRTM, and its picture.

    Ids of sets begin with a word, since those that begin with `__` are OpenRTM's own and left out.
    """

    def a(before: str = "", **options: bool) -> str:
        text = before + texts.text(xml=True, keep=False, **options)
        return quoteattr(text, _SPACE)

    one, other = (texts.text(xml=True, conf=True, keep=False) for _ in range(2))
    one, other = (n.replace("/", "_").replace("\\", "_") for n in (one, other))
    q = [quoteattr(name, _SPACE) for name in (one, other)]
    ports = [
        quoteattr(f"{name}.{port}", _SPACE)
        for name, port in ((one, "out_data"), (other, "in_data"))
    ]
    components = "".join(
        f"""<rts:Components rts:id="RTC:Lab:Fuzz:{kind}:1.0.0" rts:instanceName={name}
  rts:pathUri={a()} rts:compositeType="None" rts:isRequired="true"
  rts:activeConfigurationSet="default">
<rts:DataPorts rts:name={port}/>
<rts:ConfigurationSets rts:id="default"><rts:ConfigurationData rts:name="word" rts:data={a()}/>
</rts:ConfigurationSets>
<rts:ConfigurationSets rts:id={a("set ", conf=True)}>
<rts:ConfigurationData rts:name="word" rts:data={a()}/>
</rts:ConfigurationSets>
</rts:Components>"""
        for kind, name, port in zip(("Source", "Sink"), q, ports, strict=True)
    )
    ends = "".join(
        f"""<rts:{end}DataPort rts:componentId="RTC:Lab:Fuzz:{kind}:1.0.0"
  rts:instanceName={name} rts:portName={port}/>"""
        for end, kind, name, port in zip(
            ("source", "target"), ("Source", "Sink"), q, ports, strict=True
        )
    )
    (folder / "parts.idl").write_text(_PARTS)
    (folder / "rtgen.toml").write_text(_PROJECT)
    path = folder / "s.xml"
    path.write_text(
        f"""<?xml version="1.0" encoding="UTF-8"?>
<rts:RtsProfile rts:id={a()} rts:version="0.2" rts:abstract={a()}
  rts:creationDate="2024-05-06T07:08:09+09:00" rts:updateDate="2024-05-06T07:08:09+09:00"
  xmlns:rts="http://www.openrtp.org/namespaces/rts"
  xmlns:rtsExt="http://www.openrtp.org/namespaces/rts_ext"
  xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance">
{components}
<rts:DataPortConnectors rts:connectorId={a()} rts:name={a()} rts:dataType="RTC::TimedLong"
  rts:interfaceType="corba_cdr" rts:dataflowType="push" rts:subscriptionType="flush">
{ends}</rts:DataPortConnectors>
</rts:RtsProfile>""",
        encoding="utf-8",
    )
    with chdir(folder):
        project = load()
        run = compile_project(project)
        made = {a.path: str(a.text) for a in run.artifacts if "/s/" in a.path}
        if not run.failed:
            read, _, _ = read_file(path)
            model = compilation.read(project, lowered=True).model
            views = {
                d.name[-1]: view_of(d)
                for d in model.declarations
                if isinstance(d, Component)
            }
            assert read is not None
            made["s.svg"] = str(render(read, views))
    names = {one: "one", other: "other"}
    # The files of an instance have its name.
    made = {_renamed(path, names): text for path, text in made.items()}
    return _codes(list(run.diagnostics)), made


def _renamed(path: str, names: Mapping[str, str]) -> str:
    for name, plain in names.items():
        path = path.replace(f"/{name}.conf", f"/{plain}.conf")
    return path


def python(texts: Texts, folder: Path) -> Made:
    """Return the IDL of a module of OpenRTM with texts in its specification and ports."""

    def r(before: str = "") -> str:
        return repr(before + texts.text(keep=False, printable=True, conf=True))

    path = folder / "Part.py"
    path.write_text(
        f"""import OpenRTM_aist
import RTC
part_spec = ["implementation_id", "Part", "type_name", "Part", "description", {r()},
    "version", "1.0.0", "vendor", {r()}, "category", {r()}, "max_instance", "1",
    "conf.default.word", {r()}, "conf.default.number", "3",
    "conf.__widget__.word", "text", ""]
class Part(OpenRTM_aist.DataFlowComponentBase):
    {texts.text(keep=False)!r}
    def __init__(self, manager):
        OpenRTM_aist.DataFlowComponentBase.__init__(self, manager)
        self._d_a = RTC.TimedLong(RTC.Time(0, 0), 0)
        self._aIn = OpenRTM_aist.InPort({r("in ")}, self._d_a)
        self._bOut = OpenRTM_aist.OutPort({r("out ")}, self._d_a)
    def onInitialize(self):
        self.addInPort("a", self._aIn)
        self.addOutPort("b", self._bOut)
        return RTC.RTC_OK
""",
        encoding="utf-8",
    )
    (folder / "rtgen.toml").write_text('[output]\npackage = "fuzzed"\n')
    with chdir(folder):
        found = adopted(path, [])
        if found.component is None:
            return _codes(found.diagnostics), {}
        text = component_idl(found.model, found.component)
    _read_again(text, folder)
    return _codes(found.diagnostics), {"Part.idl": text}


def convert(texts: Texts, folder: Path) -> Made:
    """Return a profile in XML converted to IDL, to YAML, and from there to XML."""
    [xml] = profile(texts, 1).values()
    path = folder / "RTC.xml"
    path.write_text(xml, encoding="utf-8")
    (folder / "rtgen.toml").write_text(
        '[sources]\npaths = ["RTC.xml"]\n[output]\npackage = "fuzzed"\n'
    )
    with chdir(folder):
        project = load()
        read = compilation.read(project, lowered=True)
        if has_errors(read.diagnostics):
            return _codes(read.diagnostics), {}
        [component] = [d for d in read.model.declarations if isinstance(d, Component)]
        text = component_idl(read.model, component)
        written = component_profile(read.model, component, project)
    _read_again(text, folder)
    tree = located_xml.parse(xml, "RTC.xml")
    again = profile_yaml.to_xml(profile_yaml.to_yaml(tree), "RTC.yaml")
    return _codes(read.diagnostics), {
        "Part.idl": text,
        "RTC.xml": str(written),
        "again.xml": again,
    }


CONVERSIONS: Mapping[str, Callable[[Texts, Path], Made]] = {
    "system": system,
    "python": python,
    "convert": convert,
}
