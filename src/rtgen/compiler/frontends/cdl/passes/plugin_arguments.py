"""Parses the argument string of a plug-in: `name = value, ...`, with the place of each value."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping

from rtgen.compiler.diagnostics import Diagnostic, Related
from rtgen.compiler.frontends.cdl.rules import regions as rules
from rtgen.compiler.model.tecs import PluginArgument, PluginOption

_BLANK = re.compile(r"(?:\s|\\\n)*")
_NAME = re.compile(r"[A-Za-z_]\w*", re.ASCII)
_MARKS = ('\\"', "'", "%", "!")
_BARE = re.compile(r"(?:\\.|[^\\,])*", re.DOTALL)
_ESCAPE = re.compile(r"\\(.)", re.DOTALL)
_SUBSTITUTION = re.compile(r"\$([A-Za-z_]*)\$")


def options(
    argument: PluginArgument,
    known: Mapping[str, str],
    report: Callable[[Diagnostic], None],
) -> tuple[PluginOption, ...]:
    """Return the options of an argument; parsing stops, after a diagnostic, at a malformed one.

    `known` maps the names in `$...$` to their replacements: `source`, `count`, ...
    """
    return _Reader(argument, known, report).result()


class _Reader:
    def __init__(
        self,
        argument: PluginArgument,
        known: Mapping[str, str],
        report: Callable[[Diagnostic], None],
    ) -> None:
        self._argument = argument
        self._text = argument.text
        self._known = known
        self._report = report
        self._place = 0

    def result(self) -> tuple[PluginOption, ...]:
        found: dict[str, PluginOption] = {}
        self._skip()
        while self._place < len(self._text):
            option = self._option()
            if option is None:
                break
            if option.name in found:
                self._report(
                    rules.OPTION_TWICE.at(
                        option.span,
                        f"{option.name} is given twice: the last value counts",
                        related=[Related(found[option.name].span, "the first time")],
                        hint="remove one",
                    )
                )
            found[option.name] = option
        return tuple(found.values())

    def _skip(self) -> None:
        match = _BLANK.match(self._text, self._place)
        assert match is not None
        self._place = match.end()

    def _option(self) -> PluginOption | None:
        name = _NAME.match(self._text, self._place)
        if name is None:
            self._complain("a name is missing here", "write name=value, name=value")
            return None
        self._place = name.end()
        self._skip()
        if not self._text.startswith("=", self._place):
            self._complain(f"= is missing after {name[0]}", f"write {name[0]}=value")
            return None
        self._place += 1
        self._skip()
        value = self._value(name[0])
        if value is None:
            return None
        start, end = value
        option = PluginOption(
            name[0],
            self._substituted(_ESCAPE.sub(r"\1", self._text[start:end]), start, end),
            self._argument.span_of(name.start(), name.end()),
            self._argument.span_of(start, end),
        )
        self._skip()
        return option

    def _value(self, name: str) -> tuple[int, int] | None:
        """Return the start and end of a value without its quotes; advances past its comma."""
        text, start = self._text, self._place
        mark = next((m for m in _MARKS if text.startswith(m, start)), None)
        if mark is None:
            match = _BARE.match(text, start)
            assert match is not None
            self._place = match.end() + 1
            return start, start + len(match[0].rstrip())
        begin = start + len(mark)
        close = self._closing(mark, begin)
        if close < 0:
            self._complain(
                f"the value of {name} is never closed", f"put {mark} at its end"
            )
            return None
        self._place = close + len(mark)
        self._skip()
        if self._place < len(text) and text[self._place] != ",":
            self._complain(
                f"there is text after the value of {name}",
                "a comma is between two options",
            )
            return None
        self._place += 1
        return begin, close

    def _closing(self, mark: str, start: int) -> int:
        if mark == '\\"':
            return self._text.find(mark, start)
        while True:
            found = self._text.find(mark, start)
            if found <= 0 or self._text[found - 1] != "\\":
                return found
            start = found + 1

    def _complain(self, message: str, hint: str) -> None:
        end = self._text.find(",", self._place)
        end = len(self._text) if end < 0 else end
        span = self._argument.span_of(self._place, max(end, self._place + 1))
        self._report(rules.BAD_ARGUMENT.at(span, message, hint=hint))

    def _substituted(self, value: str, start: int, end: int) -> str:
        def put(match: re.Match[str]) -> str:
            word = match[1]
            if not word:
                return "$"
            if word not in self._known:
                self._report(
                    rules.UNKNOWN_SUBSTITUTION.at(
                        self._argument.span_of(start, end),
                        f"unknown variable ${word}$",
                        hint="known are " + ", ".join(f"${w}$" for w in self._known),
                    )
                )
            return self._known.get(word, match[0])

        return _SUBSTITUTION.sub(put, value)
