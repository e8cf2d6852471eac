"""A naming service that answers wrongly: `wrong_naming_service.py FAULT`.

It writes its address, and ends with its input.
"""

from __future__ import annotations

import sys
from typing import Any

import CosNaming
import CosNaming__POA
from omniORB import CORBA

from rtgen.runtime.corba.iors import place

Raised = CosNaming.NamingContext


class Iterator(CosNaming__POA.BindingIterator):  # type: ignore[misc]
    """Has more names each time, and gives none."""

    def next_n(self, most: int) -> tuple[bool, list[Any]]:
        """See `CosNaming::BindingIterator`."""
        return True, []

    def destroy(self) -> None:
        """See `CosNaming::BindingIterator`."""


class Context(CosNaming__POA.NamingContext):  # type: ignore[misc]
    """A context with one of the faults."""

    def __init__(self, fault: str) -> None:
        self.fault = fault
        self.iterator = Iterator()

    def list(self, most: int) -> tuple[list[Any], Any]:
        """See `CosNaming::NamingContext`."""
        if self.fault == "raises":
            raise ValueError
        if self.fault == "no end":
            return [], self.iterator._this()
        words = [] if self.fault == "no name" else [CosNaming.NameComponent("a", "")]
        return [CosNaming.Binding(words, CosNaming.ncontext)], None

    def resolve(self, name: Any) -> Any:
        """See `CosNaming::NamingContext`."""
        if self.fault == "raises":
            raise ValueError
        if self.fault == "cannot proceed":
            raise Raised.CannotProceed(None, name)
        if self.fault == "endless depth":
            return Context(self.fault)._this()
        raise Raised.InvalidName


FAULTS = ("raises", "no end", "no name", "cannot proceed", "endless depth", "invalid")


def main(fault: str) -> None:
    """Run the process."""
    words = ["names", "-ORBendPoint", "giop:tcp:127.0.0.1:", "-ORBtraceLevel", "0"]
    orb = CORBA.ORB_init(words, CORBA.ORB_ID)
    orb.resolve_initial_references("RootPOA")._get_the_POAManager().activate()
    poa = orb.resolve_initial_references("omniINSPOA")
    root = Context(fault)
    poa.activate_object_with_id(b"NameService", root)
    poa._get_the_POAManager().activate()
    print(place(orb.object_to_string(root._this())), flush=True)
    sys.stdin.read()


if __name__ == "__main__":
    main(*sys.argv[1:])
