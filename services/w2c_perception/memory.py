"""The pictures of one robot since it started, with their depth, for whoever asks."""

import threading

from w2c.errors import MessageError, RefusedError
from w2c_perception.buffer import View, ViewBuffer
from w2c_perception.depths import DepthMemory
from w2c_perception.window import DepthPicture


class PictureMemory:
    """Views by their stamp. Thread-safe."""

    def __init__(self, history_s: float, max_frames: int, unpacked: int) -> None:
        """Prepare.

        Args:
            history_s: how long a picture is remembered, robot time [s].
            max_frames: pictures at most.
            unpacked: of which so many have their depth ready.
        """
        # Held for microseconds: by the loop that remembers, by the handlers that look.
        self._lock = threading.Lock()
        self._views = ViewBuffer(history_s, max_frames)
        self._depths = DepthMemory(unpacked)
        self._boot_id = ""

    def add(self, view: View) -> None:
        """Remember a view."""
        with self._lock:
            self._views.add(view)

    def forget(self, boot_id: str) -> None:
        """Begin with the pictures of a robot that started, or that stands elsewhere now.

        Args:
            boot_id: of its process; "" = not known yet.
        """
        with self._lock:
            self._views.clear()
            self._boot_id = boot_id
        self._depths.clear()

    def look(self, stamp_ns: int, robot_boot_id: str = "") -> tuple[View, DepthPicture]:
        """Return the view of a stamp with its depth (h, w) [m].

        Args:
            stamp_ns: of the picture [ns].
            robot_boot_id: of the robot in it; "" = not checked.

        Raises:
            RefusedError: it is not remembered, of a robot that is no more, or without depth.
        """
        with self._lock:
            if robot_boot_id and robot_boot_id != self._boot_id:
                raise RefusedError(
                    f"the picture is one of robot process '{robot_boot_id}', those in memory are "
                    f"of '{self._boot_id or 'none yet'}': the robot started anew. Choose the pixel "
                    "in a newer picture"
                )
            view = self._views.get(stamp_ns)
        try:
            return view, self._depths.of(view)
        except MessageError as error:
            raise RefusedError(
                f"the picture of {view.stamp_ns} ns has no usable depth: {error}"
            ) from error
