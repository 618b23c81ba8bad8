"""Cones against their definition, and the order of variables."""

import itertools

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from w2c_controller.kinematics.model import ControlledModel
from w2c_controller.parameters import Limits
from w2c_controller.seiko.contacts import ContactLayout, contact_sets, plane_cone, point_cone
from w2c_controller.seiko.retargeting import Retargeting

LIMITS = Limits()
force = st.floats(-150.0, 150.0)
torque = st.floats(-10.0, 10.0)


@given(st.tuples(force, force, st.floats(0.0, 500.0), torque, torque, torque))
def test_plane_cone_is_the_rectangular_contact_of_caron(
    wrench: tuple[float, float, float, float, float, float],
) -> None:
    fx, fy, fz, tx, ty, tz = wrench
    mu, x, y = LIMITS.friction, LIMITS.cop_x, LIMITS.cop_y
    reach = mu * (x + y) * fz
    margins = [
        mu * fz - abs(fx),
        mu * fz - abs(fy),
        y * fz - abs(tx),
        x * fz - abs(ty),
        tz - (-reach + abs(y * fx - mu * tx) + abs(x * fy - mu * ty)),
        (reach - abs(y * fx + mu * tx) - abs(x * fy + mu * ty)) - tz,
    ]
    rows = plane_cone(LIMITS) @ np.array([fx, fy, fz, tx, ty, tz])
    if abs(min(margins)) > 1e-9:
        assert bool((rows <= 0).all()) == (min(margins) > 0)


@given(force, force, st.floats(0.0, 150.0))
def test_point_cone_is_a_pyramid(fx: float, fy: float, fz: float) -> None:
    rows = point_cone(LIMITS) @ np.array([fx, fy, fz])
    margin = LIMITS.friction * fz - max(abs(fx), abs(fy))
    if abs(margin) > 1e-9:
        assert bool((rows <= 0).all()) == (margin > 0)


def test_sizes_are_those_of_the_published_problem() -> None:
    feet = ContactLayout((True, True, False, False), 31)
    leaning = ContactLayout((True, True, False, True), 31)
    assert (feet.size, feet.equality_rows) == (43, 18)
    assert (leaning.size, leaning.equality_rows) == (46, 21)
    assert leaning.slices[3] == slice(43, 46)


def test_every_contact_set_has_a_foot_and_a_structure_of_its_own(model: ControlledModel) -> None:
    sets = contact_sets()
    assert len(sets) == len(set(sets)) == 12
    for enabled in sets:
        assert enabled[0] or enabled[1]
        layout = ContactLayout(enabled, model.nv)
        structure = layout.structure(model.tree)
        rows = layout.size + layout.equality_rows
        np.testing.assert_array_equal(np.sort(structure.order), np.arange(rows))
        trunk = set(structure.order[structure.starts[-2] :].tolist())
        assert trunk == set(range(6)) | set(range(rows - 6, rows))


def test_limbs_meet_only_in_the_trunk(retargeting: Retargeting) -> None:
    """What the solver does not read of H and A is zero."""
    for hand in (2, 3):
        retargeting.enable(hand, np.eye(3))
        assert retargeting.tick()
    builder = retargeting._builders[retargeting.state.enabled]
    program, structure = builder.program, builder.program.structure
    n, total = program.size, structure.total
    matrix, read = np.zeros((total, total)), np.zeros((total, total), dtype=bool)
    matrix[:n, :n] = program.full_hessian()
    matrix[n:, :n] = program.rows[: program.equalities]
    for start, end in itertools.pairwise(structure.starts):
        block = structure.order[start:end]
        read[np.ix_(block, block)] = True
    read[structure.order[structure.starts[-2] :]] = True
    read[:, structure.order[structure.starts[-2] :]] = True
    assert np.count_nonzero(matrix) > 500
    np.testing.assert_array_equal(matrix[~read], 0.0)
