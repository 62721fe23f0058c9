"""Computes the measures of `pelage bake --json` from their definitions, for any mesh with coordinates per corner."""

import numpy as np

COLLAPSED = 1e-9


def measure(vertices, triangles, uvs, periodic):
    """Returns measures of the map from the skin to texture coordinates.

    vertices: (n, 3), welded by position; triangles: (m, 3); uvs: (m, 3, 2), one per corner.
    periodic: whether the coordinates are in a repeating tile. There, unlike in an atlas, an offset by whole tiles that
    is the same at both ends of an edge is not a seam.
    """
    p = vertices[triangles]
    e1, e2 = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    areas = np.linalg.norm(np.cross(e1, e2), axis=1) / 2
    sound = areas > 0
    x = e1[sound] / np.linalg.norm(e1[sound], axis=1, keepdims=True)
    along = (e2[sound] * x).sum(1)
    y = e2[sound] - x * along[:, None]
    across = np.linalg.norm(y, axis=1)
    # Columns: the two edges in the triangle's plane, and in texture coordinates.
    plane = np.zeros((sound.sum(), 2, 2))
    plane[:, 0, 0] = np.linalg.norm(e1[sound], axis=1)
    plane[:, 0, 1], plane[:, 1, 1] = along, across
    texture = np.stack([uvs[sound, 1] - uvs[sound, 0], uvs[sound, 2] - uvs[sound, 0]], axis=2)
    maps = texture @ np.linalg.inv(plane)
    determinants, weights = np.linalg.det(maps), areas[sound]
    seams, region = seams_and_charts(vertices, triangles, uvs, periodic)
    if not periodic:
        # In an atlas, v may point down, and xatlas mirrors whole charts when it rotates them. Only triangles that are
        # flipped relative to their own chart count.
        turned = np.bincount(region[sound], np.sign(determinants) * weights)
        determinants = determinants * np.where(turned < 0, -1, 1)[region[sound]]
    s = np.linalg.svd(maps, compute_uv=False)
    kept = np.isfinite(s).all(1) & (s[:, 1] > COLLAPSED * s[:, 0])
    s, kept_weights = s[kept], weights[kept]
    s = s * np.sqrt(kept_weights.sum() / (kept_weights * s[:, 0] * s[:, 1]).sum())
    mean = lambda values: float((values * kept_weights).sum() / kept_weights.sum())
    s1, s2 = s[:, 0], s[:, 1]
    return {
        "angle_distortion": mean((s1 / s2 + s2 / s1) / 2 - 1),
        "area_distortion": mean((s1 * s2 + 1 / (s1 * s2)) / 2 - 1),
        "stretch_l2": float(np.sqrt(mean((s1**2 + s2**2) / 2))),
        "flipped_triangles": int((determinants < 0).sum()),
        "seam_length_ratio": seams / float(np.sqrt(areas.sum())),
        "charts": int(region.max()) + 1,
    }


def seams_and_charts(vertices, triangles, uvs, periodic):
    """Returns the total length of the edges whose two sides disagree, and the region of each triangle.

    Sides are paired in opposite directions, as on an orientable surface; the first match wins.
    """
    waiting, parent, seams = {}, list(range(len(triangles))), 0.0

    def root(i):
        while parent[i] != i:
            parent[i] = parent[parent[i]]
            i = parent[i]
        return i

    scale = 1e-3 if periodic else 1e-6 * float(np.abs(uvs).max())
    for f, triangle in enumerate(triangles.tolist()):
        for k in range(3):
            a, b = triangle[k], triangle[(k + 1) % 3]
            others = waiting.get((b, a))
            if not others:
                waiting.setdefault((a, b), []).append((f, k))
                continue
            g, j = others.pop(0)
            offset = uvs[f, k] - uvs[g, (j + 1) % 3]
            other = uvs[f, (k + 1) % 3] - uvs[g, j]
            whole = np.round(offset) if periodic else 0.0
            if np.abs(offset - whole).max() < scale and np.abs(other - offset).max() < scale:
                parent[root(f)] = root(g)
            else:
                seams += float(np.linalg.norm(vertices[a] - vertices[b]))
    return seams, np.unique([root(i) for i in range(len(triangles))], return_inverse=True)[1]
