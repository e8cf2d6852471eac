"""Pages of types and interfaces: one for each module, with the wire layout of each struct."""

from __future__ import annotations

from collections.abc import Iterator

from rtgen.compiler.backends.kit.idl_text.literals import default_text, readable
from rtgen.compiler.backends.kit.member_texts import (
    limits_text,
    member_text,
    operation_text,
)
from rtgen.compiler.backends.kit.quoting.markdown import Markdown, code, text
from rtgen.compiler.inspection.facts import kind_of
from rtgen.compiler.inspection.models import labels_of
from rtgen.compiler.layouts.offsets import MemberPlace
from rtgen.compiler.model import (
    VOID,
    Bitmask,
    Bitset,
    Case,
    Component,
    Const,
    Declaration,
    Enum,
    ExceptionDecl,
    Home,
    InitialValue,
    Interface,
    Member,
    Operation,
    PortKind,
    Struct,
    Typedef,
    Union,
    ValueBox,
    Valuetype,
    limits,
)
from rtgen.compiler.model.declarations import Documented
from rtgen.compiler.model.initial import default_of
from rtgen.compiler.typemap.member_units import annotated_unit
from rtgen.tools.docs.pages import Content, Page, counted
from rtgen.tools.docs.places import Kind

GLOBAL = "global scope"


def listed(content: Content) -> dict[str, list[Declaration]]:
    """Return the declarations documented by pages of types, by module, and assign anchors."""
    found: dict[str, list[Declaration]] = {}
    for declaration in content.model.declarations:
        if not isinstance(declaration, Component | Home):
            module = "::".join(declaration.name[:-1]) or GLOBAL
            found.setdefault(module, []).append(declaration)
    for module, declarations in found.items():
        page = content.places.page(Kind.TYPE, f"module {module}", module)
        for declaration in declarations:
            content.places.section(Kind.TYPE, declaration.scoped, page)
    return found


def pages(
    content: Content, modules: dict[str, list[Declaration]]
) -> Iterator[tuple[str, Page]]:
    """Yield the name and the page of each module."""
    for module, declarations in modules.items():
        path = content.places.page(Kind.TYPE, f"module {module}")
        page = Page(path, module if module == GLOBAL else f"Module {module}")
        page.summary = counted(kind_of(declaration) for declaration in declarations)
        for declaration in declarations:
            _add(content, page, declaration)
        yield module, page


def _add(content: Content, page: Page, d: Declaration) -> None:
    anchor = content.places.url(Kind.TYPE, d.scoped, page.path).partition("#")[2]
    page.heading(2, f"{kind_of(d)} {d.name[-1]}", anchor)
    page.description(member_text(d))
    facts = [("defined in", content.source(d.file, d.span))]
    if d.repository_id:
        facts.append(("repository id", code(d.repository_id)))
    page.add(", ".join(f"{name} {value}" for name, value in facts))
    match d:
        case Struct():
            _add_struct(content, page, d)
        case ExceptionDecl():
            types = (content.places.type(m.type, page.path) for m in d.members)
            rows: list[tuple[object, ...]] = [
                (code(m.name), type_, _unit(m), _described(content, m))
                for m, type_ in zip(d.members, types, strict=True)
            ]
            page.table(("member", "type", "unit", "description"), rows)
        case Union():
            _add_union(content, page, d)
        case Enum() | Bitmask():
            number = "value" if isinstance(d, Enum) else "bit"
            rows = [(code(m.name), text(m.value), m.doc) for m in d.members]
            page.table(("name", number, "description"), rows)
            if isinstance(d, Enum) and d.initial is not d.members[0]:
                page.add(f"Values start with {code(d.initial.name)}.")
        case Bitset():
            rows = [
                (
                    code(m.name or ""),
                    text(m.bits),
                    _unit(m),
                    _with_facts(m, m.initial),
                )
                for m in d.members
            ]
            page.table(("field", "bits", "unit", "description"), rows)
        case Typedef() | ValueBox():
            other = content.places.type(d.type, page.path)
            own = d.initial if isinstance(d, Typedef) else None
            default = default_of(content.model, d.type, own)
            said = (
                "" if default is None else f" Default: {code(default_text(default))}."
            )
            page.add(f"Another name of {other}.{said}")
        case Const():
            shown = readable(content.model, d.type, d.value)
            page.add(f"{content.places.type(d.type, page.path)}: {code(shown)}")
        case Interface() | Valuetype():
            _add_interface(content, page, d)


def _add_struct(content: Content, page: Page, struct: Struct) -> None:
    plain, compact = (layouts.of(struct) for layouts in content.layouts)
    rows = []
    for place, other in zip(plain.members, compact.members, strict=True):
        member = place.member
        flags = [w for w in ("key", "optional", "external") if getattr(member, w)]
        rows.append(
            (
                code(member.name),
                content.places.type(member.type, page.path),
                _unit(member),
                *_octets(place),
                *_octets(other),
                text(" ".join([*flags, _described(content, member)]).strip()),
            )
        )
    head = ("member", "type", "unit", "CDR offset", "CDR size")
    page.table((*head, "XCDR2 offset", "XCDR2 size", "description"), rows)
    sizes = [
        f"{name} {'depends on the values' if size is None else f'{size} octets'}"
        for name, size in (("CDR", plain.size), ("XCDR2", compact.size))
    ]
    kind = content.cdr.extensibility(struct)
    base = ""
    if struct.base is not None:
        name = "::".join(struct.base)
        base = f" Members of {content.places.link(Kind.TYPE, name, page.path)} first."
    page.add(f"Size: {', '.join(sizes)}. Extensibility: {kind}.{base}")


def _described(content: Content, entry: Member | Case) -> str:
    """Return the description of a member or branch, with its default."""
    if isinstance(entry, Member) and entry.optional:
        return _with_facts(entry, None)
    return _with_facts(entry, default_of(content.model, entry.type, entry.initial))


def _with_facts(entry: Documented, default: InitialValue | None) -> str:
    """Return a description with limits and default, a sentence each."""
    bounds = limits_text(limits(entry.annotations))
    facts = [f"Limits: {bounds}."] * bool(bounds)
    if default is not None:
        facts.append(f"Default: {default_text(default)}.")
    return " ".join([entry.doc, *facts]).strip() if facts else entry.doc


def _unit(entry: Documented) -> str:
    """Return the unit that an annotation states, as written."""
    return annotated_unit(entry) or ""


def _octets(place: MemberPlace) -> list[object]:
    """Return offset and size; `...` if they depend on values."""
    return ["..." if n is None else n for n in (place.offset, place.size)]


def _add_union(content: Content, page: Page, union: Union) -> None:
    switch = content.places.type(union.switch, page.path)
    page.add(f"The discriminator, {switch}, comes first; then the branch of its value.")
    rows = []
    for case in union.cases:
        shown = ", ".join(labels_of(case, content.model.unalias(union.switch)))
        type_ = content.places.type(case.type, page.path)
        described = _described(content, case)
        rows.append((code(shown), code(case.name), type_, _unit(case), described))
    page.table(("label", "branch", "type", "unit", "description"), rows)


def _add_interface(
    content: Content, page: Page, interface: Interface | Valuetype
) -> None:
    places, here = content.places, page.path
    if interface.bases:
        names = (places.link(Kind.TYPE, "::".join(b), here) for b in interface.bases)
        page.add(f"Derives from {', '.join(names)}.")
    attributes = [
        (
            code(a.name),
            places.type(a.type, here),
            "readonly" * a.readonly,
            member_text(a),
        )
        for a in interface.attributes
    ]
    page.table(("attribute", "type", "access", "description"), attributes)
    operations = [_operation(content, here, each) for each in interface.operations]
    page.table(
        ("operation", "returns", "parameters", "raises", "description"), operations
    )
    for kind, verb in (
        (PortKind.PROVIDER, "Provided by"),
        (PortKind.CONSUMER, "Called by"),
    ):
        users = content.users.get((kind, interface.scoped))
        if users:
            links = (places.link(Kind.COMPONENT, name, here) for name in users)
            page.add(f"{verb} {', '.join(links)}.")


def _operation(content: Content, here: str, o: Operation) -> tuple[object, ...]:
    places = content.places
    parameters = [
        f"{p.direction} {places.type(p.type, here)} {code(p.name)}"
        for p in o.parameters
    ]
    raises = (places.link(Kind.TYPE, "::".join(name), here) for name in o.raises)
    returns = "oneway" if o.oneway else ""
    if o.returns != VOID:
        returns = places.type(o.returns, here)
    return (
        code(o.name),
        returns,
        Markdown("<br>".join(parameters)),
        Markdown(", ".join(raises)),
        operation_text(o),
    )
