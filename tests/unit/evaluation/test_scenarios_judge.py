"""Success and failure of a run from what was true, and the causes of failures."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fakes.scenario_world import SCENARIO
from w2c_evaluation.scenarios.cause import cause_of_turn, find_cause, overlap
from w2c_evaluation.scenarios.eyewitness import Wanted
from w2c_evaluation.scenarios.hits import Robot
from w2c_evaluation.scenarios.judge import Verdict, judge
from w2c_evaluation.scenarios.record import Motion, Played, PromptRun, Understood
from w2c_evaluation.scenarios.report import format_table, make_rows, wilson
from w2c_evaluation.scenarios.run import conclude
from w2c_evaluation.scenarios.truth_log import Sample

UP = np.array([0.0, 0.0, 1.0])
BOOK = Wanted(np.array([0.5, -0.2, 0.84]), UP, "book")
CUP = Wanted(np.array([1.1, 0.2, 0.86]), UP, "cup")
ROBOT = Robot(
    frozenset({"ball", "palm", "left_sole", "right_sole", "forearm", "thigh"}),
    {"left_sole": 0, "right_sole": 1, "palm": 2, "ball": 3},
    (0.0, 0.05),
)
STANDING: tuple[tuple[str, str, float], ...] = (
    ("left_sole", "floor", 1e-4),
    ("right_sole", "floor", 1e-4),
)


def sample(second: float, **changes: object) -> Sample:
    """Return a moment of a run that goes well: leaning from 10 s on, reaching from 20 s on."""
    hands = np.array([[0.0, 0.1, 0.0], [0.0, -0.1, 0.0], [0.3, 0.3, 1.0], [0.3, -0.3, 1.0]])
    forces = np.zeros((4, 3))
    contacts = STANDING
    if second >= 10.0:
        hands[3] = BOOK.point + 0.05 * UP
        forces[3] = 40.0 * UP
        contacts = (*STANDING, ("ball", "book", 1e-4))
    if second >= 20.0:
        hands[2] = CUP.point + 0.02 * UP
    values = {
        "stamp_ns": round(second * 1e9),
        "effectors": hands,
        "forces": forces,
        "base": np.array([0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]),
        "body_touched": False,
        "contacts": contacts,
        "objects": {"cup": (1.1, 0.2, 0.8), "bottle": (0.9, -0.4, 0.8)},
        **changes,
    }
    return Sample(**values)  # type: ignore[arg-type]


def run_of(samples: dict[int, Sample] | None = None) -> list[Sample]:
    """Return 30 s of a run, a sample a second, some of them others."""
    return [(samples or {}).get(second, sample(second)) for second in range(30)]


def turn(text: str, **changes: object) -> Understood:
    values = {
        "text": text,
        "kind": "prompt",
        "module": "prediction.absolute",
        "ok": True,
        "reply": "",
        "seconds": 0.2,
        "pixel": (500.0, 500.0),
        "phrases": ("book",),
        "boxes": ((400.0, 400.0, 600.0, 600.0),),
        "true_boxes": ((400.0, 400.0, 600.0, 600.0),),
        "point": (0.5, -0.2, 0.84),
        "true_point": (0.5, -0.2, 0.84),
        "true_owner": "book",
        **changes,
    }
    return Understood(**values)  # type: ignore[arg-type]


YES = {"kind": "yes", "module": "confirmation"}


def played() -> Played:
    lean = Motion("g1", "right_hand", "contact", 5 * 10**9, "loaded", "", 11 * 10**9, 13 * 10**9)
    reach = Motion("g2", "left_hand", "reach", 15 * 10**9, "reached", "", 22 * 10**9, 25 * 10**9)
    there = (1.1, 0.2, 0.86)
    at_cup = {"point": there, "true_point": there, "true_owner": "cup"}
    cup = turn("reach", phrases=("cup",), **at_cup)
    return Played(
        [
            PromptRun([turn("place"), turn("yes", **YES)], BOOK, lean),
            PromptRun([cup, turn("yes", **YES, **at_cup)], CUP, reach),
        ],
        ["g1", "g2"],
    )


def verdict(samples: dict[int, Sample] | None = None, what: Played | None = None) -> Verdict:
    return judge(SCENARIO, what or played(), run_of(samples), ROBOT)


def test_at_an_edge_a_hand_may_come_from_either_of_its_faces() -> None:
    front = np.array([-1.0, 0.0, 0.0])
    before = {}
    for second in range(20, 30):
        hands = sample(second).effectors.copy()
        hands[2] = CUP.point + 0.02 * front
        before[second] = sample(second, effectors=hands)
    edge = played()
    edge.prompts[1] = replace(edge.prompts[1], wanted=replace(CUP, faces=(UP, front)))

    assert verdict(before).hand_errors_m[1] == pytest.approx(0.02 * np.sqrt(2.0))
    assert verdict(before, edge).hand_errors_m[1] == pytest.approx(0.0, abs=1e-9)


def test_a_run_that_goes_well_is_a_success() -> None:
    found = verdict()
    assert found.problems == ()
    assert found.hand_errors_m == pytest.approx((0.0, 0.0), abs=1e-9)
    assert found.support_n == pytest.approx((40.0, 40.0, 40.0))
    assert conclude(SCENARIO, 3, played(), found).succeeded


def test_a_hand_that_is_elsewhere_fails() -> None:
    moved = {s: sample(s, effectors=sample(s).effectors + 0.02) for s in range(22, 26)}
    assert "35 mm from where it should be" in verdict(moved).problems[0]


def test_a_reach_stops_two_centimetres_off_the_surface() -> None:
    """A hand on the surface itself is 20 mm from there, and one 6 cm above it too far."""
    above = {}
    for second in range(22, 26):
        hands = sample(second).effectors.copy()
        hands[2] = CUP.point + 0.06 * UP
        above[second] = sample(second, effectors=hands)
    assert "40 mm" in verdict(above).problems[0]


def test_a_support_that_gives_way_fails() -> None:
    weak = {s: sample(s, forces=np.zeros((4, 3))) for s in range(16, 18)}
    assert "the support carries 0 N" in verdict(weak).problems[0]
    once = {16: sample(16, forces=0.5 * sample(16).forces)}
    assert verdict(once).support_n[0] > 20.0


@pytest.mark.parametrize(
    ("contact", "problem"),
    [
        (("forearm", "table", 1e-4), "forearm touches table"),
        (("ball", "table", 1e-4), "ball touches table"),
        (("left_sole", "table", 1e-4), "left_sole touches table"),
        (("forearm", "thigh", 0.006), "forearm meets thigh (6 mm)"),
        (("palm", "book", 1e-4), "palm touches book"),
        (("forearm", "floor", 1e-4), "forearm touches floor"),
    ],
)
def test_what_must_not_be_touched_is_a_hit(contact: tuple[str, str, float], problem: str) -> None:
    found = verdict({18: sample(18, contacts=(*sample(18).contacts, contact))})
    assert len(found.hits) == 1
    assert found.hits[0].startswith(problem)
    assert "18.0 s" in found.hits[0]
    assert conclude(SCENARIO, 0, played(), found).cause == "control"


def test_hulls_that_overlap_a_little_are_no_hit() -> None:
    near = (*sample(18).contacts, ("forearm", "thigh", 0.004))
    assert verdict({18: sample(18, contacts=near)}).hits == ()


def test_the_reached_thing_may_be_touched_softly() -> None:
    def touch(force: float) -> dict[int, Sample]:
        forces = sample(24).forces.copy()
        forces[2] = (-force, 0.0, 0.0)
        contacts = (*sample(24).contacts, ("palm", "cup", 1e-4))
        return {24: sample(24, forces=forces, contacts=contacts)}

    assert verdict(touch(4.0)).problems == ()
    assert "palm pushes cup (up to 6 N)" in verdict(touch(6.0)).problems[0]


def test_the_cup_may_not_be_touched_before_it_was_confirmed() -> None:
    early = (*sample(14).contacts, ("palm", "cup", 1e-4))
    assert "palm touches cup" in verdict({14: sample(14, contacts=early)}).problems[0]


def test_a_thing_that_nobody_named_must_stay_where_it_is() -> None:
    last = sample(29, objects={"cup": (1.2, 0.2, 0.8), "bottle": (0.9, -0.35, 0.8)})
    assert verdict({29: last}).hits == ("bottle was displaced by 5 cm",)


@pytest.mark.parametrize(
    "base",
    [(0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.9, 0.0, np.sin(0.7), 0.0, np.cos(0.7))],
)
def test_a_robot_that_is_low_or_tilted_has_fallen(base: tuple[float, ...]) -> None:
    found = verdict({28: sample(28, base=np.array(base))})
    assert found.fell
    assert "the robot fell" in found.problems


def test_a_goal_that_nobody_confirmed_is_an_unconfirmed_motion() -> None:
    stranger = played()
    stranger.goal_ids.append("g3")
    assert verdict(what=stranger).unconfirmed_motions == 1
    early = {2: sample(2, effectors=sample(2).effectors + 0.05)}
    assert verdict(early).unconfirmed_motions == 1


def test_a_motion_that_does_not_end_well_says_why() -> None:
    stuck = played()
    assert stuck.prompts[1].motion is not None
    stuck.prompts[1].motion.state, stuck.prompts[1].motion.reason = "unreachable", "too far"
    found = verdict(what=stuck)
    assert "ended as unreachable: too far" in found.problems[0]
    assert conclude(SCENARIO, 0, stuck, found).cause == "control"


def test_a_run_that_ended_early_names_what_was_not_reached() -> None:
    half = Played(played().prompts[:1], ["g1"])
    assert "reach for the cup' was not reached" in verdict(what=half).problems[0]


def test_without_a_verdict_the_system_failed() -> None:
    result = conclude(SCENARIO, 0, Played(system_problem="llm does not start"), None)
    assert (result.succeeded, result.cause) == (False, "system")
    assert result.problems == ("llm does not start",)


BOOK_PROMPT = SCENARIO.prompts[0]


@pytest.mark.parametrize(
    ("changes", "cause"),
    [
        ({"module": "correction"}, "words"),
        ({"module": "prediction.relative"}, "words"),
        ({"phrases": ("hand",)}, "words"),
        ({"phrases": (), "boxes": (), "ok": False, "pixel": None, "reply": "no words"}, "words"),
        (
            {"phrases": (), "ok": False, "pixel": None, "reply": "I don't see a 'book'"},
            "vision",
        ),
        (
            {"phrases": (), "ok": False, "pixel": None, "reply": "no picture", "asked": False},
            "system",
        ),
        ({"boxes": ((100.0, 100.0, 300.0, 300.0),)}, "vision"),
        ({"true_owner": "table"}, "vision"),
        ({"point": (0.5, -0.2, 0.80)}, "geometry"),
        ({"point": None}, "geometry"),
        ({}, "operator"),
        (
            {"kind": "correction", "module": "correction", "meant": (40.0, 0.0),
             "before": (540.0, 500.0)},
            "words",
        ),
        (
            {"kind": "correction", "module": "correction", "meant": (40.0, 0.0),
             "before": (465.0, 500.0)},
            "operator",
        ),
        (
            {"kind": "correction", "module": "correction", "meant": (200.0, 0.0),
             "before": (360.0, 500.0)},
            "operator",
        ),
        (
            {"kind": "correction", "module": "correction", "meant": (10.0, 0.0),
             "before": (481.0, 500.0)},
            "operator",
        ),
        ({"kind": "yes", "module": "correction"}, "words"),
        ({"kind": "yes", "module": "none", "reply": "cannot lean there"}, "operator"),
    ],
)  # fmt: skip
def test_the_first_wrong_answer_is_the_cause(changes: dict[str, object], cause: str) -> None:
    run = PromptRun([turn("Place", **changes)], BOOK)
    assert find_cause(BOOK_PROMPT, run, right_place=False) == cause


def test_a_right_target_that_is_not_reached_is_control_unless_the_wrong_hand_went() -> None:
    run = replace(played().prompts[0])
    assert find_cause(BOOK_PROMPT, run, right_place=True) == "control"
    run.motion = Motion("g", "left_hand", "contact", 0)
    assert find_cause(BOOK_PROMPT, run, right_place=True) == "words"


def test_a_wrong_place_that_was_reached_is_the_cause_that_led_there() -> None:
    """The same run, with a target 6 cm from the place: not control."""
    astray = played()
    book = replace(BOOK, point=BOOK.point + np.array([0.06, 0.0, 0.0]))
    astray.prompts[0] = PromptRun([turn("place", true_owner="table")], book, None, "gave up")
    astray.prompts[0].turns.append(turn("yes", **YES))
    found = verdict(what=astray)
    assert found.place_errors_m[0] == pytest.approx(0.06)
    assert conclude(SCENARIO, 0, astray, found).cause == "vision"


def test_a_right_target_that_the_controller_refuses_is_control() -> None:
    refused = played()
    refused.prompts[0].motion = None
    refused.prompts[0].problem = "not gone to: the way is blocked"
    found = verdict(what=refused)
    assert found.problems[0] == "not gone to: the way is blocked"
    assert conclude(SCENARIO, 0, refused, found).cause == "control"


def test_a_target_that_was_never_confirmed_is_at_no_place() -> None:
    mute = Played([PromptRun([turn("place")], BOOK, None, "gave up")])
    found = verdict(what=mute)
    assert np.isnan(found.place_errors_m[0])
    assert conclude(SCENARIO, 0, mute, found).cause == "operator"


def test_wrong_answers_are_counted_also_where_they_were_made_good() -> None:
    made_good = played()
    made_good.prompts[0].turns.insert(1, turn("a bit up", kind="correction", module="none"))
    result = conclude(SCENARIO, 0, made_good, verdict(what=made_good))
    assert result.succeeded
    assert result.wrong_turns == {"words": 1}
    assert "1, 0, 0 of 5 | 0, 0 |" in format_table([result])


def test_questions_are_counted_with_what_became_of_them() -> None:
    asked = played()
    asked.prompts[0].turns.insert(0, turn("place", module="question", asks="answered"))
    result = conclude(SCENARIO, 0, asked, verdict(what=asked))
    rows = {(r["case"], r["metric"]): r for r in make_rows([result])}
    assert (rows["a", "questions_answered"]["value"], rows["a", "questions_answered"]["n"]) == (
        1,
        5,
    )
    assert rows["a", "questions_open"]["value"] == 0
    assert "| 1, 0 |" in format_table([result])


def test_a_hidden_place_is_the_scene() -> None:
    assert find_cause(BOOK_PROMPT, PromptRun(), right_place=False) == "scene"


def test_overlap_of_boxes() -> None:
    assert overlap((0, 0, 10, 10), (0, 0, 10, 10)) == 1.0
    assert overlap((0, 0, 10, 10), (5, 0, 15, 10)) == pytest.approx(1 / 3)
    assert overlap((0, 0, 10, 10), (20, 20, 30, 30)) == 0.0


@given(st.integers(0, 200), st.integers(1, 200))
def test_the_interval_holds_the_rate(successes: int, more: int) -> None:
    trials = successes + more
    low, high = wilson(successes, trials)
    assert 0.0 <= low <= successes / trials <= high <= 1.0
    assert wilson(95, 100) == pytest.approx((0.888, 0.978), abs=1e-3)


def test_rows_and_table_count_everything() -> None:
    good = conclude(SCENARIO, 0, played(), verdict())
    bad = conclude(SCENARIO, 1, Played(system_problem="a | b"), None)
    rows = {(r["case"], r["metric"]): r for r in make_rows([good, bad])}
    for case in ("a", "all"):
        assert (rows[case, "succeeded"]["value"], rows[case, "succeeded"]["n"]) == (1.0, 2)
        assert rows[case, "falls"]["value"] == 0.0
        assert rows[case, "unconfirmed_motions"]["value"] == 0.0
        assert rows[case, "failed_system"]["value"] == 1.0
        assert rows[case, "turns_wrong_words"]["n"] == 4
    table = format_table([good, bad])
    assert "| a | 1 of 2 | 0.50 [0.09, 0.91] |" in table
    assert "| a, seed 1 | system | a / b | none |" in table


def test_a_question_that_could_be_answered_is_no_wrong_answer() -> None:
    prompt = SCENARIO.prompts[0]
    asked = turn("place", module="question", ok=False, pixel=None, phrases=(), boxes=())
    assert cause_of_turn(asked, prompt.meaning) is not None
    assert cause_of_turn(msgspec.structs.replace(asked, asks="answered"), prompt.meaning) is None
