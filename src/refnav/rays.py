"""What rays hit. It runs on the small runtime, too."""

from math import inf


def hit_wall(
    wall: "tuple[float, float, float, float]", x: float, y: float, dx: float, dy: float
) -> float:
    """How far a wall is from a point in the direction (dx, dy), of length 1; inf if never [m].

    `wall` goes from (x1, y1) to (x2, y2).
    """
    x1, y1, x2, y2 = wall
    along_x, along_y = x2 - x1, y2 - y1
    across = dx * along_y - dy * along_x
    if across == 0.0:
        return inf
    to_x, to_y = x1 - x, y1 - y
    part = (to_x * dy - to_y * dx) / across
    way = (to_x * along_y - to_y * along_x) / across
    return way if 0.0 <= part <= 1.0 and way >= 0.0 else inf
