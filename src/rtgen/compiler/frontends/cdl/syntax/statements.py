"""Nodes of the syntax tree for statements: name spaces, signatures, celltypes, cells, regions."""

from __future__ import annotations

from typing import TypeAlias

from rtgen.compiler.frontends.cdl.syntax.tree import (
    Declaration,
    Declarator,
    Expression,
    Initialiser,
    Name,
    OfComposite,
    QualifiedType,
    ScopedName,
    Specifier,
    Specifiers,
    Subscript,
    Text,
    Typedef,
    TypeStatement,
)
from rtgen.compiler.frontends.kit.nodes import Spanned


class Namespace(Spanned):
    """`namespace name { items }`."""

    name: Name
    items: tuple[Item, ...]


class Function(Spanned):
    """A function of a signature; its parameters are in the declarator."""

    type: QualifiedType
    declarator: Declarator


class Signature(Spanned):
    """`signature name { functions }`."""

    name: Name
    functions: tuple[Item, ...]


class Port(Spanned):
    """`call signature name[size]` and `entry signature name`.

    `subscript` is that of an array; `target` is the port in `<= celltype.port`.
    """

    kind: str
    signature: ScopedName
    name: Name
    subscript: Subscript | None
    target: PortOf | None


class PortOf(Spanned):
    """`cell.port` or `celltype.port`, with its subscript."""

    owner: ScopedName
    port: Name
    subscript: Subscript | None


class Attributes(Spanned):
    """`attr { ... }` and, as `keyword` says, `var { ... }`; each item is a `Declaration`."""

    keyword: str
    items: tuple[Item, ...]


class Require(Spanned):
    """`require target.port` or `require name = target.port`."""

    name: Name | None
    target: PortOf


class Factory(Spanned):
    """`factory { ... }`, or `FACTORY { ... }` as `keyword` says."""

    keyword: str
    items: tuple[Item, ...]


class FactoryCall(Spanned):
    """`write( file, format, arguments )`; arguments are names and strings."""

    function: Name
    file: Expression
    format: Expression
    arguments: tuple[Name | Text, ...]


class Celltype(Spanned):
    """`celltype name { ports, attributes, ... }`."""

    name: Name
    items: tuple[Item, ...]


class Join(Spanned):
    """`name[i] = value` in a cell: a join, or the value of an attribute.

    The target of a join is parsed as the expression `cell.port[i]`.
    """

    name: Name
    subscript: Subscript | None
    value: Initialiser | OfComposite


class ReverseJoin(Spanned):
    """`entry[i] <= cell.port[i]`."""

    name: Name
    subscript: Subscript | None
    target: PortOf


class Export(Spanned):
    """`port => composite.name` or `port => name` in an inner cell."""

    port: Name
    name: Name


class EntryExport(Spanned):
    """`composite.name => cell.entry` or `name => cell.entry` in a composite."""

    name: Name
    cell: Name
    port: Name


class Cell(Spanned):
    """`cell type name { joins }`; `joins` is None for a prototype, which has no body."""

    celltype: ScopedName
    name: Name
    joins: tuple[Item, ...] | None


class Composite(Spanned):
    """`composite name { ... }`."""

    name: Name
    items: tuple[Item, ...]


class Region(Spanned):
    """`region name { cells and regions }`."""

    name: Name
    items: tuple[Item, ...]


class Import(Spanned):
    """`import( "file" )`, or `import( <file> )` where `reused` is set; `path` is the name alone."""

    path: str
    reused: bool


class ImportC(Spanned):
    """`import_C( "header" )` or `import_C( "header", "definitions" )`."""

    header: Text
    definitions: Text | None


class Generate(Spanned):
    """`generate( plugin, target, "arguments" )`."""

    plugin: Name
    target: ScopedName
    argument: Text


class ToolInformation(Spanned):
    """`__tool_info__( "name" ) { ... }` and `__location_information__ { ... }`, both ignored."""

    keyword: str


class Skipped(Spanned):
    """A skipped statement with a syntax error, already reported."""


Statement: TypeAlias = (
    Typedef
    | Declaration
    | TypeStatement
    | Namespace
    | Signature
    | Celltype
    | Cell
    | Composite
    | Region
    | Import
    | ImportC
    | Generate
    | ToolInformation
    | Skipped
)
"""Statements of a file, a name space, or (cells and regions) a region."""


Part: TypeAlias = (
    Function
    | Port
    | Attributes
    | Require
    | Factory
    | FactoryCall
    | Join
    | ReverseJoin
    | Export
    | EntryExport
)
"""Statements that are valid only inside another one."""


class Item(Spanned):
    """An entry of a list in braces, or of a file, with its specifiers."""

    specifiers: Specifiers | None
    node: Statement | Part

    def specifier(self, word: str) -> Specifier | None:
        """Return the first specifier with that keyword."""
        if self.specifiers is not None:
            for specifier in self.specifiers.items:
                if specifier.word == word:
                    return specifier
        return None
