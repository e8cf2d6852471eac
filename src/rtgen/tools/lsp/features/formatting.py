"""Formatting as `rtgen fmt` does, of a document or of the statements in a range."""

from __future__ import annotations

from collections.abc import Callable

from lsprotocol.types import Range, TextEdit

from rtgen.compiler.diagnostics import InputError, ToolError
from rtgen.tools.fmt import DEFAULT, Options, changed_text, edits, toml
from rtgen.tools.fmt.tokens import Language as Form
from rtgen.tools.fmt.tokens import LexicalError
from rtgen.tools.indexing.text import Shift
from rtgen.tools.lsp.documents import Language
from rtgen.tools.lsp.workspace import View

_FORMS = {Language.IDL: Form.IDL, Language.CDL: Form.CDL}
_TOML = (Language.BUS, Language.PROJECT)


def formatting(
    view: View, range_: Range | None = None, check: Callable[[], None] = lambda: None
) -> list[TextEdit]:
    """Return the edits that format a document; none if it cannot be formatted.

    `check` is called now and then, and can end the work by an exception.
    """
    form = _FORMS.get(view.language)
    if form is None and not (view.language in _TOML and toml.is_available()):
        return []
    options = DEFAULT
    if view.analysis is not None:
        settings = view.analysis.project.form.items()
        options = Options(**{key.replace("-", "_"): value for key, value in settings})
    source = view.text.source
    plain = view.text.normal
    lines = None if range_ is None else (range_.start.line + 1, range_.end.line + 1)
    try:
        if form is not None and plain == source:
            return [
                TextEdit(view.range(edit.start, edit.end), edit.text)
                for edit in edits(source, form, options, lines, check)
            ]
        if form is None:
            formatted = toml.changed_text(plain, view.document.path, options, lines)
        else:
            formatted = changed_text(plain, form, options, lines, check)
    except (LexicalError, InputError, ToolError):
        return []
    new = formatted.replace("\n", "\r\n") if "\r\n" in source else formatted
    new = source[: source.startswith("\ufeff")] + new
    shift = Shift.between(source, new)
    if shift.start == shift.old == shift.new:
        return []
    return [TextEdit(view.range(shift.start, shift.old), new[shift.start : shift.new])]
