"""System prompts and examples for general language models: (asked, answered)."""

from typing import Any

Examples = tuple[tuple[str, dict[str, Any]], ...]

PICTURE = (
    "The robot's camera picture is 1280 pixels wide and 720 high. x grows to the right, y grows "
    "DOWNWARDS: "
    "left means a smaller x, up means a smaller y. Behind or farther means higher in the picture "
    "(smaller y), in "
    "front of or nearer means lower (larger y). An object is given as 'NAME is at [x, y] with "
    "width=W and "
    "height=H', where [x, y] is its centre."
)

SELECT = (
    "You sort what an operator says to a humanoid robot. The robot shows a target point in its "
    "camera picture. "
    "Answer with one word. prediction: the operator names a new place to touch, lean on or reach "
    "for. correction: "
    "the operator wants the shown point moved, moved back, or rejects it. confirmation: the "
    "operator clearly "
    "agrees with the shown point and wants the robot to go there."
)
SELECT_EXAMPLES: tuple[tuple[str, str], ...] = (
    ("Could you rest your left palm beside the toaster?", "prediction"),
    ("nudge it a little upwards", "correction"),
    ("yep, that is exactly where I want it", "confirmation"),
    ("no, use the crate instead", "prediction"),
    ("too far, back by half", "correction"),
)

ANALYZE = (
    "You read an instruction that tells a humanoid robot where to put a hand or a foot. Find the "
    "objects that "
    "describe the place, in the order of mention, copied exactly as they are written, without "
    "article. Hands, arms "
    "and feet of the robot are never objects. The position is absolute when the place is ON an "
    "object or the object "
    "itself, and relative when it is described by a direction, distance, side, edge or corner of "
    "one or more "
    "objects. Think first, in one or two short sentences. Answer in JSON."
)
ANALYZE_EXAMPLES: Examples = (
    (
        "Lean on the grey filing cabinet with your left hand.",
        {
            "chain_of_thought": "The hand goes on the cabinet itself.",
            "position": "absolute",
            "objects": ["grey filing cabinet"],
        },
    ),
    (
        "put your right palm a bit left of the thing with the long spout",
        {
            "chain_of_thought": "The place is left of a thing, not on it.",
            "position": "relative",
            "objects": ["thing with the long spout"],
        },
    ),
    (
        "Using your right hand, reach for the tin of screws",
        {
            "chain_of_thought": "The tin itself is to be reached.",
            "position": "absolute",
            "objects": ["tin of screws"],
        },
    ),
    (
        "support yourself between the kettle and the bread bin",
        {
            "chain_of_thought": "The place is between two objects.",
            "position": "relative",
            "objects": ["kettle", "bread bin"],
        },
    ),
    (
        "rest your left hand on the far corner of the workbench",
        {
            "chain_of_thought": "A corner of the workbench is meant, so its box decides.",
            "position": "relative",
            "objects": ["workbench"],
        },
    ),
)

OBJECTS = (
    "An operator corrects a target point that a robot shows in its camera picture. List the "
    "objects that the "
    "correction speaks of, in order of mention, copied exactly as they are written, without "
    "article; most corrections "
    "name none. The target, the point and the robot's hands are not objects. Think first, "
    "briefly. Answer in JSON."
)
OBJECTS_EXAMPLES: Examples = (
    ("a bit to the right", {"chain_of_thought": "Only a direction.", "objects": []}),
    (
        "closer to the blue bucket please",
        {"chain_of_thought": "The bucket is the reference.", "objects": ["blue bucket"]},
    ),
    ("undo that", {"chain_of_thought": "It refers to the last move.", "objects": []}),
    (
        "slide it to the left edge of the tray",
        {"chain_of_thought": "The edge of the tray.", "objects": ["tray"]},
    ),
    ("now 4 cm up", {"chain_of_thought": "A distance and a direction.", "objects": []}),
)

RELATIVE = (
    f"{PICTURE} Work out the point where the robot shall put its hand or foot. Beside an object "
    "means outside its box: "
    "0.2 of its width (or height) away from the edge unless a distance is given. On an edge or a "
    "corner means just "
    "inside the box. Think first, in one or two short sentences. Then give x and y as arithmetic "
    "with numbers, "
    "+ - * / and parentheses; do not compute the result. Answer in JSON."
)
RELATIVE_EXAMPLES: Examples = (
    (
        "Kettle is at [400, 300] with width=80 and height=120.\nPut your hand left of the kettle.",
        {
            "chain_of_thought": "Half a width to the left edge, then 0.2 of it more.",
            "x": "400-80/2-0.2*80",
            "y": "300",
        },
    ),
    (
        "Tray is at [700, 500] with width=300 and height=100.\nlean behind the tray",
        {
            "chain_of_thought": "Behind is up: half a height to the top edge, 0.2 of it more.",
            "x": "700",
            "y": "500-100/2-0.2*100",
        },
    ),
    (
        "Bucket is at [200, 400] with width=100 and height=90.\n"
        "Crate is at [600, 420] with width=200 and height=150.\n"
        "your palm goes between the bucket and the crate",
        {
            "chain_of_thought": "Middle of the gap between right edge and left edge.",
            "x": "((200+100/2)+(600-200/2))/2",
            "y": "(400+420)/2",
        },
    ),
    (
        "1 cm is 12 pixels.\nJug is at [900, 350] with width=70 and height=110.\n"
        "5 cm in front of the jug",
        {
            "chain_of_thought": "In front is down: the bottom edge and 5 cm of 12 pixels.",
            "x": "900",
            "y": "350+110/2+5*12",
        },
    ),
    (
        "Workbench is at [640, 560] with width=900 and height=280.\n"
        "lean on the right end of the workbench",
        {
            "chain_of_thought": "Just inside the right edge, half way down.",
            "x": "640+900/2-0.15*900",
            "y": "560",
        },
    ),
)

CORRECT = (
    f"{PICTURE} A target point is shown, and the operator corrects it. Work out the new point. "
    "Without a size a step is 40 "
    "pixels, 'a tiny bit' 10, 'a bit' 20, 'a lot' 100; 'closer to' a thing is 0.4 of the way to "
    "its centre, 'a bit closer' 0.1, 'much closer' 0.7; 'away from' it is 0.2 of the way back. "
    "Earlier corrections are listed oldest first; 'twice as much' or 'again' "
    "repeats the last one from the present target, 'back' or 'undo' subtracts it. Someone who "
    "only rejects the "
    "point, without saying where to go, gets the same point. Think first, in one or two short "
    "sentences. Then give "
    "x and y as arithmetic with numbers, + - * / and parentheses. Answer in JSON."
)
CORRECT_EXAMPLES: Examples = (
    (
        "Target is at [500, 300].\na bit to the left",
        {"chain_of_thought": "A bit is 20 pixels, left is minus x.", "x": "500-20", "y": "300"},
    ),
    (
        "Earlier: 'move right' moved it by [40, 0].\nTarget is at [540, 300].\nnow twice as much",
        {
            "chain_of_thought": "The last move was [40, 0]; twice that.",
            "x": "540+2*40",
            "y": "300+2*0",
        },
    ),
    (
        "Bucket is at [800, 400] with width=100 and height=90.\nTarget is at [600, 300].\n"
        "closer to the bucket",
        {
            "chain_of_thought": "0.4 of the way to the centre of the bucket.",
            "x": "600+0.4*(800-600)",
            "y": "300+0.4*(400-300)",
        },
    ),
    (
        "1 cm is 9 pixels.\nTarget is at [610, 420].\n3 cm up and a lot to the right",
        {
            "chain_of_thought": "Up is minus y, 3 times 9; a lot is 100.",
            "x": "610+100",
            "y": "420-3*9",
        },
    ),
    (
        "Earlier: 'up' moved it by [0, -40].\nTarget is at [300, 260].\nno, undo that",
        {"chain_of_thought": "Subtract the last move.", "x": "300-0", "y": "260-(-40)"},
    ),
)

EFFECTOR = (
    "You read an instruction to a humanoid robot. Which end effector is named: left_hand, "
    "right_hand, left_foot, "
    "right_foot, or unspecified when none is named? Palm or arm means hand, sole or leg means "
    "foot. A side of an object is "
    "not a side of the robot. The task is contact for leaning, standing, pushing, putting or "
    "resting, and reach for "
    "getting, grabbing, fetching, touching or reaching. Answer in JSON."
)
EFFECTOR_EXAMPLES: Examples = (
    (
        "Lean with your left palm on the crate",
        {"chain_of_thought": "Left palm, lean.", "effector": "left_hand", "task": "contact"},
    ),
    (
        "grab the jug to the right of the sink",
        {"chain_of_thought": "No hand is named; grab.", "effector": "unspecified", "task": "reach"},
    ),
    (
        "with your right arm, reach the tin",
        {"chain_of_thought": "Right arm, reach.", "effector": "right_hand", "task": "reach"},
    ),
    (
        "stand on the step with the left sole",
        {"chain_of_thought": "Left sole, stand.", "effector": "left_foot", "task": "contact"},
    ),
    (
        "put your hand left of the kettle",
        {
            "chain_of_thought": "Left of the kettle is a place.",
            "effector": "unspecified",
            "task": "contact",
        },
    ),
)
