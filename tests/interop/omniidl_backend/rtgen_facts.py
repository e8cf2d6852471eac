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
        self.add(node, "const", type=type_text(node.constType()), value=value)

    def visitNative(self, node):
        self.add(node, "native")

    def visitInterface(self, node):
        operations = []
        attributes = []
        for callable_ in node.callables():
            if isinstance(callable_, idlast.Operation):
                operations.append(self.operation(callable_))
            else:
                attributes += [
                    [
                        d.identifier(),
                        type_text(callable_.attrType()),
                        bool(callable_.readonly()),
                    ]
                    for d in callable_.declarators()
                ]
        self.add(
            node,
            "interface",
            bases=[name(base) for base in node.inherits()],
            abstract=bool(node.abstract()),
            local=bool(node.local()),
            operations=operations,
            attributes=attributes,
        )
        self.all(node.declarations())

    def operation(self, node):
        directions = ("in", "out", "inout")
        return [
            node.identifier(),
            node.repoId(),
            bool(node.oneway()),
            type_text(node.returnType()),
            [
                [directions[p.direction()], p.identifier(), type_text(p.paramType())]
                for p in node.parameters()
            ],
            [name(e) for e in node.raises()],
            list(node.contexts()),
        ]

    def visitValue(self, node):
        state = []
        for member in node.statemembers():
            state += [
                [d.identifier(), declared(member.memberType(), d)]
                for d in member.declarators()
            ]
        self.add(
            node, "valuetype", bases=[name(b) for b in node.inherits()], state=state
        )
        self.all(node.declarations())

    def visitValueAbs(self, node):
        self.add(node, "valuetype", bases=[name(b) for b in node.inherits()], state=[])
        self.all(node.declarations())

    def visitValueBox(self, node):
        self.add(node, "valuebox", type=type_text(node.boxedType()))


def run(tree, args):
    facts = Facts()
    facts.all(tree.declarations())
    print(json.dumps(facts.found))
