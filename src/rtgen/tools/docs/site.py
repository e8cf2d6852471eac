"""The site: all pages of a project, its index, and the settings of MkDocs."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

from rtgen.compiler.backends.kit.quoting.markdown import Markdown, link
from rtgen.compiler.model import Extensibility, Model, System
from rtgen.tools.docs import canopen, components, systems, tecs, types
from rtgen.tools.docs.pages import Content, File, Page
from rtgen.tools.docs.places import Kind, Places

SETTINGS = "mkdocs.yml"
PAGES = "docs"
"""The folder of the pages, beside the settings."""

_TEMPLATES = Path(__file__).parents[2] / "templates" / "documentation"
ASSETS = {
    "site.css": _TEMPLATES / "site.css",
    # The plug-in `offline` would load its own from the network unless a file of this name exists.
    "iframe-worker.js": _TEMPLATES / "folder_worker.js",
}
"""Files that pages load in addition to the theme, by path."""

_Listed = tuple[str, Page]


def site(
    title: str,
    model: Model,
    all_systems: Sequence[System],
    *,
    xcdr2: bool = False,
    extensibility: str = "final",
) -> list[File]:
    """Return the files of a site; the same model gives the same files.

    `model` is the result of all lowerings. `xcdr2` and `extensibility` are the project's defaults.
    """
    content = Content(
        title=title,
        model=model,
        systems=tuple(all_systems),
        places=Places(),
        keys=_keys(model),
        xcdr2=xcdr2,
        extensibility=Extensibility(extensibility),
    )
    modules = types.listed(content)
    known = components.listed(content)
    signatures = tecs.listed(content)
    devices = content.assign(Kind.DEVICE, {d.name: d for d in model.devices})
    buses = content.assign(Kind.BUS, {b.name: b for b in model.buses})
    systems.listed(content)
    pictures: list[File] = []
    drawn: list[_Listed] = []
    for name, page, picture in systems.pages(content, known):
        drawn.append((name, page))
        pictures.append(picture)
    chapters: dict[str, list[_Listed]] = {
        "Systems": drawn,
        "Components": [*content.pages(Kind.COMPONENT, known, components.add)],
        "Types and interfaces": [*types.pages(content, modules)],
        "Signatures": [*content.pages(Kind.SIGNATURE, signatures, tecs.add)],
        "Devices": [*content.pages(Kind.DEVICE, devices, canopen.add_device)],
        "Buses": [*content.pages(Kind.BUS, buses, canopen.add_bus)],
    }
    chapters = {
        chapter: sorted(pages, key=lambda each: (each[0].casefold(), each[1].path))
        for chapter, pages in chapters.items()
        if pages
    }
    made = [_index(title, chapters)]
    made += [page for pages in chapters.values() for _, page in pages]
    files = [page.file for page in made] + pictures
    return [
        *(File(f"{PAGES}/{file.path}", file.text) for file in files),
        *(
            File(f"{PAGES}/{path}", asset.read_text("utf-8"))
            for path, asset in ASSETS.items()
        ),
        File(SETTINGS, _settings(title, chapters)),
    ]


def _keys(model: Model) -> dict[str, str]:
    """Map the displayed path of each file to its path relative to the project."""
    models = (model, *(package.model for package in model.packages))
    files = {f.name: f.key for each in models for f in each.files}
    files |= {d.file: d.key for d in model.devices}
    return files | {b.file: b.key for b in model.buses}


def _index(title: str, chapters: Mapping[str, Sequence[_Listed]]) -> Page:
    page = Page("index", title)
    for chapter, pages in chapters.items():
        page.heading(2, chapter)
        rows = [
            (Markdown(link(f"{entry.path}.md", name)), entry.summary)
            for name, entry in pages
        ]
        page.table(("name", "description"), rows)
    if not chapters:
        page.add("The project defines nothing yet.")
    return page


def _settings(title: str, chapters: Mapping[str, Sequence[_Listed]]) -> str:
    """Return the settings of MkDocs. JSON is valid YAML, and quotes any text."""
    navigation: list[dict[str, object]] = [{"Overview": "index.md"}]
    for chapter, pages in chapters.items():
        entries = [{name: f"{page.path}.md"} for name, page in pages]
        navigation.append({chapter: entries})
    template = json.loads((_TEMPLATES / "mkdocs.json").read_text("utf-8"))
    settings = {"site_name": title, **template, "nav": navigation}
    return json.dumps(settings, indent=2) + "\n"
