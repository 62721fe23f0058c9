use crate::{Lens, TrueCamera, TrueLight, TrueLighting, TrueScattering, TrueScene, TrueSky};
use glam::{Vec2, Vec3};
use pelage_bake::noise::uniform;
use pelage_bake::strands::{CurvePoint, Curves, PosedMesh};
use pelage_formats::Shading;
use pelage_formats::meaning::scattering::{Angles, AzimuthalScattering, Fibre, colour};
use pelage_stage::sky::{Environment, LightLobe, Panorama};

/// Returns a tangle of `count` strands of one colour in a ball of 1 m.
fn tangle(color: Vec3, count: u64) -> Curves {
    let mut curves = Curves::default();
    let vector = |seed: u64| Vec3::from_array([0, 1, 2].map(|i| 2.0 * uniform(seed, i) - 1.0));
    for i in 0..count {
        let (middle, way) = (vector(2 * i), vector(2 * i + 1).normalize_or(Vec3::Y) * 0.4);
        let point = |position_ws| CurvePoint { position_ws, radius_m: 0.02, color, height: 1.0, normal_ws: Vec3::Z };
        curves.push(&[point(middle - way), point(middle + way)], false, Vec2::ZERO);
    }
    curves
}

fn camera() -> TrueCamera {
    TrueCamera {
        eye_ws: Vec3::new(0.0, 0.0, 5.0),
        target_ws: Vec3::ZERO,
        up_ws: Vec3::Y,
        lens: Lens::Orthographic { height_m: 2.0 },
    }
}

fn lighting(sun: f32, bounces: u32) -> TrueLighting {
    let key = TrueLight::Directional { towards_light_ws: Vec3::new(0.3, 0.4, 0.8), color: Vec3::splat(sun) };
    let scattering = Some(TrueScattering::new(Fibre::default(), bounces).unwrap());
    TrueLighting { scattering, ..TrueLighting::of(key) }
}

/// Traces a picture and returns the mean light of its covered pixels.
fn mean(curves: Curves, ambient: f32, lighting: &TrueLighting, size: u32, spp: u32) -> Vec3 {
    let shading = Shading { ambient: [ambient; 3], ..Shading::default() };
    let scene = TrueScene::new(curves, PosedMesh::default(), None, shading).unwrap();
    let picture = scene.picture(&camera(), lighting, (size, size), spp, &mut |_, _| ());
    let sum = picture.pixels.iter().fold(glam::DVec4::ZERO, |sum, p| sum + glam::Vec4::from(*p).as_dvec4());
    (sum.truncate() / sum.w).as_vec3()
}

/// Checks that non-absorbing hair is indistinguishable from the uniform sky around it.
#[test]
fn white_hair_vanishes_in_a_uniform_sky() {
    // The uniform sky has the key light's colour. The light of the key light is traced separately and subtracted, which
    // leaves the light of the sky. With practically unlimited bounces, no light is lost.
    let found = mean(tangle(Vec3::ONE, 300), 1.0, &lighting(1.0, 1_000), 48, 64);
    let alone = mean(tangle(Vec3::ONE, 300), 0.0, &lighting(1.0, 1_000), 48, 64);
    let sky = found - alone;
    assert!((sky - Vec3::ONE).abs().max_element() < 0.005, "{sky}");
}

/// Checks that more bounces only add light, and that light-coloured hair gains much of it.
#[test]
fn light_hair_gains_from_multiple_scattering() {
    let sum = |bounces| mean(tangle(Vec3::new(0.9, 0.5, 0.05), 1_500), 0.0, &lighting(1.0, bounces), 32, 32);
    let [one, four, many] = [1, 4, 64].map(sum);
    assert!(four.cmpge(one).all() && many.cmpge(four).all(), "{one} {four} {many}");
    let gain = many / one;
    assert!(gain.x > 4.0 && gain.z < 4.0 && gain.x > gain.y && gain.y > gain.z, "{gain}");
}

/// Checks the light of one fibre, integrated over its width, at a distant eye. It must equal the fibre's far-field
/// formula, with sides, tip and root in the right places.
#[test]
fn near_field_averages_to_the_far_field() {
    let fibre = Fibre { tilt: 0.1, ..Fibre::default() };
    let color = Vec3::new(0.6, 0.3, 0.1);
    let scattering = TrueScattering::new(fibre, 1).unwrap();
    let AzimuthalScattering::Rough(scale) = fibre.around else { unreachable!() };
    // The near-field formula uses the section at θo, the far-field one that at θd. The lights are chosen so that both
    // are almost equal.
    for light in [Vec3::new(0.06, 0.3, 0.5), Vec3::new(-0.06, -0.2, 0.4), Vec3::new(0.03, 0.1, -0.9)] {
        let mut curves = Curves::default();
        let point = |x| CurvePoint {
            position_ws: Vec3::new(x, 0.0, 0.0),
            radius_m: 0.5,
            color,
            height: 1.0,
            normal_ws: Vec3::Z,
        };
        curves.push(&[point(-1e3), point(1e3)], false, Vec2::ZERO);
        let key = TrueLight::Directional { towards_light_ws: light, color: Vec3::ONE };
        let lighting = TrueLighting { key, scattering: Some(scattering.clone()), ..lighting(1.0, 1) };
        let found = mean(curves, 0.0, &lighting, 64, 16).as_dvec3();
        let angles = Angles::between(glam::DVec3::X, light.as_dvec3().normalize(), glam::DVec3::Z);
        let sigma = colour::absorption(color.as_dvec3().to_array(), scale);
        let expected = glam::DVec3::from(fibre.scatter(sigma, &angles)) * std::f64::consts::PI;
        let off = ((found - expected) / expected).abs().max_element();
        assert!(off < 0.05, "towards {light}: {found}, expected {expected}");
    }
}

/// Checks that non-absorbing hair vanishes in a uniform sky, with and without sampling of the sky. A bright window must
/// have the same effect as an equal lobe.
#[test]
fn skies_light_hair_from_their_bright_directions() {
    let under = |sky: TrueSky, color: Vec3, spp: u32| {
        let lighting = TrueLighting { sky: Some(sky), ..lighting(0.0, 1_000) };
        mean(tangle(color, 300), 0.0, &lighting, 32, spp)
    };
    let even = TrueSky::of_environment(Environment::constant([1.0, 0.5, 2.0]));
    let found = under(even, Vec3::ONE, 64) / Vec3::new(1.0, 0.5, 2.0);
    assert!((found - 1.0).abs().max_element() < 0.01, "{found}");
    // The same light as a panorama and as a lobe, on hair that absorbs.
    let lobe = LightLobe { towards: [0.3, 0.4, 0.8], width_deg: 10.0, radiance: [20.0; 3] };
    let window = Environment { lobes: vec![lobe], ..Environment::default() };
    let picture = Panorama::from_fn((256, 128), |way| window.radiance(way)).unwrap();
    let color = Vec3::new(0.6, 0.3, 0.1);
    let [painted, formula] =
        [TrueSky::of_panorama(picture, 0.0, 1.0), TrueSky::of_environment(window)].map(|sky| under(sky, color, 64));
    assert!(((painted - formula) / formula).abs().max_element() < 0.03, "{painted} {formula}");
}

/// Checks that each of 16 successive points is in a cell of its own, in grids of every shape.
#[test]
fn points_of_a_sequence_fill_all_cells() {
    for seed in 0..20 {
        let points: Vec<[f64; 2]> = (0..64).map(|i| super::even_pair(seed, i)).collect();
        for points in points.chunks(16) {
            for columns in [1.0, 2.0, 4.0, 8.0, 16.0] {
                let cell = |[x, y]: &[f64; 2]| ((x * columns) as u32, (y * 16.0 / columns) as u32);
                let cells: std::collections::BTreeSet<_> = points.iter().map(cell).collect();
                assert_eq!(cells.len(), 16, "{seed}: {columns} columns");
            }
        }
    }
    assert_ne!(super::even_pair(1, 0), super::even_pair(2, 0));
}
