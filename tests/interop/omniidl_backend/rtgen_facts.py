"""A back end of omniidl that prints the declarations it read as JSON, for comparison."""

import json

from omniidl import idlast, idltype

BASIC = {
    idltype.tk_void: "void",
    idltype.tk_short: "short",
    idltype.tk_long: "long",
    idltype.tk_ushort: "unsigned short",
    idltype.tk_ulong: "unsigned long",
    idltype.tk_float: "float",
    idltype.tk_double: "double",
    idltype.tk_boolean: "boolean",
    idltype.tk_char: "char",
    idltype.tk_octet: "octet",
    idltype.tk_any: "any",
    idltype.tk_TypeCode: "CORBA::TypeCode",
    idltype.tk_longlong: "long long",
    idltype.tk_ulonglong: "unsigned long long",
    idltype.tk_longdouble: "long double",
    idltype.tk_wchar: "wchar",
}


def name(declaration):
    return "::".join(declaration.scopedName())


def bases(found):
    """Return the names of bases, with typedefs resolved."""
    return [name(behind(base)) for base in found]


def behind(base):
    while isinstance(base, idlast.Declarator):
        base = base.alias().aliasType().decl()
    return base


def type_text(type_):
    kind = type_.kind()
    if kind in BASIC:
        return BASIC[kind]
    if isinstance(type_, idltype.String | idltype.WString):
        word = "wstring" if isinstance(type_, idltype.WString) else "string"
        return f"{word}<{type_.bound()}>" if type_.bound() else word
    if isinstance(type_, idltype.Sequence):
        bound = f",{type_.bound()}" if type_.bound() else ""
        return f"sequence<{type_text(type_.seqType())}{bound}>"
    if isinstance(type_, idltype.Fixed):
        return f"fixed<{type_.digits()},{type_.scale()}>"
    scoped = "::".join(type_.scopedName())
    return {"CORBA::Object": "Object", "CORBA::ValueBase": "ValueBase"}.get(
        scoped, scoped
    )


def declared(type_, declarator):
    return type_text(type_) + "".join(f"[{size}]" for size in declarator.sizes() or ())


def value_text(type_, value):
    if isinstance(value, idlast.Enumerator):
        return name(value)
    if isinstance(value, list):
        return "".join(map(chr, value))
    kind = type_.unalias().kind()
    if kind == idltype.tk_wchar and isinstance(value, int):
        return chr(value)
    if kind in (idltype.tk_boolean,):
        return bool(value)
    return value if isinstance(value, int | float | str) else str(value)


class Facts:
    def __init__(self):
        self.found = []

    def add(self, node, kind, **facts):
        self.found.append(
            {"kind": kind, "name": name(node), "id": node.repoId(), **facts}
        )

    def all(self, nodes):
        for node in nodes:
            getattr(self, "visit" + type(node).__name__, self.other)(node)

    def other(self, node):
        pass

    def visitModule(self, node):
        self.all(node.definitions())

    def visitStruct(self, node):
        self.in_place(node.members())
        self.add(node, "struct", members=self.members(node.members()))

    def visitException(self, node):
        self.in_place(node.members())
        self.add(node, "exception", members=self.members(node.members()))

    def in_place(self, members):
        for member in members:
            if member.constrType():
                self.all([member.memberType().decl()])

    def members(self, members):
        return [
            [d.identifier(), declared(m.memberType(), d)]
            for m in members
            for d in m.declarators()
        ]

    def visitUnion(self, node):
        if node.constrType():
            self.all([node.switchType().decl()])
        cases = []
        for case in node.cases():
            if case.constrType():
                self.all([case.caseType().decl()])
            labels = [
                (
                    "default"
                    if label.default()
                    else value_text(node.switchType(), label.value())
                )
                for label in case.labels()
            ]
            cases.append(
                [
                    sorted(map(str, labels)),
                    case.declarator().identifier(),
                    declared(case.caseType(), case.declarator()),
                ]
            )
        self.add(node, "union", switch=type_text(node.switchType()), cases=cases)

    def visitEnum(self, node):
        self.add(node, "enum", members=[e.identifier() for e in node.enumerators()])

    def visitTypedef(self, node):
        if node.constrType():
            self.all([node.aliasType().decl()])
        for declarator in node.declarators():
            self.add(declarator, "typedef", type=declared(node.aliasType(), declarator))

    def visitConst(self, node):
        value = value_text(node.constType(), node.value())
        type_ = type_text(node.constType())
        if type_ == "fixed<0,0>":
            whole, _, fraction = value.lstrip("-").partition(".")
            digits = len(whole.lstrip("0") + fraction)
            type_ = f"fixed<{max(digits, 1)},{len(fraction)}>"
        self.add(node, "const", type=type_, value=value)

    def visitNative(self, node):
        self.add(node, "native")

    def visitInterface(self, node):
        self.add(
            node,
            "interface",
            bases=bases(node.inherits()),
            abstract=bool(node.abstract()),
            local=bool(node.local()),
            **self.callables(node),
        )
        self.all(node.declarations())

    def callables(self, node):
        operations = []
        attributes = []
        for callable_ in node.callables():
            if isinstance(callable_, idlast.Operation):
                operations.append(self.operation(callable_))
            else:
                attributes += [
                    [
                        d.identifier(),
                        d.repoId(),
                        type_text(callable_.attrType()),
                        bool(callable_.readonly()),
                    ]
                    for d in callable_.declarators()
                ]
        return {"operations": operations, "attributes": attributes}

    def operation(self, node):
        return [
            node.identifier(),
            node.repoId(),
            bool(node.oneway()),
            type_text(node.returnType()),
            self.parameters(node),
            list(dict.fromkeys(name(e) for e in node.raises())),
            list(node.contexts()),
        ]

    def parameters(self, node):
        directions = ("in", "out", "inout")
        return [
            [directions[p.direction()], p.identifier(), type_text(p.paramType())]
            for p in node.parameters()
        ]

    def value(self, node, *, abstract, custom, truncatable, state, factories):
        self.add(
            node,
            "valuetype",
            bases=bases(node.inherits()),
            supports=bases(node.supports()),
            abstract=abstract,
            custom=custom,
            truncatable=truncatable,
            state=state,
            factories=factories,
            **self.callables(node),
        )
        self.all(node.declarations())

    def visitValue(self, node):
        state = []
        for member in node.statemembers():
            if member.constrType():
                self.all([member.memberType().decl()])
            public = member.memberAccess() == 0
            state += [
                [d.identifier(), declared(member.memberType(), d), public]
                for d in member.declarators()
            ]
        self.value(
            node,
            abstract=False,
            custom=bool(node.custom()),
            truncatable=bool(node.truncatable()),
            state=state,
            factories=[
                [f.identifier(), self.parameters(f), [name(e) for e in f.raises()]]
                for f in node.factories()
            ],
        )

    def visitValueAbs(self, node):
        self.value(
            node,
            abstract=True,
            custom=False,
            truncatable=False,
            state=[],
            factories=[],
        )

    def visitValueBox(self, node):
        if node.constrType():
            self.all([node.boxedType().decl()])
        self.add(node, "valuebox", type=type_text(node.boxedType()))


def run(tree, args):
    facts = Facts()
    facts.all(tree.declarations())
    print(json.dumps(facts.found))
