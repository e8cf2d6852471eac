"""Writes tokens as octets: white space, comments, macros, line ends, encodings."""

from __future__ import annotations

import re
from random import Random

import idl_words as words

_WORD = re.compile(r"[A-Za-z]\w*")
_SPLICED = re.compile(r"\\\r?\n\Z")
_LINE_END = re.compile(r"(?<!\r)\n")
_COMMENTS = (
    *(
        "/* c */",
        "// c\n",
        "/** Doc. */",
        "/// Doc.\n",
        "///< Trailing.\n",
        "/* // */",
        "// /*\n",
    ),
    *(
        '/* " */',
        "// don't\n",
        "/**/",
        "/*\n * Long.\n *\n * @param x y\n */",
    ),
    *("// \u65e5\u672c\u8a9e\n", "/* \u8868\u80fd */", "// \u00e9 \\ \n", "/*\\\n*/"),
)
_KEY = "//@key\n"
"""A comment that is an annotation: the member before it becomes a key."""

_PLAIN = str.maketrans({"\u65e5": "a", "\u672c": "b", "\u8a9e": "c"})


def write(chance: Random, tokens: list[str], *, faithful: bool) -> bytes:
    """Return the file; `faithful`: it has the meaning of the tokens."""
    if chance.random() < 0.2:
        tokens = _macros(chance, tokens)
    busy = 0.3 if chance.random() < 0.1 else 0.01
    parts: list[str] = []
    for token in tokens:
        if token.endswith("\n"):
            if parts and (_SPLICED.search(parts[-1]) or parts[-1][-1] != "\n"):
                parts.append("\n")
            parts.append(token)
            continue
        parts.append(token)
        if token in _TIGHT and chance.random() < 0.5:
            continue
        parts.append(
            _space(chance, token, faithful) if chance.random() < busy else _usual(token)
        )
    return _encode(chance, "".join(parts), faithful)


_TIGHT = frozenset("( [ :: < { ~".split())


def _usual(token: str) -> str:
    return "\n" if token in (";", "{") else " "


def _space(chance: Random, token: str, faithful: bool) -> str:
    """Return unusual white space."""
    return chance.choice(
        (
            *("  ", "\t", "\n", "\r\n", "\f", "\v", "\n\n\n", "\\\n ", " \\\r\n"),
            f" {chance.choice(_COMMENTS if faithful else (*_COMMENTS, _KEY))} ",
            _usual(token),
        )
    )


def _macros(chance: Random, tokens: list[str]) -> list[str]:
    """Replace some words by macros, which are defined at the top."""
    head: list[str] = []
    result: list[str] = []
    names: dict[str, str] = {}
    for token in tokens:
        if not _WORD.fullmatch(token) or chance.random() > 0.15:
            result.append(token)
            continue
        if token not in names:
            name = f"MACRO_{len(names)}"
            names[token] = name
            cut = chance.randint(1, len(token))
            head.append(
                chance.choice(
                    (
                        f"#define {name} {token}\n",
                        f"#define {name}_ {token}\n#define {name} {name}_\n",
                        f"#define {name}_(x) x\n#define {name} {name}_({token})\n",
                        f"#define {name}_(x,y) x##y\n"
                        f"#define {name} {name}_({token[:cut]},{token[cut:]})\n",
                    )
                )
            )
        result.append(names[token])
    return head + result


def _encode(chance: Random, text: str, faithful: bool) -> bytes:
    if chance.random() < 0.05:
        text = _LINE_END.sub("\r\n", text)
    if faithful:
        encoding = chance.choice(("utf-8",) * 8 + ("utf-8-sig", "latin-1"))
        return text.encode(
            encoding, "backslashreplace" if encoding == "latin-1" else "strict"
        )
    encoding = chance.choice(
        ("utf-8",) * 8 + ("utf-8-sig", "latin-1", "shift_jis", "euc_jp")
    )
    if chance.random() < 0.02:
        place = chance.randrange(len(text) + 1)
        text = text[:place] + chance.choice(words.TEXTS) + text[place:]
    return text.encode(encoding, "replace")
