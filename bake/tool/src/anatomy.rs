//! Size, materials, joints and clips of a model, read from its package. `bake` and `inspect` show them.

use glam::Vec3;
use pelage_bake::stages::size;
use pelage_bake::stages::slice::decode_texture;
use pelage_formats::meaning::{linear_to_srgb, posed_vertices, srgb_to_linear};
use pelage_formats::{FormatError, Package, Pose};
use serde::Serialize;

/// Size, materials, joints and clips of a model.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Anatomy {
    /// Side lengths of the bounding box at rest along x, y and z, metres.
    pub size_m: [f64; 3],
    pub materials: Vec<MaterialSummary>,
    /// Names of the joints, in the order of the skeleton.
    pub joint_names: Vec<String>,
    pub clips: Vec<ClipSummary>,
    /// Morph targets, in the order of the package.
    pub morphs: Vec<MorphSummary>,
}

/// A material of a model.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MaterialSummary {
    name: String,
    furred: bool,
    textured: bool,
    /// Mean base colour, encoded as sRGB `#rrggbb`.
    color: String,
    triangles: u64,
    /// Share of the model's surface, 0 to 1.
    share: f64,
    /// Minimum corner of the bounding box of its triangles at rest, metres; null without triangles.
    from_m: Option<[f32; 3]>,
    /// Maximum corner of the bounding box of its triangles at rest, metres; null without triangles.
    to_m: Option<[f32; 3]>,
}

/// A clip of an animation.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ClipSummary {
    name: String,
    seconds: f32,
}

/// A morph target.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MorphSummary {
    name: String,
    /// Weight in the rest pose.
    weight: f32,
}

impl Anatomy {
    /// Reads the anatomy from a package.
    ///
    /// # Errors
    ///
    /// Errors of damaged sections.
    pub fn of(package: &Package<'_>) -> Result<Self, FormatError> {
        let manifest = package.manifest();
        let animation = package.animation()?;
        let mut pose = Pose::default();
        if let Some(animation) = &animation {
            pose.sample(animation, None, 0.0);
        }
        let mesh = package.mesh()?;
        let positions: Vec<Vec3> =
            mesh.iter().flat_map(|m| posed_vertices(m, None, &pose)).map(|v| v.position.into()).collect();
        let indices: Vec<u32> = mesh.iter().flat_map(pelage_formats::MeshView::indices).collect();
        let mut found: Vec<MaterialBounds> = manifest.materials.iter().map(|_| MaterialBounds::default()).collect();
        for part in &manifest.parts {
            let corners = indices.get(part.first_index as usize..(part.first_index + part.index_count) as usize);
            let found = &mut found[part.material as usize];
            corners.unwrap_or_default().as_chunks::<3>().0.iter().for_each(|triangle| {
                found.add(triangle.map(|v| positions[v as usize]));
            });
        }
        let area: f64 = found.iter().map(|found| found.area).sum();
        let mut materials = Vec::new();
        for (index, (material, found)) in manifest.materials.iter().zip(&found).enumerate() {
            let placed = found.triangles > 0;
            materials.push(MaterialSummary {
                name: material.name.clone(),
                furred: material.furred,
                textured: material.base_color_texture.is_some(),
                color: color(package, index)?,
                triangles: found.triangles,
                share: if area > 0.0 { found.area / area } else { 0.0 },
                from_m: placed.then_some(found.from.to_array()),
                to_m: placed.then_some(found.to.to_array()),
            });
        }
        let joints =
            animation.iter().flat_map(|a| a.joints.iter().map(|joint| a.nodes[joint.node as usize].name.clone()));
        let clips = animation.iter().flat_map(|a| &a.clips);
        let morphs = animation.iter().flat_map(|a| &a.morphs.targets);
        Ok(Self {
            size_m: size::sides_m(&manifest.bounds),
            materials,
            joint_names: joints.collect(),
            clips: clips.map(|clip| ClipSummary { name: clip.name.clone(), seconds: clip.duration_s }).collect(),
            morphs: morphs.map(|morph| MorphSummary { name: morph.name.clone(), weight: morph.weight }).collect(),
        })
    }

    /// Passes the anatomy to `row`, as rows of a name and a text.
    pub fn rows(&self, row: &mut dyn FnMut(&str, String)) {
        row("size", format!("{} (x, y, z), at rest", size::format_sides(self.size_m)));
        for m in &self.materials {
            let furred = if m.furred { "furred" } else { "bare" };
            let textured = if m.textured { ", textured" } else { "" };
            let place = |corner: [f32; 3]| size::format_lengths(corner.map(f64::from)).join(" ");
            let where_ = match m.from_m.zip(m.to_m) {
                Some((from, to)) => format!("from {} to {} m", place(from), place(to)),
                None => "nowhere".to_owned(),
            };
            let (share, color) = (100.0 * m.share, &m.color);
            row(
                "material",
                format!(
                    "{:?}, {furred}, {color}{textured}, {} triangles, {share:.1} % of the surface, {where_}",
                    m.name, m.triangles
                ),
            );
        }
        if !self.joint_names.is_empty() {
            row("joints", format!("{}: {}", self.joint_names.len(), self.joint_names.join(", ")));
        }
        for clip in &self.clips {
            row("clip", format!("{:?}, {:.3} s", clip.name, clip.seconds));
        }
        for morph in &self.morphs {
            row("morph target", format!("{:?}, weight {} at rest", morph.name, f64::from(morph.weight)));
        }
    }
}

/// Number, area and bounding box of a material's triangles, at rest.
struct MaterialBounds {
    triangles: u64,
    area: f64,
    from: Vec3,
    to: Vec3,
}

impl Default for MaterialBounds {
    fn default() -> Self {
        Self { triangles: 0, area: 0.0, from: Vec3::INFINITY, to: Vec3::NEG_INFINITY }
    }
}

impl MaterialBounds {
    fn add(&mut self, [a, b, c]: [Vec3; 3]) {
        self.triangles += 1;
        self.area += (b - a).as_dvec3().cross((c - a).as_dvec3()).length() / 2.0;
        (self.from, self.to) = (self.from.min(a).min(b).min(c), self.to.max(a).max(b).max(c));
    }
}

/// Returns the mean base colour, `#rrggbb` in sRGB.
fn color(package: &Package<'_>, material: usize) -> Result<String, FormatError> {
    let [r, g, b, _] = package.manifest().materials[material].base_color;
    let mut mean = Vec3::new(r, g, b);
    if let Some(view) = package.base_color_texture(material)? {
        // The last mipmap level is the mean of all texels. If the texture cannot be decoded, the base colour factor is
        // used alone.
        let texels = decode_texture(&view, view.levels - 1, 0).unwrap_or_else(|_| vec![255; 4]);
        mean *= Vec3::new(srgb_to_linear(texels[0]), srgb_to_linear(texels[1]), srgb_to_linear(texels[2]));
    }
    let [r, g, b] = mean.to_array().map(linear_to_srgb);
    Ok(format!("#{r:02x}{g:02x}{b:02x}"))
}
