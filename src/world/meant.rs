//! What a hand or a pointer means, of all that stands on the stage: the nearest along its ray, touch before all.

use glam::Vec3;

use super::hover::{self, Pointer};
use super::settings::DrawTool;
use super::stage::rim;
use super::tools::{Hold, Hover, Met, Tools};
use crate::sketch::NodeRef;

impl Tools {
    /// What a ray from `origin` meets that a hand could use, and where.
    pub(super) fn met(&self, origin: Vec3, direction: Vec3) -> Option<Met> {
        let found = self.meant(
            None,
            &Pointer {
                origin,
                direction,
                tip: origin,
                hand: origin,
            },
        );
        Some(Met {
            place: match found {
                Hover::Node { at, .. } => self.miniature.position(at)?,
                _ => origin + direction * found.along()?,
            },
            takes_trigger: match found {
                Hover::Rim { .. } => false,
                Hover::Model { spot, .. } => spot.is_some() && self.is_marking(),
                Hover::End { .. } => self.params.settings.tool != DrawTool::Draw,
                _ => true,
            },
            scrolls: matches!(found, Hover::Panel(_)),
        })
    }

    /// What something that points means; `hand`: which hand it is, if it is one.
    pub(super) fn meant(&self, hand: Option<usize>, pointer: &Pointer) -> Hover {
        let params = &self.params.hover;
        let taken = |at: NodeRef| self.hands.iter().any(|other| other.hold == Hold::Node(at));
        let free = self.miniature.nodes.iter().filter(|node| !taken(node.at));
        let hit = hover::ball(
            free.clone().map(|node| node.position),
            self.stage.node_radius,
            pointer,
            params,
        );
        let node = hit.and_then(|hit| free.clone().nth(hit.index).map(|node| (node.at, hit)));
        let rim = hover::ring(&rim(&self.shown.platform, &self.stage), pointer, params);
        let found = self.nearest(node, rim);
        let mut along = found.along();
        let mut nearest = found;
        if let Some((id, at)) = self.handle_at(pointer)
            && along.is_none_or(|along| at <= along)
        {
            nearest = Hover::Handle { id, along: at };
            along = Some(at);
        }
        if let Some((at, met)) = self.pedestal_at(pointer)
            && along.is_none_or(|along| met <= along)
        {
            nearest = Hover::Model {
                at,
                along: met,
                spot: None,
            };
            along = Some(met);
        }
        if let Some((model, at, met)) = self.end_at(pointer)
            && along.is_none_or(|along| met <= along)
        {
            nearest = Hover::End {
                model,
                at,
                along: met,
            };
            along = Some(met);
        }
        if let Some((model, branch, met)) = self.branch_at(pointer)
            && along.is_none_or(|along| met <= along)
        {
            nearest = Hover::Branch {
                model,
                branch,
                along: met,
            };
            along = Some(met);
        }
        if let Some(on) = self.ground_meant(pointer, along) {
            nearest = Hover::Ground(on);
            along = Some(on.along);
        }
        match self.panels.find(hand, pointer) {
            Some(on) if along.is_none_or(|along| on.along <= along) => return Hover::Panel(on),
            _ => {}
        }
        // What a person stands in must not take the place of what is beyond it, unless they mark places on it.
        let marks = self.is_marking() && !matches!(nearest, Hover::End { .. });
        let furniture = matches!(nearest, Hover::Rim { .. } | Hover::Model { .. });
        let nearer = |met: f32, along: f32| met < along || furniture && met <= along;
        let wanted = |met: f32| marks && along.is_none_or(|along| nearer(met, along));
        match self.model_at(pointer) {
            Some((at, along, spot))
                if nearest == Hover::Nothing || spot.is_some() && wanted(along) =>
            {
                Hover::Model { at, along, spot }
            }
            _ => nearest,
        }
    }

    /// The node or the rim, whichever is meant.
    fn nearest(&self, node: Option<(NodeRef, hover::Hit)>, rim: Option<f32>) -> Hover {
        match (node, rim) {
            (Some((at, hit)), rim) if hit.touched || rim.is_none_or(|rim| hit.along <= rim) => {
                Hover::Node {
                    at,
                    along: hit.along,
                }
            }
            (_, Some(along)) => Hover::Rim { along },
            (Some((at, hit)), None) => Hover::Node {
                at,
                along: hit.along,
            },
            (None, None) => Hover::Nothing,
        }
    }
}
