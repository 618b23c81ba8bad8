"""Lamps that several scenes share."""

from w2c_sim_robot.scenes.scene import Light

DAYLIGHT = (
    Light(position=(-0.8, 1.8, 3.2), direction=(0.45, -0.42, -0.79), brightness=0.6, warmth=0.1),
    Light(
        position=(1.6, -2.0, 3.0),
        direction=(-0.25, 0.55, -0.8),
        brightness=0.3,
        warmth=-0.3,
        shadow=False,
    ),
)
WORKSHOP = (
    Light(position=(-0.4, -1.7, 3.2), direction=(0.3, 0.45, -0.84), brightness=0.62, warmth=0.35),
    Light(
        position=(1.2, 2.0, 3.0),
        direction=(-0.2, -0.6, -0.77),
        brightness=0.26,
        warmth=0.0,
        shadow=False,
    ),
)
