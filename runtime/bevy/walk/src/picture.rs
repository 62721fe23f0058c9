//! Picture mode: writes a PNG file without opening a window. It shows the scene in fur and in ink, one above the other.

use crate::camera_bundle;
use crate::scene::{self, SceneSize};
use bevy_app::{App, AppExit, Update};
use bevy_asset::{Assets, Handle};
use bevy_camera::RenderTarget;
use bevy_ecs::prelude::*;
use bevy_image::Image;
use bevy_log::error;
use bevy_pelage::Pelage;
use bevy_render::gpu_readback::{Readback, ReadbackComplete};
use bevy_render::render_resource::{TextureFormat, TextureUsages};
use bevy_time::TimeUpdateStrategy;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Size of each half, pixels.
const SIZE: [u32; 2] = [832, 424];

/// Number of frames before a capture, after which models and pipelines are ready.
const FRAMES: u32 = 8;

/// Requested picture and its progress.
#[derive(Resource)]
pub struct PictureRequest {
    file: PathBuf,
    target: Option<Handle<Image>>,
    reader: Option<Entity>,
    /// Number of frames since the camera was added or the style changed.
    frames: u32,
    /// Pixels of the finished halves, RGBA bytes, row by row.
    halves: Vec<Vec<u8>>,
}

impl PictureRequest {
    /// Requests a picture, to be written to `file`.
    pub fn new(file: PathBuf) -> Self {
        Self { file, target: None, reader: None, frames: 0, halves: Vec::new() }
    }
}

/// Adds the system that draws the picture and quits.
pub fn add(app: &mut App, request: PictureRequest) {
    // Every frame advances time by the same amount, however long it takes to draw.
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_millis(20)))
        .insert_resource(request)
        .add_systems(Update, draw);
}

fn draw(
    mut commands: Commands,
    scene_size: Option<Res<SceneSize>>,
    mut request: ResMut<PictureRequest>,
    mut images: ResMut<Assets<Image>>,
    mut animals: Query<&mut Pelage>,
) {
    let Some(scene_size) = scene_size else { return };
    let Some(target) = request.target.clone() else {
        let [width, height] = SIZE;
        let mut image = Image::new_target_texture(width, height, TextureFormat::Rgba8UnormSrgb, None);
        image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
        let target = images.add(image);
        commands.spawn((camera_bundle(scene::overview_camera(&scene_size, 0.0)), RenderTarget::from(target.clone())));
        request.target = Some(target);
        return;
    };
    request.frames += 1;
    if request.frames == FRAMES && !request.halves.is_empty() {
        scene::restyle(&mut animals, &scene::ink_style());
    }
    if request.frames == 2 * FRAMES {
        let reader = commands.spawn(Readback::texture(target)).observe(store_half).id();
        request.reader = Some(reader);
    }
}

fn store_half(
    read: On<ReadbackComplete>,
    mut commands: Commands,
    mut request: ResMut<PictureRequest>,
    mut exit: MessageWriter<AppExit>,
) {
    let Some(reader) = request.reader.take() else { return };
    commands.entity(reader).despawn();
    let row = 4 * SIZE[0] as usize;
    // The rows of a copied texture have alignment padding, which is removed.
    let rows = read.data.chunks_exact(read.data.len() / SIZE[1] as usize).flat_map(|aligned| &aligned[..row]);
    request.halves.push(rows.copied().collect());
    request.frames = 0;
    if request.halves.len() == 2 {
        exit.write(match write(&request.file, &request.halves.concat()) {
            Ok(()) => AppExit::Success,
            Err(fault) => {
                error!("{}: {fault}", request.file.display());
                AppExit::error()
            }
        });
    }
}

/// Writes the halves as an opaque picture, one above the other.
fn write(file: &Path, rgba: &[u8]) -> Result<(), png::EncodingError> {
    let rgb: Vec<u8> = rgba.chunks_exact(4).flat_map(|pixel| &pixel[..3]).copied().collect();
    let mut encoder = png::Encoder::new(std::io::BufWriter::new(std::fs::File::create(file)?), SIZE[0], 2 * SIZE[1]);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_compression(png::Compression::High);
    encoder.write_header()?.write_image_data(&rgb)
}
