"""Jinja environments, one per output language, strict about missing names.

The suffix of a template's file before `.j2` determines the language, and the treatment of inserted
values: `Code` of the language is inserted unchanged, other text is quoted, or rejected if only code
or a name is allowed. So a text of a definition cannot become code because of a forgotten filter.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import cache
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING

import msgspec
from markupsafe import Markup

from rtgen.backends.kit.quoting import names, properties, python, scripts, xml

if TYPE_CHECKING:
    from jinja2 import Environment, Template

_FOLDER = Path(__file__).resolve().parents[2] / "templates"


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
    found, language = _template(template)
    return language.code(found.render(values))


@cache
def _template(name: str) -> tuple[Template, Language]:
    suffix = PurePosixPath(name).suffixes[-2]
    return _environment(suffix).get_template(name), LANGUAGES[suffix]


@cache
def _environment(suffix: str) -> Environment:
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    from rtgen.backends.kit.compiled_templates import CompiledTemplates

    language = LANGUAGES[suffix]
    environment = Environment(
        loader=FileSystemLoader(_FOLDER),
        bytecode_cache=CompiledTemplates(_FOLDER / "__pycache__", suffix),
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
