"""Joint limits, from the model that a robot describes itself with."""

from xml.etree import ElementTree

import numpy as np

from w2c.errors import ConfigError
from w2c.messages import Array, RobotDescription


def joint_limits(description: RobotDescription) -> Array:
    """Return lower and upper limits of the joints of a description (n, 2) [rad].

    Raises:
        ConfigError: the model is no URDF, or a joint has no limits in it.
    """
    try:
        # Expat itself refuses entities that grow without bound.
        root = ElementTree.fromstring(description.urdf)  # noqa: S314
    except ElementTree.ParseError as error:
        raise ConfigError(f"the robot's description holds no URDF: {error}") from error
    found = {}
    for joint in root.findall("joint"):
        limit = joint.find("limit")
        if joint.get("type") in ("revolute", "prismatic") and limit is not None:
            try:
                bounds = float(limit.get("lower", "0")), float(limit.get("upper", "0"))
            except ValueError as error:
                raise ConfigError(f"limits of joint '{joint.get('name')}': {error}") from error
            found[joint.get("name", "")] = bounds
    names = [joint.name for joint in description.joints]
    missing = [name for name in names if name not in found or found[name][0] >= found[name][1]]
    if missing:
        raise ConfigError(
            f"the robot's URDF has no lower and upper limit for: {', '.join(missing)}; "
            "the driver judges commands by them"
        )
    return np.array([found[name] for name in names])
