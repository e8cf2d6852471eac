"""The rules of running a system (codes SYS...)."""

from __future__ import annotations

from rtgen.diagnostics import Rule, Severity

UNKNOWN_TYPE = Rule(
    "SYS0001",
    "component type without a factory",
    Severity.ERROR,
    """
A system has a component of a type that no installed package, no `[components]` of `rtgen.toml`
and no generated `components/entry_points.txt` of the project brings.

```toml
[components]
PathFollower = "mypackage.path_follower:PathFollower"
```

Type names are compared letter by letter. Nothing that an input file says is executed: only
factories that the installation or the project names are called.
""",
)

NO_COMPONENT = Rule(
    "SYS0002",
    "factory that makes no component",
    Severity.ERROR,
    """
A factory is called with the instance name and must give an `rtgen.runtime.Component`, and the
component's `on_initialize` must return `RTC_OK`.
""",
)

CONNECTION = Rule(
    "SYS0003",
    "ports that cannot be joined",
    Severity.ERROR,
    """
The two ends of a connection do not go together: a port is not there, both are of one direction,
their types differ (the message shows both, with a mark where they differ), or a connector
property has a value that it does not take.
""",
)

PARAMETER = Rule(
    "SYS0004",
    "configuration that a component does not take",
    Severity.ERROR,
    """
A parameter or a configuration set is unknown, or a value is not of its type or out of its range.
Values come, each over the one before, from the definition, `<Type>.conf` and `<Instance>.conf`
beside the system file, the system's configuration set, and `--set INSTANCE.PARAMETER=VALUE`.
""",
)

UNKNOWN_INSTANCE = Rule(
    "SYS0005",
    "unknown instance",
    Severity.ERROR,
    """
A name does not stand for a component of the system: in `--set`, `--until`, `timeline.toml`, or in
`rtgen.run.until`, `rtgen.run.pose` or `rtgen.run.goal` of the system file.
""",
)

CONDITION = Rule(
    "SYS0006",
    "no such condition",
    Severity.ERROR,
    """
`--until`, or the property `rtgen.run.until` of a system, is a time in seconds, a state of a
component, or both with a comma between: until the state, but no longer than the time.

```
--until 30
--until PositionInput0=ERROR
--until PositionInput0=ERROR,300
```

States: CREATED, INACTIVE, ACTIVE, ERROR. A system that runs in simulated time needs a condition.
""",
)

TIMELINE = Rule(
    "SYS0007",
    "timeline that cannot be followed",
    Severity.ERROR,
    """
`timeline.toml` is a list of instants, each with what is done then:

```toml
[[at]]
t = 2.5                                  # seconds
disconnect = "velocity"                  # a connection's name in the system

[[at]]
t = 3.0
connect = "velocity"                     # the same connection again
deactivate = ["Odometry0"]

[[at]]
t = 4.0
connect = { from = "A0.out", to = "B0.in" }   # name and properties if wanted
set = { PathFollower0.max_v = 0.3 }      # or "PathFollower0.max_v=0.3"
activate = "Odometry0"

[[at]]
t = 5.0
disconnect = { from = "A0.out", to = "B0.in" }
```

Each value may be a list; `reset` is one more key. At one instant: disconnect, connect, set,
deactivate, reset, activate. A connection is told by its name, by its connector id, or by its two
ports.

`follows = "FILE"` puts another timeline, beside this one, before it. `[[measure]]`: see SYS0010.
""",
)

OBSERVABLE = Rule(
    "SYS0008",
    "unknown observable",
    Severity.ERROR,
    """
`rtgen.run.pose` and `rtgen.run.goal` name a value that a component publishes for reports, as
`INSTANCE.NAME`: x [m], y [m] and heading [rad]. Several poses are separated by commas.
""",
)

ELSEWHERE = Rule(
    "SYS0009",
    "component of another process",
    Severity.ERROR,
    """
`rtgen run --transport corba --only A0,B0` runs the components that it names; other processes run
the rest of the system. Calls go from one process to the other, samples do not: a data connection
needs both ends in one process. `--until` and `--set` can only tell of components that run here;
properties of the system and steps of `timeline.toml` that tell of others are left to the others.

```
rtgen run robot.xml --clock real --transport corba --only Arm0,Camera0
error[SYS0009]: Arm0.state_Logger0.in: data ports of two processes, ..., cannot be connected
```
""",
)

MEASURE = Rule(
    "SYS0010",
    "measure that cannot be taken",
    Severity.ERROR,
    """
A table `[[measure]]` of `timeline.toml` says what is looked at in a run, from one time to another,
and its limits; the result is a row of the report.

```toml
[[measure]]
name = "RMP behind Ref-Hard"
kind = "distance"
of = "SegwayRmp0.truth"         # poses that rtgen.run.pose names
to = "RefHard0.truth"
from = 5.0                      # seconds; default: the whole run
until = 60.0
least = 0.8                     # limits; default: none
most = 1.5
```

Kinds: `distance`; `track` (of a pose from where the other one has been, from the time `since` on);
`inside` (how far outside of `area`, the least and greatest x and y); `moved` (how far from where it
was at the beginning); `alike` (how far apart, had both begun at the same place); `displacement`
(how far the whole motion is from `expected`, x y theta as seen from its beginning). In m.
""",
)

TOLERANCE = Rule(
    "SYS0012",
    "tolerance that cannot be applied",
    Severity.ERROR,
    """
`rtgen.run.tolerance` of a system is how far the robot may be from its goal when the run ends: a
distance [m], or a distance and an angle [rad] with a comma between, both above 0. Beyond it the
exit code of `rtgen run` is 1, whatever the end condition says.

```xml
<rtsExt:Properties rtsExt:name="rtgen.run.tolerance" rtsExt:value="0.05, 0.1"/>
```

It needs exactly one pose in `rtgen.run.pose`, and `rtgen.run.goal`.
""",
)

RAISED = Rule(
    "SYS0021",
    "code of a component failed",
    Severity.ERROR,
    """
A component's own code raised an exception, or a callback returned something that is no
`ReturnCode_t`. The place is the last line of a user's own file in the traceback, which stands
below (`--traceback none|short|full`); the message names component, callback and time.

```python
def on_execute(self, ec_id: int) -> ReturnCode_t:
    self.temperature += 1 / self.config.period       # ZeroDivisionError if period is 0
                                                     # no return: None is no ReturnCode_t
```

The component enters ERROR as `docs/life-cycle.md` says, other components go on, and `rtgen run`
exits with 1 (2 if it failed in the constructor or in `on_initialize`). A callback that fails on
purpose returns `self.fail("the reason")`, which is no such error. `--pdb` opens the debugger in
the failing frame.
""",
)

IMPORT = Rule(
    "SYS0022",
    "module of a component that cannot be imported",
    Severity.ERROR,
    """
The module that `[components]` of `rtgen.toml`, or an entry point, names for a component's type
cannot be imported: it has a syntax error, imports something that is not there, or raises while it
is read. Or it has no such attribute. The place is the last line of a user's own file.

```toml
[components]
Heater = "heaters:Heater"            # src/heaters.py, class Heater
```

Modules of the project are looked for in its skeleton and output folders. `rtgen run` exits with 3.
""",
)

BLOCKED = Rule(
    "SYS0023",
    "code of a component that does not return",
    Severity.WARNING,
    """
A callback has not returned for two seconds. The place is where it is now. In simulated time
nothing else goes on meanwhile; in real time the other components do, and this one misses its
ticks. Ctrl-C ends the run: a callback that still does not return is interrupted, or given up,
two seconds later.

A callback does a small piece of work and returns; what waits for a device or a socket belongs into
a thread that `on_activated` starts, or uses a timeout.
""",
)

NOTICE = Rule(
    "SYS0024",
    "notice of the runtime",
    Severity.WARNING,
    """
The runtime reports something that does not end the run: a callback returned an error code where
no state changes (`on_deactivated`, `on_shutdown`, ...), a request came too late, a bus is off.
""",
)

RULES: tuple[Rule, ...] = (
    UNKNOWN_TYPE,
    NO_COMPONENT,
    CONNECTION,
    PARAMETER,
    UNKNOWN_INSTANCE,
    CONDITION,
    TIMELINE,
    OBSERVABLE,
    ELSEWHERE,
    MEASURE,
    TOLERANCE,
    RAISED,
    IMPORT,
    BLOCKED,
    NOTICE,
)
