"""Definitions whose names are words of Python, of the runtime, or of generated code."""

from __future__ import annotations

import builtins
import keyword
import re
import sys
from collections.abc import Iterator, Sequence
from contextlib import chdir
from functools import cache
from pathlib import Path
from random import Random

from fuzzing import ViolationError
from generated import Generated, forgotten_types

from rtgen.compiler.backends import Owner
from rtgen.compiler.compilation import compile_project
from rtgen.compiler.diagnostics.report import report
from rtgen.compiler.project import load

ROOT = Path(__file__).parents[2]
_TARGETS = ("embedded", "openrtm", "small")
_WORD = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_MADE = (
    "{}_",
    "{}Stub",
    "{}Base",
    "{}Codec",
    "{}Configuration",
    "{}Client",
    "{}_v",
    "I{}",
)
_FEW = """
    sw_v class_var exception self cls sException sList sSelf sStub sServant tRTC init del
    type value data name size count index length key item other result error struct union enum
"""
_PROJECT = """[sources]
paths = ["{path}"]
[output]
package = "fuzzed"
target = "{target}"
"""


@cache
def _core() -> Sequence[str]:
    """Return keywords, builtins, and the words of the templates."""
    words = {*keyword.kwlist, *keyword.softkwlist, *dir(builtins), *_FEW.split()}
    for path in sorted(ROOT.glob("src/rtgen/templates/**/*.py.j2")):
        words.update(_WORD.findall(path.read_text()))
    return sorted(w for w in words if not w.startswith("_"))


@cache
def _pool() -> Sequence[str]:
    """Return keywords, builtins, and every word that rtgen generates here."""
    words = {*keyword.kwlist, *keyword.softkwlist, *dir(builtins), *dir(object)}
    words |= {*sys.stdlib_module_names}
    for pattern in (
        "generated/refrobots/_idl/*.py",
        "generated/refrobots/components/odometry/*.py",
        "generated/refrobots/canopen/*.py",
        "generated/refrobots/components/epos_drive_*/*.py",
        "generated/refrobots/eposdrive/*.py",
        "generated/refrobots/tecs/**/*.py",
        "src/rtgen/templates/**/*.j2",
        "runtime/src/rtgen/runtime/rtc/component.py",
    ):
        for path in sorted(ROOT.glob(pattern)):
            words.update(_WORD.findall(path.read_text()))
    return sorted(w for w in words if len(w) < 40 and not w.startswith("_"))


class _Names:
    """Draws names; no two names of a definition are equal, ignoring case."""

    def __init__(self, number: int) -> None:
        self._chance = Random(number)
        self._taken: set[str] = set()
        self._usual = self._chance.random()

    def name(self) -> str:
        """Return an unused name."""
        while True:
            usual = self._chance.random() < 0.7
            name = self._chance.choice(_core() if usual else _pool())
            if self._chance.random() < 0.15:
                name = self._chance.choice(_MADE).format(name)
            if name.lower() not in self._taken:
                self._taken.add(name.lower())
                return name


def _idl(n: _Names) -> str:
    m, s, e, u, x, i, t, c = (f"_{n.name()}" for _ in range(8))
    a, b, d, f, g, h = (f"_{n.name()}" for _ in range(6))
    p, q, r, o = (f"_{n.name()}" for _ in range(4))
    k1, k2, k3 = (f"_{n.name()}" for _ in range(3))
    return f"""
module {m} {{
    struct {s} {{ long {a}; string {b}; sequence<long> {d}; }};
    enum {e} {{ {f}, {g} }};
    union {u} switch ({e}) {{ case {f}: long {h}; default: {s} {a}; }};
    exception {x} {{ string {b}; }};
    typedef sequence<{s}> {t};
    const long {k1} = 3;
    interface {i} {{
        struct {k2} {{ long {k3}; }};
        attribute long {p};
        {s} {q}(in long {a}, out {t} {b}, inout {e} {h}) raises ({x});
    }};
    interface {o} : {i} {{ oneway void {r}(in double {d}); }};
}};
component {c} {{
    publishes {m}::{s} {n.name()}_o;
    consumes {m}::{u} {h};
    provides {m}::{o} {p};
    uses {m}::{i} {q};
    attribute long {a};
    attribute string {b};
    attribute {m}::{e} {d};
    attribute sequence<double> {r};
}};
"""


def _cdl(n: _Names) -> str:
    s, sig, ct, cu, tag = (n.name() for _ in range(5))
    a, b, c, f, g, h = (n.name() for _ in range(6))
    cell, user, client, const, alias = (n.name() for _ in range(5))
    return f"""
const int32_t {const} = 3;
typedef int16_t {alias};
struct {tag} {{ int32_t {a}; double64_t {b}[2]; {alias} {c}; }};
signature {sig} {{
    ER {f}( [in] int32_t {a}, [out] struct {tag} *{b} );
    int32_t {g}( [in,size_is({c})] const int32_t *{a}, [in] int32_t {c}, [inout] int32_t *{h} );
    [oneway] void {h}( [in,string] const char_t *{s} );
}};
celltype t{ct} {{ entry {sig} {a}; }};
[active] celltype t{cu} {{ call {sig} {b}; }};
region rBoard {{ cell t{ct} {cell} {{ }}; }};
[to_through( rBoard, RTCPlugin, "name={client}" )]
region rPc {{ cell t{cu} {user} {{ {b} = rBoard::{cell}.{a}; }}; }};
"""


def _eds(n: _Names) -> str:
    from hostile_definitions import eds

    class Texts:
        def text(self, **_options: bool) -> str:
            return n.name()

    files = eds(Texts(), 1)  # type: ignore[arg-type]
    return files["eds/part0.eds"]


_MAKERS = {"idl": _idl, "cdl": _cdl, "eds": _eds}


class NamesTarget:
    """Each case is one definition; all its generated code is imported."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def make(self, number: int) -> bytes:
        """Return the definition file."""
        names = _Names(number)
        return _MAKERS[_language(number)](names).encode()

    def check(self, number: int, data: bytes) -> Iterator[str]:
        """Generate and import; a refused definition must have errors."""
        if number < 0:
            return
        language = _language(number)
        target = _TARGETS[number // len(_MAKERS) % len(_TARGETS)]
        root = self._folder
        path = root / f"input.{language}"
        path.write_bytes(data)
        (root / "rtgen.toml").write_text(_PROJECT.format(path=path.name, target=target))
        with chdir(root):
            run = compile_project(load())
        path.unlink()
        report(run.diagnostics, run.sources)
        yield f"{language} {target}"
        if run.failed:
            yield "refused"
            yield from {f"{language} {d.code}" for d in run.diagnostics}
            return
        texts = {}
        for artifact in run.artifacts:
            if artifact.path.endswith(".py"):
                compile(artifact.text, artifact.path, "exec", dont_inherit=True)
                ours = artifact.owner is Owner.RTGEN and artifact.path.startswith(
                    "fuzzed/"
                )
                if ours:
                    texts[artifact.path] = str(artifact.text)
        if not texts:
            raise ViolationError("nothing was made")
        try:
            with forgotten_types():
                Generated(texts).load()
        finally:
            for name in [n for n in sys.modules if n.partition(".")[0] == "fuzzed"]:
                del sys.modules[name]
        yield "made"


def _language(number: int) -> str:
    return tuple(_MAKERS)[number % len(_MAKERS)]
