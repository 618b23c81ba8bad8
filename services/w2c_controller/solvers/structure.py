"""Which variables and equalities of a program know of each other.

A robot is a trunk with limbs. What happens in one limb (joints, contact forces, the equality that
keeps its contact in place) meets the other limbs only in the trunk, so that the KKT matrix of the
program is block diagonal but for a border.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
import numpy.typing as npt

Indices = npt.NDArray[np.intp]
Places = npt.NDArray[np.int32]


@dataclass(frozen=True, eq=False)
class Structure:
    """An order of elimination: limb after limb, then the trunk.

    The rows of the KKT matrix are numbered: variable j is row j, equality i is row size + i.
    """

    size: int
    """Number of variables"""
    order: Indices
    """(N,) rows of the KKT matrix in the order of elimination"""
    starts: Indices
    """(limbs + 2,) where each limb, then the trunk, starts in `order`; the last is N"""

    @classmethod
    def of_limbs(cls, size: int, equalities: int, limbs: Sequence[Sequence[int]]) -> "Structure":
        """Return the structure of these limbs, each a list of rows; the others are the trunk.

        In each limb, variables should come before the equalities on them.
        """
        taken = {row for limb in limbs for row in limb}
        # From the last variable to the first: in a tree, from the tips to the base.
        trunk = [row for row in range(size - 1, -1, -1) if row not in taken]
        trunk += [row for row in range(size, size + equalities) if row not in taken]
        blocks = [*limbs, trunk]
        return cls(
            size=size,
            order=np.array([row for block in blocks for row in block], dtype=np.intp),
            starts=np.cumsum([0, *(len(block) for block in blocks)]).astype(np.intp),
        )

    @staticmethod
    @lru_cache(maxsize=256)
    def dense(size: int, equalities: int) -> "Structure":
        """Return the structure in which all may know of all."""
        return Structure.of_limbs(size, equalities, [])

    @cached_property
    def total(self) -> int:
        """N: variables and equalities."""
        return int(self.order.size)

    @cached_property
    def width(self) -> int:
        """Columns of the packed factor: longest limb, trunk, right-hand side."""
        lengths = np.diff(self.starts)
        longest = int(lengths[:-1].max()) if lengths.size > 1 else 0
        return longest + int(lengths[-1]) + 1

    @cached_property
    def place(self) -> Indices:
        """(N,) where each row of the KKT matrix stands in `order`."""
        place = np.empty(self.total, dtype=np.intp)
        place[self.order] = np.arange(self.total)
        return place

    @cached_property
    def sources(self) -> tuple[Places, Places, Places, Places]:
        """Where the entries of the packed factor come from: places in flat arrays.

        Of the factor and of H (upper triangle), entry by entry; of the factor and of A.
        """
        hessian, equalities = [], []
        trunk = int(self.starts[-2])
        for first, end in zip(self.starts[:-1], self.starts[1:], strict=True):
            for row in range(first, end):
                border = range(trunk, self.total) if end <= trunk else range(0)
                for column in (*range(row, end), *border):
                    inside = column < end
                    at = column - first if inside else end - first + column - trunk
                    low, high = sorted((int(self.order[row]), int(self.order[column])))
                    if high < self.size:
                        hessian.append((row * self.width + at, low * self.size + high))
                    elif low < self.size:
                        of_a = (high - self.size) * self.size + low
                        equalities.append((row * self.width + at, of_a))
        first, second = (
            np.array(pairs, dtype=np.int32).reshape(-1, 2).T for pairs in (hessian, equalities)
        )
        return first[0].copy(), first[1].copy(), second[0].copy(), second[1].copy()
