"""Talos, floor, light and cameras as a MuJoCo model; the scene comes from `scenes.build`.

Who collides with whom: the robot with the world, the world with itself, the robot never with itself
(the wheel's convex hulls overlap by up to 9 cm in a natural posture).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np

from w2c.geometry import base_from_midfeet, inverse, quaternion_from_rotation, transform, unit
from w2c.messages import Array
from w2c_sim_robot import talos
from w2c_sim_robot.perturbation import Perturbation, perturb, raise_scene, tilt_soles
from w2c_sim_robot.urdf import make_urdf, mujoco_urdf

if TYPE_CHECKING:
    from w2c_sim_robot.scenes.scene import Scene

PHYSICS_STEP_S = 0.001

ROBOT_CONTYPE, ROBOT_CONAFFINITY = 1, 2
WORLD_CONTYPE, WORLD_CONAFFINITY = 2, 3
"""Collision bits: give the second pair to everything in a scene."""

WORLD_GROUP, ROBOT_GROUP, HEAD_SHELL_GROUP, COLLISION_GROUP = 0, 1, 2, 3
"""Geom groups. The head's shell hides a third of the head camera's picture: do not draw it there.
Collision shapes are in a group that MuJoCo does not draw by default."""

HEAD_CAMERA = "head"
CAMERA_SIZE = (1280, 720)
CAMERA_FOVY_DEG = 42.0

# Where pictures from outside are taken from, and what they look at [m].
_VIEWS = {
    "side": ((0.9, -2.7, 1.5), (0.3, 0.0, 0.85)),
    "front": ((2.9, 0.5, 1.6), (0.2, 0.0, 0.85)),
    "over_shoulder": ((-1.5, 1.2, 2.2), (0.45, -0.05, 0.85)),
}

_DAMPING_SHARE = 0.02  # kv / kp: gives the sway of the standing robot a damping ratio of about 0.1
_ARMATURE = 0.1  # reflected rotor inertia [kg m^2]
_FRICTION = (0.8, 0.01, 0.001)  # sliding, torsion [m], rolling [m]: rubber on paper, wood or floor
_CONTACT_TIME_S = 0.005  # the floor gives way by less than 0.1 mm


def build_spec(scene: Scene | None = None) -> mujoco.MjSpec:
    """Return the model to be compiled: robot, floor, light, cameras, sensors, and the scene.

    Angles that are added to it are in radians: it comes from a URDF.

    Raises:
        ConfigError: the wheel with the robot's meshes is not installed.
    """
    spec = mujoco.MjSpec.from_string(mujoco_urdf(make_urdf()))
    spec.modelname = "talos"
    _set_options(spec)
    spec.body(talos.BASE_LINK).add_freejoint(name="base")
    _sort_geoms(spec)
    _add_actuators(spec)
    _add_sensors(spec)
    _add_cameras(spec)
    _add_surroundings(spec)
    if scene is not None:
        from w2c_sim_robot.scenes.build import add_scene

        add_scene(spec, scene)
    return spec


def build_model(
    scene: Scene | None = None,
    perturbation: Perturbation | None = None,
    *,
    visuals: bool = True,
) -> mujoco.MjModel:
    """Return the compiled model. Raises ConfigError as `build_spec`."""
    if scene is not None and perturbation is not None and perturbation.table_height:
        scene = raise_scene(scene, perturbation.table_height)
    return compile_spec(build_spec(scene), perturbation, visuals=visuals)


def compile_spec(
    spec: mujoco.MjSpec, perturbation: Perturbation | None = None, *, visuals: bool = True
) -> mujoco.MjModel:
    """Return the compiled model of a spec, perturbed.

    Without visuals it is half as large and moves the same: what the driver needs.
    """
    if not visuals:
        _drop_visuals(spec)
    if perturbation is None:
        return spec.compile()
    tilt_soles(spec, perturbation)
    model = spec.compile()
    perturb(model, perturbation)
    return model


def ready_configuration(model: mujoco.MjModel) -> Array:
    """Return the generalized position (nq,) of the robot standing ready, objects where they start.

    The soles are on the floor, and the world's origin is midway between them.
    """
    data = mujoco.MjData(model)
    for name, angle in talos.READY.items():
        data.joint(name).qpos = angle
    base = model.joint("base").qposadr[0]
    data.qpos[base : base + 7] = (0, 0, 0, 1, 0, 0, 0)
    mujoco.mj_kinematics(model, data)
    left, right = (
        transform(data.body(name).xmat.reshape(3, 3), data.body(name).xpos)
        for name in talos.SOLE_FRAMES
    )
    world_from_base = inverse(base_from_midfeet(left, right))
    data.qpos[base : base + 3] = world_from_base[:3, 3]
    data.qpos[base + 3 : base + 7] = np.roll(quaternion_from_rotation(world_from_base[:3, :3]), 1)
    return np.array(data.qpos)


def _set_options(spec: mujoco.MjSpec) -> None:
    option = spec.option
    option.timestep = PHYSICS_STEP_S
    option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    option.impratio = 10.0  # feet and hand must not creep under load
    # A simulation that diverged is an error, not a robot back at the start.
    option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    # Scales the clipping planes of the cameras, which come out at 4 cm and 40 m.
    spec.stat.extent = 2.0
    spec.stat.center = (0.3, 0.0, 0.8)
    visual = spec.visual
    visual.map.znear, visual.map.zfar = 0.02, 20.0
    visual.global_.offwidth, visual.global_.offheight = 1920, 1080
    visual.quality.shadowsize = 4096
    visual.headlight.ambient = (0.35, 0.35, 0.35)
    visual.headlight.diffuse = (0.35, 0.35, 0.35)
    visual.headlight.specular = (0.1, 0.1, 0.1)


def _is_in_head(body: Any) -> bool:
    while body is not None and body.name not in ("", "world"):
        if body.name == "head_1_link":
            return True
        body = body.parent
    return False


def _sort_geoms(spec: mujoco.MjSpec) -> None:
    """Give the robot's shapes their groups, collision bits and contact properties."""
    for geom in spec.geoms:
        if geom.contype == 0:
            geom.group = HEAD_SHELL_GROUP if _is_in_head(geom.parent) else ROBOT_GROUP
            continue
        geom.group = COLLISION_GROUP
        geom.contype, geom.conaffinity = ROBOT_CONTYPE, ROBOT_CONAFFINITY
        # With priority the robot's rubber decides, whatever a scene says of its objects.
        geom.priority = 1
        geom.friction = _FRICTION
        geom.condim = 4 if geom.parent.name in talos.HAND_FRAMES else 3
        geom.solref = (_CONTACT_TIME_S, 1.0)


def _add_actuators(spec: mujoco.MjSpec) -> None:
    """Drive each joint by a spring to the commanded angle: torque = kp (command - q) - kv dq/dt."""
    for name in talos.ACTUATED:
        stiffness = talos.STIFFNESS[name]
        joint = spec.joint(name)
        joint.armature = _ARMATURE if name not in talos.HEAD else 0.01
        actuator = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        actuator.set_to_position(kp=stiffness, kv=_DAMPING_SHARE * stiffness)


def _add_sensors(spec: mujoco.MjSpec) -> None:
    kinds = mujoco.mjtSensor
    sites = {
        "left_sole": talos.SOLE_FRAMES[0],
        "right_sole": talos.SOLE_FRAMES[1],
        "left_wrist": talos.WRIST_SENSOR_LINK,
    }
    site = mujoco.mjtObj.mjOBJ_SITE
    for name, link in sites.items():
        spec.body(link).add_site(name=name, group=5)
        spec.add_sensor(name=f"{name}_force", type=kinds.mjSENS_FORCE, objtype=site, objname=name)
        spec.add_sensor(name=f"{name}_torque", type=kinds.mjSENS_TORQUE, objtype=site, objname=name)
    spec.body(talos.IMU_LINK).add_site(name="imu", group=5)
    for name, kind in (
        ("imu_orientation", kinds.mjSENS_FRAMEQUAT),
        ("imu_angular_velocity", kinds.mjSENS_GYRO),
        ("imu_linear_acceleration", kinds.mjSENS_ACCELEROMETER),
    ):
        spec.add_sensor(name=name, type=kind, objtype=site, objname="imu")


def _look_at(eye: Array, target: Array) -> Array:
    """Return the quaternion wxyz of a MuJoCo camera (looks along -z, y up) at `eye`."""
    back = unit(eye - target)
    right = unit(np.cross((0.0, 0.0, 1.0), back))
    rotation = np.column_stack([right, np.cross(back, right), back])
    return np.roll(quaternion_from_rotation(rotation), 1)


def _add_cameras(spec: mujoco.MjSpec) -> None:
    # The optical frame looks along z with y down, a MuJoCo camera along -z with y up.
    spec.body(talos.CAMERA_FRAME).add_camera(
        name=HEAD_CAMERA,
        quat=(0.0, 1.0, 0.0, 0.0),
        fovy=CAMERA_FOVY_DEG,
        resolution=CAMERA_SIZE,
    )
    for name, (eye, target) in _VIEWS.items():
        spec.worldbody.add_camera(
            name=name, pos=eye, quat=_look_at(np.array(eye), np.array(target)), fovy=40.0
        )


def _add_surroundings(spec: mujoco.MjSpec) -> None:
    """Add sky, light and floor."""
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=(0.85, 0.88, 0.92),
        rgb2=(0.55, 0.60, 0.68),
        width=256,
        height=256,
    )
    spec.add_texture(
        name="floor",
        type=mujoco.mjtTexture.mjTEXTURE_2D,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
        rgb1=(0.66, 0.66, 0.64),
        rgb2=(0.58, 0.58, 0.57),
        width=256,
        height=256,
    )
    floor_material = spec.add_material(name="floor", texrepeat=(1.0, 1.0), texuniform=True)
    floor_material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "floor"
    spec.worldbody.add_geom(
        name="floor",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=(10.0, 10.0, 0.05),
        material="floor",
        contype=WORLD_CONTYPE,
        conaffinity=WORLD_CONAFFINITY,
        castshadow=False,  # a plane that shadows itself shows moire
    )
    spec.worldbody.add_light(
        name="ceiling",
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        pos=(1.0, -1.5, 4.0),
        dir=(-0.25, 0.35, -1.0),
        diffuse=(0.55, 0.55, 0.53),
        specular=(0.2, 0.2, 0.2),
        castshadow=True,
    )


def _drop_visuals(spec: mujoco.MjSpec) -> None:
    for geom in list(spec.geoms):
        if geom.contype == 0 and geom.conaffinity == 0:
            spec.delete(geom)
    used = {geom.meshname for geom in spec.geoms}
    for mesh in list(spec.meshes):
        if mesh.name not in used:
            spec.delete(mesh)
