"""Compares the traced reference image with Mitsuba 3 on the same strands, skin, camera and light.

Prints one JSON object; see README.md.
"""

import argparse
import json
import os
import resource
import tempfile
import time
from pathlib import Path

import mitsuba as mi
import numpy as np
from mitsuba_camera import sensor
from strand_files import pelage

TOWARDS_LIGHT = (-0.25, 0.75, 0.6)


def scene(strands, skin, exported, light, spp):
    """Returns the same animal with plain diffuse hair; only hits and speed are compared."""
    towards = np.array(light) / np.linalg.norm(light)
    # One sample of the light and none of the surface: one ray from the eye and one to the light, as in the reference
    # image.
    return mi.load_dict({
        "type": "scene",
        "integrator": {"type": "direct", "emitter_samples": 1, "bsdf_samples": 0, "hide_emitters": True},
        "sensor": sensor(exported, spp),
        "light": {"type": "directional", "direction": (-towards).tolist(), "irradiance": {"type": "rgb", "value": 3.0}},
        "skin": {
            "type": "obj",
            "filename": str(skin),
            "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.2, 0.13, 0.09]}},
        },
        "hair": {
            "type": "linearcurve",
            "filename": str(strands),
            "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.55, 0.40, 0.28]}},
        },
    })  # fmt: skip


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("package", type=Path)
    arguments.add_argument("--pelage", default="../../target/release/pelage")
    arguments.add_argument("--size", default="512x512")
    arguments.add_argument("--spp", type=int, default=64)
    arguments.add_argument("--variant", default="scalar_rgb", help="scalar_rgb or llvm_ad_rgb")
    arguments.add_argument("--threads", type=int, default=os.cpu_count())
    arguments.add_argument("-o", "--output", type=Path, default=Path("."), help="folder for the two pictures")
    given = arguments.parse_args()
    mi.set_variant(given.variant)

    given.output.mkdir(parents=True, exist_ok=True)
    ours_file, theirs_file = given.output / "pelage.exr", given.output / "mitsuba.exr"
    light = ",".join(map(str, TOWARDS_LIGHT))
    ours_cpu = -resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    ours = pelage(
        given.pelage, "reference", given.package, "-o", ours_file, "--size", given.size, "--samples", given.spp,
        "--threads", given.threads, f"--light={light}", "--penumbra", 0,
    )  # fmt: skip
    ours_cpu += resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    with tempfile.TemporaryDirectory() as folder:
        strands, skin = Path(folder) / "strands.txt", Path(folder) / "skin.obj"
        words = ["--strands", strands, "--mesh", skin, "--size", given.size]
        exported = pelage(given.pelage, "export", given.package, *words)
        begun = time.perf_counter()
        loaded = scene(strands, skin, exported, TOWARDS_LIGHT, given.spp)
        load_seconds = time.perf_counter() - begun
    # Compiles the kernels, which does not count as tracing.
    np.array(mi.render(loaded, spp=1, seed=1))
    begun, begun_cpu = time.perf_counter(), time.process_time()
    picture = np.array(mi.render(loaded, spp=given.spp, seed=0))
    seconds, theirs_cpu = time.perf_counter() - begun, time.process_time() - begun_cpu
    mi.Bitmap(picture.astype(np.float32)).write(str(theirs_file))

    alpha = picture[..., 3]
    primary = picture.shape[0] * picture.shape[1] * given.spp
    shadow = int(alpha.sum() * given.spp)
    our_alpha = np.array(mi.Bitmap(str(ours_file)))[..., 3]
    covered = (alpha > 0) | (our_alpha > 0)
    print(json.dumps({
        "strands": ours["strands"],
        "segments": ours["segments"],
        "size": given.size,
        "spp": given.spp,
        "threads": given.threads,
        "pelage": {
            "build_seconds": ours["grow_seconds"],
            "seconds": ours["seconds"],
            "mrays_per_s": ours["mrays_per_s"],
            "cpu_seconds_with_build": ours_cpu,
        },
        "mitsuba": {
            "version": mi.__version__,
            "variant": given.variant,
            "build_seconds": load_seconds,
            "seconds": seconds,
            "mrays_per_s": (primary + shadow) * 1e-6 / seconds,
            "cpu_seconds": theirs_cpu,
        },
        "covered_share": {"pelage": float(our_alpha.mean()), "mitsuba": float(alpha.mean())},
        "mean_alpha_difference": float(np.abs(alpha - our_alpha).mean()),
        "mean_alpha_difference_where_covered": float(np.abs(alpha - our_alpha)[covered].mean()),
    }, indent=2))  # fmt: skip


if __name__ == "__main__":
    main()
