"""Coloured points as a PLY file, binary and little-endian: what every viewer of points reads."""

import numpy as np
import numpy.typing as npt

_VERTEX = np.dtype(
    [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("red", "u1"), ("green", "u1"), ("blue", "u1")]
)
_TYPES = {"f": "float", "u": "uchar"}


def encode_ply(
    points: npt.NDArray[np.float32], colours: npt.NDArray[np.uint8], comment: str = ""
) -> bytes:
    """Return the bytes of a PLY file.

    Args:
        points: (n, 3) [m].
        colours: (n, 3) red, green, blue.
        comment: one line that the file carries; line breaks become blanks.

    Raises:
        ValueError: other shapes.
    """
    if points.ndim != 2 or points.shape[1] != 3 or colours.shape != points.shape:
        raise ValueError(
            f"points {points.shape} and colours {colours.shape}, expected (n, 3) and the same"
        )
    vertices = np.zeros(len(points), _VERTEX)
    for column, name in enumerate(("x", "y", "z")):
        vertices[name] = points[:, column]
    for column, name in enumerate(("red", "green", "blue")):
        vertices[name] = colours[:, column]
    properties = [f"property {_TYPES[_VERTEX[name].kind]} {name}" for name in _VERTEX.names or ()]
    words = " ".join(comment.split()).encode("ascii", "replace").decode()
    header = [
        "ply",
        "format binary_little_endian 1.0",
        *([f"comment {words}"] if words else []),
        f"element vertex {len(points)}",
        *properties,
        "end_header",
    ]
    return ("\n".join(header) + "\n").encode("ascii") + vertices.tobytes()
