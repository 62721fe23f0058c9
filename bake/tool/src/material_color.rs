//! Colours of a package's materials, as the model defines them: without light, and without the gain of hair.

use glam::{Vec2, Vec3};
use pelage_bake::noise::{R2_STEP, r2_point};
use pelage_bake::recipe::Recipe;
use pelage_bake::stages::slice::decode_texture;
use pelage_formats::meaning::{linear_to_srgb, srgb_to_linear};
use pelage_formats::{FormatError, Package};

/// Largest side of the mip level that is sampled, texels.
const LARGEST: u32 = 512;
/// Number of samples on the surface of a material.
const SAMPLES: u32 = 4096;
/// Largest difference at which two colours count as equal, in steps of an sRGB byte.
const ONE_COLOR: u8 = 4;
/// Share of samples of one colour above which a material in a texture painted by the bake has that colour alone. The
/// other texels are those beside other materials.
const MOST_OF_IT: f64 = 0.9;

/// Triangle of a material.
pub struct ColoredTriangle {
    /// Area at rest, square metres.
    pub area: f64,
    /// Texture coordinates of the corners.
    pub uvs: [Vec2; 3],
    /// Vertex colours of the corners, linear.
    pub colors: [Vec3; 3],
}

/// Colour of a material.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MaterialColor {
    /// Mean base colour over the material's surface, `#rrggbb` in sRGB.
    pub hex: String,
    /// Whether the material has a texture of its own. A texture that the bake paints for several materials counts where
    /// it has more than one colour.
    pub textured: bool,
}

/// Returns the colour of each material of a package.
///
/// * `recipe`: recipe recorded in the package
/// * `areas`: area of each material at rest, square metres
/// * `triangles`: returns the triangles of a material
///
/// Fails for damaged sections.
pub fn material_colors<T: Iterator<Item = ColoredTriangle>>(
    package: &Package<'_>,
    recipe: &Recipe,
    areas: &[f64],
    triangles: impl Fn(usize) -> T,
) -> Result<Vec<MaterialColor>, FormatError> {
    let materials = &package.manifest().materials;
    let roots = package.roots()?;
    let hair_colors = package.hair_colors()?;
    let mut found = vec![MaterialColor::default(); materials.len()];
    // Materials with the same texture follow each other, so that each texture is decoded once and only one is held.
    let mut order: Vec<usize> = (0..materials.len()).collect();
    order.sort_by_key(|m| materials[*m].base_color_texture);
    let mut held: Option<(u32, Option<Texels>)> = None;
    for m in order {
        let material = &materials[m];
        let index = material.base_color_texture;
        if let Some(index) = index.filter(|index| held.as_ref().is_none_or(|(held, _)| held != index)) {
            held = Some((index, Texels::of(package, m)?));
        }
        let texels = held.as_ref().filter(|(held, _)| Some(*held) == index).and_then(|(_, texels)| texels.as_ref());
        let at_root = roots.as_ref().and_then(|info| info.uv_per_tile.get(m)).is_some_and(|scale| *scale > 0.0);
        let painted = material.furred && (at_root || recipe.color.pattern.is_some());
        let samples = samples(areas[m], triangles(m), texels);
        let one_color = if painted { one_color(&samples) } else { None };
        let lightened = material.furred && hair_colors.get(m).copied().flatten().is_none();
        let gain = recipe.color.gain.filter(|_| lightened).unwrap_or(1.0);
        let [r, g, b, _] = material.base_color;
        let mean = one_color.unwrap_or_else(|| samples.iter().sum::<Vec3>() / samples.len() as f32);
        let [r, g, b] = (mean * Vec3::new(r, g, b) / gain).to_array().map(linear_to_srgb);
        let textured = index.is_some() && one_color.is_none();
        found[m] = MaterialColor { hex: format!("#{r:02x}{g:02x}{b:02x}"), textured };
    }
    Ok(found)
}

/// Decoded texture.
struct Texels {
    size: [u32; 2],
    rgba: Vec<u8>,
}

impl Texels {
    /// Decodes the base colour texture of a material; `None` if its format cannot be decoded.
    fn of(package: &Package<'_>, material: usize) -> Result<Option<Self>, FormatError> {
        let Some(view) = package.base_color_texture(material)? else { return Ok(None) };
        let level = (0..view.levels).find(|level| (view.width.max(view.height) >> level) <= LARGEST).unwrap_or(0);
        let rgba = decode_texture(&view, level, 0).ok();
        Ok(rgba.map(|rgba| Self { size: [view.width, view.height].map(|side| (side >> level).max(1)), rgba }))
    }

    /// Returns the nearest texel, linear. The texture repeats.
    fn at(&self, uv: Vec2) -> Vec3 {
        let uv = if uv.is_finite() { uv - uv.floor() } else { Vec2::ZERO };
        let [x, y] = [(uv.x, self.size[0]), (uv.y, self.size[1])]
            .map(|(share, count)| ((share * count as f32) as usize).min(count.saturating_sub(1) as usize));
        let at = 4 * (y * self.size[0] as usize + x);
        self.rgba.get(at..at + 3).map_or(Vec3::ONE, |c| Vec3::from([0, 1, 2].map(|i| srgb_to_linear(c[i]))))
    }
}

/// Returns the product of texture and vertex colour at points evenly distributed over the triangles, linear; white for
/// a material without area.
fn samples(area: f64, triangles: impl Iterator<Item = ColoredTriangle>, texels: Option<&Texels>) -> Vec<Vec3> {
    if !(area > 0.0 && area.is_finite()) {
        return vec![Vec3::ONE];
    }
    let mut samples = Vec::with_capacity(SAMPLES as usize);
    let mut below = 0.0;
    for triangle in triangles {
        below += triangle.area;
        while samples.len() < SAMPLES as usize && (samples.len() as f64 + 0.5) / f64::from(SAMPLES) * area < below {
            let [a, b, c] = weights(samples.len());
            let mix = |[u, v, w]: [Vec3; 3]| u * a + v * b + w * c;
            let [u, v, w] = triangle.uvs;
            let texel = texels.map_or(Vec3::ONE, |texels| texels.at(u * a + v * b + w * c));
            samples.push(texel * mix(triangle.colors));
        }
    }
    samples
}

/// Returns barycentric coordinates of point `i` of a sequence that covers a triangle evenly.
fn weights(i: usize) -> [f32; 3] {
    let [u, v] = r2_point(i as u32, 0.5 * R2_STEP).as_vec2().to_array();
    let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
    [1.0 - u - v, u, v]
}

/// Returns the median colour if nearly all samples have it.
fn one_color(samples: &[Vec3]) -> Option<Vec3> {
    let bytes: Vec<[u8; 3]> = samples.iter().map(|color| color.to_array().map(linear_to_srgb)).collect();
    let median = [0, 1, 2].map(|channel| {
        let mut values: Vec<u8> = bytes.iter().map(|color| color[channel]).collect();
        values.sort_unstable();
        values[values.len() / 2]
    });
    let equal = |color: &&[u8; 3]| color.iter().zip(median).all(|(a, b)| a.abs_diff(b) <= ONE_COLOR);
    let share = bytes.iter().filter(equal).count() as f64 / bytes.len() as f64;
    (share >= MOST_OF_IT).then(|| Vec3::from(median.map(srgb_to_linear)))
}
