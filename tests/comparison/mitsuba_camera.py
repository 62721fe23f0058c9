"""The camera of an export, as Mitsuba 3 has it."""

import mitsuba as mi


def sensor(exported, spp):
    """A box filter and independent samples, so that pixels are means of the same rays as pelage's."""
    camera = exported["camera"]
    return {
        "type": "perspective",
        "fov": camera["fov_y_deg"],
        "fov_axis": "y",
        "near_clip": 1e-3,
        "to_world": mi.ScalarTransform4f().look_at(camera["eye"], camera["target"], camera["up"]),
        "film": {
            "type": "hdrfilm",
            "width": exported["width"],
            "height": exported["height"],
            "pixel_format": "rgba",
            "rfilter": {"type": "box"},
        },
        "sampler": {"type": "independent", "sample_count": spp},
    }
