"""Pages of the site that are made of the program: commands of click, diagnostics of the rules."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from typing import Any

import click
from mkdocs.structure.files import File, Files

from rtgen import api, runtime
from rtgen.cli import application
from rtgen.compiler.diagnostics.explain import rules, story
from rtgen.tools.docs.site import ASSETS

_OUTSIDE = re.compile(r"!?\[([^\]]*)\]\((?:\.\./)+(?!decisions/)[^)]*\)")


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
    if page.file.src_uri.startswith("decisions/"):
        return re.sub(r"!?\[([^\]]*)\]\((?:\.\./){2,}[^)]*\)", r"\1", markdown)
    return _OUTSIDE.sub(r"\1", markdown)


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
