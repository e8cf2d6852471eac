"""Misspelt words, and words with the wrong case."""

from mistake import Mistake, misspelt, unknown

SPELLING: dict[str, Mistake] = {
    "strcut": misspelt("§strcut S { long a; };", "struct"),
    "interace": misspelt("§interace I { void f(); };", "interface"),
    "modul": misspelt("§modul M { struct S { long a; }; };", "module"),
    "sequnce": misspelt("typedef §sequnce<long> L;", "sequence"),
    "sequnce member": misspelt("struct S { §sequnce<long> l; };", "sequence"),
    "unsinged": misspelt("struct S { §unsinged long a; };", "unsigned"),
    "unsinged typedef": misspelt("typedef §unsinged long A;", "unsigned"),
    "typdef": misspelt("§typdef long A;", "typedef"),
    "exeption": misspelt("§exeption E { string why; };", "exception"),
    "enumm": misspelt("§enumm E { A };", "enum"),
    "attribut": misspelt("interface I { §attribut long a; };", "attribute"),
    "readonly": misspelt("interface I { §readony attribute long a; };", "readonly"),
    "oneway misspelt": misspelt("interface I { §onway void f(); };", "oneway"),
    "rises": misspelt(
        "exception E {}; interface I { void f() §rises (E); };", "raises"
    ),
    "raise": misspelt(
        "exception E {}; interface I { void f() §raise (E); };", "raises"
    ),
    "inn": misspelt("interface I { void f(§inn long a); };", "in"),
    "swich": misspelt("union U §swich (long) { case 1: long a; };", "switch"),
    "cas": misspelt("union U switch (long) { §cas 1: long a; };", "case"),
    "defalt": misspelt(
        "union U switch (long) { case 1: long a; §defalt: long b; };", "default"
    ),
    "cnst": misspelt("§cnst long A = 1;", "const"),
    "abstrct": misspelt("§abstrct interface I {};", "abstract"),
    "valuetyp": misspelt("§valuetyp V { public long a; };", "valuetype"),
    "typo type": unknown("struct S { §duoble a; };", "did you mean double?"),
    "typo type strng": unknown("struct S { §strng a; };", "did you mean string?"),
    "typo type bolean": unknown("struct S { §bolean a; };", "did you mean boolean?"),
    "typo user": unknown(
        "struct Position { long a; };\nstruct S { §Positon p; };",
        "did you mean Position?",
    ),
    "case keyword Struct": misspelt("§Struct S { long a; };", "struct"),
    "case MODULE": misspelt("§MODULE M { struct S { long a; }; };", "module"),
    "case Long": unknown("struct S { §Long a; };", "did you mean the keyword 'long'?"),
    "case String": unknown(
        "struct S { §String a; };", "did you mean the keyword 'string'?"
    ),
    "case Boolean": unknown(
        "struct S { §Boolean a; };", "did you mean the keyword 'boolean'?"
    ),
    "case object": unknown(
        "interface I { void f(in §object o); };", "did you mean the keyword 'Object'?"
    ),
    "case type": (
        "struct Position { long a; };\nstruct S { §position p; };",
        "IDL0201: position is declared as Position",
        "write Position",
    ),
    "case Void": unknown(
        "interface I { §Void f(); };", "did you mean the keyword 'void'?"
    ),
    "case In": misspelt("interface I { void f(§In long a); };", "in"),
    "case Any": unknown("struct S { §Any a; };", "did you mean the keyword 'any'?"),
}
