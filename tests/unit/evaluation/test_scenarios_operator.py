"""The scripted operator: what it says, when it is content, when it gives up."""

from math import hypot

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from w2c.geometry import Intrinsics, apply, inverse, transform
from w2c_evaluation.scenarios.sight import ACCEPTED_M, ACCEPTED_PX, Circle, Sight, draw_circle
from w2c_evaluation.scenarios.speaker import MOST_CORRECTIONS, GiveUp, Speaker, Yes
from w2c_evaluation.scenarios.wording import REPEATS, Saying, choose_words

ACROSS = st.floats(0.0, 1280.0)
ALONG = st.floats(0.0, 720.0)
PIXELS = st.tuples(ACROSS, ALONG)
MOVES = st.none() | st.tuples(st.floats(-300.0, 300.0), st.floats(-300.0, 300.0))
INTRINSICS = Intrinsics(938.0, 938.0, 640.0, 360.0)
LOOKING_DOWN = transform(np.diag([1.0, -1.0, -1.0]), (0.0, 0.0, 1.0))


def circle(centre: tuple[float, float], pixels_per_cm: float = 8.0) -> Circle:
    return Circle(centre, np.eye(2) * 0.01 / pixels_per_cm, pixels_per_cm)


@given(PIXELS, PIXELS, st.floats(2.0, 25.0), MOVES, st.integers(0, 2**32))
def test_words_understood_literally_bring_the_point_nearer(
    shown: tuple[float, float],
    wanted: tuple[float, float],
    pixels_per_cm: float,
    last: tuple[float, float] | None,
    seed: int,
) -> None:
    sight = Sight(shown, circle(wanted, pixels_per_cm))
    assume(not sight.good)
    saying = choose_words(sight, last, np.random.default_rng(seed))
    assert saying is not None
    assert saying.leaves(sight.error) < hypot(*sight.error)
    if last is None:
        assert not any(saying.text in words for words in REPEATS.values())


@given(
    st.floats(0.0, 25.0),
    st.floats(0.0, 2 * np.pi),
    PIXELS,
    st.floats(4.0, 15.0),
    st.integers(0, 2**32),
)
def test_a_literal_listener_is_brought_to_the_place_and_confirmed(
    centimetres: float, angle: float, wanted: tuple[float, float], pixels_per_cm: float, seed: int
) -> None:
    """Within six corrections from 25 cm away, when each is understood literally."""
    speaker = Speaker(np.random.default_rng(seed))
    place = circle(wanted, pixels_per_cm)
    away = centimetres * pixels_per_cm
    shown = wanted[0] + away * np.cos(angle), wanted[1] + away * np.sin(angle)
    for _ in range(MOST_CORRECTIONS + 1):
        said = speaker.answer(Sight(shown, place))
        if isinstance(said, Yes):
            break
        assert isinstance(said, Saying)
        shown = shown[0] + said.du, shown[1] + said.dv
    assert isinstance(said, Yes)
    assert place.holds(shown)


def test_who_is_not_heard_gives_up_after_six() -> None:
    speaker = Speaker(np.random.default_rng(1))
    sight = Sight((100.0, 100.0), circle((400.0, 300.0)))
    said = [speaker.answer(sight) for _ in range(MOST_CORRECTIONS + 1)]
    assert all(isinstance(one, Saying) for one in said[:-1])
    assert isinstance(said[-1], GiveUp)
    assert "(300, 200) px" in said[-1].reason


def test_where_no_words_would_help_nothing_is_said() -> None:
    """Three pixels off, in a circle that nobody can be inside: the smallest step is ten."""
    never = Circle((403.0, 302.0), np.eye(2) * 1e6, 8.0)
    assert choose_words(Sight((400.0, 300.0), never), None, np.random.default_rng(0)) is None


def test_a_point_that_did_not_move_is_no_move_to_speak_of() -> None:
    speaker = Speaker(np.random.default_rng(3), most=200)
    sight = Sight((100.0, 100.0), circle((400.0, 300.0)))
    texts = [said.text for said in (speaker.answer(sight) for _ in range(200)) if said]  # type: ignore[union-attr]
    assert not set(texts) & {text for words in REPEATS.values() for text in words}


@given(st.integers(0, 2**32), st.tuples(st.floats(-200.0, 200.0), st.floats(-200.0, 200.0)))
def test_words_about_the_last_move_mean_a_part_of_it(seed: int, last: tuple[float, float]) -> None:
    """Whether they are said or not: the error is twice the last move, so that they may be."""
    assume(hypot(*last) > 10.0)
    sight = Sight((500.0, 300.0), circle((500.0 + 2.0 * last[0], 300.0 + 2.0 * last[1])))
    saying = choose_words(sight, last, np.random.default_rng(seed))
    assert saying is not None
    for factor, words in REPEATS.items():
        if saying.text in words:
            assert (saying.du, saying.dv) == (factor * last[0], factor * last[1])


def test_what_the_operator_says_depends_on_the_generator_alone() -> None:
    sight = Sight((100.0, 100.0), circle((400.0, 300.0)))
    twice = [choose_words(sight, (30.0, 0.0), np.random.default_rng(7)) for _ in range(2)]
    assert twice[0] == twice[1]
    assert len({choose_words(sight, None, np.random.default_rng(n)) for n in range(20)}) > 3


@given(st.floats(0.0, 2 * np.pi), st.floats(0.2, 1.8), st.floats(-0.3, 0.3), st.floats(-0.2, 0.2))
def test_the_circle_is_two_centimetres_on_the_surface(
    angle: float, share: float, x: float, y: float
) -> None:
    """Seen from a metre above a table: inside and outside as on the table, up to 1 %."""
    place = draw_circle(np.array([x, y, 0.0]), np.array([0.0, 0.0, 1.0]), LOOKING_DOWN, INTRINSICS)
    assume(abs(share - 1.0) > 0.05)
    radius = share * ACCEPTED_M
    point = (x + radius * np.cos(angle), y + radius * np.sin(angle), 0.0)
    pixel = INTRINSICS.pixel_from_point(np.array([point[0], -point[1], 1.0]))
    assert place.holds(pixel) == (share < 1.0)
    assert place.pixels_per_cm == pytest.approx(9.38)


@given(st.floats(0.0, 2 * np.pi), st.floats(-0.3, 0.3), st.sampled_from([0.8, 1.2]))
def test_the_circle_is_foreshortened_by_a_camera_that_looks_ahead(
    angle: float, x: float, share: float
) -> None:
    """Half-way down to a table a metre below, 1 m ahead: up to 5 % as on the table."""
    tilted = np.array([[1.0, 0.0, 0.0], [0.0, -np.sqrt(0.5), np.sqrt(0.5)],
                       [0.0, -np.sqrt(0.5), -np.sqrt(0.5)]])  # fmt: skip
    camera = transform(tilted, (0.0, -1.0, 1.0))
    place = draw_circle(np.array([x, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]), camera, INTRINSICS)
    radius = share * ACCEPTED_M
    point = np.array([x + radius * np.cos(angle), radius * np.sin(angle), 0.0])
    pixel = INTRINSICS.pixel_from_point(apply(inverse(camera), point))
    assume(hypot(pixel[0] - place.centre[0], pixel[1] - place.centre[1]) > ACCEPTED_PX)
    assert place.holds(pixel) == (share < 1.0)
    on_surface = place.metres_from_pixels @ np.subtract(pixel, place.centre)
    assert np.linalg.norm(on_surface) == pytest.approx(radius, rel=0.05)


def test_what_nobody_can_see_is_accepted() -> None:
    far = circle((400.0, 300.0), pixels_per_cm=1.0)
    assert far.holds((400.0 + 0.9 * ACCEPTED_PX, 300.0))
    assert not far.holds((400.0 + 1.1 * ACCEPTED_PX, 300.0))
