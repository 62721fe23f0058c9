//! Data of the manifest. Fields are in byte order; see `FORMAT.md`, "MANI".

use super::choice::Choice;
use super::detail::{self, DetailLevel, FarLayerInfo};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::ops::RangeInclusive;

/// Manifest section: the contents of the package, how it was made, and how to shade it.
///
/// The manifest contains no absolute path, time or user name, so that the same inputs give the same bytes anywhere.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Tool and version that baked the package, such as `pelage 0.1.0`.
    pub generator: String,
    /// Name of the model: the input's file name without folder and extension.
    pub model: String,
    /// Resolved recipe, TOML: every key with the value that was used.
    pub recipe: String,
    /// Input files, in the order of reading.
    pub inputs: Vec<InputRecord>,
    /// Bounds of the mesh surface in its posed rest state, without fur.
    pub bounds: Bounds,
    /// Shell volume.
    pub fur: FurInfo,
    /// Constants of the lighting equation.
    pub shading: Shading,
    /// Materials of the model.
    pub materials: Vec<Material>,
    /// Index ranges, one draw call each. Together they cover the index buffer in order.
    pub parts: Vec<Part>,
    /// Textures; the k-th entry names the k-th `KTX2` section.
    pub textures: Vec<TextureEntry>,
    /// Quality figures measured by the bake.
    pub quality: Vec<QualityFigure>,
    /// Warnings: what the bake had to repair, omit or guess.
    pub warnings: Vec<String>,
    /// Far layer; `None` if there is none. It shows all layers above the surface, seen from above. It is stored in one
    /// more array layer of the shell textures, dry and wet, after the outermost layer. This field and the fields below
    /// exist since version 3.
    pub coat: Option<FarLayerInfo>,
    /// Levels of detail, finest first; empty if all layers are drawn at any distance.
    pub detail: Vec<DetailLevel>,
    /// Record of how the settings were chosen, if the bake had limits.
    pub choice: Option<Choice>,
}

/// Input file of a bake.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct InputRecord {
    /// Role of the file: `model`, `recipe`, `buffer`, `image` or `material`.
    pub role: String,
    /// File name without folders; empty for data embedded in another file.
    pub name: String,
    /// Size in bytes.
    pub bytes: u64,
    /// SHA-256 of the contents.
    pub sha256: [u8; 32],
}

/// Bounds of the mesh surface in its posed rest state, metres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Bounds {
    /// Minimum x, y, z.
    pub min: [f32; 3],
    /// Maximum x, y, z.
    pub max: [f32; 3],
    /// Centre of the bounding sphere.
    pub center: [f32; 3],
    /// Radius of the bounding sphere about `center`.
    pub radius: f32,
}

/// Shell volume: one periodic tile of hair, sliced into layers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FurInfo {
    /// Number of layers of the shell textures; layer 0 is on the surface. 0 for a package without fur.
    pub layers: u32,
    /// Width and height of a layer, texels.
    pub tile_texels: u32,
    /// Width and height of the tile on the surface, metres.
    pub tile_size_m: f32,
    /// Height of layer `layers - 1` above the surface at a vertex with unscaled `fur_height`, metres.
    pub height_m: f32,
    /// Number of strands in the tile.
    pub strands: u32,
    /// Number of patches of the parameterization; 1 if the model's own texture coordinates are used.
    pub patches: u32,
    /// Index into `textures`: RGBA, premultiplied linear colour and opacity, `layers` array layers, the surface first.
    pub color_texture: u32,
    /// Index into `textures`: hair direction in the tile frame, `layers` array layers (`FORMAT.md`, "Directions").
    pub direction_texture: u32,
    /// Wet hair: a second set of textures of the same size, which a renderer blends in by wetness.
    pub wet: Option<ShellTextures>,
    /// Fin textures; present if and only if the package has a `FINS` section.
    pub fins: Option<FinInfo>,
}

/// Set of shell textures, of the size given by [`FurInfo`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ShellTextures {
    /// Index into `textures`, as [`FurInfo::color_texture`].
    pub color_texture: u32,
    /// Index into `textures`, as [`FurInfo::direction_texture`].
    pub direction_texture: u32,
}

/// Fin textures: hair of the tile seen from the side. A slab is a slice through the tile; each has an array layer. u
/// runs along a slab and repeats; v runs from the surface, the first row, to [`FurInfo::height_m`], the last.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct FinInfo {
    /// Width of a slab, texels, at least 1.
    pub width: u32,
    /// Height of a slab, texels, at least 1.
    pub height: u32,
    /// Number of slabs, at least 1, each cut through the tile in another direction. Equals the number of array layers
    /// of both textures.
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
    /// kd (default 1.2 each, because hairs shadow each other and not all light arrives).
    pub diffuse: [f32; 3],
    /// ks (default 0.18 each).
    pub specular: [f32; 3],
    /// pd, 0..=10 000 (default 2); with 0, all directions are lit equally.
    pub diffuse_exponent: f32,
    /// ps, 0..=10 000 (default 30); a higher exponent gives a narrower highlight.
    pub specular_exponent: f32,
    /// ε of the ambient attenuation γ, 0..1 (default 0.3): share of the ambient light that reaches the surface.
    pub ambient_floor: f32,
    /// r of Attenu_Back, between 0 and 1, both exclusive (default 0.3): how far light extends past the terminator, as
    /// −N·L.
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
    /// Fails with the first number that is out of its range.
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
        // Both ends are exclusive: the lighting equation divides by the value, and at 1 no direction is ever dark.
        if !(self.back_light_range > 0.0 && self.back_light_range < 1.0) {
            return Err(format!(
                "back_light_range is {}, expected a number above 0 and below 1",
                self.back_light_range
            ));
        }
        Ok(())
    }

    /// Returns the constants for wet hair: the water film smooths the hair's scales, which makes the highlight twice as
    /// strong and much narrower.
    pub fn wet(&self) -> Self {
        Self {
            specular: self.specular.map(|k| 2.0 * k),
            specular_exponent: (4.0 * self.specular_exponent).min(*Self::EXPONENT.end()),
            ..*self
        }
    }
}

/// Surface material.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Material {
    /// Name in the model, may be empty.
    pub name: String,
    /// Base colour factor, linear RGBA.
    pub base_color: [f32; 4],
    /// Index into `textures`: base colour in the model's own texture coordinates.
    pub base_color_texture: Option<u32>,
    /// Index into `textures`: the groom in the model's own texture coordinates, linear. Red is the share of the hair
    /// that grows, 0 bare to 1 full; green is wetness, 0..=1.
    pub groom_texture: Option<u32>,
    /// Opacity below which a texel of the surface is discarded; `None` for opaque materials.
    pub alpha_cutoff: Option<f32>,
    /// Whether hair grows on the material; bare materials (eyes, hooves) are drawn by the skin pass only.
    pub furred: bool,
    /// Whether back faces are drawn.
    pub double_sided: bool,
}

/// Range of the index buffer with one material.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Part {
    /// Index into `materials`.
    pub material: u32,
    /// First index.
    pub first_index: u32,
    /// Number of indices, a multiple of 3.
    pub index_count: u32,
}

/// Texture of the package.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TextureEntry {
    /// Unique name, also the file name of the texture after `pelage unpack`: letters, digits, `_` and `-`.
    pub name: String,
}

/// Measured figure.
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
    /// Returns the number of array layers of the shell textures: the shells, and the far layer if present.
    pub fn shell_texture_layers(&self) -> u32 {
        self.fur.layers.saturating_add(u32::from(self.coat.is_some()))
    }

    /// Checks that every number is finite and in range and every index valid, so that readers can rely on it.
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
            false => Err(format!("{what} is {index}, expected less than {textures}, the number of textures")),
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
                    "fur has tile_size_m {} and height_m {}, expected tile_size_m > 0 and height_m >= 0",
                    f.tile_size_m, f.height_m
                ));
            }
        } else if f.wet.is_some() || f.fins.is_some() || self.coat.is_some() {
            return Err("fur.layers is 0 but fur.wet, fur.fins or coat (far layer) is present, expected none of \
                 them without fur"
                .into());
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
                    "parts[{i}] has index_count {} and first_index {}, expected a multiple of 3 and first_index {next}",
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
            // Two names that differ only in case would be the same file on some file systems.
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
