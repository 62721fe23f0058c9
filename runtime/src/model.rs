//! A package on the GPU.

use crate::extent::Extent;
use crate::model_ink::{self, ModelInk};
use crate::passes::surface::{MaterialUniform, SurfaceLayouts};
use crate::{RendererOptions, RuntimeError};
use pelage_formats::{Animation, Clip, FinsView, FurTextures, Manifest, MeshView, Package, TextureFormat, TextureView};
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use wgpu::util::DeviceExt;

/// A package on the GPU: vertices, textures, materials. Cheap to clone; the clones share everything.
#[derive(Clone, Debug)]
pub struct Model(Arc<Resources>);

#[derive(Debug)]
struct Resources {
    manifest: Manifest,
    animation: Option<Animation>,
    geometry: wgpu::Buffer,
    attributes: wgpu::Buffer,
    skin: Option<wgpu::Buffer>,
    indices: wgpu::Buffer,
    fur: Option<wgpu::BindGroup>,
    fins: Option<Fins>,
    planar_directions: bool,
    varies: Varies,
    parts: Vec<Part>,
    extent: Extent,
    ink: Option<ModelInk>,
    /// Tells models apart, also from those that are gone.
    number: u64,
    gpu_bytes: u64,
}

static LOADED: AtomicU64 = AtomicU64::new(0);

/// Fins of a model.
#[derive(Debug)]
pub(crate) struct Fins {
    /// All fins, part after part.
    pub(crate) buffer: wgpu::Buffer,
    /// Their textures, in the layout of the shells'.
    pub(crate) textures: wgpu::BindGroup,
    /// The direction texture has two components.
    pub(crate) planar_directions: bool,
}

/// What varies over the vertices of a model: the shaders do nothing for what does not.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Varies {
    /// Some vertex leans more than the tile's strands.
    pub(crate) lean: bool,
    /// Some vertex is bare or wet.
    pub(crate) groom: bool,
}

impl Varies {
    fn of(mesh: &MeshView<'_>) -> Self {
        Self { lean: mesh.geometry().any(|v| v.lean > 0.0), groom: mesh.attributes().any(|v| v.groom != [0; 4]) }
    }
}

/// A range of the index buffer with one material.
#[derive(Debug)]
pub(crate) struct Part {
    pub(crate) indices: Range<u32>,
    pub(crate) fins: Range<u32>,
    pub(crate) material: wgpu::BindGroup,
    pub(crate) has_texture: bool,
    pub(crate) has_groom_texture: bool,
    pub(crate) cutout: bool,
    pub(crate) furred: bool,
    pub(crate) double_sided: bool,
}

impl Model {
    /// What the package says about itself.
    pub fn manifest(&self) -> &Manifest {
        &self.0.manifest
    }

    /// The model's motions.
    pub fn clips(&self) -> &[Clip] {
        self.0.animation.as_ref().map_or(&[], |a| &a.clips)
    }

    /// Index of the first clip of that name, for [`crate::Motion::Clip`].
    pub fn clip_index(&self, name: &str) -> Option<usize> {
        self.clips().iter().position(|c| c.name == name)
    }

    /// Bytes of its buffers and textures, shared by all instances.
    pub fn gpu_bytes(&self) -> u64 {
        self.0.gpu_bytes
    }

    /// The skeleton, where the vertices follow one.
    pub fn skeleton(&self) -> Option<&Animation> {
        self.0.animation.as_ref().filter(|_| self.0.skin.is_some())
    }

    pub(crate) fn geometry(&self) -> &wgpu::Buffer {
        &self.0.geometry
    }

    pub(crate) fn attributes(&self) -> &wgpu::Buffer {
        &self.0.attributes
    }

    pub(crate) fn skin(&self) -> Option<&wgpu::Buffer> {
        self.0.skin.as_ref()
    }

    pub(crate) fn indices(&self) -> &wgpu::Buffer {
        &self.0.indices
    }

    pub(crate) fn fur(&self) -> Option<&wgpu::BindGroup> {
        self.0.fur.as_ref()
    }

    pub(crate) fn fins(&self) -> Option<&Fins> {
        self.0.fins.as_ref()
    }

    pub(crate) fn planar_directions(&self) -> bool {
        self.0.planar_directions
    }

    pub(crate) fn varies(&self) -> Varies {
        self.0.varies
    }

    /// Fails for a model that has no ink style.
    pub(crate) fn has_ink(&self) -> Result<(), RuntimeError> {
        if self.0.ink.is_some() {
            return Ok(());
        }
        Err(RuntimeError::Content {
            package: self.manifest().model.clone(),
            what: "ink style".into(),
            reason: "there is none, expected one: bake the model again with ink.enabled = true in its recipe".into(),
        })
    }

    /// Its ink style, where the package has one.
    pub(crate) fn ink(&self) -> Option<&ModelInk> {
        self.0.ink.as_ref()
    }

    /// How far the skin reaches.
    pub(crate) fn extent(&self) -> &Extent {
        &self.0.extent
    }

    /// Tells models apart, also from those that are gone.
    pub(crate) fn number(&self) -> u64 {
        self.0.number
    }

    pub(crate) fn parts(&self) -> &[Part] {
        &self.0.parts
    }
}

/// Uploads a package, straight from the slices that it borrows.
pub(crate) fn load(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    options: &RendererOptions,
    layouts: &SurfaceLayouts,
    package: &Package<'_>,
) -> Result<Model, RuntimeError> {
    let manifest = package.manifest();
    let uploader = Uploader { device, queue, package };
    let mesh = package.mesh()?.ok_or_else(|| uploader.content("mesh".into(), "there is none, expected one".into()))?;
    if mesh.index_count == 0 {
        return Err(uploader.content("mesh".into(), "it has no triangles, expected at least one".into()));
    }
    let animation = package.animation()?;
    let skinned = !mesh.skin.is_empty();

    use wgpu::BufferUsages as Usage;
    let fins = package.fins()?.filter(|fins| fins.count > 0 && layouts.fins.is_some());
    let read = |by_shader| if by_shader { Usage::STORAGE } else { Usage::empty() };
    let geometry = uploader.buffer("geometry", mesh.geometry, Usage::VERTEX | read(skinned || fins.is_some()))?;
    let attributes = uploader.buffer("attributes", mesh.attributes, Usage::VERTEX | read(fins.is_some()))?;
    let skin = if skinned { Some(uploader.buffer("skin", mesh.skin, Usage::STORAGE)?) } else { None };
    let indices = uploader.buffer("indices", mesh.indices, Usage::INDEX)?;
    let buffers = [Some(&geometry), Some(&attributes), skin.as_ref(), Some(&indices)];
    let mut gpu_bytes: u64 = buffers.into_iter().flatten().map(wgpu::Buffer::size).sum();

    let sampler = |label, address_mode_v, anisotropy_clamp| {
        device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some(label),
            address_mode_u: wgpu::AddressMode::Repeat,
            address_mode_v,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            anisotropy_clamp,
            ..Default::default()
        })
    };

    let mut planar_directions = false;
    let fur = match package.fur_textures()? {
        None => None,
        Some(textures) => {
            planar_directions = textures.direction.format.components() == 2;
            gpu_bytes += uploader.hair_bytes(&textures);
            let hair = &manifest.fur;
            let [color, direction] = uploader.hair(hair.color_texture, hair.direction_texture, &textures)?;
            let wet = match (&hair.wet, package.wet_textures()?) {
                (Some(wet), Some(textures)) => {
                    gpu_bytes += uploader.hair_bytes(&textures);
                    if (textures.direction.format.components() == 2) != planar_directions {
                        let reason = "directions of dry and of wet hair in formats of two and of more components, expected both alike";
                        return Err(uploader.content("fur.wet".into(), reason.into()));
                    }
                    Some(uploader.hair(wet.color_texture, wet.direction_texture, &textures)?)
                }
                _ => None,
            };
            let wet = wet.as_ref().map(|[color, direction]| [color, direction]);
            Some(layouts.fur_bind_group(
                device,
                [&color, &direction],
                wet,
                &sampler("pelage shells", wgpu::AddressMode::Repeat, 1),
            ))
        }
    };
    let fin_resources = match (fins, package.fin_textures()?, &manifest.fur.fins) {
        (Some(view), Some(textures), Some(info)) => {
            let [color, direction] = uploader.hair(info.color_texture, info.direction_texture, &textures)?;
            // The skin's row must not show above the tips.
            let clamp = sampler("pelage fins", wgpu::AddressMode::ClampToEdge, 1);
            let buffer = uploader.buffer("fins", view.fins, Usage::STORAGE)?;
            gpu_bytes += uploader.hair_bytes(&textures) + buffer.size();
            Some(Fins {
                buffer,
                textures: layouts.fur_bind_group(device, [&color, &direction], None, &clamp),
                planar_directions: textures.direction.format.components() == 2,
            })
        }
        _ => None,
    };
    let mut fin_ends = fins.iter().flat_map(FinsView::part_counts).scan(0, |end, count| {
        *end += count;
        Some(*end)
    });

    let base_sampler = sampler("pelage base colour", wgpu::AddressMode::Repeat, options.anisotropy);
    // Materials may share a texture.
    let mut uploaded = vec![None; manifest.textures.len()];
    let mut materials = Vec::new();
    for (i, material) in manifest.materials.iter().enumerate() {
        let mut view = |index: Option<u32>, texture: Option<TextureView<'_>>| {
            let (Some(index), Some(texture)) = (index, texture) else { return Ok(layouts.white.clone()) };
            if let Some(Some(shared)) = uploaded.get(index as usize) {
                return Ok(wgpu::TextureView::clone(shared));
            }
            gpu_bytes += texture.gpu_bytes();
            let made = uploader.texture(index, &texture)?.create_view(&wgpu::TextureViewDescriptor::default());
            uploaded[index as usize] = Some(made.clone());
            Ok::<_, RuntimeError>(made)
        };
        let base_color = view(material.base_color_texture, package.base_color_texture(i)?)?;
        let groom = view(material.groom_texture, package.groom_texture(i)?)?;
        let uniform = MaterialUniform {
            base_color: material.base_color,
            alpha_cutoff: material.alpha_cutoff.unwrap_or(0.0),
            reserved: [0.0; 3],
        };
        gpu_bytes += size_of::<MaterialUniform>() as u64;
        materials.push(layouts.material_bind_group(device, &uniform, &base_color, &base_sampler, &groom));
    }

    let mut parts: Vec<Part> = Vec::new();
    let (mut previous, mut first_fin) = (None, 0);
    for part in &manifest.parts {
        let indices = part.first_index..part.first_index + part.index_count;
        let fins = first_fin..fin_ends.next().unwrap_or(first_fin);
        first_fin = fins.end;
        if part.index_count == 0 && fins.is_empty() {
            continue;
        }
        // Neighbours with one material are one draw.
        match parts.last_mut() {
            Some(last) if previous == Some(part.material) => {
                last.indices.end = indices.end;
                last.fins.end = fins.end;
            }
            _ => {
                let material = &manifest.materials[part.material as usize];
                parts.push(Part {
                    indices,
                    fins,
                    material: materials[part.material as usize].clone(),
                    has_texture: material.base_color_texture.is_some(),
                    has_groom_texture: material.groom_texture.is_some(),
                    cutout: material.alpha_cutoff.is_some(),
                    furred: material.furred && fur.is_some(),
                    double_sided: material.double_sided,
                });
            }
        }
        previous = Some(part.material);
    }

    let (ink, ink_bytes) = model_ink::load(&uploader, package, &mesh)?.unzip();
    gpu_bytes += ink_bytes.unwrap_or(0);
    let manifest = manifest.clone();
    let has_skeleton = animation.is_some();
    let resources = Resources {
        manifest,
        animation,
        geometry,
        attributes,
        skin,
        indices,
        fur,
        fins: fin_resources,
        planar_directions,
        varies: Varies::of(&mesh),
        extent: Extent::of(&mesh, skinned && has_skeleton),
        number: LOADED.fetch_add(1, Ordering::Relaxed),
        parts,
        ink,
        gpu_bytes,
    };
    Ok(Model(Arc::new(resources)))
}

pub(crate) struct Uploader<'a> {
    device: &'a wgpu::Device,
    queue: &'a wgpu::Queue,
    package: &'a Package<'a>,
}

impl Uploader<'_> {
    fn content(&self, what: String, reason: String) -> RuntimeError {
        RuntimeError::Content { package: self.package.manifest().model.clone(), what, reason }
    }

    fn texture_name(&self, index: u32) -> &str {
        self.package.manifest().textures.get(index as usize).map_or("", |t| &t.name)
    }

    fn within(
        &self,
        what: impl Fn() -> String,
        found: u64,
        limit: &'static str,
        allowed: u64,
    ) -> Result<(), RuntimeError> {
        if found > allowed {
            return Err(RuntimeError::DeviceLimit { what: what(), found, limit, allowed });
        }
        Ok(())
    }

    pub(crate) fn buffer(
        &self,
        name: &str,
        contents: &[u8],
        usage: wgpu::BufferUsages,
    ) -> Result<wgpu::Buffer, RuntimeError> {
        let limits = self.device.limits();
        let what = || format!("size in bytes of the {name} of package {:?}", self.package.manifest().model);
        self.within(what, contents.len() as u64, "max_buffer_size", limits.max_buffer_size)?;
        if usage.contains(wgpu::BufferUsages::STORAGE) {
            let allowed = limits.max_storage_buffer_binding_size;
            self.within(what, contents.len() as u64, "max_storage_buffer_binding_size", allowed)?;
        }
        let label = format!("pelage {name}");
        Ok(self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: Some(&label), contents, usage }))
    }

    /// Whether texels of two bytes travel as four: software rasterisers fetch those eight at a time and these one by one, which
    /// makes reading directions a quarter dearer.
    fn widens(&self, format: TextureFormat) -> bool {
        format == TextureFormat::Rg8Unorm && self.device.adapter_info().device_type == wgpu::DeviceType::Cpu
    }

    /// Bytes of colours and directions on the device.
    fn hair_bytes(&self, textures: &FurTextures<'_>) -> u64 {
        let bytes = |view: &TextureView<'_>| view.gpu_bytes().saturating_mul(1 + u64::from(self.widens(view.format)));
        bytes(&textures.color) + bytes(&textures.direction)
    }

    /// Colours and directions of hair, as array textures.
    fn hair(
        &self,
        color: u32,
        direction: u32,
        textures: &FurTextures<'_>,
    ) -> Result<[wgpu::TextureView; 2], RuntimeError> {
        let dimension = Some(wgpu::TextureViewDimension::D2Array);
        let array = wgpu::TextureViewDescriptor { dimension, ..Default::default() };
        let color = self.texture(color, &textures.color)?.create_view(&array);
        Ok([color, self.texture(direction, &textures.direction)?.create_view(&array)])
    }

    pub(crate) fn texture(&self, index: u32, view: &TextureView<'_>) -> Result<wgpu::Texture, RuntimeError> {
        let name = self.texture_name(index);
        let limits = self.device.limits();
        let edge = view.width.max(view.height);
        let what = |what: &str| format!("{what} of texture {name:?} of package {:?}", self.package.manifest().model);
        self.within(
            || what("size in texels"),
            edge.into(),
            "max_texture_dimension_2d",
            limits.max_texture_dimension_2d.into(),
        )?;
        let (layers, allowed) = (view.layers.into(), limits.max_texture_array_layers.into());
        self.within(|| what("array layers"), layers, "max_texture_array_layers", allowed)?;
        let block = view.format.block_size();
        if block > 1 {
            if !self.device.features().contains(wgpu::Features::TEXTURE_COMPRESSION_BC) {
                return Err(RuntimeError::MissingFeature {
                    package: self.package.manifest().model.clone(),
                    texture: name.into(),
                    format: view.format.name(),
                    feature: "TEXTURE_COMPRESSION_BC",
                });
            }
            if !view.width.is_multiple_of(block) || !view.height.is_multiple_of(block) {
                let reason = format!(
                    "{} x {} texels of {}, expected multiples of {block}: WebGPU has no partial blocks",
                    view.width,
                    view.height,
                    view.format.name()
                );
                return Err(self.content(format!("texture {name:?}"), reason));
            }
        }
        let widens = self.widens(view.format);
        let format = if widens { TextureFormat::Rgba8Unorm } else { view.format };
        let texture = self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(name),
            size: wgpu::Extent3d { width: view.width, height: view.height, depth_or_array_layers: view.layers },
            mip_level_count: view.levels,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu_format(format),
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        for level in 0..view.levels {
            let (width, height) = view.level_size(level);
            let (columns, rows) = (width.div_ceil(block), height.div_ceil(block));
            let wide: Vec<u8>;
            let texels = if widens {
                wide = view.level(level).chunks_exact(2).flat_map(|t| [t[0], t[1], 0, 255]).collect();
                &wide
            } else {
                view.level(level)
            };
            self.queue.write_texture(
                wgpu::TexelCopyTextureInfo {
                    texture: &texture,
                    mip_level: level,
                    origin: wgpu::Origin3d::ZERO,
                    aspect: wgpu::TextureAspect::All,
                },
                texels,
                wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(columns * format.block_bytes()),
                    rows_per_image: Some(rows),
                },
                // Whole blocks: small levels of compressed textures are stored so.
                wgpu::Extent3d { width: columns * block, height: rows * block, depth_or_array_layers: view.layers },
            );
        }
        Ok(texture)
    }
}

fn wgpu_format(format: TextureFormat) -> wgpu::TextureFormat {
    match format {
        TextureFormat::Rgba8Srgb => wgpu::TextureFormat::Rgba8UnormSrgb,
        TextureFormat::Rgba8Unorm => wgpu::TextureFormat::Rgba8Unorm,
        TextureFormat::Rg8Unorm => wgpu::TextureFormat::Rg8Unorm,
        TextureFormat::Bc7Srgb => wgpu::TextureFormat::Bc7RgbaUnormSrgb,
        TextureFormat::Bc7Unorm => wgpu::TextureFormat::Bc7RgbaUnorm,
        TextureFormat::Bc5Unorm => wgpu::TextureFormat::Bc5RgUnorm,
    }
}
