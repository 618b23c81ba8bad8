"""Where things go: free places on tables, boards and floors, on top of things, behind things."""

from dataclasses import dataclass

import numpy as np

from w2c_sim_robot.scenes.assets import Asset
from w2c_sim_robot.scenes.objects.catalogue import KINDS, make_object
from w2c_sim_robot.scenes.scene import Quaternion, SceneObject

FLAT_KINDS = (
    "book",
    "box",
    "tray",
    "notebook",
    "cloth",
    "paper",
    "cutting_board",
    "binder",
    "shirt",
)
"""What smaller things may stand on"""
SMALL_KINDS = (
    "mug", "can", "ball", "apple", "sponge", "block", "bottle", "bowl", "glass", "jar", "banana",
    "tape", "stapler", "soap_dispenser", "screwdriver", "milk_carton",
)  # fmt: skip
GAP = 0.012
"""Between things that stand beside each other [m]"""
TRIES = 40
EYE = (0.2, 0.0)
"""Where the camera is about, seen from above [m]"""
LYING_SHARE = 0.25
ON_TOP_SHARE = 0.25


Region = tuple[tuple[float, float], tuple[float, float]]
"""x and y, each from and to [m]"""


@dataclass(frozen=True)
class Surface:
    """A level rectangle that things may stand on, at right angles to the world's axes [m]."""

    low: tuple[float, float]
    high: tuple[float, float]
    height: float
    clearance: float = 2.0
    """Free height above it"""


@dataclass(frozen=True)
class Placed:
    """A thing in its place, and the upright cylinder that it fills [m]."""

    item: SceneObject
    middle: tuple[float, float]
    radius: float
    foot: float
    top: float

    def near(self, middle: tuple[float, float], radius: float, foot: float, top: float) -> bool:
        """Whether a thing there would touch this one."""
        if foot > self.top - 1e-6 or top < self.foot + 1e-6:
            return False
        away = np.hypot(middle[0] - self.middle[0], middle[1] - self.middle[1])
        return bool(away < radius + self.radius + GAP)


class Arranger:
    """Puts one thing after another where there is room."""

    def __init__(self, rng: np.random.Generator, surfaces: tuple[Surface, ...]) -> None:
        self._rng = rng
        self._surfaces = surfaces
        self.placed: list[Placed] = []

    def put(
        self,
        asset: Asset,
        colour: str,
        *,
        region: Region | None = None,
        behind: Placed | None = None,
    ) -> Placed | None:
        """Place a thing, within `region` (x and y [m]) or behind another; None without room."""
        rng = self._rng
        yaw = float(rng.uniform(-np.pi, np.pi) if rng.random() < 0.5 else rng.normal(0.0, 0.35))
        lying = KINDS[asset.kind].lies and region is None and rng.random() < LYING_SHARE
        if region is None and behind is None and not lying:
            on_top = self._on_top(asset, colour, yaw)
            if on_top is not None:
                return on_top
        surface = self._surfaces[int(rng.integers(len(self._surfaces)))]
        x, y, z = asset.size
        radius = 0.5 * float(np.hypot(z, x) if lying else np.hypot(x, y))
        tall = x if lying else z
        if tall > surface.clearance:
            return None
        for _ in range(TRIES):
            middle = self._draw(surface, radius, region, behind)
            if middle is None:
                return None
            foot, top = surface.height, surface.height + tall
            if not any(other.near(middle, radius, foot, top) for other in self.placed):
                item = (
                    _lay(asset, colour, middle, foot, yaw)
                    if lying
                    else _stand(asset, colour, middle, foot, yaw)
                )
                return self._keep(Placed(item, middle, radius, foot, top))
        return None

    def _draw(
        self,
        surface: Surface,
        radius: float,
        region: Region | None,
        behind: Placed | None,
    ) -> tuple[float, float] | None:
        """Return a place on a surface for a thing of this radius; None where it is too large."""
        rng = self._rng
        low_x, high_x = surface.low[0] + radius, surface.high[0] - radius
        low_y, high_y = surface.low[1] + radius, surface.high[1] - radius
        if high_x <= low_x or high_y <= low_y:
            return None
        if behind is not None:
            away = np.subtract(behind.middle, EYE)
            length = float(np.linalg.norm(away))
            further = length + behind.radius + radius + GAP + float(rng.uniform(0.0, 0.12))
            x, y = np.asarray(EYE) + away * (further / length) + rng.normal(0.0, 0.03, 2)
        elif region is not None:
            x, y = rng.uniform(*region[0]), rng.uniform(*region[1])
        else:
            x = rng.uniform(low_x, high_x)
            # The picture is wider far away.
            reach = 0.12 + 0.5 * x
            y = rng.uniform(-reach, reach)
        return float(np.clip(x, low_x, high_x)), float(np.clip(y, low_y, high_y))

    def _on_top(self, asset: Asset, colour: str, yaw: float) -> Placed | None:
        """Return the thing on top of a larger flat one, sometimes."""
        if asset.kind not in SMALL_KINDS or self._rng.random() >= ON_TOP_SHARE:
            return None
        radius = 0.5 * float(np.hypot(asset.size[0], asset.size[1]))
        for below in list(self.placed):
            foot = below.item.position[2] + _rest_share(below.item.kind) * below.item.size[2]
            top = foot + asset.size[2]
            fits = below.item.kind in FLAT_KINDS and radius < 0.55 * min(below.item.size[:2])
            others = (other for other in self.placed if other is not below)
            if fits and not any(other.near(below.middle, radius, foot, top) for other in others):
                item = _stand(asset, colour, below.middle, foot, yaw)
                return self._keep(Placed(item, below.middle, radius, foot, top))
        return None

    def _keep(self, placed: Placed) -> Placed:
        self.placed.append(placed)
        return placed


def _stand(
    asset: Asset, colour: str, middle: tuple[float, float], foot: float, yaw: float
) -> SceneObject:
    return make_object(
        asset.kind,
        colour,
        (*middle, foot),
        name=asset.name,
        size=asset.size,
        yaw=yaw,
        variant=asset.variant,
        material=asset.material,
    )


def _lay(
    asset: Asset, colour: str, middle: tuple[float, float], foot: float, yaw: float
) -> SceneObject:
    """Return a round thing on its side: turned by 90 degrees about its own x, then by `yaw`."""
    import msgspec

    half, tall = asset.size[1] / 2, asset.size[2]
    upright = _stand(asset, colour, middle, foot, 0.0)
    a, b = np.sqrt(0.5), np.sqrt(0.5)
    sine, cosine = np.sin(yaw / 2), np.cos(yaw / 2)
    orientation: Quaternion = (
        float(a * cosine), float(a * sine), float(b * sine), float(b * cosine)
    )  # fmt: skip
    # Its own axis now points along (sin yaw, -cos yaw); the origin is at its underside.
    x = middle[0] - 0.5 * tall * float(np.sin(yaw))
    y = middle[1] + 0.5 * tall * float(np.cos(yaw))
    return msgspec.structs.replace(upright, position=(x, y, foot + half), orientation=orientation)


def _rest_share(kind: str) -> float:
    """Return the height of what carries things, as a share: the floor of a tray, else the top."""
    return {"tray": 0.15, "cloth": 0.6, "shirt": 0.97}.get(kind, 1.0)
