"""Turns parser errors into diagnostics about their likely cause, and decides how to recover."""

from rtgen.compiler.frontends.idl.syntax.syntax_errors.characters import (
    bad_character,
    is_blank,
    meant,
)
from rtgen.compiler.frontends.idl.syntax.syntax_errors.context import ErrorContext
from rtgen.compiler.frontends.idl.syntax.syntax_errors.recognizers import explain
from rtgen.compiler.frontends.kit.syntax_errors import Recovery

__all__ = ["ErrorContext", "Recovery", "bad_character", "explain", "is_blank", "meant"]
