"""Jinja environments, one per output language, strict about missing names.

The suffix of a template's file before `.j2` determines the language, and the treatment of inserted
values: `Code` of the language is inserted unchanged, other text is quoted, or rejected if only code
or a name is allowed, as in files with any other suffix. So a text of a definition cannot become
code because of a forgotten filter.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextvars import ContextVar
from functools import cache
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING

import msgspec
from markupsafe import Markup

from rtgen.compiler.backends.kit.quoting import (
    names,
    properties,
    python,
    scripts,
    typescript,
    xml,
)
from rtgen.compiler.backends.kit.statements import statements

if TYPE_CHECKING:
    from jinja2 import BaseLoader, Environment, Template

FOLDER = Path(__file__).resolve().parents[3] / "templates"
"""The folder of rtgen's templates."""

_NOT_GENERATED = ("new/", "wiring/")
"""Templates of files that `rtgen generate` does not write."""

RENDERER: ContextVar[Callable[..., str] | None] = ContextVar("renderer", default=None)
"""Renders instead of `render`, for a project with templates of its own."""


class Language(msgspec.Struct, frozen=True):
    """An output language: default filter of inserted values, its result type, further filters."""

    quote: Callable[[object], str]
    code: type[str]
    filters: Mapping[str, Callable[..., str]] = {}

    def join(self, values: Iterable[object], separator: str = "") -> str:
        """Implement the filter `join`: values are quoted, the separator belongs to the template."""
        return self.code(separator.join(map(self.quote, values)))


_NAMES = Language(names.quote_name, names.Names)
_XML = Language(xml.quote_xml, Markup, {"comment": xml.xml_comment})
LANGUAGES: Mapping[str, Language] = {
    ".py": Language(
        python.quote,
        python.Python,
        {
            "literal": python.string_literal,
            "in_docstring": python.in_docstring,
            "comment": python.comment_text,
            "code": python.Python,
            "statements": statements,
        },
    ),
    ".conf": Language(
        properties.quote_conf,
        properties.Conf,
        {"key": properties.conf_key, "comment": properties.conf_comment},
    ),
    ".sh": Language(
        scripts.quote_shell, scripts.Shell, {"comment": scripts.shell_comment}
    ),
    ".bat": Language(
        scripts.quote_batch, scripts.Batch, {"comment": scripts.batch_comment}
    ),
    ".rb": Language(
        scripts.quote_ruby,
        scripts.Ruby,
        {"literal": scripts.ruby_string, "comment": scripts.ruby_comment},
    ),
    ".ts": Language(
        typescript.quote,
        typescript.TypeScript,
        {
            "literal": typescript.string,
            "comment": typescript.comment,
            "property": typescript.property_name,
            "code": typescript.TypeScript,
        },
    ),
    ".xml": _XML,
    ".svg": _XML,
}
"""The output languages with quoting of their own, by the suffix of their files."""


def render(template: str, **values: object) -> str:
    """Render a template below `rtgen/templates`; return code of the template's language."""
    return (RENDERER.get() or render_original)(template, values)


def render_original(template: str, values: Mapping[str, object]) -> str:
    """Render one of rtgen's templates, whatever a project lays over it."""
    return language_of(template).code(_template(template).render(values))


def write_code() -> None:
    """Write the code of the templates of generated files, when rtgen is packed. Raises OSError."""
    from rtgen.compiler.backends.kit.compiled_templates import write

    write({name: _environment(suffix_of(name)) for name in template_names()})


@cache
def template_names() -> tuple[str, ...]:
    """Return the names of the templates of generated files, over which a project may lay others."""
    names = (path.relative_to(FOLDER).as_posix() for path in FOLDER.rglob("*.j2"))
    return tuple(sorted(n for n in names if not n.startswith(_NOT_GENERATED)))


def template_source(name: str) -> str:
    """Return the text of one of rtgen's templates."""
    return (FOLDER / name).read_text("utf-8")


def language_of(template: str) -> Language:
    """Return the output language of a template."""
    return LANGUAGES.get(suffix_of(template), _NAMES)


def suffix_of(template: str) -> str:
    """Return the suffix of the files of a template, which has `.j2` behind it."""
    return PurePosixPath(template.removesuffix(".j2")).suffix


@cache
def _template(name: str) -> Template:
    return _environment(suffix_of(name)).get_template(name)


@cache
def _environment(suffix: str) -> Environment:
    from jinja2 import Environment

    from rtgen.compiler.backends.kit.compiled_templates import CompiledLoader

    return configured(Environment, suffix, CompiledLoader(FOLDER))


def configured(kind: type[Environment], suffix: str, loader: BaseLoader) -> Environment:
    """Return an environment for the templates of the language with the suffix."""
    from jinja2 import StrictUndefined

    language = LANGUAGES.get(suffix, _NAMES)
    environment = kind(
        loader=loader,
        auto_reload=False,
        undefined=StrictUndefined,
        # Macros then return markup, which is not quoted again.
        autoescape=language.code is Markup,
        finalize=language.quote,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    # Templates use none of them, and each call of a template would copy them.
    environment.globals.clear()
    environment.filters |= {"length_text": _length_text, "join": language.join}
    environment.filters |= language.filters
    return environment


def _length_text(value: float) -> str:
    """Return a length in a drawing, with at most one decimal."""
    return f"{value:.1f}".removesuffix(".0")
