//! Knot with fur, in which many strands of different parts overlap.

use super::surface;
use glam::{Vec3, vec3};
use pelage_bake::pipeline;
use pelage_bake::pipeline::BakeInput;
use pelage_bake::recipe::{Coat, Recipe};
use pelage_bake::stages::groom::MapImages;
use pelage_bake::strands::{Curves, PosedMesh, grow_on, tile_hair};
use pelage_formats::{Limits, Package};
use pelage_import::BakeError;

/// Unit direction from the knot towards an eye that sees it well.
pub const TOWARDS_EYE: Vec3 = vec3(0.36, 0.48, 0.8);
/// Height in metres of a picture that contains the whole knot.
pub const HEIGHT_M: f32 = 8.0;

/// Returns the knot's strands at rest, with `density` strands per tile, and its mesh surface.
///
/// # Errors
///
/// Same as [`pipeline::bake`].
pub fn grown(density: u32) -> Result<(Curves, PosedMesh), BakeError> {
    let curve = |a: f32| {
        let out = 2.0 + (3.0 * a).cos();
        vec3(out * (2.0 * a).cos(), out * (2.0 * a).sin(), 1.2 * (3.0 * a).sin())
    };
    let place = |a: f32, b: f32| {
        let along = (curve(a + 1e-2) - curve(a - 1e-2)).normalize_or(Vec3::X);
        let aside = along.cross(curve(a).with_z(0.0)).normalize_or(Vec3::Z);
        let up = aside.cross(along);
        curve(a) + 0.45 * (aside * b.cos() + up * b.sin())
    };
    let model = surface::grid(96, 16, place);
    let mut recipe = Recipe::of_coat(Coat::Natural)?;
    recipe.hair.density = density;
    let images = MapImages::default();
    let told = BakeInput::new("stability", "knot", &recipe, &images);
    let package = pipeline::bake(&told, &model, &mut |_| ())?.package;
    let fault = |source| BakeError::Package { file: "stability".into(), source };
    let package = Package::open(&package, &Limits::default()).map_err(fault)?;
    let manifest = package.manifest();
    let skin = PosedMesh::posed("stability", &package, &[])?;
    let lost = || BakeError::Internal("the knot was baked without hair".into());
    let hair = tile_hair("stability", manifest)?.ok_or_else(lost)?;
    let curves = grow_on(&skin, &hair, f64::from(manifest.fur.tile_size_m))?.0;
    Ok((curves, skin))
}
