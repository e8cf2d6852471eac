"""Formatting: the form of `rtgen fmt`, for a document or the statements in a range."""

from __future__ import annotations

from lsprotocol.types import Range, TextEdit

from rtgen.formatting import DEFAULT, LexicalError, Options, changed_text, edits
from rtgen.formatting import Language as Form
from rtgen.language_server.documents import Language
from rtgen.language_server.text import Shift
from rtgen.language_server.workspace import View

_FORMS = {Language.IDL: Form.IDL, Language.CDL: Form.CDL}


def formatting(view: View, range_: Range | None = None) -> list[TextEdit]:
    """The edits that give a document its form; none where the text is not made of tokens."""
    form = _FORMS.get(view.language)
    if form is None:
        return []
    options = DEFAULT
    if view.analysis is not None:
        settings = view.analysis.project.form.items()
        options = Options(**{key.replace("-", "_"): value for key, value in settings})
    source = view.text.source
    lines = None if range_ is None else (range_.start.line + 1, range_.end.line + 1)
    try:
        if "\r" not in source:
            return [
                TextEdit(view.range(edit.start, edit.end), edit.text)
                for edit in edits(source, form, options, lines)
            ]
        made = changed_text(source.replace("\r\n", "\n"), form, options, lines)
    except LexicalError:
        return []
    new = made.replace("\n", "\r\n")
    shift = Shift.between(source, new)
    if shift.start == shift.old == shift.new:
        return []
    return [TextEdit(view.range(shift.start, shift.old), new[shift.start : shift.new])]
