//! Moves the headset and the controllers of Monado's remote driver, packet by packet.
//!
//! The driver (`src/xrt/drivers/remote` in Monado, header `mndrmt3`) listens on a TCP port, sends two packets of its
//! own (its rest state and its present one) and then takes each 376 bytes as the new state of everything: what an
//! application reads at its next sync is what was sent last. Numbers are little endian:
//!
//! | at | bytes | what |
//! |---|---|---|
//! | 0 | 8 | header `mndrmt3` and a zero |
//! | 8 | 2 × 48 | each eye: field of view 4f (left right up down), pose relative to the head 7f, 4 unused |
//! | 104 | 28 | head pose 7f |
//! | 132 | 4 | 1 where the eyes are to be used; 3 unused |
//! | 136 | 120 | left controller |
//! | 256 | 120 | right controller |
//!
//! A pose is a quaternion x y z w, then a position. A controller is
//!
//! | at | bytes | what |
//! |---|---|---|
//! | 0 | 28 | pose |
//! | 28 | 24 | linear and angular velocity |
//! | 52 | 20 | curl of the fingers, little to thumb |
//! | 72 | 32 | trigger, squeeze, squeeze force, thumbstick 2f, trackpad force, trackpad 2f |
//! | 104 | 16 | one byte each: hand tracking, active, system click and touch, A, B, trigger, thumbstick the same, trackpad touch; 3 unused |
//!
//! **One pose a hand**: the driver gives the same pose for an Index controller's grip and aim
//! (`r_device_get_tracked_pose` in `r_device.c` answers both with the packet's pose, without an offset). So a session
//! that is to be played exactly through Monado has equal grip and aim poses; [`Packet::from_frame`] refuses others.

use std::{
    io::{self, Read as _, Write as _},
    net::TcpStream,
    thread,
    time::{Duration, Instant},
};

use glam::{Quat, Vec2, Vec3};
use ramus_xr::{Fov, Frame, Hand, Pose, View};

/// Bytes of a packet.
pub const PACKET_BYTES: usize = 376;

/// First bytes of a packet of this protocol.
const HEADER: [u8; 8] = *b"mndrmt3\0";

/// What the service's own two packets begin with: it fills in everything but the header.
const NO_HEADER: [u8; 8] = [0; 8];

/// How long the service may take to accept and to greet, and a packet to go out. A liveness guard.
const PATIENCE: Duration = Duration::from_secs(20);

/// Pause between two tries to connect.
const TRY_AGAIN: Duration = Duration::from_millis(20);

/// Why the remote driver cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum RemoteError {
    /// The connection failed.
    #[error("the remote driver's connection failed: {0}; see the service's log")]
    Io(#[from] io::Error),
    /// The service speaks another version.
    #[error(
        "the runtime's remote driver speaks {found:?} and not mndrmt3: this Monado is another version than the stage knows"
    )]
    Protocol {
        /// The header that it sent.
        found: String,
    },
    /// The frame cannot be said in a packet.
    #[error(
        "the {side} hand's grip and aim poses differ, and the remote driver has one pose a hand: make them equal in the session"
    )]
    TwoPoses {
        /// `left` or `right`.
        side: &'static str,
    },
}

/// One controller's state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Controller {
    /// Grip and aim.
    pub pose: Pose,
    /// Metres a second.
    pub linear_velocity: Vec3,
    /// Radians a second, in the controller's own axes.
    pub angular_velocity: Vec3,
    /// Little finger to thumb, 0 straight to 1 curled.
    pub curl: [f32; 5],
    /// 0 to 1.
    pub trigger: f32,
    /// 0 to 1.
    pub squeeze: f32,
    /// 0 to 1: how hard beyond closed.
    pub squeeze_force: f32,
    /// x right, y up.
    pub stick: Vec2,
    /// 0 to 1.
    pub trackpad_force: f32,
    /// x right, y up.
    pub trackpad: Vec2,
    /// The bytes in the order of the table: whether each is set.
    pub buttons: [bool; 13],
}

/// Places in [`Controller::buttons`].
pub mod button {
    /// Hand tracking is on.
    pub const HAND_TRACKING: usize = 0;
    /// The controller is tracked.
    pub const ACTIVE: usize = 1;
    /// A is pressed.
    pub const A: usize = 4;
    /// B is pressed.
    pub const B: usize = 6;
}

/// Everything that the driver says at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Packet {
    /// Eyes relative to the head; `None` leaves them to the driver.
    pub eyes: Option<[View; 2]>,
    /// The head.
    pub head: Pose,
    /// Left, right.
    pub controllers: [Controller; 2],
}

impl Controller {
    /// A controller in a hand of a session.
    fn from_hand(hand: &Hand) -> Self {
        let mut buttons = [false; 13];
        buttons[button::ACTIVE] = hand.tracked;
        buttons[button::A] = hand.lower;
        buttons[button::B] = hand.upper;
        Self {
            pose: hand.aim,
            linear_velocity: Vec3::ZERO,
            angular_velocity: Vec3::ZERO,
            curl: [0.0; 5],
            trigger: hand.trigger,
            squeeze: hand.squeeze,
            squeeze_force: 0.0,
            stick: hand.stick,
            trackpad_force: 0.0,
            trackpad: Vec2::ZERO,
            buttons,
        }
    }
}

impl Packet {
    /// What a headset must do so that an application sees this frame: head, eyes, hands.
    ///
    /// # Errors
    /// [`RemoteError::TwoPoses`] where a tracked hand's grip and aim differ.
    pub fn from_frame(frame: &Frame) -> Result<Self, RemoteError> {
        for (hand, side) in frame.hands.iter().zip(["left", "right"]) {
            if hand.tracked && hand.aim != hand.grip {
                return Err(RemoteError::TwoPoses { side });
            }
        }
        let head_from_stage = frame.head.inverse();
        let eyes = frame.views.map(|view| View {
            pose: head_from_stage * view.pose,
            ..view
        });
        Ok(Self {
            eyes: Some(eyes),
            head: frame.head,
            controllers: [
                Controller::from_hand(&frame.hands[0]),
                Controller::from_hand(&frame.hands[1]),
            ],
        })
    }

    /// As the driver reads it.
    #[must_use]
    pub fn to_bytes(&self) -> [u8; PACKET_BYTES] {
        let mut bytes = [0; PACKET_BYTES];
        let mut out = Cursor {
            bytes: &mut bytes[..],
            at: 0,
        };
        out.put(&HEADER);
        let at_rest = View {
            pose: Pose::IDENTITY,
            fov: Fov::SQUARE,
        };
        for eye in self.eyes.unwrap_or([at_rest; 2]) {
            out.floats(&[eye.fov.left, eye.fov.right, eye.fov.up, eye.fov.down]);
            out.pose(eye.pose);
            out.put(&[0; 4]);
        }
        out.pose(self.head);
        out.put(&[u8::from(self.eyes.is_some()), 0, 0, 0]);
        for controller in &self.controllers {
            out.pose(controller.pose);
            out.floats(&controller.linear_velocity.to_array());
            out.floats(&controller.angular_velocity.to_array());
            out.floats(&controller.curl);
            out.floats(&[
                controller.trigger,
                controller.squeeze,
                controller.squeeze_force,
            ]);
            out.floats(&controller.stick.to_array());
            out.floats(&[controller.trackpad_force]);
            out.floats(&controller.trackpad.to_array());
            out.put(&controller.buttons.map(u8::from));
            out.put(&[0; 3]);
        }
        bytes
    }

    /// Reads what the driver sends.
    ///
    /// # Errors
    /// [`RemoteError::Protocol`] where the header is another.
    pub fn from_bytes(bytes: &[u8; PACKET_BYTES]) -> Result<Self, RemoteError> {
        let (header, rest) = bytes.split_at(HEADER.len());
        if header != HEADER && header != NO_HEADER {
            return Err(RemoteError::Protocol {
                found: header.escape_ascii().to_string(),
            });
        }
        let mut input = Reader { bytes: rest };
        let mut eyes = [View {
            pose: Pose::IDENTITY,
            fov: Fov::SQUARE,
        }; 2];
        for eye in &mut eyes {
            let [left, right, up, down] = input.floats();
            eye.fov = Fov {
                left,
                right,
                up,
                down,
            };
            eye.pose = input.pose();
            input.take::<4>();
        }
        let head = input.pose();
        let [valid, ..] = input.take::<4>();
        let mut controller = || {
            let pose = input.pose();
            let linear_velocity = Vec3::from_array(input.floats());
            let angular_velocity = Vec3::from_array(input.floats());
            let curl = input.floats();
            let [trigger, squeeze, squeeze_force] = input.floats();
            let stick = Vec2::from_array(input.floats());
            let [trackpad_force] = input.floats();
            let trackpad = Vec2::from_array(input.floats());
            let buttons = input.take::<13>().map(|byte| byte != 0);
            input.take::<3>();
            Controller {
                pose,
                linear_velocity,
                angular_velocity,
                curl,
                trigger,
                squeeze,
                squeeze_force,
                stick,
                trackpad_force,
                trackpad,
                buttons,
            }
        };
        let controllers = [controller(), controller()];
        Ok(Self {
            eyes: (valid != 0).then_some(eyes),
            head,
            controllers,
        })
    }
}

/// Writes one after another into a packet, whose size is fixed.
struct Cursor<'a> {
    bytes: &'a mut [u8],
    at: usize,
}

impl Cursor<'_> {
    fn put(&mut self, part: &[u8]) {
        self.bytes[self.at..self.at + part.len()].copy_from_slice(part);
        self.at += part.len();
    }

    fn floats(&mut self, values: &[f32]) {
        for value in values {
            self.put(&value.to_le_bytes());
        }
    }

    fn pose(&mut self, pose: Pose) {
        self.floats(&pose.orientation.to_array());
        self.floats(&pose.position.to_array());
    }
}

/// Reads one after another; zeros beyond the end, which a whole packet never has.
struct Reader<'a> {
    bytes: &'a [u8],
}

impl Reader<'_> {
    fn take<const COUNT: usize>(&mut self) -> [u8; COUNT] {
        match self.bytes.split_first_chunk::<COUNT>() {
            Some((part, rest)) => {
                self.bytes = rest;
                *part
            }
            None => [0; COUNT],
        }
    }

    fn floats<const COUNT: usize>(&mut self) -> [f32; COUNT] {
        [(); COUNT].map(|()| f32::from_le_bytes(self.take()))
    }

    fn pose(&mut self) -> Pose {
        let orientation = Quat::from_array(self.floats());
        Pose {
            orientation,
            position: Vec3::from_array(self.floats()),
        }
    }
}

/// A connection to the remote driver.
#[derive(Debug)]
pub struct Remote {
    stream: TcpStream,
    at_rest: Packet,
}

impl Remote {
    /// Connects to the driver on this machine's `port` and reads its greeting.
    ///
    /// # Errors
    /// [`RemoteError`] when nobody answers in time or it speaks another protocol.
    pub fn connect(port: u16) -> Result<Self, RemoteError> {
        let began = Instant::now();
        // The driver begins to listen on a thread of its own, at about the time the service is ready.
        let mut stream = loop {
            match TcpStream::connect(("127.0.0.1", port)) {
                Ok(stream) => break stream,
                Err(error) if began.elapsed() >= PATIENCE => return Err(error.into()),
                Err(_) => thread::sleep(TRY_AGAIN),
            }
        };
        stream.set_nodelay(true)?;
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_write_timeout(Some(PATIENCE))?;
        let mut bytes = [0; PACKET_BYTES];
        stream.read_exact(&mut bytes)?;
        let at_rest = Packet::from_bytes(&bytes)?;
        // Without a header only the values tell whether the layout is the one we know: the controllers rest before
        // the person, with a real orientation.
        if !at_rest
            .controllers
            .iter()
            .all(|controller| controller.pose.is_sane())
        {
            return Err(RemoteError::Protocol {
                found: String::from("another layout"),
            });
        }
        stream.read_exact(&mut bytes)?;
        Packet::from_bytes(&bytes)?;
        Ok(Self { stream, at_rest })
    }

    /// The state that the driver begins with.
    #[must_use]
    pub fn at_rest(&self) -> &Packet {
        &self.at_rest
    }

    /// Makes this the state of headset and controllers.
    ///
    /// # Errors
    /// [`RemoteError::Io`] when the service is gone.
    pub fn send(&mut self, packet: &Packet) -> Result<(), RemoteError> {
        Ok(self.stream.write_all(&packet.to_bytes())?)
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "tests say what they expect by their names"
    )]

    use std::net::TcpListener;

    use super::*;

    fn float(bytes: &[u8], at: usize) -> f32 {
        f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
    }

    /// A frame in which every number differs from every other.
    fn frame() -> Frame {
        let pose = |seed: f32| Pose {
            orientation: Quat::from_rotation_y(seed) * Quat::from_rotation_x(0.3),
            position: Vec3::new(seed, seed + 0.01, seed + 0.02),
        };
        let hand = |seed: f32| Hand {
            tracked: true,
            aim: pose(seed),
            grip: pose(seed),
            trigger: 0.125 * seed,
            squeeze: 0.25 * seed,
            stick: Vec2::new(-0.5 * seed, 0.75 * seed),
            lower: false,
            upper: false,
        };
        let mut frame = Frame {
            head: pose(0.6),
            hands: [hand(0.5), hand(1.0)],
            ..Frame::start()
        };
        frame.hands[0].lower = true;
        frame.hands[1].upper = true;
        frame.views = Frame::eyes().map(|eye| View {
            pose: frame.head * eye.pose,
            ..eye
        });
        frame
    }

    #[test]
    fn each_value_lies_where_the_driver_reads_it() {
        let frame = frame();
        let bytes = Packet::from_frame(&frame).unwrap().to_bytes();
        assert_eq!(&bytes[..8], b"mndrmt3\0");
        assert_eq!(float(&bytes, 8), frame.views[0].fov.left);
        assert_eq!(float(&bytes, 8 + 48 + 4), frame.views[1].fov.right);
        assert!(
            (float(&bytes, 8 + 16 + 16) + 0.032).abs() < 1e-6,
            "the left eye is to the left of the head"
        );
        assert!((float(&bytes, 56 + 16 + 16) - 0.032).abs() < 1e-6);
        assert_eq!(float(&bytes, 104 + 12), frame.head.orientation.w);
        assert_eq!(float(&bytes, 120 + 4), frame.head.position.y);
        assert_eq!(bytes[132], 1);
        for (hand, start) in frame.hands.iter().zip([136, 256]) {
            assert_eq!(float(&bytes, start), hand.aim.orientation.x);
            assert_eq!(float(&bytes, start + 16), hand.aim.position.x);
            assert_eq!(float(&bytes, start + 72), hand.trigger);
            assert_eq!(float(&bytes, start + 76), hand.squeeze);
            assert_eq!(float(&bytes, start + 84), hand.stick.x);
            assert_eq!(float(&bytes, start + 88), hand.stick.y);
            assert_eq!(bytes[start + 105], 1, "active");
            assert_eq!(bytes[start + 108], u8::from(hand.lower), "A");
            assert_eq!(bytes[start + 110], u8::from(hand.upper), "B");
        }
    }

    #[test]
    fn a_packet_reads_back_as_it_was() {
        let mut packet = Packet::from_frame(&frame()).unwrap();
        for (at, controller) in packet.controllers.iter_mut().enumerate() {
            controller.linear_velocity = Vec3::new(1.0, 2.0, 3.0);
            controller.angular_velocity = Vec3::new(4.0, 5.0, 6.0);
            controller.curl = [0.1, 0.2, 0.3, 0.4, 0.5];
            controller.squeeze_force = 0.7;
            controller.trackpad_force = 0.8;
            controller.trackpad = Vec2::new(-0.3, 0.9);
            controller.buttons = std::array::from_fn(|place| (place + at) % 3 == 0);
        }
        assert_eq!(Packet::from_bytes(&packet.to_bytes()).unwrap(), packet);
        packet.eyes = None;
        assert_eq!(Packet::from_bytes(&packet.to_bytes()).unwrap(), packet);
    }

    #[test]
    fn the_session_that_comes_with_ramus_can_be_sent() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("../../assets/sessions/first-tree.session");
        for frame in ramus_xr::session::read_file(&path).unwrap() {
            Packet::from_frame(&frame).unwrap();
        }
    }

    #[test]
    fn what_a_packet_cannot_say_is_refused() {
        let mut frame = frame();
        frame.hands[1].grip.position.x += 0.1;
        assert!(
            Packet::from_frame(&frame)
                .unwrap_err()
                .to_string()
                .contains("right hand")
        );
        frame.hands[1].tracked = false;
        assert!(
            Packet::from_frame(&frame).is_ok(),
            "a hand that is not tracked has no pose"
        );
    }

    #[test]
    fn the_greeting_is_read_and_another_protocol_refused() {
        let greet = |header: [u8; 8]| {
            let listener = TcpListener::bind(("127.0.0.1", 0)).unwrap();
            let port = listener.local_addr().unwrap().port();
            let service = thread::spawn(move || {
                let (mut stream, _) = listener.accept().unwrap();
                let mut packet = Packet::from_frame(&frame()).unwrap().to_bytes();
                packet[..8].copy_from_slice(&header);
                stream.write_all(&packet).unwrap();
                stream.write_all(&packet).unwrap();
                let mut received = Vec::new();
                let _ = stream.read_to_end(&mut received);
                received
            });
            let remote = Remote::connect(port).map(|mut remote| {
                let packet = *remote.at_rest();
                remote.send(&packet).unwrap();
            });
            (remote, service.join().unwrap())
        };
        let (remote, received) = greet(HEADER);
        assert!(remote.is_ok());
        assert_eq!(received, Packet::from_frame(&frame()).unwrap().to_bytes());
        let (remote, received) = greet(*b"mndrmt4\0");
        assert!(remote.unwrap_err().to_string().contains("mndrmt4"));
        assert!(received.is_empty());
    }
}
