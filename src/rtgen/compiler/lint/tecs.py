"""Lint checks of TECS definitions."""

from __future__ import annotations

from collections.abc import Iterator

from rtgen.compiler.diagnostics import Diagnostic, Span
from rtgen.compiler.layouts.tdr_messages import problems
from rtgen.compiler.lint import rules
from rtgen.compiler.lint.context import Context
from rtgen.compiler.model.tecs import Signature


def signatures(context: Context) -> Iterator[Diagnostic]:
    """Report functions that no join through a transport can transfer."""
    seen: set[Span] = set()
    for unit in context.model.tecs:
        for signature in unit.declarations:
            if not isinstance(signature, Signature) or signature.span in seen:
                continue
            if not context.is_given(signature.span.file):
                continue
            seen.add(signature.span)
            for problem in problems(unit, signature):
                yield rules.NOT_CARRIED.at(
                    problem.span,
                    f"{signature.scoped} stays within a link unit: {problem.reason}",
                    hint=problem.hint,
                )
