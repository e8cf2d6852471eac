"""IDL files that ship with rtgen, which definitions can include without having a copy."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from functools import partial
from hashlib import sha256
from pathlib import Path

from rtgen.compiler.frontends import Dependency
from rtgen.compiler.frontends.kit.library import VirtualFile
from rtgen.compiler.kit.resources import IDL_FILES, idl_file, idl_key, idl_source
from rtgen.compiler.model import SourceFile


def shipped(
    definitions: Sequence[Path], needed: Collection[str]
) -> dict[str, VirtualFile | Path]:
    """Return the files by name: the one among `definitions`, else rtgen's.

    The files in `needed` are always read, others when they are included.
    """
    own = {path.name: path for path in definitions}
    return {
        name: own.get(name)
        or VirtualFile(idl_key(name), partial(idl_source, name), given=name in needed)
        for name in IDL_FILES
    }


def dependencies(files: Sequence[SourceFile]) -> Iterator[Dependency]:
    """Yield the dependencies on those of the files that ship with rtgen."""
    keys = {file.key for file in files}
    for name in IDL_FILES:
        if idl_key(name) in keys:
            path = idl_file(name)
            yield Dependency(path, sha256(path.read_bytes()).hexdigest())
