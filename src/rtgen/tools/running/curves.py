"""Records values over time for `--plot INSTANCE.PORT` and `--csv INSTANCE.PORT`."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from difflib import get_close_matches
from itertools import islice
from pathlib import Path
from textwrap import shorten
from typing import Any, TextIO

from rtgen import runtime
from rtgen.compiler.diagnostics import InputError
from rtgen.compiler.model import System
from rtgen.compiler.systems.rules import OBSERVABLE, UNKNOWN_INSTANCE
from rtgen.runtime.cdr import CdrError
from rtgen.runtime.marshalling.descriptors import Descriptor
from rtgen.runtime.system.json_printers import plain
from rtgen.runtime.system.records import MissingSamples
from rtgen.runtime.timing.clocks import SECOND
from rtgen.tools.kit.curve import Curve, Number
from rtgen.tools.kit.member_units import MemberPath, Units, no_units, units_of
from rtgen.tools.running.selected_members import MemberError, require_numbers
from rtgen.tools.running.trajectory import (
    PICTURES,
    add_legend,
    reproducible,
    save_picture,
    stroke,
)

FILES = (*PICTURES, ".csv", ".tsv", ".txt", ".dat")
"""Suffixes that mark an argument as a file name."""
_SELECTOR = re.compile(
    r"(?P<instance>[^.]+)\.(?P<name>[^.\[]+)(?P<path>(\.\w+|\[\d+\])*)"
)
_TOPIC = re.compile(
    r"(?P<instance>)(?P<name>/[\w/]+)(?P<path>(\.\w+|\[\d+\])*)", re.ASCII
)
_STEP = re.compile(r"\.(\w+)|\[(\d+)\]")
_MAX_NUMBERS = 32
_MAX_TEXT = 80
_PERIOD = SECOND // 50


class Selection:
    """The curves of `INSTANCE.NAME`, `INSTANCE.NAME.member` or `INSTANCE.NAME[index]`.

    The first selects all numbers of a sample except its time stamp. With `topics`, the name of a
    topic, `/robot/speed`, is one of `INSTANCE.NAME`. Raises InputError for a text of another form.
    """

    def __init__(self, selector: str, *, topics: bool = False) -> None:
        form = _TOPIC if topics and selector.startswith("/") else _SELECTOR
        match = form.fullmatch(selector)
        if match is None:
            hint = "INSTANCE.PORT, INSTANCE.PORT.member, or INSTANCE.PORT[index]"
            if topics:
                hint += "; /TOPIC or /TOPIC.member"
            message = f"{selector!r} names no value of a port"
            raise InputError([OBSERVABLE.at(None, message, hint=hint)])
        self.selector = selector
        self.instance, self.name = match["instance"], match["name"]
        self._path = [a or int(b) for a, b in _STEP.findall(match["path"])]
        self._curves: dict[str, Curve] = {}
        self._text = ""
        self._hint: str | None = None

    @property
    def whole(self) -> str:
        """`INSTANCE.NAME`, or the name of a topic."""
        return f"{self.instance}.{self.name}" if self.instance else self.name

    def check(self, descriptor: Descriptor | None) -> None:
        """Check the path against the type of the port, None for an observable.

        Raises InputError.
        """
        try:
            if descriptor is not None:
                require_numbers(descriptor, self._path)
            elif any(isinstance(step, str) for step in self._path):
                hint = f"an observable has numbers: {self.whole}[0]"
                raise MemberError(f"{self.whole} has no members", hint)
        except MemberError as error:
            message = f"{self.selector}: {error}"
            raise InputError([OBSERVABLE.at(None, message, hint=error.hint)]) from error

    @property
    def curves(self) -> list[Curve]:
        """The curves so far, one of which may be empty. Raises InputError without numbers."""
        if not self._curves and self._text:
            message = f"{self.selector} has no numbers; {self._text}"
            raise InputError([OBSERVABLE.at(None, message, hint=self._hint)])
        return [*self._curves.values()] or [Curve(self.selector)]

    def add(self, time: float, value: Any, units: Units) -> None:
        """Add a sample, as JSON has it, at a time [s]; `units` are those of its members."""
        inner, at, path = _inside(value, self.whole, self._path)
        numbers = [*islice(_numbers(inner, at, path), _MAX_NUMBERS)]
        if not numbers and inner != []:
            self._text = shorten(
                f"a sample is {value!r}", _MAX_TEXT, placeholder=" ..."
            )
            self._hint = _members(value, self._path)
        for name, number, member in numbers:
            if (curve := self._curves.get(name)) is None:
                curve = self._curves[name] = Curve(name, units(member))
            curve.add(time, number)


def divided(
    arguments: Sequence[str], option: str, system: System
) -> tuple[str | None, tuple[str, ...]]:
    """Separate the file name among an option's arguments from the selectors.

    An argument is a selector INSTANCE.NAME unless it has a suffix of FILES or a folder. Raises
    InputError for two files, or for a name that looks like a misspelt instance.
    """
    names = [component.instance for component in system.components]
    files, selectors = [], []
    for text in arguments:
        instance, dot, _ = text.partition(".")
        path = Path(text)
        if path.suffix.lower() in FILES or path.name != text or not dot:
            files.append(text)
        elif instance in names:
            selectors.append(text)
        elif close := get_close_matches(instance, names, n=1):
            message = f"{option} {text}: no component {instance!r} in the system"
            hint = f"did you mean {close[0]!r}?"
            raise InputError([UNKNOWN_INSTANCE.at(None, message, hint=hint)])
        else:
            files.append(text)
    if len(files) > 1:
        message = f"{option} has two files, {files[0]} and {files[1]}"
        hint = f"values of ports are INSTANCE.PORT; instances: {', '.join(names)}"
        raise InputError([OBSERVABLE.at(None, message, hint=hint)])
    return (files[0] if files else None), tuple(selectors)


class Curves:
    """Records the curves selected on the command line.

    An OutPort records each sample written, an InPort each sample read, an observable its value 50
    times a second. Raises InputError for a name that the component does not have.
    """

    def __init__(self, running: runtime.System, selectors: Sequence[str]) -> None:
        self.missing = MissingSamples()
        self._running = running
        self._of = {each: Selection(each) for each in dict.fromkeys(selectors)}
        for selection in self._of.values():
            self._follow(selection)

    def of(self, selectors: Sequence[str]) -> list[Curve]:
        """Return the curves of some selectors. Raises InputError if a selector has no numbers."""
        chosen = dict.fromkeys(selectors)
        return [curve for each in chosen for curve in self._of[each].curves]

    def _follow(self, selection: Selection) -> None:
        running, instance, name = self._running, selection.instance, selection.name
        component = running.component(instance)
        port = component.out_ports.get(name) or component.in_ports.get(name)
        units = no_units if port is None else units_of(component.profile, port)

        def add(value: Any) -> None:
            selection.add(running.time / SECOND, value, units)

        def add_sample(sample: Any) -> None:
            try:
                sample.to_cdr()
            except CdrError as error:
                self.missing.add(selection.whole, error)
            else:
                add(plain(sample))

        if port is not None or name in component.observables:
            selection.check(None if port is None else port.type._descriptor_)
        if name in component.out_ports:
            running.watch_port(instance, name, add_sample)
        elif name in component.in_ports:
            self._look_at(instance, component.in_ports[name], add_sample)
        elif name in component.observables:
            whole = selection.whole
            running.every(_PERIOD, lambda: add([*running.observable(whole)]))
        else:
            names = [*component.out_ports, *component.in_ports, *component.observables]
            close = get_close_matches(name, names, n=1)
            hint = f"known: {', '.join(names) or 'none'}"
            if close:
                hint = f"did you mean {instance}.{close[0]}?"
            message = f"{instance} has no data port and no observable {name!r}"
            raise InputError([OBSERVABLE.at(None, message, hint=hint)])

    def _look_at(
        self, instance: str, port: runtime.InPort[Any], add: Callable[[Any], None]
    ) -> None:
        last: object = None

        def look() -> None:
            nonlocal last
            if port.last is not None and port.last is not last:
                last = port.last
                add(last)

        self._running.every(self._running.context(instance).period, look)


def _inside(
    value: Any, label: str, path: Sequence[str | int]
) -> tuple[Any, str, MemberPath]:
    """Return the part of a sample that a path selects, None if missing; its label and its path.

    A path may leave out the only member beside the time stamp, as labels do.
    """
    whole: MemberPath = ()
    for step in path:
        label += f"[{step}]" if isinstance(step, int) else f".{step}"
        value, passed = _unwrapped(value, step)
        whole += passed
        if isinstance(step, int):
            is_there = isinstance(value, list) and step < len(value)
        else:
            is_there = isinstance(value, dict) and step in value
            whole += (step,)
        value = value[step] if is_there else None
    return value, label, whole


def _unwrapped(value: Any, step: str | int) -> tuple[Any, MemberPath]:
    """Return what a step selects from, and the members passed on the way to it.

    That is the only member beside the time stamp if not the sample.
    """
    passed: MemberPath = ()
    while isinstance(value, dict) and step not in value:
        members = _timeless(value)
        if len(members) != 1:
            break
        [(name, value)] = members.items()
        passed += (name,)
    return value, passed


def _members(value: Any, path: list[str | int]) -> str | None:
    """Return a hint for a path with a missing member or index; None for other paths."""
    for step in path:
        inner, _ = _unwrapped(value, step)
        if isinstance(inner, list) and isinstance(step, int) and step >= len(inner):
            return f"the sequence has {len(inner)} elements"
        if isinstance(value, dict) and isinstance(step, str) and step not in value:
            close = get_close_matches(step, value, n=1)
            return (
                f"did you mean {close[0]!r}?"
                if close
                else f"members: {', '.join(value)}"
            )
        value, _, _ = _inside(value, "", [step])
    return None


def _timeless(value: dict[str, Any]) -> dict[str, Any]:
    """Return the members without the time stamp, which is left if there are no others."""
    return {k: v for k, v in value.items() if k != "tm"} or value


def _numbers(
    value: Any, label: str, path: MemberPath
) -> Iterator[tuple[str, Number, MemberPath]]:
    """Yield the numbers in a sample with labels and paths, without time stamps of others."""
    match value:
        case bool():
            yield label, int(value), path
        case int() | float():
            yield label, value, path
        case "nan" | "inf" | "-inf":
            yield label, float(value), path
        case list():
            for index, item in enumerate(value):
                yield from _numbers(item, f"{label}[{index}]", path)
        case dict():
            members = _timeless(value)
            for name, item in members.items():
                inner = label if len(members) == 1 else f"{label}.{name}"
                yield from _numbers(item, inner, (*path, name))


def write_curves(stream: TextIO, curves: Sequence[Curve]) -> None:
    """Write a column for each curve and a row for each time at which any curve has a value."""
    rows: dict[float, dict[int, Number]] = {}
    for column, curve in enumerate(curves):
        for time, value in zip(curve.times, curve.values, strict=True):
            rows.setdefault(time, {})[column] = value
    import csv  # lazily: few runs write a table

    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(["t", *(curve.title for curve in curves)])
    for time, values in sorted(rows.items()):
        writer.writerow([time, *(values.get(c, "") for c in range(len(curves)))])


def draw_curves(path: str, title: str, curves: Sequence[Curve], time: str) -> None:
    """Draw curves over time, one frame for each unit; `time` is the label of the axis."""
    from matplotlib.figure import Figure

    units = [*dict.fromkeys(curve.unit for curve in curves)]
    with reproducible():
        figure = Figure(figsize=(7.0, 1.0 + 2.6 * len(units)), layout="constrained")
        grid = figure.subplots(len(units), 1, sharex=True, squeeze=False)
        frames = [row[0] for row in grid]
        for unit, axes in zip(units, frames, strict=True):
            for number, curve in enumerate(curves):
                if curve.unit == unit:
                    line = stroke(number, len(curves))
                    style = {"drawstyle": "steps-post", "label": curve.name}
                    axes.plot(curve.times, curve.values, **line, **style)
            axes.set_ylabel(f"[{unit}]" if unit else "")
            axes.grid(visible=True, alpha=0.3)
        frames[-1].set_xlabel(time)
        figure.suptitle(title)
        add_legend(figure, frames, most=2)
        save_picture(figure, Path(path))
