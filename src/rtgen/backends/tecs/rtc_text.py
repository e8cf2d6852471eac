"""The classes of the RTCs of a service: the marshaller, and the base of the client."""

from __future__ import annotations

from rtgen.backends.components.base_module import class_names, port_profile
from rtgen.backends.components.imports import Imports, import_from
from rtgen.backends.components.locations import heading, summary
from rtgen.backends.components.members import attributes_of
from rtgen.backends.kit.python_text import fit_text
from rtgen.backends.kit.quoting.python import docstring, number_literal, string_literal
from rtgen.backends.kit.rendering import render
from rtgen.model import Component, Model, NamedType, PortKind
from rtgen.typemap.idl_python_names import PythonNames

_ADD = {PortKind.PROVIDER: "add_provider", PortKind.CONSUMER: "add_consumer"}
RUNTIME = ("Component", "ComponentProfile", "service_port")


def rtc_class(component: Component, imports: Imports, name: str) -> str:
    """The class of a component that has service ports only, up to its `__init__`."""
    ports = []
    statements = []
    for port, attribute in attributes_of(component).ports:
        assert isinstance(port.type, NamedType)
        interface = imports.type_name(port.type.name)
        names = f"{string_literal(port.port)}, {string_literal(port.instance)}"
        ports.append(port_profile(port, attribute, interface))
        statements.append(
            f"self.{attribute} = self.{_ADD[port.kind]}({names}, {interface})"
        )
    facts = ", ".join(
        (
            string_literal(component.name[-1]),
            f"category={string_literal(component.category)}",
            f"vendor={string_literal(component.vendor)}",
            f"description={string_literal(summary(component))}",
            f"rate={number_literal(float(component.rate))}",
            f"max_instances={component.max_instances}",
            f"ports=({', '.join(ports)},)",
        )
    )
    return render(
        "tecs/rtc.py.j2",
        name=name,
        docstring=docstring(component.doc, 4),
        profile=f"ComponentProfile({facts})",
        statements=statements,
    )


def client_module(
    component: Component, model: Model, names: PythonNames, header: str
) -> str:
    """The module with the base of a client."""
    base, _ = class_names(component)
    imports = Imports(model, names, "...", {base, *RUNTIME, "ClassVar"})
    text = rtc_class(component, imports, base)
    rendered = render(
        "tecs/client.py.j2",
        header=header,
        docstring=docstring(heading(component), 0),
        runtime=import_from("rtgen.runtime", RUNTIME),
        imports=imports.lines(),
        text=text,
    )
    return fit_text(rendered)
