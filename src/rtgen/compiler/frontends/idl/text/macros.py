"""Macros (ISO C 1999, 6.10.3): definition and expansion, on tokens with hide sets.

With GNU extensions: variadic arguments can be named or omitted, and `, ## __VA_ARGS__` then expands
to nothing.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

import msgspec

from rtgen.compiler.diagnostics import Span

TOKEN = re.compile(
    r"(?P<name>[^\W\d]\w*)"
    r"|(?P<number>\.?\d(?:[eE][+-]|[\w.])*)"
    r"""|(?P<text>L?"(?:\\.|[^"\\])*"|L?'(?:\\.|[^'\\\n]){0,12}')"""
    r"|(?P<space>\s+)"
    r"|(?P<mark>\#\#|<<|>>|<=|>=|==|!=|&&|\|\||::|.)",
    re.DOTALL,
)

_REST = "__VA_ARGS__"
_NOTHING = ""

MAX_TOKENS = 100_000
"""Maximum number of tokens from the expansions in one run of text."""


class ExpansionError(Exception):
    """An invalid macro call."""

    def __init__(self, message: str) -> None:
        super().__init__(message)
        self.message = message


class Token(msgspec.Struct, frozen=True):
    """A preprocessing token; `hidden` are the macros that must not expand it."""

    kind: str
    text: str
    hidden: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class Macro:
    """A macro; `parameters` is None for an object-like one.

    The last parameter of a `variadic` macro takes the remaining arguments with their commas.
    """

    name: str
    parameters: tuple[str, ...] | None
    body: tuple[Token, ...]
    span: Span | None = field(compare=False, default=None)
    variadic: bool = False


class MalformedMacroError(ExpansionError):
    """An invalid definition; `macro` is a best-effort definition, if it has a name."""

    def __init__(self, message: str, macro: Macro | None = None) -> None:
        super().__init__(message)
        self.macro = macro


class MacroTable(dict[str, Macro]):
    """Macros by name. All changes go through `put`, which records them."""

    def __init__(self, macros: Mapping[str, Macro]) -> None:
        super().__init__(macros)
        self._replaced: list[tuple[str, Macro | None]] = []

    def put(self, name: str, macro: Macro | None) -> None:
        """Define a macro; None undefines it."""
        self._replaced.append((name, self.get(name)))
        if macro is None:
            self.pop(name, None)
        else:
            self[name] = macro

    @property
    def now(self) -> int:
        """The number of changes so far."""
        return len(self._replaced)

    def changed_since(self, then: int) -> dict[str, Macro | None]:
        """Return the definitions as they were at `then`, of all names changed since."""
        return dict(reversed(self._replaced[then:]))


def tokenize(text: str) -> list[Token]:
    """Return the tokens of a text, white space included."""
    return [
        Token(match.lastgroup or "mark", match[0]) for match in TOKEN.finditer(text)
    ]


def define(text: str, span: Span | None = None) -> Macro:
    """Parse `NAME body` or `NAME(a, b, ...) body`. Raises MalformedMacroError."""
    match = re.match(r"\s*([^\W\d]\w*)(\()?", text)
    if match is None:
        raise MalformedMacroError("the name of the macro is missing")
    name = match[1]
    parameters: tuple[str, ...] | None = None
    variadic = False
    wrong: str | None = None
    rest = text[match.end() :]
    if match[2]:
        inside, closed, rest = rest.partition(")")
        parameters, variadic, wrong = _parameters(inside, name)
        if not closed:
            wrong = f"the parameter list of {name} is not closed"
    body = [
        Token("space", " ") if token.kind == "space" else token
        for token in tokenize(rest.strip())
    ]
    while body and "##" in (body[0].text, body[-1].text):
        wrong = wrong or "'##' is not allowed at either end of a macro"
        body = _stripped(body[1:] if body[0].text == "##" else body[:-1])
    macro = Macro(name, parameters, tuple(_shielded(body)), span, variadic)
    if wrong is not None:
        raise MalformedMacroError(wrong, macro)
    return macro


def _parameters(inside: str, name: str) -> tuple[tuple[str, ...], bool, str | None]:
    """Return a macro's parameters, whether the last is variadic, and the error in them or None."""
    written = [p.strip() for p in inside.split(",")] if inside.strip() else []
    variadic = bool(written) and written[-1].endswith("...")
    if variadic:
        written[-1] = written[-1].removesuffix("...").rstrip() or _REST
    wrong = None
    for parameter in written:
        if not re.fullmatch(r"[^\W\d]\w*", parameter):
            wrong = f"'{parameter}' cannot be a parameter of {name}"
            break
    else:
        if len(set(written)) < len(written):
            wrong = f"{name} has two parameters of one name"
    return tuple(written), variadic, wrong


def _shielded(body: Iterable[Token]) -> Iterator[Token]:
    """Protect the operand of `defined` from expansion."""
    asked = False
    for token in body:
        if asked and token.kind == "name":
            token = Token(token.kind, token.text, frozenset((token.text,)))
        asked = token.text == "defined" or (asked and token.text in " (")
        yield token


class Expander:
    """Expands token lists with the macros of a table, up to a maximum number of tokens."""

    def __init__(self, macros: Mapping[str, Macro], most: int = MAX_TOKENS) -> None:
        self._macros = macros
        self._most = min(most, MAX_TOKENS)
        self._left = self._most

    @property
    def exhausted(self) -> bool:
        """Whether the limit was exceeded, as by endless expansion."""
        return self._left < 0

    @property
    def used(self) -> int:
        """Number of tokens processed."""
        return self._most - self._left

    def expand(self, tokens: list[Token]) -> list[Token]:
        """Return the tokens with all macro calls expanded. Raises ExpansionError."""
        pending = tokens[::-1]
        result: list[Token] = []
        while pending:
            self._left -= 1
            if self._left < 0:
                raise ExpansionError("the macros expand without end")
            token = pending.pop()
            macro = self._macros.get(token.text) if token.kind == "name" else None
            if macro is None or macro.name in token.hidden:
                result.append(token)
                continue
            if macro.parameters is None:
                replaced = self._substitute(macro, {}, token.hidden | {macro.name})
            else:
                arguments = self._arguments(macro, pending)
                if arguments is None:
                    result.append(token)
                    continue
                replaced = self._substitute(
                    macro, arguments, token.hidden | {macro.name}
                )
            pending.extend(reversed(replaced))
        return result

    def _arguments(
        self, macro: Macro, pending: list[Token]
    ) -> dict[str, list[Token]] | None:
        """Return the arguments of a call, removed from `pending`; None without a parenthesis."""
        index = len(pending)
        while index and pending[index - 1].kind == "space":
            index -= 1
        if not index or pending[index - 1].text != "(":
            return None
        del pending[index - 1 :]
        assert macro.parameters is not None
        arguments: list[list[Token]] = [[]]
        depth = 1
        while pending:
            token = pending.pop()
            depth += {"(": 1, ")": -1}.get(token.text, 0)
            if depth == 0:
                break
            if (
                token.text == ","
                and depth == 1
                and not (macro.variadic and len(arguments) == len(macro.parameters))
            ):
                arguments.append([])
            else:
                arguments[-1].append(token)
        else:
            raise ExpansionError(f"the call of {macro.name} is not closed")
        if not macro.parameters and len(arguments) == 1 and not _stripped(arguments[0]):
            arguments = []
        if macro.variadic and len(arguments) == len(macro.parameters) - 1:
            arguments.append([])
        if len(arguments) != len(macro.parameters):
            count = len(macro.parameters) - macro.variadic
            raise ExpansionError(
                f"{macro.name} takes {count} argument{'' if count == 1 else 's'}"
                f"{' or more' if macro.variadic else ''}, not {len(arguments)}",
            )
        stripped = map(_stripped, arguments)
        return dict(zip(macro.parameters, stripped, strict=True))

    def _substitute(
        self, macro: Macro, arguments: dict[str, list[Token]], hidden: frozenset[str]
    ) -> list[Token]:
        result: list[Token] = []
        body = macro.body
        index = 0
        while index < len(body):
            token = body[index]
            following = _next(body, index)
            if token.text == "#" and macro.parameters is not None:
                if following is None or body[following].text not in arguments:
                    raise ExpansionError(
                        f"in {macro.name}, '#' needs a parameter after it"
                    )
                result.append(_quoted(arguments[body[following].text]))
                index = following
            elif token.text == "##":
                assert following is not None
                right = body[following]
                pasted = arguments.get(right.text, [right])
                if (
                    macro.variadic
                    and macro.parameters
                    and right.text == macro.parameters[-1]
                    and _last(result) == ","
                ):
                    _paste_rest(result, self.expand(pasted))
                else:
                    _paste(result, pasted)
                index = following
            elif token.text in arguments and token.kind == "name":
                argument = arguments[token.text]
                if following is not None and body[following].text == "##":
                    result += argument or [Token("mark", _NOTHING)]
                else:
                    result += self.expand(argument)
            else:
                result.append(token)
            index += 1
        return [Token(t.kind, t.text, t.hidden | hidden) for t in result]


def _next(body: tuple[Token, ...], index: int) -> int | None:
    index += 1
    while index < len(body) and body[index].kind == "space":
        index += 1
    return index if index < len(body) else None


def _stripped(tokens: list[Token]) -> list[Token]:
    start, end = 0, len(tokens)
    while start < end and tokens[start].kind == "space":
        start += 1
    while end > start and tokens[end - 1].kind == "space":
        end -= 1
    return tokens[start:end]


def _quoted(tokens: list[Token]) -> Token:
    parts = []
    for token in tokens:
        text = " " if token.kind == "space" else token.text
        parts.append(
            re.sub(r'(["\\])', r"\\\1", text) if token.kind == "text" else text
        )
    return Token("text", '"' + "".join(parts) + '"')


def _last(tokens: list[Token]) -> str:
    """Return the text of the last token other than white space."""
    return next((t.text for t in reversed(tokens) if t.kind != "space"), "")


def _paste_rest(result: list[Token], rest: list[Token]) -> None:
    """Expand `, ## __VA_ARGS__`: the comma is removed if there are no arguments."""
    while result[-1].kind == "space":
        result.pop()
    if rest:
        result += rest
    else:
        result.pop()


def _paste(result: list[Token], right: list[Token]) -> None:
    while result and result[-1].kind == "space":
        result.pop()
    if not right:
        return
    left = result.pop().text if result else ""
    joined = tokenize(left + right[0].text)
    if len(joined) != 1:
        raise ExpansionError(f"'##' cannot join '{left}' and '{right[0].text}'")
    result += [joined[0], *right[1:]]


def call_end(code: str, start: int, end: int) -> int:
    """Return the end of the arguments of the call whose name ends at `start`, or `start`."""
    depth = 0
    for match in TOKEN.finditer(code, start, end):
        if match[0] == "(":
            depth += 1
        elif match[0] == ")" and depth:
            depth -= 1
            if not depth:
                return match.end()
        elif not depth and match.lastgroup != "space":
            return start
    return end if depth else start
