"""Compares the coverage of a package's strands and skin in pelage and Mitsuba. Prints one JSON object; see README.md.

Mitsuba only tests whether rays hit anything, and does not render an image. Its `linearcurve` has round ends, but
discards a hit on an end when it computes the surface. The pixel is then transparent even if there is skin behind.
"""

import argparse
import json
import sys
import tempfile
from pathlib import Path

import drjit as dr
import mitsuba as mi
import numpy as np
from mitsuba_strands import TOWARDS_LIGHT, scene
from strand_files import pelage

# Samples per pixel of one launch: a few million rays.
A_LAUNCH = 16


def covered_shares(scene, width, height, spp):
    """Returns, for each pixel, the share of rays from the eye that hit anything; rays are uniform over the pixel."""
    sensor = scene.sensors()[0]
    hits = np.zeros(width * height)
    for launch in range(spp // A_LAUNCH):
        count = width * height * A_LAUNCH
        random = mi.PCG32(size=count, initstate=launch)
        pixel = dr.arange(mi.UInt32, count) // A_LAUNCH
        x = (mi.Float(pixel % width) + random.next_float32()) / width
        y = (mi.Float(pixel // width) + random.next_float32()) / height
        ray, _ = sensor.sample_ray(0.0, 0.5, mi.Point2f(x, y), mi.Point2f(0.5, 0.5))
        hits += np.array(scene.ray_test(ray)).reshape(-1, A_LAUNCH).sum(axis=1)
    return (hits / spp).reshape(height, width)


def noise(alpha, spp):
    """Returns the expected mean difference of two images with this coverage and `spp` independent samples."""
    return float(np.sqrt(2.0 / np.pi * 2.0 * alpha * (1.0 - alpha) / spp).mean())


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("package", type=Path)
    arguments.add_argument("--pelage", default="../../target/release/pelage")
    arguments.add_argument("--size", default="834x424")
    arguments.add_argument("--spp", type=int, default=256, help=f"samples per pixel, a multiple of {A_LAUNCH}")
    arguments.add_argument("--limit", type=float, default=0.003, help="exit with 1 past this mean difference of alpha")
    arguments.add_argument("-o", "--output", type=Path, help="folder for both coverages and their difference, as .exr")
    given = arguments.parse_args()
    if given.spp < A_LAUNCH or given.spp % A_LAUNCH:
        arguments.error(f"--spp {given.spp}: expected a multiple of {A_LAUNCH}")
    mi.set_variant("llvm_ad_rgb")

    with tempfile.TemporaryDirectory() as folder:
        strands, skin, true = (Path(folder) / name for name in ("strands.txt", "skin.obj", "true.exr"))
        pelage(given.pelage, "reference", given.package, "-o", true, "--size", given.size, "--samples", given.spp)
        words = ["--strands", strands, "--mesh", skin, "--size", given.size]
        exported = pelage(given.pelage, "export", given.package, *words)
        ours = np.array(mi.Bitmap(str(true)))[..., 3]
        loaded = scene(strands, skin, exported, TOWARDS_LIGHT, given.spp)
        theirs = covered_shares(loaded, exported["width"], exported["height"], given.spp)
    difference = np.abs(ours - theirs)
    covered = (ours > 0) | (theirs > 0)
    if given.output:
        given.output.mkdir(parents=True, exist_ok=True)
        for name, picture in (("pelage", ours), ("mitsuba", theirs), ("difference", difference)):
            mi.Bitmap(picture.astype(np.float32)[..., None]).write(str(given.output / f"{name}.exr"))
    print(json.dumps({
        "mitsuba": mi.__version__,
        "size": given.size,
        "spp": given.spp,
        "groups": exported["groups"],
        "covered_share": {"pelage": float(ours.mean()), "mitsuba": float(theirs.mean())},
        "mean_alpha_difference": float(difference.mean()),
        "of_independent_samples": noise(0.5 * (ours + theirs), given.spp),
        "mean_alpha_difference_where_covered": float(difference[covered].mean()) if covered.any() else 0.0,
        "largest_alpha_difference": float(difference.max()),
    }, indent=2))  # fmt: skip
    if not difference.mean() <= given.limit:
        sys.exit(f"the mean difference of alpha is {difference.mean():.5f}, expected at most {given.limit}")


if __name__ == "__main__":
    main()
