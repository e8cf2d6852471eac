"""Names in what follows definitions: systems, timelines, `.conf` files."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from rtgen.compiler.diagnostics import Span
from rtgen.compiler.frontends.kit.located_xml import Element
from rtgen.compiler.frontends.profiles import profile_tree
from rtgen.compiler.model import Model
from rtgen.compiler.model.profile_elements import RTS
from rtgen.facts.encodings import decode
from rtgen.facts.files import UnreadableError, read_file
from rtgen.tools.indexing.components import KnownComponents, Names, word_at
from rtgen.tools.indexing.index import Collector, Kind, path_of
from rtgen.tools.indexing.text import Text

MAX_BYTES = 4 * 1024 * 1024
MAX_FILES = 20_000
"""Limits of what is searched below the root of a project."""

PROFILE_SUFFIXES = (".xml", ".yaml", ".yml")
_OTHERS = frozenset(
    {"build", "dist", "node_modules", "site", "site-packages", "venv", "__pycache__"}
)
_ID = re.compile(r"RTC:[^:]*:[^:]*:([^:]+)")
_EVENTS = re.compile(r"^\s*(?:\[\[\s*(?:at|measure)\s*\]\]|follows\s*=)", re.M)
_SUBTABLE = re.compile(
    r"^\s*\[\s*at\s*\.\s*set\s*\.\s*[\"']?([\w.-]+?)[\"']?\s*\]", re.M
)
_NESTED = re.compile(r"""["']?([\w-]+)["']?\s*=\s*\{([^{}]*)\}""")
_KEY = re.compile(r"""(?:^|[{,\n])\s*["']?([\w.-]+?)["']?\s*=""")
_CONF = re.compile(r"^[ \t]*(conf\.[^.\s:=]+\.|port\.(?:in|out)port\.)", re.M)
_TYPES = re.compile(
    r"^[ \t]*\w+\.(\w+)\.config_file|(?<=[:,/\s])(\w+)(?=\.conf\b|[?,\s]|$)", re.M
)
"""Types of components in the settings of a manager: `Category.TYPE.config_file`, `TYPE`."""
_COMMENT = re.compile(r"^\s*#.*$|(?<=[\s,\]}])#[^\"'\n]*$", re.M)
_ENDS = {"sourceDataPort", "targetDataPort", "sourceServicePort", "targetServicePort"}


def files_below(
    root: Path, suffixes: Sequence[str], leave: Iterable[Path] = ()
) -> Iterator[Path]:
    """Yield the files below a folder that a user writes, in order.

    `leave` are folders that are not entered; nor are hidden ones, those of build tools and virtual
    environments.
    """
    left = {os.path.normpath(each) for each in leave}
    number = 0
    for folder, folders, names in os.walk(root):
        folders[:] = sorted(
            each
            for each in folders
            if not each.startswith(".")
            and each not in _OTHERS
            and os.path.normpath(Path(folder, each)) not in left
            and not Path(folder, each, "pyvenv.cfg").exists()
        )
        for name in sorted(names):
            number += 1
            if number > MAX_FILES:
                return
            if name.lower().endswith(tuple(suffixes)):
                yield Path(folder, name)


class Followers:
    """Adds the names of systems and of what is beside them."""

    def __init__(self, collector: Collector, model: Model) -> None:
        self._collector = collector
        self.components = KnownComponents(model)
        self.instances: dict[str, str] = {}
        """The types of instances by name, of all systems."""
        self._by_folder: dict[Path, tuple[str, dict[str, str]]] = {}
        self._keys: dict[str, str] = {}
        """The key of the system with each instance; empty if there are several."""

    def add_system(self, file: str, root: Element, text: Text) -> None:
        """Add the names of an RtsProfile, displayed as `file`."""
        types: dict[str, str] = {}
        for element in root.all(RTS, "Components"):
            match = _ID.match(element.get(RTS, "id"))
            if match is not None and (instance := element.get(RTS, "instanceName")):
                types[instance] = match[1]
        _System(self._collector, self.components, file, text, types).add(root)
        self.instances |= {n: t for n, t in types.items() if n not in self.instances}
        folder = Path(path_of(file)).parent
        key = f"rts {path_of(file)}#"
        known = self._by_folder.get(folder)
        for instance in types:
            others = self._keys.get(instance, key)
            self._keys[instance] = key if others == key else ""
        if known is None or known[0] == key:
            self._by_folder[folder] = (key, dict(types))
        else:
            self._by_folder[folder] = ("", {**types, **known[1]})

    def add_timeline(self, file: str, text: Text) -> None:
        """Add the names of a timeline, which are those of the systems beside it, or of all."""
        source = _without_comments(text.normal)
        key, beside = self._by_folder.get(Path(path_of(file)).parent, ("", {}))
        instances = {**self.instances, **beside}
        self._paths(file, text, source, instances)
        for match in _SUBTABLE.finditer(source):
            stop = source.find("\n[", match.end())
            body = source[match.end() : stop if stop >= 0 else len(source)]
            self._parameters(file, text, match.end(), body, instances.get(match[1]))
            if key and match[1] in beside:
                self._refer(file, text, *match.span(1), key + match[1])
        for match in _NESTED.finditer(source):
            self._parameters(
                file, text, match.start(2), match[2], instances.get(match[1])
            )
        self._instances(file, text, source, dict.fromkeys(beside, key))

    def add_project_file(self, file: str, text: Text) -> None:
        """Add the names of instances' ports, and of types of components, in rtgen.toml."""
        source = _without_comments(text.normal)
        self._paths(file, text, source, self.instances)
        self._instances(file, text, source, self._keys)
        section = re.search(r"^\s*\[\s*components\s*\]", source, re.M)
        if section is None:
            return
        stop = source.find("\n[", section.end())
        body = source[section.end() : stop if stop >= 0 else len(source)]
        for match in _KEY.finditer(body):
            names = self.components.types.get(match[1])
            if names is not None:
                begin = section.end() + match.start(1)
                self._refer(file, text, begin, begin + len(match[1]), names.key)

    def add_conf(self, file: str, text: Text) -> None:
        """Add the names of a `.conf` file of OpenRTM: of a component, or of a manager."""
        source = _without_comments(text.normal)
        stem = Path(file).stem
        type_ = stem if stem in self.components.types else self.instances.get(stem, "")
        names = self.components.types.get(type_)
        if names is not None:
            for match in _CONF.finditer(source):
                known = names.parameters if match[1].startswith("conf") else names.ports
                name = word_at(source, match.end(), known)
                if name is not None:
                    place = match.end(), match.end() + len(name)
                    self._refer(file, text, *place, known[name])
        self._paths(file, text, source, self.instances)
        self._instances(file, text, source, self._keys)
        for match in _TYPES.finditer(source):
            word = match[1] or match[2]
            names = self.components.types.get(word)
            if names is not None:
                self._refer(file, text, *match.span(1 if match[1] else 2), names.key)

    def _paths(
        self, file: str, text: Text, source: str, instances: Mapping[str, str]
    ) -> None:
        for start, end, key in self.components.paths(source, instances):
            self._refer(file, text, start, end, key)

    def _parameters(
        self, file: str, text: Text, start: int, body: str, type_: str | None
    ) -> None:
        names = self.components.types.get(type_ or "")
        for match in _KEY.finditer(body) if names is not None else ():
            if names is not None and (key := names.parameters.get(match[1])):
                begin = start + match.start(1)
                self._refer(file, text, begin, begin + len(match[1]), key)

    def _instances(
        self, file: str, text: Text, source: str, keys: Mapping[str, str]
    ) -> None:
        """Add the instances in a text; `keys` has those of their systems."""
        known = sorted(filter(keys.get, keys), key=len, reverse=True)
        if not known:
            return
        words = "|".join(map(re.escape, known))
        for match in re.finditer(rf"(?<![\w.])(?:{words})(?!\w)", source):
            self._refer(file, text, *match.span(), f"{keys[match[0]]}{match[0]}")

    def _refer(self, file: str, text: Text, start: int, end: int, key: str) -> None:
        # Offsets are those of the text without a mark and with line feeds, as spans are.
        span = Text(text.normal).span(file, start, end)
        self._collector.refer(key, span)


class _System:
    """Adds the names of one system."""

    def __init__(
        self,
        collector: Collector,
        components: KnownComponents,
        file: str,
        text: Text,
        types: Mapping[str, str],
    ) -> None:
        self._collector = collector
        self._components = components
        self._file = file
        self._text = text
        self._source = text.normal
        self._normal = Text(text.normal)
        self._types = types
        self._key = f"rts {path_of(file)}#"

    def add(self, root: Element) -> None:
        for element in root.children:
            self._element(element, "")

    def _element(self, element: Element, instance: str) -> None:
        local = element.name[1]
        own = element.get(RTS, "instanceName")
        if own:
            instance = own
            self._instance(element, defines=local == "Components")
        names = self._components.types.get(self._types.get(instance, ""))
        for attribute in ("id", "componentId"):
            if (match := _ID.match(element.get(RTS, attribute))) is not None:
                known = self._components.types.get(match[1])
                if known is not None:
                    self._word(element, attribute, match.start(1), match[1], known.key)
        if local == "Components":
            self._tail(element, "pathUri", instance)
        if names is not None:
            self._ports(element, local, instance, names)
        for (_, attribute), value in element.attributes.items():
            if attribute in ("data", "value", "dataType"):
                self._value(element, attribute, value)
        for child in element.children:
            self._element(child, instance)

    def _ports(self, element: Element, local: str, instance: str, names: Names) -> None:
        if local in ("DataPorts", "ServicePorts"):
            self._port(element, "name", instance, names)
        elif local in _ENDS:
            self._port(element, "portName", instance, names)
        elif local == "ConfigurationData":
            name = element.get(RTS, "name")
            if name in names.parameters:
                self._word(element, "name", 0, name, names.parameters[name])

    def _instance(self, element: Element, *, defines: bool) -> None:
        instance = element.get(RTS, "instanceName")
        key = f"{self._key}{instance}"
        span = self._place(element, "instanceName", 0, instance)
        if span is None or instance not in self._types:
            return
        if defines:
            type_ = self._types[instance]
            self._collector.define(key, instance, Kind.INSTANCE, span, detail=type_)
        else:
            self._collector.refer(key, span)

    def _tail(self, element: Element, attribute: str, instance: str) -> None:
        """Add the instance at the end of a path: `localhost/A0.rtc`."""
        value = element.get(RTS, attribute)
        end = f"{instance}.rtc"
        if value.endswith((f"/{end}", f".host_cxt/{end}")) and instance:
            self._word(
                element,
                attribute,
                len(value) - len(end),
                instance,
                self._key + instance,
            )

    def _port(
        self, element: Element, attribute: str, instance: str, names: Names
    ) -> None:
        value = element.get(RTS, attribute)
        name = value.removeprefix(f"{instance}.")
        if name != value:
            self._word(element, attribute, 0, instance, self._key + instance)
        if name in names.ports:
            self._word(
                element, attribute, len(value) - len(name), name, names.ports[name]
            )

    def _value(self, element: Element, attribute: str, value: str) -> None:
        """Add the paths to ports and the names of types in any value."""
        for start, end, key in (
            *self._components.paths(value, self._types),
            *self._components.type_names(value),
        ):
            self._word(element, attribute, start, value[start:end], key)

    def _word(
        self, element: Element, attribute: str, start: int, word: str, key: str
    ) -> None:
        span = self._place(element, attribute, start, word)
        if span is not None:
            self._collector.refer(key, span)

    def _place(
        self, element: Element, attribute: str, start: int, word: str
    ) -> Span | None:
        """Return the place of a word of a value; None if the file writes the value otherwise."""
        first, last = self._normal.offsets(element.place(attribute))
        begin = first + start
        if self._source[first : first + 1] in ("'", '"'):
            begin += 1  # a value of YAML has its quotes
        if begin + len(word) > last or not self._source.startswith(word, begin):
            return None
        return self._normal.span(self._file, begin, begin + len(word))


def add_followers(
    followers: Followers,
    files: Iterable[tuple[str, bytes]],
    texts: dict[str, Text],
    encoding: str,
) -> None:
    """Add the names of systems, then of timelines and `.conf` files, by displayed paths.

    The texts of files that are among them, and have no text yet, are added to `texts`.
    """
    later = []
    for name, data in files:
        if not name.lower().endswith(PROFILE_SUFFIXES):
            later.append((name, data))
        elif b"RtsProfile" in data or b"rtsProfile" in data:
            root, source = profile_tree.parse(data, name, lambda _: None, encoding)
            if root is not None and root.name == (RTS, "RtsProfile"):
                text = texts.setdefault(name, Text(source))
                followers.add_system(name, root, text)
    for name, data in later:
        source = decode(data, encoding, standard=True).normal
        text = texts.get(name) or Text(source)
        if name.endswith(".conf"):
            followers.add_conf(name, text)
        elif _EVENTS.search(source) is not None:
            followers.add_timeline(name, text)
        else:
            continue
        texts.setdefault(name, text)


def content(path: Path) -> bytes | None:
    """Return the bytes of a file, None if it cannot be read."""
    try:
        return read_file(path, MAX_BYTES)
    except UnreadableError:
        return None


def _without_comments(text: str) -> str:
    """Return a text of TOML or of OpenRTM's settings with blanks in place of its comments."""
    return _COMMENT.sub(lambda match: " " * len(match[0]), text)
