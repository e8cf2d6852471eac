"""Imports omniidl's stubs, also for types that OpenRTM has, too."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable
from importlib import import_module
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from pathlib import Path

from rtgen.facts.files import read_file
from rtgen.runtime.errors import RtcError

SCRIPT = "idlcompile.sh"
"""The script in a component's folder that generates its stubs."""

_REPOSITORY_ID = re.compile(r'_NP_RepositoryId = "([^"]+)"')


class StubsMissingError(RtcError):
    """Stubs of omniidl are missing, or do not contain a type."""

    def __init__(self, missing: str) -> None:
        super().__init__(
            f"there is no stub of {missing}; run {SCRIPT} in the component's folder"
        )


def load(folder: Path | str, stems: Iterable[str]) -> None:
    """Import the stubs of the IDL files with these stems, each after its includes.

    OpenRTM is imported first, if installed, and the folder is the last of `sys.path`: an IDL file
    may reopen the module RTC, or declare interfaces outside of modules, and the resulting package
    `RTC` or `_GlobalIDL` in the folder must not hide OpenRTM's. The stubs are also found if another
    module, such as the component's own file, has the name of an IDL module; if OpenRTM has an IDL
    file of the same name, both are loaded. Raises StubsMissingError.
    """
    if find_spec("OpenRTM_aist") is not None:
        import_module("OpenRTM_aist")
    path = str(Path(folder).resolve())
    if path not in sys.path:
        sys.path.append(path)
    for stem in stems:
        name = f"{stem}_idl"
        try:
            module = import_module(name)
        except ModuleNotFoundError as error:
            if error.name != name:
                raise
            raise StubsMissingError(f"{stem}.idl in {path}") from error
        file = Path(path, f"{name}.py")
        if module.__file__ != str(file) and file.is_file():
            _load_beside(name, file)
    _claim(path)


def _load_beside(name: str, file: Path) -> None:
    """Load stubs, unless their types are known because another file has the same module name."""
    import omniORB

    ids = _REPOSITORY_ID.findall(read_file(file).decode("utf-8", "replace"))
    if all(omniORB.findType(each) is not None for each in ids):
        return
    spec = spec_from_file_location(f"{name} of {file.parent}", file)
    assert spec is not None, "a file that is there"
    assert spec.loader is not None
    spec.loader.exec_module(module_from_spec(spec))


def _claim(folder: str) -> None:
    """Reserve the names of the folder's packages that an import would find elsewhere."""
    import omniORB

    for package in sorted(Path(folder).glob("*/__init__.py")):
        name = package.parent.name
        # omniORB keeps these until the package is imported
        if name in omniORB._partialModules and not _is_stub(name):
            omniORB.promotePartialModule(name)


def _is_stub(name: str) -> bool:
    """Return whether an import would find omniidl's package, with stubs beside it."""
    spec = find_spec(name)
    if spec is None or spec.origin is None:
        return False
    return any(Path(spec.origin).parent.parent.glob("*_idl.py"))
