"""Rules, the sources of diagnostics. Quick to import: a page needs no diagnostic."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from rtgen.compiler.diagnostics.severities import Severity
from rtgen.facts.looks import CONTENT, look

if TYPE_CHECKING:
    from rtgen.compiler.diagnostics.findings import Diagnostic, Related, Span

_PAGES = Path(__file__).parent / "pages"
_HINTS = Path(__file__).with_name("hints.toml")


MAX_TEXT_LENGTH = 1000
"""Maximum length of a message, hint or label in characters; quotations of a file may be longer."""


class Rule(NamedTuple):
    """A rule: the source of its diagnostics and of the page of `rtgen explain`.

    `text` is the explanation of a plug-in's rule; rtgen's own rules have theirs in a file.
    """

    code: str
    title: str
    severity: Severity
    text: str | None = None

    @property
    def explanation(self) -> str:
        """Markdown: the error, an example, and how to fix it; read from `pages/<code>.md`.

        Empty for a plug-in's rule without one.
        """
        if self.text is not None:
            return self.text
        return _page(self.code)

    def at(
        self,
        span: Span | None,
        message: str,
        *,
        related: Iterable[Related] = (),
        hint: str | None = None,
    ) -> Diagnostic:
        """Return a diagnostic; texts longer than MAX_TEXT_LENGTH are cut in the middle.

        Without a `hint`, the rule's hint in `hints.toml` is used, if there is one.
        """
        from rtgen.compiler.diagnostics.findings import Diagnostic, Related

        if hint is None:
            hint = _hints().get(self.code)
        return Diagnostic(
            self.code,
            self.severity,
            _shortened(message),
            span,
            tuple(Related(each.span, _shortened(each.label)) for each in related),
            None if hint is None else _shortened(hint),
        )


def rules_of(names: Mapping[str, object]) -> tuple[Rule, ...]:
    """Return the rules among the `globals()` of a module, in order."""
    return tuple(value for value in names.values() if isinstance(value, Rule))


@cache
def _page(code: str) -> str:
    page = _PAGES / f"{code}.md"
    look(CONTENT, page)
    return page.read_text(encoding="utf-8") if page.is_file() else ""


@cache
def _hints() -> dict[str, str]:
    import tomllib

    return tomllib.loads(_HINTS.read_text(encoding="utf-8"))


def _shortened(text: str) -> str:
    if len(text) <= MAX_TEXT_LENGTH:
        return text
    half = MAX_TEXT_LENGTH // 2
    return f"{text[:half]} [...] {text[-half:]}"
