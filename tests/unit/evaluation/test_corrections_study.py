"""The correction study: pictures, conversations in one process, counting of prompts, results."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from fakes.correction_world import (
    BALL,
    BLOCK,
    DEPTH_M,
    SEED,
    Told,
    serve_words,
    turn,
    write_picture,
)
from w2c.bus import InProcessHub
from w2c.errors import ConfigError
from w2c_evaluation.corrections import commands
from w2c_evaluation.corrections.eye import RING_PX, Pixel, distance
from w2c_evaluation.corrections.operator import Operator
from w2c_evaluation.corrections.pictures import Picture, read_picture
from w2c_evaluation.corrections.report import (
    NO_DOT_PX,
    as_meant,
    by_kind,
    distances,
    format_tables,
    make_rows,
    median_interval,
)
from w2c_evaluation.corrections.services import Stage, find_true
from w2c_evaluation.corrections.trial import (
    MOST_PROMPTS,
    Prompt,
    Session,
    Study,
    Trial,
    draw_tasks,
    run_trial,
)
from w2c_evaluation.corrections.voice import read_voice

RING = (430.0, 180.0)


@pytest.fixture(scope="module")
def picture(tmp_path_factory: pytest.TempPathFactory) -> Picture:
    return write_picture(tmp_path_factory.mktemp("pictures"))


def person(*, corrects: bool = True) -> Operator:
    return Operator(read_voice("pilot"), np.random.default_rng(2), corrects=corrects)


def test_things_have_names_that_fit_nothing_else_in_sight(picture: Picture) -> None:
    assert [thing.names for thing in picture.things] == [
        ("table", "white table"),
        ("block", "red block"),
        ("ball", "blue ball"),
    ]
    twins = msgspec.structs.replace(picture.truth.objects[2], names=["block"])
    objects = [*picture.truth.objects[:2], twins]
    alike = Picture(
        SEED, picture.directory, msgspec.structs.replace(picture.truth, objects=objects)
    )
    assert [thing.names for thing in alike.things[1:]] == [("red block",), ("blue block",)]


def test_a_ring_is_on_something_and_wholly_in_the_picture(picture: Picture) -> None:
    rings = [picture.draw_ring(np.random.default_rng(seed)) for seed in range(40)]
    places = [ring for ring in rings if ring is not None]
    assert len(places) == len(rings)
    on_things = 0
    for u, v in places:
        assert RING_PX < u < 640 - RING_PX
        assert RING_PX < v < 360 - RING_PX
        on_things += picture.identity[int(v), int(u)] > 1
    assert 10 < on_things < 30


def test_a_centimetre_is_as_long_as_its_distance_says(picture: Picture) -> None:
    assert picture.pixels_per_cm(RING) == pytest.approx(0.01 * 400.0 / DEPTH_M)


def test_a_missing_picture_is_told(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="0900001"):
        read_picture(tmp_path, 900_001)


def test_truth_finds_a_thing_by_any_of_its_names_and_nothing_else(picture: Picture) -> None:
    for phrase in ("ball", "the blue ball", "blue"):
        seen = find_true(picture, phrase, "boxes")
        box = seen.boxes[0]
        assert (box.left, box.top, box.right, box.bottom) == BALL
    assert not find_true(picture, "green cup", "boxes").found


def test_the_products_dialogue_answers_in_this_process(picture: Picture) -> None:
    hub = InProcessHub()
    serve_words(hub)
    stage = Stage(hub, seed=0, boxes="truth")
    conversation = stage.begin(picture)
    first = conversation.say("put your hand on the block", "").target
    assert first is not None
    assert BLOCK[0] < first.u < BLOCK[2]
    assert BLOCK[1] < first.v < BLOCK[3]
    second = conversation.say("five centimetres to the right", first.target_id).target
    stage.close()
    assert second is not None
    # 5 cm at 0.8 m: the dialogue was told how far away the target is.
    assert second.u - first.u == pytest.approx(5 * 0.01 * 400.0 / DEPTH_M, rel=0.02)


def far(share: float) -> Pixel:
    return RING[0] - 100.0 * share, RING[1]


def test_prompts_end_with_the_dot_in_the_ring(picture: Picture) -> None:
    stage = Told([turn(far(1.0), module="prediction.absolute"), turn(far(0.5)), turn(far(0.1))])
    trial = run_trial(stage, person(), picture, RING)  # type: ignore[arg-type]
    assert [prompt.distance for prompt in trial.prompts] == [100.0, 50.0, pytest.approx(10.0)]
    assert trial.distance_after(1) == 100.0
    assert trial.distance_after(MOST_PROMPTS) == pytest.approx(10.0)


def test_everything_that_is_said_counts_as_a_prompt_answers_too(picture: Picture) -> None:
    asks = turn(options=["new place", "change"], reply="I am not sure: a new place, or a change?")
    stage = Told([asks, turn(far(0.7)), asks, turn(far(0.6)), turn(far(0.5))])
    trial = run_trial(stage, person(), picture, RING)  # type: ignore[arg-type]
    assert len(trial.prompts) == MOST_PROMPTS
    assert stage.turns == []
    assert [prompt.kind == "answer" for prompt in trial.prompts] == [
        False,
        True,
        False,
        True,
        False,
    ]
    assert [prompt.text for prompt in trial.prompts][1::2] == ["new place", "change"]
    assert trial.prompts[0].distance is None


def test_a_target_that_is_dropped_is_no_dot_any_more(picture: Picture) -> None:
    stage = Told([turn(far(1.0)), *[turn(far(1.0), state="abandoned")] * 4])
    trial = run_trial(stage, person(), picture, RING)  # type: ignore[arg-type]
    assert trial.prompts[1].distance is None


def test_both_phases_see_other_pictures_and_the_same_ones_each_time(tmp_path: Path) -> None:
    for seed in range(900_000, 900_004):
        write_picture(tmp_path, seed)
    study = Study(tmp_path, 900_000, 4, 2, "truth", "", 0)

    def drawn(phase: int) -> list[tuple[int, Pixel]]:
        return [(one.seed, ring) for one, ring in draw_tasks(study, "pilot", 0, phase)]

    assert drawn(1) == drawn(1)
    assert len({seed for phase in (1, 2) for seed, _ in drawn(phase)}) == 4


def test_pictures_without_anything_to_point_at_are_told_not_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for seed in range(900_000, 900_004):
        write_picture(tmp_path, seed)
    draw = Picture.draw_ring
    monkeypatch.setattr(
        Picture,
        "draw_ring",
        lambda self, rng: None if self.seed == 900_002 else draw(self, rng),
    )
    with pytest.raises(ConfigError, match=r"3 of 4 pictures.*needs 4: use more --pictures"):
        draw_tasks(Study(tmp_path, 900_000, 4, 2, "truth", "", 0), "pilot", 0, 1)


def prompt(kind: str, d: float | None, **changes: object) -> Prompt:
    point = None if d is None else (RING[0] + d, RING[1])
    said = Prompt(
        text=kind,
        kind=kind,
        module="correction",
        ok=d is not None,
        reply="",
        asks=False,
        point=point,
        distance=d,
        wanted=point or RING,
    )
    return msgspec.structs.replace(said, **changes)


def session(phase: int, *trials: tuple[float | None, ...], voice: str = "pilot") -> Session:
    return Session(
        voice=voice,
        operator=0,
        phase=phase,
        trials=tuple(
            Trial(
                picture=SEED,
                ring=RING,
                pixels_per_cm=5.0,
                prompts=tuple(prompt("amount", d) for d in ends),
            )
            for ends in trials
        ),
    )


SESSIONS = [session(1, (90.0, 40.0)), session(2, (None, 50.0, 12.0), (80.0, 30.0), (60.0, 8.0))]


def test_who_stops_early_keeps_the_distance_and_no_dot_is_the_worst_one() -> None:
    assert distances(SESSIONS, 1, 5) == [40.0]
    assert distances(SESSIONS, 2, 1) == [NO_DOT_PX, 80.0, 60.0]
    assert distances(SESSIONS, 2, 5) == [12.0, 30.0, 8.0]
    assert distances([session(2, ())], 2, 5) == [NO_DOT_PX]


def test_results_have_the_rows_that_are_relied_upon() -> None:
    rows = {(row["case"], row["metric"]): row for row in make_rows(SESSIONS)}
    medians = [rows["phase2", f"median_px_prompt{count}"] for count in range(1, 6)]
    assert [row["value"] for row in medians] == [80.0, 30.0, 12.0, 12.0, 12.0]
    assert {row["unit"] for row in medians} == {"px"}
    assert {row["n"] for row in medians} == {3}
    assert medians[-1]["spread"] == [10.0, 21.0]
    assert rows["phase2", "on_target"]["value"] == pytest.approx(2 / 3)
    assert rows["phase2.pilot", "median_px_prompt5"]["value"] == 12.0


def test_a_dot_that_went_the_other_way_was_not_as_meant() -> None:
    start = (100.0, 100.0)
    wanted = (200.0, 100.0)
    assert as_meant(prompt("amount", 0.0, point=(160.0, 100.0), wanted=wanted), start)
    assert not as_meant(prompt("amount", 0.0, point=(140.0, 100.0), wanted=wanted), start)
    assert not as_meant(prompt("amount", 0.0, point=wanted, wanted=wanted, ok=False), start)
    assert as_meant(prompt("on", 0.0, point=(210.0, 100.0), wanted=wanted), None)
    assert not as_meant(prompt("on", 0.0, point=(220.0, 100.0), wanted=wanted), None)


def test_questions_are_not_counted_among_the_kinds() -> None:
    trial = msgspec.structs.replace(
        SESSIONS[0].trials[0], prompts=(prompt("on", None, asks=True), prompt("answer", 3.0))
    )
    kinds = by_kind([msgspec.structs.replace(SESSIONS[0], trials=(trial,))], 1)
    assert {kind: len(prompts) for kind, prompts in kinds.items()} == {"answer": 1}


def test_the_interval_of_a_median_holds_it() -> None:
    values = [float(value) for value in range(101)]
    low, high = median_interval(values)
    assert 35.0 < low < 50.0 < high < 65.0
    assert median_interval([4.0]) == (4.0, 4.0)


def test_tables_name_phases_voices_and_kinds() -> None:
    text = format_tables(SESSIONS)
    assert "| 2 | 3 | 80 [70, 774] |" in text
    assert "| pilot | 40 [40, 40] | 12 [10, 21] |" in text
    assert "| amount | 2 | 7 |" in text


def test_a_study_that_is_complete_is_only_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(commands, "render", lambda *_: pytest.fail("nothing is to be made"))
    monkeypatch.setattr(commands, "checksum_of_embedded", lambda service: service[:2])
    write_picture(tmp_path / "pictures")
    question = {
        "first_picture": 900_000,
        "picture_count": 30,
        "images": 10,
        "boxes": "model",
        "model": "",
        "seed": 0,
        "weights": ["la", "gr"],
    }
    lines = [question, *SESSIONS]
    (tmp_path / "sessions.jsonl").write_bytes(
        b"".join(msgspec.json.encode(line) + b"\n" for line in lines)
    )
    arguments = ["--run-directory", str(tmp_path), "--resume", "--voices", "pilot"]
    assert commands.evaluate(arguments) == 0
    document = msgspec.json.decode((tmp_path / "results.json").read_bytes())
    assert (document["benchmark"], document["boxes"], document["model"]) == (
        "corrections",
        "model",
        "embedded",
    )
    for name in ("corrections.png", "corrections.svg", "stories.jpg", "tables.md"):
        assert (tmp_path / name).stat().st_size > 200
    with pytest.raises(ConfigError, match="without --resume"):
        commands.evaluate([*arguments, "--boxes", "truth"])
    monkeypatch.setattr(commands, "checksum_of_embedded", lambda _: "trained anew")
    with pytest.raises(ConfigError, match="trained anew"):
        commands.evaluate(arguments)


def test_only_a_second_phase_off_target_ends_with_status_1(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(commands, "draw_boxes", lambda *_: None)
    monkeypatch.setattr(commands, "draw_stories", lambda *_: None)
    study = Study(tmp_path, 900_000, 4, 2, "truth", "", 0)

    def status(*sessions: Session) -> int:
        made = commands.CorrectionsConfig(
            table=str(tmp_path / "new" / "tables.md"), json=str(tmp_path / "r")
        )
        return commands._report(made, study, tmp_path, list(sessions))

    even = [(10.0,), (12.0,), (20.0,), (30.0,)]  # the middle of two is the median
    assert status(session(2, *even)) == 0
    assert status(session(1, (500.0,))) == 0
    assert "target missed" not in capsys.readouterr().out
    assert status(session(2, *even, (30.0,))) == 1
    assert "target missed: the median after prompt 5 of phase 2 is 20.0 px, target 18" in (
        capsys.readouterr().out
    )
    assert (tmp_path / "new" / "tables.md").is_file()


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["--voices", "nobody"], "nobody"),
        (["--pictures", "6"], "at least 20"),
        (["--model", "missing.gguf"], "no such file"),
    ],
)
def test_flags_that_cannot_be_followed_are_refused_at_once(
    arguments: list[str], complaint: str
) -> None:
    with pytest.raises(ConfigError, match=complaint):
        commands.evaluate(arguments)


def test_distances_are_between_centres() -> None:
    assert distance((0.0, 3.0), (4.0, 0.0)) == 5.0
