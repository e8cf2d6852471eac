"""A process with omniORB's or another code set: `code_set_peer.py - | CODE_SET`.

It serves a configuration and a service (`Notes` below), writes their IORs, and ends with its input.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import Any

sys.path.append(str(Path(__file__).parents[2] / "compiler" / "types"))

import emitted
from omniORB import CORBA

from rtgen.runtime.corba.objects import Objects
from rtgen.runtime.corba.orb import Orb
from rtgen.runtime.corba.rt_objects.objects import Exported
from rtgen.runtime.corba.rt_objects.wire import CONFIGURATION

IDL = """
module Noting {
    struct Note { string text; sequence<string> words; };
    interface Notes { string keep(in Note given); };
};
"""


class Configuration:
    """Takes every set."""

    def set_configuration_set_values(self, given: Any) -> bool:
        """See `SDOPackage::Configuration`."""
        return True


def main(code_set: str) -> None:
    """Run the process."""
    words = ["peer", "-ORBendPoint", "giop:tcp:127.0.0.1:"]
    if code_set != "-":
        words += ["-ORBnativeCharCodeSet", code_set]
    CORBA.ORB_init(words, CORBA.ORB_ID)
    orb = Orb()
    exported, objects = Exported(orb), Objects(orb)
    with tempfile.TemporaryDirectory() as folder:
        package = emitted.emit_text(Path(folder), IDL)
    notes = objects.serve(
        package.noting.Notes, lambda name, arguments: arguments[0].text
    )
    print(exported.text(exported.serve(CONFIGURATION, Configuration())))
    print(exported.text(notes), flush=True)
    sys.stdin.read()


if __name__ == "__main__":
    main(*sys.argv[1:])
