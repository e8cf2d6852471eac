"""Section 2 of the language, second half: pragmas and repository ids."""

from idl_probes.probe import better, refused, same, stricter

_S = "struct S { long a; };"

PROBES = [
    same(
        "version of a forward declaration",
        "interface F;\n#pragma version F 2.3\ninterface F { void g(); };\ninterface F;",
    ),
    refused(
        "ID of a forward declaration, then another prefix",
        'interface F;\n#pragma ID F "IDL:x:1.0"\n#pragma prefix "q"\ninterface F {};',
        "IDL0214",
    ),
    refused("ID in another case", _S + '\n#pragma ID s "IDL:x:1.0"\n', "IDL0201"),
    same("default id", _S + " module M { " + _S + " module N { " + _S + " }; };"),
    same(
        "ids of all kinds",
        "module M { const long C = 1; typedef long T; enum E { X }; exception Ex {}; union U switch (long) { case 1: long a; }; interface I { void f(); attribute long b; }; native Na; valuetype V {}; valuetype B long; };",
    ),
    same(
        "ids inside an interface",
        "interface I { struct S { long a; }; const long C = 1; exception E {}; void f() raises(E); };",
    ),
    same("ids inside a struct", "struct S { struct T { enum E { A } e_; } t_; };"),
    same("prefix", '#pragma prefix "p"\n' + _S),
    same("prefix of two texts", '#pragma prefix "a" "b/" "c"\n' + _S),
    same("prefix with dots and slashes", '#pragma prefix "a.b/c-d"\n' + _S),
    same(
        "prefix for what follows",
        'struct A { long x; };\n#pragma prefix "p"\nstruct B { long x; };\n#pragma prefix "q"\nstruct C { long x; };',
    ),
    same(
        "prefix outside a module",
        '#pragma prefix "p"\nmodule M { module N { ' + _S + " }; };",
    ),
    same(
        "prefix replaces the path",
        'module M {\n#pragma prefix "b"\ninterface J {}; module N { ' + _S + " }; };",
    ),
    same(
        "prefix ends with the module",
        'module M {\n#pragma prefix "b"\n struct A { long x; }; };\nmodule M { struct B { long x; }; }; struct C { long x; };',
    ),
    same(
        "prefix ends with the inner module",
        'module M { module N {\n#pragma prefix "b"\n struct A { long x; }; };\nstruct B { long x; }; };',
    ),
    same(
        "prefix in a reopened module",
        '#pragma prefix "p"\nmodule M { struct A { long x; }; };\n#pragma prefix "q"\nmodule M { struct B { long x; }; };',
    ),
    same(
        "empty prefix resets",
        '#pragma prefix "p"\nstruct A { long x; };\n#pragma prefix ""\nstruct B { long x; };',
    ),
    same("empty prefix in a module", 'module M {\n#pragma prefix ""\n' + _S + " };"),
    same(
        "prefix and inner scopes",
        '#pragma prefix "p"\ninterface I { struct S { long a; }; void f(); };',
    ),
    same(
        "included file starts without",
        '#pragma prefix "p"\n#include "t.idl"\nstruct S { long a; };',
        files={"t.idl": "struct T { long b; };"},
    ),
    same(
        "prefix of an included file ends",
        '#include "t.idl"\nstruct S { long a; };',
        files={"t.idl": '#pragma prefix "t"\nstruct T { long b; };'},
    ),
    same(
        "included in a module",
        'module M {\n#include "t.idl"\nstruct S { long a; };\n};',
        files={"t.idl": "struct T { long b; };"},
    ),
    same(
        "included in a module with prefixes",
        '#pragma prefix "p"\nmodule M {\n#include "t.idl"\nstruct S { long a; };\n};',
        files={"t.idl": '#pragma prefix "t"\nstruct T { long b; };'},
    ),
    same(
        "included in a module, prefix inside",
        'module M {\n#pragma prefix "p"\n#include "t.idl"\nstruct S { long a; };\n};',
        files={"t.idl": "struct T { long b; };"},
    ),
    same(
        "module reopened by an included file",
        '#pragma prefix "p"\nmodule M { struct A { long x; }; };\n#include "t.idl"\nmodule M { struct B { long x; }; };',
        files={"t.idl": "module M { struct T { long b; }; };"},
    ),
    better(
        "prefix in an interface",
        'interface I {\n#pragma prefix "p"\nstruct S { long a; }; };',
        gives={"I": "interface I", "I::S id": "IDL:p/S:1.0"},
    ),
    refused("prefix without quotes", "#pragma prefix p\n" + _S, "IDL0700"),
    refused("prefix without text", "#pragma prefix\n" + _S, "IDL0700"),
    refused("prefix with more", '#pragma prefix "p" q\n' + _S, "IDL0700"),
    same(
        "prefix of forward and definition",
        '#pragma prefix "p"\ninterface I; interface I {};',
    ),
    refused(
        "prefix of forward and definition differ",
        'interface I;\n#pragma prefix "p"\ninterface I {};',
        "IDL0214",
    ),
    refused(
        "prefix of a struct's forward differs",
        '#pragma prefix "p"\nstruct S;\n#pragma prefix "q"\nstruct S { long a; };',
        "IDL0214",
    ),
    same(
        "macro is not expanded in a pragma", '#define p "x"\n#pragma prefix "p"\n' + _S
    ),
    same("ID", _S + '\n#pragma ID S "IDL:x/y:2.3"\n'),
    same("ID scoped", "module M { " + _S + ' };\n#pragma ID M::S "IDL:x:1.0"\n'),
    same("ID absolute", "module M { " + _S + '\n#pragma ID ::M::S "IDL:x:1.0"\n};'),
    same("ID in a module", "module M { " + _S + '\n#pragma ID S "IDL:x:1.0"\n};'),
    same(
        "ID in an interface",
        'interface I { void f();\n#pragma ID f "IDL:x:1.0"\nvoid g(); };',
    ),
    same(
        "ID in a struct",
        'struct T { enum E { A } e_;\n#pragma ID E "IDL:x:1.0"\nlong b; };',
    ),
    same(
        "ID of an interface leaves the inner ids",
        'interface I { struct S { long a; }; };\n#pragma ID I "IDL:x:1.0"\n',
    ),
    same(
        "ID of a forward declaration",
        'interface I;\n#pragma ID I "IDL:x:1.0"\ninterface I { void f(); };',
    ),
    same("ID of a constant", 'const long C = 1;\n#pragma ID C "IDL:x:1.0"\n'),
    same("ID of a typedef", 'typedef long A, B;\n#pragma ID B "IDL:x:1.0"\n'),
    same(
        "ID of an operation",
        'interface I { void f(); };\n#pragma ID I::f "IDL:x:1.0"\n',
    ),
    same("ID of an exception", 'exception E {};\n#pragma ID E "IDL:x:1.0"\n'),
    refused("ID before the declaration", '#pragma ID S "IDL:x:1.0"\n' + _S, "IDL0200"),
    refused("ID of nothing", '#pragma ID Nothing "IDL:x:1.0"\n', "IDL0200"),
    same(
        "same ID again", _S + '\n#pragma ID S "IDL:x:1.0"\n#pragma ID S "IDL:x:1.0"\n'
    ),
    refused(
        "another ID",
        _S + '\n#pragma ID S "IDL:x:1.0"\n#pragma ID S "IDL:y:1.0"\n',
        "IDL0703",
    ),
    same("ID without a format", _S + '\n#pragma ID S "foo"\n', "IDL0702"),
    same("bad IDL form", _S + '\n#pragma ID S "IDL:x"\n', "IDL0702"),
    same("bad version in an ID", _S + '\n#pragma ID S "IDL:x:1.x"\n', "IDL0702"),
    same("DCE", _S + '\n#pragma ID S "DCE:700dc500-0111-22ce-aa9f-0000c0f0d0e0:1"\n'),
    same(
        "RMI and LOCAL",
        _S
        + ' struct T { long b; };\n#pragma ID S "RMI:x.y:1234567890123456"\n#pragma ID T "LOCAL:abc"\n',
    ),
    refused("ID of a member", _S + '\n#pragma ID S::a "IDL:x:1.0"\n', "IDL0701"),
    refused(
        "ID of a branch",
        'union U switch (long) { case 1: long a; };\n#pragma ID U::a "IDL:x:1.0"\n',
        "IDL0701",
    ),
    refused(
        "ID of an enumerator", 'enum E { A };\n#pragma ID A "IDL:x:1.0"\n', "IDL0701"
    ),
    same(
        "ID of an attribute in a list",
        'interface I { attribute long a, b; };\n#pragma ID I::a "IDL:x:1.0"\n',
    ),
    stricter(
        "ID of a parameter",
        'interface I { void f(in long a); };\n#pragma ID I::f::a "IDL:x:1.0"\n',
        "IDL0701",
    ),
    refused("ID without a text", _S + "\n#pragma ID S\n", "IDL0700"),
    refused("ID without quotes", _S + "\n#pragma ID S IDL:x:1.0\n", "IDL0700"),
    same("ID of a module", "module M { " + _S + ' };\n#pragma ID M "IDL:x:1.0"\n'),
    same("version", _S + "\n#pragma version S 2.3\n"),
    same("version scoped", "module M { " + _S + " };\n#pragma version M::S 1.1\n"),
    same(
        "version of an operation", "interface I { void f();\n#pragma version f 2.0\n};"
    ),
    same("same version again", _S + "\n#pragma version S 2.3\n#pragma version S 2.3\n"),
    refused(
        "another version",
        _S + "\n#pragma version S 2.3\n#pragma version S 2.4\n",
        "IDL0703",
    ),
    refused(
        "version after another ID",
        _S + '\n#pragma ID S "IDL:x:1.0"\n#pragma version S 2.3\n',
        "IDL0703",
    ),
    same(
        "version that the ID has",
        _S + '\n#pragma ID S "IDL:x:1.0"\n#pragma version S 1.0\n',
    ),
    refused(
        "ID after a version",
        _S + '\n#pragma version S 2.3\n#pragma ID S "IDL:x:1.0"\n',
        "IDL0703",
    ),
    refused("version without a minor", _S + "\n#pragma version S 2\n", "IDL0700"),
    refused("version without a name", _S + "\n#pragma version 2.3\n", "IDL0700"),
    refused("version of nothing", "#pragma version Nothing 2.3\n", "IDL0200"),
    refused("version of a member", _S + "\n#pragma version S::a 2.3\n", "IDL0701"),
    same("keylist", _S + "\n#pragma keylist S a\n"),
    same(
        "DCPS",
        'module M {\n#pragma DCPS_DATA_TYPE "M::S"\n#pragma DCPS_DATA_KEY "M::S a"\n'
        + _S
        + " };",
    ),
    same("any other pragma", "#pragma hdrstop\n#pragma a b c\n" + _S, "IDL0705"),
    same(
        "pragmas everywhere",
        "module M {\n#pragma a\nstruct S {\n#pragma b\nlong a;\n#pragma c\n};\ninterface I {\n#pragma d\nvoid f();\n};\n};",
        *["IDL0705"] * 4,
    ),
    same("misspelt pragma", '#pragma perfix "p"\n' + _S, "IDL0705"),
    same("pragma in an enum", "enum E { A,\n#pragma a\nB };", "IDL0705"),
    same(
        "pragma in a union",
        "union U switch (long) {\n#pragma a\ncase 1: long a; };",
        "IDL0705",
    ),
    same(
        "two declarations with one id",
        _S + ' struct T { long b; };\n#pragma ID T "IDL:S:1.0"\n',
        "IDL0704",
    ),
]
