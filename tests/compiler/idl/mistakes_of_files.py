"""Mistakes in comments, directives and characters of a file."""

from mistake import Mistake

FILES: dict[str, Mistake] = {
    "unclosed comment inside a struct": (
        "module M {\nstruct S { long a; §/* the first\n long b; };\n};",
        "IDL0007: this comment is never closed",
        "comments do not nest; close it with */",
    ),
    "missing endif inside a struct": (
        "struct S {\n§#ifdef X\n    long a;\n};\nstruct T { S a; };",
        "IDL0013: this conditional is never closed",
        "add #endif at the end of the file",
    ),
    "unclosed comment": (
        "struct S { long a; };\n§/* never",
        "IDL0007: this comment is never closed",
        "comments do not nest; close it with */",
    ),
    "define as const": (
        "#define N 10;\nstruct S { long a[§N]; };",
        "IDL0100: the text of this macro holds a ';', which is not allowed here",
        "remove the ';' from its #define",
    ),
    "missing endif": (
        "§#ifndef A\n#define A\nstruct S { long a; };\n",
        "IDL0013: this conditional is never closed",
        "add #endif at the end of the file",
    ),
    "extra endif": (
        "struct S { long a; };\n§#endif",
        "IDL0014: #endif without #if",
        "remove it, or add the #if that is missing before it",
    ),
    "missing include": (
        '§#include "gone.idl"\nstruct S { Gone a; };',
        "IDL0010: the file gone.idl was not found",
        "searched: .",
    ),
    "include typo": (
        '§#include "whel.idl"\nstruct S { Wheel a; };',
        "IDL0010: the file whel.idl was not found",
        "did you mean wheel.idl? searched: .",
    ),
    "include case": (
        '§#include "Wheel.idl"\nstruct S { Wheel a; };',
        "IDL0010: the file Wheel.idl was not found",
        "did you mean wheel.idl? (only the case differs) searched: .",
    ),
    "include no quotes": (
        "§#include wheel.idl\nstruct S { Wheel a; };",
        'IDL0012: #include needs "file" or <file> after it',
        'write #include "wheel.idl"',
    ),
    "include one quote": (
        '§#include "wheel.idl\nstruct S { Wheel a; };',
        'IDL0012: #include needs "file" or <file> after it',
        'write #include "wheel.idl"',
    ),
    "include angle": (
        "§#include <wheel.idl>\nstruct S { Wheel a; };",
        "IDL0010: the file wheel.idl was not found",
        "searched: no folder (use -I)",
    ),
    "inclued": (
        '§#inclued "wheel.idl"\nstruct S { Wheel a; };',
        "IDL0021: '#inclued' is not a directive",
        "did you mean #include?",
    ),
    "import": (
        '§import "wheel.idl";\nstruct S { Wheel a; };',
        "IDL0012: import of a text: nothing is read",
        'write #include "file.idl" for a file, import NAME; for a module',
    ),
    "import no quotes": (
        "§import wheel.idl;\nstruct S { Wheel a; };",
        "IDL0100: 'import' does not accept a file name",
        'write #include "file.idl" for a file; import takes a name and a semicolon',
    ),
    "include without hash": (
        '§include "wheel.idl"\nstruct S { Wheel a; };',
        "IDL0121: IDL has no 'include'",
        'write #include "file.idl"',
    ),
    "pragma prefix": (
        "§#pragma prefix omg.org\nstruct S { long a; };",
        "IDL0700: malformed pragma",
        'write #pragma prefix "text"',
    ),
    "smart quotes": (
        "const string A = §\u201cabc\u201d;",
        "IDL0004: the character '\u201c' is not allowed here",
        'write "',
    ),
    "nbsp": (
        "struct S {§\xa0long a; };",
        "IDL0004: the no-break space, U+00A0, is not allowed here",
        "write a plain space",
    ),
    "fullwidth semicolon": (
        "struct S { long a§\uff1b};",
        "IDL0004: the character '\uff1b' is not allowed here",
        "write ;",
    ),
    "ideographic space": (
        "struct S {§\u3000long a; };",
        "IDL0004: the ideographic space, U+3000, is not allowed here",
        "write a plain space",
    ),
    "minus sign": (
        "const long A = §\u22121;",
        "IDL0004: the character '\u2212' is not allowed here",
        "write -",
    ),
    "zero width": (
        "struct S { long §\u200ba; };",
        "IDL0004: the zero width space, U+200B, is not allowed here",
        "remove it; nothing is seen of it",
    ),
    "bom in the middle": (
        "struct S { long §\ufeffa; };",
        "IDL0004: the zero width no-break space, U+FEFF, is not allowed here",
        "remove it; nothing is seen of it",
    ),
    "hash comment": (
        "§# this is a comment\nstruct S { long a; };",
        "IDL0021: '#this' is not a directive",
        "a comment begins with //, a pragma with #pragma",
    ),
    "dash comment": (
        "§-- this is a comment\nstruct S { long a; };",
        "IDL0121: this is not a comment in IDL",
        "write // ... or /* ... */",
    ),
    "xml comment": (
        "§<!-- this is a comment -->\nstruct S { long a; };",
        "IDL0121: this is not a comment in IDL",
        "write // ... or /* ... */",
    ),
}
