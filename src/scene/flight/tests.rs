use super::*;
use glam::Mat4;
use proptest::prelude::*;
use std::f32::consts::PI;

fn key(time_s: f64, eye: [f32; 3], about_y_rad: f32) -> FlightKey {
    let rotation = Quat::from_rotation_y(about_y_rad);
    FlightKey { time_s, eye_m: eye.into(), rotation, yfov_rad: Some(0.5 + time_s as f32 * 0.1) }
}

/// Keys anywhere at any times.
fn any_flight() -> impl Strategy<Value = Flight> {
    let number = -10.0_f32..10.0;
    let one = (0.2_f64..2.0, [number.clone(), number.clone(), number], prop::array::uniform4(-1.0_f32..1.0));
    prop::collection::vec(one, 1..8).prop_map(|keys| {
        let mut time_s = 0.0;
        let keys = keys.into_iter().map(|(step_s, eye, rotation)| {
            time_s += step_s;
            let rotation = Quat::from_array(rotation) + Quat::from_xyzw(0.0, 0.0, 0.0, 2.0);
            let yfov_rad = (eye[0] > -5.0).then_some(0.8);
            FlightKey { time_s, eye_m: eye.into(), rotation: rotation.normalize(), yfov_rad }
        });
        Flight::new(keys.collect()).unwrap()
    })
}

proptest! {
    #[test]
    fn a_file_holds_a_flight_to_the_bit(flight in any_flight()) {
        prop_assert_eq!(&Flight::parse(&flight.text()).unwrap(), &flight);
    }

    /// Through its keys, and without a jump in place or speed.
    #[test]
    fn a_flight_is_smooth_and_goes_through_its_keys(flight in any_flight()) {
        const STEP_S: f64 = 1e-5;
        // Of single precision, in which keys are, over the step.
        const SPEED_ERROR: f64 = 1e-6 * 10.0 / STEP_S;
        let begin_s = flight.keys()[0].time_s;
        for key in flight.keys() {
            let seconds = key.time_s - begin_s;
            prop_assert!(flight.at(seconds).is_some_and(|at| at.is_at(key)));
            let [before, after] = [-STEP_S, STEP_S].map(|off| flight.at(seconds + off).unwrap());
            let speeds = [&before, &after].map(|at| (at.eye_m - key.eye_m).as_dvec3() / STEP_S);
            let turns = [&before, &after].map(|at| turn(unit(key).inverse() * unit(at)) / STEP_S);
            if seconds > 0.0 && seconds < flight.duration_s() {
                prop_assert!((speeds[0] + speeds[1]).length() < SPEED_ERROR + 0.1, "{:?}", speeds);
                prop_assert!((turns[0] + turns[1]).length() < SPEED_ERROR + 0.1, "{:?}", turns);
            }
        }
    }
}

/// A straight way at a constant speed, with keys at any times, stays one; so does a turn.
#[test]
fn what_is_steady_stays_steady() {
    let flight =
        Flight::new([0.0, 0.3, 0.4, 1.7, 2.0].map(|t| key(t, [2.0 * t as f32, 1.0, 0.0], t as f32)).to_vec());
    let flight = flight.unwrap();
    for i in 0..=100 {
        let seconds = f64::from(i) * 0.02;
        let at = flight.at(seconds).unwrap();
        let expected = key(seconds, [2.0 * seconds as f32, 1.0, 0.0], seconds as f32);
        assert!((at.eye_m - expected.eye_m).length() < 1e-5, "{seconds}: {at:?}");
        assert!(turn(unit(&at).inverse() * unit(&expected)).length() < 1e-6, "{seconds}: {at:?}");
        assert!((at.yfov_rad.unwrap() - expected.yfov_rad.unwrap()).abs() < 1e-6);
    }
    for (seconds, end) in [(-1.0, 0), (99.0, 4)] {
        assert_eq!(flight.at(seconds), Some(flight.keys()[end]));
    }
}

#[test]
fn rotations_take_the_shorter_way() {
    let mut last = key(1.0, [0.0; 3], 0.2);
    last.rotation = -last.rotation;
    let flight = Flight::new(vec![key(0.0, [0.0; 3], -0.2), last]).unwrap();
    let at = flight.at(0.5).unwrap();
    assert!(turn(unit(&at)).length() < 1e-6, "{at:?}");
}

/// What was recorded brings a camera to where it was, within what a quaternion in single precision says of a matrix.
#[test]
fn what_is_recorded_is_flown() {
    const ROUNDING: f32 = 1e-6;
    let projection = Projection::Perspective { yfov_rad: 0.7, znear_m: 0.1, zfar_m: None };
    let camera = |i: u8| {
        let turned = Mat4::from_rotation_y(f32::from(i) * 0.3) * Mat4::from_rotation_x(0.4);
        let world_from_view = Mat4::from_translation(Vec3::new(f32::from(i), 1.0, 2.0)) * turned;
        Camera { name: "hand".into(), world_from_view, projection }
    };
    let mut flight = Flight::default();
    let places = [0, 1, 1, 1, 1, 2, 3, 3, 4];
    for (i, place) in (0_u8..).zip(places) {
        flight.record(FlightKey::of(&camera(place), f64::from(i) / 60.0));
    }
    assert_eq!(flight.keys().len(), places.len() - 2, "of what stands, begin and end are kept");
    for (i, place) in (0_u8..).zip(places) {
        let mut flown = Camera { projection, ..camera(9) };
        flight.place(&mut flown, f64::from(i) / 60.0);
        let apart = flown.world_from_view - camera(place).world_from_view;
        assert!(apart.abs_diff_eq(Mat4::ZERO, ROUNDING), "{i}: {apart}");
        assert_eq!(flown.projection, projection);
    }
    let parallel = Projection::Orthographic { xmag_m: 1.0, ymag_m: 1.0, znear_m: 0.0, zfar_m: 9.0 };
    let mut flown = Camera { projection: parallel, ..camera(0) };
    assert_eq!(FlightKey::of(&flown, 0.0).yfov_rad, None);
    flight.place(&mut flown, 0.0);
    assert_eq!(flown.projection, parallel);
    // What is not after the last, or nowhere, is no part of it.
    let before = flight.clone();
    flight.record(FlightKey::of(&camera(0), 0.0));
    flight.record(FlightKey { eye_m: Vec3::NAN, ..key(9.0, [0.0; 3], 0.0) });
    assert_eq!(flight, before);
}

#[test]
fn bad_files_are_refused_with_the_line() {
    let cases = [
        ("", 1, "is not 'ontile flight 1'"),
        ("# a\nontile flight 2\n", 2, "is not 'ontile flight 1'"),
        ("ontile flight 1\n\n# none\n", 1, "there was no key"),
        ("ontile flight 1\n0 0 0 0 0 0 0 1 1\n1 0 0 0 0 0 0 1\n", 3, "has 8 values, not 9"),
        ("ontile flight 1\n0\n", 2, "has 1 value"),
        ("ontile flight 1\n0 0 0 x 0 0 0 1 1\n", 2, "has 'x' where"),
        ("ontile flight 1\n0 0 0 0 0 0 0 1 -1\n", 2, "field of view of -1 rad"),
        ("ontile flight 1\n0 0 0 0 0 0 0 1 3.2\n", 2, "field of view of 3.2 rad"),
        ("ontile flight 1\n0 0 inf 0 0 0 0 1 1\n", 2, "not finite"),
        ("ontile flight 1\nNaN 0 0 0 0 0 0 1 1\n", 2, "not finite"),
        ("ontile flight 1\n0 0 0 0 0 0 0 0 1\n", 2, "without length"),
        (
            "ontile flight 1\n1 0 0 0 0 0 0 1 1\n1 0 0 0 0 0 0 1 1\n",
            3,
            "which is not after the one before, at 1 s",
        ),
    ];
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("way.flight");
    for (text, line, problem) in cases {
        std::fs::write(&path, text).unwrap();
        let told = Flight::load(&path).unwrap_err().to_string();
        assert!(
            told.contains(&format!("way.flight: line {line}: ")) && told.contains(problem),
            "{text:?}: {told}"
        );
    }
    assert!(matches!(Flight::load(&folder.path().join("none")), Err(Error::Io { .. })));
    assert!(Flight::new(vec![]).is_err());
    let error = Flight::new(vec![key(1.0, [0.0; 3], 0.0), key(0.5, [0.0; 3], PI)]).unwrap_err().to_string();
    assert!(error.contains("key 1 of a flight is at 0.5 s"), "{error}");
    let flight = Flight::new(vec![key(1.0, [0.0; 3], 0.0), key(1.5, [0.1, 0.0, -2.0], PI)]).unwrap();
    flight.save(&path).unwrap();
    assert_eq!(Flight::load(&path).unwrap(), flight);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary file is left");
}
