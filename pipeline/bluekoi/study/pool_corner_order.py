"""Whether four pool corners go round the pool once, in the order that the contract asks for."""

from __future__ import annotations

Corner = tuple[float, float]
CORNER_ORDER_TEXT = (
    "the images of pool (0,0), (length,0), (length,width), (0,width) "
    "in this order, seen from above (counter-clockwise in the pool, image v downwards)"
)
CLOCKWISE_CORNERS_PROBLEM = (
    "these go round the other way: swap the second and the fourth, "
    "or, if each pair is written as [v, u], write it as [u, v]"
)


def corner_order_problems(corners: tuple[Corner, ...]) -> list[str]:
    """What is wrong with the order of the corners; nothing where all turns are to one side.

    The cross product of consecutive edges has the sign of the turn; v points down in the image.
    """
    turns = [_edge_cross_product(*(corners[(i + k) % 4] for k in range(3))) for i in range(4)]
    if all(turn < 0 for turn in turns):
        return []
    if all(turn > 0 for turn in turns):
        return [f"{CORNER_ORDER_TEXT}; {CLOCKWISE_CORNERS_PROBLEM}"]
    return [CORNER_ORDER_TEXT + "; these cross over or lie on a line"]


def _edge_cross_product(a: Corner, b: Corner, c: Corner) -> float:
    """Cross product of the edges a to b and b to c, px^2."""
    return (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])
