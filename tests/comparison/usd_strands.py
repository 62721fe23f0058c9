"""Opens the .usda file of `pelage export` with USD's own library, and compares it with the text export.

Prints one JSON object; see README.md.
"""

import argparse
import json
import sys
import tempfile
from pathlib import Path

import numpy as np
from pxr import Sdf, Usd, UsdGeom, UsdValidation
from strand_files import pelage, read_text


def check(stage, names, strands):
    """Returns how the stage differs from these groups of strands; a strand is an array of rows x y z radius."""
    faults = []

    def same(what, found, expected):
        found, expected = np.asarray(found), np.asarray(expected)
        if found.shape != expected.shape or not np.array_equal(found, expected):
            start = f"{found.shape} {found.ravel()[:3]}"
            faults.append(f"{what}: {start}, expected {expected.shape} {expected.ravel()[:3]}")

    same("metersPerUnit", UsdGeom.GetStageMetersPerUnit(stage), 1.0)
    same("upAxis", str(UsdGeom.GetStageUpAxis(stage)), "Y")
    prims = [prim for prim in stage.GetDefaultPrim().GetChildren() if prim.IsA(UsdGeom.BasisCurves)]
    same("groups", [prim.GetDisplayName() or prim.GetName() for prim in prims], [group["name"] for group in names])
    for prim, group in zip(prims, names):
        mine = strands[group["first"] : group["first"] + group["strands"]]
        rows = np.concatenate(mine)
        curves = UsdGeom.BasisCurves(prim)
        path = str(prim.GetPath())
        same(f"{path} type", str(curves.GetTypeAttr().Get()), "linear")
        same(f"{path} counts", curves.GetCurveVertexCountsAttr().Get(), [len(strand) for strand in mine])
        same(f"{path} points", curves.GetPointsAttr().Get(), rows[:, :3])
        same(f"{path} widths", curves.GetWidthsAttr().Get(), 2 * rows[:, 3])
        same(f"{path} widths' interpolation", str(curves.GetWidthsInterpolation()), "vertex")
        same(f"{path} size", curves.ComputeUniformDataSize(Usd.TimeCode.Default()), len(mine))
        # The attribute must equal what the library computes from points and widths.
        computed = UsdGeom.Boundable.ComputeExtentFromPlugins(curves, Usd.TimeCode.Default())
        same(f"{path} extent", curves.GetExtentAttr().Get(), computed)
        primvars = UsdGeom.PrimvarsAPI(prim)
        color = primvars.GetPrimvar("displayColor")
        same(f"{path} colours", len(color.Get()), len(rows))
        same(f"{path} colours' interpolation", str(color.GetInterpolation()), "vertex")
        root = primvars.GetPrimvar("surface_uv_coordinate")
        same(f"{path} root coordinates", len(root.Get()), len(mine))
        same(f"{path} root coordinates' interpolation", str(root.GetInterpolation()), "uniform")
        same(f"{path} root coordinates' type", str(root.GetTypeName()), str(Sdf.ValueTypeNames.Float2Array))
        if not all(np.isfinite(np.asarray(numbers)).all() for numbers in (color.Get(), root.Get())):
            faults.append(f"{path}: a colour or a coordinate is no finite number")
    return faults


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("package", type=Path)
    arguments.add_argument("--pelage", default="../../target/release/pelage")
    given = arguments.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        text, usda = Path(folder) / "strands.txt", Path(folder) / "strands.usda"
        groups = pelage(given.pelage, "export", given.package, "--strands", text)["groups"]
        pelage(given.pelage, "export", given.package, "--strands", usda)
        strands = read_text(text)
        stage = Usd.Stage.Open(str(usda))
        faults = check(stage, groups, strands)
        validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
        errors = UsdValidation.ValidationContext(validators).Validate(stage)
        faults += [f"{error.GetName()}: {error.GetMessage()}" for error in errors]
        size = usda.stat().st_size
    print(json.dumps({
        "usd": ".".join(map(str, Usd.GetVersion())),
        "bytes": size,
        "groups": groups,
        "strands": len(strands),
        "points": sum(map(len, strands)),
        "validators": len(validators),
        "faults": faults,
    }, indent=2))  # fmt: skip
    if faults:
        sys.exit(f"{len(faults)} faults")


if __name__ == "__main__":
    main()
