"""Reads meshes of OBJ and glTF files in their rest pose, welded by position."""

import base64
import json
import struct
from pathlib import Path

import numpy as np

COMPONENTS = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


def load(path):
    """Returns vertices (n, 3) in float64 and triangles (m, 3)."""
    path = Path(path)
    vertices, triangles = read_obj(path) if path.suffix == ".obj" else Gltf(path).rest()
    return weld(vertices, triangles)


def weld(vertices, triangles):
    """Joins vertices that are equal bit for bit, and drops triangles that use a vertex twice."""
    unique, index = np.unique(np.asarray(vertices, np.float64) + 0.0, axis=0, return_inverse=True)
    triangles = index.reshape(-1)[np.asarray(triangles, np.int64)]
    a, b, c = triangles.T
    return unique, triangles[(a != b) & (b != c) & (c != a)]


def read_obj(path):
    vertices, triangles = [], []
    for line in path.read_text(errors="replace").splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append([np.float32(x) for x in words[1:4]])
        elif words[:1] == ["f"]:
            corners = [int(word.split("/")[0]) for word in words[1:]]
            corners = [i - 1 if i > 0 else len(vertices) + i for i in corners]
            triangles += [[corners[0], corners[i], corners[i + 1]] for i in range(1, len(corners) - 1)]
    return np.array(vertices), np.array(triangles)


class Gltf:
    """The subset of glTF 2.0 that the test data needs: triangles, node transforms, skins."""

    def __init__(self, path):
        path = Path(path)
        data = path.read_bytes()
        self.binary = None
        if data[:4] == b"glTF":
            length = struct.unpack_from("<I", data, 12)[0]
            self.json = json.loads(data[20 : 20 + length])
            self.binary = data[28 + length :]
        else:
            self.json = json.loads(data)
        self.folder = path.parent

    def buffer(self, index):
        uri = self.json["buffers"][index].get("uri")
        if uri is None:
            return self.binary
        if uri.startswith("data:"):
            return base64.b64decode(uri.split(",", 1)[1])
        return (self.folder / uri).read_bytes()

    def accessor(self, index):
        accessor = self.json["accessors"][index]
        view = self.json["bufferViews"][accessor["bufferView"]]
        kind, width = np.dtype(COMPONENTS[accessor["componentType"]]), WIDTHS[accessor["type"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        stride = view.get("byteStride", kind.itemsize * width)
        values = np.ndarray(
            (accessor["count"], width), kind, self.buffer(view["buffer"]), start, (stride, kind.itemsize)
        )
        if accessor.get("normalized"):
            return np.maximum(values / float(np.iinfo(kind).max), -1.0)
        return values

    def world(self):
        """Returns the world matrix of each node, at rest."""
        nodes = self.json["nodes"]
        parent = {child: i for i, node in enumerate(nodes) for child in node.get("children", [])}
        local = [local_matrix(node) for node in nodes]

        def of(i):
            return of(parent[i]) @ local[i] if i in parent else local[i]

        return [of(i) for i in range(len(nodes))]

    def rest(self):
        world = self.world()
        vertices, triangles, count = [], [], 0
        for i, node in enumerate(self.json["nodes"]):
            for primitive in self.json["meshes"][node["mesh"]]["primitives"] if "mesh" in node else []:
                attributes = primitive["attributes"]
                positions = self.accessor(attributes["POSITION"]).astype(np.float64)
                positions = np.c_[positions, np.ones(len(positions))]
                if "skin" in node and "JOINTS_0" in attributes:
                    positions = self.skinned(self.json["skins"][node["skin"]], attributes, positions, world)
                else:
                    positions = positions @ world[i].T
                indices = np.arange(len(positions))
                if "indices" in primitive:
                    indices = self.accessor(primitive["indices"])[:, 0].astype(np.int64)
                triangles.append(indices.reshape(-1, 3) + count)
                vertices.append(positions[:, :3])
                count += len(positions)
        return np.concatenate(vertices).astype(np.float32), np.concatenate(triangles)

    def skinned(self, skin, attributes, positions, world):
        bind = self.accessor(skin["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)
        matrices = np.array([world[joint] for joint in skin["joints"]]) @ bind
        joints, weights = self.accessor(attributes["JOINTS_0"]), self.accessor(attributes["WEIGHTS_0"])
        weights = weights / np.maximum(weights.sum(1, keepdims=True), 1e-12)
        blended = (matrices[joints] * weights[:, :, None, None]).sum(1)
        return np.einsum("nij,nj->ni", blended, positions)


def local_matrix(node):
    if "matrix" in node:
        return np.array(node["matrix"], np.float64).reshape(4, 4).T
    x, y, z, w = node.get("rotation", [0, 0, 0, 1])
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    out = np.eye(4)
    out[:3, :3] = turn * np.array(node.get("scale", [1, 1, 1]))
    out[:3, 3] = node.get("translation", [0, 0, 0])
    return out
