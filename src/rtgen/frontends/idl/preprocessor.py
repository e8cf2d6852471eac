"""The preprocessor (ISO C 1998, clause 16): includes, conditionals, macros, pragmas, lines."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from rtgen.diagnostics import Diagnostic, Related, Span
from rtgen.frontends.idl import conditions
from rtgen.frontends.idl.macros import (
    Expander,
    ExpansionError,
    Macro,
    Token,
    define,
    tokenize,
)
from rtgen.frontends.idl.rules import lexical
from rtgen.frontends.idl.source import Library, Source
from rtgen.frontends.idl.suggestions import nearest
from rtgen.frontends.idl.unit import Boundary, Inclusion, Pragma, TextBuilder, Unit

MAX_DEPTH = 64
"""How deeply includes may nest; far more than real files do, so more is a cycle."""

MAX_INCLUDES = 10_000
"""How many inclusions one translation unit may need."""

_DIRECTIVE = re.compile(r"^[ \t\v\f\r]*#([^\n]*)", re.MULTILINE)
_COMMAND = re.compile(r"\s*([^\W\d]\w*|\d+|)\s*(.*?)\s*$", re.DOTALL)
_INCLUDE = re.compile(r'"([^"\n]+)"|<([^>\n]+)>')
_LINE = re.compile(r'(\d{1,9})(?:\s+"((?:\\.|[^"\\])*)"(?:\s+\d+)*)?')
_STRUCTURE = re.compile(
    r'"(?:\\.|[^"\\])*"|\'(?:\\.|[^\'\\\n]){0,12}\'|[{}()\[\]]|[^\s{}()\[\]"\']+'
)
_KNOWN = (
    *("define", "elif", "else", "endif", "error", "if", "ifdef", "ifndef", "include"),
    *("line", "pragma", "undef", "warning"),
)
_ONCE = "#once "
_PREDEFINED = ("__FILE__", "__LINE__")


@dataclass(slots=True)
class _Conditional:
    """An open `#if`: whether its lines count, and whether a branch has been taken."""

    span: Span
    outer: bool
    active: bool
    taken: bool
    otherwise: bool = False


@dataclass(frozen=True, slots=True)
class _Prepared:
    """A unit as it came out with a macro table: reusable where the file can see no difference."""

    before: dict[str, Macro]
    words: frozenset[str]
    changes: dict[str, Macro | None]
    unit: Unit

    def fits(self, macros: Mapping[str, Macro]) -> bool:
        return all(
            macros.get(word) == self.before.get(word)
            for word in self.words
            if word in macros or word in self.before
        )


def predefined(values: Mapping[str, str]) -> dict[str, Macro]:
    """The macro table at the start of a translation unit: `__OMNIIDL__`, `__RTGEN__`, `values`.

    Raises ExpansionError for a name that is no identifier.
    """
    table = {"__OMNIIDL__": "1", "__RTGEN__": "1", **values}
    macros = {}
    for name, value in table.items():
        if not re.fullmatch(r"[A-Za-z_]\w*", name):
            raise ExpansionError(f"'{name}' cannot be the name of a macro")
        macros[name] = define(f"{name} {value}")
    for name in _PREDEFINED:
        macros[name] = Macro(name, None, ())
    return macros


class Preprocessor:
    """Turns files into units; findings go to `report`, each place's once."""

    def __init__(self, library: Library, report: Callable[[Diagnostic], None]) -> None:
        self._library = library
        self._report = report
        self._prepared: dict[Source, list[_Prepared]] = {}
        self._stack: list[Source] = []
        self._included = 0
        self._exhausted = False

    def translation_unit(self, source: Source, macros: Mapping[str, Macro]) -> Unit:
        """The unit of a file that was given, with everything it includes."""
        self._included = 0
        self._exhausted = False
        return self._prepare(source, dict(macros)).unit

    def _prepare(self, source: Source, macros: dict[str, Macro]) -> _Prepared:
        known = self._prepared.setdefault(source, [])
        for prepared in known:
            if prepared.fits(macros):
                for name, macro in prepared.changes.items():
                    if macro is None:
                        macros.pop(name, None)
                    else:
                        macros[name] = macro
                return prepared
        before = dict(macros)
        for problem in source.problems:
            self._report(problem)
        file = _File(self, source, macros, TextBuilder(source))
        self._stack.append(source)
        file.run()
        self._stack.pop()
        changes = {
            name: macros.get(name)
            for name in before.keys() | macros.keys()
            if macros.get(name) != before.get(name)
        }
        prepared = _Prepared(before, file.words, changes, file.builder.finish())
        if not self._exhausted:
            known.append(prepared)
        return prepared

    def include(self, file: _File, quoted: str | None, name: str, span: Span) -> None:
        """Take in the file that an `#include` in `file` names."""
        source = self._find(file.source, quoted is not None, name, span)
        if source is None:
            file.builder.unit.lacking = True
            return
        if _ONCE + str(source.path.resolve()) in file.macros:
            return
        self._included += 1
        if len(self._stack) >= MAX_DEPTH or self._included > MAX_INCLUDES:
            if not self._exhausted:
                cycle = (
                    self._stack[self._stack.index(source) :]
                    if source in self._stack
                    else []
                )
                chain = (
                    " -> ".join(s.name for s in (*cycle[:6], source)) if cycle else ""
                )
                self._report(
                    lexical.INCLUDE_CYCLE.at(
                        span,
                        (
                            f"the includes have no end: {chain}"
                            if chain
                            else "too many includes"
                        ),
                        hint="give each file an include guard, or #pragma once",
                    )
                )
            self._exhausted = True
        if self._exhausted:
            file.builder.unit.lacking = True
            return
        if file.at_file_scope():
            prepared = self._prepare(source, file.macros)
            file.words |= prepared.words
            unit = prepared.unit
            file.builder.unit.events.append(Inclusion(file.builder.length, unit, span))
            return
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

    def _find(
        self, source: Source, quoted: bool, name: str, span: Span
    ) -> Source | None:
        folders: list[tuple[Path, Path | None]] = []
        if quoted:
            folders.append((source.path.parent, None))
        folders += [(folder, folder) for folder in self._library.include]
        for folder, include in folders:
            try:
                found = self._library.open(folder / name, include)
            except (OSError, ValueError) as error:
                reason = getattr(error, "strerror", None) or error
                self._report(
                    lexical.UNREADABLE.at(span, f"{name} cannot be read: {reason}")
                )
                return None
            if found is not None:
                return found
        searched = [folder for folder, _ in folders]
        near = nearest(Path(name).name, _files_in(searched))
        hint = "searched: " + (", ".join(map(_shown, searched)) or "no folder (use -I)")
        if near:
            same = near.lower() == Path(name).name.lower()
            hint = f"did you mean {near}?{' (only the case differs)' if same else ''} {hint}"
        self._report(
            lexical.INCLUDE_NOT_FOUND.at(
                span, f"the file {name} was not found", hint=hint
            )
        )
        return None

    def report(self, diagnostic: Diagnostic) -> None:
        """Pass a finding on."""
        self._report(diagnostic)


def _shown(folder: Path) -> str:
    return folder.as_posix()


def _files_in(folders: list[Path]) -> list[str]:
    names: list[str] = []
    for folder in folders:
        if folder.is_dir():
            names += sorted(path.name for path in folder.glob("*.idl"))
    return names


class _File:
    """The run over one file."""

    def __init__(
        self,
        owner: Preprocessor,
        source: Source,
        macros: dict[str, Macro],
        builder: TextBuilder,
        nested: bool = False,
    ) -> None:
        self.source = source
        self.macros = macros
        self.builder = builder
        self.words = source.words
        self._owner = owner
        self._nested = nested
        self._open: list[_Conditional] = []
        self._file: str | None = None
        self._shift = 0
        self._depth = 0
        self._complete = True
        self._seen = 0

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
        names = self.macros.keys() & self.source.words
        if names and self._calls(names, start, end):
            self._expand(start, end)
        else:
            self._copy(start, end)

    def _calls(self, names: set[str], start: int, end: int) -> bool:
        code = self.source.code
        return any(code.find(name, start, end) >= 0 for name in names)

    def _copy(self, start: int, end: int) -> None:
        self.builder.copy(self.source, start, end, self._file, self._shift)

    def _expand(self, start: int, end: int) -> None:
        """Copy text up to each macro call, and put what the call expands to in its place."""
        tokens = tokenize(self.source.code[start:end])
        copied = offset = start
        index = 0
        while index < len(tokens):
            token = tokens[index]
            macro = self.macros.get(token.text) if token.kind == "name" else None
            if macro is None:
                offset += len(token.text)
                index += 1
                continue
            until = index + 1 if macro.parameters is None else _call_end(tokens, index)
            self._copy(copied, offset)
            copied = offset + sum(len(t.text) for t in tokens[index:until])
            self._replace(tokens[index:until], offset, copied)
            offset = copied
            index = until
        self._copy(copied, end)

    def _replace(self, call: list[Token], start: int, end: int) -> None:
        """Append what a macro call at [start, end) expands to."""
        span = self._span(start, end)
        builder = self.builder
        try:
            tokens = Expander(self._table(span)).expand(call)
        except ExpansionError as error:
            macro = self.macros.get(call[0].text)
            defined = macro.span if macro else None
            related = [Related(defined, "defined here")] if defined else []
            self._owner.report(
                lexical.BAD_MACRO_CALL.at(span, error.message, related=related)
            )
            tokens = call[:1]
            builder.unit.lacking = True
            builder.unit.flawed.add(builder.length)
        expanded = f" {''.join(token.text for token in tokens)} "
        builder.expand(expanded, self.source, start, end, self._file, self._shift)

    def _table(self, span: Span) -> Mapping[str, Macro]:
        file = self._file or self.source.name
        table = dict(self.macros)
        table["__FILE__"] = Macro("__FILE__", None, (Token("text", f'"{file}"'),))
        table["__LINE__"] = Macro("__LINE__", None, (Token("number", str(span.line)),))
        return table

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
        hash_at = begin - 1
        span = self._span(hash_at, max(begin + command.end(2), begin))
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
            case "undef":
                self.macros.pop(rest.split()[0] if rest else "", None)
            case "include":
                self._include(rest, span)
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
            elif re.match(r"[^\W\d]\w*", rest):
                value = (rest.split()[0] in self.macros) == (name == "ifdef")
            else:
                self._owner.report(
                    lexical.BAD_CONDITION.at(
                        span,
                        f"#{name} needs the name of a macro",
                        hint=f"write #{name} NAME",
                    )
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
        except ExpansionError as error:
            hint = "write #define NAME TEXT, or #define NAME(A, B) TEXT"
            self._owner.report(
                lexical.BAD_DEFINITION.at(span, error.message, hint=hint)
            )
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
        self.macros[macro.name] = macro

    def _expanded(self, text: str, span: Span) -> str:
        try:
            tokens = Expander(self._table(span)).expand(tokenize(text))
        except ExpansionError as error:
            self._owner.report(lexical.BAD_MACRO_CALL.at(span, error.message))
            return text
        return "".join(token.text for token in tokens)

    def _include(self, rest: str, span: Span) -> None:
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
        self._owner.include(self, found[1], found[1] or found[2].strip(), span)

    def _pragma(self, rest: str, span: Span) -> None:
        if rest.split() == ["once"]:
            name = _ONCE + str(self.source.path.resolve())
            self.words |= {name}
            self.macros[name] = Macro(name, None, ())
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
        self._shift = int(found[1]) - following
        if found[2] is not None:
            self._file = re.sub(r"\\(.)", r"\1", found[2])


def _call_end(tokens: list[Token], index: int) -> int:
    """Behind the closing parenthesis of a call; behind the name if there is no call."""
    until = index + 1
    while until < len(tokens) and tokens[until].kind == "space":
        until += 1
    if until == len(tokens) or tokens[until].text != "(":
        return index + 1
    depth = 0
    while until < len(tokens):
        depth += {"(": 1, ")": -1}.get(tokens[until].text, 0)
        until += 1
        if depth == 0:
            break
    return until
