//! `probe`: pass that exists only in tests. It shows what adding a pass requires: this folder, and one line in
//! `frame.rs`.

use super::{Outcome, Pass, PassId, PassStage};
use crate::gpu::{BindingResource, Draw, RenderSpec, Shader, uniform};
use crate::params::StyleKind;
use crate::scene::Recording;

const SHADER: Shader = Shader { name: "pelage probe", parts: &[include_str!("probe.wgsl")] };

impl PassId {
    pub(crate) const PROBE: Self = Self(&PASS);
}

pub(crate) const PASS: Pass = Pass {
    name: "probe",
    place: PassStage::Picture,
    styles: &[StyleKind::Bare],
    lines: None,
    does: "fills the whole picture with one colour",
    runs_when: "the style is bare, in tests",
    shaders: &[SHADER],
    targets: &[],
    run,
};

/// Fill colour: linear RGB and opacity.
pub(crate) const COLOR: [f32; 4] = [0.0, 1.0, 0.0, 1.0];

fn run(frame: &mut Recording<'_>) -> Outcome {
    let layout = frame.cache.layouts.get(frame.gpu, SHADER.name, || vec![uniform::<[f32; 4]>(0, false)]);
    let place = frame.uniforms.put(frame.gpu, &[COLOR]);
    let entries = vec![(0, BindingResource::block::<[f32; 4]>(&place.buffer, place.offset))];
    let group = frame.cache.bind_groups.get(frame.gpu, SHADER.name, &layout, entries);
    let spec = RenderSpec::screen(SHADER, ["vs_probe", "fs_probe"], layout, frame.options.color_format);
    let pipeline = frame.pipeline(RenderSpec { depth: Some(frame.picture_depth(false, true)), ..spec });
    Outcome::Ran("in a test".into(), vec![Draw::screen(pipeline, &group)])
}
