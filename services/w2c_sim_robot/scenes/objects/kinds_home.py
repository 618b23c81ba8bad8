"""Rows of the catalogue: furniture, kitchen, books, office, bathroom, clothes, household."""

from w2c_sim_robot.scenes.objects import (
    appliances,
    clothes,
    furniture,
    kitchen,
    office,
    paper,
    room,
    soft,
    tableware,
    tools,
)
from w2c_sim_robot.scenes.objects.kind import MANY, OAK, WOODEN, Kind

BEECH = {"brown": (0.80, 0.60, 0.37)}
PAINT = {
    "yellow": (0.88, 0.82, 0.64),
    "turquoise": (0.60, 0.76, 0.75),
    "brown": (0.62, 0.38, 0.29),
    "grey": (0.70, 0.71, 0.72),
}
"""Of a wall: paler than of things"""

FURNITURE: dict[str, Kind] = {
    "table": Kind(
        furniture.table, ("table", "desk", "tabletop", "surface"), "wood",
        (1.0, 1.7, 0.80), (0.2, 0.25, 0.06),
        WOODEN, 40.0, "carries", True, {"brown": OAK}, "furniture", ("plastic", "metal"),
    ),
    "counter": Kind(
        furniture.counter, ("counter", "worktop", "countertop", "surface"), "stone",
        (0.8, 2.0, 0.84), (0.15, 0.25, 0.06),
        ("grey", "white", "black", "brown"), 90.0, "carries", True, {"brown": OAK}, "furniture",
        ("wood", "metal"),
    ),
    "shelf": Kind(
        room.shelf, ("shelf", "shelves", "bookcase"), "wood",
        (0.36, 1.1, 0.82), (0.12, 0.25, 0.06), WOODEN, 18.0, "carries", True, {"brown": OAK},
        "furniture", ("metal",),
    ),
    "stool": Kind(
        room.stool, ("stool", "seat"), "wood", (0.34, 0.34, 0.48), (0.05, 0.05, 0.08),
        (*WOODEN, "red", "blue"), 3.5, "carries", True, {"brown": OAK}, "furniture", ("metal",),
    ),
    "fridge": Kind(
        appliances.fridge, ("fridge", "refrigerator"), "metal",
        (0.6, 0.6, 0.85), (0.06, 0.08, 0.06),
        ("white", "grey", "red", "black", "turquoise"), 40.0, "carries", True, {}, "furniture",
    ),
    "dishwasher": Kind(
        appliances.dishwasher, ("dishwasher",), "metal", (1.08, 0.6, 0.85), (0.03, 0.03, 0.03),
        ("white", "grey", "black"), 45.0, "carries", True, {}, "furniture",
    ),
    "wall": Kind(
        room.wall, ("wall",), "stone", (0.12, 2.6, 2.3), (0.1, 0.1, 0.05),
        ("white", "grey", "yellow", "turquoise", "brown"), 400.0, "carries", True, PAINT,
        "furniture", ("wood",),
    ),
    "window": Kind(
        room.window, ("window", "window pane"), "glass", (0.06, 0.7, 0.8), (0.1, 0.15, 0.15),
        ("white", "brown", "grey"), 12.0, "forbidden", True, {"brown": OAK}, "furniture",
    ),
    "poster": Kind(
        room.poster, ("picture", "poster", "painting"), "paper",
        (0.02, 0.36, 0.48), (0.1, 0.15, 0.15),
        ("black", "brown", "white", "red"), 1.0, "fragile", True, {}, "furniture",
    ),
}  # fmt: skip

KITCHEN: dict[str, Kind] = {
    "mug": Kind(
        tableware.mug, ("cup", "mug"), "ceramic", (0.125, 0.088, 0.10), (0.05, 0.05, 0.12),
        MANY, 0.35, "fragile", group="tableware", other_materials=("metal", "plastic"),
    ),
    "bowl": Kind(
        tableware.bowl, ("bowl", "dish"), "ceramic", (0.17, 0.17, 0.075), (0.02, 0.02, 0.2),
        MANY, 0.4, "fragile", group="tableware", other_materials=("wood", "plastic"),
    ),
    "plate": Kind(
        tableware.plate, ("plate", "dish"), "ceramic", (0.25, 0.25, 0.026), (0.02, 0.02, 0.1),
        MANY, 0.5, "fragile", group="tableware", other_materials=("plastic", "wood"),
    ),
    "bottle": Kind(
        tableware.bottle, ("bottle", "flask"), "glass", (0.08, 0.08, 0.27), (0.05, 0.05, 0.12),
        ("green", "blue", "brown", "red", "black", "white", "turquoise", "purple"), 0.7, "slides",
        group="tableware", other_materials=("plastic", "metal"), lies=True,
    ),
    "jug": Kind(
        tableware.jug, ("jug", "pitcher"), "ceramic", (0.17, 0.13, 0.2), (0.05, 0.05, 0.12),
        MANY, 0.9, "fragile", group="tableware", other_materials=("metal", "plastic"),
    ),
    "glass": Kind(
        kitchen.glass, ("glass", "tumbler", "drinking glass"), "glass",
        (0.078, 0.078, 0.12), (0.05, 0.05, 0.15),
        ("white", "blue", "green", "turquoise", "red"), 0.25, "fragile", group="tableware",
    ),
    "pan": Kind(
        kitchen.pan, ("pan", "frying pan", "skillet"), "metal",
        (0.46, 0.26, 0.075), (0.04, 0.04, 0.1),
        ("black", "grey", "red", "blue", "green", "orange"), 1.1, "slides", group="tableware",
        other_materials=("ceramic",),
    ),
    "pot": Kind(
        kitchen.pot, ("pot", "cooking pot", "saucepan"), "metal",
        (0.226, 0.3, 0.2), (0.03, 0.03, 0.12),
        ("grey", "red", "blue", "white", "green", "black"), 1.4, "slides", group="tableware",
        other_materials=("ceramic",),
    ),
    "teapot": Kind(
        kitchen.teapot, ("teapot",), "ceramic", (0.15, 0.25, 0.145), (0.03, 0.03, 0.08),
        MANY, 0.8, "fragile", group="tableware", other_materials=("metal",),
    ),
    "cutting_board": Kind(
        kitchen.cutting_board, ("cutting board", "chopping board"), "wood",
        (0.36, 0.24, 0.022), (0.1, 0.1, 0.2),
        ("brown", "white", "green", "red", "blue"), 1.0, "carries", tones=BEECH,
        group="tableware", other_materials=("plastic", "stone"),
    ),
    "dish_rack": Kind(
        appliances.dish_rack, ("dish rack", "rack"), "metal", (0.48, 0.48, 0.14), (0.04, 0.04, 0.1),
        ("grey", "white", "black", "blue"), 1.5, "slides", group="tableware",
        open_work=True,
    ),
    "hot_plate": Kind(
        appliances.hot_plate, ("hot plate", "stove", "cooker"), "metal",
        (0.28, 0.5, 0.07), (0.05, 0.05, 0.1), ("white", "black", "grey"), 4.0, "forbidden",
        group="tableware",
    ),
    "can": Kind(
        tableware.can, ("can", "tin"), "metal", (0.068, 0.068, 0.125), (0.05, 0.05, 0.15),
        MANY, 0.36, "slides", group="food", lies=True,
    ),
    "jar": Kind(
        kitchen.jar, ("jar", "jam jar", "jar of jam"), "glass",
        (0.08, 0.08, 0.1), (0.05, 0.05, 0.12),
        ("red", "orange", "purple", "yellow", "green", "brown"), 0.5, "fragile", group="food",
    ),
    "cereal_box": Kind(
        paper.cereal_box, ("cereal box", "packet"), "cardboard",
        (0.06, 0.19, 0.28), (0.15, 0.1, 0.1), MANY, 0.4, "slides", group="food",
    ),
    "cheez_it_box": Kind(
        kitchen.cheez_it_box,
        ("cheez it box", "cheez-it box", "cracker box", "box of crackers"), "cardboard",
        (0.06, 0.16, 0.22), (0.1, 0.08, 0.08), ("red", "orange", "yellow", "white"), 0.4, "slides",
        tones={"red": (0.86, 0.16, 0.12)}, group="food",
    ),
    "milk_carton": Kind(
        kitchen.milk_carton, ("milk carton", "carton of milk", "milk"), "cardboard",
        (0.072, 0.072, 0.235), (0.03, 0.03, 0.08),
        ("white", "blue", "green", "turquoise", "yellow"), 1.0, "slides", group="food",
    ),
    "banana": Kind(
        kitchen.banana, ("banana", "fruit"), "", (0.05, 0.19, 0.036), (0.05, 0.08, 0.05),
        ("yellow", "green", "brown"), 0.15, "slides", group="food",
    ),
    "apple": Kind(
        soft.apple, ("apple", "fruit"), "", (0.085, 0.085, 0.08), (0.03, 0.03, 0.08),
        ("red", "green", "yellow"), 0.2, "slides", group="food",
    ),
    "bread": Kind(
        kitchen.bread, ("bread", "loaf", "loaf of bread"), "",
        (0.11, 0.25, 0.085), (0.05, 0.1, 0.1),
        ("brown", "orange", "yellow"), 0.6, "slides", tones={"brown": (0.66, 0.42, 0.2)},
        group="food",
    ),
}  # fmt: skip

BOOKS: dict[str, Kind] = {
    "book": Kind(
        paper.book, ("book", "hardcover"), "paper", (0.26, 0.19, 0.035), (0.1, 0.1, 0.5),
        (*MANY, "brown"), 1.2, "carries", group="books and paper", other_materials=("leather",),
    ),
    "notebook": Kind(
        paper.notebook, ("notebook", "notepad"), "paper", (0.21, 0.15, 0.014), (0.1, 0.1, 0.3),
        MANY, 0.3, "carries", group="books and paper", other_materials=("leather", "plastic"),
    ),
    "paper": Kind(
        paper.paper, ("paper", "sheet of paper", "page"), "paper",
        (0.297, 0.21, 0.001), (0.02, 0.02, 0.0),
        ("white", "yellow", "pink", "turquoise"), 0.01, "carries", group="books and paper",
    ),
    "magazine": Kind(
        office.magazine, ("magazine", "journal"), "paper", (0.28, 0.21, 0.007), (0.05, 0.05, 0.3),
        ("white", "yellow", "pink", "turquoise", "orange"), 0.2, "carries",
        group="books and paper",
    ),
    "binder": Kind(
        office.binder, ("binder", "folder", "file"), "cardboard",
        (0.31, 0.28, 0.06), (0.03, 0.03, 0.2), MANY, 1.6, "carries", group="books and paper",
        other_materials=("plastic",),
    ),
}  # fmt: skip

OFFICE: dict[str, Kind] = {
    "laptop": Kind(
        office.laptop, ("laptop", "notebook computer", "computer"), "metal",
        (0.3, 0.33, 0.22), (0.04, 0.06, 0.06), ("grey", "black", "white"), 1.6, "forbidden",
        group="office", other_materials=("plastic",),
    ),
    "keyboard": Kind(
        office.keyboard, ("keyboard",), "plastic", (0.15, 0.44, 0.022), (0.05, 0.08, 0.1),
        ("black", "white", "grey", "blue", "pink"), 0.7, "fragile", group="office",
    ),
    "stapler": Kind(
        office.stapler, ("stapler",), "plastic", (0.036, 0.145, 0.062), (0.05, 0.08, 0.08),
        ("red", "blue", "black", "green", "orange", "grey"), 0.25, "slides", group="office",
        other_materials=("metal",),
    ),
    "lamp": Kind(
        office.lamp, ("lamp", "desk lamp"), "metal", (0.3, 0.18, 0.4), (0.05, 0.05, 0.1),
        ("black", "white", "red", "green", "yellow", "blue", "grey"), 1.5, "fragile",
        group="office", other_materials=("plastic",),
    ),
    "pen_holder": Kind(
        office.pen_holder, ("pen holder", "pencil cup", "pencils"), "plastic",
        (0.086, 0.086, 0.18), (0.05, 0.05, 0.08),
        ("black", "white", "blue", "red", "green", "brown"), 0.25, "slides", group="office",
        other_materials=("wood", "metal"),
    ),
}  # fmt: skip

HOUSEHOLD: dict[str, Kind] = {
    "soap_dispenser": Kind(
        office.soap_dispenser, ("soap dispenser", "soap bottle", "soap"), "plastic",
        (0.078, 0.068, 0.18), (0.05, 0.05, 0.1),
        ("white", "blue", "green", "pink", "turquoise", "yellow"), 0.4, "slides",
        group="bathroom", other_materials=("ceramic", "glass"),
    ),
    "toilet_paper": Kind(
        office.toilet_paper, ("toilet paper", "toilet roll", "roll of paper"), "paper",
        (0.11, 0.11, 0.1), (0.05, 0.05, 0.05), ("white", "pink", "grey"), 0.15, "slides",
        group="bathroom", lies=True,
    ),
    "hairbrush": Kind(
        office.hairbrush, ("hairbrush", "brush"), "wood", (0.235, 0.064, 0.034), (0.06, 0.05, 0.05),
        ("brown", "black", "pink", "red", "purple", "blue"), 0.12, "slides", tones=BEECH,
        group="bathroom", other_materials=("plastic",),
    ),
    "cloth": Kind(
        soft.cloth, ("cloth", "towel", "rag"), "cotton", (0.34, 0.28, 0.02), (0.15, 0.15, 0.3),
        (*MANY, "brown"), 0.1, "carries", group="bathroom", other_materials=("wool",),
    ),
    "sponge": Kind(
        soft.sponge, ("sponge",), "", (0.13, 0.085, 0.04), (0.1, 0.1, 0.15),
        ("yellow", "orange", "pink", "blue", "purple", "turquoise"), 0.05, "slides",
        group="bathroom",
    ),
    "drape": Kind(
        room.drape, ("cloth", "tablecloth", "blanket"), "cotton",
        (0.5, 0.52, 0.26), (0.1, 0.1, 0.1), MANY, 0.3, "carries", True, {}, "household",
        ("wool",),
    ),
    "box": Kind(
        paper.carton, ("box", "carton"), "cardboard", (0.22, 0.26, 0.16), (0.25, 0.25, 0.35),
        ("brown", "white", "blue", "red", "green", "grey"), 1.5, "slides", floor=True,
        other_materials=("plastic", "wood"),
    ),
    "tray": Kind(
        tools.tray, ("tray",), "plastic", (0.28, 0.4, 0.035), (0.1, 0.1, 0.15),
        (*MANY, "brown"), 0.7, "carries", other_materials=("wood", "metal"),
    ),
    "crate": Kind(
        tools.crate, ("crate", "basket"), "wood", (0.24, 0.34, 0.16), (0.12, 0.12, 0.15),
        ("brown", "white", "green", "blue", "grey", "red"), 1.3, "slides", floor=True,
        other_materials=("plastic", "wicker"),
    ),
    "ball": Kind(
        soft.ball, ("ball",), "rubber", (0.13, 0.13, 0.13), (0.0, 0.0, 0.0),
        MANY, 0.3, "slides", floor=True, other_materials=("leather",),
    ),
    "block": Kind(
        tools.block, ("block", "brick"), "wood", (0.08, 0.12, 0.07), (0.25, 0.25, 0.25),
        (*MANY, "brown"), 0.5, "slides", other_materials=("stone", "plastic"),
    ),
}  # fmt: skip

CLOTHES: dict[str, Kind] = {
    "shirt": Kind(
        clothes.shirt, ("shirt", "folded shirt"), "cotton",
        (0.33, 0.25, 0.045), (0.05, 0.05, 0.15),
        (*MANY, "brown"), 0.25, "carries", group="clothes", other_materials=("wool",),
    ),
    "hat": Kind(
        clothes.hat, ("hat",), "fabric", (0.34, 0.34, 0.13), (0.03, 0.03, 0.1),
        (*MANY, "brown"), 0.15, "slides", group="clothes", other_materials=("leather", "wool"),
    ),
    "shoe": Kind(
        clothes.shoe, ("shoe", "trainer", "sneaker"), "fabric",
        (0.3, 0.1, 0.125), (0.06, 0.05, 0.05),
        MANY, 0.35, "slides", group="clothes", other_materials=("leather",), floor=True,
    ),
}  # fmt: skip

HOME: dict[str, Kind] = {**FURNITURE, **KITCHEN, **BOOKS, **OFFICE, **HOUSEHOLD, **CLOTHES}
