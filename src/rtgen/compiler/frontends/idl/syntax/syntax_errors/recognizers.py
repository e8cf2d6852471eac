"""Recognizers of common syntax errors, by the context of the unexpected token."""

from __future__ import annotations

from collections.abc import Callable

from rtgen.compiler.diagnostics import Related
from rtgen.compiler.frontends.idl.rules import syntax
from rtgen.compiler.frontends.idl.syntax.keywords import CORBA_3, RESERVED, TERMINALS
from rtgen.compiler.frontends.idl.syntax.syntax_errors import bodies, foreign, misplaced
from rtgen.compiler.frontends.idl.syntax.syntax_errors.context import (
    DEFINERS,
    ErrorContext,
    Word,
)
from rtgen.compiler.frontends.kit.suggestions import nearest
from rtgen.compiler.frontends.kit.syntax_errors import Recovery

_NUMBERS = frozenset(("short", "long", "float", "double", "char", "int", "unsigned"))
_TEMPLATES = ("sequence", "string", "wstring", "fixed", "map")
_BEHIND_A_NAME = frozenset(";,)[({:=")
_MARKS = {
    "SEMI": ";",
    "COLON": ":",
    "COMMA": ",",
    "LPAR": "(",
    "RPAR": ")",
    "LBRACE": "{",
    "EQUALS": "=",
    "LESS": "<",
    "GREATER": ">",
    "RSQB": "]",
}
_TAGGED = ("struct", "union", "enum", "interface")
_BY_TERMINAL = {"TEXT": "string", "WTEXT": "wstring"}


def explain(context: ErrorContext) -> Recovery:
    """Return the recovery for the likely cause of a syntax error."""
    for recognise in _RECOGNISERS:
        recovery = recognise(context)
        if recovery is not None:
            return recovery
    return _unexpected(context)


def _unexpected(s: ErrorContext) -> Recovery:
    text = " ".join(s.text.split())
    text = text if len(text) <= 40 else text[:37] + "..."
    return s.recover(
        syntax.UNEXPECTED,
        f"'{text}' is not allowed here{s.expectation()}",
        misplaced.what_stands_here(s),
    )


def _at_end(s: ErrorContext) -> Recovery | None:
    if s.kind != "$END":
        return None
    if "SEMI" in s.accepted:
        return _semicolon(s)
    if s.opening is None:
        return s.recover(
            syntax.UNEXPECTED_END,
            "the file ends within a declaration",
            "write its end, or remove it",
            after_last=True,
        )
    return s.recover(
        syntax.UNCLOSED_BRACE,
        f"this '{{'{' of ' + s.called if s.called else ''} is never closed",
        "put '};' where it ends",
        at=(s.opening, s.opening + 1),
        related=[Related(s.unit.after(s.last), "the file ends here")],
    )


def _semicolon(s: ErrorContext) -> Recovery:
    return s.recover(
        syntax.MISSING_SEMICOLON,
        "a ';' is missing here",
        "put ';' at the end of the declaration",
        after_last=True,
        feed=("SEMI",),
        resume=s.start,
    )


def _missing_semicolon(s: ErrorContext) -> Recovery | None:
    """Recognize a missing `;`: the token starts a line, is a keyword, or closes the body."""
    if "SEMI" not in s.accepted or s.text in (";", "{", "="):
        return None
    if s.text == "const" and s.previous == ")" and s.following == ";":
        return None
    if s.text == "raises" or (s.previous in _NUMBERS and s.text in _NUMBERS):
        return None
    starts = s.text == "}" or s.text in RESERVED or s.text in CORBA_3
    if not starts and not (s.fresh_line and s.kind in ("IDENT", "ANNOTATION", "SCOPE")):
        return None
    comma = s.before[-2] if len(s.before) > 2 else None
    if (
        comma
        and comma.text == ","
        and "\n" in s.unit.text[comma.end : s.before[-1].start]
    ):
        return _comma_for_semicolon(s, comma, s.before[-1].start)
    return _semicolon(s)


def _comma_for_semicolon(s: ErrorContext, comma: Word, resume: int) -> Recovery:
    return s.recover(
        syntax.MISSING_SEMICOLON,
        "a ';' is expected here, not a ','",
        "a ',' separates names of one type; each declaration ends with ';'",
        at=comma,
        back=True,
        resume=resume,
    )


def _wrong_separator(s: ErrorContext) -> Recovery | None:
    """Recognize `long a,` before the next member, `;` between parameters, and similar."""
    if s.previous == "," and not s.in_parameters and "IDENT" in s.accepted:
        if s.text == "}" or (s.text in RESERVED and s.following not in _BEHIND_A_NAME):
            return _comma_for_semicolon(s, s.before[-1], s.start)
        return None
    unclosed = s.text == "{" or (s.text in RESERVED and s.previous not in (",", "("))
    if (
        unclosed
        and "RPAR" in s.accepted
        and s.in_parameters
        and "COMMA" not in s.accepted
    ):
        return s.missing(")", "close the parenthesis", feed="RPAR")
    if s.text == ";" and "COMMA" in s.accepted and s.in_parameters:
        if s.following in ("in", "out", "inout"):
            return s.recover(
                syntax.MISSING_MARK,
                "a ',' is expected here, not a ';'",
                "parameters are separated by ','",
                feed=("COMMA",),
                instead=True,
            )
        if "RPAR" in s.accepted:
            return s.missing(")", "close the list of parameters", feed="RPAR")
    if s.construct in ("enum", "bitmask") and "COMMA" in s.accepted:
        if s.text == ";":
            return s.recover(
                syntax.MISSING_MARK,
                "a ',' is expected here, not a ';'",
                "enumerators are separated by ','; the last has none",
            )
        if s.kind in ("IDENT", "ANNOTATION"):
            return s.missing(",", "enumerators are separated by ','", feed="COMMA")
    return None


def _split_name(s: ErrorContext) -> Recovery | None:
    """Recognize `long max speed;`, `struct My Struct {`, a word after the `};` of a body."""
    text = s.unit.text
    if s.kind != "IDENT" or s.fresh_line:
        return None
    if text[s.last - 1] == "}" and "SEMI" in s.accepted:
        end = s.after[0].end if s.following == ";" else s.end
        return s.recover(
            syntax.MISSING_SEMICOLON,
            f"a ';' is expected here, not {s.text}",
            "a body ends with '};': IDL declares types, not variables",
            feed=("SEMI",),
            resume=end,
        )
    previous = s.before[-1] if s.before else None
    near = nearest(s.text, _expected_words(s))
    if len(s.before) > 1 and s.before[-2].text in _TAGGED and s.following != "{":
        if near is not None:
            return None
        return s.recover(
            syntax.FOREIGN,
            f"a type is named without '{s.before[-2].text}'",
            f"write {s.previous} {s.text}",
            at=s.before[-2],
        )
    joined = s.following in _BEHIND_A_NAME and bool(s.following)
    if previous is None or not previous.is_name or not joined:
        return None
    if "SEMI" in s.accepted or "LBRACE" in s.accepted:
        if near is not None:
            return None
        s.unit.maybe_declared.add(previous.text.lower())
        return s.recover(
            syntax.UNEXPECTED,
            f"'{s.text}' is not allowed here: {previous.text} is the name already",
            f"write {previous.text}_{s.text} if that is one name",
            at=None,
        )
    return None


def _expected_words(s: ErrorContext) -> dict[str, str]:
    """Return the keywords that are allowed here, with their terminals."""
    terminals = {
        _BY_TERMINAL.get(t, t.lower()): t
        for t in s.accepted
        if t not in ("IDENT", "ERROR", "TRAILING", "ANNOTATION_DCL")
    }
    terminals = {
        {
            "true": "TRUE",
            "false": "FALSE",
            "object": "Object",
            "valuebase": "ValueBase",
        }.get(word, word): terminal
        for word, terminal in terminals.items()
    }
    marks = {m.lower() for m in _MARKS} | {"string_", "number", "character"}
    return {w: t for w, t in terminals.items() if w.isalpha() and w not in marks}


def _misspelt(s: ErrorContext) -> Recovery | None:
    """Recognize a misspelt keyword; parsing continues with the right one."""
    if s.kind != "IDENT":
        return None
    fitting = _expected_words(s)
    meant = nearest(s.text, [w for w in fitting if w != s.text])
    if meant is None or s.text in fitting:
        return None
    return s.recover(
        syntax.MISSPELT_KEYWORD,
        f"'{s.text}' is not known here",
        f"did you mean '{meant}'?",
        feed=(fitting[meant],),
        instead=True,
    )


def _misspelt_before(s: ErrorContext) -> Recovery | None:
    """Recognize a misspelt keyword read as a name before: `unsinged long`."""
    word = s.before[-1] if s.before else None
    if word is None or not word.is_name:
        return None
    single = len(s.before) == 1
    if s.text == "<":
        meant = nearest(word.text, _TEMPLATES)
    elif s.text in ("short", "long"):
        meant = nearest(word.text, ("unsigned", "readonly", "attribute", "const"))
        if meant is None and s.in_parameters:
            meant = nearest(word.text, ("in", "inout", "out"))
    elif s.text in RESERVED:
        candidates = ["in", "inout", "out"] if s.in_parameters else []
        if single:
            candidates += ["oneway", "readonly", "attribute", "const", "typedef"]
            candidates += ["abstract", "local", "custom", "public", "private"]
        meant = nearest(word.text, candidates)
    else:
        return None
    if meant is None or meant == word.text:
        return None
    resume = None
    feed: tuple[str, ...] = ()
    terminal = TERMINALS.get(meant, "")
    if single and terminal in _starters(s):
        feed, resume = (terminal,), s.start
    return s.recover(
        syntax.MISSPELT_KEYWORD,
        f"'{word.text}' is not known here",
        f"did you mean '{meant}'?",
        at=word,
        feed=feed,
        back=bool(feed),
        resume=resume,
    )


def _starters(s: ErrorContext) -> frozenset[str]:
    """Return the terminals that can be supplied at the start of a declaration in this body."""
    if s.construct == "interface":
        return frozenset(("UNSIGNED", "ONEWAY", "READONLY", "ATTRIBUTE", "TYPEDEF"))
    if s.construct in ("struct", "exception"):
        return frozenset(("UNSIGNED",))
    return frozenset()


def _keyword_as_name(s: ErrorContext) -> Recovery | None:
    if "IDENT" not in s.accepted or s.text not in RESERVED:
        return None
    if s.first == "typedef" and len(s.before) == 2 and s.before[1].is_name:
        return s.recover(
            syntax.UNEXPECTED,
            f"'{s.text}' is not allowed here: the type comes first",
            f"write typedef {s.text} {s.previous};",
        )
    if s.following not in _BEHIND_A_NAME and s.following not in ("", "}", "switch"):
        return None
    return s.recover(
        syntax.KEYWORD_AS_NAME,
        f"'{s.text}' is a keyword and cannot be a name",
        f"'_{s.text}' is the escaped form of {s.text}",
        feed=("IDENT",),
        instead=True,
    )


def _doubled_word(s: ErrorContext) -> Recovery | None:
    """Recognize a duplicated word."""
    if s.text != s.previous or not s.before[-1].is_word or s.fresh_line:
        return None
    message = f"'{s.text}' is repeated"
    return s.recover(syntax.UNEXPECTED, message, "remove one", instead=True)


def _missing_tag(s: ErrorContext) -> Recovery | None:
    if s.text != "{" or s.previous not in DEFINERS:
        return None
    return s.recover(
        syntax.MISSING_NAME,
        f"the {s.previous} has no name",
        f"write '{s.previous} Name {{ ... }}'",
    )


def _missing_mark(s: ErrorContext) -> Recovery | None:
    """Recognize the only token that fits; parsing continues as if it were there."""
    fitting = s.accepted - {"ERROR", "TRAILING"}
    if len(fitting) > 1 and fitting <= {"GREATER", "COMMA"}:
        fitting = {"GREATER"}
    if len(fitting) != 1:
        return None
    (terminal,) = fitting
    mark = _MARKS.get(terminal)
    if mark is None:
        return None
    where = f"after '{s.previous}'" if s.previous else "here"
    hint = f"put '{mark}' {where}"
    if mark == "{" and s.first == "enum" and s.text == ":":
        return s.recover(
            syntax.FOREIGN,
            "an enum names no type for its values in IDL",
            "leave it out, or write @bit_bound(BITS) before the enum",
        )
    if mark == "(" and s.text == ";":
        return s.recover(
            syntax.MISSING_MARK,
            "'()' is missing here",
            f"write {s.previous}() for an operation, attribute TYPE {s.previous} for a value",
            after_last=True,
        )
    if mark == "=" and s.text == ";":
        return s.recover(
            syntax.MISSING_MARK,
            "the value of the constant is missing here",
            "write '= VALUE' after the name",
            after_last=True,
        )
    if mark == "=" and s.text == ":":
        return s.recover(
            syntax.MISSING_MARK, "a '=' is expected here, not ':='", "write '='"
        )
    if mark == "{" and s.text == ";":
        return None
    fits = s.kind in ("IDENT", "NUMBER", "SEMI") or s.text in RESERVED
    feed = terminal if fits and mark not in "(<{" else None
    return s.missing(mark, hint, feed=feed)


def _missing_word(s: ErrorContext) -> Recovery | None:
    """Recognize a missing name, type or value before `;`, `,`, `)` or `>`."""
    if s.text not in (";", ",", ")", ">", "}", "]"):
        return None
    if s.previous in ("(", ",", "<", "[", "=") and "NUMBER" in s.accepted:
        return s.recover(
            syntax.MISSING_WORD,
            "a value is missing here",
            "write a number, a constant, or an expression of these",
        )
    if s.previous == "@":
        return None
    if "IDENT" not in s.accepted:
        return None
    type_wanted = "STRUCT" in s.accepted or (
        "LONG" in s.accepted and "SHORT" in s.accepted
    )
    if s.previous == "::":
        return s.recover(
            syntax.MISSING_WORD,
            "a name is missing after '::'",
            "'::' separates the parts of a scoped name",
            at=s.before[-1],
        )
    if s.previous in (",", "(", "<") and type_wanted:
        what = "parameter" if s.in_parameters else "type"
        hint = (
            "remove the ',', or write a parameter after it"
            if s.previous == "," and s.in_parameters
            else "write the type of its elements: sequence<long>"
        )
        return s.recover(syntax.MISSING_WORD, f"a {what} is missing here", hint)
    if s.previous == ",":
        return s.recover(
            syntax.MISSING_WORD,
            "a name is missing here",
            "remove one ',', or write a name",
        )
    if s.in_parameters and s.text in ",)":
        if s.previous == "void":
            return s.recover(
                syntax.MISSING_WORD,
                "an operation without parameters has nothing between ( and )",
                "write ()",
                at=s.before[-1],
            )
        hint = "parameters have a direction, a type and a name: in long count"
        return s.recover(
            syntax.MISSING_WORD,
            "the name of the parameter is missing here",
            hint,
            after_last=True,
        )
    last = s.before[-1] if s.before else None
    if last is not None and last.is_name and len(s.before) == 1:
        return s.recover(
            syntax.MISSING_WORD,
            f"{last.text} has no type, or no name",
            f"write 'TYPE {last.text};' or '{last.text} NAME;'",
            at=last,
        )
    return s.recover(
        syntax.MISSING_WORD,
        "a name is missing here",
        "a declaration has a type and a name: long count",
        after_last=True,
    )


def _semicolon_of_macro(s: ErrorContext) -> Recovery | None:
    """Recognize the `;` of `#define SIZE 10;`."""
    if s.text != ";" or "SEMI" in s.accepted or not s.unit.piece(s.start)[0].expanded:
        return None
    return s.recover(
        syntax.UNEXPECTED,
        "the text of this macro holds a ';', which is not allowed here",
        "remove the ';' from its #define",
        instead=True,
    )


_RECOGNISERS: tuple[Callable[[ErrorContext], Recovery | None], ...] = (
    _semicolon_of_macro,
    bodies.doubled,
    bodies.end_without_brace,
    bodies.unclosed,
    _at_end,
    bodies.unopened,
    bodies.stray,
    _missing_tag,
    foreign.number_type,
    _doubled_word,
    misplaced.values,
    misplaced.colon_after_access,
    misplaced.misplaced_direction,
    misplaced.misplaced_clause,
    foreign.superfluous,
    foreign.inclusion,
    foreign.word,
    _wrong_separator,
    _missing_semicolon,
    _split_name,
    _misspelt_before,
    _keyword_as_name,
    _misspelt,
    misplaced.misplaced,
    misplaced.assignment,
    misplaced.brackets,
    misplaced.parenthesis,
    misplaced.operators,
    misplaced.names_and_colons,
    misplaced.marks,
    misplaced.words_of_constructs,
    _missing_word,
    _missing_mark,
)
"""Order of the recognizers: the more reliable first."""
