use super::*;

const BOUNDS: Bounds = Bounds { min: [-0.42, -0.12, -0.42], max: [0.42, 0.12, 0.42], center: [0.0; 3], radius: 0.42 };

fn image(width: u32, height: u32) -> Image {
    Image { width, height, rgba: vec![0; 4 * (width * height) as usize] }
}

#[test]
fn image_spans_the_model_once_by_default() {
    let wide = image(4, 2);
    assert_eq!(spanning_m(&wide, PatternProjection::Z, &BOUNDS), 0.84);
    assert_eq!(spanning_m(&wide, PatternProjection::Y, &BOUNDS), 1.68, "0.84 high, twice as wide");
    assert_eq!(spanning_m(&wide, PatternProjection::Box, &Bounds::default()), 1.0);
}

#[test]
fn projection_keeps_right_and_up_of_the_image() {
    for along in PatternProjection::ALL.iter().copied() {
        let projection = Projection::new(along, Wrap::Clamp, &image(4, 2), &BOUNDS, Some(2.0));
        let at = |p: Vec3| projection.read(p, Vec3::X, |at| at.uv);
        let middle = at(Vec3::ZERO);
        assert_eq!(middle, Vec2::splat(0.5), "{along:?}");
        // The image is 2 m wide and 1 m high, and v points down: a step of 1 m changes u by 1/2 and v by -1.
        let [right, up] = [0, 1].map(|k| projection.read(Vec3::ZERO, Vec3::X, |at| at.axes[k]));
        assert!((at(right * 0.2) - middle - Vec2::new(0.1, 0.0)).length() < 1e-6, "{along:?}");
        assert!((at(up * 0.2) - middle - Vec2::new(0.0, -0.2)).length() < 1e-6, "{along:?}");
    }
}

#[test]
fn a_box_is_blended_by_the_normal() {
    let projection = Projection::new(PatternProjection::Box, Wrap::Clamp, &image(1, 1), &BOUNDS, None);
    let up = |normal: Vec3| projection.read(Vec3::ZERO, normal, |at| at.axes[1]);
    assert_eq!((up(Vec3::X), up(Vec3::Y), up(Vec3::NEG_Z)), (Vec3::Y, Vec3::NEG_Z, Vec3::Y));
    let between = up(Vec3::new(1.0, 1.0, 0.0).normalize());
    assert!((between - Vec3::new(0.0, 0.5, -0.5)).length() < 1e-6, "{between}");
    assert_eq!(up(Vec3::ZERO), Vec3::NEG_Z, "no normal, seen from above");
}
