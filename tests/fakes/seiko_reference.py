"""The reference model and ticks of SEIKO: an external oracle that is not part of the repository."""

import os
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest

from w2c_controller.kinematics.model import ControlledModel

ROOT = Path(__file__).resolve().parents[2]

LEGS, TORSO = 12 * [5000.0], 2 * [10000.0]
LEFT_ARM = [10000.0, 10000.0, 5000.0, 10000.0, 3000.0, 3000.0, 3000.0]
RIGHT_ARM = LEFT_ARM[:4]
"""Joint stiffness that the reference uses [Nm/rad]"""


def reference_file(name: str) -> Path:
    """Return the path of a reference file; skips the test where there is none."""
    folders = [ROOT.parent / "shared" / "reference"]
    if "W2C_REFERENCE" in os.environ:
        folders.insert(0, Path(os.environ["W2C_REFERENCE"]))
    for folder in folders:
        if (folder / name).is_file():
            return folder / name
    pytest.skip(
        f"{name} of the SEIKO reference is not on this machine; set W2C_REFERENCE to its folder"
    )


def reference_model() -> ControlledModel:
    """Return the 25-joint Talos of the reference ticks."""
    tables: Any = np.load(reference_file("seiko_talos_model.npz"))
    model = pin.Model()
    root = model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "root_joint")
    joints = [root]
    names = [str(name) for name in tables["joint_names"]]
    for i, name in enumerate(names):
        parent = joints[tables["parent"][i]]
        axis = pin.JointModelRevoluteUnaligned(tables["axis"][i])
        joints.append(model.addJoint(parent, axis, pin.SE3(tables["placement"][i]), name))
    for body, joint in enumerate(joints):
        inertia = pin.Inertia(
            float(tables["body_mass"][body]), tables["body_com"][body], tables["body_inertia"][body]
        )
        model.appendBodyToJoint(joint, inertia, pin.SE3.Identity())
    frames = []
    for i, name in enumerate(tables["frame_names"]):
        parent = joints[tables["frame_parent"][i]]
        placement = pin.SE3(tables["frame_placement"][i])
        frames.append(
            model.addFrame(pin.Frame(str(name), parent, 0, placement, pin.FrameType.OP_FRAME))
        )
    return ControlledModel(
        model=model,
        frames=(frames[0], frames[1], frames[2], frames[3]),
        hand_radius=(0.0, 0.05),
        stiffness=np.array(LEGS + TORSO + LEFT_ARM + RIGHT_ARM),
        effort=tables["effort_limit"],
        lower=tables["position_lower"],
        upper=tables["position_upper"],
        velocity=tables["velocity_limit"],
        joint_indices=np.arange(25),
        joint_names=tuple(names),
    )
