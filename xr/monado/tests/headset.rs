//! Our OpenXR headset against the real runtime: lifecycle, input, loss. Nothing is drawn here; the pictures are the
//! whole program's tests.
#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that stops says enough by stopping"
)]

use ash::vk;
use glam::{Quat, Vec2, Vec3};
use ramus_monado::{
    feed::{Fed, arrived},
    remote::{Packet, Remote},
    rival::Rival,
    service::{Service, ServiceParams},
    stage, verdict,
};
use ramus_xr::{
    Frame, Hand, Headset, HeadsetError, Pose, Pulse, Tick, View,
    openxr::{OpenXrHeadset, StartParams, connect},
    quad::QuadPlace,
    vulkan::VulkanHandles,
};

/// Runs a test where the runtime is, and fails it for whatever the runtime or a layer complained about.
fn staged(test: &str, body: impl FnOnce()) {
    let output = stage::run(test, body).unwrap();
    assert_eq!(
        verdict::complaints(&output),
        [""; 0],
        "the runtime complained"
    );
}

/// Most rounds until something must have happened: half a minute on the null compositor.
const PATIENCE: usize = 600;

/// Our headset and the Vulkan that it runs on.
struct Device {
    headset: Option<OpenXrHeadset>,
    device: ash::Device,
    instance: ash::Instance,
    _entry: ash::Entry,
}

impl Device {
    fn new(service: &Service) -> Self {
        for (name, value) in service.environment() {
            // SAFETY: inside the stage this test is alone in its process.
            unsafe { std::env::set_var(name, value) };
        }
        let system = connect(1).unwrap();
        println!("{}", system.describe());
        let (lowest, _) = system.vulkan_versions().unwrap();
        // SAFETY: the calls are made in the order and with the handles that their documentation asks for.
        unsafe {
            let entry = ash::Entry::load().unwrap();
            let find = entry.static_fn().get_instance_proc_addr;
            let application =
                vk::ApplicationInfo::default().api_version(lowest.max(vk::API_VERSION_1_1));
            let info = vk::InstanceCreateInfo::default().application_info(&application);
            let instance = system.create_instance(find, &info).unwrap();
            let instance = ash::Instance::load(entry.static_fn(), instance);
            let physical_device = system.graphics_device(instance.handle()).unwrap();
            let families = instance.get_physical_device_queue_family_properties(physical_device);
            let queue_family = (0u32..)
                .zip(&families)
                .find(|(_, family)| family.queue_flags.contains(vk::QueueFlags::GRAPHICS))
                .unwrap()
                .0;
            let queues = [vk::DeviceQueueCreateInfo::default()
                .queue_family_index(queue_family)
                .queue_priorities(&[1.0])];
            let info = vk::DeviceCreateInfo::default().queue_create_infos(&queues);
            let device = system.create_device(find, physical_device, &info).unwrap();
            let handles = VulkanHandles {
                instance: instance.handle(),
                physical_device,
                device,
                queue_family,
                queue_index: 0,
            };
            let device = ash::Device::load(instance.fp_v1_0(), device);
            let headset = system.start(handles, StartParams::new(0.05)).unwrap();
            Self {
                headset: Some(headset),
                device,
                instance,
                _entry: entry,
            }
        }
    }

    fn headset(&mut self) -> &mut OpenXrHeadset {
        self.headset.as_mut().unwrap()
    }

    /// One round; `None` where there was no frame.
    fn round(&mut self) -> Result<Option<Frame>, HeadsetError> {
        let headset = self.headset();
        match headset.wait()? {
            Tick::Frame(frame) => {
                let acquired = headset.begin()?;
                assert_eq!(acquired.is_some(), frame.should_render);
                headset.views()?;
                headset.end(acquired.is_some())?;
                Ok(Some(frame))
            }
            Tick::Idle => Ok(None),
            Tick::Exit => panic!("the session ended by itself"),
        }
    }

    /// Goes on until the session is focused and both hands are there.
    fn focus(&mut self) -> Frame {
        let mut rounds = (0..PATIENCE).filter_map(|_| self.round().unwrap());
        rounds
            .find(|frame| frame.focused && frame.hands.iter().all(|hand| hand.tracked))
            .unwrap()
    }

    fn exit(&mut self) {
        self.headset().request_exit();
        for _ in 0..PATIENCE {
            match self.headset().wait().unwrap() {
                Tick::Frame(_) => {
                    self.headset().begin().unwrap();
                    self.headset().end(false).unwrap();
                }
                Tick::Idle => {}
                Tick::Exit => return,
            }
        }
        panic!("the session never ends");
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: the headset, the only user of both, goes first; nothing was submitted by us.
        unsafe {
            let _ = self.device.device_wait_idle();
            self.headset = None;
            self.device.destroy_device(None);
            self.instance.destroy_instance(None);
        }
    }
}

/// A frame of a session: both hands move and press.
fn recorded(step: u8) -> Frame {
    let at = f32::from(step);
    let pose = |side: f32| Pose {
        orientation: Quat::from_euler(glam::EulerRot::YXZ, 0.1 * at, -0.2 + 0.05 * at, 0.3 * side),
        position: Vec3::new(0.2 * side + 0.013 * at, 1.1 + 0.017 * at, -0.3 - 0.011 * at),
    };
    let hand = |side: f32| Hand {
        tracked: true,
        aim: pose(side),
        grip: pose(side),
        trigger: 0.1 * at,
        squeeze: 1.0 - 0.1 * at,
        stick: Vec2::new(0.07 * at * side, -0.09 * at),
        lower: step.is_multiple_of(2),
        upper: step.is_multiple_of(3),
    };
    let head = Pose {
        orientation: Quat::from_rotation_y(0.02 * at),
        position: Vec3::new(0.01 * at, 1.55 + 0.003 * at, 0.2),
    };
    Frame {
        head,
        hands: [hand(-1.0), hand(1.0)],
        views: Frame::eyes().map(|eye| View {
            pose: head * eye.pose,
            ..eye
        }),
        ..Frame::start()
    }
}

#[test]
fn what_hands_and_head_do_arrives_exactly() {
    staged("what_hands_and_head_do_arrives_exactly", || {
        let service = Service::start(ServiceParams::default()).unwrap();
        let mut remote = Remote::connect(service.port()).unwrap();
        remote
            .send(&Packet::from_frame(&recorded(0)).unwrap())
            .unwrap();
        let mut device = Device::new(&service);
        let chain = device.headset().swapchain().unwrap();
        println!(
            "{:?} {:?} {:?}",
            chain.color_format(),
            chain.depth_format(),
            chain.extent()
        );
        assert!(!chain.color().is_empty() && !chain.depth().is_empty());
        device.focus();
        let mut last = 0.0;
        for step in 1..=10 {
            let sent = recorded(step);
            remote.send(&Packet::from_frame(&sent).unwrap()).unwrap();
            // The packet crosses a socket and a thread: it is there a round or two later.
            let seen = (0..10)
                .filter_map(|_| device.round().unwrap())
                .find(|frame| arrived(frame, &sent))
                .unwrap_or_else(|| {
                    panic!(
                        "step {step} never arrived: {sent:?}\n{:?}",
                        device.round().unwrap()
                    )
                });
            assert_eq!(seen.head.position, sent.head.position);
            assert!(seen.head.orientation.dot(sent.head.orientation) > 0.999_999);
            for (seen, sent) in seen.views.iter().zip(&sent.views) {
                assert_eq!(seen.fov, sent.fov);
                assert!(
                    seen.pose.position.distance(sent.pose.position) < 1e-5,
                    "{seen:?} {sent:?}"
                );
                assert!(
                    seen.pose.orientation.dot(sent.pose.orientation).abs() > 0.999_99,
                    "{seen:?} {sent:?}"
                );
            }
            assert!(seen.time > last && seen.should_render);
            last = seen.time;
            device.headset().vibrate(Pulse {
                hand: 1,
                duration: 0.01,
                amplitude: 1.0,
            });
        }
        // Tracking is lost on one side.
        let mut lost = recorded(3);
        lost.hands[0] = Hand::ABSENT;
        remote.send(&Packet::from_frame(&lost).unwrap()).unwrap();
        assert!(
            (0..10)
                .filter_map(|_| device.round().unwrap())
                .any(|frame| arrived(&frame, &lost))
        );
        device.exit();
        drop(device);
        service.stop().unwrap();
    });
}

#[test]
fn a_killed_runtime_is_a_loss() {
    stage::run("a_killed_runtime_is_a_loss", || {
        let mut service = Service::start(ServiceParams::default()).unwrap();
        let mut device = Device::new(&service);
        device.focus();
        service.kill().unwrap();
        let error = (0..PATIENCE).find_map(|_| device.round().err()).unwrap();
        println!("{error}");
        assert!(matches!(error, HeadsetError::Lost(_)), "{error}");
        // It stays lost, and nothing panics on the way out.
        assert!(device.round().is_err());
    })
    .unwrap();
}

/// Runs rounds until one is as wanted.
fn until(device: &mut Device, what: &str, wanted: impl Fn(&Frame) -> bool) -> Frame {
    (0..PATIENCE)
        .filter_map(|_| device.round().unwrap())
        .find(wanted)
        .unwrap_or_else(|| panic!("no frame {what}"))
}

#[test]
fn without_the_focus_hands_are_hidden_until_it_comes_back() {
    staged(
        "without_the_focus_hands_are_hidden_until_it_comes_back",
        || {
            let service = Service::start(ServiceParams::default()).unwrap();
            let mut device = Device::new(&service);
            let before = device.focus();
            // Another program comes to the front.
            let rival = Rival::start(&service).unwrap();
            let came = (0..PATIENCE).any(|_| {
                device.round().unwrap();
                Rival::is_there(&service).unwrap()
            });
            assert!(came, "the other program never came");
            Rival::take_focus(&service).unwrap();
            let away = until(&mut device, "without the focus", |frame| !frame.focused);
            assert_eq!(away.hands, [Hand::ABSENT; 2]);
            // The runtime shows the other program: frames go on, and nothing is drawn (`round` checks that).
            until(&mut device, "that is not to be drawn", |frame| {
                !frame.should_render
            });
            // It goes, and the focus is ours again.
            drop(rival);
            let back = until(&mut device, "with the focus again", |frame| frame.focused);
            assert!(back.time > away.time && away.time > before.time);
            assert!(
                until(&mut device, "with hands", |frame| frame
                    .hands
                    .iter()
                    .all(|hand| hand.tracked))
                .focused
            );
            device.exit();
            drop(device);
            service.stop().unwrap();
        },
    );
}

#[test]
fn a_recentring_moves_the_person_and_hides_the_hands_for_a_frame() {
    staged(
        "a_recentring_moves_the_person_and_hides_the_hands_for_a_frame",
        || {
            let service = Service::start(ServiceParams::default()).unwrap();
            let mut remote = Remote::connect(service.port()).unwrap();
            let sent = recorded(5);
            remote.send(&Packet::from_frame(&sent).unwrap()).unwrap();
            let mut device = Device::new(&service);
            device.focus();
            until(&mut device, "as sent", |frame| arrived(frame, &sent));
            println!("{}", service.control(&["-c"]).unwrap());
            let hidden = until(&mut device, "without hands", |frame| {
                frame.hands == [Hand::ABSENT; 2]
            });
            assert!(hidden.focused, "the focus stays");
            let after = until(&mut device, "with hands", |frame| {
                frame.hands.iter().all(|hand| hand.tracked)
            });
            println!("{:?}", after.head);
            // The stage's origin is now below the person; hand and head are to each other as before.
            assert!(
                after.head.position.x.abs() < 1e-4 && after.head.position.z.abs() < 1e-4,
                "{:?}",
                after.head
            );
            let hand = |frame: &Frame| (frame.head.inverse() * frame.hands[1].aim).position;
            assert!(
                hand(&after).distance(hand(&sent)) < 1e-4,
                "{} {}",
                hand(&after),
                hand(&sent)
            );
            device.exit();
            drop(device);
            service.stop().unwrap();
        },
    );
}

#[test]
fn mask_rate_and_quads_are_as_the_runtime_has_them() {
    staged("mask_rate_and_quads_are_as_the_runtime_has_them", || {
        let service = Service::start(ServiceParams::default()).unwrap();
        let mut device = Device::new(&service);
        device.focus();
        let headset = device.headset();
        let hidden = headset.visibility_mask().map(|mask| &mask.hidden);
        println!("hidden: {hidden:?}, {:?} Hz", headset.refresh_rate());
        if let Some(hidden) = hidden {
            // Triangles near what is seen: tangents, not pixels nor angles in degrees.
            let corners = hidden.iter().flatten().flatten();
            assert!(hidden.iter().all(|triangles| triangles.len() % 3 == 0));
            assert!(corners.copied().all(|tangent| tangent.abs() < 20.0));
        }
        // The null compositor has a display of 20 Hz.
        let rate = headset.refresh_rate().unwrap();
        assert!((10.0..=120.0).contains(&rate), "{rate}");
        let extent = vk::Extent2D {
            width: 64,
            height: 32,
        };
        let quad = headset.make_quad(extent).unwrap().unwrap();
        let images = headset.quad_images(quad).unwrap().color().len();
        headset.place_quad(
            quad,
            Some(QuadPlace {
                pose: Pose {
                    position: Vec3::new(0.0, 1.4, -1.0),
                    ..Pose::IDENTITY
                },
                size: [0.8, 0.4],
            }),
        );
        for painted in [false, true, true, false, false] {
            let headset = device.headset();
            assert!(matches!(headset.wait().unwrap(), Tick::Frame(_)));
            let acquired = headset.begin().unwrap();
            if painted {
                assert!(headset.acquire_quad(quad).unwrap().unwrap() < images);
            }
            headset.end(acquired.is_some()).unwrap();
        }
        device.exit();
        drop(device);
        // It fails on whatever the validation layer or the runtime said of the layers.
        service.stop().unwrap();
    });
}

#[test]
fn a_session_goes_through_the_runtime_frame_by_frame() {
    staged("a_session_goes_through_the_runtime_frame_by_frame", || {
        let service = Service::start(ServiceParams::default()).unwrap();
        let remote = Remote::connect(service.port()).unwrap();
        let mut device = Device::new(&service);
        // Frames that stand still, move, lose a hand and lose the focus.
        let mut session: Vec<Frame> = [0, 1, 1, 2, 3, 4, 4, 5, 6].map(recorded).to_vec();
        session[4].hands[0] = Hand::ABSENT;
        session[6].focused = false;
        session[6].hands = [Hand::ABSENT; 2];
        let mut fed = Fed::new(
            device.headset.take().unwrap(),
            remote,
            session.clone().into_iter(),
        );
        let mut seen = Vec::new();
        loop {
            match fed.wait().unwrap() {
                Tick::Frame(frame) => {
                    let acquired = fed.begin().unwrap();
                    fed.views().unwrap();
                    fed.end(acquired.is_some()).unwrap();
                    seen.push(frame);
                }
                Tick::Idle => {}
                Tick::Exit => break,
            }
        }
        assert_eq!(seen.len(), session.len());
        for (seen, sent) in seen.iter().zip(&session) {
            assert!(
                seen.focused == sent.focused && arrived(seen, sent),
                "{seen:?} {sent:?}"
            );
        }
        assert!(seen.windows(2).all(|pair| pair[0].time < pair[1].time));
        drop(fed);
        drop(device);
        service.stop().unwrap();
    });
}
