//! What a runtime and the validation layers found wrong, read from their output.

/// The lines of `output` that no run may print: an error that the runtime returned (`XR_ERROR…` at the
/// beginning of a line), the OpenXR core-validation layer's `VALID_ERROR`, or a broken Vulkan rule
/// (`VUID-…`, `UNASSIGNED-…`, `SYNC-HAZARD…`).
/// The layer names a rule in its remarks on its own beginning and end too; those are no complaints.
pub fn complaints(output: &str) -> Vec<&str> {
    output
        .lines()
        .filter(|line| {
            line.starts_with("XR_ERROR") || line.contains("VALID_ERROR") || breaks_rule(line)
        })
        .collect()
}

fn breaks_rule(line: &str) -> bool {
    let named = ["VUID-", "UNASSIGNED-", "SYNC-HAZARD"]
        .iter()
        .any(|rule| line.contains(rule));
    named && !line.contains("VALID_DEBUG") && !line.contains("VALID_INFO")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn complaints_are_found_and_nothing_else() {
        let cases: &[(&str, usize)] = &[
            ("", 0),
            (" INFO [client_loop] Client 1 connected", 0),
            ("XR_ERROR_CALL_ORDER_INVALID: frame not begun", 1),
            ("the spec names XR_ERROR_RUNTIME_FAILURE", 0),
            (
                "[VALID_ERROR | xrLocateSpace | VUID-xrLocateSpace-location-parameter]: x",
                1,
            ),
            (
                "a\nValidation Error: [ VUID-vkCmdDraw-None-02697 ] b\nVALID_ERROR\nc",
                2,
            ),
        ];
        for (output, count) in cases {
            assert_eq!(complaints(output).len(), *count, "{output}");
        }
    }
}
