//! Preparation of a frame: checks the input, poses and culls instances, selects shadow maps and writes uniforms.

use super::blocks::{fill_lights, frame_block, instance_block, map_level};
use super::ink::{InkScene, InkView};
use super::nearest::{NearestSegments, area, has_ribbons, with_supported_edges};
use super::recording::{Recording, RendererState};
use super::ribbons::Ribbons;
use super::visible_instance::{VisibleContours, VisibleInstance, VisiblePainting, VisibleStrandSet};
use crate::bounds::Hull;
use crate::contours::{ContourBlock, ContourBuffers, ContourView, LineBrush};
use crate::error::RuntimeError;
use crate::gpu::{BindingResource, Pool, Target, UniformRange, take_targets};
use crate::hair::{InstanceDrawing, StrandSetDrawing, Variant};
use crate::instance::Instance;
use crate::light::{Casters, DeepMapHair, InstanceKey, ShadowKey, ShadowMaps, get_or_create};
use crate::motion::PosedInstance;
use crate::painting::{PaintedModel, PaintedStrokes, PaintingFrame, PaintingView};
use crate::params::{FrameParams, InkLines, InkParams, SelfShadow, StrandEdges};
use crate::shared::frame as blocks;
use crate::surface::Lights;
use pelage_formats::PaintStroke;
use std::collections::HashSet;
use std::sync::Arc;

fn check_instances(params: &FrameParams, instances: &[&Instance]) -> Result<(), RuntimeError> {
    let mut owners = HashSet::new();
    for instance in instances {
        instance.check()?;
        if !owners.insert(instance.owner) {
            return Err(RuntimeError::Params {
                field: "Instance::owner",
                found: format!("{} twice in one frame", instance.owner),
                expected: "a different number for each instance".into(),
            });
        }
        if params.style.ink().is_some() {
            instance.model.require_ink()?;
        }
    }
    Ok(())
}

/// Returns the form in which a frame's ink lines are drawn. Strokes need a stroke pool or a contour mesh in every
/// package, and storage buffers in vertex shaders.
pub(crate) fn drawn_lines(kept: &RendererState, ink: &InkParams, instances: &[&Instance]) -> InkLines {
    let supported = kept.surfaces.fins.is_some() && kept.surfaces.strands;
    let strokes = supported
        && instances.iter().all(|instance| instance.model.painting().is_some() || instance.model.contours().is_some());
    if strokes { ink.lines } else { InkLines::Pixels }
}

/// Begins a frame. All checks that can fail precede any change of state.
pub(crate) fn begin<'f>(
    kept: &'f mut RendererState,
    encoder: &'f mut wgpu::CommandEncoder,
    params: &'f FrameParams,
    lines: Option<InkLines>,
    instances: &[&Instance],
    casters: Option<Casters<'f>>,
    targets: &[Target],
) -> Result<Recording<'f>, RuntimeError> {
    params.check(&kept.gpu.device.limits())?;
    let reversed_depth = kept.options.reversed_depth;
    let clip_from_view = params.camera.check(reversed_depth)?;
    check_instances(params, instances)?;
    let light_ws = params.light.homogeneous("FrameParams::light")?;
    let fills = fill_lights(params)?;
    if let Some(bounds) = casters.as_ref().and_then(|casters| casters.bounds)
        && !(bounds.center.is_finite() && bounds.radius.is_finite() && bounds.radius >= 0.0)
    {
        return Err(RuntimeError::Params {
            field: "Casters::bounds",
            found: format!("{bounds:?}"),
            expected: "a finite sphere with a radius of at least 0".into(),
        });
    }
    if kept.ring.lost_work() {
        kept.states.invalidate_motion();
        kept.shadows = Pool::default();
    }

    let gpu = &kept.gpu;
    kept.cache.bind_groups.next_frame();
    kept.cache.targets.next_frame();
    kept.shadows.next_frame();
    kept.ribbons.next_frame();
    kept.contours.next_frame();
    kept.nearest.next_frame();
    kept.painted.next_frame();
    let view_from_world = params.camera.view_from_world;
    let clip_from_world = clip_from_view * view_from_world;
    let moved = kept.states.pose_instances(gpu, params, clip_from_view, instances);
    let hulls: Vec<Hull> =
        instances.iter().zip(&moved).map(|(instance, moved)| visibility_hull(instance, moved)).collect();
    let limits = kept.gpu.device.limits();
    let params_drawn = with_supported_edges(params, &limits, || {
        let haired = instances.iter().zip(&hulls).filter(|(instance, _)| !instance.model.strands().is_empty());
        let seen = haired.filter(|(_, hull)| hull.may_be_visible(clip_from_world));
        let union = Hull(seen.flat_map(|(_, hull)| hull.0.iter().copied()).collect());
        area(&union, clip_from_world, params.viewport)
    });
    let drawings: Vec<_> = instances
        .iter()
        .zip(&moved)
        .zip(&hulls)
        .map(|((instance, moved), hull)| {
            let mut drawing = InstanceDrawing::for_instance(
                instance,
                &moved.hull,
                &params_drawn,
                kept.options.sample_count,
                clip_from_view,
            );
            drawing.detail.in_picture = hull.may_be_visible(clip_from_world);
            drawing.clamped_to(&limits, &instance.model)
        })
        .collect();

    let drawn_sets: Vec<Vec<StrandSetDrawing>> = instances
        .iter()
        .zip(&drawings)
        .map(|(instance, drawing)| {
            drawing.sets(&instance.model, &params_drawn.style, kept.options.sample_count, &limits)
        })
        .collect();
    let key = shadow_key(params, &limits, instances, &moved, &drawings, &drawn_sets, casters.as_ref());
    let targets = take_targets(&mut kept.cache.targets, gpu, params.viewport, targets);
    let (maps, redraw) = key.map(|key| get_or_create(&mut kept.shadows, gpu, key)).unzip();

    let sky = params.environment.as_ref().map(|environment| kept.skies.sky(gpu, environment));
    let broad = match &sky {
        Some(_) => Some(kept.skies.broad(gpu, instances.iter().map(|instance| instance.model.fibres()))?),
        None => None,
    };

    let mut uniforms = kept.ring.acquire(gpu);
    let fills = uniforms.put(gpu, &[fills]);
    let eye_ws = params.camera.eye_ws(clip_from_view);
    let frame = frame_block(
        params,
        clip_from_world,
        eye_ws,
        light_ws,
        maps.as_deref(),
        sky.as_ref().map_or(0.0, |sky| sky.max_irradiance),
    );
    let blocks_of = |maps: Option<&ShadowMaps>| -> Vec<_> {
        let block = |(instance, drawing): (&&Instance, &InstanceDrawing)| {
            let layers = maps.map_or(drawing.layers, |maps| maps.key.map_layers);
            let map_level = maps.map_or(drawing.texel_level, |maps| map_level(instance, maps));
            blocks::Instance { map_level, ..instance_block(instance, params, drawing, layers) }
        };
        instances.iter().zip(&drawings).map(block).collect()
    };
    let (frame_place, places) = (uniforms.put(gpu, &[frame]), uniforms.put(gpu, &blocks_of(None)));
    let from_light = maps.as_deref().filter(|_| redraw == Some(true)).map(|maps| {
        let clip_from_world = maps.view().clip_from_world.to_cols_array_2d();
        let frame = blocks::Frame { clip_from_world, eye_ws: light_ws.to_array(), ..frame };
        (uniforms.put(gpu, &[frame]), uniforms.put(gpu, &blocks_of(Some(maps))))
    });
    let light_places = from_light.as_ref().map(|(_, places)| places.clone());

    let blended = params_drawn.style.fur().is_some_and(|fur| fur.strand_edges == StrandEdges::Blended);
    let contour_view = params.style.ink().filter(|_| lines == Some(InkLines::Strokes)).map(|ink| ContourView {
        viewport: params.viewport,
        view_from_world,
        clip_from_view,
        eye_ws,
        brush: LineBrush::new(ink),
    });
    let all = instances.iter().zip(moved).zip(drawings).zip(&drawn_sets).enumerate();
    let seen = all.map(|(index, (((instance, moved), drawing), drawn))| {
        let offset = |place: &UniformRange| place.offset + index as u64 * place.stride;
        let mut set = |drawn: &StrandSetDrawing| {
            let strands = &instance.model.strands()[drawn.set];
            let take = || Ribbons::take(&mut kept.ribbons, gpu, strands, drawn.step, !blended);
            VisibleStrandSet {
                drawn: *drawn,
                posed: kept.states.pose_strands(gpu, instance, &moved, drawn.set, drawn.share),
                ribbons: drawing.detail.in_picture.then(take),
            }
        };
        let outline = contour_view.as_ref().zip(instance.model.contours()).filter(|_| drawing.detail.in_picture);
        let contours = outline.map(|(view, model)| {
            let radius_m = instance.scale() * instance.model.manifest().bounds.radius;
            let block = ContourBlock::new(model, instance.transform, radius_m, &moved.hull, view);
            let buffers = ContourBuffers::take(&mut kept.contours, gpu, model);
            VisibleContours { buffers, block: uniforms.put(gpu, &[block]) }
        });
        let painting = instance.model.painting().filter(|_| lines == Some(InkLines::Strokes));
        let painted = painting.filter(|_| drawing.detail.in_picture).map(|model| {
            let block =
                PaintedModel::new(model, instance.transform, instance.scale(), instance.model.manifest().bounds);
            let points = model.count * PaintStroke::POINTS as u32;
            let strokes = PaintedStrokes::take(&mut kept.painted, gpu, points);
            VisiblePainting { strokes, block: uniforms.put(gpu, &[block]) }
        });
        VisibleInstance {
            model: instance.model.clone(),
            contours,
            look: {
                let first = broad.as_ref().map_or(0, |(_, firsts)| firsts[index]);
                Variant::new(instance, params, &drawing, drawn, maps.as_ref().map(|maps| &maps.key), first)
            },
            sets: drawn.iter().map(&mut set).collect(),
            painted,
            moved,
            drawing,
            view_offset: offset(&places),
            light_offset: light_places.as_ref().map_or(0, offset),
        }
    });
    let instances: Arc<[VisibleInstance]> = seen.collect();
    let mut of_hair = Hull::default();
    let with_ribbons = instances.iter().zip(hulls).filter(|(seen, _)| has_ribbons(seen));
    with_ribbons.for_each(|(_, hull)| of_hair.0.extend(hull.0));
    let nearest = NearestSegments::take(&mut kept.nearest, gpu, &params_drawn, &of_hair, clip_from_world);
    let view = InkView { viewport: params.viewport, view_from_world, clip_from_view, reversed_depth };
    let ink = params.style.ink().map(|ink| InkScene::new(&mut uniforms, gpu, ink, &view, &instances));
    let painting = params.style.ink().filter(|_| lines == Some(InkLines::Strokes)).map(|ink| {
        let view = PaintingView { viewport: params.viewport, view_from_world, clip_from_view, reversed_depth };
        uniforms.put(gpu, &[PaintingFrame::new(ink, &view)])
    });
    let mut group = |frame: &UniformRange, places: &UniformRange, maps: Option<&ShadowMaps>| {
        let surfaces = &kept.surfaces;
        let layers = maps.and_then(|maps| maps.layers.as_ref()).map_or(&surfaces.white_array, |l| &l.map.view);
        let width = maps.and_then(|maps| maps.width.as_ref()).map_or(&surfaces.white, |w| &w.width.view);
        let entries = vec![
            (0, BindingResource::block::<blocks::Frame>(&frame.buffer, frame.offset)),
            (1, BindingResource::block::<blocks::Instance>(&places.buffer, 0)),
            (2, BindingResource::block::<Lights>(&fills.buffer, fills.offset)),
            (3, BindingResource::View(layers.clone())),
            (4, BindingResource::View(width.clone())),
            (5, BindingResource::Sampler(surfaces.map_sampler.clone())),
            (6, BindingResource::View(sky.as_ref().map_or(&surfaces.white_array, |sky| &sky.map).clone())),
            (
                7,
                BindingResource::View(broad.as_ref().map_or(&surfaces.white_array, |(broad, _)| &broad.tables).clone()),
            ),
        ];
        kept.cache.bind_groups.get(gpu, "pelage frame", &surfaces.frame, entries)
    };
    let light = from_light.map(|(frame, places)| group(&frame, &places, None));
    let view = group(&frame_place, &places, maps.as_deref());
    Ok(Recording {
        gpu,
        cache: &mut kept.cache,
        surfaces: &kept.surfaces,
        options: &kept.options,
        params,
        encoder,
        instances,
        maps,
        casters,
        nearest,
        targets,
        ink,
        seal: &mut kept.seal,
        painting,
        uniforms,
        ring: &mut kept.ring,
        view,
        light,
    })
}

/// Thickness of guided hair relative to its reach.
const THICKNESS: f32 = 0.12;

/// Returns the world-space hull of an instance, all hair included.
fn hull_with_hair(instance: &Instance, moved: &PosedInstance) -> Hull {
    moved.hull.widened(instance.scale() * instance.model.hair_reach_m())
}

/// Returns the world-space hull of an instance, all hair included. Unbounded if some fur is longer than the manifest's
/// height.
fn visibility_hull(instance: &Instance, moved: &PosedInstance) -> Hull {
    let anywhere = if instance.model.varies().beyond_height { f32::INFINITY } else { 0.0 };
    hull_with_hair(instance, moved).widened(anywhere)
}

/// Returns the key of a frame's shadow maps; `None` if it needs none.
fn shadow_key(
    params: &FrameParams,
    limits: &wgpu::Limits,
    instances: &[&Instance],
    moved: &[PosedInstance],
    drawings: &[InstanceDrawing],
    drawn_sets: &[Vec<StrandSetDrawing>],
    casters: Option<&Casters<'_>>,
) -> Option<ShadowKey> {
    // The finest instance determines the layer count. Layer-wise maps exist only if an instance reads them.
    let by_maps = match params.self_shadow_form() {
        SelfShadow::Maps => true,
        SelfShadow::Auto => instances.iter().any(|instance| !instance.model.has_baked_visibility()),
        SelfShadow::Baked | SelfShadow::Off => false,
    };
    let layers = drawings.iter().map(|d| d.map_layers).max()?;
    // The ink style is unlit.
    if params.style.ink().is_some() {
        return None;
    }
    let mut hull = Hull::default();
    instances.iter().zip(moved).for_each(|(instance, moved)| hull.0.extend(hull_with_hair(instance, moved).0));
    hull.0.extend(casters.and_then(|c| c.bounds).map(|b| (b.center, b.radius)));
    // A model bound to no joint has an empty hull, so its origin is used.
    if hull.0.is_empty() {
        hull.0.extend(instances.iter().map(|i| (i.transform.w_axis.truncate(), 0.0)));
    }
    let of = |(((instance, moved), drawing), sets): (
        ((&&Instance, &PosedInstance), &InstanceDrawing),
        &Vec<StrandSetDrawing>,
    )| InstanceKey {
        transform: instance.transform,
        revision: moved.revision,
        furry: drawing.has_shells(),
        sets: sets.iter().map(|drawn| drawn.set).collect(),
        list: drawing.list,
    };
    let keys = instances.iter().zip(moved).zip(drawings).zip(drawn_sets).map(of).collect();
    let deep_by = matches!(params.self_shadow_form(), SelfShadow::Auto | SelfShadow::Maps);
    let single = instances.iter().zip(drawn_sets).filter(|_| deep_by);
    let hair = single.flat_map(|(instance, sets)| {
        let scale = instance.scale();
        sets.iter().map(move |drawn| {
            let strands = &instance.model.strands()[drawn.set];
            let fur_m = strands.guided().map_or(instance.model.manifest().fur.height_m, |g| THICKNESS * g.reach_m);
            let guided = strands.guided().is_some();
            DeepMapHair { fur_m: scale * fur_m, width_m: scale * strands.mean_width_m, guided }
        })
    });
    let deep = hair.reduce(DeepMapHair::union).map(|hair| (hair, limits.clone()));
    let instances = keys;
    ShadowKey::new(params, by_maps, deep, layers, &hull, instances, casters.map(|c| c.revision))
}
