"""Draw a MuJoCo model: colour and depth in one pass, and which object each pixel shows.

A renderer belongs to the thread that made it, because its OpenGL context does.
"""

from dataclasses import dataclass
from typing import Literal

import cv2
import mujoco
import numpy as np
import numpy.typing as npt

from w2c.errors import ConfigError
from w2c_sim_robot.camera.culling import culled, may_be_seen
from w2c_sim_robot.camera.gl import make_context

SUPERSAMPLING = 2
"""Antialiased pictures are drawn so many times larger, then shrunk."""


@dataclass(frozen=True)
class Image:
    """What a camera saw."""

    rgb: npt.NDArray[np.uint8]
    """(h, w, 3)"""
    depth: npt.NDArray[np.float32]
    """(h, w) z-depth [m]; 0 where nothing is"""


Channels = Literal["rgbd", "rgb", "depth"]


class Renderer:
    """Draws one model. Close it: it holds a graphics context."""

    def __init__(
        self, model: mujoco.MjModel, width: int, height: int, *, hardware_samples: int = 0
    ) -> None:
        """Take the largest size that will be asked for.

        `hardware_samples` > 0 smooths every picture, and makes its depth useless at edges.

        Raises:
            ConfigError: a size without pixels, or no OpenGL.
        """
        if width < 1 or height < 1:
            raise ConfigError(f"a camera of {width}x{height} px; ask for 1x1 px or more")
        self._model = model
        self._largest = (width, height)
        model.vis.global_.offwidth = SUPERSAMPLING * width
        model.vis.global_.offheight = SUPERSAMPLING * height
        model.vis.quality.offsamples = hardware_samples
        self._scene = mujoco.MjvScene(model, maxgeom=4000)
        # Small: what is drawn goes to a buffer of MuJoCo's, not to the context's own.
        self._context = make_context(16, 16)
        self._context.make_current()
        self._gpu = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100.value)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN.value, self._gpu)
        self._gpu.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR.value

    def draw(
        self,
        data: mujoco.MjData,
        camera: str,
        *,
        size: tuple[int, int] | None = None,
        hidden_groups: tuple[int, ...] = (),
        shadows: bool = False,
        antialiasing: bool = False,
        channels: Channels = "rgbd",
    ) -> Image:
        """Return the picture of a camera. `size` = (width, height), by default the largest.

        What is not among the `channels` is empty, (0, 0), and costs less time.
        """
        width, height = self._size(size)
        scale = SUPERSAMPLING if antialiasing else 1
        flags = {mujoco.mjtRndFlag.mjRND_SHADOW: shadows}
        rgb, depth = self._render(
            data, camera, (scale * width, scale * height), hidden_groups, flags, channels
        )
        if antialiasing and rgb.size:
            rgb = cv2.resize(rgb, (width, height), interpolation=cv2.INTER_AREA).astype(np.uint8)
            # The mean of two depths lies in the air between two surfaces: take one of them.
            depth = np.ascontiguousarray(depth[1::scale, 1::scale])
        return Image(rgb, depth)

    def segment(
        self,
        data: mujoco.MjData,
        camera: str,
        *,
        size: tuple[int, int] | None = None,
        hidden_groups: tuple[int, ...] = (),
    ) -> npt.NDArray[np.int32]:
        """Return (h, w): the id of the geom that each pixel shows, -1 where none is."""
        return self.survey(data, camera, size=size, hidden_groups=hidden_groups)[0]

    def survey(
        self,
        data: mujoco.MjData,
        camera: str,
        *,
        size: tuple[int, int] | None = None,
        hidden_groups: tuple[int, ...] = (),
    ) -> tuple[npt.NDArray[np.int32], npt.NDArray[np.float32]]:
        """Return the geoms that `segment` returns, and z-depth (h, w) [m], exact up to edges.

        Nothing is smoothed here, whatever `hardware_samples` is.
        """
        flags = {mujoco.mjtRndFlag.mjRND_SEGMENT: True, mujoco.mjtRndFlag.mjRND_IDCOLOR: True}
        rgb, depth = self._render(data, camera, self._size(size), hidden_groups, flags)
        code = rgb.astype(np.int32) @ np.array([1, 2**8, 2**16], dtype=np.int32)  # (h, w)
        geom_of_code = np.full(self._scene.ngeom + 1, -1, dtype=np.int32)
        for geom in self._scene.geoms[: self._scene.ngeom]:
            if geom.segid >= 0 and geom.objtype == mujoco.mjtObj.mjOBJ_GEOM:
                geom_of_code[geom.segid + 1] = geom.objid
        return np.asarray(geom_of_code[code], dtype=np.int32), depth

    def close(self) -> None:
        """Free the graphics context. Idempotent."""
        if self._gpu is not None:
            self._context.make_current()
            self._gpu.free()
            self._context.free()
            self._gpu = None

    def _size(self, size: tuple[int, int] | None) -> tuple[int, int]:
        width, height = self._largest if size is None else size
        if width < 1 or height < 1:
            raise ConfigError(f"a picture of {width}x{height} px; ask for 1x1 px or more")
        if width > self._largest[0] or height > self._largest[1]:
            raise ConfigError(
                f"a picture of {width}x{height} px was asked of a renderer made for "
                f"{self._largest[0]}x{self._largest[1]}; ask for a smaller one"
            )
        return width, height

    def _render(
        self,
        data: mujoco.MjData,
        camera: str,
        size: tuple[int, int],
        hidden_groups: tuple[int, ...],
        flags: dict[mujoco.mjtRndFlag, bool],
        channels: Channels = "rgbd",
    ) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.float32]]:
        """Draw once; return colours (h, w, 3) and z-depth (h, w) [m], 0 at the far plane."""
        width, height = size
        option = mujoco.MjvOption()
        option.flags[mujoco.mjtVisFlag.mjVIS_TEXTURE] = "rgb" in channels
        for group in hidden_groups:
            option.geomgroup[group] = 0
        view = mujoco.MjvCamera()
        view.type = mujoco.mjtCamera.mjCAMERA_FIXED
        view.fixedcamid = self._model.camera(camera).id
        # What throws a shadow into the picture need not be in it.
        shadows = flags.get(mujoco.mjtRndFlag.mjRND_SHADOW, False)
        seen = None if shadows else may_be_seen(self._model, data, view.fixedcamid, width / height)
        with culled(self._model, option, seen):
            mujoco.mjv_updateScene(
                self._model, data, option, None, view, mujoco.mjtCatBit.mjCAT_ALL.value, self._scene
            )
        usual = self._scene.flags.copy()
        try:
            for flag, value in flags.items():
                self._scene.flags[flag] = value
            self._context.make_current()
            viewport = mujoco.MjrRect(0, 0, width, height)
            mujoco.mjr_render(viewport, self._scene, self._gpu)
            shape = (height, width)
            rgb = np.empty((*shape, 3) if "rgb" in channels else (0, 0, 3), np.uint8)
            buffer = np.empty(shape if channels != "rgb" else (0, 0), np.float32)
            mujoco.mjr_readPixels(
                rgb if rgb.size else None, buffer if buffer.size else None, viewport, self._gpu
            )
        finally:
            np.copyto(self._scene.flags, usual)
        # OpenGL's first row is the lowest one.
        return np.ascontiguousarray(rgb[::-1]), self._metric(buffer[::-1])

    def _metric(self, buffer: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        """Return z-depth [m] of a depth buffer that is 1 at the near plane and 0 at the far one.

        The projection of OpenGL (glFrustum), reversed: buffer = (near / z - near / far) / (1 -
        near / far).
        """
        extent = self._model.stat.extent
        near, far = self._model.vis.map.znear * extent, self._model.vis.map.zfar * extent
        # In single precision, in place: off by less than a millionth.
        depth = np.multiply(buffer, np.float32(far - near), dtype=np.float32)
        depth += np.float32(near)
        np.divide(np.float32(near * far), depth, out=depth)
        depth[buffer <= 0.0] = 0.0
        return depth
