//! Tests of debug views, which show false colours instead of lighting: the geometry of a frame, and the number of
//! overlapping fragments.
#![allow(clippy::unwrap_used, reason = "tests")]

use pelage_runtime::glam::Vec3;
use pelage_runtime::{
    Camera, FrameParams, FurDebugView, HairGeometry, Instance, Projection, Renderer, RendererOptions, StrandEdges,
};
use pelage_tests::gpu::gpu;
use pelage_tests::packages::straight_strands;
use pelage_tests::pictures::{Picture, draw};
use pelage_tests::plane::{PlaneGroom, groomed_plane};

/// Returns the parameters of a view from above, for a plane with layers and strands.
fn above(show: FurDebugView) -> FrameParams {
    let projection = Projection::Orthographic { height_m: 0.25, aspect: 1.0, near_m: 0.0, far_m: 2.0 };
    let camera = Camera::look_at(Vec3::Z, Vec3::ZERO, projection);
    FrameParams::new(camera, [128; 2]).with(|p| p.soft_shadow = false).with(|p| p.debug.fur = show)
}

/// Returns the share of pixels in which channel `of` is more than 1.25 times as bright as each of the other two.
fn share(picture: &Picture, of: usize) -> f64 {
    let leads = |p: &&[u8; 4]| (0..3).filter(|i| *i != of).all(|i| 4 * u32::from(p[of]) > 5 * u32::from(p[i]));
    picture.rgba.iter().filter(leads).count() as f64 / picture.rgba.len() as f64
}

#[test]
fn debug_view_colours_geometry_kinds_and_sums_overdraw() {
    let Some(gpu) = gpu("debug_view_colours_geometry_kinds_and_sums_overdraw") else { return };
    let roots: Vec<_> = (0..8).map(|i| [0.37 * i as f32 % 1.0, (i as f32 + 0.5) / 8.0]).collect();
    let strands = straight_strands(&roots, 0.5, &[[0.6, 0.07, 0.5]; 8], 0.08);
    let groom = PlaneGroom { strands: Some((strands, 8.0)), ..PlaneGroom::default() };
    let package = groomed_plane(16, 128, Default::default(), &groom);
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &RendererOptions::default()).unwrap();
    let instance = Instance::new(0, &renderer.load_bytes(&package).unwrap());
    let mut shown = |params: FrameParams| draw(gpu, &mut renderer, &params, &[&instance]);

    let shells = shown(above(FurDebugView::Geometry).with_fur(|fur| fur.hair = HairGeometry::Shells));
    assert!(share(&shells, 1) > 0.3 && share(&shells, 0) == 0.0, "shells are not green: {}", share(&shells, 1));
    for edges in [StrandEdges::Samples, StrandEdges::Blended] {
        let strands =
            above(FurDebugView::Geometry).with_fur(|fur| (fur.hair, fur.strand_edges) = (HairGeometry::Strands, edges));
        let strands = shown(strands);
        assert!(share(&strands, 0) > 0.1 && share(&strands, 1) == 0.0, "{edges:?}: not red: {}", share(&strands, 0));
    }
    let overdraw = |layers| {
        above(FurDebugView::Overdraw).with_fur(|fur| (fur.hair, fur.layers) = (HairGeometry::Shells, Some(layers)))
    };
    let [few, many] = [2, 16].map(|layers| shown(overdraw(layers)).mean(0));
    assert!(many > 1.5 * few, "16 layers are as bright as 2: {many}, {few}");
}
