"""Error recovery of the LALR parser: unwinds to a list of declarations and skips the broken one."""

from __future__ import annotations

import re

from rtgen.compiler.frontends.kit.lalr import END, Parser, token


class RecoveringParser(Parser):
    """A parser of a language with braces and `;`, whose lists of declarations accept `ERROR`."""

    def unwind(self) -> int:
        """Unwind to the innermost list of declarations; return the number of braces that were
        open.
        """
        depth = 0
        while len(self.states) > 1 and (depth < 0 or not self.would_shift("ERROR")):
            self.states.pop()
            kind = getattr(self.values.pop(), "type", None)
            depth += (kind == "LBRACE") - (kind == "RBRACE")
        return depth

    def resumption(self, start: int, depth: int, marks: re.Pattern[str]) -> int:
        """Return where parsing resumes after an error at `start`, with `depth` open braces.

        The stack was unwound. See `_resumption` for `marks`.
        """
        text = self._text
        position = _resumption(text, start, depth, marks)
        stuck = position == start < len(text)
        if stuck and "RBRACE" not in self.accepts():
            end = _end_of_declaration(text, start + 1)
            return start + 1 if end is None else end
        return position

    def opening(self) -> int | None:
        """Return the offset of the innermost open brace."""
        for value in reversed(self.values):
            if getattr(value, "type", None) == "LBRACE":
                place: int = value.start_pos
                return place
        return None

    def close(self, end: int, most: int) -> None:
        """Close open constructs at the end of the text, to keep what was read before.

        At most `most` tokens are supplied; what is still open then is dropped.
        """
        self.position = end
        for _ in range(most):
            accepted = self.accepts()
            if END in accepted:
                return
            if "RBRACE" in accepted:
                self.feed(token("RBRACE", end, "}"))
            elif "SEMI" in accepted:
                self.feed(token("SEMI", end, ";"))
            else:
                self.unwind()
                self.feed(token("ERROR", end))
        del self.states[1:], self.values[:]


_END_OF_DECLARATION = re.compile(r"\s*;|[ \t]*\w+\s*;")


def _end_of_declaration(text: str, offset: int) -> int | None:
    """Return the end of a `;`, or of a name and a `;`, at an offset; None without either."""
    rest = _END_OF_DECLARATION.match(text, offset)
    return rest.end() if rest else None


def _resumption(text: str, start: int, depth: int, marks: re.Pattern[str]) -> int:
    """Return where parsing resumes after an error at `start`, with `depth` open braces.

    This is after the `;` that ends the declaration, or before the `}` around it. `marks` matches
    braces, `;`, and the strings that may contain them.
    """
    opened = depth > 0
    for match in marks.finditer(text, start):
        mark = match[0]
        if mark == "{":
            depth += 1
            opened = True
        elif mark == "}":
            if depth == 0:
                return match.start()
            depth -= 1
            if depth == 0 and opened:
                end = _end_of_declaration(text, match.end())
                return match.end() if end is None else end
        elif mark == ";" and depth == 0:
            return match.end()
    return len(text)
