"""Compares light between fibres in `pelage reference --fibre exact` and in Mitsuba 3's `hair` and `path`.

Both use the same strands. Prints one JSON object, and exits with 1 if the means differ by more than --limit; see
README.md.
"""

import argparse
import json
import os
import sys
import tempfile
import time
from pathlib import Path

import mitsuba as mi
import numpy as np
from mitsuba_camera import sensor
from strand_files import pelage, read_text

BLOCK = 16
# Scene units per metre; a unit is 0.1 mm. Mitsuba starts rays 1e-4 units off a surface. If the unit were a metre, that
# would be the width of a hair, and light that passes through a fibre would be lost.
SCALE = 1e4


def emitter(given):
    """Returns the emitter: the environment map, or a distant light."""
    if given.environment:
        path, _, yaw = given.environment.partition(":")
        # The centre of an environment map is +x in pelage, and +z in Mitsuba.
        turn = mi.ScalarTransform4f().rotate([0, 1, 0], 90 + float(yaw or 0))
        return {"type": "envmap", "filename": path, "scale": given.environment_strength, "to_world": turn}
    light = np.array([float(x) for x in given.light.split(",")])
    towards = light / np.linalg.norm(light)
    # A light of colour 1 has an irradiance of pi.
    irradiance = {"type": "rgb", "value": float(np.pi)}
    return {"type": "directional", "direction": (-towards).tolist(), "irradiance": irradiance}


def scene(strands, skin, exported, given):
    """Returns a scene of the exported strands, with the exported fibre, over skin of one colour."""
    groups = [group for group in exported["groups"] if "fibre" in group]
    if len(groups) != 1:
        advice = "bake with shading.model=marschner, without guided hair"
        sys.exit(f"{len(groups)} groups with a fibre in the export, expected one: {advice}")
    fibre = groups[0]["fibre"]
    return mi.load_dict({
        "type": "scene",
        # Mitsuba's paths have one more vertex: the light.
        "integrator": {"type": "path", "max_depth": given.bounces + 1, "rr_depth": 8, "hide_emitters": True},
        "sensor": sensor(exported, given.spp, SCALE),
        "light": emitter(given),
        "skin": {
            "type": "obj",
            "filename": str(skin),
            "to_world": mi.ScalarTransform4f().scale(SCALE),
            "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": given.skin or colour_of(fibre)}},
        },
        "hair": {
            # The fibre needs the direction of the curve, which linear curves do not provide.
            "type": "bsplinecurve",
            "filename": str(strands),
            "bsdf": {
                "type": "hair",
                "int_ior": fibre["index_of_refraction"],
                "ext_ior": 1.0,
                "longitudinal_roughness": fibre["longitudinal_roughness"],
                "azimuthal_roughness": fibre["azimuthal_roughness"],
                "scale_tilt": fibre["scale_tilt_deg"],
                "sigma_a": {"type": "rgb", "value": fibre["absorption_per_radius"]},
            },
        },
    })  # fmt: skip


def colour_of(fibre):
    """Returns the colour of deep fur of such fibres (Chiang 2016, section 4.2), which is that of pelage's undercoat."""
    b = fibre["azimuthal_roughness"]
    depth = 5.969 - 0.215 * b + 2.532 * b**2 - 10.73 * b**3 + 5.574 * b**4 + 0.245 * b**5
    return np.exp(-depth * np.sqrt(fibre["absorption_per_radius"])).tolist()


def splines(path):
    """Rewrites the strands in a file as control points of cubic B-splines, in scene units.

    A point is added beyond each end, so that the curve reaches the end.
    """
    out = []
    for strand in read_text(path):
        points = np.asarray(strand, dtype=np.float64) * SCALE
        while len(points) < 4:
            middles = 0.5 * (points[1:] + points[:-1])
            points = np.insert(points, range(1, len(points)), middles, axis=0)
        points = np.vstack([2 * points[0] - points[1], points, 2 * points[-1] - points[-2]])
        points[:, 3] = np.maximum(points[:, 3], 1e-4)
        out.append("\n".join(" ".join(f"{x:.9g}" for x in point) for point in points))
    path.write_text("\n\n".join(out) + "\n")


def blocks(picture):
    """Returns the means of square blocks of pixels."""
    height, width = (side // BLOCK * BLOCK for side in picture.shape[:2])
    cut = picture[:height, :width].reshape(height // BLOCK, BLOCK, width // BLOCK, BLOCK, -1)
    return cut.mean(axis=(1, 3))


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("package", type=Path)
    arguments.add_argument("--pelage", default="../../target/release/pelage")
    arguments.add_argument("--size", default="256x256")
    arguments.add_argument("--spp", type=int, default=64)
    arguments.add_argument("--bounces", type=int, default=64)
    arguments.add_argument("--light", default="-0.25,0.75,0.6")
    arguments.add_argument(
        "--environment", help="panorama that replaces the light; append :DEGREES to rotate it about the vertical")
    arguments.add_argument("--environment-strength", type=float, default=1.0)
    arguments.add_argument(
        "--skin", type=float, nargs=3, help="linear reflectance of the skin; default: colour of the hair")
    arguments.add_argument("--variant", default="scalar_rgb", help="scalar_rgb or llvm_ad_rgb")
    arguments.add_argument("--limit", type=float, default=0.03)
    arguments.add_argument("-o", "--output", type=Path, default=Path("."), help="folder for the pictures")
    given = arguments.parse_args()
    mi.set_variant(given.variant)
    given.output.mkdir(parents=True, exist_ok=True)

    ours_file, theirs_file = given.output / "pelage.exr", given.output / "mitsuba.exr"
    lit = [f"--light={given.light}", "--penumbra", 0, "--studio", "old"]
    if given.environment:
        lit = ["--environment", given.environment, "--environment-strength", given.environment_strength]
    ours = pelage(
        given.pelage, "reference", given.package, "-o", ours_file, "--size", given.size, "--samples", given.spp,
        *lit, "--fibre", "exact", "--bounces", given.bounces,
    )  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        strands, skin = Path(folder) / "strands.txt", Path(folder) / "skin.obj"
        words = ["--strands", strands, "--mesh", skin, "--size", given.size]
        exported = pelage(given.pelage, "export", given.package, *words)
        splines(strands)
        loaded = scene(strands, skin, exported, given)
    begun = time.perf_counter()
    theirs = np.array(mi.render(loaded, spp=given.spp, seed=0))
    seconds = time.perf_counter() - begun
    mi.Bitmap(theirs.astype(np.float32)).write(str(theirs_file))

    picture = mi.Bitmap(str(ours_file)).convert(mi.Bitmap.PixelFormat.RGBA, mi.Struct.Type.Float32, False)
    ours_blocks, theirs_blocks = blocks(np.array(picture)), blocks(theirs)
    covered = (ours_blocks[..., 3] > 0.5) & (theirs_blocks[..., 3] > 0.5)
    ours_light, theirs_light = ours_blocks[covered][:, :3], theirs_blocks[covered][:, :3]
    means = [light.mean(axis=0) for light in (ours_light, theirs_light)]
    off = np.abs(ours_light - theirs_light).mean(axis=1) / theirs_light.mean()
    worst = float(np.abs(means[0] / means[1] - 1).max())
    print(json.dumps({
        "strands": exported["strands"],
        "fibre": exported["groups"][0]["fibre"],
        "size": given.size,
        "spp": given.spp,
        "bounces": given.bounces,
        "threads": os.cpu_count(),
        "pelage": {"mean": means[0].tolist(), "seconds": ours["seconds"]},
        "mitsuba": {"mean": means[1].tolist(), "seconds": seconds, "version": mi.__version__, "variant": given.variant},
        "means_differ_by": worst,
        "blocks": int(covered.sum()),
        "blocks_differ_by_mean": float(off.mean()),
        "blocks_differ_by_most": float(off.max()),
    }, indent=2))  # fmt: skip
    sys.exit(worst > given.limit)


if __name__ == "__main__":
    main()
