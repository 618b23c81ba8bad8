"""Target and robot as marks in the picture and in the world."""

from foxglove_schemas_protobuf.CircleAnnotation_pb2 import CircleAnnotation
from foxglove_schemas_protobuf.ImageAnnotations_pb2 import ImageAnnotations
from foxglove_schemas_protobuf.LinePrimitive_pb2 import LinePrimitive
from foxglove_schemas_protobuf.Point2_pb2 import Point2
from foxglove_schemas_protobuf.Point3_pb2 import Point3
from foxglove_schemas_protobuf.PointsAnnotation_pb2 import PointsAnnotation
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from foxglove_schemas_protobuf.SpherePrimitive_pb2 import SpherePrimitive
from foxglove_schemas_protobuf.TextAnnotation_pb2 import TextAnnotation

from w2c import messages as m
from w2c_recorder.foxglove.protocol import colour, pose_at, timestamp, vector

BLUE, YELLOW, GREY = colour(0.0, 0.3, 1.0), colour(1.0, 0.86, 0.0), colour(0.5, 0.5, 0.55)
DIAMETER_PX = 36.0
BALL_M = 0.04
BONE_M = 0.02


def annotations(target: m.Target, time_ns: int) -> ImageAnnotations:
    """Return target and boxes in the picture."""
    stamp = timestamp(time_ns)
    circle = CircleAnnotation(
        timestamp=stamp,
        position=Point2(x=target.u, y=target.v),
        diameter=DIAMETER_PX,
        thickness=3.0,
        outline_color=BLUE,
    )
    boxes = [
        PointsAnnotation(
            timestamp=stamp,
            type=PointsAnnotation.LINE_LOOP,
            points=[
                Point2(x=u, y=v)
                for u, v in (
                    (box.left, box.top),
                    (box.right, box.top),
                    (box.right, box.bottom),
                    (box.left, box.bottom),
                )
            ],
            outline_color=YELLOW,
            thickness=2.0,
        )
        for box in target.boxes
    ]
    texts = [
        TextAnnotation(
            timestamp=stamp,
            position=Point2(x=box.left, y=box.top),
            text=f"{phrase} {box.score:.2f}",
            font_size=18.0,
            text_color=YELLOW,
        )
        for phrase, box in zip(target.phrases, target.boxes, strict=False)
    ]
    return ImageAnnotations(timestamp=stamp, circles=[circle], points=boxes, texts=texts)


def target_scene(target: m.Target, frame: str, time_ns: int) -> SceneUpdate:
    """Return the target as a ball in the world; a newer one takes its place."""
    ball = SpherePrimitive(
        pose=pose_at(target.point), size=vector((BALL_M, BALL_M, BALL_M)), color=BLUE
    )
    entity = SceneEntity(timestamp=timestamp(time_ns), frame_id=frame, id="target", spheres=[ball])
    return SceneUpdate(entities=[entity])


def robot_scene(bones: m.Array, frame: str, time_ns: int) -> SceneUpdate:
    """Return lines between links; bones (n, 2, 3) from end to end."""
    points = [Point3(x=x, y=y, z=z) for x, y, z in bones.reshape(-1, 3).tolist()]
    lines = LinePrimitive(
        type=LinePrimitive.LINE_LIST,
        pose=pose_at((0.0, 0.0, 0.0)),
        thickness=BONE_M,
        points=points,
        color=GREY,
    )
    entity = SceneEntity(timestamp=timestamp(time_ns), frame_id=frame, id="robot", lines=[lines])
    return SceneUpdate(entities=[entity])
