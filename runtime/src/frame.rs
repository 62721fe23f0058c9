//! One frame, in the order in which its passes run:
//!
//! | pass | recorded by | draws | when |
//! |---|---|---|---|
//! | `pose` | [`crate::Renderer::prepare`] | compute: posed vertices | an instance's pose changed |
//! | `layer_shadow` | [`crate::Renderer::prepare`] | transmittance above each layer, seen from the key light | self-shadow on, and light, pose or package changed |
//! | `shadow_width` | [`crate::Renderer::prepare`] | depth maps, occlusion, shrunk and stretched | soft shadow on, and light, pose or package changed |
//! | `ink_normals`, `ink_features`, `ink_dilate`, `ink_stroke` | [`crate::Renderer::prepare`] | surfaces, the pixels that lines run through, the lines | style is ink |
//! | `skin` | [`Frame::draw`] | opaque base mesh, depth written | always |
//! | `fins` | [`Frame::draw`] | quads of hair along the outline | fur visible, package has fins |
//! | `shells` | [`Frame::draw`] | layers of hair, inside to outside | fur visible |
//! | `ink_composite` | [`Frame::draw`] | paper, wash and lines | style is ink |
//! | `ink_fur` | [`Frame::draw`] | strokes of fur on fins and outer shells | style is ink, package has strokes |
//!
//! In ink none of `layer_shadow` to `shells` runs but those named so: an ink painting has no light.

use crate::detail::Drawing;
use crate::ink::painted_rect;
use crate::light_view::{Hull, LightView};
use crate::params::MAX_FILL_LIGHTS;
use crate::passes::fins::{self, FinDraws};
use crate::passes::key::{Look, ShadowLook};
use crate::passes::{PassId, ink, ink_fur, layer_shadow, pose, shadow_width, shells, skin};
use crate::renderer::Pipelines;
use crate::report::{self, FrameReport};
use crate::shadow::{CasterPass, Casters, PenumbraForm, ShadowKey, ShadowMaps, SlantForm};
use crate::shared::receiver::ShadowReceiver;
use crate::shared::{detail, frame as blocks, kajiya_kay, skinning};
use crate::{FrameParams, Instance, Model, RuntimeError, Style};
use glam::{Mat3, Mat4, Vec3};
use pelage_formats::{CoatInfo, Shading};
use std::ops::Range;
use std::sync::Arc;
use wgpu::util::DeviceExt;

/// A prepared frame: everything that [`Frame::draw`] needs, held until it is dropped.
#[derive(Debug)]
pub struct Frame {
    bind_group: wgpu::BindGroup,
    instances: Vec<Drawn>,
    shadows: Option<Arc<ShadowMaps>>,
    /// Of the shadow-width map, or a white texel.
    shadow_map: wgpu::TextureView,
    /// What paints an ink frame.
    sheet: Option<ink::Sheet>,
    report: FrameReport,
}

/// What one instance draws.
#[derive(Debug)]
pub(crate) struct Drawn {
    pub(crate) model: Model,
    geometry: wgpu::Buffer,
    uniform_offset: u32,
    /// One pipeline for each of the model's parts.
    pub(crate) skin: Vec<wgpu::RenderPipeline>,
    /// Numbers and pipelines of the furred parts.
    pub(crate) shells: Vec<(usize, wgpu::RenderPipeline)>,
    /// What it draws of its fins.
    pub(crate) fins: Option<FinDraws>,
    /// Numbers and pipelines of what the key light sees, where the maps are drawn: furred parts by layers, and all parts by depth.
    pub(crate) layer_shadow: Vec<(usize, wgpu::RenderPipeline)>,
    pub(crate) casters: [Vec<(usize, wgpu::RenderPipeline)>; 2],
    /// How much of its fur is drawn.
    pub(crate) drawing: Drawing,
    /// What it draws in ink.
    pub(crate) ink: Option<ink::InkDraws>,
    /// Instances of the shells' draw.
    pub(crate) shell_instances: Range<u32>,
}

impl Drawn {
    /// Binds what every pass over the model's triangles reads.
    pub(crate) fn bind(&self, pass: &mut wgpu::RenderPass<'_>, frame: &wgpu::BindGroup) {
        pass.set_bind_group(0, frame, &[self.uniform_offset]);
        pass.set_bind_group(2, self.model.fur(), &[]);
        pass.set_vertex_buffer(0, self.geometry.slice(..));
        pass.set_vertex_buffer(1, self.model.attributes().slice(..));
        pass.set_index_buffer(self.model.indices().slice(..), wgpu::IndexFormat::Uint32);
    }
}

#[expect(clippy::too_many_arguments, reason = "what a frame is made of; the renderer's methods give it shorter forms")]
pub(crate) fn prepare(
    device: &wgpu::Device,
    encoder: &mut wgpu::CommandEncoder,
    pipelines: &mut Pipelines,
    shadows: &mut Option<Arc<ShadowMaps>>,
    params: &FrameParams,
    instances: &mut [&mut Instance],
    casters: Option<&mut Casters<'_>>,
    mark: &mut dyn FnMut(&mut wgpu::CommandEncoder, PassId),
) -> Result<Frame, RuntimeError> {
    params.check(&device.limits())?;
    let clip_from_view = params.camera.check(pipelines.reversed_depth())?;
    instances.iter().try_for_each(|instance| instance.check())?;
    let in_ink = params.ink.as_ref().filter(|_| params.style == Style::Ink);
    if in_ink.is_some() {
        instances.iter().try_for_each(|instance| instance.model().has_ink())?;
    }
    let light_ws = params.light.homogeneous()?;
    let fills = fill_lights(device, params)?;
    let posed = pose::record(device, encoder, pipelines, instances)?;
    mark(encoder, PassId::Pose);

    let drawings: Vec<_> = instances.iter().map(|i| Drawing::of(i, params, clip_from_view)).collect();
    let key = shadow_key(params, instances, &drawings, casters.as_deref());
    let redraw = key.as_ref().is_some_and(|key| shadows.as_ref().is_none_or(|maps| maps.key != *key));
    let stride = block_stride(device);
    let mut drawn = Vec::new();
    for (index, (instance, drawing)) in instances.iter().zip(&drawings).enumerate() {
        let model = instance.model();
        let look = look(model, params, drawing, instance.transform, key.as_ref());
        let from_light = look.seen_from_light(model, key.as_ref());
        drawn.push(Drawn {
            model: model.clone(),
            geometry: instance.geometry().clone(),
            uniform_offset: (index as u32 + 1) * stride,
            skin: if in_ink.is_some() { Vec::new() } else { skin::plan(device, pipelines, model, &look) },
            shells: if drawing.has_shells() { shells::plan(device, pipelines, model, &look) } else { Vec::new() },
            fins: if look.fins { fins::draws(device, pipelines, instance, &look) } else { None },
            layer_shadow: if redraw && params.self_shadow && drawing.has_shells() {
                layer_shadow::plan(device, pipelines, model, &from_light)
            } else {
                Vec::new()
            },
            casters: if redraw {
                shadow_width::plan(device, pipelines, model, &from_light)
            } else {
                Default::default()
            },
            ink: in_ink.and_then(|ink| pipelines.plan_ink(device, params, ink, instance)),
            drawing: *drawing,
            shell_instances: params
                .only_layer
                .map_or_else(|| drawing.shell_instances(), |k| k..(k + 1).min(drawing.layers)),
        });
    }

    let view = key.as_ref().map(|key| key.view);
    let mut frame = blocks::Frame {
        clip_from_world: (clip_from_view * params.camera.view_from_world).to_cols_array_2d(),
        eye_ws: params.camera.eye_ws(clip_from_view).to_array(),
        light_ws: light_ws.to_array(),
        map_from_world: view.map_or(Mat4::IDENTITY, |view| view.map_from_world).to_cols_array_2d(),
        soft_shadow: [0.0; 4],
        last_map_layer: key.as_ref().map_or(0.0, |key| (key.map_layers - 1) as f32),
        fill_lights: params.fill_lights.len() as u32,
        // Also what the hair of a far coat meets, which has no maps.
        hair_density: if params.self_shadow { params.shadows.density } else { 0.0 },
        reserved: 0,
    };
    let upload = |frame: &blocks::Frame, maps: Option<&ShadowMaps>| {
        let block = |(i, drawing): (&&mut Instance, &Drawing)| {
            let layers = maps.map_or(drawing.layers, |maps| maps.key.map_layers);
            let map_level = maps.map_or(0.0, |maps| map_level(i, maps));
            blocks::Instance { map_level, ..instance_block(i, params, drawing, layers) }
        };
        upload_blocks(device, stride, frame, instances.iter().zip(&drawings).map(block))
    };
    if let Some(key) = key.filter(|_| redraw) {
        // Maps that another frame still reads stay as they are.
        let previous = shadows.take().and_then(|maps| Arc::try_unwrap(maps).ok()).filter(|maps| maps.fits(&key));
        let maps = match previous {
            Some(maps) => ShadowMaps { key, ..maps },
            None => ShadowMaps::new(device, key),
        };
        let light_frame = blocks::Frame {
            clip_from_world: maps.view().clip_from_world.to_cols_array_2d(),
            eye_ws: light_ws.to_array(),
            ..frame
        };
        let buffer = upload(&light_frame, Some(&maps));
        let group = pipelines.layouts.frame_bind_group(device, &buffer, &fills, None);
        let mut casters = casters;
        let depth = shadow_width::record_depth;
        depth(encoder, &maps, CasterPass::Nearest, &group, &drawn, casters.as_deref_mut());
        layer_shadow::record(encoder, &maps, &group, &drawn);
        mark(encoder, PassId::LayerShadow);
        depth(encoder, &maps, CasterPass::Farthest, &group, &drawn, casters);
        shadow_width::record(device, encoder, pipelines, &maps);
        mark(encoder, PassId::ShadowWidth);
        *shadows = Some(Arc::new(maps));
    } else {
        mark(encoder, PassId::LayerShadow);
        mark(encoder, PassId::ShadowWidth);
    }
    let maps = shadows.clone().filter(|_| view.is_some());
    if let Some(maps) = &maps {
        let s = maps.soft_shadow();
        frame.soft_shadow = [s.range_m, s.penumbra, s.blur, s.texel];
    }
    let report = report::report(posed, &drawn, params, maps.as_deref(), redraw);
    let buffer = upload(&frame, None);
    let bind_group = pipelines.layouts.frame_bind_group(device, &buffer, &fills, maps.as_deref());
    if in_ink.is_none() {
        let skipped = [PassId::InkNormals, PassId::InkFeatures, PassId::InkDilate, PassId::InkStroke];
        skipped.into_iter().for_each(|id| mark(encoder, id));
    }
    let sheet = in_ink.map(|ink| {
        let (inks, making) = pipelines.ink(device, &params.camera);
        let mut hull = Hull::default();
        instances.iter().for_each(|instance| instance.add_to(&mut hull));
        let rect = painted_rect(&hull, clip_from_view * params.camera.view_from_world, ink);
        let recording = ink::Recording { making, params: ink, rect, frame: &bind_group, instances: &drawn };
        ink::record(inks, encoder, &recording, mark)
    });
    let width = maps.as_deref().and_then(ShadowMaps::width);
    let shadow_map = width.map_or_else(|| pipelines.layouts.white.clone(), |map| map.create_view(&Default::default()));
    Ok(Frame { bind_group, instances: drawn, shadows: maps, shadow_map, sheet, report })
}

/// What the shadow maps of a frame depend on; `None` where it needs none.
fn shadow_key(
    params: &FrameParams,
    instances: &[&mut Instance],
    drawings: &[Drawing],
    casters: Option<&Casters<'_>>,
) -> Option<ShadowKey> {
    // The finest instance decides; what draws other layers reads between the maps.
    let layers = drawings.iter().map(|d| d.map_layers).max()?;
    let self_shadow = params.self_shadow && layers > 1;
    // A light without light throws no shadow, and in ink there is none.
    if params.style == Style::Ink {
        return None;
    }
    if !(self_shadow || params.soft_shadow) || params.light.color() == Vec3::ZERO {
        return None;
    }
    let mut hull = Hull::default();
    instances.iter().for_each(|instance| instance.add_to(&mut hull));
    hull.0.extend(casters.and_then(|c| c.bounds).map(|b| (b.center, b.radius)));
    // A model that no joint holds yet, as before its first frame, is a point.
    if hull.0.is_empty() {
        hull.0.extend(instances.iter().map(|i| (i.transform.w_axis.truncate(), 0.0)));
    }
    let sphere = hull.sphere()?;
    Some(ShadowKey {
        light: params.light,
        view: LightView::new(&params.light, &hull, sphere),
        params: params.shadows,
        self_shadow,
        soft_shadow: params.soft_shadow,
        map_layers: if self_shadow { params.shadows.map_layers.unwrap_or(layers).min(256) } else { 1 },
        instances: instances.iter().zip(drawings).map(|(i, d)| i.shadow_key(d.has_shells())).collect(),
        casters: casters.map(|c| c.revision),
    })
}

impl Frame {
    /// Records every pass into the application's render pass, whose targets must be as [`crate::RendererOptions`] said. Leaves
    /// pipeline, bind groups 0..=3, vertex buffers 0 and 1 and the index buffer changed.
    pub fn draw(&self, pass: &mut wgpu::RenderPass<'_>) {
        self.draw_pass(PassId::Skin, pass);
        self.draw_pass(PassId::Fins, pass);
        self.draw_pass(PassId::Shells, pass);
        self.draw_pass(PassId::InkComposite, pass);
        self.draw_pass(PassId::InkFur, pass);
    }

    /// Records one pass alone, for measuring, or for drawing between skin and shells. [`PassId::Pose`] and those of the shadows
    /// were recorded by [`crate::Renderer::prepare`] and do nothing here.
    pub fn draw_pass(&self, id: PassId, pass: &mut wgpu::RenderPass<'_>) {
        if let (PassId::InkComposite, Some(sheet)) = (id, &self.sheet) {
            sheet.draw(pass);
        }
        for instance in &self.instances {
            let empty = match id {
                PassId::Skin => instance.skin.is_empty(),
                PassId::Fins => instance.fins.is_none(),
                PassId::Shells => instance.shells.is_empty(),
                PassId::InkFur => instance.ink.as_ref().is_none_or(ink::InkDraws::is_bald),
                // Recorded before, or not an instance's.
                _ => true,
            };
            if empty {
                continue;
            }
            instance.bind(pass, &self.bind_group);
            match id {
                PassId::Skin => skin::record(pass, instance),
                PassId::Fins => instance.fins.iter().for_each(|fins| fins::record(pass, &instance.model, fins)),
                PassId::Shells => shells::record(pass, instance),
                PassId::InkFur => ink_fur::record(pass, instance),
                _ => {}
            }
        }
    }

    /// What the application's own shader needs to receive the key light's shadows, besides [`Self::shadow_map`]: the uniform block of
    /// [`crate::shared::receiver`]. Without shadow-width map ([`FrameParams::soft_shadow`] off, a dark light, no instance) it
    /// lights everything, so that one pipeline serves all frames.
    pub fn shadow_receiver(&self) -> ShadowReceiver {
        self.shadows().and_then(ShadowMaps::receiver).unwrap_or_default()
    }

    /// The shadow-width map, [`ShadowMaps::WIDTH_FORMAT`], or one white texel where the frame has none: a filterable two-dimensional
    /// float texture in either case. It holds as long as [`Self::shadows`].
    pub fn shadow_map(&self) -> &wgpu::TextureView {
        &self.shadow_map
    }

    /// The key light's shadow maps themselves; `None` where the frame has none. They hold until a later frame draws them anew, which
    /// the order of submission settles: submit what reads them before that frame's encoder.
    pub fn shadows(&self) -> Option<&ShadowMaps> {
        self.shadows.as_deref()
    }

    /// Which passes run in this frame, and why the others do not.
    pub fn report(&self) -> &FrameReport {
        &self.report
    }
}

/// Compiles what a frame with these parameters needs, whatever the model's size on screen.
pub(crate) fn compile(device: &wgpu::Device, pipelines: &mut Pipelines, model: &Model, params: &FrameParams) {
    if model.skeleton().is_some() {
        pipelines.pose(device);
    }
    if let (Style::Ink, Some(ink)) = (params.style, &params.ink) {
        pipelines.compile_ink(device, model, params, ink);
        return;
    }
    for drawing in Drawing::all(model.manifest(), params) {
        let key = light_alone(model, params, &drawing);
        let look = look(model, params, &drawing, Mat4::IDENTITY, key.as_ref());
        let from_light = look.seen_from_light(model, key.as_ref());
        if params.self_shadow && key.is_some() && drawing.has_shells() {
            layer_shadow::plan(device, pipelines, model, &from_light);
        }
        if key.is_some() {
            shadow_width::plan(device, pipelines, model, &from_light);
        }
        if params.soft_shadow && key.is_some() {
            pipelines.filter(device);
        }
        skin::plan(device, pipelines, model, &look);
        if drawing.has_shells() {
            shells::plan(device, pipelines, model, &look);
        }
        if look.fins {
            fins::plan(device, pipelines, model, &look);
        }
    }
}

/// The key of a frame of one model, as far as pipelines depend on it.
fn light_alone(model: &Model, params: &FrameParams, drawing: &Drawing) -> Option<ShadowKey> {
    let mut instance = Instance::new(model);
    shadow_key(params, &[&mut instance], &[*drawing], None)
}

fn look(model: &Model, params: &FrameParams, drawing: &Drawing, transform: Mat4, shadows: Option<&ShadowKey>) -> Look {
    let manifest = model.manifest();
    Look {
        style: params.style,
        yardstick: params.yardstick,
        mirrored: skinning::handedness_of(Mat3::from_mat4(transform)) < 0.0,
        resampled: drawing.layers != manifest.fur.layers,
        detail: drawing.is_reduced(),
        coat: drawing.detail.coat > 0.0,
        fins: params.fins && model.fins().is_some() && drawing.has_shells() && drawing.detail.fins > 0.0,
        view_slanted: params.slant == SlantForm::Corrected,
        shadows: shadows.map_or_else(ShadowLook::default, |key| ShadowLook {
            self_shadow: key.self_shadow,
            slanted: key.self_shadow && key.params.slant == SlantForm::Corrected,
            // Reduced layers are lit at the height of the hair seen in them.
            maps_between: key.self_shadow && (key.map_layers != drawing.layers || drawing.is_reduced()),
            soft_shadow: key.soft_shadow,
            centred: key.soft_shadow && key.params.penumbra_form == PenumbraForm::Centred,
        }),
        fill_lights: !params.fill_lights.is_empty(),
        lighting: params.lighting,
        shading: params.shading.unwrap_or(manifest.shading),
    }
}

impl Look {
    /// The same instance as the key light sees it.
    fn seen_from_light(self, model: &Model, key: Option<&ShadowKey>) -> Self {
        let layers = key.map_or(0, |key| key.map_layers);
        Self { resampled: layers != model.manifest().fur.layers, ..self }
    }
}

/// Lights without shadow, as the shaders read them.
fn fill_lights(device: &wgpu::Device, params: &FrameParams) -> Result<wgpu::Buffer, RuntimeError> {
    let mut lights = [blocks::FillLight::default(); MAX_FILL_LIGHTS];
    for (slot, light) in lights.iter_mut().zip(&params.fill_lights) {
        *slot = blocks::FillLight {
            light_ws: light.homogeneous()?.to_array(),
            color: light.color().extend(0.0).to_array(),
        };
    }
    Ok(device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("pelage fill lights"),
        contents: bytemuck::bytes_of(&lights),
        usage: wgpu::BufferUsages::UNIFORM,
    }))
}

/// Bytes from one block to the next.
fn block_stride(device: &wgpu::Device) -> u32 {
    let largest = size_of::<blocks::Frame>().max(size_of::<blocks::Instance>()) as u32;
    largest.next_multiple_of(device.limits().min_uniform_buffer_offset_alignment)
}

/// The frame's block, then each instance's, `stride` bytes apart.
fn upload_blocks(
    device: &wgpu::Device,
    stride: u32,
    frame: &blocks::Frame,
    instances: impl Iterator<Item = blocks::Instance>,
) -> wgpu::Buffer {
    let mut bytes = bytemuck::bytes_of(frame).to_vec();
    for (index, block) in instances.enumerate() {
        bytes.resize((index + 1) * stride as usize, 0);
        bytes.extend_from_slice(bytemuck::bytes_of(&block));
    }
    // A bind group without instances still covers one instance block.
    bytes.resize(bytes.len().max(2 * stride as usize), 0);
    device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("pelage frame"),
        contents: &bytes,
        usage: wgpu::BufferUsages::UNIFORM,
    })
}

/// Mip level of an instance's hair whose texels are as large as those of the maps, whole: one level is read, not two.
fn map_level(instance: &Instance, maps: &ShadowMaps) -> f32 {
    let fur = &instance.model().manifest().fur;
    let scale = Mat3::from_mat4(instance.transform).determinant().abs().cbrt();
    let hair_m = scale * fur.tile_size_m / fur.tile_texels.max(1) as f32;
    let level = (maps.texel_m() / hair_m).log2().round();
    // Of hair without a size there is no level.
    if level.is_finite() { level.max(0.0) } else { 0.0 }
}

/// `drawn`: layers, skin counted; 1 where no fur shows.
fn instance_block(instance: &Instance, params: &FrameParams, drawing: &Drawing, drawn: u32) -> blocks::Instance {
    let manifest = instance.model().manifest();
    let shading = params.shading.unwrap_or(manifest.shading);
    let linear = Mat3::from_mat4(instance.transform);
    let handedness = skinning::handedness_of(linear);
    let cofactor = |a: Vec3, b: Vec3| -> [f32; 4] { (a.cross(b) * handedness).extend(0.0).to_array() };
    let constant = |k: [f32; 3], light: Vec3| (Vec3::from(k) * light).to_array();
    let unit = Shading { specular: [1.0; 3], ..shading };
    let baked = manifest.fur.layers;
    let coat = manifest.coat.unwrap_or_default();
    let [coat_light_base, coat_light_slope] = coat_light(&coat, params);
    blocks::Instance {
        world_from_model: instance.transform.to_cols_array_2d(),
        normal_x: cofactor(linear.y_axis, linear.z_axis),
        normal_y: cofactor(linear.z_axis, linear.x_axis),
        normal_z: cofactor(linear.x_axis, linear.y_axis),
        ambient: constant(shading.ambient, params.ambient),
        diffuse_half_exponent: 0.5 * shading.diffuse_exponent,
        diffuse: constant(shading.diffuse, params.light.color()),
        specular_half_exponent: 0.5 * shading.specular_exponent,
        specular: constant(shading.specular, params.light.color()),
        back_light_range: if params.back_attenuation {
            shading.back_light_range
        } else {
            kajiya_kay::BACK_ATTENUATION_OFF
        },
        ambient_floor: if params.ambient_attenuation { shading.ambient_floor } else { 1.0 },
        scale: linear.determinant().abs().cbrt(),
        handedness,
        opacity_exponent: if drawn > 1 && baked > 1 { (baked - 1) as f32 / (drawn - 1) as f32 } else { 1.0 },
        baked_layers: baked,
        // The shaders divide by one less.
        drawn_layers: drawn.max(2),
        wet_specular: unit.wet().specular[0],
        wet_specular_half_exponent: 0.5 * shading.wet().specular_exponent,
        diffuse_constant: shading.diffuse,
        map_level: 0.0,
        specular_constant: shading.specular,
        detail_here: drawing.weights[0],
        // The shaders divide by it; a level without layers draws none.
        layer_step: drawing.step.max(1),
        next_step: drawing.next_step,
        detail_next: drawing.weights[1],
        fin_share: drawing.detail.fins,
        coat_height: coat.height,
        coat_ambient_height: coat.ambient_height,
        coat_light_base,
        coat_light_slope,
    }
}

/// How the key light reaches the hair of a far coat: the numbers of `coat_light` in the shaders.
fn coat_light(coat: &CoatInfo, params: &FrameParams) -> [f32; 2] {
    if !params.self_shadow {
        return [1.0, 0.0];
    }
    let [base, slope] = detail::coat_light_numbers(coat);
    let slope = slope * params.shadows.density;
    match params.shadows.slant {
        SlantForm::Corrected => [base, slope],
        // All light comes straight.
        SlantForm::Printed => [base + slope, 0.0],
    }
}
