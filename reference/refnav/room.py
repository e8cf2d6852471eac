"""A plan of walls and posts: ray casting, and distances from anything."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, hypot, inf, sin, sqrt
from typing import NamedTuple

from refnav.geometry import Pose
from refnav.map_text import lines, map_error
from refnav.rays import hit_wall


class Wall(NamedTuple):
    """A wall from one point to another [m]."""

    x1: float
    y1: float
    x2: float
    y2: float

    def distance(self, x: float, y: float) -> float:
        """Return the distance of a point from the wall [m]."""
        dx, dy = self.x2 - self.x1, self.y2 - self.y1
        part = ((x - self.x1) * dx + (y - self.y1) * dy) / (dx * dx + dy * dy)
        part = min(1.0, max(0.0, part))
        return hypot(self.x1 + part * dx - x, self.y1 + part * dy - y)

    def hit(self, x: float, y: float, dx: float, dy: float) -> float:
        """Return the distance to the wall in a direction of length 1 [m]; inf if not hit."""
        return hit_wall(self, x, y, dx, dy)


class Post(NamedTuple):
    """A round post [m]."""

    x: float
    y: float
    radius: float

    def distance(self, x: float, y: float) -> float:
        """Return the distance of a point from the surface, negative within [m]."""
        return hypot(self.x - x, self.y - y) - self.radius

    def hit(self, x: float, y: float, dx: float, dy: float) -> float:
        """Return the distance to the post in a direction of length 1 [m]; inf if not hit."""
        to_x, to_y = self.x - x, self.y - y
        along = to_x * dx + to_y * dy
        beside = to_x * dy - to_y * dx
        left = self.radius * self.radius - beside * beside
        if along < 0.0 or left < 0.0:
            return inf
        return max(0.0, along - sqrt(left))


class Room:
    """Walls and posts of a room."""

    def __init__(self, things: Sequence[Wall | Post]) -> None:
        self.things = things

    def distance(self, x: float, y: float) -> float:
        """Return the distance of a point from the nearest thing [m]; inf in an empty room."""
        return min((thing.distance(x, y) for thing in self.things), default=inf)

    def ranges(self, pose: Pose, angles: Sequence[float], most: float) -> list[float]:
        """Return the distances that a range finder at a pose measures at these angles [rad].

        Inf beyond `most` [m].
        """
        x, y, theta = pose
        near = [thing for thing in self.things if thing.distance(x, y) <= most]
        found = []
        for angle in angles:
            dx, dy = cos(theta + angle), sin(theta + angle)
            reach = min((thing.hit(x, y, dx, dy) for thing in near), default=inf)
            found.append(reach if reach <= most else inf)
        return found


def parse(text: str, name: str) -> Room:
    """Parse the room in a file's text; `name` is used in errors. Raises MapError.

    `w X1 Y1 X2 Y2` is a wall, `c X Y RADIUS` a post [m].
    """
    things: list[Wall | Post] = []
    for line, letter, values in lines(text, name, {"w": 4, "c": 3}):
        if letter == "w":
            wall = Wall(*values)
            if wall[:2] == wall[2:]:
                raise map_error(name, line, "a wall has a length")
            things.append(wall)
        else:
            post = Post(*values)
            if post.radius <= 0.0:
                raise map_error(name, line, "a post has a radius above 0")
            things.append(post)
    return Room(things)
