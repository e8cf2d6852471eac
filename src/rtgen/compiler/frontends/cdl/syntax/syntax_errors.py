"""Recognizers of common syntax errors of CDL, by the context of the unexpected token."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from unicodedata import normalize

from rtgen.compiler.diagnostics import Diagnostic, Span
from rtgen.compiler.frontends.cdl.rules import lexical, syntax, types
from rtgen.compiler.frontends.cdl.syntax.keywords import (
    RESERVED,
    SPECIFIERS,
    TERMINALS,
    WORDS,
)
from rtgen.compiler.frontends.cdl.syntax.unit import TypeNames, Unit
from rtgen.compiler.frontends.cdl.text.source import ANGLE_MARK
from rtgen.compiler.frontends.kit.lalr import END
from rtgen.compiler.frontends.kit.suggestions import nearest
from rtgen.compiler.frontends.kit.syntax_errors import BaseContext, Recovery

_WORD = re.compile(
    r'"(?:[^"\\\n]|\\.)*"?|\'(?:\\.|[^\'\\\n])\'|::|<<|>>|=>|<=|>=|\w+|[^\s\w]',
    re.DOTALL,
)
_STATEMENTS = (
    *("namespace", "signature", "celltype", "cell", "composite", "region", "typedef"),
    *("const", "struct", "enum", "import", "import_C", "generate"),
)
_FOREIGN_TYPES = {
    "float": "float32_t",
    "double": "double64_t",
    "bool": "bool_t",
    "boolean": "bool_t",
    "int8": "int8_t",
    "int16": "int16_t",
    "int32": "int32_t",
    "int64": "int64_t",
    "uint8": "uint8_t",
    "uint16": "uint16_t",
    "uint32": "uint32_t",
    "uint64": "uint64_t",
    "byte": "uint8_t",
    "octet": "uint8_t",
    "float64_t": "double64_t",
    "double_t": "double64_t",
    "float_t": "float32_t",
    "size_t": "uint32_t",
}
_SEMICOLON = re.compile(r"\s*;")
_NUMBER_BEFORE = re.compile(r"(?:0x[0-9A-Fa-f]+|[0-9]+\.?[0-9]*)\Z")
_IDEOGRAPHIC = {"\u3000": " ", "\u3001": ",", "\u3002": "."}


@dataclass(frozen=True, eq=False, kw_only=True)
class ErrorContext(BaseContext):
    """An unexpected token of CDL and its surroundings.

    `lacks_types`: a missing file may declare types.
    """

    unit: Unit
    types: TypeNames
    lacks_types: bool

    @property
    def code(self) -> str:
        return self.unit.source.code

    def span(self, start: int, end: int) -> Span:
        return self.unit.span(start, end)

    def span_after(self, offset: int) -> Span:
        return self.unit.source.after(offset)

    @staticmethod
    def shown(terminal: str) -> str:
        return _shown(terminal)

    @cached_property
    def before(self) -> list[str]:
        """The tokens of the statement before the unexpected one."""
        return _WORD.findall(self.code, self.statement, self.last)

    @cached_property
    def after(self) -> list[str]:
        """Some tokens after the unexpected one."""
        return _WORD.findall(self.code, self.end, self.end + 400)

    @property
    def previous(self) -> str:
        """The token before the unexpected one."""
        return self.before[-1] if self.before else ""

    @property
    def following(self) -> str:
        """The token after the unexpected one."""
        return self.after[0] if self.after else ""

    @property
    def is_word(self) -> bool:
        """Whether the token is an identifier or a keyword."""
        return self.text[:1].isalpha() or self.text[:1] == "_"


_THROUGH = (
    "through is in brackets in front of a join: "
    '[through( RTCPlugin, "" )] cCall = Cell.eEntry;'
)


def explain(context: ErrorContext) -> Recovery:
    """Return the recovery for the likely cause of an unexpected token."""
    for recogniser in _RECOGNISERS:
        recovery = recogniser(context)
        if recovery is not None:
            return recovery
    subject = f"'{context.text[:40]}'" if context.text else "this"
    message = f"{subject} is not allowed here{context.expectation()}"
    if "through" in (*context.before, context.text, *context.after[:3]):
        return context.recovery(syntax.UNEXPECTED, message, _THROUGH)
    return context.recovery(syntax.UNEXPECTED, message)


def _shown(terminal: str) -> str:
    if terminal in WORDS:
        return f"'{WORDS[terminal]}'"
    return {
        "IDENT": "a name",
        "TYPE_NAME": "a type",
        "NUMBER": "a number",
        "STRING": "a string",
        "ANGLE": "a file name in <...>",
        "CHARACTER": "a character",
        "SHIFT": "'<<'",
        "EQUALITY": "'=='",
        "DIVISION": "'/'",
        END: "the end of the file",
    }.get(terminal, terminal)


def _end(s: ErrorContext) -> Recovery | None:
    if s.kind != END:
        return None
    if s.opening is not None and s.surplus > 0 and not s.before:
        return s.recovery(
            syntax.UNCLOSED_BRACE,
            "this brace is never closed",
            "a statement ends with };",
            at=(s.opening, s.opening + 1),
        )
    if "SEMI" in s.accepted:
        return _semicolon(s)
    return s.recovery(
        syntax.UNEXPECTED_END,
        f"the file ends in the middle of a statement{s.expectation()}",
        after_last=True,
    )


def _semicolon(s: ErrorContext) -> Recovery:
    hint = "every statement ends with ';', also after a closing brace"
    return s.recovery(
        syntax.MISSING_SEMICOLON,
        "a ';' is missing here",
        hint,
        after_last=True,
        feed=("SEMI",),
    )


def _angle(s: ErrorContext) -> Recovery | None:
    if s.kind != "ANGLE":
        return None
    text = s.text.replace(ANGLE_MARK, "<", 1)
    return s.recovery(
        lexical.ANGLE,
        f"{text[:60]} is taken for one name, as in import( <file> )",
        "put the text after the '<' operator on a line without '>'",
    )


def _stray_brace(s: ErrorContext) -> Recovery | None:
    if s.kind != "RBRACE" or s.opening is not None:
        return None
    return s.recovery(
        syntax.STRAY_BRACE,
        "this brace closes nothing",
        "remove it, or find the missing '{'",
        instead=True,
        resume=_after_semicolon(s),
    )


def _after_semicolon(s: ErrorContext) -> int:
    match = _SEMICOLON.match(s.code, s.end)
    return match.end() if match else s.end


def _extra_semicolon(s: ErrorContext) -> Recovery | None:
    if s.kind != "SEMI" or s.before:
        return None
    return s.recovery(
        syntax.EXTRA_SEMICOLON,
        "this ';' ends nothing",
        "remove it",
        instead=True,
    )


def _empty(s: ErrorContext) -> Recovery | None:
    if s.kind != "RBRACE" or s.before or s.opening is None:
        return None
    if s.code[s.opening + 1 : s.start].strip():
        return None
    if "ERROR" not in s.accepted:
        return None
    return s.recovery(
        syntax.EMPTY_BLOCK,
        "this block is empty",
        "remove it, or declare something in it",
        at=(s.opening, s.end),
        feed=("ERROR",),
    )


def _missing_semicolon(s: ErrorContext) -> Recovery | None:
    if "SEMI" not in s.accepted or s.kind in ("ANGLE", "UNKNOWN"):
        return None
    ended = s.previous in ("}", ")", "]") or s.fresh_line
    starts = s.kind == "RBRACE" or s.text in RESERVED or s.text == "["
    if (ended and (starts or s.is_word)) or s.kind == "RBRACE":
        return _semicolon(s)
    return None


def _number(s: ErrorContext) -> Recovery | None:
    if not s.is_word or s.last != s.start:
        return None
    before = _NUMBER_BEFORE.search(s.code, max(0, s.start - 40), s.start)
    if before is None:
        return None
    number = before[0] + s.text
    hint = (
        "hexadecimal numbers begin with 0x"
        if number.startswith("0X")
        else (
            "write a dot, as in 1.e5"
            if s.text[:1] in "eE"
            else "CDL has no suffixes of numbers"
        )
    )
    return s.recovery(
        lexical.NUMBER,
        f"{number} is not a number of CDL",
        hint,
        at=(before.start(), s.end),
        instead=True,
    )


def _qualifier(s: ErrorContext) -> Recovery | None:
    if s.text not in ("const", "volatile") or not s.before:
        return None
    return s.recovery(
        syntax.QUALIFIER,
        f"'{s.text}' belongs before the type, or after a '*'",
        instead=True,
    )


def _specifier(s: ErrorContext) -> Recovery | None:
    """Recognize a word in a specifier list that is not a specifier."""
    if s.kind not in ("IDENT", "TYPE_NAME") or "NULLABLE" not in s.accepted:
        return None
    similar = nearest(s.text, SPECIFIERS)
    return s.recovery(
        syntax.UNKNOWN_SPECIFIER,
        f"'{s.text}' is not a specifier",
        f"did you mean '{similar}'?" if similar else None,
        feed=("NULLABLE",) if s.following in (",", "]") else (),
        instead=s.following in (",", "]"),
    )


def _unknown_type(s: ErrorContext) -> Recovery | None:
    if s.kind != "IDENT" or "TYPE_NAME" not in s.accepted:
        return None
    follower = s.following
    is_use = follower == "*" or follower[:1].isalpha() or follower[:1] == "_"
    in_cast = s.previous == "(" and follower in (")", "*")
    at_statement = "SIGNATURE" in s.accepted
    if at_statement:
        similar = nearest(s.text, _STATEMENTS)
        if similar is not None:
            return s.recovery(
                syntax.MISSPELT_KEYWORD,
                f"'{s.text}' is not a keyword",
                f"did you mean '{similar}'?",
                feed=(TERMINALS[similar],),
                instead=True,
            )
    if not (is_use or in_cast or follower in (",", ")", "(", "[")):
        return None
    if at_statement and not is_use:
        return None
    if s.text == "union":
        return s.recovery(types.UNKNOWN_TYPE, "CDL has no unions")
    if s.lacks_types and s.text not in _FOREIGN_TYPES:
        is_guess = s.text in s.unit.guessed
        s.unit.guessed.add(s.text)
        if is_guess:
            return Recovery(None, ("TYPE_NAME",), instead=True)
        return s.recovery(
            types.GUESSED_TYPE,
            f"'{s.text}' is taken for a type that a missing file declares",
            "name the folder of the C headers by -I",
            feed=("TYPE_NAME",),
            instead=True,
        )
    is_guess = s.text in s.unit.maybe_declared
    s.unit.maybe_declared.add(s.text)
    if is_guess:
        return Recovery(None, ("TYPE_NAME",), instead=True)
    if s.text in _FOREIGN_TYPES:
        hint = f"CDL calls it {_FOREIGN_TYPES[s.text]}"
    else:
        candidates = {*s.types.declared, *s.types.prelude, *_types()}
        near = nearest(s.text, candidates)
        hint = (
            f"did you mean '{near}'?"
            if near
            else "declare it with typedef, or import the file that declares it"
        )
    return s.recovery(
        types.UNKNOWN_TYPE,
        f"the type '{s.text}' is unknown",
        hint,
        feed=("TYPE_NAME",),
        instead=True,
    )


def _types() -> list[str]:
    return [word for word in RESERVED if word.endswith("_t")]


def _long_long(s: ErrorContext) -> Recovery | None:
    if s.text not in ("long", "int", "double") or s.previous not in ("long", "short"):
        return None
    return s.recovery(
        types.UNKNOWN_TYPE,
        f"CDL has no type '{s.previous} {s.text}'",
        "int64_t is the type with 64 bits" if s.previous == "long" else None,
        instead=True,
    )


def _type_as_name(s: ErrorContext) -> Recovery | None:
    if s.kind != "TYPE_NAME" or "IDENT" not in s.accepted:
        return None
    s.unit.maybe_declared.add(s.text)
    return s.recovery(
        syntax.TYPE_AS_NAME,
        f"'{s.text}' is a type and can name nothing else",
        "a typedef may not be repeated; choose another name",
        feed=("IDENT",),
        instead=True,
    )


def _keyword_as_name(s: ErrorContext) -> Recovery | None:
    if s.text not in RESERVED | SPECIFIERS or "IDENT" not in s.accepted:
        return None
    if s.kind == "IDENT":
        return None
    return s.recovery(
        syntax.KEYWORD_AS_NAME,
        f"'{s.text}' is a keyword and can name nothing",
        "choose another name",
        feed=("IDENT",),
        instead=True,
    )


def _misspelt(s: ErrorContext) -> Recovery | None:
    if s.kind not in ("IDENT", "TYPE_NAME"):
        return None
    words = [WORDS[t] for t in s.accepted if t in TERMINALS.values()]
    similar = nearest(s.text, words)
    if similar is None:
        return None
    return s.recovery(
        syntax.MISSPELT_KEYWORD,
        f"'{s.text}' is not a keyword",
        f"did you mean '{similar}'?",
        feed=(TERMINALS[similar],),
        instead=True,
    )


def _missing_closer(s: ErrorContext) -> Recovery | None:
    """Recognize a missing closing bracket or comma."""
    candidates = (
        ("RPAR", ")"),
        ("SPEC_R", "]"),
        ("RBRACK", "]"),
    )
    for terminal, mark in candidates:
        if terminal in s.accepted and s.text in (";", "{", "}", "]", ")"):
            return s.recovery(
                syntax.MISSING_MARK,
                f"a '{mark}' is missing here",
                after_last=True,
                feed=(terminal,),
            )
    if "COMMA" in s.accepted and (s.text in SPECIFIERS or s.text == "["):
        return s.recovery(
            syntax.MISSING_MARK,
            "a ',' is missing here",
            after_last=True,
            feed=("COMMA",),
        )
    return None


def _plugin_argument(s: ErrorContext) -> Recovery | None:
    """Recognise `through( PLUGIN )`, which lacks the string."""
    if s.text != ")" or s.before[-3:-1] != ["through", "("]:
        return None
    return s.recovery(
        syntax.MISSING_MARK,
        f"the argument of {s.previous} is missing",
        f'write through({s.previous}, ""); the string holds its options',
    )


_RECOGNISERS: tuple[Callable[[ErrorContext], Recovery | None], ...] = (
    _end,
    _angle,
    _stray_brace,
    _extra_semicolon,
    _empty,
    _number,
    _long_long,
    _specifier,
    _unknown_type,
    _missing_semicolon,
    _qualifier,
    _type_as_name,
    _keyword_as_name,
    _misspelt,
    _plugin_argument,
    _missing_closer,
)


def bad_character(unit: Unit, start: int) -> tuple[Diagnostic, int]:
    """Return the diagnostic for a character that starts no token, and where lexing resumes."""
    text = unit.source.code
    character = text[start]
    end = start + 1
    line_end = text.find("\n", start)
    if line_end < 0:
        line_end = len(text)
    if character == '"':
        end = start + len(text[start:line_end].rstrip())
        if text[end - 1] == ";" and end - 1 > start:
            end -= 1
        message = "this string is never closed"
        hint: str | None = 'put " at its end'
        return lexical.UNCLOSED_TEXT.at(unit.span(start, end), message, hint=hint), end
    if character == "#" and not text[text.rfind("\n", 0, start) + 1 : start].strip():
        while text[line_end - 1 : line_end] == "\\" and line_end < len(text):
            line_end = (text.find("\n", line_end + 1) + 1 or len(text) + 1) - 1
        message = "CDL has no preprocessor"
        hint = "import reads a CDL file, import_C the types of a C header"
        span = unit.span(start, start + len(text[start:line_end].split("\n")[0]))
        return lexical.DIRECTIVE.at(span, message, hint=hint), line_end
    if character == "'":
        rest = text.find("'", start + 1, line_end)
        end = rest + 1 if rest >= 0 else end
        message = "this is not a character literal, which has one character between the quotes"
        return lexical.BAD_CHARACTER.at(unit.span(start, end), message), end
    message = f"the character {character!r} is not allowed here"
    mark = _ascii(character)
    hint = f"write '{mark}'" if mark is not None else None
    while mark is None and not text[end - 1].isascii() and end < len(text):
        if text[end].isascii() or _ascii(text[end]) is not None:
            break
        end += 1
    return lexical.BAD_CHARACTER.at(unit.span(start, end), message, hint=hint), end


def meant(text: str) -> str | None:
    """Return the terminal that an unlexable text likely stands for; None to skip it.

    `ERROR` is the terminal of a broken statement.
    """
    mark = _ascii(text) if len(text) == 1 else None
    if mark is not None:
        return next((t for t, w in WORDS.items() if w == mark), None)
    if text[0] == "'" and len(text) > 1:
        return "CHARACTER"
    if text[0] == "#":
        return None
    return "IDENT" if not text[0].isascii() and text.isidentifier() else "ERROR"


def _ascii(character: str) -> str | None:
    """Return the ASCII counterpart of a full-width character; None for other characters."""
    if character.isascii():
        return None
    ascii_form = _IDEOGRAPHIC.get(character) or normalize("NFKC", character)
    return ascii_form if ascii_form.isascii() and len(ascii_form) == 1 else None
