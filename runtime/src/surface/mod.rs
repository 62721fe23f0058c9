//! Bindings, vertex streams and materials shared by all passes over a model's surface.

use crate::gpu::{BindingResource, Gpu, SamplerSettings, VertexLayout, attribute, sampler, storage, texture, uniform};
use crate::params::MAX_FILL_LIGHTS;
use crate::shared::frame;
use crate::shared::scattering::Fibre;
use crate::shared::shader_struct::shader_struct;
use pelage_formats::meaning::environment::Environment;
use pelage_formats::{AttributeVertex, FibreInfo, Fin, GeometryVertex, ROOT_HEIGHTS};
use std::mem::offset_of;
use wgpu::util::DeviceExt;

/// Fill lights, then the lobes of the environment.
pub(crate) type Lights = [frame::FillLight; MAX_FILL_LIGHTS + Environment::MOST_LOBES];

shader_struct! {
    pub(crate) struct MaterialUniform {
        pub(crate) base_color: [f32; 4],
        pub(crate) alpha_cutoff: f32,
        /// Reciprocal of the height of the tile's hair, 1/m; 0 if there is none.
        pub(crate) share_per_m: f32,
        /// Value of `VisibilityInfo::horizon`; 1 if the package has none.
        pub(crate) horizon: f32,
        /// Index of the fur's fibre in the package.
        pub(crate) fibre: u32,
        /// Sine of the angle behind the terminator up to which hair tips are lit.
        pub(crate) rim: f32,
        /// Height of the tile's hair, in widths of the tile.
        pub(crate) hair_tiles: f32,
        pub(crate) reserved: [f32; 2],
        /// Linear RGB of hair in place of `base_color`, then 0; unused if hair has the base colour.
        pub(crate) hair_color: [f32; 4],
        /// Roughness, reflectance and metalness of bare surface; then 1 if it is wet, else 0. All 0 for matt surface.
        pub(crate) gloss: [f32; 4],
        /// Per height: the values `mean` and `along` of `RootsInfo::asides`, in texture coordinates of the base colour,
        /// then 0.
        pub(crate) asides: [[f32; 4]; ROOT_HEIGHTS],
    }
}

/// Vertex streams of all passes over surfaces, except fins, which read vertices from storage buffers.
pub(crate) const STREAMS: [VertexLayout; 2] = [
    VertexLayout::of::<GeometryVertex>(&GEOMETRY_ATTRIBUTES),
    VertexLayout::of::<AttributeVertex>(&ATTRIBUTE_ATTRIBUTES),
];

/// Attributes of the first vertex stream, [`GeometryVertex`].
pub(crate) const GEOMETRY_ATTRIBUTES: [wgpu::VertexAttribute; 5] = [
    attribute(0, wgpu::VertexFormat::Float32x3, offset_of!(GeometryVertex, position)),
    attribute(1, wgpu::VertexFormat::Float32, offset_of!(GeometryVertex, fur_height)),
    attribute(2, wgpu::VertexFormat::Float32x3, offset_of!(GeometryVertex, normal)),
    attribute(3, wgpu::VertexFormat::Float32x4, offset_of!(GeometryVertex, tangent)),
    attribute(7, wgpu::VertexFormat::Float32, offset_of!(GeometryVertex, lean)),
];
/// Attributes of the second vertex stream, [`AttributeVertex`].
pub(crate) const ATTRIBUTE_ATTRIBUTES: [wgpu::VertexAttribute; 4] = [
    attribute(4, wgpu::VertexFormat::Float32x2, offset_of!(AttributeVertex, tile_uv)),
    attribute(5, wgpu::VertexFormat::Float32x2, offset_of!(AttributeVertex, base_uv)),
    attribute(6, wgpu::VertexFormat::Unorm8x4, offset_of!(AttributeVertex, color)),
    attribute(8, wgpu::VertexFormat::Unorm8x4, offset_of!(AttributeVertex, groom)),
];

/// Vertex stream of a model's bare normals, for passes that light bare surface.
pub(crate) const BARE_NORMALS: VertexLayout =
    VertexLayout::of::<[i16; 2]>(&[attribute(13, wgpu::VertexFormat::Snorm16x2, 0)]);

/// Maximum number of storage buffers that strand passes bind at once.
const STRAND_BUFFERS: u32 = 7;

/// Maximum number of storage buffers that passes over contour lines bind at once.
const CONTOUR_BUFFERS: u32 = 8;

/// Threads of the workgroup that counts strands or crossed edges, which is the largest workgroup.
pub(crate) const SCAN_WORKGROUP: u32 = 256;

/// Bind group layouts of surfaces, and placeholders for missing textures.
#[derive(Debug)]
pub(crate) struct Surfaces {
    /// Layout of group 0: frame block, and instance block at a dynamic offset.
    pub(crate) frame: wgpu::BindGroupLayout,
    /// Layout of group 1: material.
    pub(crate) material: wgpu::BindGroupLayout,
    /// Layout of group 2: hair textures.
    pub(crate) fur: wgpu::BindGroupLayout,
    /// Layout of group 3, only for fins: posed vertices, attributes, fins. `None` if the device has no storage buffers
    /// in vertex shaders.
    pub(crate) fins: Option<wgpu::BindGroupLayout>,
    /// Whether single strands can be drawn: the device has enough storage buffers in compute shaders.
    pub(crate) strands: bool,
    /// Whether contour lines can be extracted, for the same reason.
    pub(crate) contours: bool,
    pub(crate) white: wgpu::TextureView,
    pub(crate) white_array: wgpu::TextureView,
    /// Resources for packages without fibres.
    pub(crate) no_fibres: FibreResources,
    pub(crate) map_sampler: wgpu::Sampler,
}

fn layout(device: &wgpu::Device, label: &str, entries: &[wgpu::BindGroupLayoutEntry]) -> wgpu::BindGroupLayout {
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries })
}

/// Returns the layout entry of a texture of the hair volume, which vertex shaders may also read.
fn hair(binding: u32) -> wgpu::BindGroupLayoutEntry {
    let visibility = wgpu::ShaderStages::VERTEX_FRAGMENT;
    wgpu::BindGroupLayoutEntry { visibility, ..texture(binding, wgpu::TextureViewDimension::D2Array) }
}

impl Surfaces {
    pub(crate) fn new(gpu: &Gpu) -> Self {
        use wgpu::TextureViewDimension::{D2, D2Array};
        let device = &gpu.device;
        let white = device.create_texture_with_data(
            &gpu.queue,
            &wgpu::TextureDescriptor {
                label: Some("pelage white"),
                size: wgpu::Extent3d::default(),
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::Rgba8Unorm,
                usage: wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            },
            wgpu::util::TextureDataOrder::LayerMajor,
            &[255; 4],
        );
        let limits = device.limits();
        let strands = limits.max_storage_buffers_per_shader_stage >= STRAND_BUFFERS
            && limits.max_compute_invocations_per_workgroup >= SCAN_WORKGROUP;
        // Strands are lit in compute shaders, so these also need access.
        let stages = match strands {
            true => wgpu::ShaderStages::VERTEX_FRAGMENT | wgpu::ShaderStages::COMPUTE,
            false => wgpu::ShaderStages::VERTEX_FRAGMENT,
        };
        let for_all = |entry| wgpu::BindGroupLayoutEntry { visibility: stages, ..entry };
        let frame = [
            uniform::<frame::Frame>(0, false),
            uniform::<frame::Instance>(1, true),
            uniform::<Lights>(2, false),
            texture(3, D2Array),
            texture(4, D2),
            sampler(5),
            texture(6, D2Array),
            texture(7, D2Array),
        ]
        .map(for_all);
        let material = [
            uniform::<MaterialUniform>(0, false),
            texture(1, D2),
            sampler(2),
            texture(3, D2),
            texture(4, D2Array),
            uniform::<FibreBlock>(5, false),
        ]
        .map(for_all);
        let fur = [hair(0), hair(1), sampler(2), hair(3), hair(4), hair(5), hair(6)];
        let vertices = wgpu::ShaderStages::VERTEX;
        let fins = [
            storage::<GeometryVertex>(0, vertices),
            storage::<AttributeVertex>(1, vertices),
            storage::<Fin>(2, vertices),
        ];
        let map_sampling = SamplerSettings {
            mipmaps: false,
            ..SamplerSettings::new("pelage shadow maps", wgpu::AddressMode::ClampToEdge)
        };
        let white_array =
            white.create_view(&wgpu::TextureViewDescriptor { dimension: Some(D2Array), ..Default::default() });
        Self {
            no_fibres: FibreResources::new(gpu, white_array.clone(), &[]),
            frame: layout(device, "pelage frame", &frame),
            material: layout(device, "pelage material", &material),
            fur: layout(device, "pelage fur", &fur),
            fins: (limits.max_storage_buffers_per_shader_stage >= 3).then(|| layout(device, "pelage fins", &fins)),
            strands,
            contours: limits.max_storage_buffers_per_shader_stage >= CONTOUR_BUFFERS
                && limits.max_compute_invocations_per_workgroup >= SCAN_WORKGROUP,
            map_sampler: map_sampling.make(device),
            white: white.create_view(&wgpu::TextureViewDescriptor::default()),
            white_array,
        }
    }

    /// Creates bind group 1, the material.
    pub(crate) fn material_group(
        &self,
        gpu: &Gpu,
        constants: &MaterialUniform,
        base_color: &wgpu::TextureView,
        base_color_sampler: &wgpu::Sampler,
        groom: &wgpu::TextureView,
        fibres: &FibreResources,
    ) -> wgpu::BindGroup {
        let bytes = bytemuck::bytes_of(constants);
        let entries = [
            (0, BindingResource::Buffer(gpu.buffer_of("pelage material", bytes, wgpu::BufferUsages::UNIFORM))),
            (1, BindingResource::View(base_color.clone())),
            (2, BindingResource::Sampler(base_color_sampler.clone())),
            (3, BindingResource::View(groom.clone())),
            (4, BindingResource::View(fibres.tables.clone())),
            (5, BindingResource::Buffer(fibres.constants.clone())),
        ];
        gpu.bind_group("pelage material", &self.material, &entries)
    }

    /// Creates bind group 2, the hair textures.
    pub(crate) fn fur_group(&self, gpu: &Gpu, hair: &HairViews, sampler: &wgpu::Sampler) -> wgpu::BindGroup {
        let [wet_colors, wet_directions] = hair.wet.as_ref().map_or([&self.white_array; 2], <[_; 2]>::each_ref);
        let [seen, wet_seen] = hair.visibility.each_ref().map(|view| view.as_ref().unwrap_or(&self.white_array));
        let view = |binding, view: &wgpu::TextureView| (binding, BindingResource::View(view.clone()));
        let entries = [
            view(0, &hair.dry[0]),
            view(1, &hair.dry[1]),
            (2, BindingResource::Sampler(sampler.clone())),
            view(3, wet_colors),
            view(4, wet_directions),
            view(5, seen),
            view(6, wet_seen),
        ];
        gpu.bind_group("pelage fur", &self.fur, &entries)
    }
}

/// Constants of all fibres that a package may have.
pub(crate) type FibreBlock = [Fibre; FibreInfo::MOST];

/// Scattering data of a package's fibres.
#[derive(Clone, Debug)]
pub(crate) struct FibreResources {
    tables: wgpu::TextureView,
    /// Buffer of a [`FibreBlock`].
    constants: wgpu::Buffer,
}

impl FibreResources {
    /// Creates the resources for at most [`FibreInfo::MOST`] `fibres`.
    pub(crate) fn new(gpu: &Gpu, tables: wgpu::TextureView, fibres: &[Fibre]) -> Self {
        let mut block: FibreBlock = [Fibre::default(); FibreInfo::MOST];
        block.iter_mut().zip(fibres).for_each(|(to, from)| *to = *from);
        let bytes = bytemuck::cast_slice(&block);
        Self { tables, constants: gpu.buffer_of("pelage fibres", bytes, wgpu::BufferUsages::UNIFORM) }
    }
}

/// Textures of a model's hair, or of its fins.
#[derive(Clone, Debug)]
pub(crate) struct HairViews {
    /// Colours and directions of dry hair.
    pub(crate) dry: [wgpu::TextureView; 2],
    /// Colours and directions of wet hair, if any.
    pub(crate) wet: Option<[wgpu::TextureView; 2]>,
    /// Visibility of light in dry and wet hair, if the package has it.
    pub(crate) visibility: [Option<wgpu::TextureView>; 2],
}
