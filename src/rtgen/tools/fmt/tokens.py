"""Tokens of IDL and CDL, including comments, line ends and preprocessor lines.

The text is that of the file, before preprocessing, with `\n` as its only line end. A preprocessor
line is one token, and so is the text that `#if 0` skips. OMG IDL 4.2, 7.2; CDL as tecsgen reads it.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, auto


class Language(Enum):
    """A language that can be formatted."""

    IDL = "idl"
    CDL = "cdl"


class Kind(Enum):
    """The kind of a token."""

    WORD = auto()
    NUMBER = auto()
    STRING = auto()
    ANNOTATION = auto()
    MARK = auto()
    LINE_COMMENT = auto()
    BLOCK_COMMENT = auto()
    DIRECTIVE = auto()
    VERBATIM = auto()
    END = auto()


CHECKED = 1_000
"""Number of tokens after which it is checked whether the work is still wanted."""
MAX_TOKENS = 1_000 * CHECKED
"""Maximum number of tokens of a file; each takes some hundred octets of memory."""
COMMENTS = (Kind.LINE_COMMENT, Kind.BLOCK_COMMENT)


@dataclass(frozen=True, slots=True)
class Token:
    """A token at `start` of the text, after `breaks` line ends."""

    kind: Kind
    text: str
    start: int
    breaks: int

    @property
    def end(self) -> int:
        """The offset after the token."""
        return self.start + len(self.text)


class LexicalError(Exception):
    """An invalid token; `start` and `end` are its offsets."""

    def __init__(self, message: str, start: int, end: int, hint: str) -> None:
        super().__init__(message)
        self.message = message
        self.start = start
        self.end = end
        self.hint = hint


_SPLICE = r"\\\n"
_LINE_COMMENT = {
    Language.IDL: rf"//(?:{_SPLICE}|[^\n])*+",
    Language.CDL: r"//[^\n]*+",
}
_STRING = {
    Language.IDL: r'L?"(?:\\[^\n]|[^"\\\n])*+"|L?"(?:\\.|[^"\\;{}#])*+"',
    Language.CDL: r'"(?:[^"\\\n]|\\.)*+"',
}
_CHARACTER = {
    Language.IDL: r"L?'(?:\\[^\n]|[^'\\\n]){0,12}'",
    Language.CDL: r"'(?:[^'\\\n]|\\[^\n])'",
}
_MARKS = {
    Language.IDL: r"::|<<|>>|/(?!\*)|[{}()\[\]<>,;:=|^&+\-*%~@?.!]",
    Language.CDL: r"::|<<|>>|<=|>=|=>|->|==|!=|&&|\|\||/(?!\*)|[{}()\[\]<>,;:=|^&+\-*%~?.!]",
}
_NUMBER = r"0[xX]\w*|\.?\d(?:[eE][+-]|[\w.])*"


def _scanner(language: Language) -> re.Pattern[str]:
    idl = language is Language.IDL
    parts = {
        "SPACE": rf"(?:[ \t\r\n\f\v]|{_SPLICE})++" if idl else r"[ \t\r\n\f\v]++",
        "LINE_COMMENT": _LINE_COMMENT[language],
        "BLOCK_COMMENT": r"/\*.*?\*/",
        "STRING": f"{_STRING[language]}|{_CHARACTER[language]}",
        "NUMBER": _NUMBER,
        "WORD": r"\w++(?:(?:\\\n)++\w++)*+" if idl else r"\w++",
        "ANNOTATION": r"@[ \t\n]*(?:::)?[A-Za-z_]\w*(?:::\w+)*" if idl else r"(?!)",
        "MARK": _MARKS[language],
    }
    text = "|".join(f"(?P<{name}>{pattern})" for name, pattern in parts.items())
    return re.compile(text, re.DOTALL)


_ANGLE_STRING = re.compile(r"<(?:[^>\\\n]|\\[^\n])*+(?P<closed>>)?")
_SCANNERS = {language: _scanner(language) for language in Language}
_DIRECTIVES = {
    language: re.compile(
        rf"#(?:{_SPLICE}|/\*.*?\*/|{_LINE_COMMENT[language]}"
        r'|"(?:\\.|[^"\\\n])*+"|(?!/\*)[^\n])*+',
        re.DOTALL,
    )
    for language in Language
}
_SKIPPED = re.compile(
    r"//[^\n]*+|/\*.*?\*/" r'|"(?:\\.|[^"\\\n])*+"' r"|^[ \t]*#[ \t]*(?P<word>\w*)",
    re.DOTALL | re.MULTILINE,
)
_IF_0 = re.compile(r"#[ \t]*if[ \t]+0[ \t]*(?://.*|/\*.*)?", re.DOTALL)
_EDITOR = ("__tool_info__", "__location_information__")
_BRACES = re.compile(r'"(?:[^"\\\n]|\\.)*+"|//[^\n]*+|/\*.*?\*/|[{}]', re.DOTALL)


def tokens(
    text: str, language: Language, check: Callable[[], None] = lambda: None
) -> list[Token]:
    """Return the tokens of a text, and one for its end. Raises LexicalError.

    `check` is called now and then, and can end the work by an exception.
    """
    result: list[Token] = []
    scan = _SCANNERS[language].match
    position = breaks = 0
    fresh = True  # only comments since the start of the line
    spliced = False  # only the mark of a continued line since the last token
    barren = 0  # offset up to which no angle string ends
    while position < len(text):
        if text[position] == "#" and fresh:
            token = _directive(text, position, breaks, language)
        elif text[position] == "<" and language is Language.CDL and position >= barren:
            match = _ANGLE_STRING.match(text, position)
            assert match is not None
            if match["closed"] is None:
                barren = match.end()
                continue
            token = Token(Kind.VERBATIM, match[0], position, breaks)
        else:
            match = scan(text, position)
            if match is None:
                raise _fault(text, position)
            name = match.lastgroup
            assert name is not None
            if name == "SPACE":
                space = match[0]
                breaks = space.count("\n") - space.count("\\\n")
                spliced = not space.replace("\\\n", "")
                fresh = fresh or breaks > 0
                position = match.end()
                continue
            if spliced and result and result[-1].kind not in COMMENTS:
                message = "a token may continue after this line end"
                hint = "write a blank before the backslash"
                raise LexicalError(message, result[-1].end, result[-1].end + 1, hint)
            kind = Kind[name]
            token = Token(kind, match[0], position, breaks)
            if kind is Kind.WORD and token.text in _EDITOR and language is Language.CDL:
                token = _editors(text, token)
        if not len(result) % CHECKED:
            check()
            if len(result) == MAX_TOKENS:
                message = f"the file has more than {MAX_TOKENS:,} tokens"
                hint = "divide it into several"
                raise LexicalError(message, token.start, token.end, hint)
        result.append(token)
        position = token.end
        breaks = 0
        spliced = False
        fresh = token.kind is Kind.DIRECTIVE or (fresh and token.kind in COMMENTS)
    result.append(Token(Kind.END, "", len(text), max(breaks, 1)))
    return result


def _directive(text: str, start: int, breaks: int, language: Language) -> Token:
    """Return a preprocessor line; for `#if 0`, with the lines that it skips."""
    match = _DIRECTIVES[language].match(text, start)
    assert match is not None
    if text.startswith("/*", match.end()):
        raise _fault(text, match.end())
    end = match.end()
    if _IF_0.fullmatch(match[0]):
        end = _end_of_skipped(text, end)
    return Token(Kind.DIRECTIVE, text[start:end], start, breaks)


def _end_of_skipped(text: str, position: int) -> int:
    """Return the end of the lines that `#if 0` skips."""
    depth = 0
    for match in _SKIPPED.finditer(text, position):
        word = match["word"]
        if word is None:
            continue
        if word in ("if", "ifdef", "ifndef"):
            depth += 1
        elif word == "endif" and depth:
            depth -= 1
        elif word in ("else", "elif", "endif") and not depth:
            return max(match.start() - 1, position)
    return len(text)


def _editors(text: str, word: Token) -> Token:
    """Return the text of the editor tecscde, from its first word to its last brace."""
    depth = 0
    for match in _BRACES.finditer(text, word.end):
        if match[0] == "{":
            depth += 1
        elif match[0] == "}":
            depth -= 1
            if depth <= 0:
                end = match.end()
                return Token(
                    Kind.VERBATIM, text[word.start : end], word.start, word.breaks
                )
    raise LexicalError(
        "the braces of this are never closed", word.start, word.end, "close them with }"
    )


def _fault(text: str, start: int) -> LexicalError:
    if text.startswith("/*", start):
        return LexicalError(
            "this comment is never closed", start, start + 2, "close it with */"
        )
    if text[start] in "\"'" or text.startswith(('L"', "L'"), start):
        end = text.find("\n", start)
        message = "this literal is never closed"
        hint = f"close it with {text[start].replace('L', chr(34))}"
        return LexicalError(message, start, len(text) if end < 0 else end, hint)
    message = f"{text[start]!r} is not allowed here"
    return LexicalError(message, start, start + 1, "the file is left as it is")
