"""A finer mesh of a coarse one: one step of Catmull and Clark's subdivision, as a matrix."""

from collections import defaultdict

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

Quads = NDArray[np.int32]
Edge = tuple[int, int]


def subdivided(quads: Quads, vertices: int) -> tuple[csr_array, Quads]:
    """Compute the matrix (F, V) from V coarse vertices to F fine ones, and the fine quads (4 Q, 4), for quads (Q, 4).

    The fine vertices are the moved coarse ones, then one for each quad, then one for each edge.
    """
    edges = _faces_of_edges(quads)
    face_at = vertices
    edge_at = {edge: vertices + len(quads) + k for k, edge in enumerate(edges)}
    face_rows = [dict.fromkeys(quad, 0.25) for quad in quads.tolist()]
    edge_rows = [_edge_row(edge, [face_rows[face] for face in faces]) for edge, faces in edges.items()]
    rows = [*_vertex_rows(quads, edges, vertices), *face_rows, *edge_rows]
    fine = [
        (corner, edge_at[_edge(corner, after)], face_at + k, edge_at[_edge(before, corner)])
        for k, quad in enumerate(quads.tolist())
        for before, corner, after in zip(quad[-1:] + quad[:-1], quad, quad[1:] + quad[:1], strict=True)
    ]
    return _matrix(rows, vertices), np.array(fine, np.int32)


def _edge(a: int, b: int) -> Edge:
    return (a, b) if a < b else (b, a)


def _faces_of_edges(quads: Quads) -> dict[Edge, list[int]]:
    faces: dict[Edge, list[int]] = defaultdict(list)
    for k, quad in enumerate(quads.tolist()):
        for a, b in zip(quad, quad[1:] + quad[:1], strict=True):
            faces[_edge(a, b)].append(k)
    return faces


def _edge_row(edge: Edge, face_rows: list[dict[int, float]]) -> dict[int, float]:
    """Weight both ends and both faces' middles equally; the ends alone at the rim."""
    row = defaultdict(float, dict.fromkeys(edge, 0.5))
    if len(face_rows) == 2:
        row = defaultdict(float, dict.fromkeys(edge, 0.25))
        for face in face_rows:
            for vertex, weight in face.items():
                row[vertex] += 0.25 * weight
    return row


def _vertex_rows(quads: Quads, edges: dict[Edge, list[int]], vertices: int) -> list[dict[int, float]]:
    neighbours: list[list[int]] = [[] for _ in range(vertices)]
    rims: list[list[int]] = [[] for _ in range(vertices)]
    faces: list[list[int]] = [[] for _ in range(vertices)]
    for (a, b), of_edge in edges.items():
        for one, other in ((a, b), (b, a)):
            neighbours[one].append(other)
            if len(of_edge) == 1:
                rims[one].append(other)
    for k, quad in enumerate(quads.tolist()):
        for vertex in quad:
            faces[vertex].append(k)
    return [
        _rim_row(v, rims[v]) if rims[v] else _inner_row(v, neighbours[v], quads[faces[v]].ravel().tolist())
        for v in range(vertices)
    ]


def _rim_row(vertex: int, rim: list[int]) -> dict[int, float]:
    row = defaultdict(float, {vertex: 0.75})
    for other in rim:
        row[other] += 0.25 / len(rim)
    return row


def _inner_row(vertex: int, neighbours: list[int], corners: list[int]) -> dict[int, float]:
    """Weight (mean of face middles + 2 mean of edge middles + (n - 3) vertex) / n, with n edges at the vertex.

    The mean of face middles is that of all their `corners`. An edge's middle is (vertex + neighbour) / 2, so twice
    their mean is the vertex and 1 / n of each neighbour.
    """
    n = len(neighbours)
    row: dict[int, float] = defaultdict(float)
    for corner in corners:
        row[corner] += 1.0 / (len(corners) * n)
    for other in neighbours:
        row[other] += 1.0 / (n * n)
    row[vertex] += 1.0 / n + (n - 3) / n
    return row


def _matrix(rows: list[dict[int, float]], columns: int) -> csr_array:
    counts = np.cumsum([0, *(len(row) for row in rows)])
    indices = np.array([vertex for row in rows for vertex in row], np.int32)
    weights = np.array([weight for row in rows for weight in row.values()])
    return csr_array((weights, indices, counts), shape=(len(rows), columns))
