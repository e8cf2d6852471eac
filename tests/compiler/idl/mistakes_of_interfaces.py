"""Mistakes in interfaces: bases, attributes, operations, parameters."""

from mistake import Mistake, unknown

INTERFACES: dict[str, Mistake] = {
    "direction": (
        "interface I { void f(§long a); };",
        "IDL0118: the parameter a has no direction",
        "put in, out or inout before its type",
    ),
    "direction second": (
        "interface I { void f(in long a, §long b); };",
        "IDL0118: the parameter b has no direction",
        "put in, out or inout before its type",
    ),
    "direction after": (
        "interface I { void f(long §in a); };",
        "IDL0100: 'in' belongs before the type of the parameter",
        "write 'in TYPE NAME'",
    ),
    "direction ref": (
        "interface I { void f(in long §&a); };",
        "IDL0121: IDL has no pointers and references",
        "write string for text, sequence<T> for several, inout or out for a result",
    ),
    "direction const ref": (
        "interface I { void f(in §const string a); };",
        "IDL0121: IDL has no 'const' here",
        "leave the word out: IDL passes values",
    ),
    "in out": (
        "interface I { void f(in §out long a); };",
        "IDL0100: 'in' and 'out' cannot be combined",
        "a parameter has one direction: in, out or inout",
    ),
    "parameter without name": (
        "interface I { void f(in long§); };",
        "IDL0125: the name of the parameter is missing here",
        "parameters have a direction, a type and a name: in long count",
    ),
    "void parameter": (
        "interface I { void f(§void); };",
        "IDL0125: an operation without parameters has nothing between ( and )",
        "write ()",
    ),
    "throws": (
        "exception E {}; interface I { void f() §throws (E); };",
        "IDL0121: IDL has no 'throws'",
        "write raises (NAME)",
    ),
    "type like a parameter": unknown(
        "interface I { void f(in §B b); };",
        "declare it before its use, or include the file that declares it",
    ),
    "parens missing": (
        "interface I { void f§; };",
        "IDL0124: '()' is missing here",
        "write f() for an operation, attribute TYPE f for a value",
    ),
    "class": (
        "§class C { long a; };",
        "IDL0121: IDL has no 'class'",
        "write struct for data, interface for operations, valuetype for both",
    ),
    "virtual": (
        "interface I { §virtual void f(); };",
        "IDL0121: IDL has no 'virtual'",
        "operations can always be overridden: leave the word out",
    ),
    "static": (
        "interface I { §static void f(); };",
        "IDL0121: IDL has no 'static'",
        "leave the word out: operations belong to objects",
    ),
    "public:": (
        "interface I { §public: void f(); };",
        "IDL0121: IDL has no 'public:'",
        "remove it: members of structs and interfaces are public",
    ),
    "public in interface": (
        "interface I { §public void f(); };",
        "IDL0122: 'public' is not allowed in an interface",
        "remove it: members of an interface are public",
    ),
    "method body": (
        "interface I { void f() §{ } };",
        "IDL0121: operations have no body in IDL",
        "end the declaration with ';'",
    ),
    "method body 2": (
        "interface I {\n void f() §{ return 1; }\n void g();\n};",
        "IDL0121: operations have no body in IDL",
        "end the declaration with ';'",
    ),
    "const method": (
        "interface I { void f() §const; };",
        "IDL0121: operations are not const in IDL",
        "leave the word out",
    ),
    "pure virtual": (
        "interface I { void f() §= 0; };",
        "IDL0121: operations are not defined in IDL",
        "leave the '= ...' out",
    ),
    "default argument": (
        "interface I { void f(in long a §= 1); };",
        "IDL0121: parameters have no default values in IDL",
        "leave the value out",
    ),
    "overloaded": (
        "interface I { void f(); void §f(in long a); };",
        "IDL0202: f is declared twice",
        "operations cannot be overloaded: give each a name of its own",
    ),
    "constructor": (
        "interface I { §I(in long a); };",
        "IDL0125: the operation I has no result type",
        "write void before the name if it returns nothing; IDL has no constructors",
    ),
    "raises without parenthesis": (
        "exception E {}; interface I { void f() raises §E; };",
        "IDL0124: a '(' is missing after 'raises'",
        "write raises (E)",
    ),
    "raises empty": (
        "interface I { void f() §raises (); };",
        "IDL0119: no exception is named",
        "name an exception, or leave raises out",
    ),
    "raises before": (
        "exception E {};\ninterface I { void §raises (E) f(); };",
        "IDL0100: 'raises' follows the parameters",
        "write TYPE NAME(...) raises (EXCEPTION)",
    ),
    "oneway result": (
        "interface I { oneway §long f(); };",
        "IDL0607: f is oneway, so it returns void",
        "write void, or leave oneway out",
    ),
    "oneway out": (
        "interface I { oneway void f(out long §a); };",
        "IDL0607: f is oneway, so its parameters are in",
        "write in, or leave oneway out",
    ),
    "oneway raises": (
        "exception E {}; interface I { oneway void f() §raises (E); };",
        "IDL0607: f is oneway, so it raises nothing",
        "leave raises or oneway out",
    ),
    "raises struct": (
        "struct E { long a; }; interface I { void f() raises (§E); };",
        "IDL0605: the struct E is not an exception",
        "declare it as exception E { ... };",
    ),
    "array parameter": (
        "interface I { void f(in long §a[3]); };",
        "IDL0306: an array needs a name here",
        "use a typedef",
    ),
    "sequence parameter": (
        "interface I { void f(in §sequence<long> a); };",
        "IDL0306: a type declared in place is not allowed here",
        "give it a name before: use a typedef",
    ),
    "sequence result": (
        "interface I { §sequence<long> f(); };",
        "IDL0306: a type declared in place is not allowed here",
        "give it a name before: use a typedef",
    ),
    "inheritance extends": (
        "interface A {};\ninterface B §extends A {};",
        "IDL0121: IDL has no 'extends'",
        "write ':' before the base",
    ),
    "inheritance public": (
        "interface A {};\ninterface B : §public A {};",
        "IDL0121: IDL has no 'public' here",
        "leave the word out: bases are public",
    ),
    "inheritance paren": (
        "interface A {};\ninterface B§(A) {};",
        "IDL0100: a base follows ':'",
        "write interface B : A",
    ),
    "inherit struct": (
        "struct A { long x; };\ninterface B : §A {};",
        "IDL0301: the struct A cannot be a base of an interface",
        "a base of an interface is an interface",
    ),
    "inherit forward": (
        "interface A;\ninterface B : §A {};\ninterface A {};",
        "IDL0300: A is not defined before this place",
        "put its definition before",
    ),
    "inherit struct by class": (
        "§class A {};",
        "IDL0121: IDL has no 'class'",
        "write struct for data, interface for operations, valuetype for both",
    ),
    "attribute =": (
        "interface I { attribute long a §= 1; };",
        "IDL0121: attributes have no initial values in IDL",
        "leave the value out",
    ),
    "property": (
        "interface I { §property long a; };",
        "IDL0121: IDL has no 'property'",
        "write attribute",
    ),
    "readonly without attribute": (
        "interface I { readonly §long a; };",
        "IDL0125: 'attribute' is missing after 'readonly'",
        "write readonly attribute TYPE NAME;",
    ),
    "member in interface": (
        "interface I { long a§; };",
        "IDL0124: '()' is missing here",
        "write a() for an operation, attribute TYPE a for a value",
    ),
    "raises unknown": unknown(
        "interface I { void f() raises (§Faliure); };\nexception Failure {};",
        "did you mean Failure?",
    ),
}
