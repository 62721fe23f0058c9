//! Runs shader functions on the GPU, one invocation per case of a table.

use pelage_runtime::wgpu;
use pelage_stage::Gpu;
use wgpu::util::DeviceExt;

/// Initial value of the output. A result that still has it was not computed.
pub const SENTINEL: f32 = -98_765.25;

/// Evaluates the WGSL expression `expression`, a `vec4<f32>`, for every case.
///
/// * `library`: WGSL with the functions that the expression calls
/// * `cases`: `N` vectors each, available to the expression as `in_0`, `in_1`, … of type `vec4<f32>`
///
/// Panics if a component of the result still holds the sentinel.
pub fn evaluate<const N: usize>(gpu: &Gpu, library: &str, expression: &str, cases: &[[[f32; 4]; N]]) -> Vec<[f32; 4]> {
    let inputs: String = (0..N).map(|k| format!("    let in_{k} = inputs[{N}u * index + {k}u];\n")).collect();
    let source = format!(
        "{library}
@group(0) @binding(0) var<storage, read> inputs: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> outputs: array<vec4<f32>>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {{
    let index = id.y * groups.x * 64u + id.x;
    if index >= arrayLength(&outputs) {{
        return;
    }}
{inputs}    outputs[index] = {expression};
}}
"
    );
    let device = &gpu.device;
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(expression),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(expression),
        layout: None,
        module: &module,
        entry_point: Some("main"),
        compilation_options: Default::default(),
        cache: None,
    });
    let storage = |contents: &[u8], usage| {
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor { label: None, contents, usage })
    };
    let inputs = storage(bytemuck::cast_slice(cases.as_flattened()), wgpu::BufferUsages::STORAGE);
    let blank = vec![[SENTINEL; 4]; cases.len()];
    let outputs = storage(bytemuck::cast_slice(&blank), wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
    let bind_group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: inputs.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: outputs.as_entire_binding() },
        ],
    });
    let staging = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: outputs.size(),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &bind_group, &[]);
    let groups = cases.len().div_ceil(64) as u32;
    pass.dispatch_workgroups(groups.min(1024), groups.div_ceil(1024), 1);
    drop(pass);
    encoder.copy_buffer_to_buffer(&outputs, 0, &staging, 0, outputs.size());
    gpu.queue.submit([encoder.finish()]);
    let bytes = gpu.read_buffer(&staging).expect("the device answers");
    let results: Vec<[f32; 4]> = bytes.chunks_exact(16).map(bytemuck::pod_read_unaligned).collect();
    for (case, result) in results.iter().enumerate() {
        assert!(result.iter().all(|v| *v != SENTINEL), "case {case} of {expression} was not computed");
    }
    results
}
