"""Pictures with truth in the format of `w2c scenes render`: coloured squares and discs on grey."""

import json
from pathlib import Path

import cv2
import numpy as np

COLOURS = {"red": (220, 30, 30), "green": (30, 200, 40), "blue": (30, 60, 220)}
SHAPES = {"square": ("square", "box"), "disc": ("disc", "ball", "big button")}


def write_pictures(directory: Path, count: int, *, first: int = 0) -> list[Path]:
    """Write pictures of seeds `first` to `first + count - 1`; returns the truth files."""
    directory.mkdir(parents=True, exist_ok=True)
    return [_write(directory, seed) for seed in range(first, first + count)]


def _write(directory: Path, seed: int) -> Path:
    rng = np.random.default_rng(seed)
    image = np.full((90, 160, 3), 128, dtype=np.uint8)
    identity = np.zeros((90, 160), dtype=np.uint8)
    objects = []
    for number, kind in enumerate(rng.permutation(sorted(SHAPES)), start=1):
        colour = str(rng.choice(sorted(COLOURS)))
        centre = (int(rng.integers(20, 60)) + 70 * (number - 1), int(rng.integers(20, 70)))
        mask = np.zeros_like(identity)
        if kind == "disc":
            cv2.circle(mask, centre, 14, 1, -1)
        else:
            corners = (centre[0] - 12, centre[1] - 12), (centre[0] + 12, centre[1] + 12)
            cv2.rectangle(mask, *corners, 1, -1)
        image[mask == 1] = COLOURS[colour]
        identity[mask == 1] = number
        names = SHAPES[str(kind)]
        left, top, wide, high = cv2.boundingRect(mask)
        objects.append(
            {
                "id": number,
                "name": f"{kind}_{number}",
                "kind": str(kind),
                "colour": colour,
                "material": "",
                "names": list(names),
                "phrases": [*names, *(f"{colour} {name}" for name in names)],
                "held_out": False,
                "visible_pixels": int(mask.sum()),
                "box": [left, top, left + wide, top + high],
            }
        )
    name = f"{seed:07d}"
    cv2.imwrite(str(directory / f"{name}.jpg"), cv2.cvtColor(image, cv2.COLOR_RGB2BGR))
    cv2.imwrite(str(directory / f"{name}_identity.png"), identity)
    truth = {
        "image": f"{name}.jpg",
        "identity": f"{name}_identity.png",
        "width": 160,
        "height": 90,
        "seed": seed,
        "objects": objects,
    }
    path = directory / f"{name}.json"
    path.write_text(json.dumps(truth))
    return path
