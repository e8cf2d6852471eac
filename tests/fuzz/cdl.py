"""Fuzzing of CDL: any file gives findings of known rules, in bounded time."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from random import Random

from fuzzing import ViolationError, log_uniform

from rtgen.compiler.diagnostics import Diagnostic, Span, has_errors, in_order
from rtgen.compiler.diagnostics.explain import rules
from rtgen.compiler.diagnostics.report import report
from rtgen.compiler.frontends.cdl import load
from rtgen.compiler.frontends.cdl.syntax.keywords import WORDS
from rtgen.compiler.inspection.models import inspect, tree

ROOT = Path(__file__).parents[2]

_MAX_CHARACTERS = 200_000
_TOKEN = re.compile(
    r"//[^\n]*|/\*.*?\*/|\"(?:\\.|[^\"\\\n])*\"|'(?:\\.|[^'\\\n])*'|\w+|\s+|::|<=|=>|.",
    re.DOTALL,
)
_ODD = """
    0x 08 1U 1e5 1. '' 'ab' "open <a> < > << >> -> ... # #include // /* */ \\ ~ @ ; ;; } { ) ( ] [
    ER ID size_t int8_t float union long const volatile signed TYPE tMain sEvery Pose Speed ::a a::b
    generate through RTCPlugin RTCPlug-in "a=1" id in out string nullable true C_EXP Descriptor
    1<<99999 1/0 99999999999999999999999999 -1 \u3000 \uff1b \u6f22 \x01 \ufeff
""".split()
_ENCODINGS = ("utf-8", "utf-8", "utf-8", "utf-8-sig", "euc_jp", "cp932", "utf-16")


class CdlTarget:
    """This project's own CDL, broken and mixed."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        for file in (ROOT / "tests/compiler/cdl").iterdir():
            if file.suffix in (".cdl", ".h") and file.name != "constructs.cdl":
                (folder / file.name).write_bytes(file.read_bytes())

    def make(self, number: int) -> bytes:
        """Return a file or statements with tokens changed, doubled, exchanged or left out."""
        chance = Random(number)
        tokens: list[str] = []
        kind = chance.random()
        if kind < 0.3:
            tokens += chance.choice(_texts())
        elif kind < 0.6:
            for _ in range(log_uniform(1, 8, chance.random())):
                tokens += chance.choice(_statements())
        else:
            tokens += _right()[: chance.randrange(len(_right()))]
            while tokens and tokens[-1] != ";":
                tokens.pop()
            tokens += "};" * (tokens.count("{") - tokens.count("}"))
        for _ in range(log_uniform(1, 9, chance.random()) - 1):
            _change(chance, tokens)
        text = "".join(tokens)[:_MAX_CHARACTERS]
        data = text.encode(chance.choice(_ENCODINGS), "replace")
        if chance.random() < 0.1 and data:
            at = chance.randrange(len(data))
            data = data[:at] + chance.randbytes(2) + data[at + chance.randrange(3) :]
        return data

    def check(self, number: int, data: bytes) -> Iterator[str]:
        """Read the file, and check all results."""
        path = self._folder / "input.cdl"
        path.write_bytes(data)
        result = load(
            [path],
            root=self._folder,
            include=[self._folder],
            prelude=number % 5 > 0,
            encoding=("auto", "auto", "sjis", "none")[number % 4],
        )
        lines = {name: text.split("\n") for name, text in result.sources.items()}
        _hold(result.diagnostics, lines)
        report(result.diagnostics, result.sources)
        json.dumps(inspect(result.model, result.diagnostics), allow_nan=False)
        tree(result.model)
        yield "errors" if has_errors(result.diagnostics) else "read"
        yield from {d.code for d in result.diagnostics}


def _hold(found: tuple[Diagnostic, ...], lines: dict[str, list[str]]) -> None:
    """Check the guarantees for findings."""
    if list(found) != in_order(found):
        raise ViolationError("the findings are not in order")
    for d in found:
        rule = rules().get(d.code)
        if rule is None or rule.severity is not d.severity or not d.message:
            raise ViolationError(f"{d.code} is no such rule")
        if d.span is None:
            raise ViolationError(f"{d.code} is nowhere")
        for span in (d.span, *(related.span for related in d.related)):
            _exists(d, span, lines)


def _exists(d: Diagnostic, span: Span, lines: dict[str, list[str]]) -> None:
    text = lines.get(span.file)
    if (span.line, span.column) > (span.end_line, span.end_column):
        raise ViolationError(f"{d.code} ends before it starts: {span}")
    if text is None:
        return  # a C header
    if not 1 <= span.line <= span.end_line <= len(text):
        raise ViolationError(f"{d.code} in line {span.line} of {len(text)}")
    if not 1 <= span.column <= len(text[span.line - 1]) + 1:
        raise ViolationError(f"{d.code} in column {span.column} of {span}")


@cache
def _right() -> list[str]:
    """Return a file without errors."""
    file = ROOT / "tests/compiler/cdl/constructs.cdl"
    return _TOKEN.findall(file.read_text(encoding="utf-8"))


@cache
def _texts() -> list[list[str]]:
    folders = (ROOT / "specs", ROOT / "tests/unit", ROOT / "tests/golden/cdl_errors")
    files = sorted(p for folder in folders for p in folder.rglob("*.cdl"))
    texts = (file.read_bytes().decode("utf-8", "replace") for file in files)
    return [tokens for text in texts if (tokens := _TOKEN.findall(text))]


@cache
def _statements() -> list[list[str]]:
    """Return the statements at the top level of these files."""
    found: dict[str, list[str]] = {}
    for tokens in _texts():
        start = depth = 0
        for index, token in enumerate(tokens):
            depth += {"{": 1, "}": -1}.get(token, 0)
            if token == ";" and depth == 0:
                statement = tokens[start : index + 1]
                found["".join(statement)] = statement
                start = index + 1
    return list(found.values())


def _change(chance: Random, tokens: list[str]) -> None:
    at = chance.randrange(len(tokens) + 1)
    match chance.randrange(8):
        case 0:
            tokens.insert(at, f" {chance.choice(_ODD)} ")
        case 1:
            tokens.insert(at, f" {chance.choice(sorted(WORDS.values()))} ")
        case 2:
            del tokens[at : at + log_uniform(1, 6, chance.random())]
        case 3:
            run = tokens[at : at + log_uniform(1, 40, chance.random())]
            tokens[at:at] = run
        case 4 if tokens:
            tokens[at - 1] = chance.choice(tokens)
        case 5 if tokens:
            other = chance.randrange(len(tokens))
            tokens[at - 1], tokens[other] = tokens[other], tokens[at - 1]
        case 6:
            opening, closing = chance.choice(("()", "{}", "[]", "- ", "* "))
            times = log_uniform(1, 600, chance.random())
            end = at + chance.randrange(4)
            tokens[end:end] = [closing * times]
            tokens[at:at] = [opening * times]
        case 7:
            tokens[at:at] = chance.choice(_statements())
