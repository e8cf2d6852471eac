"""The rules of `RTCPlugin`: its options, and what can become an interface (CDL10xx)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

UNKNOWN_OPTION = Rule(
    "CDL1001",
    "unknown option of RTCPlugin",
    Severity.ERROR,
    """\
The argument of `RTCPlugin` has an option that neither rtgen nor tecsgen's `OpaqueRPCPlugin`
knows:

```
[through(RTCPlugin, "prot=8931")]      // CDL1001
cServer = Server.eServer;
```

| option | default | |
|---|---|---|
| `tdr` | `network` | byte order: `network`, `little`, `big` (the latter two: `tTDR`) |
| `reply` | `tecsgen` | of a reply: `tecsgen` (return value first), `paper` (last) |
| `longBits`, `intptrBits` | 32; 64 unless `network` | width of `long`, `intptr_t` on the wire |
| `shortBits`, `intBits` | 16, 32 | width of `short` and `int` |
| `address`, `port` | `127.0.0.1`, 8931 and the number of the join | where the board listens |
| `device`, `baudrate` | none, 115200 | the serial line; with `device` it is the active one |
| `timeout` | 1.0 | seconds that a call may take |
| `encoding` | `latin-1` | the encoding of strings |
| `array` | `sequence` | what an array is in IDL: `sequence`, or `any` |
| `name` | `OpaqueRpcCommunication<n>` | instance name of the communication RTC |
| `PPAllocatorSize` | 4096 | bytes that one request may need in the server |

The options of tecsgen's `OpaqueRPCPlugin` (`taskPriority`, `stackSize`, ...) are left to tecsgen.
""",
)

BAD_OPTION = Rule(
    "CDL1002",
    "value that an option of RTCPlugin cannot have",
    Severity.ERROR,
    """\
Each option has a type and a range. A port is a number from 1 to 65535, a width 16, 32 or 64:

```
[through(RTCPlugin, "port=http, longBits=48")]      // CDL1002, twice
cServer = Server.eServer;
```

`rtgen explain CDL1001` lists the options.
""",
)

NOT_IN_IDL = Rule(
    "CDL1003",
    "type that no IDL interface can have",
    Severity.ERROR,
    """\
`RTCPlugin` makes an IDL interface of the signature of its join. Some types of CDL have no
counterpart there, or are never transferred:

```
signature sServer {
    ER f( [in] enum eColour colour );       // CDL1003: real tecsgen cannot carry an enum
    ER g( [in] int128_t big );              // CDL1003: IDL has no such integer
    ER h( [in] const void *where );         // CDL1003: nothing travels for a void pointer
};
```

Use integers of fixed width in place of an enum, two of them in place of an `int128_t`, and an
array with `size_is` in place of a pointer to anything.
""",
)

DIFFERENT_OPTIONS = Rule(
    "CDL1004",
    "two joins that want different interfaces",
    Severity.ERROR,
    """\
The IDL and the codec are made once for a signature, so all its joins through `RTCPlugin` have to
agree on what decides them: `reply`, `array`, `encoding`, `PPAllocatorSize`. All joins of a CDL
file, which may share types, have to agree on `tdr` and the widths `longBits`, `intptrBits`,
`shortBits`, `intBits`.

```
[through(RTCPlugin, "tdr=network")] cLeft  = Left.eMotor;
[through(RTCPlugin, "tdr=little")]  cRight = Right.eMotor;     // CDL1004
```

Where boards really differ, describe each in a CDL file of its own.
""",
)

SAME_NAME = Rule(
    "CDL1005",
    "two signatures with one name in Python",
    Severity.ERROR,
    """\
The files of a signature are named without its leading `s` and without its namespaces: `sServer`
gives `Server.idl` and `server_codec.py`. Two signatures that give the same name would overwrite
each other:

```
namespace nLeft  { signature sMotor { ER stop( void ); }; };
namespace nRight { signature sMotor { ER stop( void ); }; };     // CDL1005, if both are joined
```

Rename one of them.
""",
)

SAME_COMPONENT = Rule(
    "CDL1006",
    "two component types of one name",
    Severity.WARNING,
    """\
Two CDL files both have joins of a signature with the same name through `RTCPlugin`, so there are
two component types `<Name>Marshaller`. `rtgen run` finds components by their type, and takes
those of the first file. The skeleton of `<Name>Client` is that of the first file, too; clients of
the other one are subclasses of its `<Name>ClientBase`.

Name the one to use in `[components]` of `rtgen.toml`:

```toml
[components]
MotorMarshaller = "robots.tecs.right_board.motor_marshaller:MotorMarshaller"
```
""",
)

NOT_TRANSFERRED = Rule(
    "CDL1007",
    "parameter that OpaqueRPC cannot carry",
    Severity.ERROR,
    """\
A caller on another machine shares no memory with the board, so the size of everything has to be
told by the signature:

```
signature sServer {
    ER f( [out,count_is(*n)] int8_t *data, [out] int32_t *n );     // CDL1007: add size_is
    ER g( [inout,string] char_t *text );                           // CDL1007: add a length
};
```

A size may depend on parameters that travel in the same direction, and before it.
""",
)

RULES = (
    UNKNOWN_OPTION,
    BAD_OPTION,
    NOT_IN_IDL,
    DIFFERENT_OPTIONS,
    SAME_NAME,
    SAME_COMPONENT,
    NOT_TRANSFERRED,
)
