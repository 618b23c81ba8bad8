"""What things are for, in words that do not name them; and names that fit more than their kind.

A phrase of use lists every kind that a person might mean by it, so that it is said only where one
thing in the picture is of them.
"""

_HOLDS_DRINK = ("mug", "glass", "jug", "bottle", "teapot", "can", "milk_carton")
_CLEANS = ("sponge", "cloth", "soap_dispenser", "toilet_paper", "bucket", "shirt", "drape")
_TO_READ = ("book", "magazine", "binder", "notebook", "paper", "poster")
_TO_EAT = ("banana", "apple", "bread", "cereal_box", "cheez_it_box", "jar")
_TO_HIT = ("hammer", "mallet")
_HEATS = ("pan", "pot", "hot_plate", "teapot")
_CARRIES = ("tray", "crate", "box", "bucket", "toolbox", "dish_rack")
_TO_WEAR = ("shirt", "hat", "shoe", "helmet", "cloth")

USES: dict[str, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "mug": (("thing you drink coffee from", "thing for hot drinks"), (*_HOLDS_DRINK, "bowl")),
    "glass": (("thing you drink water from",), (*_HOLDS_DRINK, "bowl", "jar")),
    "jug": (("thing to pour water from",), (*_HOLDS_DRINK, "watering_can", "canister")),
    "teapot": (("thing to make tea with",), (*_HOLDS_DRINK, *_HEATS)),
    "bowl": (("thing you eat soup from",), ("bowl", "plate", "pot", "mug")),
    "plate": (("thing you eat from",), ("plate", "bowl", "tray", "cutting_board")),
    "pan": (("thing to fry eggs in",), _HEATS),
    "pot": (("thing to cook soup in",), (*_HEATS, "bowl")),
    "cutting_board": (("thing to chop vegetables on",), ("cutting_board", "tray", "plate")),
    "milk_carton": (("thing with milk in it",), _HOLDS_DRINK),
    "bread": (("thing for a sandwich",), _TO_EAT),
    "apple": (("thing to eat", "healthy snack"), _TO_EAT),
    "banana": (("thing to eat", "thing to peel"), _TO_EAT),
    "cereal_box": (("thing for breakfast",), (*_TO_EAT, "milk_carton", "mug", "bowl")),
    "book": (("thing to read",), (*_TO_READ, "laptop")),
    "magazine": (("thing to read",), (*_TO_READ, "laptop")),
    "notebook": (("thing to write in",), (*_TO_READ, "laptop")),
    "binder": (("thing to file papers in",), (*_TO_READ, "box")),
    "laptop": (("thing to write e-mails on",), ("laptop", "keyboard", *_TO_READ)),
    "keyboard": (("thing to type on",), ("laptop", "keyboard")),
    "stapler": (("thing to staple papers with",), ("stapler",)),
    "lamp": (("thing that gives light",), ("lamp", "window")),
    "pen_holder": (("thing that holds pens",), ("pen_holder", "mug", "glass")),
    "soap_dispenser": (("thing to wash your hands with",), (*_CLEANS, "bottle")),
    "toilet_paper": (("thing that belongs in the toilet",), _CLEANS),
    "hairbrush": (("thing to brush your hair with",), ("hairbrush",)),
    "sponge": (("thing to wash the dishes with",), _CLEANS),
    "cloth": (("thing to dry your hands with",), (*_CLEANS, "shirt")),
    "tray": (("thing to carry plates on",), (*_CARRIES, "cutting_board")),
    "ball": (("thing to play with", "toy"), ("ball", "block")),
    "block": (("thing to build with",), ("block", "box", "toolbox", "hammer", "drill")),
    "toolbox": (("thing to keep tools in",), ("toolbox", "box", "crate", "nail_box", "bucket")),
    "mallet": (("thing to hit with",), _TO_HIT),
    "hammer": (("thing to drive nails with",), _TO_HIT),
    "screwdriver": (("thing to turn screws with",), ("screwdriver", "drill", "wrench")),
    "wrench": (("thing to turn bolts with",), ("screwdriver", "drill", "wrench")),
    "drill": (("thing to make holes with",), ("screwdriver", "drill")),
    "tape": (("thing to seal parcels with",), ("tape", "stapler")),
    "watering_can": (("thing to water the flowers with",), ("watering_can", "bucket", "jug")),
    "trowel": (("thing to dig with",), ("trowel",)),
    "bucket": (("thing to carry water in",), ("bucket", "watering_can", "canister", "jug")),
    "helmet": (("thing that protects your head",), ("helmet", "hat")),
    "canister": (("thing that holds petrol",), ("canister", "can", "bottle")),
    "hat": (("thing to wear on your head",), _TO_WEAR),
    "shoe": (("thing to wear on your foot",), _TO_WEAR),
    "shirt": (("thing to wear",), _TO_WEAR),
}
"""Kind -> what it is for, and all kinds that may be meant"""

ALSO_CALLED = {
    "plant": ("cactus",),
    "pot": ("teapot",),
    "paper": ("magazine", "notebook"),
    "page": ("magazine", "notebook", "book"),
    "cloth": ("shirt",),
    "glass": ("jar",),
    "box": ("toolbox", "crate", "milk_carton"),
    "packet": ("milk_carton", "cheez_it_box", "nail_box"),
    "brick": ("box",),
    "brush": ("sponge",),
    "file": ("notebook",),
    "folder": ("notebook",),
    "tube": ("bottle",),
    "basket": ("box",),
    "carton": ("cereal_box",),
    "computer": ("keyboard",),
    "fruit": ("banana", "apple"),
    "dish": ("plate", "bowl", "tray"),
    "flask": ("canister",),
    "soap": ("sponge",),
    "milk": (),
}
"""Last word of a name -> kinds that have other names and might be meant all the same"""
