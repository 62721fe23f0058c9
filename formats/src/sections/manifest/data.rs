//! What a package says about itself. The order of the fields is the order of the bytes: see `FORMAT.md`, "MANI".

use super::choice::Choice;
use super::detail::{self, CoatInfo, DetailLevel};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::ops::RangeInclusive;

/// The manifest section: what is in the package, how it was made, how to shade it.
///
/// It holds no absolute path, no time and no user name, so that the same inputs give the same bytes anywhere.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Tool and version that baked the package, such as `pelage 0.1.0`.
    pub generator: String,
    /// Name of the model: the input's file name without folder and extension.
    pub model: String,
    /// The recipe as resolved, TOML: every key with the value that was used.
    pub recipe: String,
    /// The files that went in, in the order of reading.
    pub inputs: Vec<InputRecord>,
    /// Extent of the skin in its posed rest state, without fur.
    pub bounds: Bounds,
    /// The shell volume.
    pub fur: FurInfo,
    /// Constants of the lighting equation.
    pub shading: Shading,
    /// Materials of the model.
    pub materials: Vec<Material>,
    /// Index ranges, one draw each; together they cover the index buffer in order.
    pub parts: Vec<Part>,
    /// The k-th entry names the k-th `KTX2` section.
    pub textures: Vec<TextureEntry>,
    /// Figures that bake measured.
    pub quality: Vec<QualityFigure>,
    /// What bake had to repair, leave out or guess.
    pub warnings: Vec<String>,
    /// The far coat, from version 3 on, as what follows: all layers above the skin seen from above, one more array layer of the shell
    /// textures, dry and wet, behind the outermost.
    pub coat: Option<CoatInfo>,
    /// Levels of detail, finest first; empty where all layers are drawn at any distance.
    pub detail: Vec<DetailLevel>,
    /// How the settings were chosen, where a bake was told limits instead.
    pub choice: Option<Choice>,
}

/// One input file of a bake.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct InputRecord {
    /// `model`, `recipe`, `buffer`, `image` or `material`.
    pub role: String,
    /// File name without folders; empty for data embedded in another file.
    pub name: String,
    /// Size in bytes.
    pub bytes: u64,
    /// SHA-256 of the contents.
    pub sha256: [u8; 32],
}

/// Extent of the skin in its posed rest state, metres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Bounds {
    /// Least x, y, z.
    pub min: [f32; 3],
    /// Greatest x, y, z.
    pub max: [f32; 3],
    /// Centre of the bounding sphere.
    pub center: [f32; 3],
    /// Radius of the bounding sphere about `center`.
    pub radius: f32,
}

/// The shell volume: one periodic tile of hair, sliced into layers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FurInfo {
    /// Layers of the shell textures; layer 0 lies on the skin. 0 for a package without fur.
    pub layers: u32,
    /// Width and height of a layer, texels.
    pub tile_texels: u32,
    /// Width and height of the tile on the skin, metres.
    pub tile_size_m: f32,
    /// Height of layer `layers - 1` above the skin where a vertex's `fur_height` is not scaled, metres.
    pub height_m: f32,
    /// Strands in the tile.
    pub strands: u32,
    /// Patches of the parameterization; 1 where the model's own texture coordinates serve.
    pub patches: u32,
    /// Index into `textures`: RGBA, premultiplied linear colour and opacity, `layers` array layers, skin first.
    pub color_texture: u32,
    /// Index into `textures`: hair direction in the tile frame, `layers` array layers (`FORMAT.md`, "Directions").
    pub direction_texture: u32,
    /// The same hair when wet: a second set of textures of the same size, which a renderer mixes in by wetness.
    pub wet: Option<ShellTextures>,
    /// Textures of the fins; a package that has them has a `FINS` section, and the other way round.
    pub fins: Option<FinInfo>,
}

/// A set of shell textures, as large as [`FurInfo`] says.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ShellTextures {
    /// Index into `textures`, as [`FurInfo::color_texture`].
    pub color_texture: u32,
    /// Index into `textures`, as [`FurInfo::direction_texture`].
    pub direction_texture: u32,
}

/// The fin textures: hair of the tile seen from the side, one array layer per slab. u runs along a slab and repeats; v runs from
/// the skin, the first row, to [`FurInfo::height_m`], the last.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct FinInfo {
    /// Width of a slab, texels, at least 1.
    pub width: u32,
    /// Height of a slab, texels, at least 1.
    pub height: u32,
    /// Slabs, each cut through the tile in another direction, at least 1: array layers of both textures.
    pub slabs: u32,
    /// Index into `textures`: RGBA, premultiplied linear colour and opacity.
    pub color_texture: u32,
    /// Index into `textures`: hair direction in the tile frame (`FORMAT.md`, "Directions").
    pub direction_texture: u32,
}

/// Constants of Yang 2006, eqs. (1)–(3). Colours are linear RGB.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shading {
    /// ka, multiplied by the hair's colour (default 0.35 each).
    pub ambient: [f32; 3],
    /// kd (default 1.2 each: where hair shadows hair, not all of the light arrives).
    pub diffuse: [f32; 3],
    /// ks (default 0.18 each).
    pub specular: [f32; 3],
    /// pd, 0..=10 000 (default 2): 0 lights all directions alike.
    pub diffuse_exponent: f32,
    /// ps, 0..=10 000 (default 30): higher is a narrower highlight.
    pub specular_exponent: f32,
    /// ε of the ambient attenuation γ, 0..1 (default 0.3): share of the ambient light that reaches the skin.
    pub ambient_floor: f32,
    /// r of Attenu_Back, 0..1, exclusive (default 0.3): how far light creeps past the terminator, as −N·L.
    pub back_light_range: f32,
}

impl Default for Shading {
    fn default() -> Self {
        Self {
            ambient: [0.35; 3],
            diffuse: [1.2; 3],
            specular: [0.18; 3],
            diffuse_exponent: 2.0,
            specular_exponent: 30.0,
            ambient_floor: 0.3,
            back_light_range: 0.3,
        }
    }
}

/// Fails for the first value that is not finite.
fn finite(what: &str, values: &[f32]) -> Result<(), String> {
    match values.iter().find(|v| !v.is_finite()) {
        Some(v) => Err(format!("{what} is {v}, expected a finite number")),
        None => Ok(()),
    }
}

impl Shading {
    /// Range of the exponents.
    pub const EXPONENT: RangeInclusive<f32> = 0.0..=10_000.0;

    /// Checks every number; returns the field, what was found and what was expected.
    ///
    /// # Errors
    ///
    /// The first number that is out of its range.
    pub fn check(&self) -> Result<(), String> {
        finite("ambient", &self.ambient)?;
        finite("diffuse", &self.diffuse)?;
        finite("specular", &self.specular)?;
        for (what, value, range) in [
            ("diffuse_exponent", self.diffuse_exponent, Self::EXPONENT),
            ("specular_exponent", self.specular_exponent, Self::EXPONENT),
            ("ambient_floor", self.ambient_floor, 0.0..=1.0),
        ] {
            if !range.contains(&value) {
                return Err(format!("{what} is {value}, expected {}..={}", range.start(), range.end()));
            }
        }
        // Exclusive: the lighting equation divides by it, and at 1 no direction is ever dark.
        if !(self.back_light_range > 0.0 && self.back_light_range < 1.0) {
            return Err(format!("back_light_range is {}, expected it between 0 and 1", self.back_light_range));
        }
        Ok(())
    }

    /// What the constants become where hair is wet: the film of water smooths its scales, which makes the highlight twice as
    /// strong and much narrower.
    pub fn wet(&self) -> Self {
        Self {
            specular: self.specular.map(|k| 2.0 * k),
            specular_exponent: (4.0 * self.specular_exponent).min(*Self::EXPONENT.end()),
            ..*self
        }
    }
}

/// A surface material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Material {
    /// Name in the model, may be empty.
    pub name: String,
    /// Linear RGBA factor.
    pub base_color: [f32; 4],
    /// Index into `textures`: base colour in the model's own texture coordinates.
    pub base_color_texture: Option<u32>,
    /// Index into `textures`: the groom in the model's own texture coordinates, linear. Red is the share of the hair that grows,
    /// 0 bare to 1 full; green is wetness, 0..=1.
    pub groom_texture: Option<u32>,
    /// Opacity below which a texel of the skin is cut away; `None` for opaque materials.
    pub alpha_cutoff: Option<f32>,
    /// Whether hair grows on it; bare materials (eyes, hooves) are drawn by the skin pass only.
    pub furred: bool,
    /// Whether back faces are drawn.
    pub double_sided: bool,
}

/// One range of the index buffer with one material.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Part {
    /// Index into `materials`.
    pub material: u32,
    /// First index.
    pub first_index: u32,
    /// Number of indices, a multiple of 3.
    pub index_count: u32,
}

/// One texture of the package.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TextureEntry {
    /// Unique name, also the file name of the texture after `pelage unpack`: letters, digits, `_` and `-`.
    pub name: String,
}

/// One measured figure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct QualityFigure {
    /// Name, such as `angle_distortion`.
    pub name: String,
    /// Value.
    pub value: f64,
    /// Unit, `1` for ratios.
    pub unit: String,
}

impl Manifest {
    /// Array layers of the shell textures: the shells, and the coat where there is one.
    pub fn shell_texture_layers(&self) -> u32 {
        self.fur.layers.saturating_add(u32::from(self.coat.is_some()))
    }

    /// Checks that every number is finite and in its range and every index points into its list; what a reader may rely on.
    ///
    /// Returns the path of the faulty field with what was found and expected.
    pub(crate) fn check(&self) -> Result<(), String> {
        let b = &self.bounds;
        finite("bounds.min", &b.min)?;
        finite("bounds.max", &b.max)?;
        finite("bounds.center", &b.center)?;
        finite("bounds.radius", &[b.radius])?;
        for axis in 0..3 {
            if b.min[axis] > b.max[axis] {
                return Err(format!(
                    "bounds.min[{axis}] is {}, expected at most bounds.max[{axis}], {}",
                    b.min[axis], b.max[axis]
                ));
            }
        }
        if b.radius < 0.0 {
            return Err(format!("bounds.radius is {}, expected >= 0", b.radius));
        }
        self.shading.check().map_err(|reason| format!("shading.{reason}"))?;
        let textures = self.textures.len();
        let texture = |what: String, index: u32| match (index as usize) < textures {
            true => Ok(()),
            false => Err(format!("{what} is {index}, expected less than the {textures} textures")),
        };
        let f = &self.fur;
        finite("fur.tile_size_m", &[f.tile_size_m])?;
        finite("fur.height_m", &[f.height_m])?;
        if f.layers > 0 {
            texture("fur.color_texture".into(), f.color_texture)?;
            texture("fur.direction_texture".into(), f.direction_texture)?;
            if f.tile_texels == 0 {
                return Err("fur.tile_texels is 0, expected at least 1 for a package with fur".into());
            }
            if f.tile_size_m <= 0.0 || f.height_m < 0.0 {
                return Err(format!(
                    "fur.tile_size_m is {} and fur.height_m is {}, expected > 0 and >= 0",
                    f.tile_size_m, f.height_m
                ));
            }
        } else if f.wet.is_some() || f.fins.is_some() || self.coat.is_some() {
            return Err("fur.layers is 0 beside fur.wet, fur.fins or a coat, expected none of them without fur".into());
        }
        if let Some(wet) = &f.wet {
            texture("fur.wet.color_texture".into(), wet.color_texture)?;
            texture("fur.wet.direction_texture".into(), wet.direction_texture)?;
        }
        if let Some(fins) = &f.fins {
            texture("fur.fins.color_texture".into(), fins.color_texture)?;
            texture("fur.fins.direction_texture".into(), fins.direction_texture)?;
            if fins.width == 0 || fins.height == 0 || fins.slabs == 0 {
                let (w, h, n) = (fins.width, fins.height, fins.slabs);
                return Err(format!("fur.fins is {w}x{h} texels in {n} slabs, expected at least 1 of each"));
            }
        }
        if let Some(coat) = &self.coat {
            coat.check()?;
        }
        detail::check(&self.detail, self.fur.layers, self.coat.is_some())?;
        if let Some(choice) = &self.choice {
            choice.check()?;
        }
        for (i, m) in self.materials.iter().enumerate() {
            finite(&format!("materials[{i}].base_color"), &m.base_color)?;
            finite(&format!("materials[{i}].alpha_cutoff"), m.alpha_cutoff.as_slice())?;
            if let Some(index) = m.base_color_texture {
                texture(format!("materials[{i}].base_color_texture"), index)?;
            }
            if let Some(index) = m.groom_texture {
                texture(format!("materials[{i}].groom_texture"), index)?;
            }
        }
        let mut next = 0u32;
        for (i, p) in self.parts.iter().enumerate() {
            if p.material as usize >= self.materials.len() {
                let n = self.materials.len();
                return Err(format!("parts[{i}].material is {}, expected less than {n}", p.material));
            }
            if p.first_index != next || p.index_count % 3 != 0 {
                return Err(format!(
                    "parts[{i}] is {} indices from {}, expected a multiple of 3 from {next}",
                    p.index_count, p.first_index
                ));
            }
            next = next.checked_add(p.index_count).ok_or_else(|| format!("parts[{i}] ends past 2^32 indices"))?;
        }
        let mut names = BTreeSet::new();
        for (i, t) in self.textures.iter().enumerate() {
            let legal = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
            if t.name.is_empty() || t.name.len() > 64 || !t.name.chars().all(legal) {
                return Err(format!(
                    "textures[{i}].name is {:?}, expected 1 to 64 letters, digits, '_' or '-'",
                    t.name
                ));
            }
            // Two names that differ by case alone would be one file on some systems.
            if !names.insert(t.name.to_ascii_lowercase()) {
                return Err(format!("textures[{i}].name {:?} is taken, expected unique names", t.name));
            }
        }
        match self.quality.iter().find(|q| !q.value.is_finite()) {
            Some(q) => Err(format!("quality figure {:?} is {}, expected a finite number", q.name, q.value)),
            None => Ok(()),
        }
    }
}
