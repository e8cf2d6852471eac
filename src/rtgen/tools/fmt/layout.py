"""Lays out a text: statements, blocks, comments and preprocessor lines, in order."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

from rtgen.compiler.frontends.kit.doc_comments import is_trailing
from rtgen.compiler.kit.limits import MAX_NESTING
from rtgen.tools.fmt.spacing import BINARY, LABELS, Spacing
from rtgen.tools.fmt.tokens import (
    CHECKED,
    COMMENTS,
    Kind,
    Language,
    LexicalError,
    Token,
)
from rtgen.tools.fmt.wrapping import LAST_RESORT, Frame, Piece, moved, wrapped

MAX_CHARACTERS = 32 * 1024 * 1024
"""Maximum length of a formatted text, since indentation can multiply that of the source."""

_LISTS = frozenset(("enum", "bitmask", "enum8", "enum16", "enum32", "enum64"))
_OPEN_BLOCKS = frozenset(("module", "namespace", "region"))
"""Blocks that are never written on one line."""
_HEADS = frozenset(("signature", "celltype", "cell", "composite", "region"))
"""Keywords of CDL whose specifiers are on a line of their own."""
_CLAUSES = frozenset(
    ("raises", "getraises", "setraises", "context", "supports", "manages")
)
_BRACKETS = {")": "(", "]": "[", "}": "{"}


@dataclass(slots=True)
class Line:
    """A line of the result, or several that belong together.

    `token` is the number of its first token. `trailing` are trailing comments, `column` that of the
    first one in the source, `width` that of the next one.
    """

    text: str
    token: int
    blank: bool = False
    opens: bool = False
    trailing: list[str] = field(default_factory=list)
    column: int = 0
    width: int = 0


class _State(NamedTuple):
    """The state at the start of a branch of `#if`."""

    blocks: tuple[bool, ...]
    spacing: Spacing
    continued: bool
    labelled: bool


class Layout:
    """Lays out tokens; `lines` is the result."""

    def __init__(
        self, text: str, tokens: list[Token], language: Language, frame: Frame
    ) -> None:
        self._text = text
        self._tokens = tokens
        self._language = language
        self._frame = frame
        self.lines: list[Line] = []
        self._blocks: tuple[bool, ...] = ()
        self._pieces: list[Piece] = []
        self._begin = 0
        self._words: dict[str, None] = {}
        """The words of the statement so far, outside of brackets."""
        self._code: Piece | None = None
        """The last piece of the statement that is not a comment."""
        self._annotated = False
        """Whether the statement has an annotation, specifiers or parentheses."""
        self._several = False
        """Whether the statement needs several lines."""
        self._spacing = Spacing(language)
        self._continued = False
        self._labelled = False
        self._branches: list[tuple[_State, _State | None]] = []
        self._last: Token | None = None
        self._flat_until = 0
        self._length = 0
        self._comments_end = 0
        self._line_start = 0
        self._next: dict[str, tuple[int, int]] = {}

    def run(self, check: Callable[[], None] = lambda: None) -> list[Line]:
        """Return the lines, in order; `check` as in `tokens`. Raises LexicalError."""
        index = 0
        while index < len(self._tokens):
            if not index % CHECKED:
                check()
            token = self._tokens[index]
            if token.kind in COMMENTS:
                self._between(token)
                if not self._pieces:
                    index = self._comments(index)
                    continue
            if token.kind is Kind.END:
                self._flush()
            elif token.kind is Kind.DIRECTIVE:
                self._directive(index, token)
            elif token.kind is Kind.VERBATIM and token.text[0] == "_":
                self._flush()
                self._emit(token.text, index, token)
            else:
                self._token(index, token)
            index = max(index + 1, self._flat_until)
            self._last = self._tokens[index - 1]
        return self.lines

    # Lines

    @property
    def _indent(self) -> int:
        return self._frame.step * len(self._blocks)

    def _emit(self, text: str, index: int, token: Token) -> Line:
        """Append a line whose first token is given."""
        first = not self.lines
        blank = token.breaks > 1 and not first and not self.lines[-1].opens
        line = Line(text, index, blank and token.text != "}")
        self.lines.append(line)
        self._count(text)
        return line

    def _count(self, text: str) -> None:
        self._length += len(text)
        if self._length > MAX_CHARACTERS:
            message = f"the formatted text has more than {MAX_CHARACTERS:,} characters"
            raise LexicalError(message, 0, 1, "divide the file into several")

    def _flush(self, ends: bool = True) -> None:
        """Print the statement so far; `ends`: it is complete."""
        pieces = self._pieces
        if pieces:
            trailing: list[Piece] = []
            while (
                len(pieces) > 1
                and pieces[-1].column is not None
                and not pieces[-1].must
            ):
                trailing.append(pieces.pop())
            indent = self._indent + self._frame.step * self._labelled
            step = 2 * self._frame.step
            start = indent + (step if self._continued else 0)
            text = "\n".join(wrapped(pieces, indent, self._frame, start))
            line = self._emit(text, self._begin, self._tokens[self._begin])
            for piece in reversed(trailing):
                self._add_trailing(line, piece.text, piece.column or 0)
            self._start([])
        if ends:
            self._spacing = Spacing(self._language)
            self._words = {}
            self._continued = False
            self._labelled = False
        elif pieces:
            self._continued = True

    def _start(self, pieces: list[Piece]) -> None:
        """Begin a statement with pieces, which are comments."""
        self._pieces = pieces
        self._code = None
        self._annotated = False
        self._several = any(piece.must or "\n" in piece.text for piece in pieces)

    def _add_trailing(self, line: Line, text: str, column: int) -> None:
        if not line.trailing:
            line.column = column
            line.width = len(line.text) - line.text.rfind("\n")
        if "\n" in text:
            text = moved(text, column, line.width)
            line.width = 0
        line.trailing.append(text)
        line.width += len(text) - text.rfind("\n")
        self._count(text)

    def _column(self, token: Token) -> int:
        # From the last token on, since a line can be very long.
        begin = self._line_start if self._line_start <= token.start else 0
        newline = self._text.rfind("\n", begin, token.start)
        self._line_start = begin if newline < 0 else newline + 1
        return token.start - self._line_start

    # Comments and preprocessor lines

    def _comments(self, index: int) -> int:
        """Print comments between statements; return the number of the token after them."""
        token = self._tokens[index]
        end = self._end_of_comments(index)
        follower = self._tokens[end]
        behind = not token.breaks and self.lines and self._may_follow()
        if behind and not self._precedes(token, follower):
            self._add_trailing(
                self.lines[-1], _stripped(token.text), self._column(token)
            )
            self._last = token
            return index + 1
        alone = (
            follower.breaks
            or self._tokens[end - 1].kind is Kind.LINE_COMMENT
            or follower.kind in (Kind.END, Kind.DIRECTIVE)
            or follower.text == "}"
        )
        if alone:
            indent = self._indent + self._frame.step * self._labelled
            pieces = [self._comment_piece(each) for each in self._tokens[index:end]]
            frame = Frame(1 << 30, self._frame.step)
            text = "\n".join(wrapped(pieces, indent, frame))
            self._emit(text, index, token)
        else:
            self._begin = index
            self._start([self._comment_piece(t) for t in self._tokens[index:end]])
            self._spacing.space(self._tokens[end - 1])
        self._last = self._tokens[end - 1]
        return end

    def _end_of_comments(self, index: int) -> int:
        """Return the number of the token after the comments on a line."""
        if not index < self._comments_end:
            end = index + 1
            while (
                self._tokens[end].kind in COMMENTS
                and not self._tokens[end].breaks
                and self._tokens[end - 1].kind is Kind.BLOCK_COMMENT
            ):
                end += 1
            self._comments_end = end
        return self._comments_end

    def _precedes(self, comment: Token, follower: Token) -> bool:
        """Return whether a comment between two declarations on a line goes with the second.

        At the end of the line of the first, it would document that.
        """
        opened = self._last is not None and self._last.text in ("{", ":")
        ends = follower.breaks or follower.text == "}" or follower.kind is Kind.END
        return not (is_trailing(comment.text) or opened or ends)

    def _may_follow(self) -> bool:
        last = self._last
        return last is not None and last.kind is not Kind.DIRECTIVE

    def _comment_piece(self, token: Token) -> Piece:
        column = self._column(token)
        return Piece(_stripped(token.text), True, column=column)

    def _directive(self, index: int, token: Token) -> None:
        word = token.text[1:].lstrip(" \t").split(maxsplit=1)[:1]
        open_ended = bool(self._pieces) and not self._is_closed()
        in_list = bool(self._blocks) and self._blocks[-1]
        if in_list and not self._spacing.depth:
            open_ended = False
        self._flush(ends=not (open_ended or self._continued))
        self._emit(_stripped(token.text), index, token)
        match word:
            case ["if" | "ifdef" | "ifndef"]:
                self._branches.append((self._state(), None))
            case ["else" | "elif"] if self._branches:
                begin, first = self._branches[-1]
                self._branches[-1] = (begin, first or self._state())
                self._restore(begin)
            case ["endif"] if self._branches:
                _, first = self._branches.pop()
                if first is not None:
                    self._restore(first)

    def _state(self) -> _State:
        spacing = self._spacing.copy()
        return _State(self._blocks, spacing, self._continued, self._labelled)

    def _restore(self, state: _State) -> None:
        self._blocks = state.blocks
        self._spacing = state.spacing.copy()
        self._continued = state.continued
        self._labelled = state.labelled

    # Statements

    def _token(self, index: int, token: Token) -> None:
        text = token.text
        mark = token.kind is Kind.MARK
        if mark and text in (";", "}") and not self._in_braces():
            self._spacing.close_all()
        inner = self._spacing.depth > 0
        if mark and text == "}" and not inner:
            self._close(index)
            return
        if mark and text == "{" and not inner and not self._is_value():
            self._open(index)
            return
        self._between(token)
        self._append(index, token)
        if not mark or self._spacing.depth:
            return
        if text == ";" or (text == "," and self._blocks and self._blocks[-1]):
            self._flush()
        elif text == ":" and next(iter(self._words), None) in LABELS:
            self._label(index)

    def _in_braces(self) -> bool:
        return self._spacing.inside.braces > 0

    def _is_value(self) -> bool:
        """Return whether a `{` here starts an initialiser."""
        return self._last is not None and self._last.text == "=" and bool(self._pieces)

    def _is_closed(self) -> bool:
        """Return whether the statement so far is the end of a block, and comments."""
        code = self._code
        return code is not None and code.text == "}" and not self._spacing.depth

    def _between(self, token: Token) -> None:
        """End a line after annotations or specifiers, and after a closed block."""
        if not self._pieces or self._spacing.depth:
            return
        if self._is_closed():
            if token.breaks and token.text not in (";", ","):
                self._flush()
        elif self._is_ahead(token) and (
            token.breaks
            or (
                token.text in _HEADS
                and self._last is not None
                and self._last.text == "]"
            )
        ):
            labelled = self._labelled
            self._flush()
            self._labelled = labelled

    def _is_ahead(self, token: Token) -> bool:
        """Return whether the statement so far is annotations or specifiers only."""
        if self._words or (token.kind is Kind.MARK and token.text in ("(", ";", ",")):
            return False
        return self._annotated

    def _append(self, index: int, token: Token, is_block: bool = False) -> None:
        if not self._pieces:
            self._begin = index
            if token.text in LABELS:
                self._labelled = False
        last = self._tokens[index - 1] if index else None
        spacing = self._spacing
        depth = spacing.depth
        innermost = spacing.innermost
        comment = token.kind in COMMENTS
        piece = Piece(_stripped(token.text) if comment else token.text, False)
        closes_templates = token.text == ">>" and self._closes_templates(index)
        piece.space = spacing.space(
            token, closes_templates=closes_templates, is_block=is_block
        )
        if token.kind is Kind.ANNOTATION:
            piece.text = "@" + token.text[1:].lstrip()
        if comment:
            piece.column = self._column(token)
        if last is not None and self._pieces:
            piece.must = self._must(last, token, innermost)
            piece.may = self._may(last, token, depth)
            piece.restarts = not depth and piece.may == 0 and self._is_ahead(token)
        if token.kind is Kind.MARK:
            if spacing.depth > depth:
                piece.opens = token.text
            elif token.text in _BRACKETS:
                piece.closes = _BRACKETS[token.text]
            elif token.text in (">", ">>") and spacing.depth < depth:
                piece.closes = "<"
        if not depth and token.kind is Kind.WORD:
            self._words[token.text] = None
        if not comment:
            self._code = piece
        if piece.closes in ("[", "(") or piece.text[0] == "@":
            self._annotated = True
        if piece.must or "\n" in piece.text:
            self._several = True
        self._pieces.append(piece)
        _check_depth(spacing.depth, token)

    def _must(self, last: Token, token: Token, innermost: str) -> bool:
        if last.kind is Kind.LINE_COMMENT:
            return True
        if token.breaks and (token.kind in COMMENTS or last.kind in COMMENTS):
            return True
        if innermost == "{" and token.breaks:
            return last.text in ("{", ",") or token.text == "}"
        if last.text in ("<", "<=", "<<") and self._language is Language.CDL:
            return self._is_followed_by_greater(token)
        return False

    def _is_followed_by_greater(self, token: Token) -> bool:
        """Return whether a `<` alone on its line would become an angle string."""
        return self._find(">", token.start) < self._find(";", token.start)

    def _find(self, mark: str, start: int) -> int:
        """Return the offset of the next such mark, else that of the end."""
        begin, place = self._next.get(mark, (0, -1))
        if not begin <= start <= place:
            place = self._text.find(mark, start)
            place = len(self._text) if place < 0 else place
            self._next[mark] = (start, place)
        return place

    def _may(self, last: Token, token: Token, depth: int) -> int | None:
        if token.kind in COMMENTS or token.text in (")", "]", "}", ",", ";"):
            return None
        if last.text == "," and last.kind is Kind.MARK:
            return depth
        if token.kind is Kind.WORD and token.text in _CLAUSES and not depth:
            return 0
        if last.kind is Kind.MARK:
            if last.text == ":" and not depth and not self._words:
                return 0
            if last.text == "=" and not depth:
                return 1
            if last.text == "(":
                return LAST_RESORT + depth
            if not depth and last.text in (")", "]") and self._is_ahead(token):
                return 0
        if token.kind is Kind.MARK and token.text in BINARY and depth < LAST_RESORT:
            closes = token.text in ("*", "&") and self._language is Language.CDL
            return None if closes or self._spacing.innermost == "<" else depth + 1
        if token.kind is last.kind is Kind.STRING:
            return depth + 1
        return None

    def _closes_templates(self, index: int) -> bool:
        """Return whether a `>>` closes two templates, instead of a shift in a bound."""
        inside = self._spacing.inside
        if inside.mark != "<" or inside.outer is None or inside.outer.mark != "<":
            return False
        depth = inside.templates
        for place in range(index + 1, min(index + 200, len(self._tokens))):
            token = self._tokens[place]
            if token.kind is Kind.MARK and token.text in (";", "{", "}"):
                break
            if token.kind is Kind.MARK and token.text.startswith(">"):
                depth -= len(token.text)
        return depth > 0

    def _label(self, index: int) -> None:
        """Print a label of a union's branch, with the branch on its line if written so."""
        follower = self._tokens[index + 1]
        self._words = {}
        if follower.breaks or follower.kind in COMMENTS:
            self._flush()
            self._labelled = True

    # Blocks

    def _open(self, index: int) -> None:
        words = self._words
        if self._inline(index):
            return
        token = self._tokens[index]
        self._append(index, token, is_block=True)
        is_list = not words.keys().isdisjoint(_LISTS)
        self._flush()
        self.lines[-1].opens = True
        self._blocks = (*self._blocks, is_list)
        _check_depth(len(self._blocks), token)

    def _inline(self, index: int) -> bool:
        """Lay out a block on one line if it is written so, is short and fits."""
        end = self._end_of_short(index)
        if end is None:
            return False
        number, begin, spacing = len(self._pieces), self._begin, self._spacing.copy()
        state = self._code, self._annotated, self._several
        for place in range(index, end):
            self._append(place, self._tokens[place], is_block=place == index)
        empty = end == index + 2
        if (empty or self._fits_one_line()) and not self._several:
            for piece in () if empty else self._pieces:
                piece.may = None
            self._flat_until = end
            return True
        del self._pieces[number:]
        self._begin, self._spacing = begin, spacing
        self._code, self._annotated, self._several = state
        return False

    def _fits_one_line(self) -> bool:
        """Return whether the statement so far, and a semicolon, fit on one line."""
        remaining = self._frame.width - self._indent
        for number, piece in enumerate(self._pieces):
            remaining -= len(piece.text) + (piece.space and number > 0)
            if remaining < 1:
                return False
        return True

    def _end_of_short(self, index: int) -> int | None:
        """Return the number after the `}` of a block that may be on one line."""
        follower = self._tokens[index + 1]
        if follower.text == "}" and follower.kind is Kind.MARK:
            return index + 2
        if not self._words.keys().isdisjoint(_OPEN_BLOCKS):
            return None
        limit = self._tokens[index].start + self._frame.width
        statements = 0
        depth = 0
        for place in range(index + 1, len(self._tokens)):
            token = self._tokens[place]
            if token.breaks or token.start > limit or token.kind is Kind.END:
                return None
            if token.kind in (*COMMENTS, Kind.DIRECTIVE, Kind.VERBATIM):
                return None
            if token.kind is not Kind.MARK:
                continue
            if token.text in "([":
                depth += 1
            elif token.text in ")]":
                depth -= 1
            elif token.text == "{":
                if not depth and self._tokens[place - 1].text != "=":
                    return None
                depth += 1
            elif token.text == ";" and not depth:
                statements += 1
            elif token.text == "}":
                if not depth:
                    return place + 1 if statements < 2 else None
                depth -= 1
        return None

    def _close(self, index: int) -> None:
        self._flush()
        self._blocks = self._blocks[:-1]
        self._append(index, self._tokens[index])
        self._pieces[-1].closes = "block"


def _check_depth(depth: int, token: Token) -> None:
    """Raise LexicalError at a token that opens one level too many."""
    if depth > MAX_NESTING:
        message = f"this is nested for more than {MAX_NESTING} levels"
        hint = "declare the inner parts as types or constants of their own"
        raise LexicalError(message, token.start, token.end, hint)


def _stripped(text: str) -> str:
    """Return a comment or directive without trailing blanks, unless they have a meaning."""
    bare = text.rstrip(" \t\r\f\v")
    return text if bare.endswith("\\") else bare
