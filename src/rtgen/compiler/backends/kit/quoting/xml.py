"""XML and SVG: text, attributes, and comments."""

from __future__ import annotations

import re

from markupsafe import Markup, escape

from rtgen.compiler.backends.kit.quoting.code import UnquotableError
from rtgen.compiler.kit.xml_text import NOT_IN_XML

_SPACE = str.maketrans({"\t": "&#9;", "\n": "&#10;", "\r": "&#13;"})
_QUOTED = re.compile(f"""[&<>"'\t\n\r]|{NOT_IN_XML.pattern}""")
"""Characters that are quoted."""
_HYPHENS = re.compile("-(?=-|$)")


def quote_xml(value: object) -> Markup:
    """Filter of XML templates: accepts markup, quotes text for elements and attributes.

    Line breaks and tabs are preserved in attributes, too. Raises UnquotableError.
    """
    if isinstance(value, Markup):
        return value
    text = str(value)
    if not _QUOTED.search(text):
        return Markup(text)
    if NOT_IN_XML.search(text):
        raise UnquotableError(text, "XML")
    return Markup(str(escape(text)).translate(_SPACE))


def xml_comment(text: str) -> Markup:
    """Return the text for a comment: no double hyphens, none at the end."""
    return Markup(escape(_HYPHENS.sub("- ", NOT_IN_XML.sub(" ", text))))
