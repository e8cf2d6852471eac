"""Ray casting against walls and posts. Also for the small runtime."""

from math import inf

from refnav.recent import entries


def walls_of(text: str) -> "list[tuple[float, float, float, float]]":
    """Return the walls `X1 Y1 X2 Y2` [m] of a text with semicolons. Raises ValueError."""
    walls = []
    for words in entries(text):
        if len(words) != 4:
            raise ValueError(" ".join(words) + " is not a wall")
        x1, y1, x2, y2 = [float(word) for word in words]
        walls.append((x1, y1, x2, y2))
    return walls


def nearest_wall(
    walls: "list[tuple[float, float, float, float]]",
    x: float,
    y: float,
    dx: float,
    dy: float,
) -> float:
    """Return the distance to the first wall in the direction (dx, dy) [m]; inf without one."""
    nearest = inf
    for wall in walls:
        reach = hit_wall(wall, x, y, dx, dy)
        if reach < nearest:
            nearest = reach
    return nearest


def hit_wall(
    wall: "tuple[float, float, float, float]", x: float, y: float, dx: float, dy: float
) -> float:
    """Return the distance to a wall in a direction (dx, dy) of length 1; inf if not hit [m].

    `wall` goes from (x1, y1) to (x2, y2).
    """
    x1, y1, x2, y2 = wall
    along_x, along_y = x2 - x1, y2 - y1
    across = dx * along_y - dy * along_x
    to_x, to_y = x1 - x, y1 - y
    beside = to_x * dy - to_y * dx
    if across == 0.0:
        start = to_x * dx + to_y * dy
        end = (x2 - x) * dx + (y2 - y) * dy
        if beside != 0.0 or (start < 0.0 and end < 0.0):
            return inf
        return max(0.0, min(start, end))
    part = beside / across
    way = (to_x * along_y - to_y * along_x) / across
    return way if 0.0 <= part <= 1.0 and way >= 0.0 else inf
