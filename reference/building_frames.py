"""A concrete building of five storeys: dense in modes, for its 2,130 dofs.

Columns and beams, each in two elements, the floors' mass on their nodes. The twelve groups are columns at
corners, edges and inside, and beams, of the lower, middle and upper storeys.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from reference.concrete_frames import Concrete, Skeleton, assembled

#: Mass of a floor beside its beams, kg/m2.
FLOOR_KG_PER_M2 = 350.0
STOREY_M, BAY_M = 3.2, 5.5
COLUMN_M, BEAM_M = (0.4, 0.4), (0.3, 0.5)


class _Building(Skeleton):
    def __init__(self, bays: tuple[int, int], storeys: int) -> None:
        super().__init__()
        nx, ny = bays[0] + 1, bays[1] + 1
        # Bays of unlike lengths, so that no mode is repeated.
        x = BAY_M * np.concatenate([[0.0], np.cumsum(1.0 + 0.07 * np.arange(bays[0]))])
        y = 0.9 * BAY_M * np.concatenate([[0.0], np.cumsum(1.0 + 0.11 * np.arange(bays[1]))])
        places = product(range(storeys + 1), range(nx), range(ny))
        own = [self.node(np.array([x[i], y[j], STOREY_M * s])) for s, i, j in places]
        joints = np.array(own).reshape(storeys + 1, nx, ny)
        self.held = set(joints[0].ravel().tolist())
        self.heads = joints[1:].reshape(storeys, -1)
        for s in range(1, storeys + 1):
            part = ("lower", "middle", "upper")[3 * (s - 1) // storeys]
            for i, j in product(range(nx), range(ny)):
                edges = (i in (0, nx - 1)) + (j in (0, ny - 1))
                kind = ("inside", "edge", "corner")[edges]
                self.member(joints[s - 1, i, j], joints[s, i, j], f"{kind} columns, {part}", 2)
            floor = joints[s]
            pairs = [*zip(floor[:-1].ravel(), floor[1:].ravel(), strict=True)]
            pairs += zip(floor[:, :-1].ravel(), floor[:, 1:].ravel(), strict=True)
            middles = [self.member(first, second, f"beams, {part}", 2)[0] for first, second in pairs]
            self.floors.append([*map(int, floor.ravel()), *middles])
        for nodes in self.floors:
            share = FLOOR_KG_PER_M2 * float(x[-1] * y[-1]) / len(nodes)
            self.extra_kg.update(dict.fromkeys(nodes, share))

    def size_of(self, group: str) -> tuple[float, float]:
        return BEAM_M if "beams" in group else COLUMN_M


def building(bays: tuple[int, int] = (4, 3), storeys: int = 5) -> Concrete:
    """By default 2,130 dofs, half of them without mass."""
    return assembled(_Building(bays, storeys))
