"""Reads interface files and those that they use, and lowers them to declarations."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from pathlib import Path
from typing import Final

import msgspec

from rtgen.compiler.diagnostics import Span, in_order
from rtgen.compiler.frontends import FrontendResult
from rtgen.compiler.frontends.kit import characters
from rtgen.compiler.frontends.kit.findings import Findings
from rtgen.compiler.frontends.kit.library import (
    Library,
    VirtualFile,
    absolute_path,
)
from rtgen.compiler.frontends.kit.main_files import open_main
from rtgen.compiler.frontends.kit.suggestions import nearest
from rtgen.compiler.frontends.stage import Settings
from rtgen.compiler.kit import stages
from rtgen.compiler.model import Declaration, Model, ScopedName, SourceFile
from rtgen.facts.encodings import digest
from rtgen.facts.ros import ACTION_SERVICES, ACTION_TOPICS
from rtgen.ros2.rosidl import idl_form, rules
from rtgen.ros2.rosidl.interfaces import PARTS, Message, messages_of
from rtgen.ros2.rosidl.lowering import action_interfaces, declarations
from rtgen.ros2.rosidl.packages import (
    candidates,
    dependencies,
    file_of,
    identity,
    shipped,
)
from rtgen.ros2.rosidl.syntax import PRIMITIVES, STRINGS, FieldType, Part, parts_of
from rtgen.ros2.rosidl.types import scoped

_FORM: Final = "an interface file of ROS 2"
_MAX_FILES: Final = 10_000
_IDL: Final = ".idl"


def read(paths: Sequence[Path], settings: Settings) -> FrontendResult:
    """Read files with the settings of all front ends, as the stage of front ends calls it."""
    return load(
        paths,
        root=settings.root,
        include=settings.include,
        encoding=settings.encoding,
    )


class InterfaceFile(msgspec.Struct, frozen=True):
    """An interface file with its bytes; `data` is None for a file that is too large."""

    name: str
    key: str
    path: Path
    data: bytes | None


def load(
    paths: Sequence[Path],
    *,
    root: Path,
    include: Sequence[Path] = (),
    encoding: str = "auto",
) -> FrontendResult:
    """Read interface files into one model, with the messages that they contain.

    `root` is the project's folder, to which keys of files are relative; `include` are folders of
    packages, `encoding` is that of files that are not UTF-8. All errors in the input are among the
    diagnostics; no exception is raised for them.
    """
    names = {absolute_path(path): path.as_posix() for path in reversed(paths)}
    run = _Run(Library(InterfaceFile, root, include, names, shipped()), encoding)
    for absolute in dict.fromkeys(map(absolute_path, paths)):
        run.read_main(Path(absolute), names[absolute])
    return run.result()


def load_texts(texts: Mapping[str, str], also: Sequence[str] = ()) -> FrontendResult:
    """Read interface files that are not on the disk, by name (`lab/msg/Place.msg`).

    `also` are messages that ship with rtgen, for the model.
    """
    virtual = {name: VirtualFile(name, text) for name, text in texts.items()}
    library = Library(InterfaceFile, Path(), (), virtual={**shipped(), **virtual})
    run = _Run(library, "utf-8", texts)
    run.read_texts([*texts, *(f"{name}.msg" for name in also)])
    return run.result()


class _Run:
    def __init__(
        self,
        library: Library[InterfaceFile],
        encoding: str,
        texts: Container[str] = (),
    ) -> None:
        self._library = library
        self._given = texts
        self._encoding = encoding
        self._findings = Findings(rules.TOO_MANY)
        self._files: list[SourceFile] = []
        self._declarations: list[Declaration] = []
        self._texts: dict[str, str] = {}
        self._validity: dict[ScopedName, bool] = {}
        """Messages by name: True if complete, False while they are read."""
        self._names: dict[ScopedName, str] = {}
        """The files of messages, by displayed name."""
        self._places: set[ScopedName] = set()
        """Messages whose files were found."""
        self._read: set[str] = set()

    def result(self) -> FrontendResult:
        model = Model(files=tuple(self._files), declarations=tuple(self._declarations))
        return FrontendResult(
            model=Model() if self._findings.errors else model,
            diagnostics=tuple(in_order(self._findings.diagnostics)),
            sources=self._texts,
            dependencies=(*self._library.dependencies, *dependencies(self._files)),
        )

    def read_main(self, path: Path, name: str) -> None:
        stages.file(name)
        file = open_main(
            self._library,
            path,
            name,
            self._findings.report,
            missing=rules.MISSING_FILE,
            unreadable=rules.UNREADABLE,
            beside=f"*{path.suffix}",
        )
        if file is not None:
            self._main(file)

    def read_texts(self, names: Sequence[str]) -> None:
        for name in names:
            file = self._library.virtual(name)
            assert file is not None
            self._main(file)

    def _main(self, file: InterfaceFile) -> None:
        """Read a main file, or mark it if others have used it before."""
        if absolute_path(file.path) not in self._read:
            self._interface(file, main=True)
            return
        self._files = [
            msgspec.structs.replace(each, main=True) if each.name == file.name else each
            for each in self._files
        ]

    def _interface(self, file: InterfaceFile, *, main: bool) -> None:
        self._read.add(absolute_path(file.path))
        start = Span(file.name, 1, 1, 1, 1)
        text = self._text(file, start)
        names = identity(file.path, self._findings, start)
        if text is None or names is None:
            return
        package, kind, stem = names
        if file.path.suffix.lower() == _IDL:
            parts = self._parts_of_idl(text, file.name, names)
        else:
            parts = parts_of(text, file.name, self._findings)
        expected = len(PARTS[kind])
        if len(parts) != expected:
            text = f"number of parts: {len(parts)}; a .{kind} file has {expected}"
            hint = "a line --- separates two parts"
            self._findings.add(rules.SECTIONS, start, text, hint=hint)
            return
        messages = list(messages_of(package, kind, stem, parts, start))
        for message in messages:
            self._validity[message.name] = False
            self._names[message.name] = file.name
        included = self._referenced(messages, file)
        if kind == "action":
            included |= self._carried(file, start)
        for message in messages:
            self._validity[message.name] = True
        assert file.data is not None
        self._files.append(
            SourceFile(
                name=file.name,
                key=file.key,
                sha256=digest(file.data),
                main=main,
                includes=tuple(included),
            )
        )
        if not self._findings.errors:
            for message in messages:
                self._declarations += declarations(message, file.name)
            if kind == "action":
                action = (package, kind, stem)
                self._declarations += action_interfaces(action, file.name, start)

    def _parts_of_idl(
        self, text: str, file: str, names: tuple[str, str, str]
    ) -> list[Part]:
        try:
            return idl_form.parts_of(text, file, names)
        except idl_form.OtherFormError as error:
            place = Span(file, error.line, 1, error.line, 1)
            message = "this is not IDL in the form that ROS 2 generates"
            self._findings.add(rules.SYNTAX, place, message)
            return [Part((), (), "")] * len(PARTS[names[1]])

    def _text(self, file: InterfaceFile, start: Span) -> str | None:
        if file.data is None:
            self._findings.add(rules.UNREADABLE, start, f"{file.name} is too large")
            return None
        read = characters.read(file.data, file.name, self._encoding, standard=_FORM)
        for problem in read.problems:
            self._findings.report(problem)
        self._texts[file.name] = read.text
        if "\0" in read.text:
            message = "this is not a text file: it holds a NUL byte"
            self._findings.add(rules.UNREADABLE, start, message)
            return None
        return read.text

    def _referenced(
        self, messages: Sequence[Message], file: InterfaceFile
    ) -> dict[str, None]:
        """Read the types of the fields; return their files, by displayed name."""
        files: dict[str, None] = {}
        own: set[ScopedName] = set()
        for message in messages:
            for field in message.part.fields:
                if not field.type.is_message:
                    continue
                name = scoped(field.type.base, message.name[0])
                if name in own:
                    continue
                if name is None or name[1] != "msg":
                    self._report_spelling(field.type)
                    continue
                self._add_message(files, name, field.type, file)
            if message.name[1] != "msg":
                own.add(message.name)
        return files

    def _carried(self, file: InterfaceFile, start: Span) -> dict[str, None]:
        """Read the messages that all actions use; return the files, by displayed name."""
        files: dict[str, None] = {}
        for form in (*ACTION_SERVICES.values(), *ACTION_TOPICS.values()):
            package, _, name = form.partition("/")
            if name:
                suffix = "_Request" if name.startswith("srv/") else ""
                scoped_name = (package, *f"{name}{suffix}".split("/"))
                self._add_message(files, scoped_name, FieldType(form, start), file)
        return files

    def _add_message(
        self,
        files: dict[str, None],
        name: ScopedName,
        type_: FieldType,
        user: InterfaceFile,
    ) -> None:
        """Read the file of a message that `user` uses, and add it to `files`."""
        file = self._message(name, type_, user)
        if file is not None:
            files[file] = None

    def _report_spelling(self, type_: FieldType) -> None:
        near = nearest(type_.base, (*PRIMITIVES, *STRINGS))
        hint = f"did you mean {near}?" if near else "types are Name or package/Name"
        message = f"{type_.base} is not a type"
        self._findings.add(rules.BAD_TYPE, type_.span, message, hint=hint)

    def _message(
        self, name: ScopedName, type_: FieldType, file: InterfaceFile
    ) -> str | None:
        """Read the file of a message once; return its displayed name, None if missing."""
        if name not in self._validity:
            self._find(name, file)
        if name not in self._validity:
            if name not in self._places:
                where = file_of(name)
                message = f"{'/'.join(name)} is not found"
                hint = f"{where} is searched for beside the package and in [sources] include"
                self._findings.add(rules.UNKNOWN_TYPE, type_.span, message, hint=hint)
            return None
        if not self._validity[name]:
            message = f"{'/'.join(name)} contains itself"
            self._findings.add(rules.RECURSIVE, type_.span, message)
        return self._names.get(name)

    def _find(self, name: ScopedName, file: InterfaceFile) -> None:
        """Read the file of a message, if it exists."""
        if len(self._read) >= _MAX_FILES:
            return
        source = None
        try:
            if file_of(name) not in self._given:
                source = self._on_disk(name, file)
        except OSError as error:
            span = Span(file.name, 1, 1, 1, 1)
            text = f"{Path(file_of(name)).name}: {error}"
            self._findings.add(rules.UNREADABLE, span, text)
            return
        source = source or self._library.virtual(file_of(name))
        if source is not None:
            self._places.add(name)
            if absolute_path(source.path) not in self._read:
                self._interface(source, main=False)

    def _on_disk(self, name: ScopedName, file: InterfaceFile) -> InterfaceFile | None:
        """Return the file of a message that `file` uses. Raises OSError."""
        for path, folder in candidates(name, file.path, self._library.include):
            for each in (path, path.with_suffix(_IDL)):
                source = self._library.open(each, folder)
                if source is not None:
                    return source
        return None
