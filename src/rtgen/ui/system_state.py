"""The whole state of a session for its pages."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rtgen.tools.running import texts
from rtgen.ui import connection_properties, description
from rtgen.ui.description import planned
from rtgen.ui.protocol import ui

if TYPE_CHECKING:
    from rtgen.ui.session_view import SessionView


def whole(session: SessionView) -> ui.SystemState:
    """Return the whole state."""
    remote, profile = session.remote, session.profile
    shown = (*session.system.instances, *remote.components)
    components = [session.component(each) for each in shown]
    return ui.SystemState(
        name=remote.run.name or profile.name,
        types=[*session.types.nodes],
        components=components,
        connections=[
            *(description.connection(c) for c in session.connectors),
            *remote.connections.values(),
        ],
        palette=[] if remote.is_attached else session.palette,
        channels=[*session.channels.values(), *session.beside.channels],
        time=session.time(),
        edits=session.edit_state(),
        buses=session.buses.states,
        systems=[*session.project.systems],
        beside=session.beside.name,
        keeps=session.beside.keeps,
        naming=[*remote.services],
        foreign=[*session.foreign],
        plan=(
            [*remote.run.plan]
            or [
                planned(texts.planned(each))
                for each in session.project.timeline(profile).steps
            ]
        ),
        doc=remote.run.doc or profile.abstract,
        properties=connection_properties.parameters(),
    )
