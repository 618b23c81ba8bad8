"""A conversation with a product of fakes; the stand-ins; the command without a system."""

import json
import threading
from pathlib import Path

import cv2
import numpy as np
import pytest

from fakes.scenario_world import SCENARIO, TABLE_M, THINGS, FakeProduct, FlatWitness, Seen
from w2c import topics
from w2c.bus.inprocess import InProcessHub
from w2c.errors import ConfigError, RefusedError
from w2c.geometry import Matrix
from w2c.messages import ChatMessage, ChooseRequest, CompleteRequest, GroundingRequest
from w2c_evaluation.scenarios import commands
from w2c_evaluation.scenarios.conversation import Conversation
from w2c_evaluation.scenarios.experiments import EXPERIMENTS, Experiment, find_experiment
from w2c_evaluation.scenarios.eyewitness import find_place
from w2c_evaluation.scenarios.film import Film, make_strip
from w2c_evaluation.scenarios.hits import Robot
from w2c_evaluation.scenarios.judge import judge
from w2c_evaluation.scenarios.phrase_book import PhraseBook
from w2c_evaluation.scenarios.record import Played, RunResult
from w2c_evaluation.scenarios.run import RunOptions, conclude
from w2c_evaluation.scenarios.scenario import Place, Scenario
from w2c_evaluation.scenarios.scripted_words import ScriptedWords, find_span
from w2c_evaluation.scenarios.speaker import Yes
from w2c_evaluation.scenarios.true_boxes import TrueGrounding, see
from w2c_evaluation.scenarios.truth_log import TruthLog
from w2c_evaluation.scenarios.wording import Saying

BOOK = PhraseBook({thing.name: thing.phrases() for thing in THINGS}, SCENARIO.phrases())


def play(directory: Path, **product: object) -> tuple[RunResult, Played]:
    """Play scenario (a) with fakes."""
    hub = InProcessHub()
    with FakeProduct(hub, **product):  # type: ignore[arg-type]
        bus = hub.connect("operator")
        witness = FlatWitness()
        with TruthLog(hub.connect("evaluation"), witness) as log:
            film = Film(directory / "pictures")
            conversation = Conversation(bus, log, BOOK, film, rng=np.random.default_rng(2))
            conversation.play(SCENARIO)
            robot = Robot(witness.links, witness.effectors, (0.0, 0.05))
            verdict = judge(SCENARIO, conversation.played, log.samples, robot)
    return conclude(SCENARIO, 0, conversation.played, verdict), conversation.played


def test_a_scenario_is_played_to_its_end(tmp_path: Path) -> None:
    result, played = play(tmp_path)
    assert result.problems == ()
    assert result.succeeded
    assert [turns[0].text for turns in result.turns] == [p.text for p in SCENARIO.prompts]
    assert all(turns[-1].module == "confirmation" for turns in result.turns)
    assert all(count >= 1 for count in result.corrections)  # vision points beside the middle
    assert all(error <= 20.0 for error in result.place_errors_mm)
    assert len(played.goal_ids) == 2
    strip = tmp_path / "strip.jpg"
    make_strip(tmp_path / "pictures", strip)
    picture = cv2.imread(str(strip))
    assert picture is not None
    assert picture.shape[1] > 4 * 500


def test_who_is_not_heard_gives_up_and_nothing_moves(tmp_path: Path) -> None:
    result, played = play(tmp_path, deaf=True)
    assert (result.succeeded, result.cause, result.corrections) == (False, "words", (6,))
    assert "after 6 corrections" in result.problems[0]
    assert played.goal_ids == []


def test_a_picture_that_was_lost_is_taken_again(tmp_path: Path) -> None:
    result, _ = play(tmp_path, loses=2)
    assert result.succeeded
    assert all(turn.ok for turns in result.turns for turn in turns)


def test_a_hand_that_misses_is_control(tmp_path: Path) -> None:
    result, _ = play(tmp_path, misses_m=0.06)
    assert (result.succeeded, result.cause) == (False, "control")
    assert "mm from where it should be" in result.problems[0]


def test_grounding_from_truth_answers_for_the_picture_it_was_asked_about() -> None:
    hub = InProcessHub()
    with FakeProduct(hub) as product:
        bus = hub.connect("evaluation")
        with TruthLog(bus, FlatWitness()) as log:
            TrueGrounding(hub.connect("grounding"), log, BOOK, patience_s=0.1)
            assert log.wait_for(2 * 10**9, 10.0)
            phrases = ["the book", "a person"]
            request = GroundingRequest(jpeg=product.jpeg, phrases=phrases, want="heatmaps")
            book, person = bus.call(topics.GROUND, request).message.evidence
            with pytest.raises(RefusedError, match="last pictures"):
                bus.call(topics.GROUND, GroundingRequest(jpeg=b"x", phrases=["book"], want="boxes"))
    assert not person.found
    assert book.found
    assert book.point == pytest.approx((640.0, 360.0 + 0.2 / 1.2 * 1000), abs=4.0)
    assert book.boxes[0].right - book.boxes[0].left == pytest.approx(225.0, abs=6.0)
    assert book.boxes[0].bottom - book.boxes[0].top == pytest.approx(166.7, abs=6.0)
    assert book.heatmap is not None
    assert book.heatmap.shape == (180, 320)
    assert book.heatmap.max() == 255


def test_what_is_not_in_the_picture_is_not_seen() -> None:
    class Away(FlatWitness):
        def world_from_object(self, name: str) -> Matrix:
            pose = super().world_from_object(name)
            pose[0, 3] += 5.0
            return pose

    assert see(Away(), "book") is None


def test_words_that_name_a_thing() -> None:
    book = PhraseBook(
        {"mallet": ("mallet", "black mallet"), "cup": ("cup", "red cup"), "mug": ("red cup",)},
        {"thing with the wooden handle": "mallet", "cheez it box": "crackers"},
    )
    assert book.find("the Mallet") == ["mallet"]
    assert book.find("thing with wooden handle") == ["mallet"]
    assert book.find("wooden handle") == ["mallet"]
    assert book.find("Cheez-It box") == ["crackers"]
    assert book.find("red cup") == ["cup", "mug"]
    assert book.find("spoon") == []
    assert book.find("black cup") == []
    assert book.find("the") == []


@pytest.mark.parametrize(
    ("numbered", "phrase", "span"),
    [
        ("place1 your2 hand3 on4 the5 book6", "book", "6-6"),
        ("right1 from2 the3 thing4 with5 the6 wooden7 handle8", "thing with the wooden handle",
         "4-8"),
        ("reach1 for2 the3 red4 plate,5 with6 the7 left8 hand9", "red plate", "4-5"),
    ],
)  # fmt: skip
def test_scripted_words_point_at_words(numbered: str, phrase: str, span: str) -> None:
    assert find_span(numbered, phrase) == span


def test_scripted_words_know_what_is_meant() -> None:
    hub = InProcessHub()
    bus = hub.connect("dialogue")
    words = ScriptedWords(hub.connect("llm"))

    def ask(tag: str, content: str) -> dict[str, object]:
        messages = [
            ChatMessage(role="system", content=tag),
            ChatMessage(role="user", content=content),
        ]
        request = CompleteRequest(messages=messages, schema={"type": "object"})
        return dict(bus.call(topics.COMPLETE, request).message.value)

    def choose() -> str:
        messages = [ChatMessage(role="system", content="select")]
        options = ["prediction", "correction", "confirmation"]
        request = ChooseRequest(messages=messages, options=options)
        return bus.call(topics.CHOOSE, request).message.option

    with pytest.raises(RefusedError, match="announced"):
        choose()
    prompt = SCENARIO.prompts[0]
    words.expect(prompt)
    assert choose() == "prediction"
    numbered = "place1 your2 right3 hand4 on5 top6 of7 the8 book9"
    assert ask("analyze", numbered) == {"position": "absolute", "objects": ["9-9"]}
    words.expect(Saying("a bit up", 0.0, -20.0))
    assert choose() == "correction"
    assert ask("objects", "a1 bit2 up3") == {"objects": []}
    assert ask("correct", "past none\na bit up") == {"x": "target.u+0.0", "y": "target.v-20.0"}
    words.expect(Yes("yes"))
    assert choose() == "confirmation"
    assert ask("effector", prompt.text) == {"effector": "right_hand", "task": "contact"}
    with pytest.raises(RefusedError, match="--prompts embedded"):
        ask("You are a helpful assistant", "hello")


def test_a_study_goes_on_where_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    asked: list[tuple[str, int]] = []

    def run(experiment: Experiment, seed: int, options: RunOptions) -> RunResult:
        asked.append((experiment.name, seed))
        assert (options.boxes, options.words) == ("truth", "model")
        scenario = Scenario(experiment.name, ())
        return conclude(scenario, seed, Played(system_problem="nothing runs here"), None)

    monkeypatch.setattr(commands, "run_scenario", run)
    monkeypatch.setattr(commands, "configure_logs", lambda *_: None)
    flags = ["--scenarios", "a", "--boxes", "truth", "--run-directory", str(tmp_path)]
    assert commands.evaluate([*flags, "--seeds", "2"]) == 1
    assert commands.evaluate([*flags, "--seeds", "3", "--resume"]) == 1
    assert asked == [("a", 0), ("a", 1), ("a", 2)]
    results = json.loads((tmp_path / "results.json").read_text())
    assert (results["boxes"], results["words"]) == ("truth", "model")
    assert {row["case"] for row in results["rows"]} == {"a", "all"}
    assert "boxes from truth" in capsys.readouterr().out
    with pytest.raises(ConfigError, match="--resume"):
        commands.evaluate(["--scenarios", "a", "--run-directory", str(tmp_path), "--resume"])
    monkeypatch.setattr(commands, "checksum_of_embedded", lambda service: f"new {service}")
    with pytest.raises(ConfigError, match="new language_service"):
        commands.evaluate([*flags, "--seeds", "3", "--resume"])


@pytest.mark.parametrize(("rim_px", "meant"), [(1, TABLE_M + 0.05), (4, TABLE_M)])
def test_at_an_edge_the_surface_in_front_is_meant(rim_px: int, meant: float) -> None:
    """The middle of an open box is seen this many pixels behind its rim."""

    class OpenBox(FlatWitness):
        def surface(self, u: float, v: float) -> Seen | None:
            seen = super().surface(u, v)
            middle = self.project(np.array([*THINGS[0].centre, TABLE_M]))
            if seen is None or middle is None or v < middle[1] + rim_px:
                return seen
            return Seen(seen.owner, seen.point + np.array([0.0, 0.0, 0.05]), seen.normal)

    wanted = find_place(OpenBox(), Place("the middle", THINGS[0].name, (0.0, 0.0, 0.0)))
    assert wanted is not None
    assert wanted.point[2] == pytest.approx(meant)


def test_the_normal_of_a_heap_is_not_that_of_the_nail_that_is_met() -> None:
    class Nails(FlatWitness):
        def surface(self, u: float, v: float) -> Seen | None:
            seen = super().surface(u, v)
            if seen is None:
                return None
            bump = 0.002 * np.sin(7.0 * u + 3.0 * v)
            return Seen(seen.owner, seen.point + np.array([0.0, 0.0, bump]), np.array([1.0, 0, 0]))

    wanted = find_place(Nails(), Place("the middle", THINGS[0].name, (0.0, 0.0, 0.0)))
    assert wanted is not None
    assert wanted.normal[2] > 0.97


@pytest.mark.parametrize(("edge_px", "faces"), [(0, {"up", "front"}), (40, {"up"})])
def test_at_the_edge_of_a_box_its_top_and_its_front_meet(edge_px: int, faces: set[str]) -> None:
    """The middle of a box is seen this many pixels behind the edge of its top."""
    up, out = np.array([0.0, 0.0, 1.0]), np.array([0.0, -1.0, 0.0])

    class Corner(FlatWitness):
        def surface(self, u: float, v: float) -> Seen | None:
            seen = super().surface(u, v)
            middle = self.project(np.array([*THINGS[0].centre, TABLE_M]))
            if seen is None or middle is None or v <= middle[1] + edge_px:
                return seen
            edge = super().surface(u, middle[1] + edge_px)
            assert edge is not None
            down = 0.001 * (v - middle[1] - edge_px) * (out - up)
            return Seen(seen.owner, edge.point + down, (out + up) / np.sqrt(2.0))

    wanted = find_place(Corner(), Place("the middle", THINGS[0].name, (0.0, 0.0, 0.0)))
    assert wanted is not None
    names = {"up": up, "front": (out + up) / np.sqrt(2.0)}
    found = {
        name for face in wanted.faces for name, axis in names.items() if float(face @ axis) > 0.99
    }
    assert found == faces, wanted.faces


def test_runs_go_side_by_side_where_wanted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    together = threading.Barrier(2, timeout=10.0)

    def run(experiment: Experiment, seed: int, _options: RunOptions) -> RunResult:
        together.wait()  # broken, an error, where the other one does not come
        scenario = Scenario(experiment.name, ())
        return conclude(scenario, seed, Played(system_problem="nothing runs here"), None)

    monkeypatch.setattr(commands, "run_scenario", run)
    monkeypatch.setattr(commands, "configure_logs", lambda *_: None)
    flags = ["--scenarios", "a", "--seeds", "4", "--jobs", "2", "--run-directory", str(tmp_path)]
    assert commands.evaluate(flags) == 1
    lines = (tmp_path / "runs.jsonl").read_text().splitlines()
    assert sorted(json.loads(line)["seed"] for line in lines[-4:]) == [0, 1, 2, 3]


def test_an_unknown_scenario_names_the_known_ones() -> None:
    with pytest.raises(ConfigError, match="choose of: a, b, c, d"):
        find_experiment("z")
    assert all(experiment.name == name for name, experiment in EXPERIMENTS.items())
