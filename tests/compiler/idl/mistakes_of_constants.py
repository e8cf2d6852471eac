"""Mistakes in literals, constants and expressions."""

from mistake import Mistake, unknown

CONSTANTS: dict[str, Mistake] = {
    "1.0f": ("const float A = §1.0f;", "IDL0109: 1.0f ends with 'f'", "write 1.0"),
    "10L": ("const long A = §10L;", "IDL0109: 10L ends with 'L'", "write 10"),
    "0x10u": ("const long A = §0x10u;", "IDL0109: 0x10u ends with 'u'", "write 0x10"),
    "1'000": (
        "const long A = 1§'000;",
        "IDL0109: this character literal is not closed",
        "a character literal is enclosed in ', as in 'x'",
    ),
    "true": unknown(
        "const boolean A = §true;", "the boolean constants are TRUE and FALSE"
    ),
    "True": unknown(
        "const boolean A = §True;", "the boolean constants are TRUE and FALSE"
    ),
    "false": unknown(
        "const boolean A = §false;", "the boolean constants are TRUE and FALSE"
    ),
    "0b1": (
        "const long A = §0b101;",
        "IDL0109: 0b101 is not a number",
        "write 5 or 0x5",
    ),
    "089": (
        "const long A = §089;",
        "IDL0109: 089 begins with 0, so it is octal, but holds an 8 or a 9",
        "write 89",
    ),
    "unclosed string": (
        'const string A = §"abc;',
        "IDL0108: this string is never closed",
        'put " at its end',
    ),
    "unclosed char": (
        "const char A = §'a;",
        "IDL0109: this character literal is not closed",
        "a character literal is enclosed in ', as in 'x'",
    ),
    "long char": (
        "const char A = §'ab';",
        "IDL0109: a character literal holds one character, not 2 characters",
        'strings are written as "..."',
    ),
    "string for char": (
        'const char A = §"a";',
        "IDL0500: a character is expected here, not a string",
        "write one character in single quotes, such as 'x'",
    ),
    "char for string": (
        "const string A = §'a';",
        "IDL0500: a string is expected here, not a character",
        'write text in double quotes, such as "text"',
    ),
    "string for wstring": (
        'const wstring A = §"a";',
        "IDL0500: a wide string is expected here, not a string",
        "wide literals begin with L, others do not",
    ),
    "wstring for string": (
        'const string A = §L"a";',
        "IDL0500: a string is expected here, not a wide string",
        "wide literals begin with L, others do not",
    ),
    "char for wchar": (
        "const wchar A = §'a';",
        "IDL0500: a wide character is expected here, not a character",
        "wide literals begin with L, others do not",
    ),
    "int for float": (
        "const double A = §1;",
        "IDL0507: a floating-point number is expected here",
        "write 1.0",
    ),
    "float for int": (
        "const long A = §1.5;",
        "IDL0500: an integer is expected here, not a floating-point number",
        "write a number without point, or make the type double",
    ),
    "int for boolean": (
        "const boolean A = §1;",
        "IDL0500: a boolean is expected here, not an integer",
        "write TRUE or FALSE",
    ),
    "string for long": (
        'const long A = §"1";',
        "IDL0500: an integer is expected here, not a string",
        "write a number without point and quotes, such as 10",
    ),
    "null": unknown(
        "const string A = §NULL;", 'IDL has no null; an empty string is ""'
    ),
    "nullptr": (
        "const long A = §{1};",
        "IDL0121: a constant holds a single value in IDL",
        "constants are numbers, characters, strings, booleans and enumerators",
    ),
    "plus string": (
        'const string A = §"a" + "b";',
        "IDL0500: a string has no operators",
        "adjacent strings are joined",
    ),
    "const range": (
        "const octet A = §256;",
        "IDL0501: 256 is out of the range of octet: 0 to 255",
        "short holds it",
    ),
    "const without type": (
        "const §A = 1;",
        "IDL0125: the constant has no type, or no name",
        "write const TYPE NAME = VALUE;",
    ),
    "const without value": (
        "const long A§;",
        "IDL0124: the value of the constant is missing here",
        "write '= VALUE' after the name",
    ),
    "const in module ok but =": (
        "module M { const long A§ 1; };",
        "IDL0124: a '=' is missing here",
        "put '=' after 'A'",
    ),
    "==": ("const long A §== 1;", "IDL0100: '==' is not allowed here", "write one '='"),
    ":=": (
        "const long A §:= 1;",
        "IDL0124: a '=' is expected here, not ':='",
        "write '='",
    ),
    "ternary": (
        "const long A = 1 §? 2 : 3;",
        "IDL0004: the character '?' is not allowed here",
        "IDL has no conditional expressions; an optional member is marked @optional",
    ),
    "logical and": (
        "const boolean A = TRUE &§& FALSE;",
        "IDL0121: IDL has no logical operators",
        "boolean constants are TRUE or FALSE",
    ),
    "not": (
        "const boolean A = §!TRUE;",
        "IDL0004: the character '!' is not allowed here",
        "IDL has no logical operators; complement is ~",
    ),
    "power": (
        "const double A = 2.0 *§* 3.0;",
        "IDL0121: IDL has no powers",
        "write the number, or a product",
    ),
    "cast": (
        "const long A = (§long) 3.5;",
        "IDL0121: IDL has no casts",
        "write a value of the type of the constant",
    ),
}
