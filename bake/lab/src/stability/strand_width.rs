//! Strands thinner than a pixel: ribbons of true width hit samples in proportion to their coverage. Lines are at least
//! a pixel wide; they make hair an eighth of a pixel wide eight times as dense.

use super::row::{DrawCallback, Drawing, DrawnRowTest, Finding, Row};
use super::surface;
use glam::{Mat4, Vec3, vec3};
use pelage_bake::pipeline;
use pelage_bake::pipeline::BakeInput;
use pelage_bake::recipe::{Coat, Recipe};
use pelage_bake::stages::groom::MapImages;
use pelage_bake::strands::{PosedMesh, grow_on, tile_hair};
use pelage_formats::{Limits, Package};
use pelage_import::BakeError;
use pelage_runtime::{Camera, Detail, FrameParams, HairGeometry, PassId, Projection, SelfShadow};
use pelage_truth::{Lens, TrueCamera, TrueLight, TrueLighting, TrueScene};

/// Row of the stability table.
pub const ROW: Row<DrawnRowTest> = Row {
    method: "strand width",
    cliff: "strands an eighth of a pixel wide",
    naive: "each at least a pixel wide",
    safe: "ribbons of true width",
    drive,
};

/// Width and height of the picture, pixels. It is large because each pixel has only one sample, which is hit or not.
pub const SIZE: u32 = 640;
/// Side of the visible square, metres.
const VISIBLE_SIDE_M: f32 = 1.1;
/// Side of the square mesh, metres; a little smaller than the visible square.
const SKIN_M: f32 = 1.0;
/// Width of a tile, metres.
const TILE_M: f32 = 0.125;
/// Number of rays per pixel of the truth.
const TRUE_SAMPLES: u32 = 1024;
/// Width and height of the truth's picture, pixels.
const TRUE_SIZE: u32 = SIZE / 8;

/// Bakes a square with hair of one width, with `density` strands per tile. Strands are oblique to the pixel grid,
/// because a parallel strand would hit all samples of a column or none.
///
/// # Errors
///
/// Same as [`pipeline::bake`].
pub fn bake(width_px: f32, density: u32, change: impl Fn(&mut Recipe)) -> Result<Vec<u8>, BakeError> {
    let mut recipe = Recipe::of_coat(Coat::Natural)?;
    let radius = 0.5 * width_px * VISIBLE_SIDE_M / SIZE as f32 / TILE_M;
    (recipe.hair.density, recipe.hair.length_m, recipe.hair.lean) = (density, Some(0.06), 0.6);
    (recipe.hair.root_radius, recipe.hair.tip_radius) = (radius, radius);
    recipe.hair.lean_direction_deg = 33.0;
    recipe.surface.tile_size_m = Some(TILE_M);
    (recipe.strands.enabled, recipe.fins.enabled) = (true, false);
    change(&mut recipe);
    let n = 8u32;
    let corner = |i: u32| (i as f32 / n as f32 - 0.5) * SKIN_M;
    let positions = (0..=n).flat_map(|j| (0..=n).map(move |i| vec3(corner(i), corner(j), 0.0))).collect();
    let at = |i: u32, j: u32| j * (n + 1) + i;
    let quad = |(i, j): (u32, u32)| {
        let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    let triangles = (0..n).flat_map(|j| (0..n).map(move |i| (i, j))).flat_map(quad).collect();
    let model = surface::model(positions, triangles);
    let images = MapImages::default();
    let told = BakeInput::new("stability", "strand width", &recipe, &images);
    Ok(pipeline::bake(&told, &model, &mut |_| ())?.package)
}

/// Returns frame parameters that show the square from above, drawn as single strands without shadow.
pub fn above() -> FrameParams {
    let projection = Projection::Orthographic { height_m: VISIBLE_SIDE_M, aspect: 1.0, near_m: 0.0, far_m: 4.0 };
    let camera = Camera::look_at(2.0 * Vec3::Z, Vec3::ZERO, projection);
    FrameParams::new(camera, [SIZE; 2]).with(|p| p.soft_shadow = false).with_fur(|fur| {
        (fur.hair, fur.detail, fur.self_shadow) = (HairGeometry::Strands, Detail::Full, SelfShadow::Off);
    })
}

/// Returns the camera of `params` for the truth.
pub fn true_camera(params: &FrameParams) -> TrueCamera {
    TrueCamera::from_view(params.camera.view_from_world, Lens::Orthographic { height_m: VISIBLE_SIDE_M })
}

/// Returns only the strands of a package, for tracing.
///
/// # Errors
///
/// [`BakeError::Package`] if the package does not open.
pub fn strands_of(package: &[u8]) -> Result<TrueScene, BakeError> {
    let fault = |source| BakeError::Package { file: "stability".into(), source };
    let package = Package::open(package, &Limits::default()).map_err(fault)?;
    let manifest = package.manifest();
    let mut skin = PosedMesh::posed("stability", &package, &[])?;
    let lost = || BakeError::Internal("the square was baked without hair".into());
    let hair = tile_hair("stability", manifest)?.ok_or_else(lost)?;
    let curves = grow_on(&skin, &hair, f64::from(manifest.fur.tile_size_m))?.0;
    skin.triangles.clear();
    TrueScene::new(curves, skin, None, manifest.shading)
}

/// Returns the fraction of the picture that the traced strands cover.
fn truth(package: &[u8], camera: &TrueCamera) -> Result<f64, BakeError> {
    // Only coverage is needed, so lighting casts no rays.
    let lighting = TrueLighting {
        key: TrueLight::Directional { towards_light_ws: Vec3::Z, color: Vec3::ONE },
        penumbra: 0.0,
        fill: Vec::new(),
        ambient_attenuation: false,
        back_attenuation: false,
        hair_shadows: false,
        fill_shadows: false,
        skin_shadows: false,
        rolled_off: false,
        scattering: None,
        sky: None,
    };
    let size = (TRUE_SIZE, TRUE_SIZE);
    let picture = strands_of(package)?.picture(camera, &lighting, size, TRUE_SAMPLES, &mut |_, _| ());
    Ok(picture.pixels.iter().map(|p| f64::from(p[3])).sum::<f64>() / picture.pixels.len() as f64)
}

/// Strands per tile; so few that strands seldom overlap.
const DENSITY: u32 = 40;

/// Makes the hair long and flat. The round ends of strands, which only the truth has, are then a small fraction of it.
fn make_long(recipe: &mut Recipe) {
    (recipe.hair.length_m, recipe.hair.length_variation, recipe.hair.lean) = (Some(0.1), 0.2, 0.9);
}

fn drive(draw: &mut DrawCallback<'_>) -> Result<Vec<Finding>, BakeError> {
    let params = above();
    let camera = true_camera(&params);
    let mut covered = |package: &[u8]| {
        let drawing =
            Drawing { package, params: &params, size: (SIZE, SIZE), passes: &[PassId::STRANDS], at: Mat4::IDENTITY };
        let texels = draw(&drawing)?;
        Ok::<_, BakeError>(texels.iter().map(|t| f64::from(t[3])).sum::<f64>() / texels.len() as f64)
    };
    let widened = covered(&bake(1.0, DENSITY, make_long)?)?;
    let mut out = Vec::new();
    for (width_px, fails_above) in [(0.25, 1.0), (0.125, 1.0)] {
        let package = bake(width_px, DENSITY, make_long)?;
        let (truth, ours) = (truth(&package, &camera)?, covered(&package)?);
        out.push(Finding {
            case: format!(
                "strands {width_px} pixels wide that cover {:.2} % of the picture, one sample per pixel",
                100.0 * truth
            ),
            measure: "relative error of coverage, against the traced strands",
            naive: (widened / truth - 1.0).abs(),
            safe: (ours / truth - 1.0).abs(),
            bound: 0.03,
            fails_above,
        });
    }
    Ok(out)
}
