"""Many scenes with one compiled model: things are moved, repainted and hidden."""

from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt

from w2c_sim_robot import talos
from w2c_sim_robot.camera.renderer import Image, Renderer
from w2c_sim_robot.head_camera import world_from_camera
from w2c_sim_robot.model import HEAD_CAMERA, HEAD_SHELL_GROUP, build_model, ready_configuration
from w2c_sim_robot.scenes.assets import SCENES_PER_STOCK, Asset, paper_scene_of, random_assets
from w2c_sim_robot.scenes.build import VISUAL_GROUP, colour_of, light_colour, paints_of
from w2c_sim_robot.scenes.held_out import is_judging
from w2c_sim_robot.scenes.objects.catalogue import KINDS, make_object, shape_of
from w2c_sim_robot.scenes.objects.shape import Shape
from w2c_sim_robot.scenes.open_work import fill_open_work
from w2c_sim_robot.scenes.scene import Light, Scene, SceneObject, Surroundings
from w2c_sim_robot.scenes.wording import parts_of

HIDDEN_GROUP = 5
HARDWARE_SAMPLES = 4
_DOWN = (0.0, 0.0, -1.0)


@dataclass(frozen=True)
class Shot:
    """One picture of one scene, with what each pixel shows."""

    image: Image
    identity: npt.NDArray[np.uint8]
    """(h, w): 0 nothing, n = the n-th object of the scene, 255 = the robot"""
    parts: npt.NDArray[np.uint8]
    """(h, w): 0 no named part, n = the n-th name of `wording.parts_of` of the object there"""
    world_from_camera: npt.NDArray[np.float64]
    """(4, 4) of the optical frame: x right, y down, z forward"""
    vertical_fov: float
    """[rad]"""


class Pool:
    """A model with a stock of things, of which each scene shows some."""

    def __init__(self, block: int, width: int, height: int) -> None:
        """Compile the stock of the `SCENES_PER_STOCK` seeds of a block."""
        rng = np.random.default_rng([block, 5])
        first = block * SCENES_PER_STOCK
        self.assets: tuple[Asset, ...] = random_assets(
            rng, judging=is_judging(first), paper_scene=paper_scene_of(first)
        )
        stock = [_stored(asset) for asset in self.assets]
        self._shapes: dict[str, Shape] = {item.name: shape_of(item) for item in stock}
        floor = self.floor = str(rng.choice(["tiles", "wood", "concrete", "carpet"]))
        scene = Scene(
            name="pool",
            objects=tuple(stock),
            lights=(
                Light(position=(0, 0, 3), direction=_DOWN),
                Light(position=(0, 0, 3), direction=_DOWN),
            ),
            surroundings=Surroundings(floor=floor, variant=int(rng.integers(1000))),  # type: ignore[arg-type]
        )
        self.model = build_model(scene)
        self._data = mujoco.MjData(self.model)
        self._ready = ready_configuration(self.model)
        self._renderer = Renderer(self.model, width, height, hardware_samples=HARDWARE_SAMPLES)
        self._robot = self.model.body_rootid == self.model.body(talos.BASE_LINK).id

    def shoot(self, scene: Scene, rng: np.random.Generator, *, shadows: bool) -> Shot:
        """Return the picture of a scene of this pool's assets; `rng` draws the robot's posture."""
        self._arrange(scene)
        self._pose_robot(rng, _surface_height(scene))
        fov = np.radians(rng.uniform(40.0, 44.0))
        self.model.cam_fovy[self.model.camera(HEAD_CAMERA).id] = np.degrees(fov)
        hidden = (HEAD_SHELL_GROUP, HIDDEN_GROUP)
        image = self._renderer.draw(self._data, HEAD_CAMERA, hidden_groups=hidden, shadows=shadows)
        geoms, depth = self._renderer.survey(self._data, HEAD_CAMERA, hidden_groups=hidden)
        image = Image(image.rgb, depth)
        pose = world_from_camera(self._data)
        identity = self._identity_of_geom(scene)[geoms]
        parts = self._part_of_geom(scene)[geoms]
        fill_open_work(scene.objects, identity, parts)
        return Shot(image, identity, parts, pose, float(fov))

    def close(self) -> None:
        """Free the graphics context."""
        self._renderer.close()

    def _identity_of_geom(self, scene: Scene) -> npt.NDArray[np.uint8]:
        """Return (ngeom + 1,) so that index -1 is nothing."""
        identity = np.zeros(self.model.ngeom + 1, dtype=np.uint8)
        identity[:-1][self._robot[self.model.geom_bodyid]] = 255
        for number, item in enumerate(scene.objects, start=1):
            identity[:-1][self.model.geom_bodyid == self.model.body(item.name).id] = number
        return identity

    def _part_of_geom(self, scene: Scene) -> npt.NDArray[np.uint8]:
        """Return (ngeom + 1,) so that index -1 is no part."""
        part_of = np.zeros(self.model.ngeom + 1, dtype=np.uint8)
        for item in scene.objects:
            names = parts_of(item)
            for number, part in enumerate(self._shapes[item.name].parts):
                if part.name:
                    geom = self.model.geom(f"{item.name}_visual_{number}").id
                    part_of[geom] = names.index(part.name) + 1
        return part_of

    def _arrange(self, scene: Scene) -> None:
        """Move, paint and hide the stock, and set light and room."""
        shown = {item.name: item for item in scene.objects}
        for name, shape in self._shapes.items():
            item = shown.get(name)
            for number, part in enumerate(shape.parts):
                geom = self.model.geom(f"{name}_visual_{number}").id
                self.model.geom_group[geom] = HIDDEN_GROUP if item is None else VISUAL_GROUP
                if item is not None:
                    material = self.model.geom_matid[geom]
                    self.model.mat_rgba[material, :3] = colour_of(part.surface, paints_of(item))
            if item is not None:
                body = self.model.body(name).id
                x, y, z, w = item.orientation
                self.model.body_pos[body] = item.position
                self.model.body_quat[body] = (w, x, y, z)
        self._light(scene)

    def _light(self, scene: Scene) -> None:
        model = self.model
        for number, light in enumerate(scene.lights):
            lamp = model.light(f"lamp_{number}").id
            model.light_pos[lamp] = light.position
            model.light_dir[lamp] = np.asarray(light.direction) / np.linalg.norm(light.direction)
            model.light_diffuse[lamp] = light_colour(light)
            model.light_castshadow[lamp] = light.shadow
        model.mat_rgba[model.material("scene_floor").id, :3] = scene.surroundings.floor_colour
        model.mat_rgba[model.material("scene_wall").id, :3] = scene.surroundings.wall_colour
        model.vis.headlight.ambient[:] = scene.surroundings.ambient

    def _pose_robot(self, rng: np.random.Generator, surface: float) -> None:
        """Bend the robot: head and torso a little, the hands above the surface in most pictures."""
        data = self._data
        data.qpos[:] = self._ready
        data.qpos[:3] += rng.normal(0.0, 0.02, 3)
        pitch = rng.uniform(-0.05, 0.12)
        data.qpos[3:7] = (np.cos(pitch / 2), 0.0, np.sin(pitch / 2), 0.0)
        self._bend(rng, "head_1_joint", -0.4 if rng.random() < 0.5 else -0.1, 0.085)
        # A leaning robot turns its trunk, and its head the other way to keep its gaze.
        turn = rng.uniform(-0.45, 0.45) if rng.random() < 0.5 else rng.uniform(-0.1, 0.1)
        self._bend(rng, "torso_1_joint", turn, turn)
        self._bend(rng, "head_2_joint", -turn - 0.2, -turn + 0.2)
        self._bend(rng, "torso_2_joint", -0.05, 0.3)
        for joints, hand in zip((talos.LEFT_ARM, talos.RIGHT_ARM), talos.HAND_FRAMES, strict=True):
            if rng.random() < 0.75:
                self._raise_hand(rng, joints, hand, surface)
        mujoco.mj_kinematics(self.model, data)
        mujoco.mj_comPos(self.model, data)
        mujoco.mj_camlight(self.model, data)

    def _raise_hand(
        self, rng: np.random.Generator, joints: tuple[str, ...], hand: str, surface: float
    ) -> None:
        """Draw arm postures until the hand is over the surface; keep the last one in any case."""
        for _ in range(80):
            for name in joints:
                self._bend(rng, name, -0.8, 0.8)
            mujoco.mj_kinematics(self.model, self._data)
            x, y, z = self._data.body(hand).xpos
            if 0.42 < x < 1.0 and abs(y) < 0.5 and surface + 0.03 < z < surface + 0.3:
                return

    def _bend(self, rng: np.random.Generator, joint: str, low: float, high: float) -> None:
        """Set a joint this much away from ready, within its limits."""
        row = self.model.joint(joint)
        address = row.qposadr[0]
        angle = self._ready[address] + rng.uniform(low, high)
        self._data.qpos[address] = np.clip(angle, *row.range)


def _surface_height(scene: Scene) -> float:
    """Return the height of the furniture, or of the floor [m]."""
    first = scene.objects[0]
    return first.size[2] if KINDS[first.kind].furniture else 0.0


def _stored(asset: Asset) -> SceneObject:
    """Return the thing as it is compiled: out of sight, and fixed, to be posed in the model."""
    return make_object(
        asset.kind,
        KINDS[asset.kind].colours[0],
        (0.0, 0.0, -20.0),
        name=asset.name,
        size=asset.size,
        variant=asset.variant,
        movable=False,
        material=asset.material,
    )
