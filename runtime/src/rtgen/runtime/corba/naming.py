"""Client of the naming service, by which processes find each other's providers.

A provider is bound as `<instance>.<port>/<name>`: a context for the port (id: instance name, kind:
port name) that contains the provider under its instance name.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from itertools import islice
from typing import Any

import CosNaming
import msgspec
import omniORB
from omniORB import CORBA

from rtgen.runtime.corba.faults import is_silent
from rtgen.runtime.errors import (
    NoNamingServiceError,
    ServedElsewhereError,
    TransportError,
)

PORT = 2809
"""Default port of naming services (IANA: corbaloc)."""
_AT_ONCE = 100
MAX_NAMES = 4096
"""Maximum number of names listed; contexts can contain each other."""
_MAX_DEPTH = 64
"""Maximum number of contexts within each other whose names are listed."""
_HOST = "host_cxt"
"""Kind of the contexts in which OpenRTM binds the components of a host."""

_Context = CosNaming.NamingContext


class Bound(msgspec.Struct, frozen=True):
    """A name of a naming service: its path of ids and kinds, and the object; None for a context."""

    path: tuple[tuple[str, str], ...]
    reference: Any

    @property
    def text(self) -> str:
        """The path as text (CosNaming 2.4, stringified names): `rh3.host_cxt/Arm0.rtc`."""
        return "/".join(map(_name_text, self.path))


class Naming:
    """A naming service at `HOST` or `HOST:PORT`. All methods raise TransportError.

    `limit` bounds the calls of a reference; without it, the options of the process's ORB do.
    Raises NoNamingServiceError if none answers.
    """

    def __init__(
        self, orb: Any, address: str, limit: Callable[[Any], None] | None = None
    ) -> None:
        self.address = address if ":" in address else f"{address}:{PORT}"
        self._limit = limit
        self._root: Any = None
        text = f"corbaloc::{self.address}/NameService"
        try:
            self._root = self._narrowed(orb.string_to_object(text))
        except (CORBA.Exception, ValueError) as error:
            _raise_interrupt(error)
            raise NoNamingServiceError(
                f"no naming service answers at {self.address}: {_error_text(error)}"
            ) from error
        if self._root is None:
            raise NoNamingServiceError(
                f"the object at {self.address} is not a naming service"
            )

    def _narrowed(self, reference: Any) -> Any:
        """Return a reference as a naming context; None for another object."""
        if self._limit is not None:
            self._limit(reference)
        context = reference._narrow(_Context)
        if context is not None and self._limit is not None:
            self._limit(context)
        return context

    def bind(self, port: tuple[str, str], name: str, reference: Any) -> None:
        """Bind a provider of a port, replacing one that no longer exists.

        Raises ServedElsewhereError if the bound provider still responds.
        """
        with self._asking("bind"):
            bound = _resolved(self._root, *port)
            if not is_alive(bound):
                with suppress(_Context.NotFound):
                    self._root.unbind(_path(*port))
                bound = None
            context = self._entered(bound)
            if context is None:
                context = self._root.bind_new_context(_path(*port))
            self._check_free(context, (name,), f"{'.'.join(port)}:{name}")
            context.rebind(_path(name), reference)

    def unbind(self, port: tuple[str, str], name: str, reference: Any) -> None:
        """Unbind a provider, unless the name has been bound to another one since."""
        with self._asking("unbind"):
            context = self._entered(_resolved(self._root, *port))
            bound = None if context is None else _resolved(context, name)
            if bound is None or not bound._is_equivalent(reference):
                return
            context.unbind(_path(name))
            with suppress(_Context.NotEmpty):
                context.destroy()
                self._root.unbind(_path(*port))

    def bind_object(self, name: tuple[str, str], reference: Any) -> None:
        """Bind an object by id and kind, replacing one that no longer exists.

        Raises ServedElsewhereError if the bound one still responds.
        """
        with self._asking("bind"):
            self._check_free(self._root, name, ".".join(name))
            self._root.rebind(_path(*name), reference)

    def unbind_object(self, name: tuple[str, str], reference: Any) -> None:
        """Unbind an object, unless the name has been bound to another one since."""
        with self._asking("unbind"):
            bound = _resolved(self._root, *name)
            if bound is not None and bound._is_equivalent(reference):
                self._root.unbind(_path(*name))

    def _check_free(self, context: Any, name: tuple[str, ...], shown: str) -> None:
        """Raise ServedElsewhereError if the object of a name in a context responds."""
        if is_alive(_resolved(context, *name)):
            raise ServedElsewhereError(
                f"{shown} is served by another process already, "
                f"says the naming service at {self.address}"
            )

    def component(self, name: str, kind: str) -> Any:
        """Return the object of a name in the root, or in a host's context, as OpenRTM does.

        None if there is none.
        """
        with self._asking("ask"):
            found = _resolved(self._root, name, kind)
            hosts = [] if found is not None else _names(self._root)
            for id_, host, _ in hosts:
                if found is None and host == _HOST:
                    context = self._entered(_resolved(self._root, id_, host))
                    with _passing_over_faults():
                        found = context and _resolved(context, name, kind)
            return found

    def at(self, path: Sequence[tuple[str, str]]) -> Any:
        """Return the object of a path of ids and kinds; None if there is none."""
        first, *rest = path
        with self._asking("ask"):
            found = _resolved(self._root, *first)
            for each in rest:
                context = self._entered(found)
                found = None
                with _passing_over_faults():
                    found = context and _resolved(context, *each)
            return found

    def tree(self, most: int = MAX_NAMES) -> list[Bound]:
        """Return up to `most` names in order, each after the context that contains it."""
        with self._asking("ask"):
            names = _names(self._root)
            return [*islice(self._below(self._root, names, (), []), most)]

    def _below(
        self,
        context: Any,
        names: _Names,
        path: tuple[tuple[str, str], ...],
        around: list[Any],
    ) -> Iterator[Bound]:
        """Yield the bindings of a context; `around` are the contexts that contain it."""
        inside = [*around, context]
        for id_, kind, is_context in names:
            here = (*path, (id_, kind))
            found = _resolved(context, id_, kind)
            yield Bound(here, None if is_context else found)
            is_entered = is_context and len(inside) < _MAX_DEPTH
            within = self._entered(found) if is_entered else None
            if within is None or any(within._is_equivalent(each) for each in inside):
                continue
            with _passing_over_faults():
                yield from self._below(within, _names(within), here, inside)

    def providers(self, port: tuple[str, str]) -> dict[str, Any]:
        """Return the bound providers of a port by name."""
        with self._asking("ask"):
            context = self._entered(_resolved(self._root, *port))
            found = {}
            with _passing_over_faults():
                names = [] if context is None else _names(context)
                found = {name: _resolved(context, name) for name, _, _ in names}
            return {name: r for name, r in found.items() if r is not None}

    def _entered(self, reference: Any) -> Any:
        """Return the context of an entry; None without, or if it leads nowhere."""
        with _passing_over_faults():
            return None if reference is None else self._narrowed(reference)

    @contextmanager
    def _asking(self, what: str) -> Iterator[None]:
        """Raise errors of omniORB as TransportError."""
        try:
            yield
        except (CORBA.Exception, ValueError) as error:
            _raise_interrupt(error)
            raise TransportError(
                f"cannot {what} at the naming service {self.address}: {_error_text(error)}"
            ) from error


def _raise_interrupt(error: Exception) -> None:
    """Raise KeyboardInterrupt if that was the reason for an error of omniORBpy.

    A signal handler that raises during a call ends it with this error; it runs in the main thread.
    Elsewhere, the error is that of an object which is implemented in Python.
    """
    reason = getattr(error, "minor", None)
    if (
        isinstance(error, CORBA.UNKNOWN)
        and reason == omniORB.UNKNOWN_PythonException
        and threading.current_thread() is threading.main_thread()
    ):
        raise KeyboardInterrupt from error


@contextmanager
def _passing_over_faults() -> Iterator[None]:
    """End the block at an entry whose object is gone, silent or faulty: others are good."""
    try:
        yield
    except CORBA.Exception as error:
        _raise_interrupt(error)


def _path(id_: str, kind: str = "") -> list[Any]:
    return [CosNaming.NameComponent(id_, kind)]


def _resolved(context: Any, id_: str, kind: str = "") -> Any:
    try:
        return context.resolve(_path(id_, kind))
    except _Context.NotFound:
        return None


def _listed(context: Any) -> list[Any]:
    """Return up to MAX_NAMES bindings of a context."""
    next_ones, more = context.list(_AT_ONCE)
    found = list(next_ones)
    if more is None:
        return found[:MAX_NAMES]
    try:
        remain = True
        while remain and len(found) < MAX_NAMES:
            remain, next_ones = more.next_n(_AT_ONCE)
            remain = remain and bool(next_ones)
            found += next_ones
    finally:
        more.destroy()
    return found[:MAX_NAMES]


_Names = list[tuple[str, str, bool]]
"""The ids and kinds of bindings, and whether each is a context."""


def _names(context: Any) -> _Names:
    return sorted(
        (name.id, name.kind, each.binding_type is CosNaming.ncontext)
        for each in _listed(context)
        for name in each.binding_name[:1]
    )


def _name_text(name: tuple[str, str]) -> str:
    parts = [
        part.replace("\\", "\\\\").replace("/", "\\/").replace(".", "\\.")
        for part in name
    ]
    return ".".join(parts) if parts[1] else parts[0]


def is_alive(reference: Any) -> bool:
    """Return whether the process of an object responds in time."""
    if reference is None:
        return False
    try:
        reference._non_existent()
    except CORBA.SystemException as error:
        return not is_silent(error)
    return True


def _error_text(error: Exception) -> str:
    return repr(error).replace("CORBA.", "").replace("omniORB.", "")
