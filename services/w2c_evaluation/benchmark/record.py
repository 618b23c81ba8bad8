"""One picture of a benchmark: its prompt, the mask of the accepted area, and what is known of both.

docs/reference/benchmark.md describes the folder.
"""

from typing import Annotated, Literal

import msgspec

Position = Literal["absolute", "relative"]
Look = Literal["indoor", "outdoor"]
POSITIONS: tuple[Position, ...] = ("absolute", "relative")
BoxEdges = tuple[float, float, float, float]
"""left, top (inclusive), right, bottom (exclusive) [px]"""

PROMPTS_FILE = "prompts.jsonl"
MANIFEST_FILE = "benchmark.json"
IMAGES, MASKS, OVERLAYS = "images", "masks", "overlays"
LONGEST_PROMPT = 500
"""Characters; the dialogue takes no more"""

Identifier = Annotated[str, msgspec.Meta(pattern=r"^[A-Za-z0-9][A-Za-z0-9_.-]{0,99}$")]
Prompt = Annotated[str, msgspec.Meta(min_length=1, max_length=LONGEST_PROMPT, pattern=r"\S")]


class NamedThing(msgspec.Struct, frozen=True, kw_only=True):
    """Something that a prompt speaks of."""

    words: str
    """As in the prompt, without article"""
    kind: str = ""
    box: BoxEdges
    """Around what is visible of it [px]"""


class Origin(msgspec.Struct, frozen=True, kw_only=True):
    """How a picture of `w2c benchmark make` came about; other folders have none."""

    scene: int
    """Seed"""
    look: Look
    stage: str
    """What the things stand on: table, counter, shelf or floor"""
    relation: str
    """Of the place to the things: on, on_top, left ..."""
    naming: str
    """plain, synonym, colour, material, part, use: how the first thing is named"""
    attribute: str = ""
    """colour, size or material: what tells it apart from another one of its kind in the picture"""
    pair: bool = False
    """The picture has two of a kind that an attribute tells apart"""
    distractors: int
    """Visible things that could be moved and are not spoken of"""
    verb: str
    end_effector: str
    task: Literal["contact", "reach"]
    held_out: bool
    """A thing that is spoken of is of a kind, or of a kind in a material or colour, that pictures
    for training never show"""


class Record(msgspec.Struct, frozen=True, kw_only=True):
    """One line of the prompts."""

    id: Identifier
    prompt: Prompt
    position: Position
    """absolute: on a thing. relative: described by its relation to things (paper, Methods)"""
    image: str = ""
    """Path inside the folder; "" = images/ID with any usual suffix"""
    mask: str = ""
    """Path inside the folder; "" = masks/ID with any usual suffix"""
    px_per_cm: Annotated[float, msgspec.Meta(gt=0, le=1000)] = 10.0
    """How long a centimetre looks at the first thing: what a camera with depth would tell"""
    things: tuple[NamedThing, ...] | None = None
    """In order of mention; None = not known, so that errors cannot be told apart as finely"""
    origin: Origin | None = None
