//! What became of each pass of a frame, and of the fur of each instance.

use crate::frame::Drawn;
use crate::ink::InkShow;
use crate::passes::{PassId, ink_fur};
use crate::shadow::ShadowMaps;
use crate::{FrameParams, InstanceDetail, Light, Style};
use glam::Vec3;

/// Which passes ran, and why the others did not.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameReport {
    /// One entry per pass, in order.
    pub passes: Vec<PassReport>,
    /// One entry per instance, in the order given.
    pub instances: Vec<InstanceDetail>,
}

/// What became of one pass.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PassReport {
    /// Name of the pass: [`PassId::name`].
    pub name: &'static str,
    /// Whether it does anything in this frame.
    pub ran: bool,
    /// What it does, or why nothing.
    pub reason: String,
}

impl PassReport {
    pub(crate) fn ran(name: &'static str, reason: impl Into<String>) -> Self {
        Self { name, ran: true, reason: reason.into() }
    }

    pub(crate) fn skipped(name: &'static str, reason: impl Into<String>) -> Self {
        Self { name, ran: false, reason: reason.into() }
    }
}

/// The report of a frame whose passes are planned. `posed`: of the pass that ran first; `redrawn`: whether the shadow maps were drawn anew.
pub(crate) fn report(
    posed: PassReport,
    drawn: &[Drawn],
    params: &FrameParams,
    maps: Option<&ShadowMaps>,
    redrawn: bool,
) -> FrameReport {
    FrameReport {
        passes: vec![
            posed,
            report_layer_shadow(drawn, params, maps, redrawn),
            report_shadow_width(drawn, params, maps, redrawn),
            report_ink(PassId::InkNormals, drawn, params),
            report_ink(PassId::InkFeatures, drawn, params),
            report_ink(PassId::InkDilate, drawn, params),
            report_ink(PassId::InkStroke, drawn, params),
            report_skin(drawn, params),
            report_fins(drawn, params),
            report_shells(drawn, params),
            report_ink(PassId::InkComposite, drawn, params),
            report_ink(PassId::InkFur, drawn, params),
        ],
        instances: drawn.iter().map(|d| d.drawing.detail).collect(),
    }
}

fn report_layer_shadow(drawn: &[Drawn], params: &FrameParams, maps: Option<&ShadowMaps>, redrawn: bool) -> PassReport {
    let name = PassId::LayerShadow.name();
    match maps.filter(|maps| maps.key.self_shadow) {
        Some(maps) if redrawn => {
            let (size, layers) = (maps.key.params.map_size, maps.key.map_layers - 1);
            PassReport::ran(name, format!("{layers} maps of {size} x {size}{}", light_inside(maps)))
        }
        Some(_) => PassReport::skipped(name, "light, poses and models as in the maps"),
        None if drawn.is_empty() => PassReport::skipped(name, "no instances"),
        None if !params.self_shadow => PassReport::skipped(name, "switched off"),
        None if params.light.color() == Vec3::ZERO => PassReport::skipped(name, "the key light is dark"),
        None if params.style != Style::Fur => PassReport::skipped(name, not_fur(params.style)),
        None if all_reduced(drawn) => {
            PassReport::skipped(name, "far coats alone, which have their light from the package")
        }
        None => PassReport::skipped(name, "no fur is drawn"),
    }
}

fn report_shadow_width(drawn: &[Drawn], params: &FrameParams, maps: Option<&ShadowMaps>, redrawn: bool) -> PassReport {
    let name = PassId::ShadowWidth.name();
    match maps.filter(|maps| maps.key.soft_shadow) {
        Some(maps) if redrawn => {
            let (size, shrink) = (maps.key.params.map_size, maps.key.params.shrink);
            PassReport::ran(name, format!("{size} x {size}, shrunk {shrink} times{}", light_inside(maps)))
        }
        Some(_) => PassReport::skipped(name, "light, poses and models as in the maps"),
        None if drawn.is_empty() => PassReport::skipped(name, "no instances"),
        None if !params.soft_shadow => PassReport::skipped(name, "switched off"),
        None if params.style == Style::Ink => PassReport::skipped(name, not_fur(params.style)),
        None => PassReport::skipped(name, "the key light is dark"),
    }
}

/// A light inside what it lights has no view of all of it.
fn light_inside(maps: &ShadowMaps) -> &'static str {
    let sphere = maps.view().sphere;
    match maps.key.light {
        Light::Point { position, .. } if position.distance(sphere.center) < sphere.radius => {
            "; the light is inside the scene, the maps cover the side of its centre"
        }
        _ => "",
    }
}

/// Why passes of the furry style do nothing.
fn not_fur(style: Style) -> &'static str {
    match style {
        Style::Fur => "style is fur",
        Style::Bare => "style is bare",
        Style::Ink => "style is ink",
    }
}

fn report_ink(id: PassId, drawn: &[Drawn], params: &FrameParams) -> PassReport {
    let name = id.name();
    let Some(ink) = params.ink.as_ref().filter(|_| params.style == Style::Ink) else {
        return PassReport::skipped(name, not_fur(params.style));
    };
    let draws = || drawn.iter().filter_map(|d| d.ink.as_ref());
    let [width, height] = ink.target_px;
    match id {
        PassId::InkNormals => {
            let parts: usize = draws().map(|d| d.normals().len()).sum();
            PassReport::ran(name, format!("{} instances, {parts} parts, {width} x {height}", drawn.len()))
        }
        PassId::InkFur => {
            let furry = draws().filter(|d| !d.is_bald()).count();
            match (furry, ink.show) {
                (0, InkShow::Painting) => PassReport::skipped(name, "no package has strokes of fur to draw"),
                (0, _) => PassReport::skipped(name, "the painting is not shown"),
                _ => PassReport::ran(name, format!("{furry} instances, {} shells and fins", ink_fur::SHELLS)),
            }
        }
        PassId::InkDilate => PassReport::ran(name, format!("{} pixels along rows", ink.reach_px())),
        PassId::InkStroke => PassReport::ran(name, format!("{} pixels along columns", ink.reach_px())),
        _ => PassReport::ran(name, format!("{width} x {height}")),
    }
}

fn report_skin(drawn: &[Drawn], params: &FrameParams) -> PassReport {
    let draws: usize = drawn.iter().map(|d| d.skin.len()).sum();
    if params.style == Style::Ink {
        return PassReport::skipped("skin", not_fur(params.style));
    }
    if draws == 0 {
        return PassReport::skipped("skin", "no instances");
    }
    let coats = drawn.iter().filter(|d| d.drawing.detail.coat > 0.0).count();
    let coats = if coats > 0 { format!(", {coats} with the far coat") } else { String::new() };
    PassReport::ran("skin", format!("{} instances, {draws} parts{coats}", drawn.len()))
}

/// Whether everything is so small that what was asked about is left out.
fn all_reduced(drawn: &[Drawn]) -> bool {
    drawn.iter().any(|d| d.drawing.is_reduced())
}

fn report_fins(drawn: &[Drawn], params: &FrameParams) -> PassReport {
    let with_fins = drawn.iter().filter(|d| d.fins.is_some());
    let fins: u32 = with_fins.clone().flat_map(|d| d.model.parts()).map(|part| part.fins.len() as u32).sum();
    if fins > 0 {
        return PassReport::ran("fins", format!("{} instances, {fins} edges", with_fins.count()));
    }
    PassReport::skipped(
        "fins",
        match (drawn.is_empty(), params.style, params.layers) {
            (true, ..) => "no instances",
            (_, Style::Bare | Style::Ink, _) => not_fur(params.style),
            (_, _, Some(1)) => "one layer is the skin alone",
            _ if !params.fins => "switched off",
            _ if all_reduced(drawn) => "the fur is too small on screen",
            _ if drawn.iter().any(|d| d.model.manifest().fur.fins.is_some()) => {
                "no edges, or no storage buffers in vertex shaders"
            }
            _ => "no package has fins",
        },
    )
}

fn report_shells(drawn: &[Drawn], params: &FrameParams) -> PassReport {
    let furry = drawn.iter().filter(|d| !d.shells.is_empty());
    let layers: u32 = furry.clone().map(|d| d.drawing.detail.layers).sum();
    if layers > 0 {
        let how = if params.yardstick { ", yardstick: one read, no lighting" } else { "" };
        let of: u32 = drawn.iter().map(|d| d.drawing.detail.of_layers).sum();
        let of = if all_reduced(drawn) { format!(" of {of}") } else { String::new() };
        return PassReport::ran("shells", format!("{} instances, {layers}{of} layers{how}", furry.count()));
    }
    PassReport::skipped(
        "shells",
        match (drawn.is_empty(), params.style, params.layers) {
            (true, ..) => "no instances",
            (_, Style::Bare | Style::Ink, _) => not_fur(params.style),
            (_, _, Some(1)) => "one layer is the skin alone",
            _ if all_reduced(drawn) => "the fur is too small on screen: far coats on the skin",
            _ => "no package has fur",
        },
    )
}
