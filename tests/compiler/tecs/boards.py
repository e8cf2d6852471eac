"""CDL files with joins through RTCPlugin, and rtgen's output for them, written and imported."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

from rtgen.compiler.backends import Artifact, Emission, Options, Owner
from rtgen.compiler.backends.stage import BUILT_IN, together
from rtgen.compiler.diagnostics import Diagnostic, has_errors
from rtgen.compiler.frontends.cdl import load
from rtgen.compiler.lowering.settings import Settings
from rtgen.compiler.lowering.stage import lowered
from rtgen.compiler.model import Model

SERVER = """\
signature sServer {
  ER func1( [in] int32_t indata );
  ER func2( [out] char_t *outdata );
  ER func3( [in] int64_t indata, [inout] uint32_t *iodata );
};
"""
"""The signature of the paper's Figure 8."""

MOTOR = """\
const int32_t WHEELS = 2;
namespace nBoard {
  const float32_t GAIN = 1.5;
  const double64_t FAR = 1.5e300;
  const bool_t GEARED = true;
  const char_t MARK = 'm';
  typedef int16_t Level;
  struct tagPoint { int16_t x; int32_t y; };
  typedef struct tagPoint Point;
  struct tagState {
    Level level; int8_t sign; char_t code; char_t label[4]; int8_t raw[3]; uint8_t grid[2][3];
    [string(8)] char_t *nick; struct tagPoint at; [size_is(count)] int8_t *data; int8_t count;
  };
  signature sMotor {
    ER set( [in] Level level, [in] int8_t sign, [in,size_is(n)] const char_t *text,
            [in,size_is(n)] const int8_t *raw, [in] int32_t n );
    Level get( void );
    ER state( [in] const struct tagState *given, [out] struct tagState *state );
    ER maybe( [in,nullable] const int8_t *in8, [inout,nullable] char_t *letter,
              [in,nullable] const Point *point, [out,nullable] int32_t *out32 );
    ER names( [in,size_is(n),string(12)] const char_t **list, [in] int32_t n,
              [out,string(24)] char_t *joined, [in,string] const uint16_t *wide,
              [in,count_is(n),nullable] const int8_t *marks );
    ER part( [in,size_is(n,8)] const Point *points, [in] uint8_t n, [out] Point *sum,
             [out,size_is(3)] bool_t *flags );
    long_t wide( [in] const uint8_t grid[2][3], [out,size_is(4)] char_t *label );
    [oneway] void stop( [in] uchar_t why );
    [oneway] ER stop_all( void );
    ER bytes( [in] Point tagPoint, [in] Point nBoard_tagPoint, [in] int8_t RpcError,
              [in,nullable] const int8_t *RpcError_in, [in] int8_t codec_nBoard_tagPoint,
              [out] Point *outs, [inout,nullable] int8_t *outs_out );
    void list( [in] int8_t handlers );
    void __init__( void );
    void class( [in] int32_t None, [in] int32_t any, [in] int32_t self, [in] int32_t Self,
                [out] uint8_t *out );
  };
};
"""
"""Structs, arrays, strings, name spaces, names with a meaning in IDL or Python."""


def joined(text: str, *signatures: str, options: str = "") -> str:
    """Return the text with a client of each signature's server, joined through the plug-in."""
    parts = [text]
    for number, signature in enumerate(signatures):
        parts.append(f"""\
celltype tServer{number} {{ entry {signature} eServer; }};
[active] celltype tClient{number} {{ call {signature} cServer; }};
cell tServer{number} Server{number} {{}};
cell tClient{number} Client{number} {{
  [through(RTCPlugin,"{options}")]
  cServer = Server{number}.eServer;
}};
""")
    return "".join(parts)


def emit(
    folder: Path, files: dict[str, str], *, corba: bool = False
) -> tuple[Emission, list[Diagnostic]]:
    """Return the output of the back end for CDL files, and all findings but notes."""
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    read = load([folder / name for name in files], root=folder)
    assert not has_errors(read.diagnostics), read.diagnostics
    return emitted(read.model, corba=corba)


def emitted(model: Model, *, corba: bool = False) -> tuple[Emission, list[Diagnostic]]:
    """Return the output of the back ends for the model of CDL files, and the findings."""
    made = lowered(model, Settings())
    findings = list(made.diagnostics)
    options = Options("robots", "nodes", "0.1.0", tecs_corba=corba)
    backends = () if has_errors(findings) else BUILT_IN
    emission = together(backend.emit(made.model, options) for backend in backends)
    findings += emission.diagnostics
    if has_errors(findings):
        emission = Emission((), findings)
    return emission, findings


def texts(artifacts: Sequence[Artifact]) -> dict[str, str]:
    """Return texts by path; skeletons are in a package beside the generated one, `nodes`."""
    folders = {Owner.RTGEN: "", Owner.USER: "nodes/"}
    return {f"{folders[a.owner]}{a.path}": a.text for a in artifacts}


def write(folder: Path, artifacts: Sequence[Artifact]) -> None:
    """Write the files below the folder."""
    for path, text in texts(artifacts).items():
        file = folder / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")


@contextmanager
def imported(folder: Path, *names: str) -> Iterator[list[ModuleType]]:
    """Import the generated package and the skeletons, apart from others of these names."""

    def take() -> dict[str, ModuleType]:
        found = [n for n in sys.modules if n.partition(".")[0] in ("robots", "nodes")]
        return {name: sys.modules.pop(name) for name in found}

    before = take()
    sys.path.insert(0, str(folder))
    try:
        importlib.invalidate_caches()
        yield [importlib.import_module(name) for name in names]
    finally:
        sys.path.remove(str(folder))
        take()
        sys.modules.update(before)
