"""Mixes pieces of valid inputs: lines, tokens, octets."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from random import Random

from fuzzing import log_uniform

ROOT = Path(__file__).parents[3]
MAX_OCTETS = 50_000

_TOKEN = re.compile(rb"\s+|\w+|\"(?:\\.|[^\"\\\n])*\"|.", re.DOTALL)
_ODD = (
    *(b"", b"0", b"-1", b"1e999", b"nan", b"0x", b"99999999999999999999", b"\0"),
    *(b"\xff", "日本".encode(), b'"', b"'", b"\\", b"\n", b"\r\n", b"\t", b"#", b"$"),
    *(b"=", b"[", b"]", b"[[", b"{", b"}", b"<", b">", b"/", b"..", b"true", b"null"),
    *(b"%s", b"{0}", b"*", b"//", b"/*", b";", b":", b"::", b",", b"class", b"None"),
)


def files(*patterns: str) -> list[bytes]:
    """Return the contents of the repository's files, in the order of their names."""
    found = {path for pattern in patterns for path in ROOT.glob(pattern)}
    texts = [path.read_bytes() for path in sorted(found) if path.is_file()]
    return [text for text in texts if 0 < len(text) <= MAX_OCTETS]


def mixing(seeds: Sequence[bytes]) -> Callable[[Random], bytes]:
    """Return a generator of inputs: a seed with tokens changed, doubled, exchanged or nested."""
    tokens: list[list[bytes]] = []

    def make(chance: Random) -> bytes:
        if not tokens:
            tokens.extend(_TOKEN.findall(seed) for seed in seeds)
        mixed = list(chance.choice(tokens))
        for _ in range(log_uniform(1, 12, chance.random()) - 1):
            _change(chance, mixed, chance.choice(tokens))
        return b"".join(mixed)[:MAX_OCTETS]

    return make


def _change(chance: Random, mixed: list[bytes], other: list[bytes]) -> None:
    at = chance.randrange(len(mixed) + 1)
    match chance.randrange(6):
        case 0:
            mixed.insert(at, chance.choice(_ODD))
        case 1:
            del mixed[at : at + log_uniform(1, 20, chance.random())]
        case 2 if mixed:
            mixed[at - 1] = chance.choice(_ODD)
        case 3 if mixed:
            mixed[at - 1] = chance.choice(other)
        case 4:
            start = chance.randrange(len(other))
            mixed[at:at] = other[start : start + log_uniform(1, 40, chance.random())]
        case _:
            opening, closing = chance.choice(
                ((b"(", b")"), (b"{", b"}"), (b"[", b"]"), (b"<a>", b"</a>"))
            )
            times = log_uniform(1, 400, chance.random())
            mixed[at:at] = [opening * times, closing * chance.choice((0, times))]
