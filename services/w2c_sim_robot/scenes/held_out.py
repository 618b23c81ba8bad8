"""What is kept for judging: seeds, kinds, and kinds in certain colours or of certain materials.

Nothing is trained on scenes from `JUDGING_SEED` on, and they alone show what is listed here.
"""

import zlib

from w2c_sim_robot.scenes.objects.catalogue import KINDS

JUDGING_SEED = 900_000

HELD_OUT_KINDS = frozenset(
    {
        "bread", "cactus", "drill", "gearwheel", "hairbrush", "hat", "helmet", "keyboard",
        "milk_carton", "pen_holder", "stapler", "tape", "teapot", "watering_can", "wrench",
    }
)  # fmt: skip
"""A fifth of all kinds, of every group; none that the scenes of the paper need"""
SEVERAL = 3
"""Kinds of so many materials keep the last one for judging"""
HELD_OUT_PAIRS = frozenset(
    {
        ("hammer", "rubber"),
        ("lamp", "plastic"),
        ("pan", "ceramic"),
        ("pipe", "plastic"),
        ("trowel", "plastic"),
    }
)
"""With the last materials above, a fifth of all pairs of the kinds that are trained on"""


def is_judging(seed: int) -> bool:
    """Whether a scene of this seed is for judging."""
    return seed >= JUDGING_SEED


def held_out(kind: str, colour: str) -> bool:
    """Whether this pair is kept for judging: about one in seven, never all colours of a kind."""
    if KINDS[kind].furniture or colour == KINDS[kind].colours[0]:
        return False
    return zlib.crc32(f"{kind}/{colour}".encode()) % 7 == 0


def held_out_material(kind: str, material: str) -> bool:
    """Whether this kind is made of this material for judging only."""
    materials = KINDS[kind].materials
    last_of_several = len(materials) >= SEVERAL and material == materials[-1]
    return last_of_several or (kind, material) in HELD_OUT_PAIRS


def kinds_for(judging: bool) -> tuple[str, ...]:
    """Return the kinds that scenes may show."""
    return tuple(kind for kind in KINDS if judging or kind not in HELD_OUT_KINDS)


def materials_for(kind: str, judging: bool) -> tuple[str, ...]:
    """Return what a kind may be made of, the usual material first."""
    return tuple(
        material
        for material in KINDS[kind].materials
        if judging or not held_out_material(kind, material)
    )
