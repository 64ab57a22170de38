//! Claims about the picture: size, colours where the numbers are, refusal of what cannot be drawn.

#[path = "record_synthetic/mod.rs"]
mod synthetic;

use synthetic::{frame, pad, pads, sphere};
use tactus::render::{HEIGHT, Pixmap, Scalar, Style, WIDTH, colormap, encode, render_pads, save};

/// Centre of the drawing of the left pad: see the layout in `src/render/pads.rs`.
const LEFT_CENTER: (u32, u32) = (209, 272);

fn rgb(picture: &Pixmap, at: (u32, u32)) -> [f32; 3] {
    let pixel = picture.pixel(at.0, at.1).expect("inside");
    [pixel.red(), pixel.green(), pixel.blue()].map(f32::from)
}

fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f32::max)
}

#[test]
fn the_middle_of_the_bump_is_hot_and_the_rim_is_cold() {
    let pads = vec![pad([12, 14, 3], true); 2];
    let style = Style { markers: false, title: "sphere, grasp 000".into(), ..Style::default() };
    let picture =
        render_pads(&pads, &frame(&pads, 49, 1e-3), Some(&sphere(48, synthetic::RADIUS)), &style).expect("drawn");
    assert_eq!((picture.width(), picture.height()), (WIDTH, HEIGHT));
    assert!(distance(rgb(&picture, LEFT_CENTER), colormap::color(1.0)) < 12.0, "{:?}", rgb(&picture, LEFT_CENTER));
    let rim = (LEFT_CENTER.0, LEFT_CENTER.1 - 118);
    assert!(distance(rgb(&picture, rim), colormap::color(0.01)) < 25.0, "{:?}", rgb(&picture, rim));
}

#[test]
fn saved_png_reads_back_and_is_the_same_bytes_each_time() {
    let pads = pads(false);
    for scalar in [Scalar::Stress, Scalar::Displacement, Scalar::ContactForce] {
        let style = Style { scalar, ..Style::default() };
        let draw = || render_pads(&pads, &frame(&pads, 3, 0.5e-3), None, &style).expect("drawn");
        let dir = tempfile::tempdir().expect("temporary directory");
        let path = dir.path().join("pads.png");
        save(&draw(), &path).expect("saved");
        let bytes = std::fs::read(&path).expect("read");
        assert_eq!(bytes, encode(&draw()).expect("encoded"));
        let back = Pixmap::load_png(&path).expect("a PNG");
        assert_eq!((back.width(), back.height()), (WIDTH, HEIGHT));
    }
}

#[test]
fn odd_inputs_are_drawn_or_refused_never_a_panic() {
    let good = pads(true);
    let style = Style::default();
    assert!(render_pads(&[], &Default::default(), None, &style).is_ok(), "an empty frame is an empty picture");
    let mut bad = frame(&good, 7, 1e-3);
    bad.pads[1].von_mises_node[4] = f64::NAN;
    let message = render_pads(&good, &bad, None, &style).expect_err("NaN").to_string();
    assert!(message.contains("frame 7") && message.contains("von_mises_node[4]"), "{message}");
    let unfit = Style { range: Some((2.0, 1.0)), ..Style::default() };
    assert!(render_pads(&good, &frame(&good, 0, 1e-3), None, &unfit).is_err());
    let mut flat = good.clone();
    flat[0].rest.iter_mut().for_each(|p| *p = glam::DVec3::ZERO);
    assert!(
        render_pads(&flat, &frame(&flat, 0, 1e-3), None, &style).is_ok(),
        "a collapsed pad has no face but no panic"
    );
    let mut far = frame(&good, 0, 1e-3);
    far.pads[0].position[0] = glam::DVec3::splat(1e300);
    let _ = render_pads(&good, &far, None, &style);
}
