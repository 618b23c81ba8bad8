"""The paper's own figures (Table I, photographs): beside ours, and not of the same work."""

from pathlib import Path

PRESET_FILE = Path(__file__).with_name("paper.toml")
LANGUAGE_MODELS = ("calme-7b-instruct", "mixtao-7bx2-moe", "gpt-3.5")
DETECTORS = ("florence-2", "grounding-dino")
SEGMENTERS = ("clipseg", "clip-surgery")

TABLE: dict[tuple[str, str, str], tuple[float, float, float]] = {
    ("calme-7b-instruct", "florence-2", "clipseg"): (0.67, 0.39, 0.54),
    ("calme-7b-instruct", "florence-2", "clip-surgery"): (0.43, 0.42, 0.42),
    ("calme-7b-instruct", "grounding-dino", "clipseg"): (0.71, 0.46, 0.59),
    ("calme-7b-instruct", "grounding-dino", "clip-surgery"): (0.45, 0.46, 0.45),
    ("mixtao-7bx2-moe", "florence-2", "clipseg"): (0.66, 0.34, 0.51),
    ("mixtao-7bx2-moe", "florence-2", "clip-surgery"): (0.43, 0.36, 0.42),
    ("mixtao-7bx2-moe", "grounding-dino", "clipseg"): (0.66, 0.41, 0.53),
    ("mixtao-7bx2-moe", "grounding-dino", "clip-surgery"): (0.42, 0.45, 0.42),
    ("gpt-3.5", "florence-2", "clipseg"): (0.74, 0.39, 0.55),
    ("gpt-3.5", "florence-2", "clip-surgery"): (0.42, 0.34, 0.41),
    ("gpt-3.5", "grounding-dino", "clipseg"): (0.71, 0.50, 0.61),
    ("gpt-3.5", "grounding-dino", "clip-surgery"): (0.45, 0.53, 0.47),
}
"""Medians of absolute, relative and overall"""
RANDOM = (0.12, 0.17, 0.13)
BEST = "gpt-3.5", "grounding-dino", "clipseg"
