//! The stage itself: the real runtime starts, answers a client that is not ours, ends and dies as told.
#![allow(
    clippy::unwrap_used,
    clippy::missing_assert_message,
    reason = "a test that stops says enough by stopping"
)]

use std::{
    io::{Read as _, Write as _},
    net::TcpStream,
    process::Stdio,
    thread,
    time::{Duration, Instant},
};

use ramus_monado::{
    rival::Rival,
    service::{Service, ServiceError, ServiceParams},
    stage::{self, StageError},
};

#[test]
fn the_runtime_answers_and_ends_in_good_order() {
    stage::run("the_runtime_answers_and_ends_in_good_order", || {
        let began = Instant::now();
        let service = Service::start(ServiceParams::default()).unwrap();
        println!("ready after {} ms", began.elapsed().as_millis());
        let output = service.command("openxr_runtime_list").output().unwrap();
        assert!(output.status.success());
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(text.contains("Monado: Remote HMD"), "{text}");
        assert!(text.contains("XR_KHR_vulkan_enable2"), "{text}");
        let log = service.stop().unwrap();
        assert!(log.contains("Client 1 connected"), "{log}");
    })
    .unwrap();
}

#[test]
fn the_remote_driver_greets_on_its_port() {
    stage::run("the_remote_driver_greets_on_its_port", || {
        let service = Service::start(ServiceParams::default()).unwrap();
        let mut stream = TcpStream::connect(("127.0.0.1", service.port())).unwrap();
        stream
            .set_read_timeout(Some(Duration::from_secs(10)))
            .unwrap();
        // The service first sends two packets of 376 bytes of its own.
        let mut greeting = [0_u8; 2 * 376];
        stream.read_exact(&mut greeting).unwrap();
        assert!(greeting.iter().any(|byte| *byte != 0));
        drop(stream);
        service.stop().unwrap();
    })
    .unwrap();
}

/// A client that is not ours draws with lavapipe through the runtime as far as the focused state.
#[test]
fn a_foreign_client_gets_the_focus_and_outlives_nothing() {
    stage::run(
        "a_foreign_client_gets_the_focus_and_outlives_nothing",
        || {
            let mut service = Service::start(ServiceParams::default()).unwrap();
            let mut client = Rival::command(&service)
                .stdout(Stdio::piped())
                .spawn()
                .unwrap();
            // A line on its input ends it; the guard does so if it never gets the focus.
            let mut input = client.stdin.take().unwrap();
            let guard = thread::spawn(move || {
                thread::sleep(Duration::from_secs(4));
                let _ = input.write_all(b"\n");
            });
            let output = client.wait_with_output().unwrap();
            guard.join().unwrap();
            let text = String::from_utf8_lossy(&output.stdout);
            assert!(text.contains("XR_SESSION_STATE_FOCUSED"), "{text}");
            service.kill().unwrap();
            let log = service.stop().unwrap();
            assert!(log.contains("HelloXR"), "{log}");
        },
    )
    .unwrap();
}

#[test]
fn a_runtime_that_cannot_start_says_why() {
    stage::run("a_runtime_that_cannot_start_says_why", || {
        let params = ServiceParams {
            // No Vulkan driver is left to it.
            environment: vec![("VK_DRIVER_FILES".to_owned(), "/nowhere.json".to_owned())],
            ..ServiceParams::default()
        };
        match Service::start(params) {
            Err(ServiceError::Ended { log, .. }) => assert!(log.contains("ERROR"), "{log}"),
            Err(other) => panic!("{other}"),
            Ok(service) => panic!("it started: {}", service.log()),
        }
    })
    .unwrap();
}

#[test]
fn a_wrong_name_is_noticed() {
    match stage::run("there_is_no_such_test", || {}) {
        // The last where there is no runtime: skipped.
        Err(StageError::NoTest { .. } | StageError::NoRuntime) | Ok(_) => {}
        Err(other) => panic!("{other}"),
    }
}

#[test]
fn a_failure_inside_is_a_failure_outside() {
    let name = "a_failure_inside_is_a_failure_outside";
    let verdict = stage::run(name, || panic!("as it should"));
    match verdict {
        Err(StageError::Failed { output, .. }) => {
            assert!(output.contains("as it should"), "{output}")
        }
        Err(StageError::NoRuntime) | Ok(_) => {}
        Err(other) => panic!("{other}"),
    }
}
