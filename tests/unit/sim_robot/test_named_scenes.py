"""The scenes of the paper: their layouts, what their prompts mean, and that a hand gets there."""

import mujoco
import numpy as np
import pytest

from w2c.errors import ConfigError
from w2c.geometry import Vector
from w2c.messages import PlaceGoal, RobotDescription
from w2c_controller.preview.reach import farthest_reach
from w2c_sim_robot.description import make_description
from w2c_sim_robot.model import build_model, ready_configuration
from w2c_sim_robot.scenes import scene as scenes
from w2c_sim_robot.scenes.held_out import HELD_OUT_KINDS
from w2c_sim_robot.scenes.named import SCENES, named_scene
from w2c_sim_robot.scenes.objects.catalogue import shape_of
from w2c_sim_robot.scenes.scene import Instruction, Scene

PAPER = [name for name in SCENES if name != "random"]
CLEARANCE = 0.02
"""Between the hand's frame and what it reaches for [m]"""


@pytest.fixture(scope="module")
def description() -> RobotDescription:
    return make_description(lock_step=True)


def support_of(scene: Scene) -> PlaceGoal:
    """Return the first prompt as a goal of the controller."""
    lean = scene.instructions[0]
    return PlaceGoal(
        goal_id="support",
        end_effector=lean.end_effector,
        task="contact",
        point=scene.place(lean),
        normal=np.array(lean.normal),
    )


def aim_of(scene: Scene, reach: Instruction) -> Vector:
    """Return where the hand's frame goes: before the side of the thing towards the robot."""
    near = scene.place(reach)
    if reach.normal[0] == -1.0:
        near = near - [scene.object(reach.thing).size[0] / 2, 0.0, 0.0]
    return np.asarray(near + CLEARANCE * np.array(reach.normal))


@pytest.mark.parametrize("name", PAPER)
def test_a_layout_follows_from_its_seed_and_passes_the_checks(name: str) -> None:
    assert named_scene(name, 3) == named_scene(name, 3)
    assert named_scene(name, 3).objects != named_scene(name, 4).objects
    scenes.check(named_scene(name, 3))
    assert not {item.kind for item in named_scene(name, 3).objects} & HELD_OUT_KINDS


@pytest.mark.parametrize("name", PAPER)
def test_the_robot_stands_clear_of_everything(name: str) -> None:
    model = build_model(named_scene(name, 5), visuals=False)
    data = mujoco.MjData(model)
    data.qpos[:] = ready_configuration(model)
    mujoco.mj_forward(model, data)
    root = model.body_rootid == model.body("base_link").id

    touching = {
        (model.body(bodies[0]).name, model.body(bodies[1]).name)
        for contact in data.contact[: data.ncon]
        for bodies in [sorted(model.geom_bodyid[[contact.geom1, contact.geom2]])]
        if root[bodies].any()
    }

    assert touching == {("world", "left_sole_link"), ("world", "right_sole_link")}


@pytest.mark.parametrize("name", ["scenario_b", "scenario_c", "scenario_d"])
def test_the_target_is_out_of_reach_on_two_feet_and_within_reach_with_support(
    name: str, description: RobotDescription
) -> None:
    scene = named_scene(name, 11)
    aim = aim_of(scene, scene.instructions[1])
    reaches = [
        farthest_reach(
            description,
            end_effector="left_hand",
            origin=(0.0, float(aim[1])),
            direction=(1.0, 0.0),
            height=float(aim[2]),
            support=support,
        )
        for support in (None, support_of(scene))
    ]
    assert reaches[0] + 0.04 < aim[0] < reaches[1] - 0.03


def test_the_wall_can_be_leaned_on(description: RobotDescription) -> None:
    scene = named_scene("scenario_e", 11)

    farthest_reach(
        description,
        end_effector="left_hand",
        origin=(0.0, 0.2),
        direction=(1.0, 0.0),
        height=1.0,
        support=support_of(scene),
    )

    assert scene.instructions[1].task == "lift"


def test_the_thing_with_the_wooden_handle_has_one() -> None:
    scene = named_scene("scenario_c", 0)
    thing = scene.instructions[0].things["thing with the wooden handle"]

    assert ("handle", "wood") in {
        (part.name, part.material) for part in shape_of(scene.object(thing)).parts
    }


def test_an_unknown_scene_is_answered_with_the_known_ones() -> None:
    with pytest.raises(ConfigError, match="no scene 'scenario_z'; choose of: scenario_a"):
        named_scene("scenario_z")
