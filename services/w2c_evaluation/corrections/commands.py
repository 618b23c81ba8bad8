"""`w2c evaluate corrections`."""

import time
from pathlib import Path
from statistics import median
from typing import Annotated, Literal

import msgspec

from w2c.config import parse
from w2c.errors import ConfigError
from w2c_evaluation.corrections.eye import RING_PX
from w2c_evaluation.corrections.pictures import FIRST_JUDGING_SEED, render
from w2c_evaluation.corrections.report import distances, draw_boxes, format_tables, make_rows
from w2c_evaluation.corrections.story import draw_stories
from w2c_evaluation.corrections.trial import MOST_PROMPTS, PHASES, Session, Study, run_session
from w2c_evaluation.corrections.voice import read_voice, voice_names
from w2c_evaluation.embedded import checksum_of_embedded
from w2c_evaluation.pool import ResultFile, run_all
from w2c_evaluation.results import make_results, origin, write_results, write_text

SEEDS_APART = 1000
"""Pictures of one seed of the study lie so far from those of the next"""


class CorrectionsConfig(msgspec.Struct, frozen=True, kw_only=True):
    """The paper's pilot study: scripted operators put a dot into a ring, by words alone."""

    seed: Annotated[int, msgspec.Meta(ge=0, le=90_000)] = 0
    """Of pictures, targets and operators."""
    voices: tuple[str, ...] = ()
    """Which ones; none = all."""
    operators: Annotated[int, msgspec.Meta(ge=1, le=100)] = 1
    """With each voice; they choose other words and differ in what they hold for a bit."""
    images: Annotated[int, msgspec.Meta(ge=1, le=100)] = 10
    """For each operator and phase."""
    pictures: Annotated[int, msgspec.Meta(ge=2, le=SEEDS_APART)] = 30
    """Scenes from which these are drawn."""
    phase: Literal["1", "2", "both"] = "both"
    """1: operators only name places; 2: they may correct, too."""
    boxes: Literal["model", "truth"] = "model"
    """Who finds things in pictures: the grounding service, or the simulator's truth."""
    model: str = ""
    """GGUF file of the language model; empty = the embedded model."""
    workers: Annotated[int, msgspec.Meta(ge=0, le=1024)] = 1
    """Processes; 0 = one a core. Each loads the models."""
    run_directory: str = ""
    """Where everything goes; empty = runs/<date and time>-corrections."""
    resume: bool = False
    """Go on with what the run directory has already."""
    json: str = ""
    """Write the results to this file; empty = results.json in the run directory."""
    table: str = ""
    """Write the tables to this Markdown file; empty = tables.md in the run directory."""
    image: str = ""
    """Write the box plot to this file and its .svg twin; empty = corrections.png in the run
    directory."""


def evaluate(arguments: list[str] | None = None) -> int:
    """Run the study. Exit status 1 where phase 2 ends off target: its last median is over 18 px.

    Raises:
        ConfigError: a voice or a model does not exist, or there are fewer pictures than asked for.
        ProcessError: the pictures could not be made.
    """
    config = parse(CorrectionsConfig, arguments or [], program="w2c evaluate corrections")
    voices = [read_voice(name).name for name in config.voices or voice_names()]
    if config.pictures < config.images * len(PHASES):
        raise ConfigError(
            f"--pictures {config.pictures}: each operator sees {config.images} in each of "
            f"{len(PHASES)} phases, none twice; use at least {config.images * len(PHASES)}"
        )
    if config.model and not Path(config.model).is_file():
        raise ConfigError(f"--model {config.model}: there is no such file")
    stamp = time.strftime("%Y-%m-%d_%H-%M-%S")
    directory = Path(config.run_directory or f"runs/{stamp}-corrections").resolve()
    study = Study(
        pictures=directory / "pictures",
        first_picture=FIRST_JUDGING_SEED + SEEDS_APART * config.seed,
        picture_count=config.pictures,
        images=config.images,
        boxes=config.boxes,
        model=str(Path(config.model).resolve()) if config.model else "",
        seed=config.seed,
    )
    question = {
        name: getattr(study, name)
        for name in ("first_picture", "picture_count", "images", "boxes", "model", "seed")
    }
    question["weights"] = [
        "" if study.model else checksum_of_embedded("language_service"),
        checksum_of_embedded("grounding_service") if study.boxes == "model" else "",
    ]
    file = ResultFile(directory / "sessions.jsonl", question, Session)
    done = {_key(session): session for session in file.start(resume=config.resume)}
    phases = PHASES if config.phase == "both" else (int(config.phase),)
    wanted = [
        (voice, operator, phase)
        for operator in range(config.operators)
        for voice in voices
        for phase in phases
    ]
    missing = [(study, *one) for one in wanted if one not in done]
    if missing:
        render(study.pictures, study.first_picture, study.picture_count)
    for session in run_all(run_session, missing, workers=config.workers, title="sessions"):
        file.add(session)
        done[_key(session)] = session
    return _report(config, study, directory, [done[one] for one in wanted])


def _key(session: Session) -> tuple[str, int, int]:
    return session.voice, session.operator, session.phase


def _report(
    config: CorrectionsConfig, study: Study, directory: Path, sessions: list[Session]
) -> int:
    """Write and print everything; return the exit status."""
    document = make_results("corrections", config.seed, make_rows(sessions))
    document |= {"boxes": config.boxes, "model": Path(config.model).name or "embedded"}
    write_results(document, Path(config.json) if config.json else directory / "results.json")
    mark = " with boxes from truth" if config.boxes == "truth" else ""
    tables = f"# Corrections{mark}\n\n{format_tables(sessions)}\n\n{origin(document)}\n"
    write_text(tables, Path(config.table) if config.table else directory / "tables.md")
    image = Path(config.image) if config.image else directory / "corrections.png"
    draw_boxes(sessions, [image, image.with_suffix(".svg")])
    draw_stories(study, sessions, directory / "stories.jpg")
    print(f"{tables}\nall of it: {directory}")
    last = distances(sessions, 2, MOST_PROMPTS)
    if last and median(last) > RING_PX:
        print(
            f"target missed: the median after prompt {MOST_PROMPTS} of phase 2 is "
            f"{median(last):.1f} px, target {RING_PX:.0f}"
        )
        return 1
    return 0
