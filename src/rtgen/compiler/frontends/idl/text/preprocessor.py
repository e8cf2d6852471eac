"""Preprocessor (ISO C 1998, clause 16): includes, conditionals, macros, pragmas, lines."""

from __future__ import annotations

import re
from collections import ChainMap
from collections.abc import Iterable, Mapping

import msgspec

from rtgen.compiler.diagnostics import Diagnostic, Related, Span
from rtgen.compiler.frontends.idl.rules import lexical
from rtgen.compiler.frontends.idl.text.conditionals import Conditionals
from rtgen.compiler.frontends.idl.text.include_path import IncludePath, Place
from rtgen.compiler.frontends.idl.text.macros import (
    Expander,
    ExpansionError,
    Macro,
    MacroTable,
    MalformedMacroError,
    Token,
    call_end,
    define,
    tokenize,
)
from rtgen.compiler.frontends.idl.text.predefined import PLACES, TIMES
from rtgen.compiler.frontends.idl.text.source import Library, Source
from rtgen.compiler.frontends.idl.text.unit import (
    Boundary,
    Inclusion,
    Pragma,
    Repeated,
    TextBuilder,
    Unit,
)
from rtgen.compiler.frontends.kit.suggestions import nearest
from rtgen.compiler.kit.limits import MAX_NESTING

MAX_SELF_INCLUDES = 32
"""Maximum nesting of a file within itself; more is a cycle."""

MAX_EXPANSION = 500_000
"""Maximum number of tokens from macro calls in a translation unit."""

MAX_INCLUDES = 10_000
"""Maximum number of inclusions in a translation unit."""

MAX_RESULTS = 16
"""Maximum number of results of a file that are cached, each for other macros."""

_DIRECTIVE = re.compile(r"^[ \t\v\f\r]*(?:#|%:)([^\n]*)", re.MULTILINE)
_COMMAND = re.compile(r"\s*([^\W\d]\w*|[0-9]+|)\s*(.*?)\s*$", re.DOTALL)
_INCLUDE = re.compile(r'"([^"\n]+)"|<([^>\n]+)>')
_LINE = re.compile(r'([0-9]{1,9})(?:\s+"((?:\\.|[^"\\])*)"(?:\s+[0-9]+)*)?')
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


class _Reusable(msgspec.Struct):
    """A result, and the macros it depends on; reusable if those are the same."""

    words: set[str]
    defined: dict[str, Macro]
    undefined: set[str]

    def fits(self, macros: Mapping[str, Macro]) -> bool:
        return macros.keys().isdisjoint(self.undefined) and (
            self.defined.items() <= macros.items()
        )


class _Row(_Reusable):
    """Includes in successive lines of files that have been included before: they add nothing.

    [start, end) is their place in the code, `text` what is between them; `searched` and `printed`
    as in `Unit`.
    """

    start: int
    end: int
    text: str = ""
    sources: dict[str, Source] = {}
    places: list[tuple[str, Span]] = []
    searched: dict[str, None] = {}
    printed: dict[str, None] = {}

    def add(self, other: _Row) -> None:
        """Add the row in the next line, for which the same macros are defined."""
        self.words |= other.words
        self.defined |= other.defined
        self.undefined |= other.undefined
        self.end = other.end
        self.text += "\n"
        self.sources |= other.sources
        self.places += other.places
        self.searched |= other.searched
        self.printed |= other.printed


class _Prepared(_Reusable):
    """A cached unit."""

    changes: dict[str, Macro | None]
    unit: Unit
    weight: int
    """Number of inclusions in the unit with itself, without empty files."""
    tokens: int
    """Number of tokens from macro calls."""

    @property
    def repeats(self) -> bool:
        """Whether the file has been included before, and its guard has left nothing of it."""
        unit = self.unit
        return not (
            unit.text.strip()
            or unit.events
            or unit.searched
            or unit.findings.diagnostics
            or unit.lacking
            or self.changes
            or not self.defined
        ) and all(
            macro.span is not None and macro.span.file == unit.source.name
            for macro in self.defined.values()
        )


class Preprocessor:
    """Preprocesses files to units, which hold the diagnostics."""

    def __init__(self, library: Library) -> None:
        self._path = IncludePath(library)
        self._prepared: dict[Source, list[_Prepared]] = {}
        self._rows: dict[tuple[Source, int], _Row] = {}
        self._stack: list[Source] = []
        self.macros: dict[tuple[Macro, Span], Macro] = {}
        """Each macro once, since they are often compared."""
        self.tokens_left = MAX_EXPANSION
        self._included = 0
        self._exhausted = False

    def translation_unit(self, source: Source, macros: Mapping[str, Macro]) -> Unit:
        """Return the unit of a main file with everything that it includes."""
        self.tokens_left = MAX_EXPANSION
        self._included = 0
        self._exhausted = False
        return self._prepare(source, MacroTable(macros)).unit

    def _prepare(self, source: Source, macros: MacroTable) -> _Prepared:
        cached = self._prepared.setdefault(source, [])
        for index, prepared in enumerate(cached):
            if prepared.fits(macros):
                cached.insert(0, cached.pop(index))
                for name, macro in prepared.changes.items():
                    macros.put(name, macro)
                self.tokens_left -= prepared.tokens
                return prepared
        start = macros.now
        included = self._included
        tokens = self.tokens_left
        file = _File(self, source, macros, TextBuilder(source))
        for problem in source.problems:
            file.builder.unit.findings.report(problem)
        self._stack.append(source)
        file.run()
        self._stack.pop()
        unit = file.builder.finish()
        weight = self._included - included
        weight += bool(unit.events or not (unit.text.isspace() or unit.text == ""))
        self._included = included
        replaced = macros.changed_since(start)
        before = {**macros, **replaced}
        named = file.words & before.keys()
        defined = {name: macro for name in named if (macro := before[name])}
        prepared = _Prepared(
            words=file.words,
            defined=defined,
            undefined=file.words - defined.keys(),
            changes={name: macros.get(name) for name in replaced},
            unit=unit,
            weight=weight,
            tokens=tokens - self.tokens_left,
        )
        if not self._exhausted:
            cached.insert(0, prepared)
            del cached[MAX_RESULTS:]
        return prepared

    def include(
        self, file: _File, name: str, span: Span, *, quoted: bool, further: bool
    ) -> None:
        """Include the file named by an `#include` in `file`.

        `further`: search only the folders after that of `file`, as GNU's `#include_next` does.
        """
        unit = file.builder.unit
        place = self._path.place(file.source, name, quoted=quoted, further=further)
        source = self._path.find(place, span, unit)
        # The folder where a file was found may have been recorded in another unit.
        unit.guessed = unit.guessed or further
        if source is None:
            unit.lacking = True
            return
        once = _ONCE + source.real
        file.words.add(once)
        if once in file.macros:
            self._note(file, {once}, place)
            return
        if (
            len(self._stack) >= MAX_NESTING
            or self._stack.count(source) >= MAX_SELF_INCLUDES
            or self._included >= MAX_INCLUDES
        ):
            self._exhaust(source, span, unit)
        if self._exhausted:
            unit.lacking = True
            return
        if file.at_file_scope():
            prepared = self._prepare(source, file.macros)
            file.words |= prepared.words
            if prepared.repeats:
                event = Repeated(
                    file.builder.length, {source.name: source}, [(source.name, span)]
                )
                unit.events.append(event)
                self._note(file, prepared.words | {once}, place, event)
                return
            unit.included.append(prepared.unit)
            self._included += prepared.weight
            if self._included > MAX_INCLUDES:
                self._exhaust(source, span, unit)
                return
            inclusion = Inclusion(file.builder.length, prepared.unit, span)
            unit.events.append(inclusion)
            return
        self._included += 1
        for problem in source.problems:
            unit.findings.report(problem)
        unit.nested.append(source)
        unit.events.append(Boundary(file.builder.length, source, True))
        inner = _File(self, source, file.macros, file.builder, nested=True)
        self._stack.append(source)
        inner.run()
        self._stack.pop()
        file.words |= inner.words
        unit.events.append(Boundary(file.builder.length, source, False))

    def _note(
        self,
        file: _File,
        words: set[str],
        place: Place,
        event: Repeated | None = None,
    ) -> None:
        """Note that the include at hand adds nothing."""
        _, searched, printed = self._path.known[place]
        row = file.note(words, event, searched, place[-1:] if printed else ())
        if row is not None:
            self._rows[file.source, row.start] = row

    def row(self, file: _File, start: int) -> _Row | None:
        """Return the includes at `start` of a file's code, if they add nothing here."""
        row = self._rows.get((file.source, start))
        usable = (
            row is not None
            and not self._exhausted
            and len(self._stack) < MAX_NESTING
            and file.is_unchanged()
            and row.fits(file.macros)
        )
        return row if usable else None

    def _exhaust(self, source: Source, span: Span, unit: Unit) -> None:
        """Report the limit, and ignore all further includes."""
        if not self._exhausted:
            cycle: list[Source] = []
            if source in self._stack:
                cycle = self._stack[self._stack.index(source) :]
            chain = " -> ".join(s.name for s in (*cycle[:6], source)) if cycle else ""
            message = (
                f"the includes have no end: {chain}" if chain else "too many includes"
            )
            hint = "give each file an include guard, or #pragma once"
            unit.findings.report(lexical.INCLUDE_CYCLE.at(span, message, hint=hint))
        self._exhausted = True


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
        self._conditionals = Conditionals(self._report)
        self._file: str | None = None
        self._shift = 0
        self._depth = 0
        self._complete = True
        self._seen = 0
        self._endless = False
        self._row: _Row | None = None
        self._here: re.Match[str]

    def _report(self, diagnostic: Diagnostic) -> None:
        self.builder.unit.findings.report(diagnostic)

    def run(self) -> None:
        """Append the file to the builder."""
        code = self.source.code
        start = 0
        while match := _DIRECTIVE.search(code, start):
            self._text(start, match.start())
            row = self._owner.row(self, match.start())
            if row is None:
                self._here = match
                self._directive(match)
                start = match.end()
            else:
                self._pass_over(row)
                start = row.end
        self._text(start, len(code))
        unit = self.builder.unit
        if self.source.unfinished or not self._conditionals.active:
            unit.cut = unit.lacking = True
        self._conditionals.end()

    def _pass_over(self, row: _Row) -> None:
        """Append includes that add nothing."""
        self.words |= row.words
        unit = self.builder.unit
        unit.searched |= row.searched
        unit.printed |= row.printed
        if row.places:
            event = Repeated(self.builder.length, row.sources.copy(), [*row.places])
            unit.events.append(event)
        self.builder.expand(row.text, self.source, row.start, row.end, None, 0)

    def note(
        self,
        words: set[str],
        event: Repeated | None,
        searched: Iterable[str],
        printed: Iterable[str],
    ) -> _Row | None:
        """Note that the directive at hand adds nothing; return a row that begins with it."""
        if not self.is_unchanged():
            return None
        start, end = self._here.span()
        words = words.union(_WORD.findall(self.source.code, start, end))
        defined = {name: self.macros[name] for name in words & self.macros.keys()}
        row = _Row(
            *(words, defined, words - defined.keys(), start, end, ""),
            *((dict(event.sources), [*event.places]) if event else ({}, [])),
            *(dict.fromkeys(searched), dict.fromkeys(printed)),
        )
        last = self._row
        if last is not None and self.source.code[last.end : start] == "\n":
            last.add(row)
            return None
        self._row = row
        return row

    def is_unchanged(self) -> bool:
        """Return whether the place is active, at file scope, and not moved by a line marker."""
        return (
            self._conditionals.active
            and self._file is None
            and not self._shift
            and self.at_file_scope()
        )

    def at_file_scope(self) -> bool:
        """Return whether the text so far ends between two definitions at file scope."""
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
        if start == end or not self._conditionals.active:
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
        """Warn that the text depends on the time of translation."""
        for name in sorted(TIMES.keys() & words):
            if self.macros.get(name) == TIMES[name]:
                self._report(
                    lexical.TIME_OF_TRANSLATION.at(
                        span,
                        f"{name} is always {TIMES[name].body[0].text} here",
                        hint=f"define it: -D {name}=...",
                    )
                )

    def _words(self, start: int, end: int) -> set[str]:
        """Record the identifiers of an active piece: its result depends on macros among them."""
        distinct = set(self.source.code[start:end].split())
        words = set(_WORD.findall(" ".join(distinct)))
        self.words |= words
        return words

    def _copy(self, start: int, end: int) -> None:
        self.builder.copy(self.source, start, end, self._file, self._shift)

    def _end_of_call(self, macro: Macro, start: int, name_end: int, end: int) -> int:
        """Return the end of the call that starts at `start`, whose name ends before `name_end`.

        Arguments for its expansion belong to the call, too (ISO C, 16.3.4).
        """
        code = self.source.code
        until = name_end if macro.parameters is None else call_end(code, name_end, end)
        while (further := call_end(code, until, end)) > until:
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
            self._report(
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
        if self._conditionals.active or (name == "elif" and self._conditionals.chooses):
            self._words(begin, match.end())
        match name:
            case "if" | "ifdef" | "ifndef":
                self._conditionals.begin(name, rest, span, self._table(span))
            case "elif" | "else" | "endif":
                self._conditionals.proceed(name, rest, span, self._table(span))
            case _ if not self._conditionals.active:
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
                message = f"#{name} is ignored"
                hint = "use #define and #undef"
                self._report(lexical.PASSED_OVER.at(span, message, hint=hint))
            case "error":
                self._report(lexical.ERROR_DIRECTIVE.at(span, rest or "#error"))
            case "warning":
                self._report(lexical.WARNING_DIRECTIVE.at(span, rest or "#warning"))
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
                self._report(
                    lexical.UNKNOWN_DIRECTIVE.at(
                        span,
                        f"'#{name or rest.split()[0]}' is not a directive",
                        hint=(
                            f"did you mean #{near}?"
                            if near
                            else "a comment begins with //, a pragma with #pragma"
                        ),
                    )
                )

    def _define(self, rest: str, span: Span) -> None:
        try:
            macro = define(rest, span)
        except MalformedMacroError as error:
            hint = "write #define NAME TEXT, or #define NAME(A, B) TEXT"
            self._report(lexical.BAD_DEFINITION.at(span, error.message, hint=hint))
            if error.macro is not None and error.macro.name not in PLACES:
                self.macros.put(error.macro.name, error.macro)
            return
        if macro.name in (*PLACES, "defined"):
            message = f"{macro.name} cannot be defined"
            hint = "choose another name"
            self._report(lexical.BAD_DEFINITION.at(span, message, hint=hint))
            return
        previous = self.macros.get(macro.name)
        if previous is not None and previous != macro:
            related = (
                [Related(previous.span, "first defined here")] if previous.span else []
            )
            self._report(
                lexical.MACRO_REDEFINED.at(
                    span,
                    f"{macro.name} is defined again, differently",
                    related=related,
                    hint=f"put #undef {macro.name} before, if that is meant",
                )
            )
        macro = self._owner.macros.setdefault((macro, span), macro)
        self.macros.put(macro.name, macro)

    def _expanded(self, text: str, span: Span) -> str:
        try:
            tokens = Expander(self._table(span)).expand(tokenize(text))
        except ExpansionError as error:
            self._report(lexical.BAD_MACRO_CALL.at(span, error.message))
            return text
        return "".join(token.text for token in tokens)

    def _include(self, rest: str, span: Span, further: bool) -> None:
        match = _INCLUDE.match(rest) or _INCLUDE.match(
            self._expanded(rest, span).strip()
        )
        if match is None:
            name = rest.strip("\"<>'; \t") or "file.idl"
            self._report(
                lexical.BAD_INCLUDE.at(
                    span,
                    '#include needs "file" or <file> after it',
                    hint=f'write #include "{name}"',
                )
            )
            self.builder.unit.lacking = True
            return
        name = match[1] or match[2].strip()
        self._owner.include(self, name, span, quoted=bool(match[1]), further=further)

    def _pragma(self, rest: str, span: Span) -> None:
        if rest.split() == ["once"]:
            name = _ONCE + self.source.real
            self.words.add(name)
            self.macros.put(name, Macro(name, None, ()))
            return
        self.builder.unit.events.append(Pragma(self.builder.length, rest, span))

    def _line(self, rest: str, end: int, span: Span) -> None:
        match = _LINE.match(rest)
        if match is None:
            self._report(
                lexical.BAD_LINE_MARKER.at(
                    span,
                    "a line marker needs a line number",
                    hint='write #line 12 "file.idl"',
                )
            )
            return
        following = self.source.position(self.source.text_offset(end))[0] + 1
        self._shift = max(int(match[1]), 1) - following
        if match[2] is not None:
            self._file = re.sub(r"\\(.)", r"\1", match[2])
