"""The embedded runtime: what generated code and behaviours import, free of the compiler."""

from rtgen.runtime.buffers import (
    BufferSettings,
    EmptyPolicy,
    FullPolicy,
)
from rtgen.runtime.clocks import (
    SECOND,
    Clock,
    RealClock,
    SimulatedClock,
)
from rtgen.runtime.component import Component
from rtgen.runtime.conf_file import ConfFile
from rtgen.runtime.configuration import (
    DEFAULT_SET,
    ConfigurationSets,
)
from rtgen.runtime.connectors import DataConnector
from rtgen.runtime.data_ports import (
    InPort,
    OutPort,
)
from rtgen.runtime.descriptors import DataType
from rtgen.runtime.errors import (
    ConfFileError,
    ConfigurationError,
    ConnectError,
    ConnectionLimitError,
    ConnectorPropertyError,
    DuplicateConnectionError,
    DuplicateInstanceError,
    DuplicatePortError,
    InitializationError,
    ParameterValueError,
    PolarityError,
    PortTypeError,
    RateError,
    RtcError,
    SampleTypeError,
    UnknownComponentError,
    UnknownConfigurationSetError,
    UnknownConnectionError,
    UnknownObservableError,
    UnknownParameterError,
    UnknownPortError,
)
from rtgen.runtime.execution_context import (
    ExecutionContext,
    Participant,
)
from rtgen.runtime.profiles import (
    ComponentProfile,
    ParameterProfile,
    PortProfile,
)
from rtgen.runtime.recording import JsonLinesRecorder
from rtgen.runtime.records import (
    Listener,
    Record,
    SampleRecord,
    StateRecord,
)
from rtgen.runtime.return_codes import (
    ACTIVE_STATE,
    BAD_PARAMETER,
    CREATED_STATE,
    ERROR_STATE,
    INACTIVE_STATE,
    OUT_OF_RESOURCES,
    PORT_OK,
    PRECONDITION_NOT_MET,
    RTC_ERROR,
    RTC_OK,
    UNSUPPORTED,
    ExecutionKind,
    LifeCycleState,
    PortStatus,
    ReturnCode_t,
)
from rtgen.runtime.service_connectors import ServiceConnector
from rtgen.runtime.service_ports import (
    Consumer,
    Provider,
)
from rtgen.runtime.services import (
    BadOperation,
    ObjectNotExist,
    Servant,
    ServiceError,
    Skeleton,
    Stub,
    UnknownException,
)
from rtgen.runtime.system import (
    Statistics,
    System,
)

__all__ = [
    "ACTIVE_STATE",
    "BAD_PARAMETER",
    "CREATED_STATE",
    "DEFAULT_SET",
    "ERROR_STATE",
    "INACTIVE_STATE",
    "OUT_OF_RESOURCES",
    "PORT_OK",
    "PRECONDITION_NOT_MET",
    "RTC_ERROR",
    "RTC_OK",
    "SECOND",
    "UNSUPPORTED",
    "BadOperation",
    "BufferSettings",
    "Clock",
    "Component",
    "ComponentProfile",
    "ConfFile",
    "ConfFileError",
    "ConfigurationError",
    "ConfigurationSets",
    "ConnectError",
    "ConnectionLimitError",
    "ConnectorPropertyError",
    "Consumer",
    "DataConnector",
    "DataType",
    "DuplicateConnectionError",
    "DuplicateInstanceError",
    "DuplicatePortError",
    "EmptyPolicy",
    "ExecutionContext",
    "ExecutionKind",
    "FullPolicy",
    "InPort",
    "InitializationError",
    "JsonLinesRecorder",
    "LifeCycleState",
    "Listener",
    "ObjectNotExist",
    "OutPort",
    "ParameterProfile",
    "ParameterValueError",
    "Participant",
    "PolarityError",
    "PortProfile",
    "PortStatus",
    "PortTypeError",
    "Provider",
    "RateError",
    "RealClock",
    "Record",
    "ReturnCode_t",
    "RtcError",
    "SampleRecord",
    "SampleTypeError",
    "Servant",
    "ServiceConnector",
    "ServiceError",
    "SimulatedClock",
    "Skeleton",
    "StateRecord",
    "Statistics",
    "Stub",
    "System",
    "UnknownComponentError",
    "UnknownConfigurationSetError",
    "UnknownConnectionError",
    "UnknownException",
    "UnknownObservableError",
    "UnknownParameterError",
    "UnknownPortError",
]
