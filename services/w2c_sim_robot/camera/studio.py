"""Turns what the simulator knows into camera messages. Knows nothing of the bus."""

import cv2
import mujoco
import numpy as np
import numpy.typing as npt

from w2c.depth import DEPTH_UNIT, encode_depth
from w2c.errors import ConfigError
from w2c.geometry import Intrinsics, intrinsics_from_fov
from w2c.messages import Array, CameraFrame, Picture, PictureRequest
from w2c_sim_robot import talos
from w2c_sim_robot.camera.renderer import Image, Renderer
from w2c_sim_robot.model import (
    CAMERA_FOVY_DEG,
    CAMERA_SIZE,
    HEAD_CAMERA,
    HEAD_SHELL_GROUP,
    build_model,
)
from w2c_sim_robot.scenes.scene import Scene

JPEG_QUALITY = 95
_LARGEST_PICTURE = (1920, 1080)


class Studio:
    """The model of robot and scene, drawn in the state the simulator reports.

    Belongs to the thread that made it.
    """

    def __init__(
        self,
        scene: Scene | None,
        *,
        size: tuple[int, int] = CAMERA_SIZE,
        jpeg_quality: int = JPEG_QUALITY,
    ) -> None:
        """Build the model.

        Args:
            scene: What stands before the robot; None = nothing but the floor.
            size: Width and height of the head camera's pictures [px].
            jpeg_quality: Of all pictures.
        """
        self.size = size
        self._quality = jpeg_quality
        self.model = build_model(scene)
        self.data = mujoco.MjData(self.model)
        self.renderer = Renderer(self.model, *_LARGEST_PICTURE)

    @property
    def intrinsics(self) -> Intrinsics:
        """Return those of the head camera."""
        return intrinsics_from_fov(*self.size, float(np.radians(CAMERA_FOVY_DEG)))

    def pose(self, generalized_position: Array) -> None:
        """Put everything where the simulator has it.

        Raises:
            ConfigError: the simulator has another model, so another scene.
        """
        if generalized_position.shape != (self.model.nq,):
            raise ConfigError(
                f"the robot reports {generalized_position.size} coordinates, this camera's model "
                f"has {self.model.nq}: start both with the same --scene"
            )
        self.data.qpos[:] = generalized_position
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        mujoco.mj_camlight(self.model, self.data)

    def frame(
        self,
        stamp_ns: int,
        *,
        shadows: bool = False,
        antialiasing: bool = False,
        depth: bool = True,
        robot_boot_id: str = "",
    ) -> CameraFrame:
        """Return what the head camera sees. Its own shell is not drawn: it would hide a third."""
        image = self.shoot(shadows=shadows, antialiasing=antialiasing, depth=depth)
        intrinsics = self.intrinsics
        return CameraFrame(
            stamp_ns=stamp_ns,
            frame=talos.CAMERA_FRAME,
            width=self.size[0],
            height=self.size[1],
            intrinsics=(intrinsics.fx, intrinsics.fy, intrinsics.cx, intrinsics.cy),
            jpeg=jpeg(image.rgb, self._quality),
            depth=encode_depth(image.depth) if depth else b"",
            depth_unit=DEPTH_UNIT,
            robot_boot_id=robot_boot_id,
        )

    def depth(self) -> bytes:
        """Return the depth that the head camera sees, as it is sent."""
        return encode_depth(self.shoot(colours=False).depth)

    def shoot(
        self,
        *,
        shadows: bool = False,
        antialiasing: bool = False,
        depth: bool = True,
        colours: bool = True,
    ) -> Image:
        """Return the head camera's picture as arrays; empty ones for what is not asked for."""
        return self.renderer.draw(
            self.data,
            HEAD_CAMERA,
            size=self.size,
            hidden_groups=(HEAD_SHELL_GROUP,),
            shadows=shadows,
            antialiasing=antialiasing,
            channels="rgbd" if depth and colours else "rgb" if colours else "depth",
        )

    def picture(self, stamp_ns: int, request: PictureRequest) -> Picture:
        """Return a picture of the robot from outside, at its best."""
        return Picture(
            stamp_ns=stamp_ns,
            jpeg=jpeg(self.look(request.view, (request.width, request.height)), self._quality),
        )

    def look(self, view: str, size: tuple[int, int]) -> npt.NDArray[np.uint8]:
        """Return a picture (h, w, 3) at its best of any camera: `head`, or one from outside."""
        hidden = (HEAD_SHELL_GROUP,) if view == HEAD_CAMERA else ()
        return self.renderer.draw(
            self.data, view, size=size, hidden_groups=hidden, shadows=True, antialiasing=True
        ).rgb

    def close(self) -> None:
        """Free the graphics context. Idempotent."""
        self.renderer.close()


def jpeg(rgb: npt.NDArray[np.uint8], quality: int = JPEG_QUALITY) -> bytes:
    """Return the JPEG of a picture (h, w, 3)."""
    done, encoded = cv2.imencode(
        ".jpg", cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR), [cv2.IMWRITE_JPEG_QUALITY, quality]
    )
    if not done:
        raise ValueError(f"no JPEG of a picture of shape {rgb.shape}")
    return encoded.tobytes()
