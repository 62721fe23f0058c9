"""The camera of an export, as Mitsuba 3 has it."""

import mitsuba as mi


def sensor(exported, spp, scale=1.0):
    """A box filter and independent samples, so that pixels are means of the same rays as pelage's. `scale`: units of the scene in a metre."""
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
