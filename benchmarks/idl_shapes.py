"""IDL files for `idl.py`: a large one, and others of different shapes.

Each is a dict of file names and texts; the first file is read.
"""

from __future__ import annotations

from collections.abc import Iterator

STRUCTS, ENUMS, EXCEPTIONS, INTERFACES = 2000, 200, 100, 100
TYPES = (
    *("double", "long", "unsigned short", "float", "octet", "boolean", "string"),
    *("long long", "char", "sequence<double>", "sequence<octet>", "string<16>"),
)


def synthetic() -> str:
    """Return a module of 2,000 structs, 200 enums, 100 exceptions and 100 interfaces.

    Structs have 8 members.
    """
    lines = ["module Synthetic {"]
    for number in range(STRUCTS):
        if number % (STRUCTS // ENUMS) == 0:
            lines += _enum(number // (STRUCTS // ENUMS))
        lines += _struct(number)
        if number % (STRUCTS // INTERFACES) == 0:
            lines += _interface(number // (STRUCTS // INTERFACES), number)
    return "\n".join([*lines, "};", ""])


def _enum(number: int) -> Iterator[str]:
    names = ", ".join(f"STATE_{number}_{i}" for i in range(5))
    yield f"  enum Mode{number} {{ {names} }};"


def _struct(number: int) -> Iterator[str]:
    yield f"  struct Record{number} {{"
    for member in range(8):
        kind = (number * 7 + member * 5) % (len(TYPES) + 3)
        if kind < len(TYPES):
            yield f"    {TYPES[kind]} field_{member};"
        elif kind == len(TYPES) or not number:
            yield f"    Mode{number // 10} field_{member};"
        elif kind == len(TYPES) + 1:
            yield f"    Record{number - 1} field_{member};"
        else:
            yield f"    sequence<Record{number - 1}> field_{member};"
    yield "  };"


def _interface(number: int, struct: int) -> Iterator[str]:
    yield f"  exception Failure{number} {{"
    yield "    string reason;"
    yield "    long code;"
    yield "  };"
    yield ""
    yield f"  interface Service{number} {{"
    yield f"    readonly attribute Mode{struct // 10} mode;"
    yield "    attribute double rate;"
    yield f"    Record{struct} get(in long index) raises (Failure{number});"
    yield f"    void put(in long index, in Record{struct} value);"
    yield "    oneway void notify(in string text);"
    yield "    boolean ready();"
    yield "  };"
    yield ""


DEPTH, EACH = 90, 20


def deep_includes() -> dict[str, str]:
    """Return 90 files, each of which includes the next two; 20 structs in each."""
    return {f"deep{n}.idl": "\n".join(_included(n)) for n in range(DEPTH)}


def _included(number: int) -> Iterator[str]:
    yield f"#ifndef DEEP_{number}"
    yield f"#define DEEP_{number}"
    for other in (number + 1, number + 2):
        if other < DEPTH:
            yield f'#include "deep{other}.idl"'
    yield f"module Deep{number} {{"
    for struct in range(EACH):
        yield f"  struct Part{struct} {{"
        yield "    long stamp;"
        yield "    sequence<double> values;"
        if number + 1 < DEPTH:
            yield f"    Deep{number + 1}::Part{struct} inner;"
        yield "  };"
    yield "};"
    yield "#endif"
    yield ""


def comments() -> dict[str, str]:
    """Return 600 structs of 6 members, with comments of five lines above and one behind members."""
    lines = ["module Spoken {"]
    for number in range(600):
        lines += ["  /**", f"   * The record of number {number}."]
        lines += [f"   * Line {i} of what there is to say about it." for i in range(3)]
        lines += ["   */", f"  struct Record{number} {{"]
        for member in range(6):
            lines += [
                f"    // Read in cycle {member}; what it means depends on the mode.",
                f"    {TYPES[member]} field_{member};  ///< [m] member {member}",
            ]
        lines.append("  };")
    return {"comments.idl": "\n".join([*lines, "};", ""])}


def long_structs() -> dict[str, str]:
    """Return 20 structs of 500 members."""
    lines = ["module Wide {"]
    for number in range(20):
        lines.append(f"  struct Table{number} {{")
        for member in range(500):
            type_ = TYPES[(number + 5 * member) % len(TYPES)]
            lines.append(f"    {type_} column_{member};")
        lines.append("  };")
    return {"long_structs.idl": "\n".join([*lines, "};", ""])}


def services() -> dict[str, str]:
    """Return 300 interfaces of 10 operations with an exception each, and no struct."""
    lines = ["module Services {"]
    for number in range(300):
        lines += [f"  exception Failed{number} {{ string reason; }};"]
        lines.append(f"  interface Service{number} {{")
        for operation in range(10):
            type_ = TYPES[operation % 9]
            given = f"in {type_} value, in long index, out string text"
            lines.append(
                f"    {type_} call_{operation}({given}) raises (Failed{number});"
            )
        lines.append("  };")
    return {"services.idl": "\n".join([*lines, "};", ""])}


SHAPES = {
    "synthetic": lambda: {"synthetic.idl": synthetic()},
    "deep includes": deep_includes,
    "comments": comments,
    "long structs": long_structs,
    "services": services,
}
"""The shapes by name."""
