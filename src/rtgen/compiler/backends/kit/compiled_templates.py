"""Cache of compiled templates beside their sources, as Python caches compiled modules.

Compiling a template takes longer than rendering it. Nothing is written if Python would not write
bytecode; a read-only folder is ignored.
"""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path

import jinja2.compiler
from jinja2.bccache import Bucket, BytecodeCache

from rtgen.facts.files import open_file, write_atomically

_QUOTING = Path(__file__).parent / "quoting"


class CompiledTemplates(BytecodeCache):
    """The compiled templates of one environment.

    Jinja compares the text of a template itself; `environment` identifies everything else that the
    code depends on.
    """

    def __init__(self, folder: Path, environment: str) -> None:
        key = sha256(repr((environment, *_stamps())).encode()).hexdigest()[:16]
        self._folder = folder
        self._key = f"{sys.implementation.cache_tag}.{key}"

    def load_bytecode(self, bucket: Bucket) -> None:
        """See `BytecodeCache`."""
        with contextlib.suppress(OSError), open_file(self._file(bucket)) as stream:
            bucket.load_bytecode(stream)

    def dump_bytecode(self, bucket: Bucket) -> None:
        """See `BytecodeCache`."""
        if sys.dont_write_bytecode:
            return
        file = self._file(bucket)
        with contextlib.suppress(OSError):
            self._folder.mkdir(exist_ok=True)
            write_atomically(file, bucket.bytecode_to_string())

    def _file(self, bucket: Bucket) -> Path:
        return self._folder / f"{bucket.key}.{self._key}"


def _stamps() -> Iterator[tuple[str, int, int]]:
    """Yield name, time and size of the files that determine the code of a template."""
    here = Path(__file__)
    files = (here, here.with_name("rendering.py"), *sorted(_QUOTING.glob("*.py")))
    for file in (Path(jinja2.compiler.__file__), *files):
        status = file.stat()
        yield file.name, status.st_mtime_ns, status.st_size
