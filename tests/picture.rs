//! Pictures drawn without a headset, measured: what is where, in which colour, at which depth, for which eye.
//!
//! Everything runs with the validation layer and its synchronisation checks; any message fails the test. Numbers first, then small
//! reference images (`UPDATE_SNAPSHOTS=1` rewrites them; look at them before you commit them).
#![allow(
    clippy::unwrap_used,
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    clippy::cast_sign_loss,
    clippy::missing_assert_message,
    reason = "tests"
)]

mod picture {
    mod board;
    mod crowns;
    mod eyes;
    mod faults;
    mod hidden;
    mod levels;
    mod lights;
    mod models;
    mod older;
    mod organs;
    mod parts;
    mod runs;
    mod snapshots;
    mod support;
    mod textured;
    mod trees;
    mod uploads;
    mod wind;
    mod wood;
}
