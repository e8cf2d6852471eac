"""Converts errors of calls to system exceptions of CORBA and back."""

from __future__ import annotations

from typing import Any

import omniORB
from omniORB import CORBA

from rtgen.runtime.services.calls import REPORTED_AS, SYSTEM_EXCEPTIONS, kind_of
from rtgen.runtime.services.servants import (
    BadOperation,
    CallTimeout,
    MarshalError,
    ObjectNotExist,
    ServiceError,
)

_OURS = 0
"""Minor code of exceptions raised by rtgen's servants."""
_BEFORE_THE_CALL = (BadOperation, MarshalError, ObjectNotExist)

_LOST = (
    CORBA.TRANSIENT,
    CORBA.COMM_FAILURE,
    CORBA.OBJECT_NOT_EXIST,
    CORBA.INV_OBJREF,
)


def raised(error: ServiceError) -> Any:
    """Convert an error to the exception that omniORB sends to the client."""
    kind = kind_of(error)
    begun = not isinstance(error, _BEFORE_THE_CALL)
    completed = CORBA.COMPLETED_MAYBE if begun else CORBA.COMPLETED_NO
    return getattr(CORBA, REPORTED_AS[kind])(_OURS, completed)


def caught(operation: str, error: Any) -> ServiceError:
    """Convert a system exception of omniORB to an error."""
    kind = SYSTEM_EXCEPTIONS.get(error._NP_RepositoryId, ServiceError)
    minor = omniORB.minorCodeToString(error) or f"minor {error.minor}"
    if is_timeout(error):
        kind = CallTimeout
    name = error._NP_RepositoryId.split("/")[-1].partition(":")[0]
    completed = str(error.completed).removeprefix("COMPLETED_").lower()
    return kind(f"{operation}: {name} ({minor}, completed: {completed})")


def is_inactive(error: Any) -> bool:
    """Return whether the object exists, but its component is not ACTIVE.

    omniORB's minor code shows it.
    """
    return isinstance(error, CORBA.OBJECT_NOT_EXIST) and error.minor == _OURS


def is_unsent(error: Any) -> bool:
    """Return whether a system exception implies that the call was not executed."""
    return bool(error.completed == CORBA.COMPLETED_NO)


def is_lost(error: Any) -> bool:
    """Return whether a system exception means that the object or its process is gone."""
    return isinstance(error, _LOST)


def is_timeout(error: Any) -> bool:
    """Return whether a system exception means that there was no answer in time."""
    minor = omniORB.minorCodeToString(error) or ""
    return isinstance(error, CORBA.TIMEOUT) or "Timedout" in minor


def is_silent(error: Any) -> bool:
    """Return whether the object or its process is gone, or did not respond in time."""
    return isinstance(error, (*_LOST, CORBA.TIMEOUT))
