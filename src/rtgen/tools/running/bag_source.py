"""A bag of ROS 2 as the source of a replay: it drives the ports that are bound to topics."""

from __future__ import annotations

from collections.abc import Callable, Collection
from contextlib import ExitStack
from typing import TYPE_CHECKING, Protocol

from msgspec.structs import replace

from rtgen import runtime
from rtgen.compiler.diagnostics import Diagnostic, InputError
from rtgen.compiler.model import System
from rtgen.compiler.project import Project
from rtgen.compiler.systems.rules import NO_TOPIC, OBSERVABLE
from rtgen.tools.kit.console import Console
from rtgen.tools.recording.bag_files import Recording
from rtgen.tools.recording.bag_writer import PROFILE
from rtgen.tools.recording.replay import is_run
from rtgen.tools.recording.selection import near_names
from rtgen.tools.recording.topic_replay import LocalMedium, TopicReplay, survey
from rtgen.tools.running.partition import alone
from rtgen.tools.running.ros2 import topic_joints

if TYPE_CHECKING:
    from rtgen.runtime.ros2.ports import Joint
    from rtgen.tools.recording.bag_recorder import BagRecorder


class Source(Protocol):
    """What a replay reads, and the system that it is replayed into."""

    @property
    def profile(self) -> System:
        """The components and connections that run, with those that play others."""

    @property
    def clock(self) -> runtime.SimulatedClock:
        """The clock of the system."""

    @property
    def has_topics(self) -> bool:
        """Whether the system has topics, which are recorded as a bag."""

    @property
    def through(self) -> bool:
        """Whether the actions due at the end are executed."""

    @property
    def prepare(self) -> Callable[[runtime.System], None] | None:
        """Function called before the components are connected."""

    def begin(
        self, files: ExitStack, running: runtime.System, bag: BagRecorder | None
    ) -> None:
        """Connect the system until `files` is closed; `bag` records its topics.

        Raises InputError.
        """

    def run(self, running: runtime.System, until: int | None) -> None:
        """Run to the end, or until an earlier time [ns]. Raises RecordingError."""


def is_bag(recorded: Recording) -> bool:
    """Return whether a recording has topics of ROS 2 instead of the events of a run."""
    if is_run(recorded):
        return False
    return recorded.profile == PROFILE or any(
        message.channel.schema.encoding.startswith(PROFILE)
        for message in recorded.messages()
    )


class BagSource:
    """A bag; see `Source`."""

    has_topics = True
    through = True
    prepare = None

    def __init__(
        self,
        recorded: Recording,
        project: Project,
        profile: System,
        present: Collection[str],
        console: Console,
    ) -> None:
        """Read through a bag. Raises RecordingError."""
        self._survey = survey(recorded)
        self._project = project
        self._console = console
        self._absent = frozenset(c.instance for c in profile.components) - {*present}
        self.clock = runtime.SimulatedClock(self._survey.start)
        self.profile = replace(alone(profile, present), properties=())

    def begin(
        self, files: ExitStack, running: runtime.System, bag: BagRecorder | None
    ) -> None:
        """See `Source`."""
        from rtgen.runtime.ros2.network import RosNetwork
        from rtgen.runtime.ros2.ports import RosPorts

        joints = topic_joints(self._project, running, self._absent)
        medium = LocalMedium()
        network = RosNetwork(medium)
        if bag is not None:
            network.observe(bag.observe)
            running.at(0, bag.begin)
        files.callback(RosPorts(network, joints).close)
        read = [each for each in joints if isinstance(each.port, runtime.InPort)]
        played = [each for each in read if each.topic not in medium.written]
        self._tell_missing(played)
        known = [each for each in played if each.topic in self._survey.channels]
        types = {
            each.topic: each.marshaling.message if each.marshaling else each.port.type
            for each in known
        }
        self._replay = TopicReplay(self._survey, types, medium.deliver)

    def run(self, running: runtime.System, until: int | None) -> None:
        """See `Source`."""
        self._replay.run(running, until)

    def _tell_missing(self, played: list[Joint]) -> None:
        """Warn of the topics that the bag lacks. Raises InputError if it has none of them."""
        channels = self._survey.channels
        path = self._survey.bag.path
        missing = [each for each in played if each.topic not in channels]
        is_none = len(missing) == len(played)
        if is_none and not played:
            hint = '[ros2.topics] "INSTANCE.PORT" = "TOPIC" in rtgen.toml binds it'
            message = f"no InPort of the system reads a topic that {path} could have"
            raise InputError([OBSERVABLE.at(None, message, hint=hint)])
        rule = OBSERVABLE if is_none else NO_TOPIC
        findings: list[Diagnostic] = [
            rule.at(
                None,
                f"{path} has no topic {each.topic}, which {each.port} reads",
                hint=near_names(each.topic, channels),
            )
            for each in missing
        ]
        if is_none:
            raise InputError(findings)
        if findings:
            self._console.findings(findings)
