"""Rigid distances over the pool, cell by cell: the data of a picture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..data import Float
from .pool_projection import PoolCamera
from .rigid_distances import RigidDistances

LENGTH_ERROR_MAP_CELLS = (8, 5)


@dataclass(frozen=True)
class LengthErrorMap:
    """Relative error of rigid distances over the pool, for a picture.

    x_edges_m, y_edges_m: cell borders. excess: (rows, columns) mean of measured / known - 1, NaN
    where the robot never was; std: of that mean; count: distances in the cell; model: what the
    named error predicts there.
    """

    x_edges_m: Float
    y_edges_m: Float
    excess: Float
    std: Float
    count: Float
    model: Float


def length_error_map(
    camera: PoolCamera, distances: RigidDistances, predicted: Float
) -> LengthErrorMap:
    """Relative excess of the distances over the pool beside what a named error predicts (n,)."""
    length, width = camera.pool_size_m
    x_edges = np.linspace(0, length, LENGTH_ERROR_MAP_CELLS[0] + 1)
    y_edges = np.linspace(0, width, LENGTH_ERROR_MAP_CELLS[1] + 1)
    x, y = distances.centers_m.T
    weight = (distances.known_m / distances.std_m) ** 2

    def sum_by_cell(values: Float) -> Float:
        grid, _, _ = np.histogram2d(x, y, bins=[x_edges, y_edges], weights=values)
        return np.asarray(grid.T, dtype=np.float64)

    total = sum_by_cell(weight)
    with np.errstate(invalid="ignore", divide="ignore"):
        return LengthErrorMap(
            x_edges_m=x_edges,
            y_edges_m=y_edges,
            excess=sum_by_cell(weight * distances.excess_m / distances.known_m) / total,
            std=1 / np.sqrt(total),
            count=sum_by_cell(np.ones_like(weight)),
            model=sum_by_cell(weight * predicted / distances.known_m) / total,
        )
