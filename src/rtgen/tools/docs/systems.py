"""Pages of systems: the wiring as a picture whose boxes are links; instances, connections."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

from rtgen.compiler.backends.kit.quoting.markdown import Markdown, code, text
from rtgen.compiler.backends.wiring import render, view_of
from rtgen.compiler.backends.wiring.routing import MAX_WIDTH
from rtgen.compiler.model import Component, System
from rtgen.tools.docs.pages import Content, File, Page, counted
from rtgen.tools.docs.places import Kind


def listed(content: Content) -> None:
    """Assign pages to systems."""
    for system in content.systems:
        content.places.page(Kind.SYSTEM, system.file, system.name)


def pages(
    content: Content, components: Mapping[str, Component]
) -> Iterator[tuple[str, Page, File]]:
    """Yield the name, the page and the picture of each system."""
    for system in content.systems:
        page = Page(content.places.page(Kind.SYSTEM, system.file), system.name)
        picture = _picture(content, page, system, components)
        _add(content, page, system, picture, components)
        yield system.name, page, picture


def _picture(
    content: Content, page: Page, system: System, components: Mapping[str, Component]
) -> File:
    views = {name: view_of(c) for name, c in components.items()}
    ways = {
        each.type: url
        for each in system.components
        if (url := content.places.url(Kind.COMPONENT, each.type, page.path))
    }
    drawn = render(system, views, (), content.model.buses, links=ways)
    return File(f"{page.path}.svg", drawn)


def _whole(picture: str) -> str:
    """Return the class of a picture that is shown as a whole.

    One of which the text would be too small is as wide as the page, and higher.
    """
    size = re.search(r'width="(\d+)" height="(\d+)"', picture)
    assert size is not None
    width, height = int(size[1]), int(size[2])
    return " whole" if width > MAX_WIDTH or height <= MAX_WIDTH else ""


def _add(
    content: Content,
    page: Page,
    system: System,
    picture: File,
    components: Mapping[str, Component],
) -> None:
    page.description(system.abstract)
    if not page.summary:
        page.summary = counted(["component"] * len(system.components))
    page.add(f"Defined in {code(content.keys.get(system.file, system.file))}.")
    page.heading(2, "Wiring")
    name = picture.path.rpartition("/")[2]
    label = text(f"Wiring of {system.name}")
    page.add(
        f'<div class="wiring{_whole(picture.text)}">'
        f'<object type="image/svg+xml" data="{name}" aria-label="{label}"></object></div>',
        f"[The picture alone]({name})",
    )
    page.heading(2, "Components")
    page.table(
        ("instance", "component", "rate", "configuration set"),
        [
            (
                code(c.instance),
                content.places.link(Kind.COMPONENT, c.type, page.path),
                "" if c.rate is None else f"{c.rate:g} Hz",
                code(c.active_set),
            )
            for c in system.components
        ],
    )
    units = {
        name: {each.name: each.unit for each in component.configuration}
        for name, component in components.items()
    }
    values = [
        (code(c.instance), code(set_id), code(name), code(value), unit.get(name, ""))
        for c in system.components
        for unit in [units.get(c.type, {})]
        for set_id, pairs in c.parameter_sets
        for name, value in pairs
    ]
    if values:
        page.heading(2, "Values")
        page.table(("instance", "set", "parameter", "value", "unit"), values)
    page.heading(2, "Connections")
    page.table(
        ("from", "to", "properties"),
        [
            (
                code(str(each.source)),
                code(str(each.target)),
                Markdown("<br>".join(code(f"{k}={v}") for k, v in each.properties)),
            )
            for each in system.connections
        ],
    )
