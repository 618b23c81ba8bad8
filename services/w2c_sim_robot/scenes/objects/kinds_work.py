"""Rows of the catalogue: tools, garden, industry."""

from w2c_sim_robot.scenes.objects import garden, industry, tools, workshop
from w2c_sim_robot.scenes.objects.kind import Kind

BEECH = {"brown": (0.80, 0.60, 0.37)}
CLAY = {"brown": (0.66, 0.33, 0.20)}

TOOLS: dict[str, Kind] = {
    "toolbox": Kind(
        tools.toolbox, ("toolbox", "tool box"), "metal", (0.2, 0.4, 0.21), (0.1, 0.12, 0.12),
        ("red", "blue", "grey", "black", "yellow", "orange", "green"), 6.0, "carries",
        group="tools", other_materials=("plastic", "wood"), floor=True,
    ),
    "mallet": Kind(
        tools.mallet, ("mallet", "hammer"), "rubber", (0.32, 0.12, 0.07), (0.1, 0.1, 0.1),
        ("black", "white", "red", "orange", "blue", "green", "grey"), 0.8, "slides",
        group="tools", other_materials=("wood", "plastic"),
    ),
    "hammer": Kind(
        workshop.hammer, ("hammer", "claw hammer"), "wood", (0.31, 0.13, 0.028), (0.06, 0.06, 0.05),
        ("brown", "red", "yellow", "black", "blue"), 0.6, "slides", tones=BEECH, group="tools",
        other_materials=("rubber",),
    ),
    "screwdriver": Kind(
        workshop.screwdriver, ("screwdriver",), "plastic",
        (0.23, 0.028, 0.028), (0.1, 0.05, 0.05),
        ("red", "yellow", "blue", "green", "orange", "black"), 0.12, "slides", group="tools",
        other_materials=("wood", "rubber"),
    ),
    "wrench": Kind(
        workshop.wrench, ("wrench", "spanner"), "metal", (0.22, 0.048, 0.012), (0.1, 0.05, 0.1),
        ("grey", "black", "red", "blue"), 0.3, "slides", group="tools",
    ),
    "drill": Kind(
        workshop.drill, ("drill", "power drill", "cordless drill"), "plastic",
        (0.2, 0.23, 0.058), (0.04, 0.04, 0.04),
        ("green", "yellow", "blue", "red", "orange", "turquoise"), 1.3, "slides", group="tools",
    ),
    "nail_box": Kind(
        workshop.nail_box, ("nail box", "box of nails", "nails"), "cardboard",
        (0.11, 0.15, 0.07), (0.1, 0.1, 0.1),
        ("brown", "yellow", "red", "blue", "green", "white"), 1.2, "slides",
        tones={"brown": (0.66, 0.49, 0.31)}, group="tools", other_materials=("wood", "plastic"),
    ),
    "tape": Kind(
        workshop.tape, ("tape", "roll of tape", "adhesive tape"), "plastic",
        (0.11, 0.11, 0.045), (0.05, 0.05, 0.1),
        ("brown", "grey", "yellow", "red", "black", "blue"), 0.2, "slides", group="tools",
    ),
}  # fmt: skip

GARDEN: dict[str, Kind] = {
    "flower_pot": Kind(
        garden.flower_pot, ("plant", "flower pot", "potted plant"), "ceramic",
        (0.22, 0.22, 0.26), (0.05, 0.05, 0.12),
        ("brown", "white", "blue", "grey", "yellow", "turquoise"), 1.2, "fragile", tones=CLAY,
        group="garden", other_materials=("plastic", "stone"), floor=True,
    ),
    "cactus": Kind(
        garden.cactus, ("cactus",), "ceramic", (0.15, 0.16, 0.26), (0.05, 0.05, 0.12),
        ("brown", "white", "red", "yellow", "blue"), 0.8, "forbidden", tones=CLAY, group="garden",
    ),
    "watering_can": Kind(
        garden.watering_can, ("watering can",), "metal",
        (0.15, 0.35, 0.21), (0.04, 0.04, 0.08),
        ("grey", "green", "blue", "red", "yellow", "turquoise"), 0.8, "slides", group="garden",
        other_materials=("plastic",), floor=True,
    ),
    "trowel": Kind(
        garden.trowel, ("trowel", "garden shovel", "small shovel"), "wood",
        (0.305, 0.07, 0.028), (0.06, 0.06, 0.05),
        ("brown", "green", "red", "blue", "orange"), 0.25, "slides", tones=BEECH, group="garden",
        other_materials=("plastic",),
    ),
    "bucket": Kind(
        industry.bucket, ("bucket", "pail"), "plastic", (0.27, 0.27, 0.25), (0.03, 0.03, 0.08),
        ("blue", "red", "green", "yellow", "grey", "black", "white"), 0.7, "slides",
        group="garden", other_materials=("metal",), floor=True,
    ),
}  # fmt: skip

INDUSTRY: dict[str, Kind] = {
    "helmet": Kind(
        industry.helmet, ("helmet", "hard hat", "safety helmet"), "plastic",
        (0.31, 0.235, 0.15), (0.03, 0.03, 0.05),
        ("yellow", "white", "red", "blue", "orange", "green"), 0.4, "slides", group="industrial",
        floor=True,
    ),
    "cone": Kind(
        industry.cone, ("cone", "traffic cone"), "plastic", (0.24, 0.24, 0.4), (0.04, 0.04, 0.15),
        ("orange", "red", "yellow", "green", "blue"), 1.0, "slides", group="industrial",
        floor=True,
    ),
    "pipe": Kind(
        industry.pipe, ("pipe", "tube"), "metal", (0.075, 0.4, 0.075), (0.0, 0.2, 0.0),
        ("grey", "red", "yellow", "blue", "orange", "black"), 2.0, "slides", group="industrial",
        other_materials=("plastic",), floor=True,
    ),
    "gearwheel": Kind(
        industry.gearwheel, ("gearwheel", "gear", "cog"), "metal",
        (0.16, 0.16, 0.04), (0.1, 0.1, 0.15), ("grey", "black", "brown", "yellow"), 2.5, "carries",
        group="industrial", other_materials=("plastic",),
    ),
    "canister": Kind(
        industry.canister, ("canister", "jerry can", "fuel can"), "plastic",
        (0.16, 0.3, 0.34), (0.06, 0.06, 0.1),
        ("red", "green", "blue", "yellow", "black", "white"), 5.0, "slides",
        group="industrial", other_materials=("metal",), floor=True,
    ),
}  # fmt: skip

WORK: dict[str, Kind] = {**TOOLS, **GARDEN, **INDUSTRY}
