"""Mistakes in modules, and in names: their form, their scopes, their declarations."""

from mistake import Mistake, unknown

from rtgen.compiler.frontends.idl.names.lookup import CASE_ALLOWED

NAMES: dict[str, Mistake] = {
    "using namespace": (
        "§using namespace std;\nstruct S { long a; };",
        "IDL0121: IDL has no 'using'",
        "IDL has no using: write typedef for a type, or scoped names such as A::B",
    ),
    "namespace": (
        "§namespace N { struct S { long a; }; };",
        "IDL0121: IDL has no 'namespace'",
        "write module",
    ),
    "package": (
        "§package N;\nstruct S { long a; };",
        "IDL0121: IDL has no 'package'",
        "write module NAME { ... };",
    ),
    "redefinition": (
        "struct S { long a; };\nstruct §S { long b; };",
        "IDL0202: S is declared twice",
        "rename one of them",
    ),
    "redefinition kinds": (
        "struct S { long a; };\nenum §S { A };",
        "IDL0202: S is declared twice",
        "rename one of them",
    ),
    "foo": (
        "struct Foo { long a; };\nstruct S { Foo §foo; };",
        "IDL0204: foo clashes with Foo, which is used in this scope",
        f"write ::Foo there, or rename this; {CASE_ALLOWED}",
    ),
    "keyword name": (
        "struct S { long §in; };",
        "IDL0103: 'in' is a keyword and cannot be a name",
        "'_in' is the escaped form of in",
    ),
    "keyword name type": (
        "struct §object { long a; };",
        "IDL0206: object differs from the keyword 'Object' in case only",
        f"'_object' is the escaped form of object; {CASE_ALLOWED}",
    ),
    "keyword parameter": (
        "interface I { void f(in string §context); };",
        "IDL0103: 'context' is a keyword and cannot be a name",
        "'_context' is the escaped form of context",
    ),
    "keyword enumerator": (
        "enum E { §default, other };",
        "IDL0103: 'default' is a keyword and cannot be a name",
        "'_default' is the escaped form of default",
    ),
    "keyword operation": (
        "interface I { void §local(); };",
        "IDL0103: 'local' is a keyword and cannot be a name",
        "'_local' is the escaped form of local",
    ),
    "keyword module": (
        "module §public { struct S { long a; }; };",
        "IDL0103: 'public' is a keyword and cannot be a name",
        "'_public' is the escaped form of public",
    ),
    "single colon": (
        "module M { struct P { long a; }; };\nstruct S { M§:P a; };",
        "IDL0100: one ':' is not allowed in a name",
        "parts of a name are joined by ::",
    ),
    "dot": (
        "module M { struct P { long a; }; };\nstruct S { M§.P a; };",
        "IDL0004: the character '.' is not allowed here",
        "parts of a name are joined by ::",
    ),
    "arrow": (
        "module M { struct P { long a; }; };\nstruct S { M§->P a; };",
        "IDL0100: '-' is not allowed in a name",
        "parts of a name are joined by ::",
    ),
    "slash": (
        "module M { struct P { long a; }; };\nstruct S { M§/P a; };",
        "IDL0100: '/' is not allowed in a name",
        "parts of a name are joined by ::",
    ),
    "before declaration": unknown(
        "struct S { §T a; };\nstruct T { long b; };",
        "it is declared later, at a.idl:2: move that before its use",
    ),
    "before declaration module": unknown(
        "module M { struct S { §T a; }; };\nmodule M { struct T { long b; }; };",
        "it is declared later, at a.idl:2: move that before its use",
    ),
    "other module": unknown(
        "module M { struct T { long b; }; };\nstruct S { §T a; };", "did you mean M::T?"
    ),
    "forward never": (
        "struct §S;\ntypedef sequence<S> Ss;",
        "IDL0215: the struct S is declared, but never defined",
        "define it, or remove the declaration",
    ),
    "forward interface never": (
        "interface §I;\nstruct S { I a; };",
        "IDL0216: the interface I is declared, but never defined",
        "define it, or remove the declaration",
    ),
    "hyphen name": (
        "struct S { long max§-speed; };",
        "IDL0100: '-' is not allowed in a name",
        "write max_speed",
    ),
    "digit name": (
        "struct S { long §2nd; };",
        "IDL0100: '2nd' is not a name: it begins with a digit",
        "a name begins with a letter",
    ),
    "dollar name": (
        "struct S { long §$a; };",
        "IDL0004: the character '$' is not allowed here",
        "names hold ASCII letters, digits and underscores",
    ),
    "space name": (
        "struct S { long max §speed; };",
        "IDL0100: 'speed' is not allowed here: max is the name already",
        "write max_speed if that is one name",
    ),
    "space name struct": (
        "struct My §Struct { long a; };",
        "IDL0100: 'Struct' is not allowed here: My is the name already",
        "write My_Struct if that is one name",
    ),
    "accents": (
        "struct S { long §größe; };",
        "IDL0207: the identifier größe has letters other than ASCII",
        "names hold the letters a to z, digits and underscores",
    ),
    "leading underscores": (
        "struct S { long §__a; };",
        "IDL0207: the identifier _a has more than one leading underscore",
        "write a",
    ),
    "operation in module": (
        "module M { §void f(); };",
        "IDL0122: an operation is not allowed in a module",
        "put it into an interface",
    ),
    "operation at top": (
        "§void f();",
        "IDL0122: an operation is not allowed at file scope",
        "put it into an interface",
    ),
    "member at top": (
        "§long a;",
        "IDL0122: a member is not allowed at file scope",
        "put it into a struct; or write typedef for a type, const for a constant",
    ),
    "enum used as scope": (
        "enum E { A };\nconst E X = E::§A;",
        "IDL0213: A is declared beside the enum, not inside it",
        "write A",
    ),
    "module lowercase end": (
        "module M { struct S { long a; } ; } §end;",
        "IDL0121: IDL has no 'end'",
        "a body ends with '};'",
    ),
    "name ending": (
        "struct S { CORBA§:: ; };",
        "IDL0125: a name is missing after '::'",
        "'::' separates the parts of a scoped name",
    ),
    "name ending 2": (
        "struct S { sequence<CORBA§::> a; };",
        "IDL0125: a name is missing after '::'",
        "'::' separates the parts of a scoped name",
    ),
}
