//! Pictures of pads: size, colours that correspond to the values, and refusal of invalid input.

use crate::keep::Keep;
use crate::synthetic::{frame, pad, pads, sphere};
use tactus::backend::choose;
use tactus::model::Model;
use tactus::model::grasp::grasp_poses;
use tactus::record::render::{HEIGHT, Pixmap, Scalar, Style, WIDTH, colormap, encode, render_pads, save};
use tactus::scene::from_ron;
use tactus::world::run::run_grasps;

/// Centre of the left pad in the picture, pixels: see the layout in `src/render/pads.rs`.
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
    let picture = render_pads(&pads, &frame(&pads, 49, 1e-3), Some(&sphere(48, crate::synthetic::RADIUS)), &style)
        .expect("drawn");
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

/// Picture, without arrows, of a ball of 20 mm radius pressed 0.65 mm into a pad of 2.6 mm finite elements.
fn pressed_ball() -> Pixmap {
    let scene = from_ron(
        "(object: (shape: Sphere(radius: 0.02), motion: Fixed),
          gripper: (pads: GelSightMini(shape: Flat, spacing: 2.6e-3), fingers: One, friction: 0.8),
          loading: Press(depths: [0.65e-3]))",
    )
    .expect("scene");
    let (model, last) = (Model::build(&scene).expect("model"), Keep::default());
    let grasps = [(0, grasp_poses(&scene).expect("poses")[0])];
    run_grasps(&model, choose(&scene).expect("stepper").as_ref(), &grasps, 1, &last).expect("run");
    let frame = last.last();
    let pads = vec![model.fingers[0].topology.as_ref().clone()];
    let style = Style { markers: false, ..Style::default() };
    render_pads(&pads, &frame, Some(&model.object.surface), &style).expect("drawn")
}

/// Position of the colour of a pixel on the colour scale, 0 to 1; None if the scale does not have it.
fn fraction(pixel: [f32; 3]) -> Option<f64> {
    let all = (0..=200).map(|i| f64::from(i) / 200.0).map(|t| (distance(pixel, colormap::color(t)), t));
    all.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|(off, _)| *off < 6.0).map(|(_, t)| t)
}

/// At 0.5 and 0.7 of the largest displacement, the widths of the patch along x, y and both diagonals agree to 3 pixels
/// of about 70 (1 mm is 11 pixels).
#[test]
fn the_patch_of_a_ball_is_round_where_elements_are_as_large_as_half_of_it() {
    let picture = pressed_ball();
    // A single pad takes the full height of the picture.
    let center = (209.0, 440.0);
    for level in [0.5, 0.7] {
        let reach = |direction: usize| {
            let angle = std::f64::consts::FRAC_PI_4 * direction as f64;
            let at =
                |r: f64| ((center.0 + r * angle.cos()).round() as u32, (center.1 - r * angle.sin()).round() as u32);
            let inside = |r: &f64| fraction(rgb(&picture, at(*r))).is_some_and(|t| t > level);
            (0..400).map(|i| 0.25 * f64::from(i)).take_while(inside).last().expect("the middle is hot")
        };
        let width: Vec<f64> = (0..4).map(|direction| reach(direction) + reach(direction + 4)).collect();
        let (low, high) = width.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), w| (low.min(*w), high.max(*w)));
        println!("level {level}: {width:?}");
        assert!(low > 40.0 && high - low <= 3.0, "level {level}: {width:?}");
    }
}

/// The cut face of the ball has one flat colour: its rows of that colour form an ellipse, which is point-symmetric
/// about its centre to 4 pixels. Anything visible through the cut would interrupt a row on one side.
#[test]
fn nothing_shows_through_the_cut_of_a_ball() {
    let picture = pressed_ball();
    let flat = |x: i32, y: i32| distance(rgb(&picture, (x as u32, y as u32)), [212.0, 205.0, 192.0]) < 1.5;
    let run =
        |(x, y): (i32, i32), (dx, dy): (i32, i32)| (1..).take_while(|i| flat(x + i * dx, y + i * dy)).count() as i32;
    // Moving to the midpoints of horizontal and vertical chords converges to the centre of the ellipse.
    let mut middle = (1000, 420);
    assert!(flat(middle.0, middle.1));
    for _ in 0..8 {
        middle.0 += (run(middle, (1, 0)) - run(middle, (-1, 0))) / 2;
        middle.1 += (run(middle, (0, 1)) - run(middle, (0, -1))) / 2;
    }
    // Near top and bottom the chord length changes by many pixels from row to row, so these rows are excluded.
    let height = run(middle, (0, 1)) * 4 / 5;
    assert!(height > 150, "{height} pixels");
    for k in -height..=height {
        let (left, right) = (run((middle.0, middle.1 + k), (-1, 0)), run((middle.0, middle.1 - k), (1, 0)));
        assert!(
            (left - right).abs() <= 4,
            "{k} rows from the middle {middle:?}: {left} to the left, {right} to the right"
        );
    }
}
