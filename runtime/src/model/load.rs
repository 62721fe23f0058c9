//! Creation of a model from a package.

use super::bounds::ModelBounds;
use super::resources::{Fins, Model, MorphBuffers, Part, Resources, VaryingAttributes};
use super::upload::Uploader;
use super::{contours, ink, painting, strands};
use crate::error::RuntimeError;
use crate::gpu::{Gpu, SamplerSettings};
use crate::params::RendererOptions;
use crate::shared::environment::pack_openness;
use crate::shared::scattering::Fibre;
use crate::surface::{FibreBlock, FibreResources, HairViews, MaterialUniform, Surfaces};
use pelage_formats::meaning::openness::Openness;
use pelage_formats::{
    AttributeVertex, FinsView, Manifest, MeshView, Package, Part as PackagePart, ROOT_HEIGHTS, RootOffset, RootsInfo,
    SimplifiedView, TextureView,
};
use std::ops::Range;
use std::sync::Arc;

/// Uploads a package directly from the slices that it borrows, without a copy.
pub(crate) fn load(
    gpu: &Gpu,
    options: &RendererOptions,
    surfaces: &Surfaces,
    package: &Package<'_>,
) -> Result<Model, RuntimeError> {
    let manifest = package.manifest();
    let uploader = Uploader { gpu, package };
    let mesh = package.mesh()?.ok_or_else(|| uploader.content("mesh".into(), "there is none, expected one".into()))?;
    if mesh.index_count == 0 {
        return Err(uploader.content("mesh".into(), "it has no triangles, expected at least one".into()));
    }
    let animation = package.animation()?;
    let skinned = !mesh.skin.is_empty();

    use wgpu::BufferUsages as Usage;
    let fins = package.fins()?.filter(|fins| fins.count > 0 && surfaces.fins.is_some());
    let single = surfaces.strands && (package.strands()?.is_some() || !package.hair_groups()?.is_empty());
    // Compute shaders also read both vertex streams: they pose the surface, lean fur and place the roots of hair.
    let geometry = uploader.buffer("geometry", mesh.geometry, Usage::VERTEX | Usage::STORAGE)?;
    let opened = package.openness()?.map(|openness| with_openness(mesh.attributes, openness));
    let stream = opened.as_deref().unwrap_or(mesh.attributes);
    let attributes = uploader.buffer("attributes", stream, Usage::VERTEX | Usage::STORAGE)?;
    let bare_normals = package.bare_normals()?;
    let bare_normals = bare_normals.map(|bytes| uploader.buffer("bare normals", bytes, Usage::VERTEX)).transpose()?;
    let skin = if skinned { Some(uploader.buffer("skin", mesh.skin, Usage::STORAGE)?) } else { None };
    let morphs = package.morphs()?.filter(|morphs| skinned && !morphs.deltas.is_empty());
    let morph_buffers = match &morphs {
        Some(morphs) => Some(MorphBuffers {
            first: uploader.buffer("morph targets", bytemuck::cast_slice(&morphs.first), Usage::STORAGE)?,
            deltas: uploader.buffer("morph deltas", bytemuck::cast_slice(&morphs.deltas), Usage::STORAGE)?,
        }),
        None => None,
    };
    let simplified = package.simplified()?;
    let lists = [mesh.indices, simplified.map_or(&[][..], |lists| lists.indices)].concat();
    let indices = uploader.buffer("indices", &lists, Usage::INDEX)?;
    let of_morphs = morph_buffers.iter().flat_map(|m| [&m.first, &m.deltas]).map(Some);
    let buffers = [Some(&geometry), Some(&attributes), bare_normals.as_ref(), skin.as_ref(), Some(&indices)];
    let buffers = buffers.into_iter().chain(of_morphs);
    let mut gpu_bytes: u64 = buffers.flatten().map(wgpu::Buffer::size).sum();

    let sampler = |label, v, anisotropy| {
        let sampling = SamplerSettings::new(label, wgpu::AddressMode::Repeat);
        SamplerSettings { v, anisotropy, ..sampling }.make(&gpu.device)
    };

    let hair = hair(&uploader, package, &mut gpu_bytes)?;
    let planar_directions = hair.as_ref().is_some_and(|(_, planar)| *planar);
    let shell_sampler = sampler("pelage shells", wgpu::AddressMode::Repeat, 1);
    let fur = hair.as_ref().map(|(views, _)| surfaces.fur_group(gpu, views, &shell_sampler));
    let knows_visibility = hair.as_ref().is_some_and(|(views, _)| views.visibility[0].is_some());
    let fin_resources = match (fins, package.fin_textures()?, &manifest.fur.fins) {
        (Some(view), Some(textures), Some(info)) => {
            let dry = uploader.hair(info.color_texture, info.direction_texture, &textures)?;
            let visibility = hair.map_or([None, None], |(views, _)| views.visibility);
            // Clamp, because the row of texels at the skin must not repeat above the tips.
            let clamp = sampler("pelage fins", wgpu::AddressMode::ClampToEdge, 1);
            let buffer = uploader.buffer("fins", view.fins, Usage::STORAGE)?;
            gpu_bytes += uploader.hair_bytes(&textures) + buffer.size();
            Some(Fins {
                buffer,
                textures: surfaces.fur_group(gpu, &HairViews { dry, wet: None, visibility }, &clamp),
                planar_directions: textures.direction.format.components() == 2,
            })
        }
        _ => None,
    };
    let mut fin_ends = fins.iter().flat_map(FinsView::part_counts).scan(0, |end, count| {
        *end += count;
        Some(*end)
    });

    let strands = if single { strands::load(&uploader, package, &mesh, options.max_strands)? } else { Vec::new() };
    gpu_bytes += strands.iter().map(strands::StrandSet::gpu_bytes).sum::<u64>();
    let base_sampler = sampler("pelage base colour", wgpu::AddressMode::Repeat, options.anisotropy);
    let fibres = package.fibres()?;
    let scattering = match (&fibres, package.fibre_tables()?) {
        (Some(info), Some(view)) => {
            gpu_bytes += uploader.device_bytes(&view) + size_of::<FibreBlock>() as u64;
            let each: Vec<Fibre> =
                info.fibres.iter().zip(&info.means).map(|(of, means)| Fibre::new(of, means)).collect();
            FibreResources::new(gpu, uploader.array(info.texture, &view)?, &each)
        }
        _ => surfaces.no_fibres.clone(),
    };
    // Materials may share textures; each is uploaded once.
    let mut uploaded = vec![None; manifest.textures.len()];
    let mut materials = Vec::new();
    let roots = package.roots()?;
    let hair_colors = package.hair_colors()?;
    let hair_color = |material: usize| hair_colors.get(material).copied().flatten();
    let gloss = package.gloss()?;
    let gloss_of = |material: usize| gloss.get(material).copied().flatten();
    for (i, material) in manifest.materials.iter().enumerate() {
        let mut view = |index: Option<u32>, texture: Option<TextureView<'_>>| {
            let (Some(index), Some(texture)) = (index, texture) else { return Ok(surfaces.white.clone()) };
            if let Some(Some(shared)) = uploaded.get(index as usize) {
                return Ok(wgpu::TextureView::clone(shared));
            }
            gpu_bytes += uploader.device_bytes(&texture);
            let made = uploader.texture(index, &texture)?.create_view(&wgpu::TextureViewDescriptor::default());
            uploaded[index as usize] = Some(made.clone());
            Ok::<_, RuntimeError>(made)
        };
        let base_color = view(material.base_color_texture, package.base_color_texture(i)?)?;
        let groom = view(material.groom_texture, package.groom_texture(i)?)?;
        let uniform = MaterialUniform {
            base_color: material.base_color,
            alpha_cutoff: material.alpha_cutoff.unwrap_or(0.0),
            share_per_m: if manifest.fur.height_m > 0.0 { manifest.fur.height_m.recip() } else { 0.0 },
            horizon: package.visibility()?.map_or(1.0, |info| info.horizon),
            rim: rim_sine(manifest),
            hair_tiles: manifest.fur.height_m / manifest.fur.tile_size_m.max(f32::MIN_POSITIVE),
            reserved: [0.0; 2],
            hair_color: hair_color(i).map_or([0.0; 4], |[r, g, b]| [r, g, b, 0.0]),
            gloss: gloss_of(i)
                .map_or([0.0; 4], |of| [of.roughness, of.reflectance, of.metalness, f32::from(u8::from(of.wet))]),
            fibre: fibres.as_ref().and_then(|info| info.of_materials.get(i)).copied().unwrap_or(0).into(),
            asides: root_offsets(roots.as_ref(), i),
        };
        gpu_bytes += size_of::<MaterialUniform>() as u64;
        materials.push(surfaces.material_group(gpu, &uniform, &base_color, &base_sampler, &groom, &scattering));
    }

    let mut parts: Vec<Part> = Vec::new();
    let (mut previous, mut first_fin) = (None, 0);
    let ranges = index_ranges(manifest, &mesh, simplified.as_ref());
    for (number, (part, indices)) in manifest.parts.iter().zip(ranges).enumerate() {
        let hairs: Vec<Range<u32>> = strands.iter().map(|strands| strands.of_parts[number].clone()).collect();
        let fins = first_fin..fin_ends.next().unwrap_or(first_fin);
        first_fin = fins.end;
        if part.index_count == 0 && fins.is_empty() {
            continue;
        }
        // Adjacent parts with the same material become one draw.
        match parts.last_mut() {
            Some(last) if previous == Some(part.material) => {
                last.indices.iter_mut().zip(indices).for_each(|(last, next)| last.end = next.end);
                last.fins.end = fins.end;
                last.strands.iter_mut().zip(hairs).for_each(|(last, next)| last.end = next.end);
            }
            _ => {
                let material = &manifest.materials[part.material as usize];
                parts.push(Part {
                    indices,
                    fins,
                    strands: hairs,
                    material: materials[part.material as usize].clone(),
                    has_texture: material.base_color_texture.is_some(),
                    at_root: uv_per_tile(roots.as_ref(), part.material as usize) > 0.0,
                    has_hair_color: hair_color(part.material as usize).is_some(),
                    has_groom_texture: material.groom_texture.is_some(),
                    glossy: gloss_of(part.material as usize).is_some(),
                    cutout: material.alpha_cutoff.is_some(),
                    furred: material.furred && fur.is_some(),
                    double_sided: material.double_sided,
                });
            }
        }
        previous = Some(part.material);
    }

    let (ink, ink_bytes) = ink::load(&uploader, package, &mesh)?.unzip();
    gpu_bytes += ink_bytes.unwrap_or(0);
    let (painting, painting_bytes) = painting::load(&uploader, package)?.unzip();
    gpu_bytes += painting_bytes.unwrap_or(0);
    let contours = if surfaces.contours { contours::load(&uploader, package, &mesh)? } else { None };
    gpu_bytes += contours.as_ref().map_or(0, |contours| contours.mesh.size());
    let varies = VaryingAttributes::of(&mesh, manifest.fur.height_m);
    let has_skeleton = animation.is_some();
    let resources = Resources {
        animation,
        geometry,
        attributes,
        bare_normals,
        skin,
        morphs: morph_buffers,
        indices,
        fur,
        fins: fin_resources,
        strands,
        colliders: package.hair_motion()?.map_or_else(Vec::new, |motion| motion.colliders.clone()),
        planar_directions,
        knows_visibility,
        fibres,
        varies,
        extent: ModelBounds::of(&mesh, morphs.as_deref(), skinned && has_skeleton),
        parts,
        deviations_m: simplified.iter().flat_map(SimplifiedView::deviations).collect(),
        layer_opacities: layer_opacities(package)?,
        ink,
        painting,
        contours,
        gpu_bytes,
    };
    Ok(Model { manifest: Arc::new(manifest.clone()), resources: Arc::new(resources) })
}

/// Returns the sine of the angle behind a body's outline up to which the tips of its fur are lit. For hair of height h
/// on a body of radius R, that sine is √(2 h / R). The radius is estimated from the bounding box, for a body that fills
/// it as animals do.
fn rim_sine(manifest: &Manifest) -> f32 {
    const OF_SIZE: f32 = 2.53;
    let bounds = &manifest.bounds;
    let sides: [f32; 3] = std::array::from_fn(|i| bounds.max[i] - bounds.min[i]);
    let size_m = sides.iter().product::<f32>().max(0.0).cbrt();
    (OF_SIZE * (manifest.fur.height_m / size_m.max(1e-6)).sqrt()).clamp(0.1, 0.6)
}

/// Returns the attribute stream with the openness of the body in the last two bytes of each vertex; packages store 0
/// there.
fn with_openness(attributes: &[u8], openness: &[u8]) -> Vec<u8> {
    let mut out = attributes.to_vec();
    for (vertex, of) in out.chunks_exact_mut(size_of::<AttributeVertex>()).zip(openness.chunks_exact(4)) {
        let packed = pack_openness(Openness::from_bytes([of[0], of[1], of[2], of[3]]));
        let spare = vertex.len() - packed.len();
        vertex[spare..].copy_from_slice(&packed);
    }
    out
}

/// Returns [`RootsInfo::uv_per_tile`] of a material; 0 if the package does not store it.
fn uv_per_tile(roots: Option<&RootsInfo>, material: usize) -> f32 {
    roots.and_then(|roots| roots.uv_per_tile.get(material).copied()).unwrap_or(0.0)
}

/// Returns the offsets of a material's hair from its root, by height, in the material's texture coordinates.
fn root_offsets(roots: Option<&RootsInfo>, material: usize) -> [[f32; 4]; ROOT_HEIGHTS] {
    let scale = uv_per_tile(roots, material);
    let scaled = |aside: RootOffset| [aside.mean[0] * scale, aside.mean[1] * scale, aside.along * scale, 0.0];
    roots.map_or([[0.0; 4]; ROOT_HEIGHTS], |roots| roots.asides.map(scaled))
}

/// Returns the index ranges of each part: in the index list of the mesh, then in each simplified list. In the buffer,
/// the simplified lists follow the list of the mesh.
fn index_ranges(manifest: &Manifest, mesh: &MeshView<'_>, lists: Option<&SimplifiedView<'_>>) -> Vec<Vec<Range<u32>>> {
    let own = |part: &PackagePart| part.first_index..part.first_index + part.index_count;
    let mut ranges: Vec<_> = manifest.parts.iter().map(|part| vec![own(part)]).collect();
    let mut first = mesh.index_count;
    for list in 0..lists.map_or(0, |lists| lists.level_count as usize) {
        for (ranges, count) in ranges.iter_mut().zip(lists.into_iter().flat_map(|lists| lists.part_counts(list))) {
            ranges.push(first..first + count);
            first += count;
        }
    }
    ranges
}

/// Returns the mean opacity of each layer of hair, beginning with that of the mesh surface: the larger one of dry and
/// wet hair. It is the last mip level of the package's colours. Empty for a package without fur.
fn layer_opacities(package: &Package<'_>) -> Result<Vec<f32>, RuntimeError> {
    let Some(dry) = package.fur_textures()? else { return Ok(Vec::new()) };
    let wet = package.wet_textures()?;
    let mean = |colors: &TextureView<'_>, layer: u32| {
        let texels = colors.rgba8(colors.levels - 1, layer).unwrap_or_default();
        let sum: f32 = texels.chunks_exact(4).map(|texel| f32::from(texel[3])).sum();
        sum / (255.0 * (texels.len() / 4).max(1) as f32)
    };
    let colors = [Some(&dry.color), wet.as_ref().map(|wet| &wet.color)];
    let largest = |layer| colors.iter().flatten().map(|colors| mean(colors, layer)).fold(0.0, f32::max);
    Ok((0..package.manifest().fur.layers).map(largest).collect())
}

/// Uploads the hair textures. The boolean is true if the direction textures have two components instead of three.
/// Returns `None` for a package without fur.
fn hair(
    uploader: &Uploader<'_>,
    package: &Package<'_>,
    gpu_bytes: &mut u64,
) -> Result<Option<(HairViews, bool)>, RuntimeError> {
    let Some(textures) = package.fur_textures()? else { return Ok(None) };
    let info = &package.manifest().fur;
    let planar = textures.direction.format.components() == 2;
    *gpu_bytes += uploader.hair_bytes(&textures);
    let dry = uploader.hair(info.color_texture, info.direction_texture, &textures)?;
    let wet = match (&info.wet, package.wet_textures()?) {
        (Some(wet), Some(textures)) => {
            *gpu_bytes += uploader.hair_bytes(&textures);
            if (textures.direction.format.components() == 2) != planar {
                let reason = "dry and wet hair have direction formats with different numbers of components, expected \
                     the same format for both";
                return Err(uploader.content("fur.wet".into(), reason.into()));
            }
            Some(uploader.hair(wet.color_texture, wet.direction_texture, &textures)?)
        }
        _ => None,
    };
    let mut visibility = [None, None];
    if let (Some(info), Some(textures)) = (package.visibility()?, package.visibility_textures()?) {
        let found = [(Some(info.texture), Some(textures.dry)), (info.wet_texture, textures.wet)];
        for (view, found) in visibility.iter_mut().zip(found) {
            if let (Some(index), Some(texture)) = found {
                *gpu_bytes += uploader.device_bytes(&texture);
                *view = Some(uploader.array(index, &texture)?);
            }
        }
    }
    Ok(Some((HairViews { dry, wet, visibility }, planar)))
}
