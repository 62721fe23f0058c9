//! Reference images: path-traced pictures of the same package and view as `render` draws, with individual strands. No
//! adapter is needed.

use super::exit::Failure;
use super::view::PictureView;
use glam::Vec3;
use pelage_bake::strands::{Curves, GroomReport, PosedMesh, grow_groups, grow_on, tile_hair};
use pelage_formats::meaning::scattering::Fibre;
use pelage_formats::meaning::tone::tone_mapped;
use pelage_formats::meaning::{linear_to_srgb, srgb_to_linear, up_of_view};
use pelage_formats::{FibreInfo, FibreOptics, HairGroup};
use pelage_import::BakeError;
use pelage_stage::{KeyLight, Look, LookScattering, LookSelfShadow, LookStyle, NamedPackage, Viewpoint};
use pelage_truth::{Lens, Portion, TracedPicture, TrueCamera, TrueLight, TrueLighting, TrueScattering, TrueScene};
use std::ops::ControlFlow;

/// Package in one pose and style, ready to be traced from any camera and in any light.
pub struct ReferenceTracer {
    /// Strands and mesh surface.
    pub scene: TrueScene,
    /// Report about the growth of the tile's strands.
    pub report: GroomReport,
    scattering: Option<TrueScattering>,
    /// Whether the package has fibre data.
    fibres: bool,
    /// Whether hair is lit by scattering even if the look disables it.
    forced: bool,
    outline: Vec<Vec3>,
    height_m: f32,
}

impl ReferenceTracer {
    /// Grows the strands of the package in `file` on its mesh surface, at the clip time and in the style of `view`.
    pub fn new(file: &NamedPackage<'_>, view: &PictureView) -> Result<Self, Failure> {
        let package = &file.open()?;
        let manifest = package.manifest();
        let morphs = view.morph_weights(file, package)?;
        let mut skin = PosedMesh::morphed(&file.name, package, &view.layers(file, package)?, &morphs)?;
        let hair = match view.look.picture.style {
            LookStyle::Bare => None,
            _ => tile_hair(&file.name, manifest)?,
        };
        let (mut curves, mut report) = match &hair {
            Some(hair) => grow_on(&skin, hair, f64::from(manifest.fur.tile_size_m))?,
            None => Default::default(),
        };
        let groups = package.hair_groups().map_err(|source| BakeError::Package { file: file.name.clone(), source })?;
        if view.look.picture.style != LookStyle::Bare && !groups.is_empty() {
            let grown = grow_groups(&groups, &skin);
            report.strands += grown.len() as u64;
            report.points_before += grown.points.len() as u64;
            curves.append(&grown);
            report.segments = curves.segments() as u64;
        }
        if view.look.picture.style == LookStyle::Bare {
            skin.materials.iter_mut().for_each(|material| material.furred = false);
        }
        let info = package.fibres().map_err(|source| BakeError::Package { file: file.name.clone(), source })?;
        let fibres = info.is_some();
        let scattering = info.map(|info| scattering(&info, &groups, &skin, &curves)).transpose()?;
        Ok(Self {
            scattering,
            fibres,
            forced: false,
            scene: TrueScene::new(curves, skin, hair.as_ref(), manifest.shading)?,
            report,
            outline: view.outline(file, package)?,
            height_m: manifest.fur.height_m,
        })
    }

    /// Returns a camera that frames the model from the direction `towards`, in a picture of the view's size: eye,
    /// target, and vertical field of view in degrees.
    pub fn framed(&self, view: &PictureView, towards: Vec3) -> Viewpoint {
        pelage_stage::framing::frame(&self.outline, self.height_m, view.look.aspect(), towards)
    }

    /// Returns the fur height on screen, pixels, at the median distance of the mesh surface from the eye. 0 if nothing
    /// is in front of the eye.
    pub fn fur_px(&self, view: &PictureView) -> f64 {
        f64::from(self.height_m) * self.px_per_m(view)
    }

    /// Returns the pixels per metre on screen, at the median distance of the mesh surface from the eye. 0 if nothing is
    /// in front of the eye.
    pub fn px_per_m(&self, view: &PictureView) -> f64 {
        let Viewpoint { eye, target, fov_deg } = self.viewpoint(view);
        let (eye, forward) = (eye.as_dvec3(), (target - eye).normalize_or_zero().as_dvec3());
        let skin = self.scene.skin();
        let mut depths: Vec<f64> = skin.vertices.iter().map(|p| (p.position_ws - eye).dot(forward)).collect();
        depths.retain(|depth| *depth > 0.0);
        depths.sort_by(f64::total_cmp);
        let Some(depth) = depths.get(depths.len() / 2) else { return 0.0 };
        let view_m = 2.0 * *depth * (0.5 * f64::from(fov_deg).to_radians()).tan();
        f64::from(view.size().1) / view_m
    }

    /// Returns the camera that `render` uses for the view.
    pub fn camera(&self, view: &PictureView) -> TrueCamera {
        true_camera(self.viewpoint(view))
    }

    /// Returns the camera of [`Self::camera`] as the command line gives it.
    pub fn viewpoint(&self, view: &PictureView) -> Viewpoint {
        view.viewpoint(&self.outline, self.height_m)
    }

    /// Traces a picture with `spp` samples per pixel. Size, camera, lights and lighting terms are those of `view`;
    /// clip, time and style were fixed by [`Self::new`]. `progress` receives the numbers of finished and all pixels.
    pub fn picture(&self, view: &PictureView, spp: u32, progress: &mut dyn FnMut(u64, u64)) -> TracedPicture {
        self.scene.picture(&self.camera(view), &self.lighting(view), view.size(), spp, progress)
    }

    /// Traces a portion of the picture of [`Self::picture`]. Returns `None` if `progress` cancels.
    pub fn portion(
        &self,
        view: &PictureView,
        portion: &Portion,
        progress: &mut dyn FnMut(u64, u64) -> ControlFlow<()>,
    ) -> Option<TracedPicture> {
        self.scene.portion(&self.camera(view), &self.lighting(view), view.size(), portion, progress)
    }
}

impl ReferenceTracer {
    /// Enables scattering between fibres, even if look and package disable it. Uses the package's fibres, or human hair
    /// if it has none.
    ///
    /// Fails with [`BakeError::Internal`] for fibres that the reference does not support, which no package contains.
    pub fn scatter(&mut self, bounces: u32) -> Result<(), Failure> {
        let scattering = self.scattering.take().map_or_else(|| TrueScattering::new(Fibre::default(), 1), Ok)?;
        self.scattering = Some(scattering.with_bounces(bounces));
        self.forced = true;
        Ok(())
    }

    /// Returns the view with the light that `render` uses for this package, as [`Look::resolved`] does.
    pub fn resolved(&self, view: &PictureView) -> PictureView {
        view.resolved(self.fibres)
    }

    /// Encodes a picture of [`Self::picture`] with the same view, as `render` does.
    pub fn encode(&self, picture: &TracedPicture, view: &PictureView) -> image::RgbaImage {
        encode(picture, &self.resolved(view).look)
    }

    /// Returns the scattering of the fibres; `None` for a package without fibres.
    pub fn scattering(&self) -> Option<&TrueScattering> {
        self.scattering.as_ref()
    }

    /// Returns the lights and lighting terms of a look, and the model of hair lighting.
    pub fn lighting(&self, view: &PictureView) -> TrueLighting {
        let view = &self.resolved(view);
        let look = &view.look;
        let scattering = match look.fur.scattering {
            _ if self.forced => self.scattering.clone(),
            LookScattering::Multiple => self.scattering.clone(),
            LookScattering::Single => self.scattering.clone().map(|scattering| scattering.with_bounces(1)),
            LookScattering::Off => None,
        };
        TrueLighting { scattering, ..lighting(view) }
    }
}

/// Returns the scattering for the fibres of the package's fur and of its groups of hair.
fn scattering(
    info: &FibreInfo,
    groups: &[HairGroup],
    skin: &PosedMesh,
    curves: &Curves,
) -> Result<TrueScattering, BakeError> {
    let first = info.fibres.first().map_or_else(Fibre::default, FibreOptics::fibre);
    let mut all = TrueScattering::new(first, TrueScattering::BOUNCES)?;
    for run in curves.groups() {
        let group = groups.iter().position(|group| group.name == run.name).and_then(|i| info.of_groups.get(i));
        // A material without fur may name a fibre that no fur uses.
        let furred = || skin.materials.iter().filter(|material| material.furred).map(|material| &material.fibre);
        let of_coat = || furred().find(|fibre| skin.fibre_group_name(**fibre) == run.name);
        let fibre =
            group.or_else(of_coat).and_then(|i| info.fibres.get(usize::from(*i))).map_or(first, FibreOptics::fibre);
        all = all.with_run(&run.name, run.strands.end, fibre)?;
    }
    Ok(all)
}

/// Returns the lights of a look, and the lighting terms that it disables.
fn lighting(view: &PictureView) -> TrueLighting {
    let look = &view.look;
    let distant = |towards_light_ws, color| TrueLight::Directional { towards_light_ws, color };
    let strength = Vec3::splat(look.key_strength());
    let (sky, sun) = view.sky.as_ref().map(|sky| sky.for_tracing()).unzip();
    let key = match (look.key_light(), sun.flatten().filter(|_| look.light.strength.is_none())) {
        (_, Some(sun)) => distant(sun.towards.into(), sun.color.into()),
        (KeyLight::Distant(towards), None) => distant(towards, strength),
        (KeyLight::Nearby(position_ws), None) => TrueLight::Point { position_ws, color: strength },
    };
    let [ambient_attenuation, back_attenuation] = look.attenuations();
    TrueLighting {
        penumbra: f64::from(look.shadow.penumbra),
        fill: look.fill_lights().map(|(towards, strength)| distant(towards, Vec3::splat(strength))).collect(),
        ambient_attenuation,
        back_attenuation,
        hair_shadows: look.shadow.self_shadow != LookSelfShadow::Off,
        fill_shadows: matches!(look.shadow.self_shadow, LookSelfShadow::Auto | LookSelfShadow::Baked),
        skin_shadows: look.shadow.soft_shadow,
        rolled_off: look.picture.style == LookStyle::Bare,
        scattering: None,
        sky,
        key,
    }
}

/// Converts a camera of `render` to one for path tracing.
pub fn true_camera(Viewpoint { eye, target, fov_deg }: Viewpoint) -> TrueCamera {
    TrueCamera {
        eye_ws: eye,
        target_ws: target,
        up_ws: up_of_view(eye, target),
        lens: Lens::Perspective { fov_y_rad: fov_deg.to_radians() },
    }
}

/// Encodes a picture as `render` does with the same look: exposed, tone-mapped, sRGB with straight alpha, or composited
/// over the look's background colour.
fn encode(picture: &TracedPicture, look: &Look) -> image::RgbaImage {
    let behind = look.background().map(|rgb| rgb.map(srgb_to_linear));
    let exposure = look.exposure();
    let shown = |light: Vec3| if look.is_tone_mapped() { tone_mapped(light) } else { light };
    image::RgbaImage::from_fn(picture.width, picture.height, |x, y| {
        let [r, g, b, alpha] = picture.pixels[y as usize * picture.width as usize + x as usize];
        // The runtime maps the colours of surfaces, before their coverage.
        let light = exposure * Vec3::new(r, g, b);
        let [r, g, b] = if alpha > 0.0 { (alpha * shown(light / alpha)).to_array() } else { light.to_array() };
        match behind {
            Some(behind) => {
                let over = |color: f32, behind: f32| linear_to_srgb(color + (1.0 - alpha) * behind);
                image::Rgba([over(r, behind[0]), over(g, behind[1]), over(b, behind[2]), 255])
            }
            None if alpha > 0.0 => {
                let straight = |color: f32| linear_to_srgb(color / alpha);
                image::Rgba([straight(r), straight(g), straight(b), (255.0 * alpha + 0.5) as u8])
            }
            None => image::Rgba([0; 4]),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec2;
    use pelage_bake::strands::{CurvePoint, PosedMaterial};
    use pelage_formats::meaning::scattering::optics::Medulla;

    #[test]
    fn traced_pixels_are_encoded_like_rendered_ones() {
        let pixels = vec![[0.0; 4], [0.5, 0.25, 0.0, 0.5], [2.0, 0.5, 0.0, 1.0], [0.1, 0.1, 0.1, 1.0]];
        let picture = TracedPicture { width: 2, height: 2, pixels, ..TracedPicture::default() };
        let straight = encode(&picture, &Look::default());
        assert_eq!(straight.get_pixel(0, 0).0, [0; 4]);
        // Linear 0.5 is 188 in 8-bit sRGB.
        assert_eq!(straight.get_pixel(1, 0).0, [255, 188, 0, 128]);
        assert_eq!(straight.get_pixel(0, 1).0, [255, 188, 0, 255]);
        let mut look = Look::default();
        look.set("picture.background=255,0,0").expect("a known key");
        let over = encode(&picture, &look);
        assert_eq!(over.get_pixel(0, 0).0, [255, 0, 0, 255]);
        assert_eq!(over.get_pixel(1, 0).0, [255, linear_to_srgb(0.25), 0, 255]);
    }

    #[test]
    fn bare_materials_do_not_affect_the_fibre_of_the_fur() {
        let optics = |eta| FibreOptics { eta, along: 0.2, tilt: 0.0, around: 0.3, medulla: Medulla::NONE };
        let info = FibreInfo { fibres: vec![optics(1.5), optics(1.6), optics(1.7)], ..FibreInfo::default() };
        let material =
            |name: &str, furred, fibre| PosedMaterial { name: name.into(), furred, fibre, ..Default::default() };
        let materials = vec![material("Hoof", false, 2), material("Body", true, 0), material("Mane", true, 1)];
        let skin = PosedMesh { materials, ..PosedMesh::default() };
        let mut curves = Curves::default();
        for name in [skin.fibre_group_name(0), skin.fibre_group_name(1)] {
            curves.begin_group(&name);
            curves.push(&[CurvePoint::default(); 2], false, Vec2::ZERO);
        }
        let found = scattering(&info, &[], &skin, &curves).expect("fibres that paths can meet");
        assert_eq!(["coat", "coat/Mane"].map(|name| found.of_group(name).0.eta), [1.5_f32, 1.6].map(f64::from));
    }
}
