//! GPU device, and the `<canvas>` that it draws on.

use crate::js_error::{pelage_error, stage_error};
use pelage_runtime::shared::srgb;
use pelage_runtime::wgpu;
use pelage_stage::{Canvas, Gpu, StageError};
use wasm_bindgen::prelude::*;
use web_sys::HtmlCanvasElement;

/// GPU device and the canvas that it presents to.
#[wasm_bindgen(js_name = Opened)]
#[derive(Debug)]
pub struct OpenedDevice {
    pub(crate) gpu: Gpu,
    /// Canvas; `None` if another renderer presents the image.
    pub(crate) screen: Option<Screen>,
}

#[wasm_bindgen(js_class = Opened)]
impl OpenedDevice {
    /// Returns the `GPUDevice`, which can be shared, and whose `lost` promise reports its loss.
    #[wasm_bindgen(getter)]
    pub fn device(&self) -> JsValue {
        self.gpu.device.as_webgpu().map_or(JsValue::UNDEFINED, |device| device.clone().into())
    }

    /// Returns the name of the adapter as given by the browser; may be empty.
    #[wasm_bindgen(getter)]
    pub fn adapter(&self) -> String {
        self.gpu.info.name.clone()
    }
}

/// Opens a device that draws on `canvas`.
///
/// Fails with an error of kind `no-adapter` if the browser provides none; `device` if WebGPU cannot draw on the canvas,
/// for example because it has a 2d context.
#[wasm_bindgen]
pub async fn open(canvas: HtmlCanvasElement) -> Result<OpenedDevice, JsValue> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let surface = instance.create_surface(wgpu::SurfaceTarget::Canvas(canvas));
    let surface = surface.map_err(|error| pelage_error("device", &format!("canvas: {error}")))?;
    let gpu = Gpu::request(&instance, Some(&surface), wanted_features(), None).await.map_err(open_error)?;
    Ok(OpenedDevice { screen: Some(Screen::new(&gpu, surface)), gpu })
}

/// Opens a device for use with another renderer.
///
/// Fails with an error of kind `no-adapter` if the browser provides none.
#[wasm_bindgen]
pub async fn open_shared() -> Result<OpenedDevice, JsValue> {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let gpu = Gpu::request(&instance, None, wanted_features(), None).await.map_err(open_error)?;
    Ok(OpenedDevice { screen: None, gpu })
}

/// Converts an error of opening a device. Replaces the description of wgpu, which means nothing to the user of a page.
fn open_error(error: StageError) -> JsValue {
    match error {
        StageError::NoAdapter(_) => pelage_error(
            "no-adapter",
            "the browser has WebGPU but offers no graphics adapter; turn on hardware acceleration in its settings, and \
             update browser and graphics driver (chrome://gpu or about:support shows what is blocked)",
        ),
        other => stage_error(other),
    }
}

/// Returns the wanted features: block compression if available, which fits four times the texels into the same memory.
fn wanted_features() -> wgpu::Features {
    wgpu::Features::TEXTURE_COMPRESSION_BC
}

/// Canvas of the page, to which the stage's own canvas is copied.
///
/// A page's canvas has no sRGB format, but a stage draws linear light. Therefore a pass of one triangle copies the
/// stage's encoded bytes. The stage's colours are premultiplied with coverage in linear light. The pass converts them
/// to the form that a page blends: encoded colours, premultiplied.
#[derive(Debug)]
pub(crate) struct Screen {
    surface: wgpu::Surface<'static>,
    pipeline: wgpu::RenderPipeline,
    /// Bind group of the stage's image; `None` until an image is shown after a change of size.
    picture: Option<wgpu::BindGroup>,
}

/// Format that every browser must support and whose bytes are laid out like a stage's.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

impl Screen {
    fn new(gpu: &Gpu, surface: wgpu::Surface<'static>) -> Self {
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("canvas"),
            source: wgpu::ShaderSource::Wgsl([srgb::WGSL, include_str!("canvas.wgsl")].concat().into()),
        });
        let pipeline = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("canvas"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vertex"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("fragment"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(FORMAT.into())],
            }),
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            multiview_mask: None,
            cache: None,
        });
        Self { surface, pipeline, picture: None }
    }

    /// Sets width and height in pixels. The content of the canvas is lost.
    pub fn resize(&mut self, gpu: &Gpu, (width, height): (u32, u32)) {
        self.picture = None;
        self.surface.configure(
            &gpu.device,
            &wgpu::SurfaceConfiguration {
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
                format: FORMAT,
                color_space: wgpu::SurfaceColorSpace::Auto,
                width,
                height,
                present_mode: wgpu::PresentMode::AutoVsync,
                desired_maximum_frame_latency: 2,
                alpha_mode: wgpu::CompositeAlphaMode::PreMultiplied,
                view_formats: Vec::new(),
            },
        );
    }

    /// Discards the bind group of the stage's image, because the stage has a new canvas.
    pub fn discard_image(&mut self) {
        self.picture = None;
    }

    /// Records the commands that present `canvas`, whose size was last given to [`Self::resize`]. `None` if the page
    /// currently has no texture to draw on; the canvas then keeps its content.
    pub fn show(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        canvas: &Canvas,
    ) -> Option<wgpu::SurfaceTexture> {
        let texture = match self.surface.get_current_texture() {
            wgpu::CurrentSurfaceTexture::Success(texture) | wgpu::CurrentSurfaceTexture::Suboptimal(texture) => texture,
            _ => return None,
        };
        let picture = self.picture.get_or_insert_with(|| {
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("canvas"),
                layout: &self.pipeline.get_bind_group_layout(0),
                entries: &[wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(&canvas.encoded()),
                }],
            })
        });
        let view = texture.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("canvas"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &*picture, &[]);
        pass.draw(0..3, 0..1);
        drop(pass);
        Some(texture)
    }
}
