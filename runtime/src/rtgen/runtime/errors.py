"""All errors raised by the runtime, under one base class."""

from __future__ import annotations

from types import CodeType

from rtgen.runtime.stack_frames import shown


class RtcError(Exception):
    """Base class of the runtime's errors, except those of service calls (`services`)."""


class InitializationError(RtcError):
    """`on_initialize` failed, so the component cannot be added to a system."""


class CallbackError(RtcError, TypeError):
    """A callback has a wrong signature or result; `code` is the callback's code."""

    def __init__(self, what: str, code: CodeType | None = None) -> None:
        self.code = code
        super().__init__(what)


class ParametersError(CallbackError):
    """A callback cannot be called with the arguments of the life cycle."""


class ReturnValueError(CallbackError):
    """A callback returned a value that is not a ReturnCode_t."""

    def __init__(self, returned: str, code: CodeType | None = None) -> None:
        super().__init__(
            f"the callback returned {returned}, which is not a ReturnCode_t: "
            "does it end with 'return RTC_OK'?",
            code,
        )


class BlockedError(RtcError):
    """A callback did not return; `file` and `line` are its last known place."""

    def __init__(self, callback: str, file: str, line: int) -> None:
        self.callback = callback
        self.file = file
        self.line = line
        super().__init__(f"{callback} has not returned ({shown(file)}, line {line})")


class EndOfRunError(Exception):
    """A call that a callback waits for ends with the run; the callback counts as done."""


class CheckpointError(RtcError):
    """The state of a component cannot be stored."""


class DuplicateInstanceError(RtcError):
    """A component of that instance name already exists in the system."""


class UnknownComponentError(RtcError):
    """A system has no component of that instance name."""


class ConnectError(RtcError):
    """Two ports cannot be connected; subclasses give the reason."""


class UnknownPortError(ConnectError):
    """The component has no port of that name."""


class PolarityError(ConnectError):
    """The ports do not complement each other, such as two OutPorts or two providers."""


class PortTypeError(ConnectError):
    """The data types or interfaces of the two ends differ; the message shows both."""


class DuplicateConnectionError(ConnectError):
    """The two ports are already connected, or a connection of that name exists."""


class ConnectionLimitError(ConnectError):
    """One more connection would exceed `dataport.fan_in` or `dataport.fan_out`."""


class ConnectorPropertyError(ConnectError):
    """A connector property is unknown, ill-typed, or contradicts another."""


class UnknownConnectionError(RtcError):
    """There is no connection of that name, or it was removed."""


class UnknownObservableError(RtcError):
    """The component has no observable of that name."""


class ObservableError(RtcError):
    """A function for an observable raised (see the cause), or did not return numbers."""


class ConfigurationError(RtcError):
    """Base of the errors about configuration parameters and sets."""


class UnknownParameterError(ConfigurationError):
    """The component has no configuration parameter of that name."""


class UnknownConfigurationSetError(ConfigurationError):
    """The component has no configuration set of that id."""


class ParameterValueError(ConfigurationError):
    """A text is not of the parameter's type, or violates its range or constraint."""


class ConfFileError(ConfigurationError):
    """A `.conf` file cannot be read: the message has file, line and reason.

    `line` is 0 if the whole file cannot be read.
    """

    def __init__(self, name: str, line: int, reason: str) -> None:
        super().__init__(f"{name}:{line}: {reason}" if line else f"{name}: {reason}")
        self.line = line
        self.reason = reason


class SampleTypeError(RtcError, TypeError):
    """A sample of another class than the port's was written."""


class DuplicatePortError(RtcError):
    """A component already has a port of that name and kind."""


class RateError(RtcError, ValueError):
    """A rate is not a number of Hz above 0."""


class EndlessFlowError(RtcError):
    """Samples execute event-driven components in a cycle, so simulated time would stand still."""


class TransportError(RtcError):
    """The transport of service calls cannot work as configured, or the naming service is gone."""


class NoNamingServiceError(TransportError):
    """No naming service answers at the configured address."""


class ServedElsewhereError(TransportError):
    """Another process provides a component of that instance name."""
