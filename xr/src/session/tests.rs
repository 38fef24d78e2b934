//! What the reader and the writer of sessions must hold, case by case.

#![allow(
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    clippy::missing_assert_message,
    reason = "tests say what they expect by their names"
)]

use glam::{Quat, Vec2, Vec3};
use proptest::prelude::*;

use super::*;
use crate::frame::{Fov, Hand};

const EXAMPLE: &str = "\
ramus-session 1
# A hand comes into view, pulls the trigger and goes.
frame 0
left eye -0.9 0.7 0.8 -0.8 -0.03 0 0 0 0 0 1

frame 0.0125
right tracked yes
right aim 0.1 1.2 -0.4 0 0 0 1
right grip 0.1 1.2 -0.35 0.70710677 0 0 0.70710677
frame 0.025
head 0.5 1.6 0 0 1 0 0
right trigger 0.75
right stick -1 1e-7
frame 0.0375
right tracked no
right trigger 0
";

fn message(text: &[u8]) -> String {
    from_bytes(text).unwrap_err().to_string()
}

#[test]
fn reads_what_is_said_and_keeps_the_rest() {
    let frames = from_bytes(EXAMPLE.as_bytes()).unwrap();
    assert_eq!(frames.len(), 4);
    let start = Frame::start();
    assert_eq!(frames[0].hands, start.hands);
    assert_eq!(frames[0].views[1], start.views[1]);
    assert_eq!(
        frames[0].views[0].fov,
        Fov {
            left: -0.9,
            right: 0.7,
            up: 0.8,
            down: -0.8
        }
    );
    assert_eq!(frames[1].hands[1].aim.position, Vec3::new(0.1, 1.2, -0.4));
    assert_eq!(
        frames[1].hands[1].grip.orientation.x,
        std::f32::consts::FRAC_1_SQRT_2
    );
    assert!(frames[1].hands[1].tracked && !frames[1].hands[0].tracked);
    assert_eq!(frames[2].hands[1].trigger, 0.75);
    assert_eq!(frames[2].hands[1].stick, Vec2::new(-1.0, 1e-7));
    // The head turned half round and moved: the left eye went with it.
    let eye = frames[2].views[0].pose.position;
    assert!(eye.distance(Vec3::new(0.53, 1.6, 0.0)) < 1e-6, "{eye}");
    assert_eq!(frames[3].hands[1].aim, frames[1].hands[1].aim);
    assert_eq!(frames[3].time, 0.0375);
}

#[test]
fn writes_only_what_changed() {
    let frames = from_bytes(EXAMPLE.as_bytes()).unwrap();
    let text = String::from_utf8(to_bytes(&frames).unwrap()).unwrap();
    let canonical: Vec<&str> = EXAMPLE
        .lines()
        .filter(|line| !line.is_empty() && !line.starts_with('#'))
        .collect();
    assert_eq!(text.lines().collect::<Vec<_>>(), canonical);
    let still = vec![Frame::start(); 3];
    assert_eq!(
        to_bytes(&still).unwrap(),
        b"ramus-session 1\nframe 0\nframe 0\nframe 0\n"
    );
}

#[test]
fn an_eye_that_is_not_fixed_to_the_head_is_written_in_the_stage() {
    let mut frame = Frame::start();
    frame.views[0].pose.position = Vec3::new(0.123_456_79, 1.0, 0.3);
    let text = String::from_utf8(to_bytes(&[frame]).unwrap()).unwrap();
    assert!(text.contains("left view "), "{text}");
    assert_eq!(from_bytes(text.as_bytes()).unwrap(), [frame]);
}

#[test]
fn every_broken_session_says_where_and_what() {
    let begun = |line: &str| format!("ramus-session 1\nframe 0\n{line}\n").into_bytes();
    let line = "session line 3, column";
    let table: Vec<(Vec<u8>, String)> = vec![
        (
            b"".to_vec(),
            "session line 1, column 1: the file is empty".into(),
        ),
        (
            b"PNG".to_vec(),
            "session line 1, column 1: this is no session".into(),
        ),
        (
            b"ramus-session".to_vec(),
            "session line 1, column 14: the line ends too early".into(),
        ),
        (
            b"ramus-session 2\n".to_vec(),
            "column 15: format `2` is not known".into(),
        ),
        (
            b"ramus-session 1 x\n".to_vec(),
            "column 17: `x` is one word too many".into(),
        ),
        (
            b"ramus-session 1\nhead 0 0 0 0 0 0 1\n".to_vec(),
            "line 2, column 1: a session's first frame".into(),
        ),
        (
            b"ramus-session 1\nframe\n".to_vec(),
            "line 2, column 6: the line ends too early".into(),
        ),
        (
            b"ramus-session 1\nframe -1\n".to_vec(),
            "column 7: `-1` is no time".into(),
        ),
        (
            b"ramus-session 1\nframe NaN\n".to_vec(),
            "column 7: `NaN` is no time".into(),
        ),
        (
            b"ramus-session 1\nframe 1e300\n".to_vec(),
            "`1e300` is no time".into(),
        ),
        (
            b"ramus-session 1\nframe 1\nframe 0.9\n".to_vec(),
            "line 3, column 7: a frame follows".into(),
        ),
        (
            b"ramus-session 1\nframe 1\nframe 1.2\n".to_vec(),
            "line 3, column 7: a frame follows".into(),
        ),
        (
            begun("head 0 0 0 0 0 0"),
            format!("{line} 17: the line ends too early"),
        ),
        (
            begun("head 0 0 0 0 0 0 1 1"),
            format!("{line} 20: `1` is one word too many"),
        ),
        (begun("head 0 0 0 0 0 0 0"), format!("{line} 6: a pose is")),
        (begun("head 0 0 0 0 0 0 2"), format!("{line} 6: a pose is")),
        (
            begun("head 0 nan 0 0 0 0 1"),
            format!("{line} 8: a number here is finite"),
        ),
        (
            begun("head 0 0 inf 0 0 0 1"),
            format!("{line} 10: a number here is finite"),
        ),
        (
            begun("head 0 0 1e99 0 0 0 1"),
            format!("{line} 10: a number here is finite"),
        ),
        (
            begun("head 0 0 1e30 0 0 0 1"),
            format!("{line} 6: a pose is"),
        ),
        (
            begun("head 0 O 0 0 0 0 1"),
            format!("{line} 8: `O` is no number"),
        ),
        (
            begun("left trigger 1.5"),
            format!("{line} 14: `1.5` is not between 0 and 1"),
        ),
        (
            begun("left stick 0 -1.01"),
            format!("{line} 14: `-1.01` is not between -1 and 1"),
        ),
        (
            begun("left lower 1"),
            format!("{line} 12: `1` is neither yes nor no"),
        ),
        (begun("left"), format!("{line} 5: the line ends too early")),
        (
            begun("left foot yes"),
            format!("{line} 6: `foot` is unknown"),
        ),
        (
            begun("middle lower yes"),
            format!("{line} 1: `middle` is unknown"),
        ),
        (
            begun("left lower yes\nleft lower no"),
            "session line 4, column 1: this frame has said that already".into(),
        ),
        (
            begun("left view 0.5 0.4 0.8 -0.8 0 0 0 0 0 0 1"),
            format!("{line} 11: a field of view is"),
        ),
        (
            begun("left eye -1.6 0.4 0.8 -0.8 0 0 0 0 0 0 1"),
            format!("{line} 10: a field of view is"),
        ),
        (
            begun("left eye -1 1 1 -1 9999 0 0 0 0 0 1\nhead 9999 0 0 0 0 0 1"),
            "session line 2, column 1: the left view".into(),
        ),
        (
            begun("\u{1b}[2J\u{7}evil"),
            format!("{line} 1: `\\u{{1b}}[2J\\u{{7}}evil` is unknown"),
        ),
        (
            begun(&"x".repeat(100)),
            format!("{line} 1: `xxxxxxxxxxxxxxxxxxxxxxxx…` is unknown"),
        ),
        (
            begun(&" ".repeat(MAX_LINE + 1)),
            format!("{line} {}: the line is longer than", MAX_LINE + 1),
        ),
        (
            b"ramus-session 1\nframe 0\nhead \xff\n".to_vec(),
            format!("{line} 6: this is not text"),
        ),
    ];
    for (text, expected) in table {
        let found = message(&text);
        assert!(
            found.contains(&expected),
            "{:?}\nexpected {expected:?}\nfound {found:?}",
            String::from_utf8_lossy(&text)
        );
        assert!(!found.contains('\n'), "more than one line: {found:?}");
    }
}

#[test]
fn lines_may_be_as_long_as_allowed_and_end_as_windows_ends_them() {
    let padded = format!(
        "ramus-session 1\r\nframe 0\r\n{}\r\nfocused no",
        " ".repeat(MAX_LINE - 1)
    );
    assert!(!from_bytes(padded.as_bytes()).unwrap()[0].focused);
}

#[test]
fn an_endless_line_is_given_up_early() {
    struct Endless(usize);
    impl io::Read for Endless {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            buffer.fill(b'a');
            self.0 += buffer.len();
            assert!(self.0 < 1 << 20, "the reader goes on for ever");
            Ok(buffer.len())
        }
    }
    assert!(SessionReader::new(BufReader::new(Endless(0))).is_err());
}

#[test]
fn too_many_frames_are_refused_and_an_error_ends_the_reading() {
    let mut text = String::from("ramus-session 1\n");
    text.push_str(&"frame 0\n".repeat(MAX_FRAMES + 1));
    let mut reader = SessionReader::new(text.as_bytes()).unwrap();
    let good = reader.by_ref().take_while(Result::is_ok).count();
    assert_eq!(
        good,
        MAX_FRAMES - 1,
        "the frame before the one too many is not given either"
    );
    assert!(reader.next().is_none());
}

#[test]
fn the_writer_refuses_what_the_reader_would() {
    let mut writer = SessionWriter::new(Vec::new()).unwrap();
    let mut frame = Frame::start();
    frame.time = 1.0;
    writer.write(&frame).unwrap();
    let faults = [
        Frame {
            time: f64::NAN,
            ..frame
        },
        Frame { time: 0.5, ..frame },
        Frame { time: 1.2, ..frame },
        Frame {
            head: Pose {
                position: Vec3::NAN,
                ..Pose::IDENTITY
            },
            ..frame
        },
        Frame {
            head: Pose {
                orientation: Quat::from_xyzw(0.0, 0.0, 0.0, 0.0),
                ..Pose::IDENTITY
            },
            ..frame
        },
        Frame {
            hands: [Hand {
                trigger: -0.1,
                ..Hand::ABSENT
            }; 2],
            ..frame
        },
        Frame {
            hands: [Hand {
                stick: Vec2::splat(f32::NAN),
                ..Hand::ABSENT
            }; 2],
            ..frame
        },
        Frame {
            views: [View {
                fov: Fov {
                    left: 1.0,
                    ..Fov::SQUARE
                },
                pose: Pose::IDENTITY,
            }; 2],
            ..frame
        },
    ];
    for fault in faults {
        assert!(writer.write(&fault).is_err(), "{fault:?}");
    }
    writer.write(&frame).unwrap();
    assert_eq!(
        writer.finish().unwrap(),
        b"ramus-session 1\nframe 1\nframe 1\n"
    );
}

#[test]
fn rounded_quaternions_become_unit_and_unit_ones_stay() {
    let text = b"ramus-session 1\nframe 0\nhead 0 1 0 -0.1707 0 0 0.9853\nleft eye -1 1 1 -1 0 0 0 0 0.7071 0 0.7071\n";
    let frames = from_bytes(text).unwrap();
    for orientation in [
        frames[0].head.orientation,
        frames[0].views[0].pose.orientation,
    ] {
        assert!((orientation.length() - 1.0).abs() < 2e-7, "{orientation}");
    }
    assert_eq!(frames[0].settled(), Ok(frames[0]));
    // The writer keeps the short numbers, and eyes that follow the head are not said again.
    let rough = Quat::from_xyzw(-0.1707, 0.0, 0.0, 0.9853);
    let head = Pose {
        orientation: rough,
        ..Frame::start().head
    };
    let views = Frame::eyes().map(|eye| View {
        pose: head * eye.pose,
        ..eye
    });
    let written = to_bytes(&[Frame {
        head,
        views,
        ..Frame::start()
    }])
    .unwrap();
    assert_eq!(
        String::from_utf8_lossy(&written),
        "ramus-session 1\nframe 0\nhead 0 1.6 0 -0.1707 0 0 0.9853\n"
    );
    assert_eq!(from_bytes(&written).unwrap()[0].head, head.settled());
}

/// Found by the fuzzer: rounding an eye's offset gave a quaternion that the reader then changed.
#[test]
fn an_eye_far_from_a_turned_head_survives_writing() {
    let text = "ramus-session 1\nframe 0\nright view -0.7 0.9 0.8 -0.8 -703 1.6 0 0 0 0 1\n\
                frame 0.0125\nhead 0.51 1.2 -0.35 0.70710677 0 0 0.70710677\n";
    let frames = from_bytes(text.as_bytes()).unwrap();
    let again = from_bytes(&to_bytes(&frames).unwrap()).unwrap();
    assert_eq!(bits(&frames), bits(&again));
}

#[test]
fn a_missing_file_is_named() {
    let error = read_file(Path::new("no-such.session"))
        .unwrap_err()
        .to_string();
    assert!(
        error.starts_with("cannot open the session no-such.session: "),
        "{error}"
    );
}

fn pose() -> impl Strategy<Value = Pose> {
    let turn = prop_oneof![
        Just(Quat::IDENTITY),
        Just(Quat::from_xyzw(-0.0, 1.0, 0.0, -0.0)),
        (-1.0f32..1.0, -1.0f32..1.0, -1.0f32..1.0, 0.1f32..1.0)
            .prop_map(|(x, y, z, w)| Quat::from_xyzw(x, y, z, w).normalize()),
    ];
    let place = prop_oneof![
        Just(0.0f32),
        Just(-0.0),
        Just(f32::MIN_POSITIVE / 8.0),
        -3.0f32..3.0,
        -9999.0f32..9999.0
    ];
    (turn, [place.clone(), place.clone(), place]).prop_map(|(orientation, position)| Pose {
        orientation,
        position: Vec3::from_array(position),
    })
}

fn fov() -> impl Strategy<Value = Fov> {
    (-1.5f32..0.0, 0.01f32..1.5, 0.01f32..1.5, -1.5f32..0.0).prop_map(|(left, right, up, down)| {
        Fov {
            left,
            right,
            up,
            down,
        }
    })
}

fn hand() -> impl Strategy<Value = Hand> {
    (
        any::<(bool, bool, bool)>(),
        pose(),
        pose(),
        0.0f32..=1.0,
        0.0f32..=1.0,
        -1.0f32..=1.0,
        -1.0f32..=1.0,
    )
        .prop_map(
            |((tracked, lower, upper), aim, grip, trigger, squeeze, x, y)| Hand {
                tracked,
                aim,
                grip,
                trigger,
                squeeze,
                stick: Vec2::new(x, y),
                lower,
                upper,
            },
        )
}

/// Each part of a frame changes or stays, so that all ways of leaving things out are met.
fn frames() -> impl Strategy<Value = Vec<Frame>> {
    let change = (
        0.0f64..0.1,
        any::<[Option<bool>; 2]>(),
        proptest::option::of(pose()),
        [
            proptest::option::of((any::<bool>(), pose(), fov())),
            proptest::option::of((any::<bool>(), pose(), fov())),
        ],
        [proptest::option::of(hand()), proptest::option::of(hand())],
    );
    proptest::collection::vec(change, 0..12).prop_map(|changes| {
        let mut frame = Frame::start();
        let mut eyes = Frame::eyes().map(Eye::Relative);
        changes
            .into_iter()
            .map(|(step, flags, head, views, hands)| {
                frame.time += step;
                frame.focused = flags[0].unwrap_or(frame.focused);
                frame.should_render = flags[1].unwrap_or(frame.should_render);
                frame.head = head.unwrap_or(frame.head);
                for (eye, change) in eyes.iter_mut().zip(views) {
                    if let Some((relative, pose, fov)) = change {
                        let view = View { pose, fov };
                        *eye = if relative {
                            Eye::Relative(view)
                        } else {
                            Eye::Absolute(view)
                        };
                    }
                }
                frame.views = eyes.map(|eye| eye.view(frame.head));
                for (hand, change) in frame.hands.iter_mut().zip(hands) {
                    *hand = change.unwrap_or(*hand);
                }
                frame
            })
            .filter_map(|frame| frame.settled().ok())
            .collect()
    })
}

/// All bits of a frame: −0 and 0 differ here, as they do in `Debug`.
fn bits(frames: &[Frame]) -> String {
    format!("{frames:?}")
}

proptest! {
    #[test]
    fn round_trips_are_exact(frames in frames()) {
        // Leaving out insane frames may leave gaps in time.
        prop_assume!(frames.windows(2).all(|pair| follows(pair[0].time, pair[1].time)));
        let bytes = to_bytes(&frames).unwrap();
        let read = from_bytes(&bytes).unwrap();
        prop_assert_eq!(bits(&read), bits(&frames));
        prop_assert_eq!(to_bytes(&read).unwrap(), bytes);
    }

    #[test]
    fn any_bytes_end_in_frames_or_an_error(tail in proptest::collection::vec(any::<u8>(), 0..300)) {
        let _ = from_bytes(&tail);
        let mut text = b"ramus-session 1\nframe 0\n".to_vec();
        text.extend(tail);
        for frame in SessionReader::new(&text[..]).unwrap().flatten() {
            prop_assert!(frame.check().is_ok());
        }
    }

    #[test]
    fn a_damaged_session_ends_in_frames_or_an_error(at in 0usize..500, byte in any::<u8>()) {
        let mut text = EXAMPLE.as_bytes().to_vec();
        if let Some(old) = text.get_mut(at) {
            *old = byte;
        }
        if let Ok(frames) = from_bytes(&text) {
            prop_assert!(frames.iter().all(|frame| frame.check().is_ok()));
            prop_assert!(to_bytes(&frames).is_ok());
        }
    }
}
