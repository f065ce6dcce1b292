"""Meshes in scene lengths: vertices, facets and normals, made once per mesh of a plan."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from transport.compile import layout
from transport.shapes import Mesh

if TYPE_CHECKING:
    from transport.compile.plan import Plan


@dataclass
class MeshTable:
    """A mesh as arrays; the engine sorts its facets, and adds a hierarchy and cumulative areas."""

    vertices: np.ndarray  # (n, 3) [scene lengths]
    faces: np.ndarray  # (m, 3) int32
    normals: np.ndarray  # (m, 3)
    areas: np.ndarray  # (m,) [m^2]
    center: np.ndarray  # of its bounds
    rows: list[np.ndarray] = field(default_factory=list)  # rows that point to these arrays
    nodes: np.ndarray | None = None
    shares: np.ndarray | None = None

    def point(self) -> None:
        """Write the addresses and lengths of the arrays into the rows."""
        for row in self.rows:
            for name in ("vertices", "faces", "normals", "nodes", "shares"):
                if name in row.dtype.names and getattr(self, name) is not None:
                    row[name] = getattr(self, name).ctypes.data
            counts = {"vertex_count": self.vertices, "facet_count": self.faces, "node_count": self.nodes}
            for name, counted in counts.items():
                if name in row.dtype.names and counted is not None:
                    row[name] = len(counted)


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
    return _pointing(table, layout.row(layout.MESH, **layout.center_columns(tuple(table.center))))


def areas_row(plan: Plan, mesh: Mesh, side: float) -> np.ndarray:
    """Return a row by which places on the mesh are sampled."""
    return _pointing(mesh_table(plan, mesh), layout.row(layout.AREAS, side=side))


def _pointing(table: MeshTable, row: np.ndarray) -> np.ndarray:
    table.rows.append(row)
    return row
