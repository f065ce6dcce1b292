"""Meshes in scene lengths: vertices, facets and normals, made once per mesh of a plan."""

from __future__ import annotations

import numpy as np

from transport.compile import layout
from transport.compile.plan import MeshTable, Plan
from transport.geometry.mesh import Mesh


def mesh_table(plan: Plan, mesh: Mesh) -> MeshTable:
    """Return the table of a mesh, made at the first call."""
    if mesh not in plan.meshes:
        vertices = (mesh.vertices - np.array(plan.space.origin)) / plan.space.size
        center = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
        plan.meshes[mesh] = MeshTable(vertices, mesh.faces.astype(np.int32), mesh.normals, mesh.areas, center)
    return plan.meshes[mesh]


def mesh_row(plan: Plan, mesh: Mesh) -> np.ndarray:
    """Return a row by which rays are intersected with the mesh."""
    table = mesh_table(plan, mesh)
    return _register_row(table, layout.row(layout.MESH, **layout.center_columns(tuple(table.center))))


def areas_row(plan: Plan, mesh: Mesh, side: float) -> np.ndarray:
    """Return a row by which places on the mesh are sampled."""
    return _register_row(mesh_table(plan, mesh), layout.row(layout.FACET_AREAS, side=side))


def _register_row(table: MeshTable, row: np.ndarray) -> np.ndarray:
    table.rows.append(row)
    return row
