"""Templates: one environment for text and one that escapes for XML, strict about missing names."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from markupsafe import Markup, escape

if TYPE_CHECKING:
    from jinja2 import Environment

_FOLDER = Path(__file__).resolve().parents[1] / "templates"
_XML_SPACE = str.maketrans({"\t": "&#9;", "\n": "&#10;", "\r": "&#13;"})


def render(template: str, **values: object) -> str:
    """The text of a template below `rtgen/templates`, with nothing escaped."""
    return _environment(False).get_template(template).render(values)


def render_xml(template: str, **values: object) -> str:
    """The same with values escaped for XML text and attributes, their line breaks too."""
    return _environment(True).get_template(template).render(values)


@cache
def _environment(xml: bool) -> Environment:
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(_FOLDER),
        undefined=StrictUndefined,
        autoescape=xml,
        finalize=_for_xml if xml else None,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters["length_text"] = _length_text
    return environment


def _for_xml(value: object) -> Markup:
    if isinstance(value, Markup):
        return value
    return Markup(str(escape(value)).translate(_XML_SPACE))


def _length_text(value: float) -> str:
    """A length in a drawing, with at most one decimal."""
    return f"{value:.1f}".removesuffix(".0")
