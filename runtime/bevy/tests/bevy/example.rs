//! Test of the example's scene, which `./run bevy` shows in a window.

use crate::scene::{self, Animals, Stage};
use crate::support::{Stand, ball, gpu};
use bevy_ecs::prelude::*;
use bevy_ecs::system::RunSystemOnce as _;
use bevy_pelage::Pelage;
use bevy_pelage::runtime::Style;
use bevy_render::view::Msaa;
use bevy_transform::components::Transform;

#[test]
fn example_scene_is_set_up_and_its_animals_walk() {
    let Some(mut stand) = gpu("example_scene_is_set_up_and_its_animals_walk") else { return };
    let models = vec![stand.model("ball", &ball()), stand.model("ball", &ball())];
    stand.app.insert_resource(Animals(models));
    scene::add(&mut stand.app);
    stand.wait(0.5);
    let stage = *stand.world().resource::<Stage>();
    let camera = stand.camera([160, 120], Msaa::Sample4, scene::seen_from(&stage, 0.0));
    let fur = stand.picture(&camera);
    let restyle = |stand: &mut Stand, style: Style| {
        let restyled = move |mut animals: Query<&mut Pelage>| scene::restyle(&mut animals, &style);
        stand.world().run_system_once(restyled).unwrap();
    };
    restyle(&mut stand, scene::ink());
    let ink = stand.picture(&camera);
    let (changed, _) = fur.differences(&ink);
    assert!((0.2..20.0).contains(&changed), "fur and ink differ by {changed}");
    restyle(&mut stand, scene::fur());
    assert_eq!(stand.picture(&camera), fur, "and back");
    let place = |stand: &mut Stand| {
        let mut animals = stand.world().query_filtered::<&Transform, With<Pelage>>();
        animals.iter(stand.app.world()).map(|transform| transform.translation).collect::<Vec<_>>()
    };
    let before = place(&mut stand);
    stand.wait(0.2);
    let after = place(&mut stand);
    assert!(
        before.len() == 2 && before.iter().zip(&after).all(|(a, b)| a.distance(*b) > 0.005),
        "{before:?} {after:?}"
    );
}
