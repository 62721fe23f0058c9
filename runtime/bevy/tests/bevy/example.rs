//! Test of the example's scene, which `./run bevy` shows in a window.

use crate::scene::{self, AnimalModels, SceneSize};
use crate::support::{TestApp, ball_package, gpu};
use bevy_ecs::prelude::*;
use bevy_ecs::system::RunSystemOnce as _;
use bevy_pelage::Pelage;
use bevy_pelage::runtime::Style;
use bevy_render::view::Msaa;
use bevy_transform::components::Transform;

#[test]
fn example_scene_is_set_up_and_its_animals_walk() {
    let Some(mut test_app) = gpu("example_scene_is_set_up_and_its_animals_walk") else { return };
    let models = vec![test_app.add_model("ball", &ball_package()), test_app.add_model("ball", &ball_package())];
    test_app.app.insert_resource(AnimalModels(models));
    scene::add(&mut test_app.app);
    test_app.advance(0.5);
    let scene_size = *test_app.world().resource::<SceneSize>();
    let camera = test_app.spawn_camera([160, 120], Msaa::Sample4, scene::overview_camera(&scene_size, 0.0));
    let fur = test_app.picture(&camera);
    let restyle = |test_app: &mut TestApp, style: Style| {
        let restyled = move |mut animals: Query<&mut Pelage>| scene::restyle(&mut animals, &style);
        test_app.world().run_system_once(restyled).unwrap();
    };
    restyle(&mut test_app, scene::ink_style());
    let ink = test_app.picture(&camera);
    let (changed, _) = fur.differences(&ink);
    assert!((0.2..20.0).contains(&changed), "fur and ink differ by {changed}");
    restyle(&mut test_app, scene::fur_style());
    assert_eq!(test_app.picture(&camera), fur, "the fur style is restored");
    let place = |test_app: &mut TestApp| {
        let mut animals = test_app.world().query_filtered::<&Transform, With<Pelage>>();
        animals.iter(test_app.app.world()).map(|transform| transform.translation).collect::<Vec<_>>()
    };
    let before = place(&mut test_app);
    test_app.advance(0.2);
    let after = place(&mut test_app);
    assert!(
        before.len() == 2 && before.iter().zip(&after).all(|(a, b)| a.distance(*b) > 0.005),
        "{before:?} {after:?}"
    );
}
