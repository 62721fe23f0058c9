//! Tests of the table of key images.

use super::KEY_PICTURES;
use crate::recipe::{Recipe, keys};

#[test]
fn every_key_picture_uses_a_valid_key_and_values() {
    let order: Vec<String> = keys().map(|knob| knob.name.to_owned()).collect();
    let places: Vec<usize> =
        KEY_PICTURES.iter().map(|picture| order.iter().position(|name| name == picture.key).unwrap()).collect();
    assert!(places.is_sorted(), "not in the order of the page: {places:?}");
    for picture in KEY_PICTURES {
        let drawn = picture.values.map(|value| {
            let mut recipe = Recipe::default();
            recipe.set(&format!("{}={value}", picture.key)).unwrap();
            recipe.validate().unwrap();
            recipe.to_toml()
        });
        assert!(drawn[0] != drawn[1] && drawn[1] != drawn[2] && drawn[0] != drawn[2], "{}", picture.key);
    }
}
