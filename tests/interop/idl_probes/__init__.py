"""The probes by section of the language."""

from idl_probes import (
    constants,
    corba3,
    idl4,
    interfaces,
    lexical,
    names,
    pragmas,
    preprocessor,
    types,
)
from idl_probes.probe import Probe

SECTIONS: dict[str, list[Probe]] = {
    "lexical": lexical.PROBES,
    "preprocessor": preprocessor.PROBES,
    "pragmas": pragmas.PROBES,
    "names": names.PROBES,
    "types": types.PROBES,
    "interfaces": interfaces.PROBES,
    "constants": constants.PROBES,
    "corba3": corba3.PROBES,
    "idl4": idl4.PROBES,
}
"""Every probe, by section of the language."""
