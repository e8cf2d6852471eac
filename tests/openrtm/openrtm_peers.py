"""Values and calls of omniORB's side, converted by octets."""

from __future__ import annotations

import importlib
import sys
from functools import reduce
from pathlib import Path
from typing import Any

import omniORB
from omniORB import CORBA, cdrMarshal, cdrUnmarshal, tcInternal
from probes import answer
from specimens import specimen

from rtgen.runtime.services.calls import Call, calls_of


def load_stubs(folder: Path) -> None:
    """Import omniidl's modules of a folder; new names are added to already loaded modules."""
    sys.path.append(str(folder))
    for file in sorted(folder.glob("*_idl.py")):
        importlib.import_module(file.stem)


def wire(value: Any) -> Any:
    """Return omniORB's value of rtgen's, converted by octets."""
    code = CORBA.TypeCode(value._descriptor_.repository_id)
    return cdrUnmarshal(code, value.to_cdr(), True)


def octets(value: Any) -> bytes:
    """Return the octets of a value of omniORB. Padding is not zero."""
    body: bytes = cdrMarshal(CORBA.TypeCode(CORBA.id(type(value))), value, True)
    return body


def interface_of(interface: Any) -> Any:
    """Return omniORB's class of references to an interface."""
    names = interface._descriptor_.name.split("::")
    first = names[0] if len(names) > 1 else "_GlobalIDL"
    rest = names[1:] if len(names) > 1 else names
    return reduce(getattr, rest, importlib.import_module(first))


class Record:
    """Arguments or results, as if they were the members of a struct."""

    def __init__(self, *values: Any) -> None:
        for place, value in enumerate(values):
            setattr(self, f"m{place}", value)
        self.values = values


def _code(types: Any) -> Any:
    members = [
        each for place, type_ in enumerate(types) for each in (f"m{place}", type_)
    ]
    described = (tcInternal.tv_struct, Record, "IDL:Record:1.0", "Record", *members)
    return tcInternal.createTypeCode(described)


def unpacked(types: Any, record: Any) -> list[Any]:
    """Return omniORB's values of the members of a request or reply."""
    if record is None:
        return []
    return list(cdrUnmarshal(_code(types), record.to_cdr(), True).values)


def packed(kind: Any, types: Any, values: Any) -> Any:
    """Return a request or reply with omniORB's values."""
    if kind is None:
        return None
    return kind.from_cdr(cdrMarshal(_code(types), Record(*values), True))


def of(kind: Any, number: int) -> Any:
    """Return the specimen of a request or reply."""
    return None if kind is None else specimen(kind._descriptor_, number)


def described(interface: Any, operation: str) -> tuple[Any, Any]:
    """Return omniORB's types of arguments and of results of an operation."""
    arguments, results, *_ = getattr(interface_of(interface), f"_d_{operation}")
    return arguments, results or ()


def raised_by(call: Call, error: Any) -> Any:
    """Return rtgen's exception for omniORB's."""
    for _, kind in call.raises:
        descriptor = kind._descriptor_
        if descriptor.repository_id == error._NP_RepositoryId:
            members = omniORB.findType(descriptor.repository_id)[4:]
            values = [getattr(error, name) for name in members[::2]]
            record = cdrMarshal(_code(members[1::2]), Record(*values), True)
            return kind.from_cdr(record)
    raise error


def to_be_raised(error: Any) -> Exception:
    """Return omniORB's exception for rtgen's."""
    descriptor = omniORB.findType(error._descriptor_.repository_id)
    record = cdrUnmarshal(_code(descriptor[5::2]), error.to_cdr(), True)
    made: Exception = descriptor[1](*record.values)
    return made


def outcomes(call: Call) -> int:
    """Return the number of outcomes of a call: its result, and its exceptions."""
    return 1 + len(call.raises)


def number_of_calls(interface: Any) -> int:
    """Return the number of outcomes of all operations."""
    return sum(outcomes(call) for call in calls_of(interface).values())


def check_requests(interface: Any, found: list[tuple[str, str]]) -> None:
    """Check that the servant received what the caller sent, as octets.

    A oneway call may arrive after later calls.
    """
    assert sorted(found) == sorted(
        (operation, _hex(of(call.request, number)))
        for operation, call in calls_of(interface).items()
        for number in range(outcomes(call))
    )


def check_outcomes(interface: Any, found: list[tuple[str, tuple[str, str]]]) -> None:
    """Check that the caller received what the servant answered, as octets."""
    expected = []
    for operation, call in calls_of(interface).items():
        expected.append((operation, ("", _hex(of(call.reply, 0)))))
        for number, (_, kind) in enumerate(call.raises, 1):
            raised = specimen(kind._descriptor_, number)
            expected.append((operation, (kind.__name__, _hex(raised))))
    assert found == expected


def _hex(value: Any) -> str:
    return "" if value is None else value.to_cdr().hex()


def call_all(interface: Any, reference: Any) -> None:
    """Call each operation of a provider once for each outcome, and check the results."""
    for operation, call in calls_of(interface).items():
        sent, received = described(interface, operation)
        for number in range(outcomes(call)):
            arguments = unpacked(sent, of(call.request, number))
            try:
                result = getattr(reference, operation)(*arguments)
            except CORBA.UserException as error:
                expected = specimen(call.raises[number - 1][1]._descriptor_, number)
                found = raised_by(call, error)
                assert number, operation
                assert type(found) is type(expected)
                assert found.to_cdr() == expected.to_cdr(), operation
            else:
                assert number == 0, operation
                values = result if len(received) > 1 else [result]
                assert packed(call.reply, received, values) == of(call.reply, number)


def servant(interface: Any) -> tuple[Any, list[tuple[str, str]]]:
    """Return a servant of omniORB, and the requests it received, as octets of rtgen's codecs."""
    skeleton = omniORB.skeletonMapping[interface._descriptor_.repository_id]
    taken: list[tuple[str, str]] = []
    calls = calls_of(interface)
    own = {name: _served(interface, name, call, taken) for name, call in calls.items()}
    return type("Servant", (skeleton,), own)(), taken


def _served(interface: Any, operation: str, call: Call, taken: list[Any]) -> Any:
    sent, received = described(interface, operation)

    def served(self: Any, *arguments: Any) -> Any:
        number = sum(name == operation for name, _ in taken)
        taken.append((operation, _hex(packed(call.request, sent, arguments))))
        try:
            answer(call, number)
        except tuple(kind for _, kind in call.raises) as error:
            raise to_be_raised(error) from error
        values = unpacked(received, of(call.reply, number))
        if not values:
            return None
        return values[0] if len(values) == 1 else tuple(values)

    return served
