//! Built-in photo studio: an environment map without a file.

use super::{Environment, LightLobe, Sun};

/// Constant radiance of the walls.
const WALLS: [f32; 3] = [0.030, 0.032, 0.036];

/// Key light. It is in front of the model and high, so that the flank towards the default camera is lit at a slant.
const KEY: Sun = Sun { towards: [0.02, 0.74, 0.67], color: [1.36, 1.26, 1.11] };

/// Soft box around the key light, top light, fill, rim light behind the model, and the floor's reflection.
const LOBES: [LightLobe; 5] = [
    LightLobe { towards: [0.15, 0.72, 0.62], width_deg: 26.0, radiance: [0.62, 0.57, 0.50] },
    LightLobe { towards: [0.0, 1.0, -0.1], width_deg: 35.0, radiance: [0.20, 0.22, 0.27] },
    LightLobe { towards: [1.0, 0.15, 0.1], width_deg: 35.0, radiance: [0.12, 0.135, 0.17] },
    LightLobe { towards: [0.35, 0.45, -0.85], width_deg: 16.0, radiance: [2.0, 2.1, 2.25] },
    LightLobe { towards: [0.0, -1.0, 0.1], width_deg: 50.0, radiance: [0.12, 0.10, 0.08] },
];

/// Returns the lights of a photo studio for a model that faces +z, metres or any other unit: a warm key light with
/// a soft box, a cool top light and fill, a rim light behind, and a warm floor.
///
/// * `floor`: albedo of the floor, linear RGB; `None` for the studio's own
pub fn studio(floor: Option<[f32; 3]>) -> Environment {
    let lit = Environment { even: WALLS, sun: Some(KEY), lobes: LOBES.to_vec() };
    let Some(albedo) = floor else { return lit };
    let light = lit.ground_irradiance().as_vec3().to_array();
    let reflected = Environment::gradient([0.0; 3], std::array::from_fn(|i| albedo[i] * light[i]));
    let above = LOBES.into_iter().filter(|lobe| lobe.towards[1] >= 0.0);
    Environment { lobes: above.chain(reflected.lobes).collect(), ..lit }
}
