"""Nodes of the syntax tree for statements: name spaces, signatures, celltypes, cells, regions."""

from __future__ import annotations

from typing import TypeAlias

from rtgen.frontends.cdl.syntax.tree import (
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
from rtgen.frontends.kit.nodes import node


@node
class Namespace:
    """`namespace name { items }`."""

    name: Name
    items: tuple[Item, ...]
    start: int
    end: int


@node
class Function:
    """A function of a signature; its parameters are in the declarator."""

    type: QualifiedType
    declarator: Declarator
    start: int
    end: int


@node
class Signature:
    """`signature name { functions }`."""

    name: Name
    functions: tuple[Item, ...]
    start: int
    end: int


@node
class Port:
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


@node
class PortOf:
    """`cell.port` or `celltype.port`, with its subscript."""

    owner: ScopedName
    port: Name
    subscript: Subscript | None
    start: int
    end: int


@node
class Attributes:
    """`attr { ... }` and, as `keyword` says, `var { ... }`; each item is a `Declaration`."""

    keyword: str
    items: tuple[Item, ...]
    start: int
    end: int


@node
class Require:
    """`require target.port` or `require name = target.port`."""

    name: Name | None
    target: PortOf
    start: int
    end: int


@node
class Factory:
    """`factory { ... }`, or `FACTORY { ... }` as `keyword` says."""

    keyword: str
    items: tuple[Item, ...]
    start: int
    end: int


@node
class FactoryCall:
    """`write( file, format, arguments )`; arguments are names and strings."""

    function: Name
    file: Expression
    format: Expression
    arguments: tuple[Name | Text, ...]
    start: int
    end: int


@node
class Celltype:
    """`celltype name { ports, attributes, ... }`."""

    name: Name
    items: tuple[Item, ...]
    start: int
    end: int


@node
class Join:
    """`name[i] = value` in a cell: a join, or the value of an attribute.

    The target of a join is parsed as the expression `cell.port[i]`.
    """

    name: Name
    subscript: Subscript | None
    value: Initialiser | OfComposite
    start: int
    end: int


@node
class ReverseJoin:
    """`entry[i] <= cell.port[i]`."""

    name: Name
    subscript: Subscript | None
    target: PortOf
    start: int
    end: int


@node
class Export:
    """`port => composite.name` or `port => name` in an inner cell."""

    port: Name
    name: Name
    start: int
    end: int


@node
class EntryExport:
    """`composite.name => cell.entry` or `name => cell.entry` in a composite."""

    name: Name
    cell: Name
    port: Name
    start: int
    end: int


@node
class Cell:
    """`cell type name { joins }`; `joins` is None for a prototype, which has no body."""

    celltype: ScopedName
    name: Name
    joins: tuple[Item, ...] | None
    start: int
    end: int


@node
class Composite:
    """`composite name { ... }`."""

    name: Name
    items: tuple[Item, ...]
    start: int
    end: int


@node
class Region:
    """`region name { cells and regions }`."""

    name: Name
    items: tuple[Item, ...]
    start: int
    end: int


@node
class Import:
    """`import( "file" )`, or `import( <file> )` where `reused` is set; `path` is the name alone."""

    path: str
    reused: bool
    start: int
    end: int


@node
class ImportC:
    """`import_C( "header" )` or `import_C( "header", "definitions" )`."""

    header: Text
    definitions: Text | None
    start: int
    end: int


@node
class Generate:
    """`generate( plugin, target, "arguments" )`."""

    plugin: Name
    target: ScopedName
    argument: Text
    start: int
    end: int


@node
class ToolInformation:
    """`__tool_info__( "name" ) { ... }` and `__location_information__ { ... }`, both ignored."""

    keyword: str
    start: int
    end: int


@node
class Skipped:
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


@node
class Item:
    """An entry of a list in braces, or of a file, with its specifiers."""

    specifiers: Specifiers | None
    node: Statement | Part
    start: int
    end: int

    def specifier(self, word: str) -> Specifier | None:
        """The first specifier with that keyword."""
        if self.specifiers is not None:
            for specifier in self.specifiers.items:
                if specifier.word == word:
                    return specifier
        return None
