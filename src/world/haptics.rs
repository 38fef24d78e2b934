//! What hands feel: a short vibration for each thing that happens to them.

/// A vibration of one controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Haptic {
    /// 0 left, 1 right.
    pub hand: usize,
    /// How long, seconds.
    pub seconds: f32,
    /// How strong, 0 to 1.
    pub amplitude: f32,
}

/// Length in seconds and strength (0 to 1) of each vibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HapticParams {
    /// A node comes under the hand.
    pub hover: [f32; 2],
    /// Something was chosen, gripped or dropped.
    pub choose: [f32; 2],
    /// A segment was made.
    pub create: [f32; 2],
    /// Something was deleted.
    pub delete: [f32; 2],
    /// The tree grew or stepped back, an edit was undone or redone.
    pub grow: [f32; 2],
    /// Nothing was done, because it cannot be.
    pub limit: [f32; 2],
}

impl Default for HapticParams {
    fn default() -> Self {
        Self {
            hover: [0.015, 0.25],
            choose: [0.02, 0.5],
            create: [0.05, 0.6],
            delete: [0.08, 0.8],
            grow: [0.04, 0.5],
            limit: [0.12, 1.0],
        }
    }
}
