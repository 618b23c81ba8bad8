"""What a hand must stay above: heights seen by the camera, grown by the hand and a clearance.

A cell of the field is a column from the floor to its height h. A ball of radius R about a point p
is clear of it where

    p_z >= h + sqrt(R^2 - d^2)    for the horizontal distance d < R between p and the column,

so the largest right-hand side over all cells is a floor for the ball's centre. Hand and forearm are
balls along the line from the hand to where the elbow is at rest: the Retargeting's posture cost
holds the elbow near it. Near a point that it reaches for, a hand points with its fingers, and the
balls lie behind them. What is not higher than the surface of the target is no obstacle around it:
the arm goes there. Unseen cells are taken as empty, as far as anybody knows.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from w2c.messages import HeightField
from w2c_controller.compiled import compiled
from w2c_controller.motion.trajectory import Bow, Leg, leg_point

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]
Heights = npt.NDArray[np.float32]

SURROUNDINGS = 0.35
"""Around the target, what is not higher than its surface is no obstacle [m]."""
SURFACE_TOLERANCE = 0.02
"""Above the surface of the target that still counts as the surface [m]"""
NEAR_TARGET = 0.15
NEAR_CLEARANCE = 0.01
"""Of what stands so close to the target that the hand comes down beside it [m]."""
FULL_CLEARANCE = 0.25
"""So far from the target, the whole clearance is kept; between, half of both [m]"""
OBJECT_RADIUS = 0.08
"""Around a point that is reached for, things belong to what is reached for [m]."""
SURFACE_CLEARANCE = 0.02
"""Of the hand's frame from the surface of the target, before the last leg [m]"""
POINTS_WITHIN, POINTS_FROM = 0.15, 0.40
"""How near to its point a reaching hand points at it, and where it begins to turn [m]"""
BEHIND_TIPS = 0.04
"""Of the first ball from the frame of a hand that points: there its fingers end [m]"""
POINTING_RADIUS = 0.055
"""Of an open hand with its fingers, across their opening [m]"""
FREE_ROOM = 0.2
"""Nothing is looked for farther from an arm [m]."""
ROOM_SAMPLES = 5
"""Of the last leg"""
ARM_BALLS = 4
ARM_SPACING = 0.1
"""Balls along hand and forearm, and the distance between them [m]"""
SAMPLES = 96
"""Of a leg; a hand's width apart at most"""
FREE = -1e3
"""Floor where nothing is known to stand [m]"""
RECOVERY = 0.3
"""Share of a leg within which a hand that starts too close must have come clear"""


@dataclass(frozen=True)
class Arm:
    """What travels: a hand with its forearm, and how far it gets."""

    radius: float
    """Of hand and forearm [m]"""
    elbow: Vector
    """(3,) where the elbow is at rest, in the world [m]"""
    shoulder: Vector
    """(3,) at rest [m]"""
    reach: float
    """How far from the shoulder's place at rest a way may lead [m]"""


@dataclass(frozen=True)
class Terrain:
    """Floors for the balls of one arm on its way to one target."""

    arm: Arm
    obstacles: Heights
    """(rows, columns) heights of what must be cleared; `FREE` where there is nothing [m]"""
    travel_floor: Heights
    """(rows, columns) for the way, with clearance [m]"""
    origin: Vector
    """(2,) corner of cell [0, 0] [m]"""
    cell: float
    clearance: float
    """[m]"""
    target: Vector
    """(3,) the point [m]"""
    behind: Vector
    """(3,) unit, from the hand to its wrist at the point; zeros: towards the elbow"""
    planned: Bow | None = None
    """Of the curve that was found to clear it; None: not planned yet"""

    def balls(self, hand: Vector) -> Matrix:
        """Return the centres (ARM_BALLS, 3) of hand and forearm for a hand at a point (3,) [m]."""
        *way, tip = elbow_from_hand(hand, self.arm.elbow, self.target, self.behind)
        length = max(float(np.linalg.norm(way)), 1e-9)
        along = np.minimum(tip + ARM_SPACING * np.arange(ARM_BALLS), length)
        return np.asarray(hand + along[:, None] / length * np.array(way))

    def margin(self, leg: Leg, *, home: bool = False, reach: float = np.inf) -> tuple[float, float]:
        """Return by how much the arm clears its floor where it clears it least, and when [m, s].

        Args:
            leg: That the hand travels.
            home: Whether the leg ends where the hand was before: it may be close to things there.
            reach: Points of the leg farther from the shoulder than this are not clear either [m].
        """
        scratch = np.empty(3)
        return lowest_margin(
            leg.points,
            leg.duration,
            leg.rate,
            leg.drift,
            self.travel_floor,
            self.origin,
            self.cell,
            self.arm.elbow,
            self.arm.shoulder,
            self.target,
            self.behind,
            reach,
            home,
            scratch,
        )

    def room(self, start: Vector, end: Vector) -> float:
        """Return how far the arm stays from everything on a straight way [m]; negative: it hits.

        Without any clearance, but exact to the cell: this is for the last centimetres.

        Args:
            start: (3,) of the hand [m].
            end: (3,) of it [m].
        """
        radius = POINTING_RADIUS if self.behind.any() else self.arm.radius
        gap = FREE_ROOM
        for share in np.linspace(0.0, 1.0, ROOM_SAMPLES):
            balls = self.balls(start + share * (end - start))
            gap = min(gap, smallest_gap(balls, self.obstacles, self.origin, self.cell))
        return gap - radius


@compiled
def smallest_gap(points: Matrix, heights: Heights, origin: Vector, cell: float) -> float:
    """Return the distance of points (n, 3) to the nearest column around them, or `FREE_ROOM`."""
    gap, steps = FREE_ROOM, int(FREE_ROOM / cell) + 1
    for n in range(points.shape[0]):
        x, y, z = points[n, 0], points[n, 1], points[n, 2]
        row = int(np.floor((x - origin[0]) / cell))
        column = int(np.floor((y - origin[1]) / cell))
        for i in range(max(row - steps, 0), min(row + steps + 1, heights.shape[0])):
            dx = max(abs(x - origin[0] - (i + 0.5) * cell) - 0.5 * cell, 0.0)
            for j in range(max(column - steps, 0), min(column + steps + 1, heights.shape[1])):
                dy = max(abs(y - origin[1] - (j + 0.5) * cell) - 0.5 * cell, 0.0)
                dz = max(z - heights[i, j], 0.0)
                gap = min(gap, (dx * dx + dy * dy + dz * dz) ** 0.5)
    return gap


@compiled
def elbow_from_hand(
    hand: Vector, elbow: Vector, target: Vector, behind: Vector
) -> tuple[float, float, float, float]:
    """Return the way from a hand (3,) along its forearm, about as long as to the elbow at rest.

    Returns:
        x, y, z of it, and how far along it the first ball is [m].
    """
    x, y, z = elbow[0] - hand[0], elbow[1] - hand[1], elbow[2] - hand[2]
    if behind[0] == 0.0 and behind[1] == 0.0 and behind[2] == 0.0:
        return x, y, z, 0.0
    length = (x * x + y * y + z * z) ** 0.5
    i, j, k = target[0] - hand[0], target[1] - hand[1], target[2] - hand[2]
    share = (POINTS_FROM - (i * i + j * j + k * k) ** 0.5) / (POINTS_FROM - POINTS_WITHIN)
    share = min(max(share, 0.0), 1.0)
    rest, pointed = 1.0 - share, share * length
    return (
        rest * x + pointed * behind[0],
        rest * y + pointed * behind[1],
        rest * z + pointed * behind[2],
        share * BEHIND_TIPS,
    )


@compiled
def lowest_margin(
    points: Matrix,
    duration: float,
    rate: float,
    drift: Vector,
    floor: Heights,
    origin: Vector,
    cell: float,
    elbow: Vector,
    shoulder: Vector,
    target: Vector,
    behind: Vector,
    reach: float,
    home: bool,
    point: Vector,
) -> tuple[float, float]:
    """Return the least margin of an arm along a leg [m], and its time [s]; see `Terrain.margin`.

    A hand that starts below its floor may come clear on the first part of the leg; one that comes
    home may be as close to things as it was there.
    """
    worst, when, first, last = 1e3, 0.0, 0.0, 0.0
    for step in range(-2, SAMPLES + 1):
        # Both ends first: they say what must be forgiven.
        n = SAMPLES if step == -2 else max(step, 0)
        time = duration * n / SAMPLES
        leg_point(points, duration, rate, drift, time, point)
        x, y, z, tip = elbow_from_hand(point, elbow, target, behind)
        length = max((x * x + y * y + z * z) ** 0.5, 1e-9)
        margin = 1e3
        for ball in range(ARM_BALLS):
            along = min((tip + ball * ARM_SPACING) / length, 1.0)
            row = int(np.floor((point[0] + along * x - origin[0]) / cell))
            column = int(np.floor((point[1] + along * y - origin[1]) / cell))
            if 0 <= row < floor.shape[0] and 0 <= column < floor.shape[1]:
                margin = min(margin, point[2] + along * z - floor[row, column])
        x, y, z = point[0] - shoulder[0], point[1] - shoulder[1], point[2] - shoulder[2]
        margin = min(margin, reach - (x * x + y * y + z * z) ** 0.5)
        if step == -2:
            last = min(margin, 0.0) if home else 0.0
        elif step == -1:
            first = min(margin, 0.0)
        allowed = first * max(1.0 - n / (RECOVERY * SAMPLES), 0.0)
        allowed = min(allowed, last * max(1.0 - (SAMPLES - n) / (RECOVERY * SAMPLES), 0.0))
        if step >= 0 and margin - allowed < worst:
            worst, when = margin - allowed, time
    return worst, when


def make_terrain(
    field: HeightField, arm: Arm, point: Vector, normal: Vector, clearance: float, *, reach: bool
) -> Terrain:
    """Return the terrain of an arm on its way to a point of a surface.

    Args:
        field: What the camera saw.
        arm: That goes there.
        point: (3,) on the surface [m].
        normal: (3,) unit, of the surface.
        clearance: Between the arm and everything on its way [m].
        reach: Whether the point is reached for rather than leaned on.
    """
    heights = np.asarray(field.heights, dtype=np.float64)
    heights = np.where(np.isfinite(heights), heights, FREE)
    rows, columns = heights.shape
    x = field.origin[0] + (np.arange(rows) + 0.5) * field.cell - point[0]
    y = field.origin[1] + (np.arange(columns) + 0.5) * field.cell - point[1]
    away = np.hypot(x[:, None], y[None, :])
    above = normal[0] * x[:, None] + normal[1] * y[None, :] + normal[2] * (heights - point[2])
    surface = (away < SURROUNDINGS) & (above < SURFACE_TOLERANCE + 0.5 * field.cell)
    if reach:
        surface |= away < OBJECT_RADIUS
    obstacles = np.where(surface, FREE, heights)
    ground = np.where(surface & (above < SURFACE_TOLERANCE), heights, FREE)
    half = 0.5 * (NEAR_CLEARANCE + clearance)
    travel = ground + SURFACE_CLEARANCE
    for low, high, kept in (
        (0.0, NEAR_TARGET, NEAR_CLEARANCE),
        (NEAR_TARGET, FULL_CLEARANCE, half),
        (FULL_CLEARANCE, np.inf, clearance),
    ):
        ring = np.where((low <= away) & (away < high), obstacles, FREE)
        np.maximum(travel, _grow(ring, arm.radius + kept, field.cell), out=travel)
    return Terrain(
        arm=arm,
        obstacles=obstacles.astype(np.float32),
        travel_floor=travel.astype(np.float32),
        origin=np.array(field.origin),
        cell=float(field.cell),
        clearance=clearance,
        target=np.array(point),
        behind=np.zeros(3),
    )


def _grow(heights: Matrix, radius: float, cell: float) -> Matrix:
    """Return the floor (rows, columns) of a ball's centre above columns of these heights.

    Ball and column may be anywhere in their cells: the distance is the least that both allow.
    """
    steps = int(np.ceil(radius / cell)) + 1
    padded = np.pad(heights, steps, constant_values=FREE)
    rows, columns = heights.shape
    floor = np.full_like(heights, FREE)
    for i in range(-steps, steps + 1):
        for j in range(-steps, steps + 1):
            squared = cell**2 * (max(abs(i) - 1, 0) ** 2 + max(abs(j) - 1, 0) ** 2)
            if squared >= radius**2:
                continue
            shifted = padded[steps + i : steps + i + rows, steps + j : steps + j + columns]
            rise = float(np.sqrt(radius**2 - squared))
            np.maximum(floor, np.where(shifted > FREE, shifted + rise, FREE), out=floor)
    return floor
