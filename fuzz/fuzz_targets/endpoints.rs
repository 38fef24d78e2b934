//! The readers of endpoints: no bytes may stop them, and what they read is written and read again the same.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ramus::mesh::endpoints::Endpoints;

fuzz_target!(|bytes: &[u8]| {
    for list in [Endpoints::from_csv(bytes), Endpoints::from_json(bytes)] {
        let Ok(list) = list else { continue };
        let all = |list: &Endpoints| list.iter().map(|(_, one)| one.clone()).collect::<Vec<_>>();
        let json = Endpoints::from_json(list.to_json().as_bytes()).expect("what was written can be read");
        assert_eq!(all(&json), all(&list), "nothing is lost");
        let csv = Endpoints::from_csv(list.to_csv().as_bytes()).expect("what was written can be read");
        assert_eq!(csv.len(), list.len(), "no endpoint is lost");
    }
});
