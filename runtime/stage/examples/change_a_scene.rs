//! Loads a scene file, changes it, and draws it: `cargo run --release -p pelage-stage --features draw --example change_a_scene`
//! `SCENE.toml PICTURE.png [SECONDS]`. The first model comes twice, the copy beside it and facing the other way, in the light of a lamp.

use pelage_runtime::{FrameParams, InkParams, Light, Style};
use pelage_stage::{Gpu, NamedPackage, Number, Picture, Point, SceneFile, Stage, camera};
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [scene, picture, rest @ ..] = words.as_slice() else {
        return Err("usage: SCENE.toml PICTURE.png [SECONDS]".into());
    };
    let time_s: f32 = rest.first().map_or(Ok(0.0), |seconds| seconds.parse())?;

    // Read: what is wrong with it is said with line and key.
    let mut file = SceneFile::parse(scene, std::fs::read(scene)?)?;

    let inked = file.scene.view.get("style").and_then(|style| style.as_str()) == Some("ink");

    // Change: a scene is plain data until it is loaded.
    let mut copy = file.scene.models[0].clone();
    copy.name = Some("copy".into());
    copy.path = None;
    copy.heading_deg = Some(Number(180.0));
    copy.position = Some(Point(glam::Vec3::new(1.5, 0.0, 0.0)));
    file.scene.models.push(copy);

    // Load: the packages come from wherever this program has them.
    let folder = Path::new(scene).parent().unwrap_or(Path::new(""));
    let loaded = file.load(&|path: &str| {
        let path = folder.join(path).display().to_string();
        let bytes = std::fs::read(&path).map_err(|error| format!("{path}: {error}"))?;
        Ok(NamedPackage::new(path, bytes))
    })?;

    // Draw: the scene's camera, or one that frames everybody; the light is this program's own.
    let canvas = Picture { size: (834, 424), samples: 4, background: Some([236, 231, 220]) };
    let cast = loaded.cast(None, canvas.aspect(), true)?;
    let params =
        FrameParams::new(camera(&cast.camera.at(time_s), canvas.aspect()), canvas.size.into()).with(|params| {
            params.light = Light::Point { position: glam::Vec3::new(2.0, 4.0, 3.0), color: glam::Vec3::ONE };
            if inked {
                params.style = Style::Ink(InkParams::default());
            }
        });
    let mut stage = Stage::new(&cast, &canvas, params, time_s, Gpu::open)?;
    stage.draw()?;
    let (width, height) = stage.canvas.size();
    image::save_buffer(picture, &stage.canvas.read(&stage.gpu)?, width, height, image::ColorType::Rgba8)?;
    println!("{}: {} models of {} packages", picture, cast.actors.len(), cast.packages.len());
    Ok(())
}
