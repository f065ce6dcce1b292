"""Refuse mesh faces that coincide with other shapes: rounding would decide which is hit first.

Other shapes on one plane share a sheet (sheets.py); a mesh is a sheet by itself. A mesh that stands on a
floor, a detector or source on one of its faces, and two meshes with a common face are therefore refused, with
the gap that cures it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from transport.geometry.mesh import Mesh
from transport.geometry.neighbours import touching_boxes
from transport.geometry.relations import rounding_tolerance
from transport.geometry.shape import ROUNDING, Shape
from transport.scene.parts import surface_name
from transport.validation import SceneError

if TYPE_CHECKING:
    from transport.scene.parts import SceneParts

COPLANAR_SIN2 = 1e-12  # squared sine of the angle between planes that may coincide
MAX_PAIRS = 200_000  # most pairs of facets compared between two meshes
GAP = 1e-9  # suggested gap, relative to the size of both shapes


def check_coplanar_meshes(scene: SceneParts) -> None:
    """Raise SceneError if a face of a mesh coincides with another shape of the scene."""
    users = list(_named_shapes(scene))
    if not any(shape.triangles for _, shape in users):
        return
    low, high = np.array([shape.bounds for _, shape in users]).transpose(1, 0, 2)
    gap = 64 * ROUNDING * max(shape.coordinate_scale for _, shape in users)
    seen = set()
    for (title, mesh), near in zip(users, touching_boxes(low - gap, high), strict=True):
        for other_title, other in [users[k] for k in near.tolist()] if mesh.triangles else ():
            if other == mesh or frozenset((mesh, other)) in seen:
                continue
            seen.add(frozenset((mesh, other)))
            parts = [part for piece in other.pieces() for part in piece.primitives()]
            if any(_is_coplanar(mesh, part) for part in parts):
                gap = GAP * (mesh.extent + (0.0 if other.is_infinite else other.extent))
                cure = f"leave a gap such as {gap:.0e} m between them, or make them one Mesh"
                raise SceneError(
                    f"Scene: a face of {title}, a Mesh, lies on {other_title}, a {type(other).__name__}:"
                    f" rounding would decide which is hit first; {cure}; detectors and sources on the mesh"
                    " itself take its surface's name as shape"
                )


def _named_shapes(scene: SceneParts) -> Iterator[tuple[str, Shape]]:
    """Shapes that rays hit or start on, with their names."""
    for number, surface in enumerate(scene.surfaces):
        yield surface_name(scene, number), surface.shape
    for number, source in enumerate(scene.sources):
        if isinstance(source.shape, Shape) and source.emission.has_side:
            yield f"sources[{number}]", source.shape
    for detector in scene.meters:
        if isinstance(detector.shape, Shape):
            yield f"Detector {detector.name!r}", detector.shape


def _is_coplanar(mesh: Mesh, other: Shape) -> bool:
    """Return whether a facet has more than an edge in common with a flat piece or another mesh."""
    if other.triangles:
        return _are_coplanar(mesh, other)
    if not other.is_flat:
        return False
    tolerance = rounding_tolerance(mesh, other) if not other.is_infinite else rounding_tolerance(mesh, mesh)
    (e_u, e_v, normal), center = np.array(other.frame), np.array(other.center)
    heights = np.abs((mesh.vertices - center) @ normal)
    faces = mesh.faces[(heights[mesh.faces] <= tolerance).all(axis=1)]
    if len(faces) == 0 or other.is_infinite:
        return len(faces) > 0
    places = (mesh.vertices[faces] - center) @ np.array([e_u, e_v]).T
    if not other.corners:
        return bool((_distance_from_origin(places) < other.radius - tolerance).any())
    return bool(_overlap(places, np.array(other.corners), tolerance).any())


def _overlap(facets: np.ndarray, polygon: np.ndarray, tolerance: float) -> np.ndarray:
    """Return which triangles (k, 3, 2) overlap a convex polygon (n, 2): no edge separates them."""
    meet = np.ones(len(facets), bool)
    for edge in np.roll(polygon, -1, axis=0) - polygon:
        meet &= _projections_overlap(
            facets @ _edge_normals(edge)[:, None], polygon @ _edge_normals(edge), tolerance
        )
    for corner in range(3):
        axes = _edge_normals(facets[:, (corner + 1) % 3] - facets[:, corner])
        meet &= _projections_overlap(
            np.einsum("kij,kj->ki", facets, axes)[..., None], axes @ polygon.T, tolerance
        )
    return meet


def _projections_overlap(ones: np.ndarray, others: np.ndarray, tolerance: float) -> np.ndarray:
    """Return whether projections of triangles (k, 3, 1) and a polygon (n,) or (k, n) on an axis overlap."""
    ones = ones[..., 0]
    low, high = others.min(axis=-1), others.max(axis=-1)
    return (ones.min(axis=1) < high - tolerance) & (ones.max(axis=1) > low + tolerance)


def _edge_normals(edges: np.ndarray) -> np.ndarray:
    """Unit vectors perpendicular to edges."""
    turned = np.stack([-edges[..., 1], edges[..., 0]], axis=-1)
    return turned / np.linalg.norm(turned, axis=-1, keepdims=True)


def _distance_from_origin(facets: np.ndarray) -> np.ndarray:
    """Distance of triangles (k, 3, 2) from the origin of the plane; 0 if they contain it."""
    ends = np.roll(facets, -1, axis=1)
    offsets = ends - facets
    share = np.clip(-(facets * offsets).sum(axis=2) / (offsets * offsets).sum(axis=2), 0, 1)
    nearest = np.linalg.norm(facets + share[..., None] * offsets, axis=2).min(axis=1)
    turns = facets[..., 0] * ends[..., 1] - facets[..., 1] * ends[..., 0]
    return np.where((turns > 0).all(axis=1) | (turns < 0).all(axis=1), 0.0, nearest)


def _are_coplanar(one: Mesh, other: Mesh) -> bool:
    """Return whether facets of two meshes lie on one plane and overlap."""
    from scipy.spatial import cKDTree

    # Keep the facets within both bounding boxes.
    tolerance = rounding_tolerance(one, other)
    low, high = (np.array([mesh.bounds[end] for mesh in (one, other)]) for end in (0, 1))
    low, high = low.max(axis=0) - tolerance, high.min(axis=0) + tolerance
    near = [_facets_within(mesh, low, high) for mesh in (one, other)]
    if (low > high).any() or not all(map(len, near)):
        return False
    # Compare only facets on nearly the same plane.
    size = one.extent + other.extent
    planes = [
        _plane_coordinates(mesh, facets, size, np.array(one.middle))
        for mesh, facets in zip((one, other), near, strict=True)
    ]
    pairs = cKDTree(planes[0]).query_ball_tree(
        cKDTree(planes[1]), math.sqrt(COPLANAR_SIN2) + 2 * tolerance / size
    )
    looked_at = 0
    for number, matches in zip(near[0], pairs, strict=True):
        if matches:
            looked_at += len(matches)
            corners = one.vertices[one.faces[number]]
            if _overlaps_facets(corners, one.normals[number], other, near[1][matches], tolerance):
                return True
        if looked_at > MAX_PAIRS:
            break
    return False


def _overlaps_facets(
    corners: np.ndarray, normal: np.ndarray, other: Mesh, facets: np.ndarray, tolerance: float
) -> bool:
    """Return whether a triangle overlaps one of the coplanar facets of another mesh."""
    along = corners[1] - corners[0]
    e_u = along / np.linalg.norm(along)
    frame = np.array([e_u, np.cross(normal, e_u)]).T
    others = other.vertices[other.faces[facets]] - corners[0]
    flat = (np.abs(others @ normal) <= tolerance).all(axis=1)
    return bool(_overlap(others[flat] @ frame, (corners - corners[0]) @ frame, tolerance).any())


def _facets_within(mesh: Mesh, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Indices of the facets that reach into a box."""
    corners = mesh.vertices[mesh.faces]
    return np.flatnonzero(((corners.max(axis=1) >= low) & (corners.min(axis=1) <= high)).all(axis=1))


def _plane_coordinates(mesh: Mesh, facets: np.ndarray, size: float, origin: np.ndarray) -> np.ndarray:
    """Normals, independent of their sign, and distances from the origin relative to `size`: (k, 4)."""
    normals = mesh.normals[facets]
    lead = np.take_along_axis(normals, np.abs(normals).argmax(axis=1)[:, None], axis=1)
    normals = normals * np.sign(lead)
    places = mesh.vertices[mesh.faces[facets, 0]] - origin
    return np.concatenate([normals, (places * normals).sum(axis=1, keepdims=True) / size], axis=1)
