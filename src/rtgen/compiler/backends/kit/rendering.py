"""Jinja environments, one per output language, strict about missing names.

The suffix of a template's file before `.j2` determines the language, and the treatment of inserted
values: `Code` of the language is inserted unchanged, other text is quoted, or rejected if only code
or a name is allowed. So a text of a definition cannot become code because of a forgotten filter.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from contextvars import ContextVar
from functools import cache
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING

import msgspec
from markupsafe import Markup

from rtgen.compiler.backends.kit.quoting import names, properties, python, scripts, xml
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
    ".xml": _XML,
    ".svg": _XML,
    **dict.fromkeys((".cdl", ".eds", ".h", ".idl", ".md", ".toml", ".txt"), _NAMES),
}
"""The output languages by the suffix of their files."""


def render(template: str, **values: object) -> str:
    """Render a template below `rtgen/templates`; return code of the template's language."""
    return (RENDERER.get() or render_original)(template, values)


def render_original(template: str, values: Mapping[str, object]) -> str:
    """Render one of rtgen's templates, whatever a project lays over it."""
    return language_of(template).code(_template(template).render(values))


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
    return LANGUAGES[_suffix(template)]


def _suffix(template: str) -> str:
    return PurePosixPath(template).suffixes[-2]


@cache
def _template(name: str) -> Template:
    return _environment(_suffix(name)).get_template(name)


@cache
def _environment(suffix: str) -> Environment:
    from jinja2 import Environment, FileSystemLoader

    return configured(Environment, suffix, FileSystemLoader(FOLDER))


def configured(kind: type[Environment], suffix: str, loader: BaseLoader) -> Environment:
    """Return an environment for the templates of the language with the suffix."""
    from jinja2 import StrictUndefined

    from rtgen.compiler.backends.kit.compiled_templates import CompiledTemplates

    language = LANGUAGES[suffix]
    environment = kind(
        loader=loader,
        bytecode_cache=CompiledTemplates(
            FOLDER / "__pycache__", f"{kind.__name__} {suffix}"
        ),
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
