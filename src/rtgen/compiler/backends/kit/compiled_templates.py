"""The code of the templates, a module that is written when rtgen is packed.

Compiling a template takes longer than rendering it. A template is compiled when it is loaded if its
text, jinja's compiler or the quoting is not that of the code.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from hashlib import sha256
from importlib import import_module
from pathlib import Path
from textwrap import indent
from typing import Any

import jinja2.compiler
from jinja2 import Environment, FileSystemLoader, Template

from rtgen.facts.files import write_atomically

_HERE = Path(__file__).parent
_CODE = _HERE / "template_code.py"
_MODULE = f"{__package__}.{_CODE.stem}"
_HEAD = '''"""The code of the templates, made by jinja when rtgen was packed."""
# mypy: ignore-errors
'''


class CompiledLoader(FileSystemLoader):
    """Loads rtgen's templates."""

    def load(
        self,
        environment: Environment,
        name: str,
        globals: Any = None,  # noqa: A002 - the name in Jinja
    ) -> Template:
        """See `BaseLoader`."""
        source, filename, _ = self.get_source(environment, name)
        code = _code().get(_key(name, source))
        if code is None:
            return super().load(environment, name, globals)
        names = code(environment) | {"__file__": filename}
        return environment.template_class.from_module_dict(
            environment, names, globals or {}
        )


def write(environments: Mapping[str, Environment]) -> None:
    """Write the code of the templates of these names. Raises OSError."""
    parts = [_HEAD]
    keys = {}
    for number, (name, environment) in enumerate(environments.items()):
        assert environment.loader is not None
        source, _, _ = environment.loader.get_source(environment, name)
        code = environment.compile(source, name, raw=True)
        body = indent(f"{code}\nreturn locals()\n", "    ")
        parts.append(f"def template_{number}(environment):\n{body}")
        keys[_key(name, source)] = f"template_{number}"
    table = "".join(f'    "{key}": {function},\n' for key, function in keys.items())
    parts.append(f"CODE = {{\n{table}}}\n")
    write_atomically(_CODE, "\n\n".join(parts).encode())


@cache
def _code() -> dict[str, Callable[[Environment], dict[str, Any]]]:
    """Return the functions that define the code of templates, by their keys."""
    try:
        module = import_module(_MODULE)
    except ImportError:
        return {}
    code: dict[str, Callable[[Environment], dict[str, Any]]] = module.CODE
    return code


def _key(name: str, source: str) -> str:
    return sha256(f"{_compiler()}\0{name}\0{source}".encode()).hexdigest()[:32]


@cache
def _compiler() -> str:
    """Return the hash of the files that determine the code of a text."""
    files = (_HERE / "rendering.py", *sorted((_HERE / "quoting").glob("*.py")))
    digest = sha256()
    for file in (Path(jinja2.compiler.__file__), *files):
        digest.update(file.read_bytes())
    return digest.hexdigest()
