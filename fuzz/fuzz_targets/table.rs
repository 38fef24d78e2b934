//! Tables of models: no bytes may stop their reader, and of whatever is read a tree can be asked for.
#![no_main]

use std::sync::atomic::AtomicBool;

use libfuzzer_sys::fuzz_target;
use ramus::abstraction::{FitParams, Table, fit, rules};

fuzz_target!(|bytes: &[u8]| {
    let Some(table) = str::from_utf8(bytes).ok().and_then(|text| Table::read(text).ok()) else {
        return;
    };
    // Lengths beyond the limits are refused by name.
    let _ = rules::params(&table, 1).check();
    if table.counts.centerlines.is_some_and(|tips| tips < 100) {
        let params = FitParams {
            candidates: 20,
            ..FitParams::default()
        };
        let _ = fit(&table, &params, &AtomicBool::new(false), &mut |_, _, _| {});
    }
});
