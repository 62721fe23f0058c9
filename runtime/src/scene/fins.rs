//! Draws of fins. Their shaders read vertices from storage buffers.

use super::recording::Recording;
use super::visible_instance::VisibleInstance;
use crate::gpu::{BindingResource, Draw, DrawBindGroup, RenderSpec};
use crate::model::Part;
use pelage_formats::meaning::{FIN_CORNERS, fin_rows};

/// Returns the draws of a model's parts that have fins; empty for a model without fins. `textures`: bind group 2;
/// `spec`: returns the pipeline of a part, whose bind groups and vertex streams are set here.
pub(crate) fn fin_draws(
    frame: &mut Recording<'_>,
    seen: &VisibleInstance,
    textures: Option<DrawBindGroup>,
    spec: impl Fn(&Recording<'_>, &Part) -> RenderSpec,
) -> Vec<Draw> {
    let model = &seen.model;
    let (Some(fins), Some(layout)) = (model.fins(), &frame.surfaces.fins) else { return Vec::new() };
    let buffers = [&seen.moved.geometry, model.attributes(), &fins.buffer];
    let entries = (0..).zip(buffers.map(BindingResource::all)).collect();
    let group = frame.cache.bind_groups.get(frame.gpu, "pelage fins", layout, entries);
    let vertices = FIN_CORNERS * fin_rows(model.varies().lean);
    let mut draws = Vec::new();
    for part in model.parts().iter().filter(|part| !part.fins.is_empty()) {
        let mut spec = spec(frame, part);
        spec.groups.push(layout.clone());
        spec.streams.clear();
        draws.push(Draw {
            pipeline: frame.pipeline(spec),
            groups: [
                frame.eye_group(seen),
                DrawBindGroup::of(&part.material),
                textures.clone(),
                DrawBindGroup::of(&group),
            ],
            vertices: Default::default(),
            indices: None,
            range: part.fins.start * vertices..part.fins.end * vertices,
            instances: 0..1,
            indirect: None,
        });
    }
    draws
}
