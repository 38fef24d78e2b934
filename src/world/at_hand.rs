//! What a hand is at and what it holds.

use glam::{Vec2, Vec3};

use super::handles::HandleId;
use super::panels::{OnPanel, PanelId};
use crate::mesh::pick::Hit;
use crate::sketch::NodeRef;

/// What a hand is at.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Hover {
    #[default]
    Nothing,
    /// A node, so many metres along the ray (0: touched).
    Node { at: NodeRef, along: f32 },
    /// The platform's rim, so many metres along the ray (0: touched).
    Rim { along: f32 },
    /// A scanned model or its pedestal, so many metres along the ray (0: touched), and the place of its surface, from the mesh's origin.
    Model {
        at: usize,
        along: f32,
        spot: Option<Hit>,
    },
    /// An endpoint of a scanned model, so many metres along the ray (0: touched).
    End { model: usize, at: usize, along: f32 },
    /// A branch of a model's centerlines, so many metres along the ray (0: touched).
    Branch {
        model: usize,
        branch: usize,
        along: f32,
    },
    /// A panel.
    Panel(OnPanel),
    /// The lever, the wheel or the stump, so many metres along the ray (0: touched).
    Handle { id: HandleId, along: f32 },
    /// The ground, or a planted tree on it, for the tools that plant and uproot.
    Ground(OnGround),
}

/// Where on the ground a hand is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OnGround {
    /// Metres to the right of the stage's middle and towards the person: x and z.
    pub(super) at: Vec2,
    /// Metres along the ray (0: touched).
    pub(super) along: f32,
    /// The planted tree that is meant, by its number, if one is.
    pub(super) plant: Option<usize>,
    /// Whether the hand is at the ground in miniature, on the platform.
    pub(super) in_miniature: bool,
}

/// What a hand holds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Hold {
    #[default]
    Nothing,
    Node(NodeRef),
    Platform,
    /// A scanned model, by its number.
    Model(usize),
    /// An endpoint of one.
    End {
        model: usize,
        at: usize,
    },
    /// A panel, pressed by the trigger or by the tip.
    Panel {
        id: PanelId,
        poked: bool,
    },
    /// A panel that is carried, with its centre in the hand's frame, metres.
    Carried {
        id: PanelId,
        offset: Vec3,
    },
    /// The lever or the wheel.
    Handle(HandleId),
    /// A free-hand stroke in progress.
    Stroke,
    /// Trees that are being planted.
    Planting,
    /// Trees that are being uprooted.
    Uprooting,
}

/// What a ray meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Met {
    /// Where, metres on the stage: a node's centre, else the point on the ray.
    pub place: Vec3,
    /// A hand that points there uses it with the trigger; else the trigger draws as if nothing was there.
    pub takes_trigger: bool,
    /// The thumbstick up and down scrolls it.
    pub scrolls: bool,
}

impl Hover {
    /// Metres along the ray; none where there is nothing.
    pub(super) fn along(self) -> Option<f32> {
        match self {
            Self::Nothing => None,
            Self::Node { along, .. }
            | Self::Rim { along }
            | Self::Model { along, .. }
            | Self::End { along, .. }
            | Self::Branch { along, .. }
            | Self::Handle { along, .. } => Some(along),
            Self::Panel(on) => Some(on.along),
            Self::Ground(on) => Some(on.along),
        }
    }
}
