"""Preprocessor (ISO C 1998, clause 16): includes, conditionals, macros, pragmas, lines."""

from __future__ import annotations

import os
import re
from collections import ChainMap
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

import msgspec

from rtgen.diagnostics import Diagnostic, Related, Span
from rtgen.frontends.idl.rules import lexical
from rtgen.frontends.idl.text import conditions
from rtgen.frontends.idl.text.macros import (
    TOKEN,
    Expander,
    ExpansionError,
    Macro,
    MacroTable,
    MalformedMacroError,
    Token,
    define,
    tokenize,
)
from rtgen.frontends.idl.text.source import Library, Source
from rtgen.frontends.idl.text.unit import Boundary, Inclusion, Pragma, TextBuilder, Unit
from rtgen.frontends.kit.suggestions import Guesses, nearest

MAX_DEPTH = 256
"""Maximum nesting of includes."""

MOST_WITHIN_ITSELF = 32
"""Maximum nesting of a file within itself; more is a cycle."""

MAX_EXPANSION = 500_000
"""Maximum number of tokens from macro calls in a translation unit."""

MAX_INCLUDES = 10_000
"""Maximum number of inclusions in a translation unit."""

_DIRECTIVE = re.compile(r"^[ \t\v\f\r]*(?:#|%:)([^\n]*)", re.MULTILINE)
_COMMAND = re.compile(r"\s*([^\W\d]\w*|\d+|)\s*(.*?)\s*$", re.DOTALL)
_INCLUDE = re.compile(r'"([^"\n]+)"|<([^>\n]+)>')
_LINE = re.compile(r'(\d{1,9})(?:\s+"((?:\\.|[^"\\])*)"(?:\s+\d+)*)?')
_STRUCTURE = re.compile(
    r'"(?:\\.|[^"\\])*"|\'(?:\\.|[^\'\\\n]){0,12}\'|[{}()\[\]]|[^\s{}()\[\]"\']+'
)
_NAME_OR_TEXT = re.compile(
    r"""L?"(?:\\.|[^"\\])*"|L?'(?:\\.|[^'\\\n]){0,12}'|\.?\d(?:[eE][+-]|[\w.])*|[^\W\d]\w*""",
    re.DOTALL,
)
_WORD = re.compile(r"[^\W\d]\w*")
_KNOWN = (
    *("define", "elif", "else", "endif", "error", "if", "ifdef", "ifndef", "include"),
    *("include_next", "line", "pragma", "undef", "warning"),
)
_ONCE = "#once "
_PREDEFINED = ("__FILE__", "__LINE__")
_ASKED_FOR = {
    "__OMNIIDL__": "0x2630",
    "__RTGEN__": "1",
    "__STDC__": "1",
    "__STDC_VERSION__": "199409L",
    "__DATE__": '"Jan  1 1970"',
    "__TIME__": '"00:00:00"',
}
"""Macros that files test for; all but `__RTGEN__` and the times are those of omniidl 4.2.5."""
_TIMES = {
    name: define(f"{name} {_ASKED_FOR[name]}") for name in ("__DATE__", "__TIME__")
}


_Folders = tuple[Path | None, ...]
"""Folders of `-I` to search; None stands for that of the including file."""

_Place = tuple[Path | None, _Folders, str]
"""The folder of the including file if it is searched, the other folders, and the file's name."""


class _Conditional(msgspec.Struct):
    """An open `#if`: whether its lines are active, and whether a branch has been taken."""

    span: Span
    outer: bool
    active: bool
    taken: bool
    otherwise: bool = False


class _Prepared(msgspec.Struct, frozen=True):
    """A cached unit and the macros it depends on; reusable if those are the same."""

    words: set[str]
    defined: dict[str, Macro]
    undefined: set[str]
    changes: dict[str, Macro | None]
    unit: Unit
    weight: int
    """Number of inclusions in the unit with itself, without empty files."""

    def fits(self, macros: Mapping[str, Macro]) -> bool:
        return macros.keys().isdisjoint(self.undefined) and all(
            macros.get(name) == macro for name, macro in self.defined.items()
        )


def predefined(values: Mapping[str, str]) -> dict[str, Macro]:
    """The macro table at the start of a translation unit: predefined macros and `values`.

    Raises ExpansionError for a name that is no identifier.
    """
    table = {**_ASKED_FOR, **values}
    macros = {}
    for name, value in table.items():
        if not re.fullmatch(r"[A-Za-z_]\w*", name):
            raise ExpansionError(f"'{name}' cannot be the name of a macro")
        macros[name] = define(f"{name} {value}")
    for name in _PREDEFINED:
        macros[name] = Macro(name, None, ())
    return macros


class Preprocessor:
    """Turns files into units; diagnostics go to `report`, once for each place."""

    def __init__(self, library: Library, report: Callable[[Diagnostic], None]) -> None:
        self._library = library
        self._report = report
        self._prepared: dict[Source, list[_Prepared]] = {}
        self._found: dict[_Place, Source] = {}
        self._missing: dict[_Place, str] = {}
        self._origins: dict[Source, Path | None] = {}
        self._searched: dict[tuple[Path | None, _Folders], tuple[str, list[str]]] = {}
        self._guesses = Guesses()
        self._stack: list[Source] = []
        self.tokens_left = MAX_EXPANSION
        self._included = 0
        self._exhausted = False

    def translation_unit(self, source: Source, macros: Mapping[str, Macro]) -> Unit:
        """The unit of a main file with everything that it includes."""
        self.tokens_left = MAX_EXPANSION
        self._included = 0
        self._exhausted = False
        return self._prepare(source, MacroTable(macros)).unit

    def _prepare(self, source: Source, macros: MacroTable) -> _Prepared:
        known = self._prepared.setdefault(source, [])
        for prepared in known:
            if prepared.fits(macros):
                for name, macro in prepared.changes.items():
                    macros.put(name, macro)
                return prepared
        start = macros.now
        for problem in source.problems:
            self._report(problem)
        included = self._included
        file = _File(self, source, macros, TextBuilder(source))
        self._stack.append(source)
        file.run()
        self._stack.pop()
        unit = file.builder.finish()
        weight = self._included - included
        weight += bool(unit.events or not (unit.text.isspace() or unit.text == ""))
        self._included = included
        replaced = macros.changed_since(start)
        before = {word: replaced.get(word, macros.get(word)) for word in file.words}
        prepared = _Prepared(
            words=file.words,
            defined={name: macro for name, macro in before.items() if macro},
            undefined={name for name, macro in before.items() if macro is None},
            changes={name: macros.get(name) for name in replaced},
            unit=unit,
            weight=weight,
        )
        if not self._exhausted:
            known.append(prepared)
        return prepared

    def include(
        self, file: _File, name: str, span: Span, *, quoted: bool, further: bool
    ) -> None:
        """Include the file named by an `#include` in `file`.

        `further`: as GNU's `#include_next`, search only the folders after that of `file`.
        """
        folders: _Folders = (None, *self._library.include)
        origin = self._origins.get(file.source)
        if further and origin is not None:
            folders = folders[folders.index(origin) + 1 :]
        elif not quoted:
            folders = folders[1:]
        place = (file.source.folder if None in folders else None, folders, name)
        source = self._found.get(place) or self._find(place, span)
        if source is None:
            file.builder.unit.lacking = True
            return
        self._found[place] = source
        if _ONCE + source.real in file.macros:
            return
        if (
            len(self._stack) >= MAX_DEPTH
            or self._stack.count(source) >= MOST_WITHIN_ITSELF
            or self._included >= MAX_INCLUDES
        ):
            self._exhaust(source, span)
        if self._exhausted:
            file.builder.unit.lacking = True
            return
        if file.at_file_scope():
            prepared = self._prepare(source, file.macros)
            file.words |= prepared.words
            self._included += prepared.weight
            if self._included > MAX_INCLUDES:
                self._exhaust(source, span)
                return
            inclusion = Inclusion(file.builder.length, prepared.unit, span)
            file.builder.unit.events.append(inclusion)
            return
        self._included += 1
        unit = file.builder.unit
        for problem in source.problems:
            self._report(problem)
        unit.nested.append(source)
        unit.events.append(Boundary(file.builder.length, source, True))
        inner = _File(self, source, file.macros, file.builder, nested=True)
        self._stack.append(source)
        inner.run()
        self._stack.pop()
        file.words |= inner.words
        unit.events.append(Boundary(file.builder.length, source, False))

    def _exhaust(self, source: Source, span: Span) -> None:
        """Ignore all further includes."""
        if not self._exhausted:
            cycle: list[Source] = []
            if source in self._stack:
                cycle = self._stack[self._stack.index(source) :]
            chain = " -> ".join(s.name for s in (*cycle[:6], source)) if cycle else ""
            message = (
                f"the includes have no end: {chain}" if chain else "too many includes"
            )
            hint = "give each file an include guard, or #pragma once"
            self._report(lexical.INCLUDE_CYCLE.at(span, message, hint=hint))
        self._exhausted = True

    def _find(self, place: _Place, span: Span) -> Source | None:
        """Find a file in the folder of its includer, or in those of -I."""
        beside, folders, name = place
        if place not in self._missing:
            try:
                for folder in folders:
                    searched = folder or beside or ""
                    path = os.path.join(searched, name)  # noqa: PTH118 (time)
                    found = self._library.open(path, folder)
                    if found is not None:
                        self._origins.setdefault(found, folder)
                        return found
            except (OSError, ValueError) as error:
                reason = getattr(error, "strerror", None) or error
                message = f"{name} cannot be read: {reason}"
                self._report(lexical.UNREADABLE.at(span, message))
                return None
            if (virtual := self._library.virtual(name)) is not None:
                return virtual
            self._missing[place] = self._hint(place)
        self._report(
            lexical.INCLUDE_NOT_FOUND.at(
                span, f"the file {name} was not found", hint=self._missing[place]
            )
        )
        return None

    def _hint(self, place: _Place) -> str:
        """The folders searched, and a file there with a similar name."""
        beside, folders, name = place
        if (beside, folders) not in self._searched:
            real = [folder or beside or Path() for folder in folders]
            shown = dict.fromkeys(map(self._library.displayed, real))
            files = [p.name for folder in real for p in sorted(folder.glob("*.idl"))]
            places = ", ".join(shown) or "no folder (use -I)"
            files += self._library.virtual_names
            self._searched[beside, folders] = places, files
        places, files = self._searched[beside, folders]
        last = Path(name).name
        near = self._guesses.nearest(last, files)
        if near is None:
            return f"searched: {places}"
        case = " (only the case differs)" if near.lower() == last.lower() else ""
        return f"did you mean {near}?{case} searched: {places}"

    def report(self, diagnostic: Diagnostic) -> None:
        """Report a diagnostic."""
        self._report(diagnostic)


class _File:
    """Preprocesses one file."""

    def __init__(
        self,
        owner: Preprocessor,
        source: Source,
        macros: MacroTable,
        builder: TextBuilder,
        nested: bool = False,
    ) -> None:
        self.source = source
        self.macros = macros
        self.builder = builder
        self.words: set[str] = set()
        self._owner = owner
        self._nested = nested
        self._open: list[_Conditional] = []
        self._file: str | None = None
        self._shift = 0
        self._depth = 0
        self._complete = True
        self._seen = 0
        self._endless = False

    @property
    def _active(self) -> bool:
        return not self._open or self._open[-1].active

    def run(self) -> None:
        """Append the file to the builder."""
        code = self.source.code
        start = 0
        for match in _DIRECTIVE.finditer(code):
            self._text(start, match.start())
            self._directive(match)
            start = match.end()
        self._text(start, len(code))
        unit = self.builder.unit
        if self.source.unfinished or not self._active:
            unit.cut = unit.lacking = True
        for conditional in self._open:
            self._owner.report(
                lexical.UNCLOSED_CONDITIONAL.at(
                    conditional.span,
                    "this conditional is never closed",
                    hint="add #endif at the end of the file",
                )
            )

    def at_file_scope(self) -> bool:
        """Whether the text so far ends between two definitions at file scope."""
        if self._nested:
            return False
        text, self._seen = self.builder.tail(self._seen)
        for match in _STRUCTURE.finditer(text):
            mark = match[0]
            if mark in "{([":
                self._depth += 1
            elif mark in "})]":
                self._depth -= 1
            self._complete = mark.endswith(";")
        return self._depth <= 0 and self._complete

    def _text(self, start: int, end: int) -> None:
        if start == end or not self._active:
            return
        code = self.source.code
        copied = start
        calls = not self.macros.keys().isdisjoint(self._words(start, end))
        for match in _NAME_OR_TEXT.finditer(code, start, end) if calls else ():
            macro = self.macros.get(match[0])
            if macro is None or match.start() < copied:
                continue
            self._copy(copied, match.start())
            self._warn_of_time([macro.name], self._span(match.start(), match.end()))
            copied = self._end_of_call(macro, match.start(), match.end(), end)
            call = tokenize(code[match.start() : copied])
            self._replace(call, match.start(), copied)
        self._copy(copied, end)

    def _warn_of_time(self, words: Iterable[str], span: Span) -> None:
        """Warn of a text that depends on the time of its translation."""
        for name in sorted(_TIMES.keys() & words):
            if self.macros.get(name) == _TIMES[name]:
                self._owner.report(
                    lexical.TIME_OF_TRANSLATION.at(
                        span,
                        f"{name} is always {_TIMES[name].body[0].text} here",
                        hint=f"say what it is: -D {name}=...",
                    )
                )

    def _words(self, start: int, end: int) -> set[str]:
        """Record the identifiers of an active piece: macros among them determine its result."""
        words = set(_WORD.findall(self.source.code, start, end))
        self.words |= words
        return words

    def _copy(self, start: int, end: int) -> None:
        self.builder.copy(self.source, start, end, self._file, self._shift)

    def _end_of_call(self, macro: Macro, start: int, behind: int, end: int) -> int:
        """The end of the call that starts at `start`, whose name ends before `behind`.

        Arguments for its expansion belong to the call, too (ISO C, 16.3.4).
        """
        code = self.source.code
        until = behind if macro.parameters is None else _call_end(code, behind, end)
        while (further := _call_end(code, until, end)) > until:
            try:
                expanded = Expander(self.macros).expand(tokenize(code[start:until]))
            except ExpansionError:
                break
            last = next((t for t in reversed(expanded) if t.kind != "space"), None)
            inner = self.macros.get(last.text) if last and last.kind == "name" else None
            if last is None or inner is None or inner.name in last.hidden:
                break
            until = further
        return until

    def _replace(self, call: list[Token], start: int, end: int) -> None:
        """Append the expansion of the macro call at [start, end)."""
        span = self._span(start, end)
        builder = self.builder
        expander = Expander(self._table(span), self._owner.tokens_left)
        try:
            if self._endless:
                raise ExpansionError("the macros expand without end")
            tokens = expander.expand(call)
        except ExpansionError as error:
            self._endless = self._endless or expander.exhausted
            macro = self.macros.get(call[0].text)
            defined = macro.span if macro else None
            related = [Related(defined, "defined here")] if defined else []
            self._owner.report(
                lexical.BAD_MACRO_CALL.at(span, error.message, related=related)
            )
            tokens = call[:1]
            builder.unit.lacking = True
            builder.unit.flawed.add(builder.length)
        self._owner.tokens_left -= expander.used
        expanded = f" {''.join(token.text for token in tokens)} "
        builder.expand(expanded, self.source, start, end, self._file, self._shift)

    def _table(self, span: Span) -> Mapping[str, Macro]:
        file = self._file or self.source.name
        place = {
            "__FILE__": Macro("__FILE__", None, (Token("text", f'"{file}"'),)),
            "__LINE__": Macro("__LINE__", None, (Token("number", str(span.line)),)),
        }
        return ChainMap(place, self.macros)

    def _span(self, start: int, end: int) -> Span:
        span = self.source.span(start, end)
        if self._file is None and not self._shift:
            return span
        return Span(
            self._file or span.file,
            max(span.line + self._shift, 1),
            span.column,
            max(span.end_line + self._shift, 1),
            span.end_column,
        )

    def _directive(self, match: re.Match[str]) -> None:
        command = _COMMAND.match(match[1])
        assert command is not None
        name, rest = command[1], command[2]
        begin = match.start(1)
        hash_at = begin - (1 if self.source.code[begin - 1] == "#" else 2)
        span = self._span(hash_at, max(begin + command.end(2), begin))
        if self._active or (name == "elif" and self._open[-1].outer):
            self._words(begin, match.end())
        match name:
            case "if" | "ifdef" | "ifndef":
                self._begin(name, rest, span)
            case "elif" | "else" | "endif":
                self._continue(name, rest, span)
            case _ if not self._active:
                return
            case "" if not rest:
                return
            case "define":
                self._define(rest, span)
                self._warn_of_time(_WORD.findall(rest), span)
            case "undef":
                self.macros.put(rest.split()[0] if rest else "", None)
            case "include" | "include_next":
                self._include(rest, span, further=name == "include_next")
            case "assert" | "unassert":
                message = f"#{name} is passed over"
                hint = "use #define and #undef"
                self._owner.report(lexical.PASSED_OVER.at(span, message, hint=hint))
            case "error":
                self._owner.report(lexical.ERROR_DIRECTIVE.at(span, rest or "#error"))
            case "warning":
                self._owner.report(
                    lexical.WARNING_DIRECTIVE.at(span, rest or "#warning")
                )
            case "pragma":
                self._pragma(rest, span)
            case "line":
                self._line(self._expanded(rest, span), match.end(), span)
            case _ if name.isdigit():
                self._line(f"{name} {rest}", match.end(), span)
            case _:
                near = nearest(name, _KNOWN)
                if near == "include":
                    self.builder.unit.lacking = True
                self._owner.report(
                    lexical.UNKNOWN_DIRECTIVE.at(
                        span,
                        f"'#{name or rest.split()[0]}' is no directive",
                        hint=(
                            f"did you mean #{near}?"
                            if near
                            else "a comment begins with //, a pragma with #pragma"
                        ),
                    )
                )

    def _begin(self, name: str, rest: str, span: Span) -> None:
        outer = self._active
        value = False
        if outer:
            if name == "if":
                value = self._condition(rest, span)
            elif found := _WORD.match(rest):
                value = (found[0] in self.macros) == (name == "ifdef")
            else:
                value = name == "ifndef"
                message = f"#{name} needs the name of a macro"
                hint = f"write #{name} NAME, or #if for an expression"
                self._owner.report(
                    lexical.NAMELESS_CONDITION.at(span, message, hint=hint)
                )
        self._open.append(_Conditional(span, outer, outer and value, value))

    def _continue(self, name: str, rest: str, span: Span) -> None:
        if not self._open:
            message = f"#{name} without #if"
            hint = "remove it, or look for an #if that is missing before it"
            self._owner.report(lexical.STRAY_CONDITIONAL.at(span, message, hint=hint))
            return
        current = self._open[-1]
        if name == "endif":
            self._open.pop()
            return
        if current.otherwise:
            self._owner.report(
                lexical.STRAY_CONDITIONAL.at(
                    span,
                    f"#{name} after #else",
                    related=[Related(current.span, "of this conditional")],
                    hint="an #if has one #else, which comes last",
                )
            )
            return
        if name == "else":
            current.otherwise = True
            current.active = current.outer and not current.taken
        elif current.taken or not current.outer:
            current.active = False
        else:
            current.active = self._condition(rest, span)
        current.taken = current.taken or current.active

    def _condition(self, text: str, span: Span) -> bool:
        try:
            return conditions.evaluate(text, self._table(span))
        except ExpansionError as error:
            hint = "write an integer expression, such as defined(NAME) && VERSION >= 2"
            self._owner.report(lexical.BAD_CONDITION.at(span, error.message, hint=hint))
            return False

    def _define(self, rest: str, span: Span) -> None:
        try:
            macro = define(rest, span)
        except MalformedMacroError as error:
            hint = "write #define NAME TEXT, or #define NAME(A, B) TEXT"
            self._owner.report(
                lexical.BAD_DEFINITION.at(span, error.message, hint=hint)
            )
            if error.macro is not None and error.macro.name not in _PREDEFINED:
                self.macros.put(error.macro.name, error.macro)
            return
        if macro.name in (*_PREDEFINED, "defined"):
            message = f"{macro.name} cannot be defined"
            hint = "choose another name"
            self._owner.report(lexical.BAD_DEFINITION.at(span, message, hint=hint))
            return
        previous = self.macros.get(macro.name)
        if previous is not None and previous != macro:
            related = (
                [Related(previous.span, "first defined here")] if previous.span else []
            )
            self._owner.report(
                lexical.MACRO_REDEFINED.at(
                    span,
                    f"{macro.name} is defined again, differently",
                    related=related,
                    hint=f"put #undef {macro.name} before, if that is meant",
                )
            )
        self.macros.put(macro.name, macro)

    def _expanded(self, text: str, span: Span) -> str:
        try:
            tokens = Expander(self._table(span)).expand(tokenize(text))
        except ExpansionError as error:
            self._owner.report(lexical.BAD_MACRO_CALL.at(span, error.message))
            return text
        return "".join(token.text for token in tokens)

    def _include(self, rest: str, span: Span, further: bool) -> None:
        found = _INCLUDE.match(rest) or _INCLUDE.match(
            self._expanded(rest, span).strip()
        )
        if found is None:
            name = rest.strip("\"<>'; \t") or "file.idl"
            self._owner.report(
                lexical.BAD_INCLUDE.at(
                    span,
                    '#include needs "file" or <file> behind it',
                    hint=f'write #include "{name}"',
                )
            )
            self.builder.unit.lacking = True
            return
        name = found[1] or found[2].strip()
        self._owner.include(self, name, span, quoted=bool(found[1]), further=further)

    def _pragma(self, rest: str, span: Span) -> None:
        if rest.split() == ["once"]:
            name = _ONCE + self.source.real
            self.words.add(name)
            self.macros.put(name, Macro(name, None, ()))
            return
        self.builder.unit.events.append(Pragma(self.builder.length, rest, span))

    def _line(self, rest: str, end: int, span: Span) -> None:
        found = _LINE.match(rest)
        if found is None:
            self._owner.report(
                lexical.BAD_LINE_MARKER.at(
                    span,
                    "a line marker needs a line number",
                    hint='write #line 12 "file.idl"',
                )
            )
            return
        following = self.source.position(self.source.text_offset(end))[0] + 1
        self._shift = max(int(found[1]), 1) - following
        if found[2] is not None:
            self._file = re.sub(r"\\(.)", r"\1", found[2])


def _call_end(code: str, start: int, end: int) -> int:
    """The end of the arguments of the call whose name ends at `start`, or `start`."""
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
