"""A ball in contact rolls on its surface: its centre moves where it turns.

The point of a ball of radius r that touches a plane with normal n is at rest; it is at the lever
l = -r n from the centre p. So

    p' + w x l = 0,     (J_p - [l]x J_w) v = 0,     p' = w x (r n):

the centre stays at its height and moves along the plane, and what a contact holds on to moves with
it. A turn about the normal moves nothing: the contact of a ball is a point.
"""

import numpy as np
import numpy.typing as npt

from w2c_controller.compiled import compiled

Vector = npt.NDArray[np.float64]
Matrix = npt.NDArray[np.float64]
Indices = npt.NDArray[np.intp]


@compiled
def roll(
    dt: float,
    velocity: Vector,
    jacobians: Matrix,
    supports: Indices,
    levers: Matrix,
    contacts: Indices,
    places: Matrix,
) -> None:
    """Move the places (4, 3) of hands in contact by -dt w x l.

    Args:
        dt: [s]
        velocity: Begins with v (nv,).
        jacobians: (4, 6, nv) of the centres, linear then angular.
        supports: (4, nv) columns of v that move each end effector, then -1.
        levers: (4, 3) from centre to touching point, in the world [m].
        contacts: (nc, 3) end effector, and what `ContactLayout.table` says of it.
        places: Where the contacts hold the centres, in the world [m].
    """
    for row in range(contacts.shape[0]):
        k = contacts[row, 0]
        if k < 2:
            continue
        a = b = c = 0.0
        for j in supports[k]:
            if j < 0:
                break
            a += jacobians[k, 3, j] * velocity[j]
            b += jacobians[k, 4, j] * velocity[j]
            c += jacobians[k, 5, j] * velocity[j]
        x, y, z = levers[k, 0], levers[k, 1], levers[k, 2]
        places[k, 0] -= dt * (b * z - c * y)
        places[k, 1] -= dt * (c * x - a * z)
        places[k, 2] -= dt * (a * y - b * x)
