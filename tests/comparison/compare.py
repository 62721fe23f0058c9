"""Compares parameterizations: pelage, xatlas, and libigl's LSCM. Prints CSV; see README.md."""

import argparse
import csv
import heapq
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import igl
import numpy as np
import xatlas

from measures import measure
from meshes import Gltf, load, local_matrix

STATIC = ["bunny", "spot", "armadillo", "cat-low-resolution", "penguin", "goathead", "stanford-bunny-full"]
SKINNED = ["Fox", "Alpaca", "Cow", "Horse", "ShibaInu", "Velociraptor", "Wolf"]
PELAGE = {"pelage patches": [], "pelage patches, no comb": ["surface.comb=none"]}
COLUMNS = [
    "mesh", "triangles", "method", "seconds", "charts", "angle_distortion", "area_distortion", "stretch_l2",
    "flipped_triangles", "seam_length_ratio", "comb_misalignment_deg",
]  # fmt: skip


def by_xatlas(vertices, triangles):
    """Returns corner coordinates of an atlas with default settings, and seconds, which include packing."""
    atlas = xatlas.Atlas()
    atlas.add_mesh(vertices.astype(np.float32), triangles.astype(np.uint32))
    begun = time.perf_counter()
    atlas.generate()
    seconds = time.perf_counter() - begun
    mapping, indices, uvs = atlas[0]
    assert (mapping[indices] == triangles).all(), "xatlas changed the triangles"
    # Coordinates are fractions of a texture, which need not be square.
    uvs = uvs * np.array([atlas.width, atlas.height])
    return uvs[indices].astype(np.float64), seconds


def components(triangles, joined):
    """Returns the region index of each triangle. `joined(f, k, g, j)`: whether edge k of f continues in edge j of g."""
    sides, neighbours = {}, [[] for _ in triangles]
    for f, triangle in enumerate(triangles.tolist()):
        for k in range(3):
            a, b = triangle[k], triangle[(k + 1) % 3]
            for g, j in sides.get((b, a), []):
                if joined(f, k, g, j):
                    neighbours[f].append(g)
                    neighbours[g].append(f)
            sides.setdefault((a, b), []).append((f, k))
    region = np.full(len(triangles), -1)
    count = 0
    for first in range(len(triangles)):
        if region[first] >= 0:
            continue
        stack, region[first] = [first], count
        while stack:
            for g in neighbours[stack.pop()]:
                if region[g] < 0:
                    region[g] = count
                    stack.append(g)
        count += 1
    return region


def lscm(vertices, triangles):
    """Returns coordinates per vertex of a mesh with a boundary; pins two distant boundary vertices."""
    boundary = np.asarray(igl.boundary_loop(triangles))
    rim = vertices[boundary]
    # The farthest vertex from the farthest vertex: nearly the diameter, in linear time.
    a = int(np.linalg.norm(rim - rim[0], axis=1).argmax())
    b = int(np.linalg.norm(rim - rim[a], axis=1).argmax())
    length = np.linalg.norm(rim[a] - rim[b])
    pins, places = np.array([boundary[a], boundary[b]], np.int64), np.array([[0.0, 0.0], [length, 0.0]])
    return np.asarray(igl.lscm(vertices, triangles, pins, places)[0])


def lscm_on_charts(vertices, triangles, chart_uvs):
    """Computes LSCM on each chart of an atlas, scaled to the chart's area on the skin."""
    begun = time.perf_counter()
    same = lambda f, k, g, j: np.array_equal(chart_uvs[f, k], chart_uvs[g, (j + 1) % 3]) and np.array_equal(
        chart_uvs[f, (k + 1) % 3], chart_uvs[g, j]
    )
    region = components(triangles, same)
    out = np.zeros((len(triangles), 3, 2))
    for chart in range(region.max() + 1):
        faces = np.flatnonzero(region == chart)
        # Corners at the same position in the atlas are one vertex.
        keys = np.concatenate([triangles[faces].reshape(-1, 1), chart_uvs[faces].reshape(-1, 2)], axis=1)
        _, first, index = np.unique(keys, axis=0, return_index=True, return_inverse=True)
        local = index.reshape(-1, 3).astype(np.int64)
        points = vertices[triangles[faces].reshape(-1)[first]]
        out[faces] = fitted(points, local, lscm(points, local) if len(faces) > 1 else flat(points, local))
    return out, time.perf_counter() - begun


def flat(points, triangles):
    a, b, c = points[triangles[0]]
    x = (b - a) / max(np.linalg.norm(b - a), 1e-30)
    along = float((c - a) @ x)
    out = np.zeros((len(points), 2))
    out[triangles[0]] = [[0, 0], [np.linalg.norm(b - a), 0], [along, np.linalg.norm(c - a - x * along)]]
    return out


def fitted(points, triangles, uvs):
    """Returns corner coordinates, scaled to the total area of the triangles on the skin."""
    p, q = points[triangles], uvs[triangles]
    skin = np.linalg.norm(np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), axis=1).sum()
    d1, d2 = q[:, 1] - q[:, 0], q[:, 2] - q[:, 0]
    texture = np.abs(d1[:, 0] * d2[:, 1] - d1[:, 1] * d2[:, 0]).sum()
    return q * np.sqrt(skin / max(texture, 1e-300))


def lscm_with_one_cut(vertices, triangles):
    """Computes LSCM on each component as one chart.

    A sphere is cut along the shortest path of edges between two distant vertices. Components of another genus, or with
    several boundaries, are cut to a disc by igl.cut_to_disk.
    """
    begun = time.perf_counter()
    region = components(triangles, lambda *_: True)
    out = np.zeros((len(triangles), 3, 2))
    for component in range(region.max() + 1):
        faces = np.flatnonzero(region == component)
        used, local = np.unique(triangles[faces], return_inverse=True)
        points, local = vertices[used], local.reshape(-1, 3).astype(np.int64)
        edges = {tuple(sorted((t[k], t[(k + 1) % 3]))) for t in local.tolist() for k in range(3)}
        euler = len(points) - len(edges) + len(local)
        closed = 2 * len(edges) == 3 * len(local)
        if len(local) == 1:
            out[faces] = fitted(points, local, flat(points, local))
            continue
        if closed and euler == 2:
            cuts = [far_path(points, edges)]
        elif not closed and euler == 1:
            cuts = []
        else:
            cuts = igl.cut_to_disk(local)
        cut_edges = {frozenset(pair) for cut in cuts for pair in zip(cut, cut[1:])}
        flags = np.array([[frozenset((t[k], t[(k + 1) % 3])) in cut_edges for k in range(3)] for t in local.tolist()])
        open_points, open_faces = points, local
        if cut_edges:
            open_points, open_faces = igl.cut_mesh(points, local, flags)[:2]
        out[faces] = fitted(open_points, open_faces, lscm(open_points, open_faces))
    return out, time.perf_counter() - begun


def far_path(points, edges):
    """Returns the vertices along the shortest path between two distant vertices."""
    neighbours = [[] for _ in points]
    for a, b in edges:
        length = float(np.linalg.norm(points[a] - points[b]))
        neighbours[a].append((b, length))
        neighbours[b].append((a, length))

    def sweep(start):
        distance, before = {start: 0.0}, {}
        heap = [(0.0, start)]
        while heap:
            d, v = heapq.heappop(heap)
            if d > distance[v]:
                continue
            for w, length in neighbours[v]:
                if d + length < distance.get(w, np.inf):
                    distance[w], before[w] = d + length, v
                    heapq.heappush(heap, (d + length, w))
        return max(distance, key=distance.get), before

    start, _ = sweep(0)
    end, before = sweep(start)
    path = [end]
    while path[-1] != start:
        path.append(before[path[-1]])
    return path


def by_pelage(binary, path, sets):
    """Returns the measures that pelage reports, checked against those of measures.py on its tile coordinates."""
    with tempfile.TemporaryDirectory() as folder:
        package, unpacked = f"{folder}/a.pelage", f"{folder}/a"
        small = ["--set", "slice.tile_texels=16", "--set", "slice.layers=4", "--set", "hair.density=20"]
        command = [binary, "bake", str(path), "-o", package, "--json", "--quiet", *small]
        command += [x for s in sets for x in ("--set", s)]
        report = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
        subprocess.run([binary, "unpack", package, unpacked, "--quiet"], check=True, stdout=subprocess.DEVNULL)
        mesh = Gltf(f"{unpacked}/mesh.glb")
        points, triangles, uvs = posed(mesh, path)
    vertices, index = np.unique(points, axis=0, return_inverse=True)
    again = measure(vertices, index.reshape(-1)[triangles], uvs[triangles].astype(np.float64), periodic=True)
    out = {key: report[key] for key in COLUMNS[5:] if report[key] is not None}
    out["seconds"] = next(stage["seconds"] for stage in report["stages"] if stage["name"] == "surface")
    out["charts"] = report["patches"]
    for key in COLUMNS[4:10]:
        if not np.isclose(again[key], out[key], rtol=2e-3, atol=2e-5):
            print(f"{path.stem}: {key} is {out[key]} by pelage, {again[key]} by this script", file=sys.stderr)
    return out, len(triangles)


def posed(mesh, path):
    """Returns rest positions, triangles and tile coordinates of an unpacked package."""
    primitives = [p for m in mesh.json["meshes"] for p in m["primitives"]]
    attributes = primitives[0]["attributes"]
    triangles = np.concatenate([mesh.accessor(p["indices"])[:, 0].astype(np.int64).reshape(-1, 3) for p in primitives])
    points = mesh.accessor(attributes["POSITION"]).astype(np.float64)
    if "JOINTS_0" in attributes:
        matrices = joint_matrices(Path(mesh.folder) / "animation.json")
        joints, weights = mesh.accessor(attributes["JOINTS_0"]), mesh.accessor(attributes["WEIGHTS_0"])
        blended = (matrices[joints] * weights[:, :, None, None]).sum(1)
        points = np.einsum("nij,nj->ni", blended, np.c_[points, np.ones(len(points))])[:, :3]
        # Copies of a vertex have the same pose up to rounding.
        _, first, index = np.unique(
            mesh.accessor(attributes["POSITION"]), axis=0, return_index=True, return_inverse=True
        )
        points = points[first][index.reshape(-1)]
    return points, triangles, mesh.accessor(attributes["_TILE_UV"])


def joint_matrices(path):
    animation = json.loads(path.read_text())
    world = []
    for node in animation["nodes"]:
        parent = node["parent"]
        local = local_matrix(node)
        world.append(local if parent is None else world[parent] @ local)
    binds = [np.array(j["inverse_bind"], np.float64).reshape(4, 4).T for j in animation["joints"]]
    return np.array([world[j["node"]] @ bind for j, bind in zip(animation["joints"], binds)])


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", type=Path, help="folder with static/ and skinned/")
    parser.add_argument("--pelage", help="the pelage binary; without it, only the others are measured")
    parser.add_argument("--set", action="append", default=[], help="passed to pelage bake, as KEY=VALUE")
    parser.add_argument("--only", nargs="*", help="names of meshes")
    args = parser.parse_args()
    files = [args.data / "static" / f"{name}.obj" for name in STATIC]
    for name in SKINNED:
        found = [args.data / "skinned" / f"{prefix}{name}.glb" for prefix in ("", "quaternius_")]
        files += [path for path in found if path.exists()]
    writer = csv.DictWriter(sys.stdout, COLUMNS, restval="")
    writer.writeheader()

    def row(path, count, method, values):
        rounded = {k: float(f"{v:.5g}") if isinstance(v, float) else v for k, v in values.items()}
        writer.writerow({"mesh": path.stem, "triangles": count, "method": method, **rounded})
        sys.stdout.flush()

    for path in files:
        if args.only and path.stem not in args.only:
            continue
        if args.pelage:
            for method, sets in PELAGE.items():
                values, count = by_pelage(args.pelage, path, args.set + sets)
                row(path, count, method, values)
        vertices, triangles = load(path)
        atlas, seconds = by_xatlas(vertices, triangles)
        row(path, len(triangles), "xatlas", {"seconds": seconds, **measure(vertices, triangles, atlas, False)})
        uvs, more = lscm_on_charts(vertices, triangles, atlas)
        values = {"seconds": seconds + more, **measure(vertices, triangles, uvs, False)}
        # These charts overlap, so seams are measured on the atlas.
        values.update({k: measure(vertices, triangles, atlas, False)[k] for k in ("seam_length_ratio", "charts")})
        row(path, len(triangles), "libigl LSCM on xatlas charts", values)
        try:
            uvs, seconds = lscm_with_one_cut(vertices, triangles)
        except (ValueError, RuntimeError) as error:
            print(f"{path.stem}: libigl LSCM with one cut: {error}", file=sys.stderr)
            continue
        values = measure(vertices, triangles, uvs, False)
        row(path, len(triangles), "libigl LSCM, one chart", {"seconds": seconds, **values})


if __name__ == "__main__":
    main()
