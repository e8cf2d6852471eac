"""Section 5 of the language: constant expressions."""

from idl_probes.probe import better, refused, same, stricter

PROBES = [
    same(
        "all types",
        "const short A = 1; const long B = 2; const long long C = 3; const unsigned short D = 4; const unsigned long E = 5; const unsigned long long F = 6; const octet G = 7; const char H = 'a'; const wchar I = L'b'; const boolean J = TRUE; const float K = 1.5; const double L = 2.5; const string M = \"c\"; const wstring N = L\"d\";",
    ),
    same("long double", "const long double A = 1.5;", "IDL0313"),
    same("bounded strings", 'const string<5> A = "abc"; const wstring<3> B = L"abc";'),
    same(
        "plain fixed",
        "const fixed A = 3.14d;",
        gives={"A": "const A: fixed<3,2> = 3.14"},
    ),
    same("enum", "enum E { A, B }; const E C = B;"),
    same(
        "aliases",
        'typedef long T; typedef T U; const U A = 3; typedef string<4> S; const S B = "abc"; enum E { X }; typedef E F; const F C = X;',
    ),
    refused("any", "const any A = 1;", "IDL0310"),
    refused("struct", "struct S { long a; }; const S A = 1;", "IDL0310"),
    refused("Object", "const Object A = 0;", "IDL0310"),
    refused("sequence", "const sequence<long> A = 1;", "IDL0310"),
    refused("alias of an array", "typedef long T[2]; const T A = 1;", "IDL0310"),
    refused("fixed with digits", "const fixed<3, 2> A = 3.14d;", "IDL0305"),
    refused("without a value", "const long A;", "IDL01"),
    refused("without a type", "const A = 1;", "IDL01"),
    # Operators
    same(
        "or, xor, and",
        "const long A = 1 | 6 ^ 5 & 3; const long B = 12 & 10 | 1; const long C = 6 ^ 3 | 8;",
    ),
    same(
        "shift and add",
        "const long A = 1 << 2 + 1; const long B = 256 >> 2 >> 1; const long C = 1 << 1 << 1;",
    ),
    same(
        "add and multiply",
        "const long A = 1 + 2 * 3; const long B = 10 - 4 - 3; const long C = 100 / 10 / 5; const long D = 17 % 7 % 2;",
    ),
    same(
        "unary",
        "const long A = -5; const long B = +5; const long C = -(-5); const long D = 3 - -2; const long E = 2 * -3;",
    ),
    refused("- - 1", "const long A = - - 1;", "IDL01"),
    refused("- + 1", "const long A = -+1;", "IDL01"),
    refused("~-1", "const long A = ~-1;", "IDL01"),
    same("brackets", "const long A = (1 + 2) * 3; const long B = ((4));"),
    refused("unclosed bracket", "const long A = (1 + 2;", "IDL01"),
    same("names", "module M { const long N = 3; }; const long A = M::N + ::M::N;"),
    refused("name of a type", "typedef long T; const long A = T;", "IDL0211"),
    refused("operator without a right side", "const long A = 1 +;", "IDL01"),
    refused("comparison", "const boolean A = 1 < 2;", "IDL01"),
    refused("not", "const boolean A = !TRUE;", "IDL0004"),
    # No mixing
    better(
        "integer literal for a double",
        "const double A = 1;",
        "IDL0507",
        A="const A: double = 1.0",
    ),
    better(
        "integer in a floating expression",
        "const double A = 1.5 + 1;",
        "IDL0507",
        A="const A: double = 2.5",
    ),
    better(
        "integer constant in a floating expression",
        "const long N = 2; const double A = 1.5 * N;",
        "IDL0507",
        A="const A: double = 3.0",
    ),
    refused("floating literal for an integer", "const long A = 1.0;", "IDL0500"),
    refused(
        "floating constant for an integer",
        "const double N = 1.0; const long A = N;",
        "IDL0500",
    ),
    refused("fixed for a double", "const double A = 1.5d;", "IDL0500"),
    refused("double for a fixed", "const fixed A = 1.5;", "IDL0500"),
    refused("character for an integer", "const long A = 'a';", "IDL0500"),
    refused("integer for a character", "const char A = 65;", "IDL0500"),
    refused("string for a character", 'const char A = "a";', "IDL0500"),
    refused("character for a string", "const string A = 'a';", "IDL0500"),
    refused("boolean for an integer", "const long A = TRUE;", "IDL0500"),
    refused("enumerator for an integer", "enum E { A }; const long B = A;", "IDL0500"),
    refused("integer for an enumerator", "enum E { A }; const E B = 0;", "IDL0500"),
    # Integers
    same(
        "intermediate above",
        "const long A = 4294967295 - 4294967290; const unsigned long B = 0 - 1 + 2;",
    ),
    refused("sum above", "const unsigned long A = 4294967295 + 1 - 5;", "IDL0501"),
    refused(
        "sum above 32 bits in a long",
        "const long A = 4294967295 + 1 - 4294967290;",
        "IDL0501",
    ),
    refused("product above", "const long A = 65536 * 65536 / 65536;", "IDL0501"),
    refused("difference below", "const long A = -2147483647 - 5 + 5;", "IDL0501"),
    refused(
        "operand above 32 bits", "const long A = 4294967296 / 4294967296;", "IDL0501"
    ),
    refused(
        "negative operand in a constant of another type",
        "const long long N = -4294967296; const long A = N / N;",
        "IDL0501",
    ),
    same(
        "64 bits",
        "const long long A = 9223372036854775807; const unsigned long long B = 18446744073709551615 - 5; const long long C = 18446744073709551615 - 18446744073709551610;",
    ),
    refused(
        "64 bits, sum above",
        "const unsigned long long A = 18446744073709551615 + 1;",
        "IDL0501",
    ),
    refused(
        "64 bits, product above",
        "const unsigned long long A = 4294967296 * 4294967296;",
        "IDL0501",
    ),
    refused(
        "64 bits, below", "const long long A = -9223372036854775807 - 2;", "IDL0501"
    ),
    same(
        "limits",
        "const short A = 32767; const short B = -32768; const unsigned short C = 65535; const long D = 2147483647; const long E = -2147483647; const unsigned long F = 4294967295; const octet G = 255; const octet H = 0;",
    ),
    *(
        refused(f"{kind} = {value}", f"const {kind} A = {value};", "IDL0501")
        for kind, value in (
            ("short", "32768"),
            ("short", "-32769"),
            ("unsigned short", "65536"),
            ("unsigned short", "-1"),
            ("long", "2147483648"),
            ("long", "-2147483649"),
            ("unsigned long", "4294967296"),
            ("unsigned long", "-1"),
            ("octet", "256"),
            ("octet", "-1"),
            ("long long", "9223372036854775808"),
            ("long long", "-9223372036854775809"),
            ("unsigned long long", "-1"),
        )
    ),
    better(
        "least long", "const long A = -2147483648;", A="const A: long = -2147483648"
    ),
    better(
        "least long long",
        "const long long A = -9223372036854775808;",
        A="const A: long long = -9223372036854775808",
    ),
    better(
        "least long by subtraction",
        "const long A = -2147483647 - 1;",
        A="const A: long = -2147483648",
    ),
    better(
        "least long long by subtraction",
        "const long long A = -9223372036854775807 - 1;",
        A="const A: long long = -9223372036854775808",
    ),
    same(
        "complement, unsigned",
        "const unsigned long A = ~0; const unsigned long B = ~5; const unsigned long long C = ~0;",
    ),
    same(
        "complement, masked",
        "const octet A = ~5 & 0xff; const short B = ~5 & 0x7f; const unsigned short C = ~1 & 0xffff;",
    ),
    same("complement of a negative", "const long A = ~(-1); const long B = ~(-6);"),
    better("complement, long", "const long A = ~5;", A="const A: long = -6"),
    better(
        "complement, long long", "const long long A = ~5;", A="const A: long long = -6"
    ),
    better("complement, short", "const short A = ~5;", A="const A: short = -6"),
    better("complement, octet", "const octet A = ~5;", A="const A: octet = 250"),
    better(
        "complement, unsigned short",
        "const unsigned short A = ~5;",
        A="const A: unsigned short = 65530",
    ),
    refused("complement of a float", "const double A = ~1.0;", "IDL0500"),
    same(
        "shift",
        "const long A = 1 << 30; const unsigned long B = 1 << 31; const unsigned long long C = 1 << 63; const long D = 64 >> 3;",
    ),
    refused("1 << 31 in a long", "const long A = 1 << 31;", "IDL0501"),
    refused("1 << 64", "const unsigned long long A = 1 << 64;", "IDL0503"),
    refused("shift by a negative", "const long A = 1 << -1;", "IDL0503"),
    refused("right shift by a negative", "const long A = 1 >> -1;", "IDL0503"),
    stricter("1 << 32", "const long A = 1 << 32;", "IDL0503"),
    stricter("1 >> 32", "const long A = 1 >> 32;", "IDL0503"),
    same(
        "arithmetic shift",
        "const long A = -8 >> 1; const long B = -1 >> 3; const long long C = -16 >> 2;",
    ),
    same("negative left shift", "const long A = -1 << 4;"),
    same(
        "division toward zero",
        "const long A = -7 / 2; const long B = 7 / -2; const long C = -7 / -2; const long long D = -9 / 2;",
    ),
    same("remainder of a negative", "const long A = -7 % 2;", "IDL0508"),
    same("remainder by a negative", "const long A = 7 % -2;", "IDL0508"),
    refused("division by zero", "const long A = 1 / 0;", "IDL0502"),
    refused("remainder by zero", "const long A = 1 % 0;", "IDL0502"),
    refused("floating division by zero", "const double A = 1.0 / 0.0;", "IDL0502"),
    refused("fixed division by zero", "const fixed A = 1.0d / 0.0d;", "IDL0502"),
    same(
        "and, or of negatives",
        "const long A = -4 & -2; const long B = -4 | 1; const long C = -4 ^ 3;",
    ),
    # Floating-point
    same(
        "floats",
        "const float A = 0.1; const float B = 1.0 / 3.0; const double C = 1.0 / 3.0; const double D = 1e-300; const double E = -(1.5 + 2.5) * 3.0;",
    ),
    same("large float", "const float A = 3.4e38; const double B = 1.7e308;"),
    same("infinite double", "const double A = -(1e400);", "IDL0509"),
    same("infinite float", "const float A = 1e39;", "IDL0509"),
    refused(
        "infinite constant",
        "const float A = 1e39; const float B = A;",
        "IDL0509",
        "IDL0501",
    ),
    refused("infinite product", "const double A = 1e200 * 1e200;", "IDL0501"),
    same("tiny double is 0", "const double A = 1e-400;"),
    refused("floating or", "const double A = 1.0 | 2.0;", "IDL0500"),
    refused("floating shift", "const double A = 1.0 << 2.0;", "IDL0500"),
    refused("floating remainder", "const double A = 1.0 % 2.0;", "IDL0500"),
    same(
        "float constant in a double", "const float A = 1.5; const double B = A * 2.0;"
    ),
    same("double constant in a float", "const double A = 0.1; const float B = A;"),
    # Fixed
    same(
        "fixed sums",
        "const fixed A = 1.25d + 2.5d; const fixed B = 1.25d - 2.5d; const fixed C = 1.25d * 2.5d; const fixed D = -1.5d;",
    ),
    same(
        "fixed quotients",
        "const fixed A = 1.0d / 3.0d; const fixed B = 10d / 4d; const fixed C = 2d / 3d; const fixed D = 100d / 3d;",
    ),
    same(
        "fixed alias", "typedef fixed<5, 2> F; const F A = 123.45d; const F B = 1.5d;"
    ),
    stricter(
        "fixed alias, too many digits",
        "typedef fixed<3, 2> F; const F A = 12.5d;",
        "IDL0501",
    ),
    refused(
        "fixed alias, far too many digits",
        "typedef fixed<3, 2> F; const F A = 1234.5d;",
        "IDL0501",
    ),
    same(
        "fixed alias, surplus fraction",
        "typedef fixed<5, 2> F; const F A = 1.239d;",
        "IDL0504",
    ),
    same(
        "fixed alias, negative surplus",
        "typedef fixed<5, 2> F; const F A = -1.239d;",
        "IDL0504",
    ),
    same("fixed from a constant", "const fixed A = 1.5d; const fixed B = A * 2d;"),
    refused("fixed or", "const fixed A = 1d | 2d;", "IDL0500"),
    refused("fixed complement", "const fixed A = ~1d;", "IDL0500"),
    better(
        "integer in a fixed expression",
        "const fixed A = 1.5d + 1;",
        "IDL0507",
        A="const A: fixed<2,1> = 2.5",
    ),
    # Booleans, characters, strings, enums
    same("boolean constant", "const boolean A = TRUE; const boolean B = A;"),
    refused("TRUE | FALSE", "const boolean A = TRUE | FALSE;", "IDL0500"),
    refused("-TRUE", "const boolean A = -TRUE;", "IDL0500"),
    same(
        "character constant",
        "const char A = 'a'; const char B = A; const wchar C = L'c'; const wchar D = C;",
    ),
    refused("character arithmetic", "const char A = 'a' + 'b';", "IDL0500"),
    same(
        "string constant",
        'const string A = "a"; const string B = A; const wstring C = L"a"; const wstring D = C;',
    ),
    refused('"a" + "b"', 'const string A = "a" + "b";', "IDL0500"),
    refused(
        "string and constant", 'const string A = "a"; const string B = A "b";', "IDL01"
    ),
    same("string in brackets", 'const string A = ("a");'),
    refused("longer than the bound", 'const string<2> A = "abc";', "IDL0505"),
    refused("wide, longer than the bound", 'const wstring<2> A = L"abc";', "IDL0505"),
    refused(
        "constant longer than the bound",
        'const string A = "abc"; const string<2> B = A;',
        "IDL0505",
    ),
    same("as long as the bound", 'const string<3> A = "abc";'),
    refused(
        "wide constant for a narrow one",
        'const wstring A = L"a"; const string B = A;',
        "IDL0500",
    ),
    same("enum constant", "enum E { A, B }; const E C = A; const E D = C;"),
    refused(
        "enumerator of another enum",
        "enum E { A }; enum F { B }; const E C = B;",
        "IDL0506",
    ),
    refused(
        "constant of another enum",
        "enum E { A }; enum F { B }; const F C = B; const E D = C;",
        "IDL0506",
    ),
    refused(
        "enumerators have no operators",
        "enum E { A, B }; const E C = A | B;",
        "IDL0500",
    ),
    # Constants of other types
    same(
        "short for a long",
        "const short A = 3; const long B = A; const octet C = A; const unsigned long long D = A * 2;",
    ),
    refused("long for a short", "const long A = 40000; const short B = A;", "IDL0501"),
    refused(
        "negative for unsigned",
        "const long A = -1; const unsigned long B = A;",
        "IDL0501",
    ),
    same("long long for a long", "const long long A = 5; const long B = A;"),
    refused("constant of itself", "const long A = A;", "IDL0200"),
    refused("constant in a struct", "struct S { const long C = 1; };", "IDL01"),
    same(
        "constant in an interface",
        "interface I { const long C = 1; const long D = C + 1; }; const long E = I::D;",
    ),
    same(
        "bounds by constants",
        "module M { const short N = 2; }; typedef sequence<string<M::N>, M::N * 2> T; typedef long A[M::N][M::N + 1];",
    ),
    refused(
        "string as a dimension", 'const string N = "a"; typedef long A[N];', "IDL0500"
    ),
    refused("unknown name", "const long A = Nothing;", "IDL0200"),
]
