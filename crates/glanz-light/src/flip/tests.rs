use super::*;

// The expected numbers are those of the authors' program (PyPI flip-evaluator 1.7):
// `evaluate(reference, test, "LDR", inputsRGB=False, applyMagma=False)` and
// `evaluate(reference, test, "HDR", applyMagma=False)` on the pictures below, which are exact in f32.

const WIDTH: u32 = 53;
const HEIGHT: u32 = 37;

fn picture(f: impl Fn(i32, i32, i32) -> f32) -> Pixels {
    let pixel = |i: u32| {
        let (x, y) = ((i % WIDTH) as i32, (i / WIDTH) as i32);
        std::array::from_fn(|c| f(x, y, c as i32))
    };
    let rgb: Vec<[f32; 3]> = (0..WIDTH * HEIGHT).map(pixel).collect();
    Pixels::try_from_rgb(WIDTH, HEIGHT, &rgb).unwrap()
}

fn ramp() -> Pixels {
    picture(|x, y, c| ((x * 4 + y * 3 * c) % 256) as f32 / 256.0)
}

fn noisy_ramp() -> Pixels {
    picture(|x, y, c| {
        let noise = ((x * 31 + y * 17 + c * 11) % 32) as f32 / 256.0;
        (((x * 4 + y * 3 * c) % 256) as f32 / 256.0 + noise).min(1.0)
    })
}

fn edge_at(column: i32) -> Pixels {
    picture(|x, _, c| (if x < column { 0.25 } else { 0.75 }) + c as f32 * 0.0625)
}

fn check(found: &FlipMap, mean: f64, corners: [f32; 4]) {
    assert!((found.mean - mean).abs() < 2e-5, "mean {}, expected {mean}", found.mean);
    for ((x, y), expected) in [(0, 0), (21, 10), (30, 20), (52, 36)].into_iter().zip(corners) {
        let error = found.errors[y * WIDTH as usize + x];
        assert!((error - expected).abs() < 2e-5, "({x}, {y}): {error}, expected {expected}");
    }
}

#[test]
fn ldr_errors_equal_those_of_the_authors_program() {
    let noise = ldr(&noisy_ramp(), &ramp(), PIXELS_PER_DEGREE).unwrap();
    check(&noise, 0.216_234_5, [0.569_907, 0.171_273, 0.149_756, 0.323_896]);
    let edge = ldr(&edge_at(22), &edge_at(20), PIXELS_PER_DEGREE).unwrap();
    check(&edge, 0.050_798_5, [0.0, 0.549_037, 0.0, 0.0]);
    let dots = picture(|x, y, _| if x % 9 == 4 && y % 7 == 3 { 1.0 } else { 0.125 });
    let dots = ldr(&edge_at(20), &dots, PIXELS_PER_DEGREE).unwrap();
    check(&dots, 0.813_506_1, [0.591_769, 0.899_242, 0.948_721, 0.947_411]);
    let reddish = picture(|_, _, c| [1.0, 0.5, 0.25][c as usize]);
    let bluish = picture(|_, _, c| [0.0, 0.5, 1.0][c as usize]);
    check(&ldr(&bluish, &reddish, PIXELS_PER_DEGREE).unwrap(), 0.958_22, [0.958_22; 4]);
}

#[test]
fn ldr_errors_at_another_resolution_equal_those_of_the_authors_program() {
    let found = ldr(&noisy_ramp(), &ramp(), 20.0).unwrap();
    assert!((found.mean - 0.280_013_17).abs() < 2e-5, "{}", found.mean);
}

#[test]
fn hdr_errors_and_exposures_equal_those_of_the_authors_program() {
    let light = |x: i32, y: i32, c: i32| ((x * 5 + y * 3 + c) % 13 - 4) as f32;
    let reference = picture(|x, y, c| light(x, y, c).exp2());
    let test =
        picture(|x, y, c| light(x, y, c).exp2() * (1.0 + ((x * 7 + y * 11 + c * 5) % 16) as f32 / 16.0));
    let found = hdr(&test, &reference, PIXELS_PER_DEGREE).unwrap();
    check(&found, 0.190_404_1, [0.262_409, 0.191_493, 0.180_552, 0.424_973]);
    assert_eq!(found.exposures.len(), 5);
    assert!((found.exposures[0] + 6.633_066).abs() < 1e-5 && (found.exposures[4] + 1.866_648).abs() < 1e-5);

    let lamp = |radius: i32, dark: f32| {
        picture(move |x, y, c| {
            let inside = (x - 26).pow(2) + (y - 18).pow(2) < radius;
            (if inside { 64.0 } else { dark }) * (1.0 + c as f32 / 4.0)
        })
    };
    let found = hdr(&lamp(40, 0.09375), &lamp(50, 0.0625), PIXELS_PER_DEGREE).unwrap();
    check(&found, 0.361_959_6, [0.335_054, 0.479_948, 0.190_292, 0.335_054]);
    assert_eq!(found.exposures.len(), 10);
}

#[test]
fn equal_pictures_have_no_error() {
    for map in
        [ldr(&ramp(), &ramp(), PIXELS_PER_DEGREE).unwrap(), hdr(&ramp(), &ramp(), PIXELS_PER_DEGREE).unwrap()]
    {
        assert_eq!(map.mean, 0.0);
        assert!(map.errors.iter().all(|&e| e == 0.0));
    }
}

#[test]
fn error_between_flat_green_and_flat_blue_is_one() {
    let green = picture(|_, _, c| if c == 1 { 1.0 } else { 0.0 });
    let blue = picture(|_, _, c| if c == 2 { 1.0 } else { 0.0 });
    let found = ldr(&green, &blue, PIXELS_PER_DEGREE).unwrap();
    assert!((found.mean - 1.0).abs() < 1e-4, "{}", found.mean);
}

#[test]
fn errors_lie_in_the_unit_interval_for_any_light() {
    let odd = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0, f32::MAX, 1e-40, 0.0, 1.0];
    let first = picture(|x, y, c| odd[((x + 3 * y + 5 * c) % 8) as usize]);
    let second = picture(|x, y, c| odd[((3 * x + y + c) % 8) as usize]);
    let black = picture(|_, _, _| 0.0);
    for (test, reference) in [(&first, &second), (&second, &first), (&first, &black), (&black, &first)] {
        for map in [
            ldr(test, reference, PIXELS_PER_DEGREE).unwrap(),
            hdr(test, reference, PIXELS_PER_DEGREE).unwrap(),
        ] {
            assert!(map.errors.iter().all(|e| (0.0..=1.0).contains(e)) && map.mean.is_finite());
        }
    }
}

#[test]
fn single_pixel_can_be_compared() {
    let one = |v: f32| Pixels::try_from_rgb(1, 1, &[[v; 3]]).unwrap();
    assert!(ldr(&one(0.2), &one(0.4), PIXELS_PER_DEGREE).unwrap().mean > 0.0);
    assert!(hdr(&one(0.2), &one(0.4), PIXELS_PER_DEGREE).unwrap().mean > 0.0);
}

#[test]
fn resolution_that_is_not_positive_is_refused() {
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(ldr(&ramp(), &ramp(), bad), Err(CompareError::Resolution(_))));
    }
}
