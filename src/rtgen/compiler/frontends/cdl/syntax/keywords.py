"""The keywords of CDL: reserved words, and keywords of specifier lists."""

from __future__ import annotations

from rtgen.compiler.kit.words import words

RESERVED = words("""
    namespace signature celltype cell attr var call entry composite require factory FACTORY
    typedef struct region import import_C generate void volatile const signed unsigned int8_t
    int16_t int32_t int64_t int128_t uint8_t uint16_t uint32_t uint64_t uint128_t float32_t
    double64_t bool_t char_t schar_t uchar_t int short long char enum enum8 enum16 enum32 enum64
    true false C_EXP Descriptor __tool_info__ __location_information__ __cell__ __join__
    """)
"""Reserved words, which are never identifiers."""

SPECIFIERS = words("""
    id callback context deviate singleton idx_is_id active inline ref_desc optional dynamic omit
    choice allocator prototype restrict oneway in out inout send receive size_is count_is string
    nullable through in_through out_through to_through node linkunit domain class
    """)
"""Keywords inside specifier lists, identifiers elsewhere."""

TERMINALS = {
    **{word: word.upper() for word in RESERVED | SPECIFIERS},
    "FACTORY": "CT_FACTORY",
    "string": "TEXT",
    "__tool_info__": "TOOL_INFO",
    "__location_information__": "LOCATION_INFORMATION",
    "__cell__": "LOCATED_CELL",
    "__join__": "LOCATED_JOIN",
}
"""The terminal of the grammar for each keyword."""

WORDS = {
    **{terminal: word for word, terminal in TERMINALS.items()},
    "AMPERSAND": "&",
    "AND_AND": "&&",
    "ARROW": "=>",
    "BAR": "|",
    "CARET": "^",
    "COLON": ":",
    "COMMA": ",",
    "DOT": ".",
    "EQUALS": "=",
    "GREATER": ">",
    "GREATER_EQUAL": ">=",
    "LBRACE": "{",
    "LBRACK": "[",
    "LESS": "<",
    "LESS_EQUAL": "<=",
    "LPAR": "(",
    "MINUS": "-",
    "NOT": "!",
    "OR_OR": "||",
    "PLUS": "+",
    "QMARK": "?",
    "RBRACE": "}",
    "RBRACK": "]",
    "RPAR": ")",
    "SCOPE": "::",
    "SEMI": ";",
    "SPEC_L": "[",
    "SPEC_R": "]",
    "STAR": "*",
    "TILDE": "~",
}
"""The spelling of each terminal that has only one."""
