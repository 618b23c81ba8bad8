"""The stories of `w2c demo --scene`: what is said in each, and how one ends."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from w2c import topics
from w2c.bus import CallContext
from w2c.bus.inprocess import InProcessHub
from w2c.errors import ConfigError
from w2c.messages import GoalEvent, GoalReply, ReleaseGoal
from w2c_evaluation.demo.commands import demo
from w2c_evaluation.demo.lifted_foot import lift_left_foot
from w2c_evaluation.demo.stories import STORIES, find_story
from w2c_evaluation.demo.told import BOXES_FROM_TRUTH, format_story, make_summary
from w2c_evaluation.scenarios.phrase_book import PhraseBook
from w2c_evaluation.scenarios.record import Played, RunResult, Understood
from w2c_evaluation.scenarios.run import conclude
from w2c_evaluation.scenarios.scenario import Scenario
from w2c_evaluation.scenarios.truth_log import Sample


def test_a_scene_that_is_not_there_is_answered_with_those_that_are(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"'kitchen'.*a, b, c, d, e, random"):
        find_story("kitchen")
    with pytest.raises(ConfigError, match="choose of"):
        demo(["--scene", "kitchen", "--run-directory", str(tmp_path)])
    assert not list(tmp_path.iterdir()), "nothing was begun"


def test_what_is_said_at_the_wall_is_what_words_can_say(tmp_path: Path) -> None:
    story, path = STORIES["e"], tmp_path / "scene.json"
    story.experiment.draw_layout(0, path)
    prompts = story.experiment.read(path).prompts
    assert [(p.meaning.effector, p.meaning.task) for p in prompts] == [("right_hand", "contact")]
    assert story.afterwards is not None
    assert story.afterwards.act is lift_left_foot


def test_in_a_random_scene_a_thing_within_reach_is_named_so_that_it_is_found(
    tmp_path: Path,
) -> None:
    story, path = STORIES["random"], tmp_path / "scene.json"
    said = story.experiment.draw_layout(3, path)
    (prompt,) = story.experiment.read(path).prompts
    ((phrase, thing),) = prompt.meaning.things.items()
    assert prompt.place.thing == thing
    assert phrase in prompt.text
    assert prompt.meaning.effector.replace("_", " ") in prompt.text
    assert "seed 3" in said
    text = path.read_text()
    assert PhraseBook({thing: [phrase]}, {}).find(phrase) == [thing]
    assert text.count(f'"name": "{thing}"') == 1


class Log:
    """What is true of a foot: its height at first, and in the seconds after it was lifted."""

    def __init__(self, before: float, *after: float) -> None:
        self._after = after
        self.samples = [self._sample(0, before)]

    def wait_for(self, _stamp_ns: int, _patience_s: float) -> bool:
        self.samples += [self._sample(second, h) for second, h in enumerate(self._after, 1)]
        return True

    def _sample(self, second: int, height: float) -> Sample:
        return Sample(
            stamp_ns=second * 10**9,
            effectors=np.array([[0, 0, height], [0, 0, 0], [0, 0, 1], [0, 0, 1]]),
            forces=np.zeros((4, 3)),
            base=np.zeros(7),
            body_touched=False,
            contacts=(),
            objects={},
        )


def lift(state: str, log: Log) -> str:
    """Lift a foot with a controller that ends it in some state."""
    hub = InProcessHub()
    controller = hub.connect("controller")

    def release(goal: ReleaseGoal, _context: CallContext) -> GoalReply:
        controller.publish(
            topics.GOAL_EVENT,
            GoalEvent(
                stamp_ns=10**9,
                goal_id=goal.goal_id,
                end_effector=goal.end_effector,
                task="contact",
                state=state,  # type: ignore[arg-type]  # of the event's states
                reason="for a test",
            ),
        )
        return GoalReply(goal_id=goal.goal_id, start_tick=0)

    controller.serve(topics.RELEASE, release)
    return lift_left_foot(hub.connect("operator"), log)  # type: ignore[arg-type]  # a log


@pytest.mark.parametrize(
    ("state", "heights", "problem"),
    [
        ("released", (0.01, 0.06, 0.05, 0.055), ""),
        ("released", (0.01, 0.06, 0.02, 0.055), "the foot was 10 mm up, at least 20"),
        ("aborted", (0.01,), "lifting the foot ended as aborted: for a test"),
    ],
)
def test_a_lifted_foot_is_judged_by_the_truth(
    state: str, heights: tuple[float, ...], problem: str
) -> None:
    assert lift(state, Log(*heights)) == problem


def result(**changes: Any) -> RunResult:
    turn = Understood(
        text="lean on the wall", kind="prompt", module="prediction", ok=True, reply="", seconds=0.2,
        pixel=(640.0, 360.0),
    )  # fmt: skip
    standard = {"scenario": "e", "seed": 0, "succeeded": True, "fell": False}
    return RunResult(**{**standard, "unconfirmed_motions": 0, "turns": ((turn,),), **changes})


def test_boxes_from_truth_are_told() -> None:
    assert BOXES_FROM_TRUTH in format_story(result(), "truth", "x.mcap")
    assert BOXES_FROM_TRUTH not in format_story(result(), "model", "x.mcap")
    assert make_summary(result(), "truth", "x.mcap")["boxes"] == "truth"
    assert "then                 a foot was up" in format_story(
        result(), "model", "", "a foot was up"
    )
    failed = result(succeeded=False, problems=("it fell",), cause="control")
    assert "PROBLEM              it fell (from control)" in format_story(failed, "model", "")
    assert "a foot was up" not in format_story(failed, "model", "", "a foot was up")
    assert "(640, 360)" in format_story(failed, "model", "")


def test_what_goes_wrong_after_the_words_is_the_controllers() -> None:
    played = Played(afterwards_problem="the foot stayed down")
    ended = conclude(Scenario("e", ()), 0, played, None)
    assert ended.problems == ("the foot stayed down",)
    assert not ended.succeeded
