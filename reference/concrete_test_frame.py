"""A concrete test frame of two storeys and two bays, finely meshed: few modes, for its 2,220 dofs.

A laboratory's frame at full scale: columns in twelve elements, floors as grids of slab strips that carry
beams on the lines of the columns. The twelve groups are, of each storey, the outer and the middle columns,
the beams along and across, and the strips of the slab along and across.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from reference.concrete_frames import CONCRETE_KG_PER_M3, Concrete, Skeleton, assembled

#: Height of a storey, lengths of the two bays along and of the one across, m. Unlike one another: no mode is
#: repeated.
STOREY_M, BAYS_M, ACROSS_M = 3.6, (5.5, 6.0), 4.6
COLUMN_M, BEAM_M, SLAB_M = (0.40, 0.40), (0.30, 0.55), 0.16
#: Elements of a column; cells of the slab's grid, each bay along, and across.
COLUMN_PARTS, CELLS, CELLS_ACROSS = 12, (8, 8), 6
#: Mass of a floor beside its strips, kg/m2.
FLOOR_KG_PER_M2 = 150.0


class _TestFrame(Skeleton):
    def __init__(self) -> None:
        super().__init__()
        x, y = _cuts(BAYS_M, CELLS), _cuts((ACROSS_M,), (CELLS_ACROSS,))
        lines = np.cumsum([0, *CELLS])
        self._strip_m = float(y[1]), float(x[1])
        feet = [self.node(np.array([x[i], y[j], 0.0])) for i, j in product(lines, (0, -1))]
        self.held = set(feet)
        floors = []
        for storey in (1, 2):
            grid = [self.node(np.array([a, b, STOREY_M * storey])) for a, b in product(x, y)]
            floor = np.array(grid).reshape(x.size, y.size)
            heads = floor[np.ix_(lines, (0, -1))].ravel()
            for nth, (foot, head) in enumerate(zip(feet, heads, strict=True)):
                kind = "middle" if nth in (2, 3) else "outer"
                self.member(foot, int(head), f"{kind} columns, storey {storey}", COLUMN_PARTS)
            feet = heads.tolist()
            self._floor(floor, lines, storey)
            self.floors.append(grid)
            floors.append(heads)
            share = FLOOR_KG_PER_M2 * float(x[-1] * y[-1]) / len(grid)
            self.extra_kg.update(dict.fromkeys(grid, share))
        self.heads = np.array(floors)

    def _floor(self, floor: np.ndarray, lines: np.ndarray, storey: int) -> None:
        """Strips between all nodes of the grid; beams, in place of them, on the lines of the columns."""
        nx, ny = floor.shape
        for j in range(ny):
            kind = "beams" if j in (0, ny - 1) else "slab"
            for i in range(nx - 1):
                self.member(floor[i, j], floor[i + 1, j], f"{kind} along, storey {storey}", 1)
        for i in range(nx):
            kind = "beams" if i in lines else "slab"
            for j in range(ny - 1):
                self.member(floor[i, j], floor[i, j + 1], f"{kind} across, storey {storey}", 1)

    def size_of(self, group: str) -> tuple[float, float]:
        if "slab" in group:
            return self._strip_m[0 if "along" in group else 1], SLAB_M
        return BEAM_M if "beams" in group else COLUMN_M

    def density(self, group: str) -> float:
        # The slab's mass is that of the strips along: those across are the same concrete.
        return 0.0 if "slab across" in group else CONCRETE_KG_PER_M3


def _cuts(lengths: tuple[float, ...], cells: tuple[int, ...]) -> np.ndarray:
    """Places of the grid's lines, m."""
    steps = [np.full(n, length / n) for length, n in zip(lengths, cells, strict=True)]
    return np.concatenate([[0.0], np.cumsum(np.concatenate(steps))])


def concrete_test_frame() -> Concrete:
    """2,220 dofs, half of them without mass."""
    return assembled(_TestFrame())
