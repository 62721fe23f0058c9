//! What a model consists of, read from its package: how large it is, its materials and where they are, its joints and clips. What `bake` and `inspect`
//! say of it.

use glam::Vec3;
use pelage_bake::stages::size;
use pelage_bake::stages::textures::decode_texture;
use pelage_formats::meaning::{linear_to_srgb, posed_vertices, srgb_to_linear};
use pelage_formats::{FormatError, Package, Pose};
use serde_json::{Value, json};

/// Says of a package's model: `size_m`, `materials`, `joint_names`, `clips`, `morphs`.
///
/// # Errors
///
/// Those of damaged sections.
pub fn anatomy(package: &Package<'_>) -> Result<Value, FormatError> {
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
    let mut found: Vec<Found> = manifest.materials.iter().map(|_| Found::default()).collect();
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
        materials.push(json!({
            "name": material.name,
            "furred": material.furred,
            "textured": material.base_color_texture.is_some(),
            "color": color(package, index)?,
            "triangles": found.triangles,
            "share": if area > 0.0 { found.area / area } else { 0.0 },
            "from_m": placed.then_some(found.from.to_array()),
            "to_m": placed.then_some(found.to.to_array()),
        }));
    }
    let joints = animation.iter().flat_map(|a| a.joints.iter().map(|joint| a.nodes[joint.node as usize].name.as_str()));
    let clips = animation.iter().flat_map(|a| &a.clips);
    let morphs = animation.iter().flat_map(|a| &a.morphs.targets);
    Ok(json!({
        "size_m": size::sides_m(&manifest.bounds),
        "materials": materials,
        "joint_names": joints.collect::<Vec<_>>(),
        "clips": clips.map(|clip| json!({ "name": clip.name, "seconds": clip.duration_s })).collect::<Vec<_>>(),
        "morphs": morphs.map(|morph| json!({ "name": morph.name, "weight": morph.weight })).collect::<Vec<_>>(),
    }))
}

/// The triangles of a material, at rest.
struct Found {
    triangles: u64,
    area: f64,
    from: Vec3,
    to: Vec3,
}

impl Default for Found {
    fn default() -> Self {
        Self { triangles: 0, area: 0.0, from: Vec3::INFINITY, to: Vec3::NEG_INFINITY }
    }
}

impl Found {
    fn add(&mut self, [a, b, c]: [Vec3; 3]) {
        self.triangles += 1;
        self.area += (b - a).as_dvec3().cross((c - a).as_dvec3()).length() / 2.0;
        (self.from, self.to) = (self.from.min(a).min(b).min(c), self.to.max(a).max(b).max(c));
    }
}

/// The mean base colour, `#rrggbb` in sRGB.
fn color(package: &Package<'_>, material: usize) -> Result<String, FormatError> {
    let [r, g, b, _] = package.manifest().materials[material].base_color;
    let mut mean = Vec3::new(r, g, b);
    if let Some(view) = package.base_color_texture(material)? {
        // The last level is the mean of all texels. One that does not decode leaves the factor.
        let texels = decode_texture(&view, view.levels - 1, 0).unwrap_or_else(|_| vec![255; 4]);
        mean *= Vec3::new(srgb_to_linear(texels[0]), srgb_to_linear(texels[1]), srgb_to_linear(texels[2]));
    }
    let [r, g, b] = mean.to_array().map(linear_to_srgb);
    Ok(format!("#{r:02x}{g:02x}{b:02x}"))
}

/// The same in lines of two columns: what it is about, and what there is to say.
pub fn rows(anatomy: &Value, row: &mut dyn FnMut(&str, String)) {
    let text = |v: &Value| v.as_str().unwrap_or_default().to_owned();
    let list = |key: &str| anatomy[key].as_array().cloned().unwrap_or_default();
    let number = |v: &Value| v.as_f64().unwrap_or(0.0);
    let place = |v: &Value| size::lengths([0, 1, 2].map(|axis| number(&v[axis]))).join(" ");
    let sides = [0, 1, 2].map(|axis| number(&anatomy["size_m"][axis]));
    row("size", format!("{} (x, y, z), at rest", size::words(sides)));
    for m in list("materials") {
        let furred = if m["furred"] == true { "furred" } else { "bare" };
        let textured = if m["textured"] == true { ", textured" } else { "" };
        let where_ = if m["from_m"].is_null() {
            "nowhere".to_owned()
        } else {
            format!("from {} to {} m", place(&m["from_m"]), place(&m["to_m"]))
        };
        row(
            "material",
            format!(
                "{:?}, {furred}, {}{textured}, {} triangles, {:.1} % of the surface, {where_}",
                text(&m["name"]),
                text(&m["color"]),
                m["triangles"],
                100.0 * number(&m["share"]),
            ),
        );
    }
    let joints: Vec<String> = list("joint_names").iter().map(text).collect();
    if !joints.is_empty() {
        row("joints", format!("{}: {}", joints.len(), joints.join(", ")));
    }
    for clip in list("clips") {
        row("clip", format!("{:?}, {:.3} s", text(&clip["name"]), number(&clip["seconds"])));
    }
    for morph in list("morphs") {
        row("morph target", format!("{:?}, at {} at rest", text(&morph["name"]), number(&morph["weight"])));
    }
}
