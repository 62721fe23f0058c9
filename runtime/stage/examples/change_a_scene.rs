//! Loads a scene file, changes it and draws it. The first model is copied. The copy is beside it and faces the other
//! way; a lamp lights both.
//!
//! ```text
//! cargo run --release -p pelage-stage --features draw --example change_a_scene SCENE.toml PICTURE.png [SECONDS]
//! ```

use pelage_stage::{Framing, Gpu, NamedPackage, Number, Point, SceneFile, Stage};
use std::error::Error;
use std::path::Path;

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [scene, picture, rest @ ..] = words.as_slice() else {
        return Err("usage: SCENE.toml PICTURE.png [SECONDS]".into());
    };
    let time_s: f32 = rest.first().map_or(Ok(0.0), |seconds| seconds.parse())?;

    // Read the scene: errors include line and key. The look may be in a separate file.
    let folder = Path::new(scene).parent().unwrap_or(Path::new(""));
    let read = |path: &str| std::fs::read(folder.join(path)).map_err(|error| format!("{path}: {error}"));
    let mut file = SceneFile::parse(scene, std::fs::read(scene)?)?;
    let mut look = file.look(|path| {
        let text = String::from_utf8(read(path)?).map_err(|error| error.to_string())?;
        Ok((folder.join(path).display().to_string(), text))
    })?;

    // Change the scene: it is plain data until it is loaded.
    let mut copy = file.scene.models[0].clone();
    copy.name = Some("copy".into());
    copy.path = None;
    copy.heading_deg = Some(Number(180.0));
    copy.position = Some(Point(glam::Vec3::new(1.5, 0.0, 0.0)));
    file.scene.models.push(copy);

    // Load the scene: this program provides the packages.
    let loaded = file.load(&|path: &str| Ok(NamedPackage::new(path, read(path)?)))?;

    // Draw the picture with the scene's camera, or one that frames all models. The picture has four samples per pixel
    // and is lit by a lamp.
    look.set("picture.samples=4")?;
    look.set("light.position_m=[2, 4, 3]")?;
    let cast = loaded.cast(None, look.aspect(), &Framing::default())?;
    let mut stage = Stage::new(&cast, &look.picture(), look.frame_params(), time_s, Gpu::open)?;
    stage.draw()?;
    let (width, height) = stage.canvas.size();
    image::save_buffer(picture, &stage.canvas.read(&stage.gpu)?, width, height, image::ColorType::Rgba8)?;
    println!("{}: {} models of {} packages", picture, cast.actors.len(), cast.packages.len());
    Ok(())
}
