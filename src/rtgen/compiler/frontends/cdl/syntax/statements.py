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
from rtgen.compiler.frontends.kit.nodes import Node


class Namespace(Node):
    """`namespace name { items }`."""

    name: Name
    items: tuple[Item, ...]
    start: int
    end: int


class Function(Node):
    """A function of a signature; its parameters are in the declarator."""

    type: QualifiedType
    declarator: Declarator
    start: int
    end: int


class Signature(Node):
    """`signature name { functions }`."""

    name: Name
    functions: tuple[Item, ...]
    start: int
    end: int


class Port(Node):
    """`call signature name[size]` and `entry signature name`.

    `subscript` is that of an array; `target` is the port in `<= celltype.port`.
    """

    kind: str
    signature: ScopedName
    name: Name
    subscript: Subscript | None
    target: PortOf | None
    start: int
    end: int


class PortOf(Node):
    """`cell.port` or `celltype.port`, with its subscript."""

    owner: ScopedName
    port: Name
    subscript: Subscript | None
    start: int
    end: int


class Attributes(Node):
    """`attr { ... }` and, as `keyword` says, `var { ... }`; each item is a `Declaration`."""

    keyword: str
    items: tuple[Item, ...]
    start: int
    end: int


class Require(Node):
    """`require target.port` or `require name = target.port`."""

    name: Name | None
    target: PortOf
    start: int
    end: int


class Factory(Node):
    """`factory { ... }`, or `FACTORY { ... }` as `keyword` says."""

    keyword: str
    items: tuple[Item, ...]
    start: int
    end: int


class FactoryCall(Node):
    """`write( file, format, arguments )`; arguments are names and strings."""

    function: Name
    file: Expression
    format: Expression
    arguments: tuple[Name | Text, ...]
    start: int
    end: int


class Celltype(Node):
    """`celltype name { ports, attributes, ... }`."""

    name: Name
    items: tuple[Item, ...]
    start: int
    end: int


class Join(Node):
    """`name[i] = value` in a cell: a join, or the value of an attribute.

    The target of a join is parsed as the expression `cell.port[i]`.
    """

    name: Name
    subscript: Subscript | None
    value: Initialiser | OfComposite
    start: int
    end: int


class ReverseJoin(Node):
    """`entry[i] <= cell.port[i]`."""

    name: Name
    subscript: Subscript | None
    target: PortOf
    start: int
    end: int


class Export(Node):
    """`port => composite.name` or `port => name` in an inner cell."""

    port: Name
    name: Name
    start: int
    end: int


class EntryExport(Node):
    """`composite.name => cell.entry` or `name => cell.entry` in a composite."""

    name: Name
    cell: Name
    port: Name
    start: int
    end: int


class Cell(Node):
    """`cell type name { joins }`; `joins` is None for a prototype, which has no body."""

    celltype: ScopedName
    name: Name
    joins: tuple[Item, ...] | None
    start: int
    end: int


class Composite(Node):
    """`composite name { ... }`."""

    name: Name
    items: tuple[Item, ...]
    start: int
    end: int


class Region(Node):
    """`region name { cells and regions }`."""

    name: Name
    items: tuple[Item, ...]
    start: int
    end: int


class Import(Node):
    """`import( "file" )`, or `import( <file> )` where `reused` is set; `path` is the name alone."""

    path: str
    reused: bool
    start: int
    end: int


class ImportC(Node):
    """`import_C( "header" )` or `import_C( "header", "definitions" )`."""

    header: Text
    definitions: Text | None
    start: int
    end: int


class Generate(Node):
    """`generate( plugin, target, "arguments" )`."""

    plugin: Name
    target: ScopedName
    argument: Text
    start: int
    end: int


class ToolInformation(Node):
    """`__tool_info__( "name" ) { ... }` and `__location_information__ { ... }`, both ignored."""

    keyword: str
    start: int
    end: int


class Skipped(Node):
    """A skipped statement with a syntax error, already reported."""

    start: int
    end: int


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


class Item(Node):
    """An entry of a list in braces, or of a file, with its specifiers."""

    specifiers: Specifiers | None
    node: Statement | Part
    start: int
    end: int

    def specifier(self, word: str) -> Specifier | None:
        """Return the first specifier with that keyword."""
        if self.specifiers is not None:
            for specifier in self.specifiers.items:
                if specifier.word == word:
                    return specifier
        return None
