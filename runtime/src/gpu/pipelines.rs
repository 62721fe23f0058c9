//! Cache of pipelines, keyed by the specification that a pass supplies.

use super::device::Gpu;
use std::collections::HashMap;
use std::hash::{Hash, Hasher};

/// Shader source and its name. Two shaders with the same name are treated as equal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shader {
    pub(crate) name: &'static str,
    /// Source files in order, joined when the shader is compiled. A program thus contains shared files only once, which
    /// keeps the download of web pages small.
    pub(crate) parts: &'static [&'static str],
}

impl Shader {
    /// Returns the whole source.
    pub(crate) fn wgsl(&self) -> String {
        self.parts.concat()
    }
}

impl PartialEq for Shader {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl Eq for Shader {}

impl Hash for Shader {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.name.hash(state);
    }
}

/// Values of a shader's override constants by name. A constant that is not listed keeps its declared default, which
/// switches its feature off.
pub(crate) type Constants = Vec<(&'static str, u32)>;

/// Returns a boolean override constant.
pub(crate) fn flag(name: &'static str, value: bool) -> (&'static str, u32) {
    (name, u32::from(value))
}

/// Layout of vertices in a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct VertexLayout {
    /// Bytes from one vertex to the next.
    pub(crate) stride: u64,
    pub(crate) attributes: &'static [wgpu::VertexAttribute],
}

impl VertexLayout {
    /// Creates a layout of vertices `T`.
    pub(crate) const fn of<T>(attributes: &'static [wgpu::VertexAttribute]) -> Self {
        Self { stride: size_of::<T>() as u64, attributes }
    }
}

pub(crate) const fn attribute(
    shader_location: u32,
    format: wgpu::VertexFormat,
    offset: usize,
) -> wgpu::VertexAttribute {
    wgpu::VertexAttribute { format, offset: offset as u64, shader_location }
}

/// Returns the primitive state. `mirrored`: the instance is mirrored, so its front faces wind clockwise.
/// `double_sided`: back faces are drawn instead of culled.
pub(crate) fn primitive_state(mirrored: bool, double_sided: bool) -> wgpu::PrimitiveState {
    wgpu::PrimitiveState {
        front_face: if mirrored { wgpu::FrontFace::Cw } else { wgpu::FrontFace::Ccw },
        cull_mode: (!double_sided).then_some(wgpu::Face::Back),
        ..Default::default()
    }
}

/// Returns the state of a depth test without stencil or bias.
pub(crate) fn depth_state(
    format: wgpu::TextureFormat,
    write: bool,
    compare: wgpu::CompareFunction,
) -> wgpu::DepthStencilState {
    wgpu::DepthStencilState {
        format,
        depth_write_enabled: Some(write),
        depth_compare: Some(compare),
        stencil: wgpu::StencilState::default(),
        bias: wgpu::DepthBiasState::default(),
    }
}

/// Complete description of a render pipeline; the cache key.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct RenderSpec {
    pub(crate) shader: Shader,
    /// Names of the entry points.
    pub(crate) vertex: &'static str,
    pub(crate) fragment: Option<&'static str>,
    pub(crate) groups: Vec<wgpu::BindGroupLayout>,
    pub(crate) streams: Vec<VertexLayout>,
    pub(crate) constants: Constants,
    pub(crate) primitive: wgpu::PrimitiveState,
    pub(crate) colors: Vec<wgpu::ColorTargetState>,
    pub(crate) depth: Option<wgpu::DepthStencilState>,
    pub(crate) samples: u32,
}

impl RenderSpec {
    /// Returns the specification of a triangle that covers a target of `format`.
    pub(crate) fn screen(
        shader: Shader,
        [vertex, fragment]: [&'static str; 2],
        group: wgpu::BindGroupLayout,
        format: wgpu::TextureFormat,
    ) -> Self {
        Self {
            shader,
            vertex,
            fragment: Some(fragment),
            groups: vec![group],
            streams: Vec::new(),
            constants: Vec::new(),
            primitive: wgpu::PrimitiveState::default(),
            colors: vec![format.into()],
            depth: None,
            samples: 1,
        }
    }
}

/// Complete description of a compute pipeline; the cache key.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct ComputeSpec {
    pub(crate) shader: Shader,
    pub(crate) entry: &'static str,
    pub(crate) groups: Vec<wgpu::BindGroupLayout>,
    pub(crate) constants: Constants,
}

#[derive(Debug, Default)]
pub(crate) struct Pipelines {
    modules: HashMap<Shader, wgpu::ShaderModule>,
    renders: HashMap<RenderSpec, wgpu::RenderPipeline>,
    computes: HashMap<ComputeSpec, wgpu::ComputePipeline>,
}

fn module(gpu: &Gpu, shader: Shader) -> wgpu::ShaderModule {
    gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(shader.name),
        source: wgpu::ShaderSource::Wgsl(shader.wgsl().into()),
    })
}

fn layout(gpu: &Gpu, label: &str, groups: &[wgpu::BindGroupLayout]) -> wgpu::PipelineLayout {
    let groups: Vec<_> = groups.iter().map(Some).collect();
    gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(label),
        bind_group_layouts: &groups,
        immediate_size: 0,
    })
}

/// Converts override constants to wgpu's format.
fn to_wgpu_constants(shader: Shader, constants: &Constants) -> Vec<(&'static str, f64)> {
    // A browser rejects constants that the shader does not declare.
    let declares = |name: &str| shader.parts.iter().any(|part| part.contains(&format!("override {name}:")));
    debug_assert!(constants.iter().all(|(name, _)| declares(name)), "{constants:?}");
    constants.iter().map(|(name, value)| (*name, f64::from(*value))).collect()
}

/// Shader stage of a pipeline with the constants that select its variant.
#[cfg(feature = "study")]
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShaderVariant {
    /// Name of the shader.
    pub shader: &'static str,
    /// Name of the entry point.
    pub entry: &'static str,
    /// WGSL source.
    pub source: String,
    /// Override constants by name. Others keep their declared default.
    pub constants: Vec<(&'static str, u32)>,
}

#[cfg(feature = "study")]
impl Pipelines {
    /// Returns the shader stages of all pipelines, ordered by name.
    pub(crate) fn variants(&self) -> Vec<ShaderVariant> {
        let of = |shader: Shader, entry, constants: &Constants| ShaderVariant {
            shader: shader.name,
            entry,
            source: shader.wgsl(),
            constants: constants.clone(),
        };
        let renders = self.renders.keys().flat_map(|spec| {
            let entries = std::iter::once(spec.vertex).chain(spec.fragment);
            entries.map(move |entry| of(spec.shader, entry, &spec.constants))
        });
        let computes = self.computes.keys().map(|spec| of(spec.shader, spec.entry, &spec.constants));
        let mut all: Vec<_> = renders.chain(computes).collect();
        all.sort_by(|a, b| (a.shader, a.entry, &a.constants).cmp(&(b.shader, b.entry, &b.constants)));
        all.dedup();
        all
    }
}

impl Pipelines {
    pub(crate) fn render(&mut self, gpu: &Gpu, spec: RenderSpec) -> wgpu::RenderPipeline {
        if let Some(made) = self.renders.get(&spec) {
            return made.clone();
        }
        let module = self.modules.entry(spec.shader).or_insert_with(|| module(gpu, spec.shader));
        let label = spec.fragment.unwrap_or(spec.vertex);
        let constants = to_wgpu_constants(spec.shader, &spec.constants);
        let compilation_options = wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() };
        let streams: Vec<_> = spec
            .streams
            .iter()
            .map(|stream| {
                Some(wgpu::VertexBufferLayout {
                    array_stride: stream.stride,
                    step_mode: wgpu::VertexStepMode::Vertex,
                    attributes: stream.attributes,
                })
            })
            .collect();
        let colors: Vec<_> = spec.colors.iter().cloned().map(Some).collect();
        let pipeline = gpu.render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(label),
            layout: Some(&layout(gpu, label, &spec.groups)),
            vertex: wgpu::VertexState {
                module,
                entry_point: Some(spec.vertex),
                compilation_options: compilation_options.clone(),
                buffers: &streams,
            },
            primitive: spec.primitive,
            depth_stencil: spec.depth.clone(),
            multisample: wgpu::MultisampleState { count: spec.samples, ..Default::default() },
            fragment: spec.fragment.map(|fragment| wgpu::FragmentState {
                module,
                entry_point: Some(fragment),
                compilation_options,
                targets: &colors,
            }),
            multiview_mask: None,
            cache: None,
        });
        self.renders.entry(spec).or_insert(pipeline).clone()
    }

    pub(crate) fn compute(&mut self, gpu: &Gpu, spec: ComputeSpec) -> wgpu::ComputePipeline {
        if let Some(made) = self.computes.get(&spec) {
            return made.clone();
        }
        let module = self.modules.entry(spec.shader).or_insert_with(|| module(gpu, spec.shader));
        let constants = to_wgpu_constants(spec.shader, &spec.constants);
        let pipeline = gpu.compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(spec.entry),
            layout: Some(&layout(gpu, spec.entry, &spec.groups)),
            module,
            entry_point: Some(spec.entry),
            compilation_options: wgpu::PipelineCompilationOptions { constants: &constants, ..Default::default() },
            cache: None,
        });
        self.computes.entry(spec).or_insert(pipeline).clone()
    }
}
