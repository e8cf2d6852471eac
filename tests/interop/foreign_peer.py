"""A process with omniidl's stubs only: its servant forwards each call to another object.

python foreign_peer.py FOLDER CORBALOC-OR-IOR

It calls that object by its stubs, writes the IOR of its own servant, and ends with its input.
"""

from __future__ import annotations

import sys
from typing import Any


def main(folder: str, reference: str) -> None:
    """Run the process."""
    sys.path.insert(0, folder)
    import Foreign
    import Foreign__POA
    from omniORB import CORBA

    words = ["peer", "-ORBendPoint", "giop:tcp:127.0.0.1:"]
    orb = CORBA.ORB_init([*words, "-ORBnativeCharCodeSet", "UTF-8"], CORBA.ORB_ID)
    other = orb.string_to_object(reference)._narrow(Foreign.Echo)

    def relayed(name: str) -> Any:
        def method(self: Any, *arguments: Any) -> Any:
            return getattr(other, name)(*arguments)

        return method

    names = Foreign__POA.Echo._omni_op_d
    relay = type("Relay", (Foreign__POA.Echo,), {name: relayed(name) for name in names})
    servant = relay()
    orb.resolve_initial_references("RootPOA")._get_the_POAManager().activate()
    print(orb.object_to_string(servant._this()), flush=True)
    sys.stdin.read()


if __name__ == "__main__":
    main(*sys.argv[1:])
