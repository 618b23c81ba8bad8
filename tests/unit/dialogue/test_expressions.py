"""Arithmetic is parsed, bounded and refused with a reason; never evaluated as code."""

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from w2c.errors import ModelError
from w2c.messages import Box
from w2c_dialogue.expressions import (
    MAX_DEPTH,
    MAX_LENGTH,
    MAX_VALUE,
    UnknownSymbolError,
    correction_symbols,
    evaluate,
    evaluate_point,
    object_symbols,
)
from w2c_dialogue.prompts.base import CorrectionScene, Move, SceneObject

SYMBOLS = {
    "a.left": 100.0,
    "a.width": 40.0,
    "target.u": 640.0,
    "last.du": -20.0,
    "cm": 10.0,
    "moves[-2].du": 7.0,
}


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("12", 12.0),
        (" 1.5 + .5 ", 2.0),
        ("a.left-0.5*a.width", 80.0),
        ("target.u+2*last.du", 600.0),
        ("target.u-5*cm", 590.0),
        ("2-3-4", -5.0),
        ("24/4/2", 3.0),
        ("2+3*4", 14.0),
        ("(2+3)*4", 20.0),
        ("-(2+3)", -5.0),
        ("--2", 2.0),
        ("3*-2", -6.0),
        ("moves[-2].du", 7.0),
        ("260-(-40)", 300.0),
    ],
)
def test_values(text: str, value: float) -> None:
    assert evaluate(text, SYMBOLS) == pytest.approx(value)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "ends"),
        ("1+", "ends"),
        ("1 2", "does not belong"),
        ("(1", "not closed"),
        ("1)", "does not belong"),
        ("*1", "does not belong"),
        ("1/0", "divides by zero"),
        ("1/(cm-10)", "divides by zero"),
        ("1e999", "does not belong|not known"),
        ("999999999999", "limit"),
        ("1000000*1000000", "limit"),
        ("__import__('os')", "no part"),
        ("a.left;1", "no part"),
        ("2**3", "does not belong"),
        ("\u0661+\u0661", "no part"),
        ("1" * (MAX_LENGTH + 1), "characters"),
        ("(" * (MAX_DEPTH + 2) + "1" + ")" * (MAX_DEPTH + 2), "nested"),
        ("-" * (MAX_DEPTH + 2) + "1", "nested"),
        ("moves[2].du", "no part"),
    ],
)
def test_refusals(text: str, reason: str) -> None:
    with pytest.raises(ModelError, match=reason):
        evaluate(text, SYMBOLS)


def test_an_unknown_symbol_is_named_with_what_is_known() -> None:
    with pytest.raises(UnknownSymbolError, match=r"'b\.left'.*a\.left") as caught:
        evaluate("b.left", SYMBOLS)
    assert caught.value.symbol == "b.left"


def _trees() -> st.SearchStrategy[tuple[str, float]]:
    """Expressions with the value they have, None for one that must be refused."""
    numbers = st.floats(0, 1000, allow_nan=False).map(lambda x: (f"{x:.3f}", float(f"{x:.3f}")))
    symbols = st.sampled_from(sorted(SYMBOLS)).map(lambda name: (name, SYMBOLS[name]))

    def combine(children: Any) -> Any:
        def join(pair: Any) -> tuple[str, float]:
            (left, x), sign, (right, y) = pair
            result = {"+": x + y, "-": x - y, "*": x * y, "/": x / y if y else math.nan}[sign]
            return f"({left}){sign}({right})", result

        return st.tuples(children, st.sampled_from("+-*/"), children).map(join)

    return st.recursive(numbers | symbols, combine, max_leaves=5)


@given(_trees())
def test_every_expression_has_the_value_of_its_tree_or_is_refused(tree: tuple[str, float]) -> None:
    text, value = tree
    try:
        result = evaluate(text, SYMBOLS)
    except ModelError:
        assert not abs(value) <= MAX_VALUE or len(text) > MAX_LENGTH or "/" in text or "*" in text
    else:
        assert result == pytest.approx(value, rel=1e-9, abs=1e-9)


@given(
    st.text(alphabet="0123456789.+-*/() abcdlmstuv[]\n\x00é", max_size=60) | st.text(max_size=300)
)
def test_any_text_is_a_finite_value_or_a_refusal(text: str) -> None:
    try:
        value = evaluate(text, SYMBOLS)
    except ModelError:
        return
    assert abs(value) <= MAX_VALUE


@given(st.floats(-1e5, 1e5), st.floats(-1e5, 1e5))
def test_points_are_clipped_to_the_picture_and_say_so(u: float, v: float) -> None:
    point = evaluate_point(f"0+({u:.6f})", f"0+({v:.6f})", {}, (1280, 720))
    assert 0 < point.u < 1280
    assert 0 < point.v < 720
    outside = not (0 <= float(f"{u:.6f}") <= 1280 and 0 <= float(f"{v:.6f}") <= 720)
    assert point.clipped == outside


def test_symbols_of_a_scene() -> None:
    box = Box(left=100, top=200, right=140, bottom=260, score=1.0)
    scene = CorrectionScene(
        target=(300, 400),
        start=(250, 380),
        moves=(Move(10, 0), Move(40, 20)),
        instructions=("x", "y"),
        objects=(SceneObject("cup", box),),
        pixels_per_cm=12.0,
    )
    symbols = correction_symbols(scene)
    assert symbols["a.u"] == 120
    assert symbols["a.v"] == 230
    assert symbols["a.height"] == 60
    assert symbols["last.du"] == symbols["moves[-1].du"] == 40
    assert symbols["moves[-2].du"] == 10
    assert symbols["last.size"] == pytest.approx(math.hypot(40, 20))
    assert (symbols["first.du"], symbols["first.dv"]) == (10, 0)
    assert symbols["cm"] == 12
    assert "b.left" not in object_symbols([box], 10.0)


def test_a_way_has_the_length_one_and_points_at_the_thing() -> None:
    box = Box(left=30, top=20, right=50, bottom=60, score=1.0)
    scene = CorrectionScene(
        target=(10, 80),
        start=(10, 80),
        moves=(Move(-3, 4),),
        instructions=("x",),
        objects=(SceneObject("cup", box),),
        pixels_per_cm=10.0,
    )
    symbols = correction_symbols(scene)

    assert (symbols["a.way.u"], symbols["a.way.v"]) == pytest.approx((0.6, -0.8))
    assert (symbols["last.way.u"], symbols["last.way.v"]) == pytest.approx((-0.6, 0.8))
    assert evaluate("target.u+2*cm*a.way.u", symbols) == pytest.approx(10 + 12)


def test_where_there_is_no_way_it_is_zero() -> None:
    box = Box(left=30, top=20, right=50, bottom=60, score=1.0)
    scene = CorrectionScene((40, 40), (40, 40), (Move(0, 0),), ("x",), (SceneObject("c", box),), 10)
    symbols = correction_symbols(scene)

    assert symbols["a.way.u"] == symbols["a.way.v"] == 0
    assert symbols["last.way.u"] == symbols["last.way.v"] == 0
