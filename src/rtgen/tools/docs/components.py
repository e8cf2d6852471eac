"""Pages of components: ports, parameters, life cycle, and connected components."""

from __future__ import annotations

from collections.abc import Mapping

from rtgen.compiler.backends.kit.idl_text.literals import default_text
from rtgen.compiler.backends.kit.member_texts import limits_text
from rtgen.compiler.backends.kit.quoting.markdown import Markdown, code
from rtgen.compiler.model import Component, ConfigurationParameter, Port, PortKind
from rtgen.compiler.typemap.components.actions import ACTIONS
from rtgen.tools.docs.pages import Content, Page
from rtgen.tools.docs.places import Kind

_STATES = (
    ("CREATED", "on_initialize, on_finalize"),
    ("INACTIVE", "on_activated, on_deactivated on the way to ACTIVE and back"),
    ("ACTIVE", "on_execute, on_state_update in every cycle"),
    ("ERROR", "on_aborting once, on_error in every cycle, on_reset on the way out"),
)


def listed(content: Content) -> Mapping[str, Component]:
    """Return the components by name, and assign pages to them."""
    models = (content.model, *(p.model for p in content.model.packages))
    found: dict[str, Component] = {}
    for model in models:
        for declaration in model.declarations:
            if isinstance(declaration, Component):
                found.setdefault(declaration.name[-1], declaration)
    return content.assign(Kind.COMPONENT, found)


def add(content: Content, page: Page, c: Component) -> None:
    """Fill the page of a component."""
    page.description(c.doc or c.description)
    page.table(
        ("property", "value"),
        [
            ("defined in", content.source(c.file, c.span)),
            ("profile", code(c.profile_id)),
            ("kind", c.kind),
            (
                "activity",
                (
                    f"{c.activity}, {c.rate:g} Hz"
                    if c.activity == "PERIODIC"
                    else ", on ".join((c.activity, *c.trigger_ports))
                ),
            ),
            (
                "implemented by",
                code(c.factory or c.runtime_base or "a behaviour of the project"),
            ),
        ],
    )
    page.heading(2, "Ports")
    rows = [_port(content, page.path, c, port) for port in c.ports]
    page.table(("port", "kind", "type", "unit", "connected with", "description"), rows)
    if not rows:
        page.add("None.")
    page.heading(2, "Parameters")
    page.table(
        ("parameter", "type", "default", "range", "unit", "description"),
        [_parameter(content, page.path, each) for each in c.configuration],
    )
    if not c.configuration:
        page.add("None.")
    page.heading(2, "Life cycle")
    page.table(("state", "callbacks"), [(code(s), text) for s, text in _STATES])
    own = {action.method for action in ACTIONS if action.implemented}
    page.add(f"A new skeleton has {', '.join(code(m) for m in sorted(own))}.")
    _add_systems(content, page, c)


def _port(content: Content, here: str, c: Component, port: Port) -> tuple[object, ...]:
    return (
        code(port.name),
        port.kind.word,
        content.places.type(port.type, here),
        port.unit,
        _peers(content, here, c, port),
        port.doc,
    )


def _peers(content: Content, here: str, c: Component, port: Port) -> Markdown:
    """Return the ports of other components that systems connect to a port."""
    found: dict[str, None] = {}
    names = (
        {port.name} if port.kind in (PortKind.INPORT, PortKind.OUTPORT) else {port.port}
    )
    for system in content.systems:
        types = {each.instance: each.type for each in system.components}
        for connection in system.connections:
            both = (connection.source, connection.target)
            for end, other in (both, both[::-1]):
                if types.get(end.instance) == c.name[-1] and end.port in names:
                    type_ = types.get(other.instance, other.instance)
                    link = content.places.link(Kind.COMPONENT, type_, here)
                    found[f"{link} {code(other.port)}"] = None
    return Markdown("<br>".join(found))


def _parameter(
    content: Content, here: str, p: ConfigurationParameter
) -> tuple[object, ...]:
    bounds = limits_text((p.minimum, p.maximum)) or p.constraint
    default = "" if p.default is None else code(default_text(p.default))
    return (
        code(p.name),
        content.places.type(p.type, here),
        default,
        bounds,
        p.unit,
        p.doc,
    )


def _add_systems(content: Content, page: Page, c: Component) -> None:
    rows = [
        (
            content.places.link(Kind.SYSTEM, system.file, page.path, system.name),
            code(each.instance),
        )
        for system in content.systems
        for each in system.components
        if each.type == c.name[-1]
    ]
    if rows:
        page.heading(2, "Systems")
        page.table(("system", "instance"), rows)
