"""Distances of many places from long lines."""

from typing import Any

import numpy as np
import shapely


def distances(places: Any, line: shapely.LineString | shapely.MultiLineString) -> Any:
    """How far each place, a row of x and y, is from a line.

    By a tree of the line's segments: `shapely.distance` measures from each place to all of them.
    """
    parts = [shapely.get_coordinates(part) for part in shapely.get_parts(line)]
    ends = np.concatenate([np.stack([part[:-1], part[1:]], axis=1) for part in parts])
    tree = shapely.STRtree(shapely.linestrings(ends))
    _, away = tree.query_nearest(shapely.points(places), return_distance=True, all_matches=False)
    return away
