//! What the cameras of an app show.

use crate::support::{Stand, hare};
use bevy_color::Color;
use bevy_math::Vec3;
use bevy_pelage::Pelage;
use bevy_render::view::Msaa;
use bevy_transform::components::Transform;

#[test]
fn first() {
    let t = std::time::Instant::now();
    let mut stand = Stand::new();
    println!("app {:?}", t.elapsed());
    let model = stand.model("hare", hare());
    println!("baked {:?}", t.elapsed());
    stand.sun(Vec3::new(-1.0, 2.0, 1.0), true);
    let camera = stand.camera([400, 300], Msaa::Sample4, Transform::from_xyz(0.6, 0.5, 1.1).looking_at(Vec3::Y * 0.15, Vec3::Y));
    stand.cuboid(Vec3::new(3.0, 0.1, 3.0), Vec3::Y * -0.05, Color::srgb(0.4, 0.5, 0.3));
    stand.cuboid(Vec3::splat(0.2), Vec3::new(0.25, 0.1, 0.1), Color::srgb(0.7, 0.2, 0.1));
    stand.world().spawn(Pelage::fur(model));
    let picture = stand.picture(&camera);
    println!("drawn {:?}", t.elapsed());
    picture.save("first.png");
    println!("{:?}", stand.renderers().said().collect::<Vec<_>>());
}
