"""Converts the camera of an export to Mitsuba 3."""

import mitsuba as mi


def sensor(exported, spp, scale=1.0):
    """Returns a sensor with a box filter and independent samples.

    Each pixel is then the mean of the same rays as in pelage.

    scale: scene units per metre.
    """
    camera = exported["camera"]
    eye, target = ([scale * x for x in camera[place]] for place in ("eye", "target"))
    return {
        "type": "perspective",
        "fov": camera["fov_y_deg"],
        "fov_axis": "y",
        "near_clip": 1e-3 * scale,
        "far_clip": 1e4 * scale,
        "to_world": mi.ScalarTransform4f().look_at(eye, target, camera["up"]),
        "film": {
            "type": "hdrfilm",
            "width": exported["width"],
            "height": exported["height"],
            "pixel_format": "rgba",
            "rfilter": {"type": "box"},
        },
        "sampler": {"type": "independent", "sample_count": spp},
    }
