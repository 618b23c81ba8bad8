"""What perception answers about the pictures that it remembers. Thread-safe."""

from w2c.bus import CallContext
from w2c.errors import MessageError, RefusedError
from w2c.messages import (
    AllowedArea,
    AllowedAreaRequest,
    HeightField,
    HeightFieldRequest,
    LiftReply,
    LiftRequest,
    PointCloud,
    PointCloudRequest,
)
from w2c.messages.cloud import MAX_POINTS
from w2c_perception.allowed import CELL, REASONS, UNSEEN, allowed_cells
from w2c_perception.carrying import verdicts
from w2c_perception.cloud import Box, decode_colours, point_cloud
from w2c_perception.config import PerceptionConfig
from w2c_perception.heights import Area, height_field
from w2c_perception.lift import check_pixel, lift
from w2c_perception.memory import PictureMemory
from w2c_perception.registration import Match, find_in_depth, to_colours

TOLD = 0.005
"""What depth could not see before a point is told an operator from this length on [m]"""


class Answers:
    """Handlers of the calls. All raise RefusedError, for pictures that are not remembered too."""

    def __init__(self, config: PerceptionConfig, memory: PictureMemory) -> None:
        self._config = config
        self._memory = memory

    def lift(self, request: LiftRequest, _context: CallContext | None = None) -> LiftReply:
        """Answer what is behind a pixel."""
        view, depth = self._memory.look(request.frame_stamp_ns, request.robot_boot_id)
        check_pixel(depth, request.u, request.v)
        match = Match(request.u, request.v, 0.0)
        if view.depth_from_colours is not None:
            match = find_in_depth(
                depth, view.intrinsics, view.depth_from_colours, request.u, request.v
            )
        surface = lift(
            depth,
            view.intrinsics,
            view.depth_pose.world_from_camera,
            match.u,
            match.v,
            footprint=request.footprint,
            depth_unit=view.depth_unit,
            blur=view.blur(depth, match.u, match.v, self._config.depth_lag),
        )
        pose_error = view.pose_error(surface.point, self._config.joint_error)
        error_bound = surface.error_bound + pose_error + match.hidden
        return LiftReply(
            point=surface.point,
            normal=surface.normal,
            error_bound=error_bound,
            flatness=surface.flatness,
            slope=surface.slope,
            extent=surface.extent,
            edge_distance=surface.edge_distance,
            frame_stamp_ns=view.stamp_ns,
            warning="; ".join(filter(None, [surface.warning, _hidden(match)])),
            verdicts=verdicts(surface, error_bound, request.footprint),
        )

    def heights(
        self, request: HeightFieldRequest, _context: CallContext | None = None
    ) -> HeightField:
        """Answer how high things stand in a picture."""
        view, depth = self._memory.look(request.frame_stamp_ns, request.robot_boot_id)
        area = Area()
        pose = view.depth_pose
        heights = height_field(depth, view.intrinsics, pose.world_from_camera, pose.arms, area)
        return HeightField(
            stamp_ns=view.stamp_ns,
            origin=(area.x[0], area.y[0]),
            cell=area.cell,
            heights=heights,
        )

    def allowed(
        self, request: AllowedAreaRequest, _context: CallContext | None = None
    ) -> AllowedArea:
        """Answer where in a picture a surface can carry a hand."""
        view, depth = self._memory.look(request.frame_stamp_ns, request.robot_boot_id)
        pose = view.depth_pose
        cells = allowed_cells(depth, view.intrinsics, pose.world_from_camera, pose.arms)
        if view.depth_from_colours is not None:
            moved = view.depth_from_colours
            cells = to_colours(cells, depth, view.intrinsics, moved, CELL, UNSEEN)
        return AllowedArea(
            stamp_ns=view.stamp_ns,
            width=view.width,
            height=view.height,
            cells=cells,
            reasons=list(REASONS),
        )

    def cloud(self, request: PointCloudRequest, _context: CallContext | None = None) -> PointCloud:
        """Answer what stands in a box."""
        view, depth = self._memory.look(request.frame_stamp_ns, request.robot_boot_id)
        try:
            colours = decode_colours(view.frame.jpeg, view.width, view.height)
        except MessageError as error:
            raise RefusedError(
                f"the picture of {view.stamp_ns} ns has no usable colours: {error}"
            ) from error
        cloud = point_cloud(
            depth,
            colours,
            view.intrinsics,
            view.depth_pose.world_from_camera,
            Box(request.low, request.high),
            voxel=request.voxel,
            most=MAX_POINTS,
            depth_from_colours=view.depth_from_colours,
        )
        return PointCloud(
            stamp_ns=view.stamp_ns,
            voxel=request.voxel,
            points=cloud.points,
            colours=cloud.colours,
        )


def _hidden(match: Match) -> str:
    """Return what an operator should know of depth that was taken from elsewhere, or nothing."""
    if match.hidden < TOLD:
        return ""
    return f"depth, of another instant, did not see {100.0 * match.hidden:.0f} cm before the point"
