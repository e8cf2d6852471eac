"""Types of other languages; mistakes in typedefs, arrays, sequences and bounds."""

from mistake import Mistake, unknown

SIZE_FOLLOWS = (
    "IDL0123: the size of an array follows the name",
    "write TYPE NAME[SIZE], or sequence<TYPE> NAME if the size varies",
)

TYPES: dict[str, Mistake] = {
    "unsigned double": (
        "struct S { §unsigned double a; };",
        "IDL0121: 'unsigned double' is not a type",
        "write double: floating-point numbers have a sign",
    ),
    "unsigned char": (
        "struct S { §unsigned char a; };",
        "IDL0121: 'unsigned char' is not a type",
        "write octet for a byte without sign",
    ),
    "unsigned int": (
        "struct S { §unsigned int a; };",
        "IDL0121: 'unsigned int' is not a type",
        "write unsigned long (32 bits)",
    ),
    "unsigned": (
        "struct S { §unsigned a; };",
        "IDL0121: 'unsigned' is not a type",
        "write unsigned short, unsigned long or unsigned long long",
    ),
    "signed": (
        "struct S { §signed long a; };",
        "IDL0121: IDL has no 'signed'",
        "IDL's integers have a sign: leave the word out",
    ),
    "int": unknown("struct S { §int a; };", "write long (32 bits) or short (16 bits)"),
    "int parameter": unknown(
        "interface I { void f(in §int a); };", "write long (32 bits) or short (16 bits)"
    ),
    "int result": unknown(
        "interface I { §int f(); };", "write long (32 bits) or short (16 bits)"
    ),
    "const int": unknown(
        "const §int A = 1;", "write long (32 bits) or short (16 bits)"
    ),
    "long int": (
        "struct S { §long int a; };",
        "IDL0121: 'long int' is not a type",
        "write long",
    ),
    "long float": (
        "struct S { §long float a; };",
        "IDL0121: 'long float' is not a type",
        "write double",
    ),
    "short int": (
        "struct S { §short int a; };",
        "IDL0121: 'short int' is not a type",
        "write short",
    ),
    "long long long": (
        "struct S { §long long long a; };",
        "IDL0121: 'long long long' is not a type",
        "write long long",
    ),
    "bool": unknown("struct S { §bool a; };", "write boolean"),
    "byte": unknown("struct S { §byte a; };", "write octet"),
    "uint32_t": unknown("struct S { §uint32_t a; };", "write unsigned long"),
    "int64_t": unknown("struct S { §int64_t a; };", "write long long"),
    "size_t": unknown(
        "struct S { §size_t a; };",
        "write unsigned long (32 bits) or unsigned long long (64 bits)",
    ),
    "float64": unknown("struct S { §float64 a; };", "write double"),
    "float32": unknown("struct S { §float32 a; };", "write float"),
    "std::string": (
        "struct S { §std::string a; };",
        "IDL0121: IDL has no 'std::string'",
        "write string",
    ),
    "std::vector": (
        "struct S { §std::vector<long> a; };",
        "IDL0121: IDL has no 'std::vector'",
        "write sequence<T>",
    ),
    "vector": (
        "struct S { §vector<long> a; };",
        "IDL0121: IDL has no 'vector'",
        "write sequence<T>",
    ),
    "list": (
        "struct S { §list<long> a; };",
        "IDL0121: IDL has no 'list'",
        "write sequence<T>",
    ),
    "array type": (
        "struct S { §array<long, 3> a; };",
        "IDL0121: IDL has no 'array'",
        "write T name[n] for an array, sequence<T> for a list",
    ),
    "char*": (
        "struct S { char §*a; };",
        "IDL0121: IDL has no pointers and references",
        "write string for text, sequence<T> for several, inout or out for a result",
    ),
    "reference": (
        "struct P { long a; }; struct S { P §&p_; };",
        "IDL0121: IDL has no pointers and references",
        "write string for text, sequence<T> for several, inout or out for a result",
    ),
    "string[]": ("struct S { string §[] a; };", *SIZE_FOLLOWS),
    "array before name": ("struct S { long§[3] a; };", *SIZE_FOLLOWS),
    "array before name typedef": ("typedef long§[3] A;", *SIZE_FOLLOWS),
    "open array": (
        "struct S { long a§[]; };",
        "IDL0123: an array has a size",
        "write NAME[SIZE], or sequence<TYPE> NAME if the size varies",
    ),
    "array comma": (
        "struct S { long a[2§,3]; };",
        "IDL0123: each dimension has its own brackets",
        "write NAME[2][3]",
    ),
    "array parens": (
        "struct S { long a§(3); };",
        "IDL0123: the size of an array is written in brackets",
        "write a[3]",
    ),
    "auto/var": unknown(
        "struct S { §var a; };", "name the type: IDL does not infer types"
    ),
    "ros array": (
        "struct S { sequence<long§ a; };",
        "IDL0124: a '>' is missing here",
        "put '>' after 'long'",
    ),
    "sequence without type": (
        "struct S { sequence§ a; };",
        "IDL0124: a '<' is missing here",
        "put '<' after 'sequence'",
    ),
    "sequence parens": (
        "struct S { sequence§(long) a; };",
        "IDL0124: 'sequence' requires '<' and '>', not '(' and ')'",
        "write sequence<...>",
    ),
    "sequence bound first": (
        "struct S { sequence<§10, long> a; };",
        "IDL0100: the type comes first, then the bound",
        "write sequence<TYPE, BOUND>",
    ),
    "time": unknown(
        "struct S { §Time tm; };",
        "declare it before its use, or include the file that declares it",
    ),
    "bound zero": (
        "typedef sequence<long, §0> L;",
        "IDL0304: 0 is not from 1 to 4294967295",
        "a bound is positive; without a bound, sequences and strings hold any number",
    ),
    "bound text": (
        'typedef string<§"10"> L;',
        "IDL0500: an integer is expected here, not a string",
        "write a number without point and quotes, such as 10",
    ),
    "bound unknown": unknown(
        "typedef string<§N> L;",
        "declare it before its use, or include the file that declares it",
    ),
    "bound float": (
        "typedef string<§1.5> L;",
        "IDL0500: an integer is expected here, not a floating-point number",
        "write a number without point, or make the type double",
    ),
    "array zero": (
        "typedef long A[§0];",
        "IDL0304: 0 is not from 1 to 4294967295",
        "a bound is positive; without a bound, sequences and strings hold any number",
    ),
    "typedef =": (
        "typedef A §= long;",
        "IDL0121: '=' is not allowed in a typedef",
        "write typedef TYPE NAME;",
    ),
    "typedef = 2": (
        "typedef long A §= 3;",
        "IDL0121: '=' is not allowed in a typedef",
        "write typedef TYPE NAME;",
    ),
    "using =": (
        "§using A = long;",
        "IDL0121: IDL has no 'using'",
        "IDL has no using: write typedef for a type, or scoped names such as A::B",
    ),
    "typedef reversed": (
        "typedef Size §long;",
        "IDL0100: 'long' is not allowed here: the type comes first",
        "write typedef long Size;",
    ),
    "template": (
        "§template<typename T> struct S { T a; };",
        "IDL0121: IDL has no 'template'",
        "IDL has no templates of types: write out each struct",
    ),
    "string array C": (
        "struct S { char name§[]; };",
        "IDL0123: an array has a size",
        "write NAME[SIZE], or sequence<TYPE> NAME if the size varies",
    ),
    "nothing between templates": (
        "typedef sequence<§> L;",
        "IDL0125: a type is missing here",
        "write the type of its elements: sequence<long>",
    ),
    "missing name in typedef": (
        "typedef long§;",
        "IDL0125: a name is missing here",
        "a declaration has a type and a name: long count",
    ),
}
