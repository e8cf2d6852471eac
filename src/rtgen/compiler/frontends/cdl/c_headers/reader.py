"""C headers: the typedefs, structs and enums that `import_C` takes from them.

pcpp preprocesses the header. Its output is split into declarations at file scope, and only those of
types are parsed, by pycparser, so that function bodies, variables and vendors' extensions are
skipped. Macros and functions are not kept.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from io import StringIO
from pathlib import Path
from typing import Any, Final

import msgspec
from pcpp.parser import default_lexer
from pcpp.preprocessor import Action, OutputDirective, Preprocessor

from rtgen.compiler.diagnostics import Diagnostic, Span
from rtgen.compiler.frontends.cdl.c_headers.file import HeaderFile
from rtgen.compiler.frontends.cdl.c_headers.types import Declarations, NotCError
from rtgen.compiler.frontends.cdl.rules import headers as rules
from rtgen.compiler.frontends.cdl.syntax.unit import Header
from rtgen.compiler.frontends.kit.conditions import ConditionError, Operand, value_of
from rtgen.compiler.frontends.kit.library import MAX_BYTES, Library
from rtgen.compiler.kit.words import words
from rtgen.compiler.model.tecs import TecsDeclaration

MAX_TOKENS = 500_000
"""The largest number of tokens that macro expansion processes for one header."""

MAX_TEXT = 8 * 1024 * 1024
"""The largest number of characters of preprocessed text."""

MAX_FILES = 1000
"""The largest number of inclusions in one header, repeated ones counted."""

MAX_DEPTH = 60
"""The largest depth of nested inclusions."""

MAX_MISTAKES = 20
"""After this number of declarations that cannot be parsed, the rest of the header is skipped."""

_STANDARD_FOLDER = "/\0standard"


def _opaque(*names: str) -> str:
    return "".join(f"typedef union {{ int a; }} {name};" for name in names)


_STANDARD: Mapping[str, str] = {
    "pthread.h": "typedef unsigned long pthread_t;"
    + _opaque(
        *("pthread_attr_t", "pthread_mutex_t", "pthread_mutexattr_t"),
        *("pthread_cond_t", "pthread_condattr_t", "pthread_once_t", "pthread_key_t"),
    ),
    "semaphore.h": _opaque("sem_t"),
    "stdio.h": "typedef unsigned long size_t;" + _opaque("FILE"),
    "stdarg.h": _opaque("va_list"),
    "time.h": "typedef unsigned long size_t; typedef long time_t; typedef long clock_t;"
    "struct timespec { time_t tv_sec; long tv_nsec; };",
    "sys/time.h": "typedef long time_t; struct timeval { time_t tv_sec; long tv_usec; };",
    "sys/socket.h": "typedef unsigned int socklen_t; typedef unsigned short sa_family_t;",
    "signal.h": "typedef int sig_atomic_t;" + _opaque("sigset_t"),
    "setjmp.h": _opaque("jmp_buf"),
    "unistd.h": "typedef unsigned long size_t; typedef int pid_t;",
    **dict.fromkeys(
        ("stdint.h", "inttypes.h", "sys/types.h"),
        "typedef long intptr_t; typedef unsigned long uintptr_t;"
        "typedef signed char int_least8_t; typedef unsigned char uint_least8_t;"
        "typedef long size_t; typedef long ssize_t;"
        "typedef long long intmax_t; typedef unsigned long long uintmax_t;",
    ),
    "stddef.h": "typedef unsigned long size_t; typedef long ptrdiff_t;\n#define NULL ((void *)0)",
    "stdbool.h": "#define bool _Bool\n#define true 1\n#define false 0",
    "limits.h": "#define CHAR_BIT 8\n#define INT_MAX 2147483647\n#define INT_MIN (-INT_MAX-1)\n"
    "#define UINT_MAX 4294967295U",
    **dict.fromkeys(("stdlib.h", "string.h"), "typedef unsigned long size_t;"),
    **dict.fromkeys(
        (
            *("assert.h", "ctype.h", "errno.h", "float.h", "math.h"),
            *("arpa/inet.h", "netinet/in.h", "netdb.h", "fcntl.h", "sys/select.h"),
        ),
        "",
    ),
}
"""Types of standard headers, known without the files."""

_COMPILER: Mapping[str, str] = {
    f"__{name}__": value
    for name, value in (
        *(("GNUC", "12"), ("GNUC_MINOR", "2"), ("GNUC_PATCHLEVEL", "0")),
        *(("STDC", "1"), ("STDC_HOSTED", "1"), ("STDC_VERSION", "201710L")),
        *(("x86_64", "1"), ("LP64", "1"), ("linux", "1"), ("unix", "1")),
        *(("CHAR_BIT", "8"), ("SIZEOF_SHORT", "2"), ("SIZEOF_INT", "4")),
        *(("SIZEOF_LONG", "8"), ("SIZEOF_LONG_LONG", "8"), ("SIZEOF_POINTER", "8")),
        *(("SCHAR_MAX", "0x7f"), ("SHRT_MAX", "0x7fff"), ("INT_MAX", "0x7fffffff")),
        *(("LONG_MAX", "0x7fffffffffffffffL"), ("SIZE_TYPE", "long unsigned int")),
        *(("INT8_TYPE", "signed char"), ("UINT8_TYPE", "unsigned char")),
        *(("INT16_TYPE", "short int"), ("UINT16_TYPE", "short unsigned int")),
        *(("INT32_TYPE", "int"), ("UINT32_TYPE", "unsigned int")),
        *(("INT64_TYPE", "long int"), ("UINT64_TYPE", "long unsigned int")),
        *(("INTPTR_TYPE", "long int"), ("UINTPTR_TYPE", "long unsigned int")),
    )
}
"""Predefined macros that headers expect from the compiler: tecsgen preprocesses with gcc."""

_TOKEN = re.compile(
    r'\#line[ ](?P<line>\d+)(?:[ ]"(?P<file>[^"\n]*)")?[^\n]*'
    r"|\#[^\n]*"
    r'|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])*\''
    r"|(?P<vendor>\b(?:__attribute__|__attribute|__declspec|__asm__|__asm|asm|_Alignas)\b"
    r"|\b_Static_assert\b)"
    r"|(?P<word>[A-Za-z_]\w*)|(?P<mark>[{}();])|\n",
    re.DOTALL,
)
_DROPPED = words("""
    __extension__ __inline __inline__ inline Inline _Noreturn __restrict __restrict__ restrict
    __const __volatile __volatile__ __signed__
    """)


class LimitError(Exception):
    """A header that exceeds a limit."""


class Headers(msgspec.Struct, eq=False):
    """Reads the C headers of a main file; the library finds their includes."""

    _library: Library[HeaderFile]
    _define: Mapping[str, str]
    _report: Callable[[Diagnostic], None]
    _table: Declarations = msgspec.field(default_factory=Declarations)
    lacking: bool = False
    """Whether an included file is missing."""

    def read(self, file: HeaderFile, definitions: list[str], place: Span) -> Header:
        """Return the declarations of a header; `place` is that of its import, for diagnostics."""
        if file.too_large:
            message = f"{file.name} is larger than {MAX_BYTES:,} bytes"
            self._report(rules.HEADER_LIMIT.at(place, message))
            return Header(())
        run = _Preprocessor(self._library, file, self._report)
        for name, value in self._define.items():
            run.define(f"{name} {value}")
        for definition in definitions:
            name, equals, value = definition.partition("=")
            run.define(f"{name.strip()} {value if equals else '1'}")
        try:
            text = run.text()
            pieces = list(_pieces(text, file.name))
        except (LimitError, RecursionError) as error:
            message = (
                f"{file.name}: {error}" if isinstance(error, LimitError) else file.name
            )
            self._report(rules.HEADER_LIMIT.at(place, message))
            return Header(())
        for message in dict.fromkeys(run.problems):
            self._report(rules.UNREADABLE_HEADER.at(place, message))
        if run.missing:
            self.lacking = True
            names = ", ".join(dict.fromkeys(run.missing))
            message = f"{file.name} includes files that are not found: {names}"
            hint = "name their folder by -I"
            self._report(rules.MISSING_INCLUDE.at(place, message, hint=hint))
        return Header(tuple(self._declarations(pieces, place, run.spans)))

    def _declarations(
        self, pieces: list[Piece], place: Span, names: Mapping[str, str]
    ) -> Iterator[TecsDeclaration]:
        mistakes = 0
        declarations = self._table
        declarations.enter(names)
        for piece in pieces:
            try:
                yield from declarations.read(piece.text, piece.file, piece.line)
            except NotCError as error:
                mistakes += 1
                if mistakes == MAX_MISTAKES:
                    return
                file = names.get(piece.file, piece.file)
                message = f"{file}:{error.line}: {error.message}"
                hint = "exclude it by #ifndef TECSGEN"
                self._report(rules.UNREADABLE_HEADER.at(place, message, hint=hint))


_INCOMPLETE: Final[Mapping[str, list[list[str]]]] = {
    **{
        name: [[]] for name in ("define", "undef", "ifdef", "ifndef", "elif", "include")
    },
    "if": [[], ["!"], ["!", "defined"], ["!", "defined", "("]],
}
"""Directives with a truncated operand: the spellings of the rest."""


@dataclass(frozen=True, slots=True)
class Piece:
    """A declaration of types at file scope, without vendors' extensions."""

    text: str
    file: str
    line: int


@cache
def _lexer() -> Any:
    """Return pcpp's lexer, of which each preprocessor has a copy."""
    return default_lexer()


@cache
def _prepared() -> Preprocessor:
    """Return a preprocessor with the macros that are defined for each header."""
    run = Preprocessor(_lexer().clone())
    for name, value in {**_COMPILER, "TECSGEN": "1"}.items():
        run.define(f"{name} {value}")
    for name in ("__DATE__", "__TIME__"):
        del run.macros[name]  # they differ between runs
    return run


_PARAMETERS = "a parameter of the macro has no name"


class _Preprocessor(Preprocessor):  # type: ignore[misc]  # pcpp has no types
    def __init__(
        self,
        library: Library[HeaderFile],
        file: HeaderFile,
        report: Callable[[Diagnostic], None],
    ) -> None:
        # A copy, since pcpp takes longer to begin than to read most headers.
        for name, value in vars(_prepared()).items():
            is_own = isinstance(value, (dict, list))
            setattr(self, name, value.copy() if is_own else value)
        self.lexer = _lexer().clone()
        self.problems: list[str] = []
        self.missing: list[str] = []
        self.spans: dict[str, str] = {}
        self._library = library
        self._file = file
        self._report = report
        self._tokens = 0
        self._opened = 0
        self._length = 0
        self.evaluator = self._value
        for folder in library.include:
            self.add_path(str(folder))

    def text(self) -> str:
        """Return the text of the file, preprocessed. Raises LimitError."""
        path = str(self._file.path.absolute())
        self.spans[path] = self._file.name
        self.temp_path.insert(0, str(Path(path).parent))
        self.path.append(_STANDARD_FOLDER)
        self.rewrite_paths: list[tuple[str, str]] = []
        self.parse(self._text_of(self._file), path)
        out = _Bounded()
        self.write(out)
        return out.getvalue()

    def define(self, tokens: Any) -> None:
        try:
            super().define(tokens)
        except IndexError:  # pcpp accesses the first token of an empty parameter
            if isinstance(tokens, str):
                self.problems.append(f"-D {tokens}: {_PARAMETERS}")
            else:
                self.on_error(tokens[0].source, tokens[0].lineno, _PARAMETERS)

    def _value(self, tokens: Any, functions: Any, identifiers: Any) -> _Number:
        """Return the value of a condition; pcpp's own evaluator computes numbers of any size."""
        try:
            return _Number(value_of(_operands(tokens, identifiers)))
        except ConditionError as error:
            message = f"a condition cannot be evaluated: {error}"
            self.on_error(tokens[0].source, tokens[0].lineno, message)
            return _Number(0)

    def expand_macros(self, tokens: Any, expanding_from: Any = ()) -> Any:
        self._tokens += len(tokens)
        if self._tokens > MAX_TOKENS:
            raise LimitError(f"its macros come to more than {MAX_TOKENS:,} tokens")
        return super().expand_macros(tokens, list(expanding_from))

    def on_file_open(self, is_system_include: bool, includepath: str) -> StringIO:
        if includepath.startswith(_STANDARD_FOLDER):
            name = includepath[len(_STANDARD_FOLDER) + 1 :]
            if name not in _STANDARD:
                raise OSError(includepath)
            return StringIO(_STANDARD[name] + "\n")
        header = self._library.open(includepath)
        if header is None:
            raise OSError(includepath)
        self._opened += 1
        if self._opened > MAX_FILES or len(self.temp_path) > MAX_DEPTH:
            raise LimitError(f"it includes too many files: {header.name} among them")
        self.spans[includepath] = header.name
        return StringIO(self._text_of(header))

    def _text_of(self, file: HeaderFile) -> str:
        for problem in file.problems:
            self._report(problem)
        return file.text

    def on_directive_handle(
        self, directive: Any, toks: Any, ifpassthru: bool, precedingtoks: Any
    ) -> bool | None:
        # pcpp accesses the tokens of an include guard without checking that they exist.
        if [t.value for t in toks] in _INCOMPLETE.get(directive.value, ()):
            message = f"#{directive.value} is incomplete"
            self.on_error(directive.source, directive.lineno, message)
            raise OutputDirective(Action.IgnoreAndRemove)
        handled: bool | None = super().on_directive_handle(
            directive, toks, ifpassthru, precedingtoks
        )
        return handled

    def on_include_not_found(
        self, is_malformed: bool, is_system_include: bool, curdir: str, includepath: str
    ) -> str:
        self.missing.append(includepath)
        raise OutputDirective(Action.IgnoreAndRemove)

    def on_error(self, file: str, line: int, msg: str) -> None:
        self.problems.append(f"{self.spans.get(file, file)}:{line}: {msg}")

    def on_directive_unknown(
        self, directive: Any, toks: Any, ifpassthru: Any, precedingtoks: Any
    ) -> bool:
        if directive.value == "error":
            text = "".join(token.value for token in toks)
            self.on_error(directive.source, directive.lineno, f"#error {text}")
        return True

    def on_comment(self, tok: Any) -> bool:
        return False


class _Number(int):
    """A result as pcpp expects it from its evaluator."""

    def value(self) -> int:
        """Return the number."""
        return self


def _operands(tokens: Any, identifiers: Any) -> Iterator[Operand]:
    """Yield the tokens of a condition; `identifiers` are the values of names that are no macros."""
    tokens = [token for token in tokens if token.type not in _BLANKS]
    place = 0
    while place < len(tokens):
        token = tokens[place]
        place += 1
        name = token.type == "CPP_ID"
        if name and place < len(tokens) and tokens[place].value == "(":
            # `__has_include(...)` and the like: a function that is not known
            place = _end_of_call(tokens, place)
            yield Operand("number", "0")
        elif name:
            yield Operand("number", str(identifiers[token.value]))
        else:
            yield Operand(_OPERANDS.get(token.type, ""), token.value)


def _end_of_call(tokens: Any, place: int) -> int:
    depth = 0
    while place < len(tokens):
        depth += {"(": 1, ")": -1}.get(tokens[place].value, 0)
        place += 1
        if not depth:
            break
    return place


_BLANKS = frozenset(("CPP_WS", "CPP_LINECONT", "CPP_COMMENT1", "CPP_COMMENT2"))
_OPERANDS = {"CPP_INTEGER": "number", "CPP_CHAR": "text"}


class _Bounded(StringIO):
    def write(self, text: str) -> int:
        if self.tell() > MAX_TEXT:
            raise LimitError(f"it comes to more than {MAX_TEXT:,} characters")
        return super().write(text)


class _Cutter:
    """Cuts preprocessed text into the declarations of types at file scope."""

    def __init__(self, text: str, file: str) -> None:
        self._text = text
        self._file = file
        self._line = 1
        self._parts: list[str] = []
        self._start = (file, 1)
        self._braces = 0
        self._parentheses = 0
        self._is_type = False
        self._body = False

    def pieces(self) -> Iterator[Piece]:
        """Yield the declarations, in order."""
        position = 0
        skipping: int | None = None
        for match in _TOKEN.finditer(self._text):
            token = match[0]
            between = self._text[position : match.start()]
            position = match.end()
            if skipping is None:
                self._take(between)
            if token == "\n":
                self._line += 1
                self._parts.append(token)
                continue
            if match["line"]:
                self._line = int(match["line"]) - 1
                self._file = match["file"] or self._file
                continue
            if token.startswith("#"):
                continue
            if skipping is not None:
                # skip the argument of a vendor's keyword: one pair of parentheses
                skipping += {"(": 1, ")": -1}.get(token, 0)
                if skipping == 0:
                    skipping = None
                continue
            if match["vendor"]:
                if self._text[position : position + 200].lstrip()[:1] == "(":
                    skipping = 0
                continue
            yield from self._token(token, bool(match["word"]))

    def _take(self, text: str) -> None:
        if text.strip():
            self._begin()
        self._parts.append(text)

    def _begin(self) -> None:
        if not any(part.strip() for part in self._parts):
            self._parts.clear()
            self._start = (self._file, self._line)

    def _token(self, token: str, is_word: bool) -> Iterator[Piece]:
        if is_word and token in _DROPPED:
            self._parts.append("signed" if token == "__signed__" else " ")
            return
        self._begin()
        outside = not self._braces and not self._parentheses
        if outside and token in ("typedef", "struct", "union", "enum"):
            self._is_type = True
        if token == "{":
            before = "".join(self._parts).rstrip()
            self._body |= outside and before.endswith(")")
            self._braces += 1
        elif token == "}":
            self._braces -= 1
        elif token in "()":
            self._parentheses += 1 if token == "(" else -1
        self._parts.append(token)
        closed = self._braces <= 0 and self._parentheses <= 0
        if closed and (token == ";" or (token == "}" and self._body)):
            text = "".join(self._parts)
            if self._is_type and not self._body:
                yield Piece(text, *self._start)
            self._parts.clear()
            self._braces = self._parentheses = 0
            self._is_type = self._body = False


def _pieces(text: str, file: str) -> Iterator[Piece]:
    return _Cutter(text, file).pieces()
