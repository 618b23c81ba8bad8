"""Put a scene into a MuJoCo model specification."""

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np

from w2c.geometry import Vector, quaternion_from_rotation
from w2c_sim_robot.scenes.objects import textures
from w2c_sim_robot.scenes.objects.catalogue import KINDS, shape_of
from w2c_sim_robot.scenes.objects.palette import COLOURS, Colour, Paints, contrasting, shade
from w2c_sim_robot.scenes.objects.shape import Collider, Mesh, Surface, Texture
from w2c_sim_robot.scenes.scene import Light, Scene, SceneObject, Surroundings

VISUAL_GROUP = 0
COLLIDER_GROUP = 3
WORLD_CONTYPE, WORLD_CONAFFINITY = 2, 3
"""The robot has 1 and 2: it meets the world, the world meets itself, the robot never meets
itself."""
FLOOR = "floor"
TILE = 0.5
"""Side of one tile of the floor [m]; its texture shows four by four"""
WALL_DISTANCE = 4.0
_FLOORS: dict[str, Callable[[np.random.Generator], Texture]] = {
    "tiles": textures.tiles,
    "wood": textures.wood,
    "concrete": textures.concrete,
    "carpet": textures.weave,
}
_SHAPES = {
    "box": mujoco.mjtGeom.mjGEOM_BOX,
    "cylinder": mujoco.mjtGeom.mjGEOM_CYLINDER,
    "sphere": mujoco.mjtGeom.mjGEOM_SPHERE,
    "capsule": mujoco.mjtGeom.mjGEOM_CAPSULE,
}


def add_scene(spec: mujoco.MjSpec, scene: Scene) -> None:
    """Add floor, walls, lights and objects.

    A body carries the name of its object; a movable one has a free joint `<name>_free`. A floor
    that the specification has already (a geom named "floor") is kept and only painted; lamps it
    has are put out.
    """
    _add_surroundings(spec, scene.surroundings)
    for light in spec.lights:
        light.active = False
    for number, light in enumerate(scene.lights):
        _add_light(spec, light, f"lamp_{number}")
    for item in scene.objects:
        add_object(spec, item)


def add_object(spec: mujoco.MjSpec, item: SceneObject) -> None:
    """Add one object: geoms `<name>_visual_<n>` to see, `<name>_collider_<n>` to touch."""
    x, y, z, w = item.orientation
    body = spec.worldbody.add_body(name=item.name, pos=item.position, quat=[w, x, y, z])
    shape = shape_of(item)
    paints = paints_of(item)
    for number, part in enumerate(shape.parts):
        name = f"{item.name}_visual_{number}"
        _add_mesh(spec, name, part.mesh)
        _add_material(spec, name, part.surface, paints)
        body.add_geom(
            name=name,
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=name,
            material=name,
            group=VISUAL_GROUP,
            contype=0,
            conaffinity=0,
            mass=0.0,
        )
    add_colliders(body, item)
    if item.movable:
        body.add_freejoint(name=f"{item.name}_free")


def add_colliders(body: Any, item: SceneObject) -> None:
    """Give a body of a specification what can be touched of an object, and its mass."""
    shape = shape_of(item)
    volumes = np.array([_volume(collider) for collider in shape.colliders])
    for number, (collider, volume) in enumerate(zip(shape.colliders, volumes, strict=True)):
        body.add_geom(
            name=f"{item.name}_collider_{number}",
            type=_SHAPES[collider.shape],
            size=(*collider.size, *(0.0,) * (3 - len(collider.size))),
            pos=collider.position,
            group=COLLIDER_GROUP,
            contype=WORLD_CONTYPE,
            conaffinity=WORLD_CONAFFINITY,
            mass=item.mass * float(volume / volumes.sum()),
            friction=(0.8, 0.01, 0.001),
        )


def paints_of(item: SceneObject) -> Paints:
    """Return what the object is painted in: a shade of its colour that its variant chooses."""
    usual = KINDS[item.kind].tones.get(item.colour, COLOURS[item.colour])
    main = shade(usual, np.random.default_rng([item.variant, 11]))
    return Paints(main, contrasting(main))


def colour_of(surface: Surface, paints: Paints) -> Colour:
    """Return the colour that multiplies the texture of a surface."""
    if surface.paint == "main":
        return paints.main
    if surface.paint == "accent":
        return paints.accent
    return surface.paint


def _add_mesh(spec: mujoco.MjSpec, name: str, mesh: Mesh) -> None:
    spec.add_mesh(
        name=name,
        uservert=mesh.vertices.ravel().tolist(),
        usernormal=mesh.normals.ravel().tolist(),
        usertexcoord=mesh.texcoords.ravel().tolist(),
        userface=mesh.faces.ravel().tolist(),
        userfacenormal=mesh.faces.ravel().tolist(),
        userfacetexcoord=mesh.faces.ravel().tolist(),
        inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
    )


def _add_material(spec: mujoco.MjSpec, name: str, surface: Surface, paints: Paints) -> None:
    material = spec.add_material(
        name=name,
        rgba=(*colour_of(surface, paints), surface.opacity),
        specular=0.75 * surface.gloss,
        shininess=0.15 + 0.75 * surface.gloss,
    )
    if surface.texture is not None:
        _add_texture(spec, name, surface.texture)
        _use_texture(material, name)


def _add_texture(spec: mujoco.MjSpec, name: str, texture: Texture) -> None:
    height, width, channels = texture.shape
    added = spec.add_texture(
        name=name,
        type=mujoco.mjtTexture.mjTEXTURE_2D,
        width=width,
        height=height,
        nchannel=channels,
    )
    # The first row of a picture is its top, that of an OpenGL texture is at coordinate 0: the same
    # here, because meshes.py counts texture coordinates from the top.
    added.data = texture.tobytes()


def _use_texture(material: Any, name: str) -> None:
    slots = list(material.textures)
    slots[int(mujoco.mjtTextureRole.mjTEXROLE_RGB)] = name
    material.textures = slots


def _volume(collider: Collider) -> float:
    size = collider.size
    if collider.shape == "box":
        return 8.0 * size[0] * size[1] * size[2]
    if collider.shape == "sphere":
        return 4.0 / 3.0 * np.pi * size[0] ** 3
    round_ends = 4.0 / 3.0 * np.pi * size[0] ** 3 if collider.shape == "capsule" else 0.0
    return 2.0 * np.pi * size[0] ** 2 * size[1] + round_ends


def light_colour(light: Light) -> Vector:
    """Return the colour (3,) of the lamp's light."""
    warm = np.array([1.0 + 0.08 * light.warmth, 1.0, 1.0 - 0.16 * light.warmth])
    return np.clip(light.brightness * warm, 0.0, 1.0)


def _add_light(spec: mujoco.MjSpec, light: Light, name: str) -> None:
    spec.worldbody.add_light(
        name=name,
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        pos=light.position,
        dir=light.direction,
        diffuse=light_colour(light),
        specular=np.full(3, 0.35 * light.brightness),
        ambient=np.zeros(3),
        castshadow=light.shadow,
    )


def _add_surroundings(spec: mujoco.MjSpec, surroundings: Surroundings) -> None:
    rng = np.random.default_rng([surroundings.variant, 3])
    pattern = _FLOORS[surroundings.floor](rng)
    _add_texture(spec, "scene_floor", pattern)
    material = spec.add_material(
        name="scene_floor",
        rgba=(*surroundings.floor_colour, 1.0),
        specular=0.1,
        shininess=0.3,
        texuniform=True,
    )
    material.texrepeat = (0.25 / TILE, 0.25 / TILE)
    _use_texture(material, "scene_floor")
    floor = spec.geom(FLOOR)
    if floor is None:
        floor = spec.worldbody.add_geom(
            name=FLOOR,
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            size=(0.0, 0.0, 0.05),
            contype=WORLD_CONTYPE,
            conaffinity=WORLD_CONAFFINITY,
            group=VISUAL_GROUP,
        )
    floor.material = "scene_floor"
    floor.castshadow = False  # it can only shade itself, in bands
    _add_walls(spec, surroundings)
    spec.visual.headlight.ambient = np.full(3, surroundings.ambient)
    spec.visual.headlight.diffuse = np.full(3, 0.12)
    spec.visual.headlight.specular = np.zeros(3)


def _add_walls(spec: mujoco.MjSpec, surroundings: Surroundings) -> None:
    """Add four walls, to be seen only: nothing can touch them."""
    spec.add_material(
        name="scene_wall", rgba=(*surroundings.wall_colour, 1.0), specular=0.0, emission=0.35
    )
    for quarter, name in enumerate(("wall_ahead", "wall_left", "wall_behind", "wall_right")):
        angle = quarter * np.pi / 2
        towards = np.array([np.cos(angle), np.sin(angle), 0.0])
        sideways = np.array([-np.sin(angle), np.cos(angle), 0.0])
        inwards = np.column_stack([sideways, (0.0, 0.0, -1.0), -towards])
        spec.worldbody.add_geom(
            name=name,
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            size=(10.0, 10.0, 0.05),
            pos=WALL_DISTANCE * towards,
            quat=np.roll(quaternion_from_rotation(inwards), 1),
            material="scene_wall",
            group=VISUAL_GROUP,
            contype=0,
            conaffinity=0,
            castshadow=False,
        )
