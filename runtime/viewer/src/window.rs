//! The window: winit provides events, a surface shows the picture, and egui draws the controls.

use crate::app::App;
use crate::events::Events;
use crate::lights::{Lights, LoadLights, LoadSeal};
use crate::save;
use crate::show::Show;
use crate::ui;
use crate::worker::{WorkerMessage, Workers};
use crate::workshop::Workshop;
use egui::{Context, TextureId, ViewportId};
use egui_wgpu::ScreenDescriptor;
use image::RgbaImage;
use pelage_runtime::wgpu;
use pelage_stage::{Gpu, Look, StageError};
use serde_json::json;
use std::io::Write;
use std::panic::{self, AssertUnwindSafe};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::{StartCause, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop, EventLoopProxy};
use winit::window::{Window, WindowId};

/// Initial options of a window.
pub struct ViewOptions {
    /// File to open first; `None` waits for a file to be dropped.
    pub open: Option<PathBuf>,
    /// Initial look, before the user's changes.
    pub look: Look,
    /// Width and height of the window, physical pixels.
    pub size: (u32, u32),
    /// Folder for saved pictures.
    pub folder: PathBuf,
    /// Whether panels are initially visible.
    pub panels: bool,
    /// Function that loads an environment map.
    pub lights_of: LoadLights,
    /// Function that loads the image of a seal.
    pub seal_of: LoadSeal,
    /// Event log for scripts, one line of JSON per event.
    pub events: Option<Box<dyn Write + Send>>,
    /// Start time of the program; times in the event log are relative to it.
    pub began: Instant,
}

/// Reason why a window cannot be opened, or was closed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ViewError {
    /// No display is available.
    #[error(
        "no window can be opened: {0}\nA window needs a desktop: on Linux an X server (DISPLAY; Wayland desktops \
             provide one, Xwayland) and libxkbcommon-x11. Without one, `pelage render` draws into files."
    )]
    NoDisplay(String),
    /// No device can draw to the window, or the device was lost.
    #[error(transparent)]
    Stage(#[from] StageError),
}

/// Opens a window that shows the content of `workshop`. Returns when the window is closed.
///
/// Fails with [`ViewError::NoDisplay`] without a display. [`ViewError::Stage`] without a device, or if the device is
/// lost and cannot be restored.
pub fn view(options: ViewOptions, workshop: Box<dyn Workshop>) -> Result<(), ViewError> {
    let event_loop = event_loop()?;
    let proxy = event_loop.create_proxy();
    let mut host = Host { begins: Some((options, workshop)), proxy, open: None, failure: None };
    let ran = event_loop.run_app(&mut host).map_err(|error| ViewError::NoDisplay(error.to_string()));
    host.failure.map_or(ran, Err)
}

/// Creates winit's event loop. Converts a panic, caused by a missing system library, to an error.
fn event_loop() -> Result<EventLoop<WorkerMessage>, ViewError> {
    let hook = panic::take_hook();
    panic::set_hook(Box::new(|_| ()));
    let made = panic::catch_unwind(AssertUnwindSafe(|| EventLoop::with_user_event().build()));
    panic::set_hook(hook);
    match made {
        Ok(Ok(event_loop)) => Ok(event_loop),
        Ok(Err(error)) => Err(ViewError::NoDisplay(error.to_string())),
        Err(_) => Err(ViewError::NoDisplay("a library of the window system is missing".into())),
    }
}

/// winit application. Has no window until the system allows one.
struct Host {
    begins: Option<(ViewOptions, Box<dyn Workshop>)>,
    proxy: EventLoopProxy<WorkerMessage>,
    open: Option<OpenWindow>,
    failure: Option<ViewError>,
}

struct OpenWindow {
    window: Arc<Window>,
    instance: wgpu::Instance,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    gpu: Gpu,
    egui: Context,
    input: egui_winit::State,
    painter: egui_wgpu::Renderer,
    picture: Option<TextureId>,
    app: App,
    /// Time of the next frame, unless user input comes first.
    due: Option<Instant>,
}

impl Host {
    fn fail(&mut self, event_loop: &ActiveEventLoop, error: ViewError) {
        self.failure = Some(error);
        event_loop.exit();
    }

    fn open(&mut self, event_loop: &ActiveEventLoop) -> Result<(), ViewError> {
        let Some((options, workshop)) = self.begins.take() else { return Ok(()) };
        let (width, height) = options.size;
        let attributes =
            Window::default_attributes().with_title("pelage").with_inner_size(PhysicalSize::new(width, height));
        let window = event_loop.create_window(attributes).map_err(|e| ViewError::NoDisplay(e.to_string()))?;
        self.open = Some(OpenWindow::new(Arc::new(window), event_loop, options, workshop, &self.proxy)?);
        Ok(())
    }

    fn frame(&mut self, event_loop: &ActiveEventLoop) {
        if let Some(open) = &mut self.open
            && let Err(error) = open.frame()
        {
            self.fail(event_loop, error.into());
        }
    }
}

impl ApplicationHandler<WorkerMessage> for Host {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if let Err(error) = self.open(event_loop) {
            self.fail(event_loop, error);
        }
    }

    fn new_events(&mut self, _: &ActiveEventLoop, cause: StartCause) {
        if let (StartCause::ResumeTimeReached { .. }, Some(open)) = (cause, &mut self.open) {
            open.due = None;
            open.window.request_redraw();
        }
    }

    fn user_event(&mut self, _: &ActiveEventLoop, told: WorkerMessage) {
        if let Some(open) = &mut self.open {
            open.app.handle_message(told, &open.egui);
            open.window.set_title(&open.app.title());
            open.window.request_redraw();
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(open) = &mut self.open else { return };
        match &event {
            WindowEvent::CloseRequested => return event_loop.exit(),
            WindowEvent::RedrawRequested => return self.frame(event_loop),
            WindowEvent::Resized(size) => open.resize(*size),
            WindowEvent::DroppedFile(path) => open.app.open(path),
            _ => {}
        }
        if open.input.on_window_event(&open.window, &event).repaint {
            open.window.request_redraw();
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        let due = self.open.as_ref().and_then(|open| open.due);
        event_loop.set_control_flow(due.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }
}

impl OpenWindow {
    fn new(
        window: Arc<Window>,
        event_loop: &ActiveEventLoop,
        options: ViewOptions,
        workshop: Box<dyn Workshop>,
        proxy: &EventLoopProxy<WorkerMessage>,
    ) -> Result<Self, ViewError> {
        let display = Box::new(event_loop.owned_display_handle());
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_with_display_handle_from_env(display));
        let none = |error: &dyn std::fmt::Display| StageError::NoAdapter(error.to_string());
        let surface = instance.create_surface(window.clone()).map_err(|error| none(&error))?;
        let chosen = wgpu::util::initialize_adapter_from_env_or_default(&instance, Some(&surface));
        let adapter = pollster::block_on(chosen).map_err(|error| none(&error))?;
        let gpu = Gpu::of_adapter(&adapter)?;
        let size = window.inner_size();
        let mut config = surface
            .get_default_config(&adapter, size.width.max(1), size.height.max(1))
            .ok_or_else(|| none(&"it cannot draw on the window's surface"))?;
        // egui writes sRGB-encoded values, and the picture is encoded already, so the surface must not encode again.
        config.format = config.format.remove_srgb_suffix();
        config.desired_maximum_frame_latency = 1;
        surface.configure(&gpu.device, &config);

        let egui = Context::default();
        egui.set_theme(egui::Theme::Dark);
        let limit = gpu.device.limits().max_texture_dimension_2d as usize;
        let scale = Some(window.scale_factor() as f32);
        let input = egui_winit::State::new(egui.clone(), ViewportId::ROOT, &window, scale, None, Some(limit));
        let painter = egui_wgpu::Renderer::new(&gpu.device, config.format, egui_wgpu::RendererOptions::default());

        let proxy = proxy.clone();
        // If the window is closed, the message is dropped.
        let workers = Workers::start(workshop, &(Arc::new(move |told| drop(proxy.send_event(told))) as _));
        let mut events = Events::new(options.began, options.events);
        let is_software = gpu.info.device_type == wgpu::DeviceType::Cpu;
        let adapter = gpu.info.name.clone();
        events.log("adapter", json!({ "adapter": adapter, "software": is_software }));
        let mut app = App::new(Show::new(gpu.clone()), workers, events, options.folder, options.look);
        app.panels = options.panels;
        app.lights = Lights::new(options.lights_of, options.seal_of);
        app.adapter = if is_software {
            format!("{adapter} (software rendering: lower resolution while moving)")
        } else {
            adapter
        };
        if let Some(path) = &options.open {
            app.open(path);
        }
        window.request_redraw();
        Ok(Self { window, instance, surface, config, gpu, egui, input, painter, picture: None, app, due: None })
    }

    fn resize(&mut self, size: PhysicalSize<u32>) {
        if size.width > 0 && size.height > 0 {
            let limit = self.gpu.device.limits().max_texture_dimension_2d;
            (self.config.width, self.config.height) = (size.width.min(limit), size.height.min(limit));
            self.surface.configure(&self.gpu.device, &self.config);
        }
    }

    /// Runs one frame: handles input, draws the picture, presents the window.
    fn frame(&mut self) -> Result<(), StageError> {
        let taken = self.input.take_egui_input(&self.window);
        let (app, drawn) = (&mut self.app, self.picture);
        let egui::FullOutput { platform_output, textures_delta, shapes, pixels_per_point, viewport_output, .. } =
            self.egui.run_ui(taken, |ui| ui::lay_out(ui, app, drawn));
        self.input.handle_platform_output(&self.window, platform_output);
        let mut textures = textures_delta;
        for (id, deltas) in textures.set.drain() {
            deltas.iter().for_each(|delta| self.painter.update_texture(&self.gpu.device, &self.gpu.queue, id, delta));
        }
        let gone: Vec<TextureId> = textures.free.drain().collect();

        let step = self.app.next_frame()?;
        if step.drew {
            self.take_picture();
        }
        let painted = self.egui.tessellate(shapes, pixels_per_point);
        let screen = ScreenDescriptor { size_in_pixels: [self.config.width, self.config.height], pixels_per_point };
        if let Some(target) = self.acquire() {
            self.paint(&target.texture, &painted, &screen);
            self.window.pre_present_notify();
            self.gpu.queue.present(target);
        }
        if let Some(path) = self.app.take_window() {
            let saved = self.save_window(&painted, &screen).and_then(|image| save::write_png(&path, &image));
            self.app.window_saved(saved.map(|()| path));
        }
        gone.iter().for_each(|id| self.painter.free_texture(id));

        let delay = viewport_output.get(&ViewportId::ROOT).map_or(Duration::MAX, |output| output.repaint_delay);
        let delay = step.wait.map_or(delay, |wait| wait.min(delay));
        // The first picture did not exist when the window was laid out, so the next frame follows at once.
        let delay = if step.drew && drawn.is_none() { Duration::ZERO } else { delay };
        self.due = if delay.is_zero() { None } else { Instant::now().checked_add(delay) };
        if delay.is_zero() {
            self.window.request_redraw();
        }
        Ok(())
    }

    /// Passes the drawn picture to the window's painter.
    fn take_picture(&mut self) {
        let Some(view) = self.app.show.picture_view() else { return };
        let (device, filter) = (&self.gpu.device, wgpu::FilterMode::Linear);
        match self.picture {
            Some(id) => self.painter.update_egui_texture_from_wgpu_texture(device, &view, filter, id),
            None => self.picture = Some(self.painter.register_native_texture(device, &view, filter)),
        }
    }

    /// Returns the surface's next texture. `None` if there is none in this frame, or none at all.
    fn acquire(&mut self) -> Option<wgpu::SurfaceTexture> {
        use wgpu::CurrentSurfaceTexture as Current;
        for _ in 0..2 {
            match self.surface.get_current_texture() {
                Current::Success(texture) => return Some(texture),
                Current::Suboptimal(texture) => {
                    drop(texture);
                    self.surface.configure(&self.gpu.device, &self.config);
                }
                Current::Outdated | Current::Validation => self.surface.configure(&self.gpu.device, &self.config),
                Current::Lost => {
                    if let Ok(surface) = self.instance.create_surface(self.window.clone()) {
                        self.surface = surface;
                        self.surface.configure(&self.gpu.device, &self.config);
                    }
                }
                Current::Timeout | Current::Occluded => return None,
            }
        }
        None
    }

    fn paint(&mut self, target: &wgpu::Texture, painted: &[egui::ClippedPrimitive], screen: &ScreenDescriptor) {
        let (device, queue) = (&self.gpu.device, &self.gpu.queue);
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("window") });
        let more = self.painter.update_buffers(device, queue, &mut encoder, painted, screen);
        let view = target.create_view(&wgpu::TextureViewDescriptor::default());
        let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("window"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
        self.painter.render(&mut pass.forget_lifetime(), painted, screen);
        queue.submit(more.into_iter().chain([encoder.finish()]));
    }

    /// Saves a screenshot: paints the window again and reads it back.
    fn save_window(
        &mut self,
        painted: &[egui::ClippedPrimitive],
        screen: &ScreenDescriptor,
    ) -> Result<RgbaImage, String> {
        let [width, height] = screen.size_in_pixels;
        let format = self.config.format;
        let target = self.gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("window"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        self.paint(&target, painted, screen);
        let mut texels = self.gpu.read_texture(&target, 0).map_err(|error| error.to_string())?;
        for texel in texels.chunks_exact_mut(4) {
            if format == wgpu::TextureFormat::Bgra8Unorm {
                texel.swap(0, 2);
            }
            texel[3] = 255;
        }
        RgbaImage::from_raw(width, height, texels).ok_or_else(|| "the window was read back incompletely".into())
    }
}
