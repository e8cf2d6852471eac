"""The mutation fuzzer: the definition files of this repository, cut, broken and mixed."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from random import Random

import idl_words as words
from fuzzing import log_uniform

ROOT = Path(__file__).parents[2]
FOLDERS = ("specs", "tests", "benchmarks")

_TOKEN = re.compile(
    r"//[^\n]*|/\*.*?\*/|\n[ \t]*#[^\n]*|L?\"(?:\\.|[^\"\\\n])*\"|L?'(?:\\.|[^'\\\n])*'"
    r"|[^\W\d]\w*|\.?\d[\w.]*|\s+|::|<<|>>|.",
    re.DOTALL,
)
_MAX_CHARACTERS = 200_000
_TYPES = """
    short long octet boolean char wchar string wstring float double any Object void int8 uint64
    """.split()
_OPERATORS = "+ - * / % << >> | & ^ ~ = : :: , ;".split()


def mutant(number: int) -> bytes:
    """Return the input of a case."""
    chance = Random(number)
    tokens = _start(chance)
    for _ in range(log_uniform(1, 6, chance.random())):
        chance.choice(_MUTATIONS)(chance, tokens)
        if len(tokens) > _MAX_CHARACTERS:
            break
    text = "".join(tokens)[:_MAX_CHARACTERS]
    if chance.random() < 0.1:
        text = "\n".join(_lines(chance, text.split("\n")))
    data = text.encode(*chance.choice(_ENCODINGS))
    return _octets(chance, data) if chance.random() < 0.15 else data


@cache
def texts() -> list[list[str]]:
    """Return the tokens of each definition file of this repository, in the order of paths."""
    paths = (p for folder in FOLDERS for p in (ROOT / folder).rglob("*.idl"))
    files = sorted(path for path in paths if path.is_file())
    found = (path.read_bytes().decode("utf-8", "replace") for path in files)
    return [tokens for text in found if (tokens := _TOKEN.findall(text))]


@cache
def pieces() -> list[list[str]]:
    """Return the declarations in these files, with braces closed, and short files in full."""
    found: dict[str, list[str]] = {}
    for tokens in texts():
        if len(tokens) < 200:
            found["".join(tokens)] = tokens
        starts = [0]
        for index, token in enumerate(tokens):
            if token == "{":
                starts.append(index + 1)
            elif token == "}" and len(starts) > 1:
                starts.pop()
            elif token == ";":
                piece = tokens[starts[-1] : index + 1]
                if 8 <= len(piece) <= 600:
                    found["".join(piece)] = piece
                starts[-1] = index + 1
    return list(found.values())


def _start(chance: Random) -> list[str]:
    """Return the beginning of a file, its braces closed, or some pieces, perhaps in a module."""
    if chance.random() < 0.5:
        tokens = chance.choice(texts())
        tokens = tokens[: log_uniform(30, 2500, chance.random())]
        while tokens and tokens[-1] not in (";", "}"):
            tokens = tokens[:-1]
        return [*tokens, *"\n};" * (tokens.count("{") - tokens.count("}")), "\n"]
    tokens = []
    for _ in range(log_uniform(1, 8, chance.random())):
        tokens += chance.choice(pieces())
        tokens.append("\n")
    if chance.random() < 0.3:
        tokens = ["module", " ", "M", " ", "{", "\n", *tokens, "}", ";", "\n"]
    return tokens


def _word(chance: Random) -> str:
    kinds = (
        *(words.KEYWORDS, words.CONTEXTUAL, words.NEAR, words.MARKS, words.MARKS),
        *(words.NAMES, words.NUMBERS, words.TEXTS, words.ANNOTATIONS),
    )
    return f" {chance.choice(chance.choice(kinds))} "


def _place(chance: Random, tokens: list[str]) -> int:
    """Return the index of a token other than white space, if one is found soon."""
    place = 0
    for _ in range(4):
        place = chance.randrange(len(tokens))
        if not tokens[place].isspace():
            break
    return place


def _delete(chance: Random, tokens: list[str]) -> None:
    place = _place(chance, tokens)
    del tokens[place : place + log_uniform(1, 6, chance.random())]
    if not tokens:
        tokens.append(" ")


def _repeat(chance: Random, tokens: list[str]) -> None:
    place = _place(chance, tokens)
    run = tokens[place : place + log_uniform(1, 40, chance.random())]
    tokens[place:place] = run


def _swap(chance: Random, tokens: list[str]) -> None:
    one, other = _place(chance, tokens), _place(chance, tokens)
    tokens[one], tokens[other] = tokens[other], tokens[one]


def _replace(chance: Random, tokens: list[str]) -> None:
    tokens[_place(chance, tokens)] = _word(chance)


def _copy(chance: Random, tokens: list[str]) -> None:
    """Replace a token by another one of the text: existing names in wrong places."""
    tokens[_place(chance, tokens)] = tokens[_place(chance, tokens)]


def _exchange(chance: Random, tokens: list[str]) -> None:
    """Replace a token by another one of its kind: the syntax stays valid."""
    place = _place(chance, tokens)
    token = tokens[place]
    if token.isdigit():
        tokens[place] = chance.choice(words.NUMBERS)
    elif token in _TYPES:
        tokens[place] = chance.choice(_TYPES)
    elif token.isidentifier() and token not in words.RESERVED:
        others = [t for t in tokens if t.isidentifier() and t not in words.RESERVED]
        tokens[place] = chance.choice((*others, *words.CONTEXTUAL))
    elif token[:1] in "\"'" or token[:2] in ('L"', "L'"):
        tokens[place] = chance.choice(words.TEXTS)
    elif token in _OPERATORS:
        tokens[place] = chance.choice(_OPERATORS)


def _member(chance: Random, tokens: list[str]) -> None:
    """Insert a declaration of another text after a `;` or `{`."""
    places = [i + 1 for i, token in enumerate(tokens) if token in (";", "{")]
    if places:
        place = chance.choice(places)
        tokens[place:place] = ["\n", *chance.choice(pieces())]


def _annotation(chance: Random, tokens: list[str]) -> None:
    """Insert an annotation before a declaration, or anywhere."""
    places = [i + 1 for i, token in enumerate(tokens) if token in (";", "{", ",", "(")]
    tokens.insert(chance.choice(places or [0]), f" {chance.choice(words.ANNOTATIONS)} ")


def _insert(chance: Random, tokens: list[str]) -> None:
    tokens.insert(_place(chance, tokens), _word(chance))


def _respell(chance: Random, tokens: list[str]) -> None:
    """Misspell a word: case, a letter lost, doubled or exchanged, an underscore."""
    place = _place(chance, tokens)
    word = tokens[place]
    if not word.strip():
        return
    at = chance.randrange(len(word))
    tokens[place] = chance.choice(
        (
            word.swapcase(),
            word.capitalize(),
            word[:at] + word[at + 1 :],
            word[:at] + word[at] + word[at:],
            word[:at] + word[at : at + 2][::-1] + word[at + 2 :],
            "_" + word,
        )
    )


def _splice(chance: Random, tokens: list[str]) -> None:
    """Join the head of one text and the tail of another."""
    other = chance.choice(pieces())
    cut, start = _place(chance, tokens), chance.randrange(len(other))
    tokens[cut:] = other[start:]


def _move(chance: Random, tokens: list[str]) -> None:
    place = _place(chance, tokens)
    run = tokens[place : place + log_uniform(1, 30, chance.random())]
    del tokens[place : place + len(run)]
    at = chance.randrange(len(tokens) + 1)
    tokens[at:at] = run


def _directive(chance: Random, tokens: list[str]) -> None:
    tokens.insert(_place(chance, tokens), f"\n{chance.choice(words.LINES)}\n")


def _nest(chance: Random, tokens: list[str]) -> None:
    """Nest something within itself, up to a few hundred times; often without closing all."""
    opening, middle, closing = chance.choice(_NESTS)
    depth = log_uniform(2, 400, chance.random())
    closed = depth if chance.random() < 0.7 else chance.randint(0, depth)
    text = opening * depth + middle + closing * closed
    tokens.insert(_place(chance, tokens), text)


def _lengthen(chance: Random, tokens: list[str]) -> None:
    """Repeat a token many times, or make it very long."""
    place = _place(chance, tokens)
    count = log_uniform(2, 300, chance.random())
    glue = chance.choice(("", " ", "\n", ",", "::", "+", "\\\n"))
    tokens[place] = glue.join([tokens[place]] * count)


def _macro(chance: Random, tokens: list[str]) -> None:
    """Replace a word of the text by a macro, or make it one."""
    place = _place(chance, tokens)
    word = tokens[place]
    name = chance.choice(("MACRO", "A", "long", "struct", word.strip() or "B"))
    line = chance.choice(
        (
            f"\n#define {name} {word.strip()}\n",
            f"\n#define {name}(x) x {word.strip()} #x\n",
            f"\n#define {name}(x, y) x##y\n",
        )
    )
    tokens[place] = chance.choice(
        (name, f"{name}({word})", f"{name}({word},{word})", f"{name}(")
    )
    tokens.insert(0, line)


_MUTATIONS: list[Callable[[Random, list[str]], None]] = [
    *(
        _delete,
        _delete,
        _repeat,
        _swap,
        _replace,
        _replace,
        _copy,
        _copy,
        _insert,
        _insert,
    ),
    *(_exchange,) * 10,
    *(_member, _member, _annotation, _annotation),
    *(_respell, _respell, _splice, _move, _directive, _nest, _lengthen, _macro),
]
_NESTS = [
    *(("(", "1", ")"), ("sequence<", "long", ">"), ("sequence<", "long", ",1>")),
    *(
        ("map<long,", "long", ">"),
        ("module m {", "", "};"),
        ("struct s {", "long a;", "} a;"),
    ),
    *(
        ("union u switch (long) { case 1: ", "long a;", "} a;"),
        ("[", "1", "]"),
        ("-", "1", ""),
    ),
    *(("\n#if 1\n", "", "\n#endif\n"), ("\n#if 0\n", "", "\n#else\n"), ("::", "A", "")),
    *(
        ("A::", "B", ""),
        ("@a ", "", ""),
        ("{", "", "}"),
        ("<", "", ">"),
        ("~(", "1", ")"),
    ),
    *(
        ("interface I {", "", "};"),
        ("/*", "", "*/"),
        ("1 +", "1", ""),
        ("1 <<", "1", ""),
    ),
    *(
        ('"a" ', "", ""),
        ("@a(", "1", ")"),
        ("F(", "1", ")"),
        ("valuetype V {", "", "};"),
    ),
    *(("enum E { A = ", "1", "};"), ("typedef ", "long a;", ""), (">>", "", "")),
]
_ENCODINGS = [
    *(("utf-8", "surrogatepass"),) * 20,
    *(("utf-8-sig", "surrogatepass"),) * 2,
    *(("latin-1", "replace"), ("shift_jis", "replace"), ("euc_jp", "replace")),
    ("utf-16", "replace"),
]


def _lines(chance: Random, lines: list[str]) -> list[str]:
    """Remove, repeat, exchange or join lines, or change their ends."""
    for _ in range(chance.randint(1, 3)):
        place = chance.randrange(len(lines))
        match chance.randrange(5):
            case 0 if len(lines) > 1:
                del lines[place]
            case 1:
                lines.insert(place, lines[place])
            case 2:
                other = chance.randrange(len(lines))
                lines[place], lines[other] = lines[other], lines[place]
            case 3:
                lines[place] += chance.choice(
                    ("\\", "\r", "\\ ", "//", "/*", "\f", "\v")
                )
            case _:
                lines[place] = chance.choice(words.LINES)
    return lines


def _octets(chance: Random, data: bytes) -> bytes:
    """Change, remove, repeat or insert some octets."""
    octets = bytearray(data)
    for _ in range(log_uniform(1, 8, chance.random())):
        place = chance.randrange(len(octets) + 1)
        match chance.randrange(5):
            case 0:
                octets[place:place] = chance.randbytes(chance.randint(1, 4))
            case 1:
                del octets[place : place + chance.randint(1, 8)]
            case 2 if place < len(octets):
                octets[place] ^= 1 << chance.randrange(8)
            case 3:
                octets[place:place] = octets[place : place + chance.randint(1, 64)]
            case _:
                del octets[place:]
    return bytes(octets)
