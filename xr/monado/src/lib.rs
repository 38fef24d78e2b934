//! The real-runtime test stage: Monado, an OpenXR runtime that nobody here wrote, started for a test
//! with its null compositor and its remote driver, whose headset and controllers a test moves packet by packet.
//!
//! - [`remote`] moves its headset and controllers, and [`feed`] plays a whole session through it.
//! - [`stage`] brings a test to where Monado is: the test runs again inside `enter.sh`.
//! - [`rival`] is another program that takes the focus.
//! - [`service`] starts, ends and kills the runtime and says how a program finds it.
//! - [`teller`] is a layer that makes the runtime end a session which the program did not end.
//! - [`verdict`] reads outputs for what the runtime and the validation layers found wrong.
//!
//! Debian 12 has no Monado, and Debian 13's needs Debian 13's C library; `make-root.sh` therefore makes a
//! Debian 13 root once, and `enter.sh` runs a command in it, in namespaces of its own. Building Monado from
//! source was the other way: slower, and a second build system to look after.

#![deny(unsafe_code)]

pub mod feed;
pub mod remote;
pub mod rival;
pub mod service;
pub mod stage;
pub mod teller;
pub mod verdict;
