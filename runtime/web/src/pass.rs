//! Drawing of a package into the frame of another renderer, such as three.js, on the same device.

use crate::canvas::OpenedDevice;
use crate::js_error::{invalid_argument, pelage_error, stage_error};
use crate::report;
use crate::viewer::{frame_params, reject_files, with_environment};
use glam::{Mat4, Vec3};
use js_sys::Reflect;
use pelage_runtime::{Camera, Instance, Model, Motion, Projection, Renderer, RendererOptions, RuntimeError, wgpu};
use pelage_stage::{Gpu, Look, LookStyle, NamedPackage};
use wasm_bindgen::prelude::*;

/// Owner id of the single instance.
const OWNER: u64 = 0;

/// Package drawn over the output of another renderer, into the same colour and depth targets.
#[wasm_bindgen]
pub struct Pass {
    gpu: Gpu,
    renderer: Renderer,
    loaded: Option<(NamedPackage<'static>, Model)>,
    look: Look,
    light_color: Vec3,
}

#[wasm_bindgen]
impl Pass {
    /// Creates a pass for targets of the given formats, named as in WebGPU, with one sample per pixel. `reversed_depth`
    /// means that the near plane has depth 1.
    ///
    /// Fails with an error of kind `asked` for a format that cannot be drawn to.
    #[wasm_bindgen(constructor)]
    pub fn new(opened: &OpenedDevice, color: &str, depth: &str, reversed_depth: bool) -> Result<Self, JsValue> {
        let options = RendererOptions {
            color_format: color_format(color)?,
            depth_format: depth_format(depth)?,
            reversed_depth,
            ..RendererOptions::default()
        };
        let gpu = opened.gpu.clone();
        let renderer = Renderer::new(&gpu.device, &gpu.queue, &options).map_err(invalid_argument)?;
        Ok(Self { gpu, renderer, loaded: None, look: Look::default(), light_color: Vec3::ONE })
    }

    /// Loads the package to draw; `name` is its name in messages.
    ///
    /// Fails like [`crate::Viewer::load`].
    pub fn load(&mut self, name: &str, bytes: Vec<u8>) -> Result<JsValue, JsValue> {
        let file = NamedPackage::new(name, bytes);
        let package = file.open().map_err(stage_error)?;
        let has_ink = package.ink().map_err(|error| stage_error(file.fault(error)))?.is_some();
        let model = self.renderer.load(&package).map_err(|error| load_error(&file, error))?;
        let info = report::package(name, file.bytes.len(), &model, has_ink);
        drop(package);
        self.renderer.forget(OWNER);
        self.loaded = Some((file, model));
        Ok(info)
    }

    /// Sets one key of the look, in one of its tables `light`, `shadow` and `fur`. The table `picture` is up to the
    /// other renderer.
    ///
    /// Fails with an error of kind `asked` with what was found and expected.
    pub fn set_look(&mut self, assignment: &str) -> Result<(), JsValue> {
        let mut look = self.look.clone();
        look.set(assignment).map_err(invalid_argument)?;
        if look.picture.style == LookStyle::Ink {
            return Err(invalid_argument(
                "picture.style: found ink, expected fur or bare: ink paints the whole picture",
            ));
        }
        self.look = reject_files(look)?;
        Ok(())
    }

    /// Sets an environment map from TOML, like [`crate::viewer::Viewer::set_environment`].
    ///
    /// Fails with an error of kind `asked` with line, key, what was found and expected.
    pub fn set_environment(&mut self, text: &str) -> Result<(), JsValue> {
        self.look = with_environment(&self.look, text)?;
        Ok(())
    }

    /// Sets the colour of the key light, linear; 1 is full light.
    pub fn set_light_color(&mut self, red: f32, green: f32, blue: f32) {
        self.light_color = Vec3::new(red, green, blue).max(Vec3::ZERO);
    }

    /// Draws a frame over `color` and `depth`, two `GPUTexture`s of this device of equal size, and submits it.
    ///
    /// * `matrices`: `view_from_world`, `clip_from_view` and `world_from_model`, 16 numbers each, column-major
    /// * `clip`: index of the clip; below 0 for the model at rest
    /// * `time_s`: time in the clip, seconds
    /// * `clock_s`: time of the hair simulation, seconds; without it, hair is as groomed
    ///
    /// Fails with an error of kind `asked` for arguments that cannot be drawn.
    pub fn draw(
        &mut self,
        color: &JsValue,
        depth: &JsValue,
        matrices: &[f32],
        clip: i32,
        time_s: f32,
        clock_s: Option<f64>,
    ) -> Result<JsValue, JsValue> {
        let Some((_, model)) = &self.loaded else { return Ok(JsValue::UNDEFINED) };
        if matrices.len() != 48 {
            return Err(invalid_argument(format!("matrices: found {} numbers, expected 48", matrices.len())));
        }
        let matrix = |index: usize| Mat4::from_cols_slice(&matrices[16 * index..16 * (index + 1)]);
        let options = self.renderer.options();
        let (color, size) = self.foreign_texture_view(color, options.color_format, "color")?;
        let (depth, depth_size) = self.foreign_texture_view(depth, options.depth_format, "depth")?;
        if size != depth_size {
            return Err(invalid_argument(format!(
                "depth: found {depth_size:?} pixels, expected {size:?}, the size of color"
            )));
        }
        let camera = Camera { view_from_world: matrix(0), projection: Projection::Custom(matrix(1)) };
        let params = frame_params(&self.look, self.light_color).with(|params| {
            params.camera = camera;
            params.viewport = size;
            if let Some(clock_s) = clock_s {
                (params.time_s, params.hair_motion) = (clock_s, self.look.hair_motion());
            }
        });
        let motion = usize::try_from(clip).map_or(Motion::Rest, |clip| Motion::Clip { clip, time_s });
        let animal = Instance::new(OWNER, model).at(matrix(2)).moving(motion);
        let mut encoder =
            self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("pelage") });
        let frame = self.renderer.prepare(&mut encoder, &params, [animal]).map_err(invalid_argument)?;
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("pelage"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &color,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &depth,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            ..Default::default()
        });
        frame.draw(&mut pass);
        drop(pass);
        self.gpu.queue.submit([encoder.finish()]);
        Ok(report::frame(&frame, model.gpu_bytes() + self.renderer.owners_gpu_bytes()))
    }
}

impl Pass {
    /// Returns a view of a texture that belongs to another renderer, and the texture's width and height. Nothing is
    /// copied.
    fn foreign_texture_view(
        &self,
        texture: &JsValue,
        format: wgpu::TextureFormat,
        what: &str,
    ) -> Result<(wgpu::TextureView, [u32; 2]), JsValue> {
        let number = |name: &str| Reflect::get(texture, &name.into()).ok().and_then(|value| value.as_f64());
        let (Some(width), Some(height), Some(samples)) = (number("width"), number("height"), number("sampleCount"))
        else {
            return Err(invalid_argument(format!("{what}: found no GPUTexture, expected one of this device")));
        };
        if samples != 1.0 {
            return Err(invalid_argument(format!("{what}: found {samples} samples per pixel, expected 1")));
        }
        let size = [width as u32, height as u32];
        let descriptor = wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
            view_formats: &[],
        };
        let handle = texture.clone().unchecked_into();
        let texture = self.gpu.device.create_texture_from_webgpu_handle(handle, &descriptor, None);
        Ok((texture.create_view(&wgpu::TextureViewDescriptor::default()), size))
    }
}

fn color_format(name: &str) -> Result<wgpu::TextureFormat, JsValue> {
    Ok(match name {
        "rgba16float" => wgpu::TextureFormat::Rgba16Float,
        "rgba8unorm" => wgpu::TextureFormat::Rgba8Unorm,
        "rgba8unorm-srgb" => wgpu::TextureFormat::Rgba8UnormSrgb,
        "bgra8unorm" => wgpu::TextureFormat::Bgra8Unorm,
        "bgra8unorm-srgb" => wgpu::TextureFormat::Bgra8UnormSrgb,
        _ => {
            let expected = "rgba16float, rgba8unorm, bgra8unorm, or one of these with -srgb";
            return Err(invalid_argument(format!("color: found {name}, expected {expected}")));
        }
    })
}

fn depth_format(name: &str) -> Result<wgpu::TextureFormat, JsValue> {
    Ok(match name {
        "depth32float" => wgpu::TextureFormat::Depth32Float,
        "depth24plus" => wgpu::TextureFormat::Depth24Plus,
        _ => return Err(invalid_argument(format!("depth: found {name}, expected depth32float or depth24plus"))),
    })
}

/// Converts an error of the runtime on loading a package. The kind depends on the cause.
fn load_error(file: &NamedPackage<'_>, error: RuntimeError) -> JsValue {
    let kind = match &error {
        RuntimeError::Package(_) | RuntimeError::Content { .. } => "package",
        RuntimeError::DeviceLimit { .. } => "no-adapter",
        _ => "internal",
    };
    pelage_error(kind, &format!("{}: {error}", file.name))
}
