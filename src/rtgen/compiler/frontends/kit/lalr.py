"""LALR(1) parser with a contextual lexer, based on the tables that lark makes of a grammar.

The tables are plain data, made when the package is built, so that a run does not need lark. If they
are missing or of another grammar, they are made again.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from hashlib import sha256
from operator import itemgetter
from typing import Any, TypeAlias

FORMAT = "rtgen-lalr/1"
WORD = "IDENT"
"""The terminal of words; a word can also be a keyword, see `Grammar`."""

END = "$END"
_UNKNOWN = "UNKNOWN"

Make: TypeAlias = Callable[[list[Any]], Any]


class Token(str):
    """A piece of text, with its terminal of the grammar."""

    __slots__ = ("end_pos", "start_pos", "type")

    type: str
    start_pos: int
    end_pos: int


def token(kind: str, start: int, text: str = "") -> Token:
    """Return a token at `start`."""
    result = Token(text)
    result.type = kind
    result.start_pos = start
    result.end_pos = start + len(text)
    return result


class UnexpectedTokenError(Exception):
    """Raised for a token that is not allowed at its place."""

    def __init__(self, token: Token) -> None:
        super().__init__(f"unexpected {token.type}")
        self.token = token


class UnexpectedCharacterError(Exception):
    """Raised for a character that starts no token; the parser's `position` is its place."""


class TooDeepError(Exception):
    """Raised at a token that is nested too deeply."""

    def __init__(self, token: Token) -> None:
        super().__init__(f"nested too deeply at {token.start_pos}")
        self.token = token


class Grammar:
    """The tables, with what `builder` makes of each rule: the method of its name or alias.

    `reserved` words are never identifiers; other words of the grammar are keywords only where their
    construct is allowed.
    """

    def __init__(
        self, tables: Mapping[str, Any], builder: object, reserved: frozenset[str]
    ) -> None:
        words: dict[str, str] = tables["words"]
        self.reserved = {word: words[word] for word in reserved}
        self.contextual: dict[str, tuple[str, re.Pattern[str]]] = {
            word: (kind, re.compile(guard))
            for word, (kind, guard) in (
                *((word, (words[word], "")) for word in words.keys() - reserved),
                *tables["guarded"].items(),
            )
        }
        self.words = frozenset((*self.reserved, *self.contextual))
        self.actions: list[dict[str, int]] = tables["actions"]
        self.rules = [_rule(builder, *rule) for rule in tables["rules"]]
        self.start: int = tables["start"]
        self.terminals: dict[str, str] = tables["terminals"]
        alternatives = [f"(?P<{name}>{text})" for name, text in self.terminals.items()]
        self.scanner = re.compile(
            f"{tables['ignored']}(?:{'|'.join(alternatives)}|(?P<{_UNKNOWN}>.))",
            re.DOTALL,
        )


def key(text: str) -> str:
    """Return the hash that identifies the grammar of tables."""
    return sha256(f"{FORMAT}\n{text}".encode()).hexdigest()


class Parser:
    """The parsing of one text. Error recovery can change `position` and the stacks."""

    watched: frozenset[str] = frozenset()
    """Terminals for whose tokens `shifted` is called."""
    judges_all_words = False
    """Whether `word` is asked about words that the grammar does not have, too."""
    most = sys.maxsize
    """Maximum depth of the stack; a token beyond it raises TooDeepError."""

    def __init__(self, grammar: Grammar, text: str) -> None:
        self.position = 0
        self.states = [grammar.start]
        self.values: list[Any] = []
        self._grammar = grammar
        self._text = text
        self._end = len(text.rstrip())

    def run(self) -> Any:
        """Parse the text from `position` on, and return the value of the start rule.

        Raises UnexpectedTokenError and UnexpectedCharacterError; parsing can continue after either.
        """
        self._feed(self._tokens())
        return self.feed(token(END, len(self._text)))

    def feed(self, token: Token) -> Any:
        """Shift a token after the necessary reductions; returns the result at the end."""
        self._feed((token,))
        return self.values[0] if token.type == END else None

    def _tokens(self) -> Iterator[Token]:
        """Yield the tokens from `position` on, each one read when those before it are shifted."""
        states, word = self.states, self.word
        actions, reserved = self._grammar.actions, self._grammar.reserved
        words = None if self.judges_all_words else self._grammar.words
        while self.position < self._end:
            scanned = self._grammar.scanner.finditer(
                self._text, self.position, self._end
            )
            for match in scanned:
                kind: str = match.lastgroup  # type: ignore[assignment]  # one always matches
                text = match[kind]
                self.position = end = match.end()
                row = actions[states[-1]]
                if kind == WORD and (words is None or text in words):
                    kind = reserved[text] if text in reserved else word(text, end)
                token = Token(text)
                token.type = kind
                token.start_pos = end - len(text)
                token.end_pos = end
                if kind not in row:
                    token = self.other(token)
                yield token
                if token.end_pos != end:
                    self.position = token.end_pos
                    break

    def _feed(self, tokens: Iterable[Token]) -> None:
        states, values, watched = self.states, self.values, self.watched
        actions, rules, most = self._grammar.actions, self._grammar.rules, self.most
        for token in tokens:
            kind = token.type
            if len(states) > most:
                raise TooDeepError(token)
            row = actions[states[-1]]
            while True:
                if kind not in row:
                    raise UnexpectedTokenError(token)
                action = row[kind]
                if action >= 0:
                    states.append(action)
                    values.append(token)
                    break
                size, origin, make = rules[~action]
                if size == 1:
                    if make is not None:
                        values[-1] = make(values[-1:])
                    row = actions[states[-2]]
                    states[-1] = row[origin]
                elif size:
                    children = values[-size:]
                    del values[-size:], states[-size:]
                    values.append(make(children))  # type: ignore[misc]  # of one part alone
                    states.append(actions[states[-1]][origin])
                else:
                    values.append(make([]))  # type: ignore[misc]
                    states.append(row[origin])
                row = actions[states[-1]]
            if kind in watched:
                self.shifted(token)

    def shifted(self, token: Token) -> None:
        """Called when a token of a watched terminal is shifted."""

    def word(self, text: str, end: int) -> str:
        """Return the terminal of an unreserved word that ends at `end`."""
        if text in self._grammar.contextual:
            # The row may have the terminal from another context with the same state.
            keyword, guard = self._grammar.contextual[text]
            if self.would_shift(keyword) and guard.match(self._text, end):
                return keyword
        return WORD

    def other(self, unexpected: Token) -> Token:
        """Return another token with the same start that the state accepts; raises if none is."""
        row = self._grammar.actions[self.states[-1]]
        start = unexpected.start_pos
        for kind, pattern in self._grammar.terminals.items():
            if kind in row and kind != WORD:
                match = re.compile(pattern).match(self._text, start)
                if match is not None:
                    return token(kind, start, match[0])
        self.position = start
        if unexpected.type == _UNKNOWN:
            raise UnexpectedCharacterError
        raise UnexpectedTokenError(unexpected)

    def takes(self, kind: str) -> bool:
        """Return whether the state has an action for a terminal, even if that is a reduction."""
        return kind in self._grammar.actions[self.states[-1]]

    def accepts(self) -> set[str]:
        """Return the terminals that are allowed next."""
        return {
            kind
            for kind in self._grammar.actions[self.states[-1]]
            if kind.isupper() and self.would_shift(kind)
        }

    def would_shift(self, kind: str) -> bool:
        states, actions = self.states, self._grammar.actions
        depth = len(states)
        added: list[int] = []
        while True:
            action = actions[added[-1] if added else states[depth - 1]].get(kind)
            if action is None or action >= 0:
                return action is not None
            size, origin, _ = self._grammar.rules[~action]
            depth -= max(size - len(added), 0)
            del added[max(len(added) - size, 0) :]
            added.append(actions[added[-1] if added else states[depth - 1]][origin])


def _rule(
    builder: object,
    origin: str,
    size: int,
    name: str | None,
    selection: list[tuple[int, bool]] | None,
    single: bool,
) -> tuple[int, str, Make | None]:
    """Return a rule's length, its symbol, and the function that makes its value.

    The function is None if the value is that of the rule's only part. `selection`: the parts that
    count, each with whether it is a list to be spread; None for all. `single`: one part is the
    value.
    """
    if single and size == 1 and selection is None:
        return size, origin, None
    make: Make = _as_they_are if name is None else getattr(builder, name)
    if selection is None:
        return size, origin, make
    indexes = [index for index, _ in selection]
    spreads = [index for index, spread in selection if spread]
    if not spreads:
        if single and len(indexes) == 1:
            return size, origin, itemgetter(*indexes)
        return size, origin, lambda parts: make([parts[i] for i in indexes])
    if name is None and spreads == [0] and indexes[1:] == [size - 1]:
        return size, origin, _appended
    if not single and len(spreads) == 1 and indexes == list(range(size)):
        place = spreads[0]
        if place == 0:

            def spread_first(parts: list[Any]) -> Any:
                items: list[Any] = parts[0]  # not copied: the list grows on the left
                items += parts[1:]
                return make(items)

            return size, origin, spread_first

        def spread_one(parts: list[Any]) -> Any:
            parts[place : place + 1] = parts[place]
            return make(parts)

        return size, origin, spread_one

    def select(parts: list[Any]) -> Any:
        items: list[Any] = []
        for index, spread in selection:
            if not spread:
                items.append(parts[index])
            elif items:
                items += parts[index]
            else:  # not copied: the list grows on the left
                items = parts[index]
        return items[0] if single and len(items) == 1 else make(items)

    return size, origin, select


def _as_they_are(parts: list[Any]) -> list[Any]:
    return parts


def _appended(parts: list[Any]) -> list[Any]:
    items: list[Any] = parts[0]
    items.append(parts[-1])
    return items
