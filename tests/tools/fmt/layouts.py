"""Random layouts of valid texts, and their content, which a formatter must not change."""

from __future__ import annotations

import random
import re

from rtgen.tools.fmt.tokens import COMMENTS, Kind, Language, Token, tokens

TEXTS = {
    Language.IDL: (
        "module M { const long A = - 1 | ( B << 2 ) ; struct S : T { long a , b [ 3 ] ; } ; } ;",
        "enum E { RED , GREEN , BLUE } ; bitmask F { @position(3) A , B } ;",
        "interface I : J , ::K { oneway void f ( in long a , inout M::T b ) raises ( X , Y ) ;"
        " readonly attribute sequence < sequence < long , 3 >> c ; exception Z { string why ; } ; } ;",
        "union U switch ( enum V { P , Q } ) { case P : case Q : @key long a ; default : any b ; } ;",
        '@rtc ( kind = "A" ) component C { @unit ( "m" ) publishes M::T p ; attribute double d ; } ;',
        "valuetype V : truncatable W supports I { public long a ; factory f ( in long b ) ; } ;",
        "typedef struct R { map < string , long > m ; } Q ; typedef fixed < 5 , 2 > G ;",
    ),
    Language.CDL: (
        "[ active ] celltype tA { call sB cB [ ] ; attr { int32_t * a = { 1 , 2 * 3 } ; } ; } ;",
        "signature sA { [ oneway ] void f ( [ in , size_is ( n ) ] const char_t * p , [ in ] int n ) ; } ;",
        "region r { cell tA A { [ through ( P , \"\" ) ] cB = r::C.eD [ 2 ] ; x = C_EXP ( \"&z\" ) ; } ; } ;",
        "enum { A = 1 , B = A + 2 } ; typedef struct tagS { int8_t * * p ; } S ; const int N = ( int ) 3 ;",
        "composite tC { entry sA e ; cell tA In { cB => composite.c ; } ; composite.e => In.eA ; } ;",
    ),
}  # fmt: skip
"""Texts with separated tokens."""

_GAPS = (
    *(" ", "\n", "\t", "   ", "\n\n", "\n\n\n  ", " \n\t "),
    *("/* c */", " /** d\n * e */ ", "/* f\n g\n   h */", " // i\n", "\n// j\n", "\n/// k\n"),
    *(" ///< l\n", " // m \\\n n\n", "\n/* o */ /* p */\n", " /**< q */"),
)  # fmt: skip
_DIRECTIVES = (
    *("\n#pragma x  y\n", "\n #ifdef A\n", "\n#endif\n", "\n#else // z\n"),
    *("\n#define A \\\n 1\n", "\n#if 0\n it's\n#endif\n"),
)  # fmt: skip


def layout(number: int) -> tuple[str, Language]:
    """Return a text with random space, comments and preprocessor lines between its tokens."""
    chance = random.Random(number)
    language = chance.choice(list(Language))
    words = chance.choice(TEXTS[language]).split(" ")
    parts = [chance.choice(("", "\n", "// head\n", "/* head */"))]
    plain = chance.choice((0.5, 0.8, 1.0))
    directives = chance.choice((0.0, 0.0, 0.1)) if language is Language.IDL else 0.0
    for word, follower in zip(words, [*words[1:], ""], strict=True):
        parts.append(word)
        pick = chance.random()
        if pick < directives:
            parts.append(chance.choice(_DIRECTIVES))
        elif pick < plain:
            touch = re.match(r"\w|[@\"]", follower) and re.search(r"[\w\"]$", word)
            apart = touch or (word + follower)[-2:] in (">>", "::", "<<")
            parts.append(" " if apart else chance.choice(("", " ", "\n", "\n\n")))
        else:
            gaps = (
                _GAPS
                if language is Language.IDL
                else [g for g in _GAPS if "\\" not in g]
            )
            parts.append(chance.choice(gaps))
    return "".join(parts), language


def content(text: str, language: Language) -> tuple[list[str], list[list[str]]]:
    """Return the tokens of a text, its comments and preprocessor lines, without indentation."""
    found = tokens(text, language)
    plain = [
        _spelt(token)
        for token in found
        if token.kind not in (*COMMENTS, Kind.DIRECTIVE)
    ]
    rest = [
        [line.strip() for line in token.text.split("\n")]
        for token in found
        if token.kind in (*COMMENTS, Kind.DIRECTIVE)
    ]
    return plain, rest


def _spelt(token: Token) -> str:
    if token.kind is Kind.ANNOTATION:
        return "@" + token.text[1:].lstrip()
    return token.text
