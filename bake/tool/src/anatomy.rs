//! Size, materials, joints and clips of a model, read from its package. `bake` and `inspect` show them.

use super::material_color::{ColoredTriangle, MaterialColor, material_colors};
use glam::{Vec2, Vec3};
use pelage_bake::recipe::Recipe;
use pelage_bake::stages::size;
use pelage_formats::meaning::posed_vertices;
use pelage_formats::{FormatError, Package, Part, Pose};
use pelage_params::glob;
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
    /// Pattern of `model.bare` that makes the material bare; null for a furred material.
    bare_by: Option<String>,
    /// Whether the material has a texture of its own.
    textured: bool,
    /// Mean base colour over the material's surface, encoded as sRGB `#rrggbb`: factor, texture and vertex colours,
    /// without `color.gain`.
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
    /// Fails with errors of damaged sections.
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
        let attributes: Vec<_> = mesh.iter().flat_map(pelage_formats::MeshView::attributes).collect();
        let mut found: Vec<MaterialBounds> = manifest.materials.iter().map(|_| MaterialBounds::default()).collect();
        let corners = |part: &Part| {
            let range = part.first_index as usize..(part.first_index + part.index_count) as usize;
            indices.get(range).unwrap_or_default().as_chunks::<3>().0
        };
        let placed = |triangle: &[u32; 3]| triangle.map(|v| positions[v as usize]);
        for part in &manifest.parts {
            corners(part).iter().for_each(|triangle| found[part.material as usize].add(placed(triangle)));
        }
        let colored = |triangle: &[u32; 3]| {
            let corners = triangle.map(|v| attributes[v as usize]);
            ColoredTriangle {
                area: area(placed(triangle)),
                uvs: corners.map(|corner| Vec2::from(corner.base_uv)),
                colors: corners.map(|corner| Vec3::from([0, 1, 2].map(|i| f32::from(corner.color[i]) / 255.0))),
            }
        };
        let of_material = |material: usize| {
            let parts = manifest.parts.iter().filter(move |part| part.material as usize == material);
            parts.flat_map(corners).map(colored)
        };
        let areas: Vec<f64> = found.iter().map(|found| found.area).collect();
        let whole: f64 = areas.iter().sum();
        // The recipe of a package from another version may be unreadable.
        let recipe = Recipe::parse_recorded("recipe", &manifest.recipe).unwrap_or_default();
        let colors = material_colors(package, &recipe, &areas, of_material)?;
        let mut materials = Vec::new();
        for ((material, found), MaterialColor { hex, textured }) in manifest.materials.iter().zip(&found).zip(colors) {
            let placed = found.triangles > 0;
            // Materials that the bake has split are named "whole/part".
            let names = || std::iter::once(&*material.name).chain(material.name.split('/'));
            let bare = recipe.model.bare.iter().flatten().find(|pattern| names().any(|name| glob(pattern, name)));
            materials.push(MaterialSummary {
                name: material.name.clone(),
                furred: material.furred,
                bare_by: bare.filter(|_| !material.furred).cloned(),
                textured,
                color: hex,
                triangles: found.triangles,
                share: if whole > 0.0 { found.area / whole } else { 0.0 },
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
            let furred = match &m.bare_by {
                _ if m.furred => "furred".to_owned(),
                Some(pattern) => format!("bare (model.bare has {pattern:?})"),
                None => "bare".to_owned(),
            };
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
    fn add(&mut self, triangle: [Vec3; 3]) {
        self.triangles += 1;
        self.area += area(triangle);
        let [a, b, c] = triangle;
        (self.from, self.to) = (self.from.min(a).min(b).min(c), self.to.max(a).max(b).max(c));
    }
}

fn area([a, b, c]: [Vec3; 3]) -> f64 {
    (b - a).as_dvec3().cross((c - a).as_dvec3()).length() / 2.0
}
