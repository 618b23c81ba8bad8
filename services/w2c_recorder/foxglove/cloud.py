"""What the camera's depth shows, as points."""

import numpy as np
from foxglove_schemas_protobuf.PackedElementField_pb2 import PackedElementField
from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud

from w2c.depth import decode_depth
from w2c.messages import CameraFrame
from w2c_recorder.foxglove.protocol import pose_at, timestamp

STEP_PX = 12
"""Between points: the whole depth is in the raw channel, this is to be looked at"""


def cloud_of(frame: CameraFrame, time_ns: int) -> PointCloud | None:
    """Return points in the camera's frame [m]; None where there is no depth.

    Raises:
        MessageError: the depth cannot be unpacked.
    """
    if not frame.depth:
        return None
    depth = decode_depth(frame.depth, frame.width, frame.height, frame.depth_unit)
    first = STEP_PX // 2
    z = depth[first::STEP_PX, first::STEP_PX]
    rows, columns = np.nonzero(z)
    z = z[rows, columns]
    fx, fy, cx, cy = frame.intrinsics
    # The centre of pixel (0, 0) is at (0.5, 0.5).
    u, v = first + STEP_PX * columns + 0.5, first + STEP_PX * rows + 0.5
    points = np.stack([(u - cx) / fx * z, (v - cy) / fy * z, z], axis=1).astype("<f4")
    fields = [
        PackedElementField(name=name, offset=4 * index, type=PackedElementField.FLOAT32)
        for index, name in enumerate("xyz")
    ]
    return PointCloud(
        timestamp=timestamp(time_ns),
        frame_id=frame.frame,
        pose=pose_at((0.0, 0.0, 0.0)),
        point_stride=12,
        fields=fields,
        data=points.tobytes(),
    )
