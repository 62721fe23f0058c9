//! Prediction, without a GPU, of a package's rendering cost, and of detail beyond what the screen can show.
//!
//! Every triangle of the surface, and every layer and fin that the runtime would draw at rest by default, is rasterised
//! ([`raster`]) and counted. The prediction is an amount of work: fragments, vertices, bytes. The time for it depends
//! on the adapter; `pelage bench` measures that.
//!
//! Advice names harmless savings, and improvements of the look for views that are too close. This module judges
//! harmlessness only by sizes on the screen. A caller with an adapter renders the picture before and after the change,
//! compares both with the reference image, and drops advice that fails [`is_harmless`].

mod advice;
mod fit;
mod prognosis;
pub mod raster;

pub use advice::is_harmless;
pub use fit::fitted;
pub use prognosis::{Advice, ErrorChange, Memory, OnScreen, PassWork, Prognosis, PrognosisView, Saved};

use glam::{Mat4, Vec2, Vec3, Vec4};
use pelage_formats::meaning::planting::{PlantingMesh, Roots, SurfaceWalk};
use pelage_formats::meaning::{
    TOTAL_MAP_LAYERS, detail_count, detail_layer, detail_pairs, detail_position, fin_face, fin_opacity, fin_rows,
    hair_offset, layer_height, posed_vertices, row_heights, simplest_list, tile_frame, view_axes,
};
use pelage_formats::{FormatError, MeshView, Package, Part, Pose, StrandsView};
use pelage_import::BakeError;
use raster::{DrawMode, PixelCounts, Raster};

/// Maximum number of pixels rasterised. Larger pictures are rasterised at a smaller size, and the counts are scaled.
const MOST_PIXELS: u64 = 1 << 20;

/// Area, pixels, below which a triangle's vertices cost more than its pixels.
const SMALL_PX: f64 = 16.0;

/// A posed vertex with its fur.
struct Vertex {
    position: Vec3,
    normal: Vec3,
    bitangent: Vec3,
    height_m: f32,
    lean: f32,
}

impl Vertex {
    /// Returns a point of the hair at this vertex; `share` is its height as a fraction of the fur's height.
    fn at(&self, share: f32) -> Vec3 {
        self.position + hair_offset(self.normal, self.bitangent, self.lean, share, self.height_m)
    }
}

/// Predicts the rendering cost of an opened package and collects advice.
///
/// * `fault`: converts an error of the package; adds the file name
///
/// Fails with [`BakeError::Package`] for damaged sections. [`BakeError::Params`] if eye and target of the camera
/// coincide.
pub fn diagnose(
    package: &Package<'_>,
    view: &PrognosisView,
    fault: &dyn Fn(FormatError) -> BakeError,
) -> Result<Prognosis, BakeError> {
    let manifest = package.manifest();
    let fur = &manifest.fur;
    let vertices = vertices(package, fault)?;
    let layers = if fur.layers < 2 { 1 } else { fur.layers };
    let indices: Vec<u32> = package.mesh().map_err(fault)?.map_or_else(Vec::new, |mesh| mesh.indices().collect());
    let mut furred = vec![false; vertices.len()];
    for part in manifest.parts.iter().filter(|part| manifest.materials[part.material as usize].furred && layers > 1) {
        triangles(&indices, part).flatten().for_each(|i| furred[i as usize] = true);
    }
    let near = NearestFur::of(&vertices, &furred, view);
    let drawn = drawn_layers(manifest, near.height_px);
    let lists = drawn_lists(package, indices, near.px_per_m, fault)?;
    let (raster_size, scale) = raster_size(view.size);
    let clip_from_world = camera(view)?;
    let clip = |p: Vec3| clip_from_world * p.extend(1.0);
    let mut raster = Raster::new(raster_size.0, raster_size.1);

    let mut skin = PixelCounts::default();
    let mut areas = Vec::new();
    for (part, list) in manifest.parts.iter().zip(&lists) {
        let both = manifest.materials[part.material as usize].double_sided;
        for t in corners(list) {
            let corners = t.map(|i| clip(vertices[i as usize].position));
            let found = raster.draw(corners, both, DrawMode::Opaque);
            skin = sum(skin, found);
            if found.pixels > 0 || on_screen(corners) {
                areas.push(area_px(corners, view.size));
            }
        }
    }
    let mut shells = PixelCounts::default();
    let mut shell_vertices = vec![false; vertices.len()];
    for (part, list) in manifest.parts.iter().zip(&lists) {
        let material = &manifest.materials[part.material as usize];
        if !material.furred {
            continue;
        }
        let both = material.double_sided;
        list.iter().for_each(|i| shell_vertices[*i as usize] = true);
        for layer in &drawn {
            let share = layer_height(*layer, layers);
            let place: Vec<Vec4> = vertices.iter().map(|v| clip(v.at(share))).collect();
            for t in corners(list) {
                shells = sum(shells, raster.draw(t.map(|i| place[i as usize]), both, DrawMode::Layer));
            }
        }
    }
    let (fins, fin_quads) = fins(package, &vertices, view, &clip, &mut raster, fault)?;

    let furry_vertices = shell_vertices.iter().filter(|f| **f).count() as u64;
    let on_screen = sizes(manifest, &near, drawn.len(), &mut areas);
    let memory = memory(package, view, layers, fault)?;
    let times = f64::from(view.instances) * scale;
    let passes = passes(&PassInput {
        manifest,
        vertices: vertices.len() as u64,
        furry_vertices,
        layers,
        drawn: drawn.len() as u64,
        fin_quads,
        skin,
        fins,
        shells,
        times,
        view,
        skinned: memory.posed > 0,
        knows_visibility: package.visibility().map_err(fault)?.is_some(),
        single: package.strands().map_err(fault)?.is_some(),
    });
    let (furry_pixels, mean, most) = raster.layers();
    let scaled = |count: u64| (count as f64 * scale).round() as u64;
    let mut prognosis = Prognosis {
        covered_pixels: [scaled(raster.opaque_pixels()), scaled(furry_pixels)],
        overdraw: (mean, most),
        passes,
        memory,
        on_screen,
        advice: Vec::new(),
    };
    prognosis.advice = advice::advise(package, view, &prognosis, fault)?;
    Ok(prognosis)
}

fn sum(a: PixelCounts, b: PixelCounts) -> PixelCounts {
    PixelCounts { pixels: a.pixels + b.pixels, in_blocks: a.in_blocks + b.in_blocks }
}

/// Returns the layers that the package's levels of detail select for fur that is `height_px` pixels high.
fn drawn_layers(manifest: &pelage_formats::Manifest, height_px: f64) -> Vec<u32> {
    let baked = manifest.fur.layers;
    let (place, fade) = detail_position(&manifest.detail, height_px as f32);
    let Some(level) = manifest.detail.get(place) else { return (1..baked).collect() };
    if level.step == 0 {
        return Vec::new();
    }
    let next = manifest.detail.get(place + 1).map_or(0, |next| next.step);
    let gone = if next == 0 { 0.0 } else { fade * detail_pairs(baked, level.step) as f32 };
    let count = detail_count(baked, level.step) - gone as u32;
    (0..count).map(|index| detail_layer(index, baked, level.step, gone)).collect()
}

/// Returns the indices that are drawn for each part at `px_per_m` pixels per metre: those of the mesh, or of a
/// simplified list.
fn drawn_lists(
    package: &Package<'_>,
    indices: Vec<u32>,
    px_per_m: f64,
    fault: &dyn Fn(FormatError) -> BakeError,
) -> Result<Vec<Vec<u32>>, BakeError> {
    let parts = &package.manifest().parts;
    let simplified = package.simplified().map_err(fault)?;
    let deviations: Vec<f32> = simplified.iter().flat_map(pelage_formats::SimplifiedView::deviations).collect();
    let simplest = simplest_list(&deviations, px_per_m as f32);
    let Some((lists, list)) = simplified.zip(simplest.checked_sub(1)) else {
        return Ok(parts.iter().map(|part| triangles(&indices, part).flatten().collect()).collect());
    };
    let before: u32 = (0..list).flat_map(|list| lists.part_counts(list)).sum();
    let mut rest = lists.indices().skip(before as usize);
    Ok(lists.part_counts(list).map(|count| rest.by_ref().take(count as usize).collect()).collect())
}

fn corners(list: &[u32]) -> impl Iterator<Item = [u32; 3]> + '_ {
    list.chunks_exact(3).map(|t| [t[0], t[1], t[2]])
}

fn triangles<'a>(indices: &'a [u32], part: &pelage_formats::Part) -> impl Iterator<Item = [u32; 3]> + 'a {
    let range = part.first_index as usize..(part.first_index + part.index_count) as usize;
    corners(indices.get(range).unwrap_or_default())
}

/// Returns the size at which to rasterise, and the number of picture pixels per rasterised pixel.
fn raster_size((width, height): (u32, u32)) -> ((u32, u32), f64) {
    let pixels = u64::from(width) * u64::from(height);
    let shrink = (pixels as f64 / MOST_PIXELS as f64).sqrt().max(1.0);
    let small = [width, height].map(|side| ((f64::from(side) / shrink) as u32).max(1));
    ((small[0], small[1]), pixels as f64 / f64::from(small[0]) / f64::from(small[1]))
}

/// Returns the matrix from world to clip space; w is the distance along the view.
fn camera(view: &PrognosisView) -> Result<Mat4, BakeError> {
    let forward = (view.target - view.eye).try_normalize().ok_or_else(|| BakeError::Params {
        what: "camera",
        reason: format!("eye and target are both at {}, expected different points", view.eye),
    })?;
    let aspect = view.size.0 as f32 / view.size.1 as f32;
    let [right, up, _] = view_axes(view.eye, view.target);
    let scale = 1.0 / (0.5 * view.fov_y_rad).tan();
    let row = |axis: Vec3, scale: f32| (axis * scale).extend(-axis.dot(view.eye) * scale);
    // The z row is zero, because depth is computed from w.
    Ok(Mat4::from_cols(row(right, scale / aspect), row(up, scale), Vec4::ZERO, row(forward, 1.0)).transpose())
}

fn vertices(package: &Package<'_>, fault: &dyn Fn(FormatError) -> BakeError) -> Result<Vec<Vertex>, BakeError> {
    let Some(mesh) = package.mesh().map_err(fault)? else { return Ok(Vec::new()) };
    let mut pose = Pose::default();
    if let Some(animation) = package.animation().map_err(fault)? {
        pose.sample(&animation, None, 0.0);
    }
    let vertex = |v: pelage_formats::GeometryVertex| {
        let [x, y, z, handedness] = v.tangent;
        let frame = tile_frame(v.normal.into(), Vec3::new(x, y, z), handedness);
        Vertex {
            position: v.position.into(),
            normal: frame.normal_ws,
            bitangent: frame.bitangent_ws,
            height_m: v.fur_height,
            lean: v.lean,
        }
    };
    Ok(posed_vertices(&mesh, None, &pose).map(vertex).collect())
}

/// Rasterises the fins that are visible at the current viewing angle, as the runtime does. Returns their coverage and
/// the number of quads.
fn fins(
    package: &Package<'_>,
    vertices: &[Vertex],
    view: &PrognosisView,
    clip: &dyn Fn(Vec3) -> Vec4,
    raster: &mut Raster,
    fault: &dyn Fn(FormatError) -> BakeError,
) -> Result<(PixelCounts, u64), BakeError> {
    let Some(found) = package.fins().map_err(fault)? else { return Ok((PixelCounts::default(), 0)) };
    // Bent hair needs three quads, one above the other.
    let rows = fin_rows(vertices.iter().any(|v| v.lean > 0.0));
    let mut covered = PixelCounts::default();
    for fin in found.fins() {
        let (a, b) = (&vertices[fin.a as usize], &vertices[fin.b as usize]);
        let face = fin_face(a.position, b.position, a.normal, b.normal);
        let towards_eye = (view.eye - 0.5 * (a.position + b.position)).normalize_or_zero();
        let opacity = fin.opacity * fin_opacity(face.dot(towards_eye));
        if opacity < 0.5 / 255.0 {
            continue;
        }
        for row in 0..rows {
            let [low, high] = row_heights(row, rows);
            let [a0, b0, b1, a1] = [a.at(low), b.at(low), b.at(high), a.at(high)].map(clip);
            covered = sum(covered, raster.draw([a0, b0, b1], true, DrawMode::Quad));
            covered = sum(covered, raster.draw([a0, b1, a1], true, DrawMode::Quad));
        }
    }
    Ok((covered, u64::from(found.count) * u64::from(rows)))
}

fn on_screen(corners: [Vec4; 3]) -> bool {
    corners.iter().all(|c| c.w > 0.0 && c.x.abs() <= c.w && c.y.abs() <= c.w) && area_px(corners, (1, 1)) > 0.0
}

/// Returns the area of a triangle, pixels; negative if it faces away from the eye.
fn area_px(corners: [Vec4; 3], size: (u32, u32)) -> f64 {
    let [a, b, c] = corners.map(|c| {
        let w = f64::from(c.w);
        (f64::from(c.x) / w * 0.5 * f64::from(size.0), f64::from(c.y) / w * 0.5 * f64::from(size.1))
    });
    0.5 * ((b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0))
}

/// Nearest fur to the eye.
struct NearestFur {
    /// Depth along the view, metres. If nothing is in sight, it is infinite and all other fields are 0.
    near_m: f32,
    px_per_m: f64,
    /// Height of the fur there, pixels seen from the side.
    height_px: f64,
}

impl NearestFur {
    fn of(vertices: &[Vertex], furred: &[bool], view: &PrognosisView) -> Self {
        let forward = (view.target - view.eye).normalize_or_zero();
        let furry = || vertices.iter().zip(furred).filter(|(_, f)| **f).map(|(v, _)| v);
        let depths = furry().map(|v| (v.position - view.eye).dot(forward)).filter(|z| *z > 0.0);
        let near_m = depths.fold(f32::INFINITY, f32::min);
        let px_per_m = f64::from(view.size.1) / (2.0 * f64::from(near_m) * f64::from(0.5 * view.fov_y_rad).tan());
        let highest = furry().map(|v| v.height_m).fold(0.0, f32::max);
        Self { near_m, px_per_m, height_px: f64::from(highest) * px_per_m }
    }
}

fn sizes(manifest: &pelage_formats::Manifest, near: &NearestFur, layers_drawn: usize, areas: &mut [f64]) -> OnScreen {
    let fur = &manifest.fur;
    let NearestFur { near_m, px_per_m, height_px } = *near;
    areas.sort_by(f64::total_cmp);
    OnScreen {
        texel_px: f64::from(fur.tile_size_m) * px_per_m / f64::from(fur.tile_texels.max(1)),
        layer_gap_px: height_px / f64::from(fur.layers.max(2) - 1),
        height_px,
        layers_drawn: layers_drawn as u32,
        near_m: if near_m.is_finite() { f64::from(near_m) } else { 0.0 },
        triangle_px: areas.get(areas.len() / 2).map_or(0.0, |area| area.abs()),
        small_triangles: areas.iter().filter(|area| area.abs() < SMALL_PX).count() as f64 / areas.len().max(1) as f64,
        triangles: areas.len() as u64,
    }
}

fn memory(
    package: &Package<'_>,
    view: &PrognosisView,
    layers: u32,
    fault: &dyn Fn(FormatError) -> BakeError,
) -> Result<Memory, BakeError> {
    let mut memory = Memory::default();
    for index in 0..package.manifest().textures.len() {
        memory.textures += package.texture(index as u32).map_err(fault)?.gpu_bytes();
    }
    if let Some(m) = package.mesh().map_err(fault)? {
        let skinned = package.animation().map_err(fault)?.is_some() && !m.skin.is_empty();
        let simplified = package.simplified().map_err(fault)?.map_or(0, |lists| lists.indices.len());
        memory.buffers = (m.geometry.len() + m.attributes.len() + m.indices.len() + simplified) as u64;
        if let Some(strands) = package.strands().map_err(fault)? {
            memory.strands = planted_bytes(package, &m, &strands).map_err(fault)?;
        }
        if skinned {
            let morphs = package.morphs().map_err(fault)?;
            let morphs = morphs.map_or(0, |m| size_of_val(&m.first[..]) + size_of_val(&m.deltas[..]));
            memory.buffers += (m.skin.len() + morphs) as u64;
            memory.posed = m.geometry.len() as u64 * u64::from(view.instances);
        }
    }
    memory.buffers += package.fins().map_err(fault)?.map_or(0, |f| f.fins.len() as u64);
    memory.buffers += package.ink().map_err(fault)?.map_or(0, |ink| ink.vertices.len() as u64);
    let (map, small) = (u64::from(view.shadow_map).pow(2), u64::from(view.shadow_map.div_ceil(4)).pow(2));
    // Size of the shadow maps. Each of the two depth maps has four bytes per texel. Transmittance has two bytes per
    // texel and layer, or two bytes per texel in all if the package stores visibility. The soft shadow has eight bytes
    // per texel, in one full-size map and two small ones.
    let maps = if package.visibility().map_err(fault)?.is_some() { 1 } else { u64::from(layers) };
    let layer_maps = if layers > 1 { 2 * map * maps } else { 0 };
    memory.shadow_maps = 8 * map + layer_maps + 8 * (map + 2 * small);
    Ok(memory)
}

/// Returns the size of the strands planted on the mesh, bytes.
///
/// Each strand takes 32 bytes, plus 16 per point, or twice 16 if wet hair is blended in. The number of strands of a
/// part is rounded up to a multiple of 64. The points of the tile's own strands are included.
fn planted_bytes(package: &Package<'_>, mesh: &MeshView<'_>, strands: &StrandsView<'_>) -> Result<u64, FormatError> {
    let ground = PlantingMesh::of_package(package, mesh)?;
    let walk = SurfaceWalk::new(&ground);
    let roots = Roots::new(strands.roots().zip(0..).map(|(root, i)| (Vec2::from(root).as_dvec2(), i)));
    let heights: Vec<f32> = mesh.geometry().map(|v| v.fur_height).collect();
    let in_part = |part: &Part| {
        let triangles = part.first_index as usize / 3..(part.first_index + part.index_count) as usize / 3;
        let mut count = 0u64;
        for triangle in triangles.filter(|t| walk.is_furred(*t)) {
            let tall = Vec3::from(ground.corners(triangle, &heights));
            roots.for_each_in(ground.corners(triangle, &ground.tile_uv), |_, weights| {
                count += u64::from(weights.as_vec3().dot(tall) > 0.0);
            });
        }
        count.next_multiple_of(64)
    };
    let planted: u64 = package.manifest().parts.iter().map(in_part).sum();
    let points = u64::from(strands.points_per_strand());
    let of_tile = u64::from(strands.strand_count()) * points;
    let times = strands.points().len() as u64 / of_tile.max(1);
    Ok(planted * (32 + 16 * points * times) + 16 * of_tile * times)
}

/// Input for the list of passes.
struct PassInput<'a> {
    manifest: &'a pelage_formats::Manifest,
    vertices: u64,
    furry_vertices: u64,
    layers: u32,
    /// Number of layers drawn, skin excluded.
    drawn: u64,
    fin_quads: u64,
    skin: PixelCounts,
    fins: PixelCounts,
    shells: PixelCounts,
    times: f64,
    view: &'a PrognosisView,
    skinned: bool,
    /// Whether the package stores hair-to-hair shadows.
    knows_visibility: bool,
    /// Whether the package has strands.
    single: bool,
}

fn passes(w: &PassInput<'_>) -> Vec<PassWork> {
    let copies = u64::from(w.view.instances);
    let furry = w.layers > 1 && w.furry_vertices > 0;
    let shadows = w.view.shadow_map > 0;
    let above = u64::from(w.layers - 1);
    let mapped = if w.knows_visibility { above.min(u64::from(TOTAL_MAP_LAYERS - 1)) } else { above };
    let yes_or = |runs: bool, yes: String, no: &str| if runs { yes } else { no.to_owned() };
    let pass = |name, runs: bool, reason: String, vertices: u64, covered: Option<PixelCounts>| PassWork {
        name,
        runs,
        reason,
        vertices: if runs { vertices * copies } else { 0 },
        fragments: covered.map(|c| (c.pixels as f64 * w.times).round() as u64),
        fragments_in_blocks: covered.map(|c| (c.in_blocks as f64 * w.times).round() as u64),
    };
    let size = w.view.shadow_map;
    let has_fins = w.fin_quads > 0 && furry && w.drawn > 0;
    // The predicted frame draws layers, so the passes for strands do not run.
    let of_strands = |name| {
        let reason = if w.single {
            "the prediction is for a frame drawn with layers (--hair shells)"
        } else {
            "the package has no strands"
        };
        pass(name, false, reason.into(), 0, None)
    };
    vec![
        pass("pose", w.skinned, yes_or(w.skinned, "whenever the pose changes".into(), "no skeleton"), w.vertices, None),
        pass("fur_motion", false, "the prediction is for a frame in which no hair moves".into(), 0, None),
        of_strands("strand_pose"),
        of_strands("hair_motion"),
        of_strands("hair_pose"),
        of_strands("strand_shadow"),
        pass(
            "layer_shadow",
            shadows && furry,
            match (shadows, furry) {
                (true, true) if w.knows_visibility => {
                    format!(
                        "one map of {mapped} layers, {size} x {size} texels, redrawn if light, pose or model changes"
                    )
                }
                (true, true) => {
                    format!("{mapped} maps of {size} x {size} texels, redrawn if light, pose or model changes")
                }
                (false, _) => "switched off".into(),
                (_, false) => "no fur is drawn".into(),
            },
            w.vertices + w.furry_vertices * mapped,
            None,
        ),
        pass(
            "shadow_width",
            shadows,
            yes_or(shadows, format!("{size} x {size} texels, redrawn if light, pose or model changes"), "switched off"),
            w.vertices,
            None,
        ),
        of_strands("strand_light"),
        of_strands("strand_gather"),
        pass("skin", w.vertices > 0, yes_or(w.vertices > 0, "always".into(), "no triangles"), w.vertices, Some(w.skin)),
        of_strands("strands"),
        pass(
            "fins",
            has_fins,
            yes_or(
                has_fins,
                format!("{} quads", w.fin_quads),
                if w.fin_quads > 0 && furry { "the fur is too small on screen" } else { "the package has none" },
            ),
            6 * w.fin_quads,
            Some(w.fins),
        ),
        pass(
            "shells",
            furry && w.drawn > 0,
            yes_or(
                furry && w.drawn > 0,
                format!("{} of {above} layers, {} strands in the tile", w.drawn, w.manifest.fur.strands),
                if furry {
                    "the fur is too small on screen: the skin shows the far fur layer"
                } else {
                    "the package has no fur"
                },
            ),
            w.furry_vertices * w.drawn,
            Some(w.shells),
        ),
        of_strands("strand_blend"),
    ]
}

#[cfg(test)]
#[path = "tests.rs"]
mod tests;
