"""State of an evaluated function, to merge the branches of a statement."""

from __future__ import annotations

from dataclasses import dataclass

from rtgen.openrtm.python_modules.values import Frame, Value, merged


@dataclass(frozen=True, slots=True)
class State:
    """The variables of a function and the attributes of its object at one point."""

    names: dict[str, Value]
    attributes: dict[str, Value]

    @classmethod
    def of(cls, frame: Frame) -> State:
        """Return a copy of the current state."""
        held = {} if frame.component is None else frame.component.attributes
        names = frame.module.names if frame.names is None else frame.names
        return cls(dict(names), dict(held))

    def restore(self, frame: Frame) -> None:
        """Return to this state."""
        names = frame.module.names if frame.names is None else frame.names
        names.clear()
        names.update(self.names)
        if frame.component is not None:
            frame.component.attributes.clear()
            frame.component.attributes.update(self.attributes)

    def merged(self, other: State) -> State:
        """Return the state after one of two branches; values that differ are merged."""
        return State(
            _merged(self.names, other.names), _merged(self.attributes, other.attributes)
        )


def _merged(one: dict[str, Value], other: dict[str, Value]) -> dict[str, Value]:
    values = {**other, **one}
    for name in one.keys() & other.keys():
        values[name] = merged(one[name], other[name])
    return values
