"""Pages of the site that are made of the program: commands of click, diagnostics of the rules."""

from __future__ import annotations

import inspect
import posixpath
import re
from collections.abc import Iterator
from typing import Any

import click
from mkdocs.structure.files import File, Files
from mkdocs.structure.nav import Navigation
from mkdocs.structure.pages import Page

from rtgen import api, runtime
from rtgen.cli import application
from rtgen.compiler.diagnostics.explain import rules, story
from rtgen.tools.docs.site import ASSETS

_LINK = re.compile(r"!?\[([^\]]*)\]\((\.\./[^)]*)\)")
_JAPANESE = "ja/"
"""The folder of the Japanese pages."""


def on_files(files: Files, *, config: Any, **_: Any) -> Files:
    """Add the pages of the reference."""
    made = {
        "reference/commands.md": _commands(),
        "reference/diagnostics.md": _diagnostics(),
        "reference/python.md": _python(),
    }
    for path, text in made.items():
        files.append(File.generated(config, path, content=text))
    for path, asset in ASSETS.items():
        files.append(File.generated(config, path, content=asset.read_text("utf-8")))
    return files


def on_page_markdown(markdown: str, *, page: Any, **_: Any) -> str:
    """Links to files of the repository that are no pages become their texts."""
    folder = posixpath.dirname(page.file.src_uri)

    def shown(link: re.Match[str]) -> str:
        target = posixpath.normpath(posixpath.join(folder, link[2]))
        return link[1] if target.startswith("..") else link[0]

    return _LINK.sub(shown, markdown)


def on_page_context(context: Any, *, page: Page, config: Any, nav: Navigation) -> Any:
    """A Japanese page has Japanese menus and the Japanese pages beside it.

    The choice of the language leads to the same page, or to the first one in that language.
    """
    pages = {each.file.src_uri: each for each in nav.pages}
    japanese = [each for uri, each in pages.items() if uri.startswith(_JAPANESE)]
    name = page.file.src_uri.removeprefix(_JAPANESE)
    is_japanese = page in japanese
    config.theme["language"] = "ja" if is_japanese else "en"
    for entry in config.extra["alternate"]:
        folder = _JAPANESE if entry["lang"] == "ja" else ""
        form = pages.get(folder + name, pages[f"{folder}README.md"])
        entry["link"] = form.url
    if is_japanese:
        context["nav"] = Navigation(japanese, japanese)
        context["nav"].homepage = pages[f"{_JAPANESE}README.md"]
    return context


def _commands() -> str:
    context = click.Context(application, info_name="rtgen")
    parts = [
        f"## {path}\n\n```text\n{command.get_help(inner)}\n```\n"
        for path, command, inner in _walk(application, context)
    ]
    return (
        "# Options of all commands\n\n*For those who look up an option.*\n\n"
        + "\n".join(parts)
    )


def _walk(
    command: click.Command, context: click.Context
) -> Iterator[tuple[str, click.Command, click.Context]]:
    yield context.command_path, command, context
    if isinstance(command, click.Group):
        for name in command.list_commands(context):
            inner = command.get_command(context, name)
            assert inner is not None
            yield from _walk(inner, click.Context(inner, context, name))


def _diagnostics() -> str:
    texts = (re.sub(r"^#", "##", story(rule), count=1) for rule in rules().values())
    return "# All findings\n\n*For those who have a code.*\n\n" + "\n".join(texts)


def _python() -> str:
    parts = ["# Python\n\n*For those who call rtgen or its runtime from a program.*\n"]
    for module in (api, runtime):
        parts.append(f"## {module.__name__}\n")
        for name in sorted(module.__all__):
            documentation = inspect.getdoc(getattr(module, name)) or ""
            parts.append(f"### {name}\n\n```text\n{documentation}\n```\n")
    return "\n".join(parts)
