//! Panels on the stage: where they stand, and where a hand is on them.
//!
//! A panel is a flat sheet that `ui` writes on; the world knows its place and turns hands into pointers on
//! it. A hand means a panel by its ray or by poking it with its tip; the trigger presses. What a hand
//! does on a panel, it does nowhere else: a press is a hold, so nothing is
//! drawn, gripped or undone by it, wherever the hand goes until it lets go. One hand at a time has
//! a panel: the one that presses, else the one that came last. A hand that is not tracked points at nothing.
//!
//! Panels are moved by the grip, and turn to the head while they are carried. They belong to the room, not to
//! the document: moving one is not undone.

use glam::{Affine3A, Mat3, Quat, Vec2, Vec3};

use super::{
    hover::Pointer,
    input::Pose,
    scene::{PlacedPanel, Scene},
    stage::StageParams,
    tools::{Hand, Hold, Hover, Tools, pointer},
};

/// The panels that hands can point at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum PanelId {
    /// The bench: everything that can be set.
    Bench,
    /// The few things that are wanted often, on the back of a hand that is looked at.
    Wrist,
    /// The keyboard, where there is something to type.
    Keyboard,
    /// One line beside what a hand is at; nobody points at it.
    Label,
    /// The tutorial.
    Lesson,
    /// What a participant of a study is asked.
    Study,
}

impl PanelId {
    /// All of them, in the order of their slots.
    pub const ALL: [Self; 6] = [
        Self::Bench,
        Self::Wrist,
        Self::Keyboard,
        Self::Label,
        Self::Lesson,
        Self::Study,
    ];

    /// Which picture it shows ([`PlacedPanel::slot`]).
    #[must_use]
    pub const fn slot(self) -> usize {
        self as usize + 1
    }
}

/// Sizes and places of the panels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PanelParams {
    /// Width and height of each, metres, in the order of [`PanelId::ALL`].
    pub sizes: [[f32; 2]; 6],
    /// Where the bench stands at first, metres.
    pub bench: Vec3,
    /// Where the keyboard stands at first, metres.
    pub keyboard: Vec3,
    /// Where the tutorial stands at first, metres.
    pub lesson: Vec3,
    /// Where the panel of a study stands at first, metres.
    pub study: Vec3,
    /// The tip presses within this of a panel's face, metres in front of it.
    pub poke: f32,
    /// A tip that came through goes on pressing so far behind the face, metres.
    pub through: f32,
    /// How much a hand's back must face the head for its panel to show: a cosine; and to stay.
    pub facing: [f32; 2],
    /// How far from the grip's centre the panel on a hand stands: out of the back of the hand, and towards the elbow, metres.
    pub wrist: [f32; 2],
    /// How far rays reach panels, metres.
    pub reach: f32,
}

impl Default for PanelParams {
    fn default() -> Self {
        Self {
            sizes: [
                [0.6, 0.66],
                [0.2, 0.205],
                [0.56, 0.3],
                [0.26, 0.036],
                [0.5, 0.36],
                [0.7, 0.82],
            ],
            // Beside the platform as the board is, and nearer: hands reach it.
            bench: Vec3::new(-0.72, 1.05, -0.52),
            keyboard: Vec3::new(-0.5, 0.62, -0.3),
            // Above the sketch and beside the tree, where one looks anyway.
            lesson: Vec3::new(-0.38, 1.52, -1.05),
            // Above the bench, and beside the tree: it is read between two strokes.
            study: Vec3::new(-0.48, 1.72, -1.0),
            poke: 0.012,
            through: 0.06,
            facing: [0.75, 0.6],
            wrist: [0.05, 0.07],
            reach: 4.0,
        }
    }
}

/// A place on a panel: metres to the right of and below its upper left corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PanelPointer {
    /// The hand, 0 left, 1 right.
    pub hand: usize,
    /// Where.
    pub at: Vec2,
    /// Whether it presses.
    pub pressed: bool,
    /// The stick, up positive, −1 to 1: scrolls.
    pub scroll: f32,
}

/// One panel's place and whether it is there.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Place {
    world_from_panel: Affine3A,
    shown: bool,
}

/// See the module.
#[derive(Clone, Debug)]
pub(super) struct Panels {
    places: [Place; 6],
    /// The hand that has each panel.
    owner: [Option<usize>; 6],
    /// The hand whose back shows the wrist's panel.
    wrist: Option<usize>,
    params: PanelParams,
}

/// Where a ray or a tip is on a panel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OnPanel {
    pub(super) id: PanelId,
    /// Metres along the ray, 0 where the tip touches it.
    pub(super) along: f32,
    /// The tip has come to its face, or is somewhere behind it.
    reached: bool,
}

impl Panels {
    pub(super) fn new(params: PanelParams, stage: &StageParams) -> Self {
        let facing = |at: Vec3| Place {
            world_from_panel: facing(at, stage.board_faces),
            shown: false,
        };
        let mut panels = Self {
            places: [facing(params.bench); 6],
            owner: [None; 6],
            wrist: None,
            params,
        };
        panels.places[PanelId::Keyboard as usize] = facing(params.keyboard);
        panels.places[PanelId::Lesson as usize] = facing(params.lesson);
        panels.places[PanelId::Study as usize] = facing(params.study);
        panels.places[PanelId::Bench as usize].shown = true;
        panels
    }

    /// Width and height in metres.
    pub(super) fn size(&self, id: PanelId) -> Vec2 {
        Vec2::from(self.params.sizes[id as usize])
    }

    pub(super) fn is_shown(&self, id: PanelId) -> bool {
        self.places[id as usize].shown
    }

    pub(super) fn show(&mut self, id: PanelId, shown: bool) {
        self.places[id as usize].shown = shown;
        if !shown {
            self.owner[id as usize] = None;
        }
    }

    /// Puts a panel somewhere, upright, turned to the head.
    fn put(&mut self, id: PanelId, at: Vec3, head: Vec3) {
        self.places[id as usize].world_from_panel = facing(at, head);
    }

    /// Puts a panel somewhere, to be read as the head is held.
    fn put_level(&mut self, id: PanelId, at: Vec3, head: &Pose) {
        let normal = (head.position - at).normalize_or(Vec3::Z);
        self.places[id as usize].world_from_panel = sheet(at, normal, head.orientation * Vec3::Y);
    }

    pub(super) fn position(&self, id: PanelId) -> Vec3 {
        self.places[id as usize].world_from_panel.translation.into()
    }

    /// Lets the wrist's panel follow the hand whose back faces the head; `free` hands hold nothing.
    pub(super) fn follow_wrist(&mut self, hands: &[Hand; 2], head: Option<Pose>) {
        let PanelParams { wrist, facing, .. } = self.params;
        let pose = |hand: usize| {
            let free = |hand: &&Hand| hand.hold == Hold::Nothing;
            let sample = hands.get(hand).filter(free)?.sample?;
            Some(on_the_back(&sample.grip, hand, &head?, wrist))
        };
        let faces = |hand: usize| {
            let (place, head) = (pose(hand)?, head?);
            let to_head = (head.position - Vec3::from(place.translation)).normalize_or_zero();
            Some(Vec3::from(place.matrix3.z_axis).dot(to_head))
        };
        let [begin, stay] = facing;
        let still = self
            .wrist
            .filter(|&hand| faces(hand).is_some_and(|cosine| cosine > stay));
        self.wrist = still.or_else(|| {
            [0, 1]
                .into_iter()
                .find(|&hand| faces(hand).is_some_and(|cosine| cosine > begin))
        });
        self.show(PanelId::Wrist, self.wrist.is_some());
        if let Some(place) = self.wrist.and_then(pose) {
            self.places[PanelId::Wrist as usize].world_from_panel = place;
        }
    }

    /// The nearest panel that something that points is at. The hand that carries the wrist's panel cannot point at it.
    pub(super) fn find(&self, hand: Option<usize>, pointer: &Pointer) -> Option<OnPanel> {
        let pointable = PanelId::ALL.into_iter().filter(|&id| {
            self.is_shown(id)
                && id != PanelId::Label
                && (id != PanelId::Wrist || hand.is_none() || self.wrist != hand)
        });
        let hits = pointable.filter_map(|id| {
            let (at, along) = self.pointed(id, pointer)?;
            let size = self.size(id);
            let inside = at.cmpge(Vec2::ZERO).all() && at.cmple(size).all();
            inside.then_some(OnPanel {
                id,
                along,
                reached: self.depth(id, pointer.tip) <= self.params.poke * 0.5,
            })
        });
        hits.min_by(|a, b| a.along.total_cmp(&b.along))
    }

    /// Where a hand is on a panel's plane, and metres along its ray (0: its tip is there). `None`: it points away.
    fn pointed(&self, id: PanelId, pointer: &Pointer) -> Option<(Vec2, f32)> {
        if self.depth(id, pointer.tip).abs() <= self.params.poke {
            return Some((self.on_plane(id, pointer.tip), 0.0));
        }
        let (at, along) = self.met(id, pointer)?;
        (along <= self.params.reach).then_some((at, along))
    }

    /// Where the ray meets a panel's plane from the front.
    fn met(&self, id: PanelId, pointer: &Pointer) -> Option<(Vec2, f32)> {
        let place = &self.places[id as usize].world_from_panel;
        let normal = Vec3::from(place.matrix3.z_axis);
        let center = Vec3::from(place.translation);
        let towards = -pointer.direction.dot(normal);
        let along = (pointer.origin - center).dot(normal) / towards;
        // A ray along the plane gives ±∞ or NaN, which fails here.
        (towards > 1e-4 && along > 0.0 && along.is_finite()).then(|| {
            (
                self.on_plane(id, pointer.origin + pointer.direction * along),
                along,
            )
        })
    }

    /// The foot of a point on a panel: metres right of and below its upper left corner.
    fn on_plane(&self, id: PanelId, point: Vec3) -> Vec2 {
        let place = &self.places[id as usize].world_from_panel;
        let local = place.inverse().transform_point3(point);
        Vec2::new(local.x, -local.y) + self.size(id) * 0.5
    }

    /// Metres that a point stands in front of a panel's face.
    fn depth(&self, id: PanelId, point: Vec3) -> f32 {
        let place = &self.places[id as usize].world_from_panel;
        (point - Vec3::from(place.translation)).dot(Vec3::from(place.matrix3.z_axis))
    }

    /// Whether a tip that poked a panel is still in it.
    pub(super) fn is_poked(&self, id: PanelId, tip: Vec3) -> bool {
        let depth = self.depth(id, tip);
        (-self.params.through..=self.params.poke).contains(&depth)
    }

    /// Whether a tip has come to a panel's face.
    pub(super) fn is_touched(&self, id: PanelId, tip: Vec3) -> bool {
        (-self.params.poke..=self.params.poke * 0.5).contains(&self.depth(id, tip))
    }

    /// Describes the panels that are there.
    pub(super) fn draw(&self, scene: &mut Scene) {
        scene
            .panels
            .extend(PanelId::ALL.into_iter().filter_map(|id| {
                let place = &self.places[id as usize];
                place.shown.then_some(PlacedPanel {
                    slot: id.slot(),
                    world_from_panel: place.world_from_panel,
                    size: self.params.sizes[id as usize],
                })
            }));
    }
}

/// A sheet at a place, as upright as its normal lets it be.
fn sheet(at: Vec3, normal: Vec3, up: Vec3) -> Affine3A {
    let right = up.cross(normal).normalize_or(Vec3::X);
    let up = normal.cross(right);
    let turn = Quat::from_mat3(&Mat3::from_cols(right, up, normal));
    Affine3A::from_rotation_translation(turn, at)
}

/// A sheet at a place, upright, whose face looks at a point.
fn facing(at: Vec3, looks_at: Vec3) -> Affine3A {
    sheet(at, (looks_at - at).normalize_or(Vec3::Z), Vec3::Y)
}

/// The sheet on the back of a hand. In OpenXR's grip pose (its specification, "Standard pose identifiers") +X leaves the palm of a
/// left hand and the back of a right one, and with a fist whose thumb is up +Y goes to the elbow. The text stands upright for the head, however the
/// hand is turned.
fn on_the_back(grip: &Pose, hand: usize, head: &Pose, [out, back]: [f32; 2]) -> Affine3A {
    let outwards = if hand == 0 { Vec3::NEG_X } else { Vec3::X };
    let at = grip.position + grip.orientation * (outwards * out + Vec3::Y * back);
    sheet(at, grip.orientation * outwards, head.orientation * Vec3::Y)
}

impl Tools {
    /// Presses the panel that the hand is at, unless another hand does: it would take that hand's drag with it.
    pub(super) fn press(&mut self, hand: usize, id: PanelId, poked: bool) {
        let presses =
            |other: &Hand| matches!(other.hold, Hold::Panel { id: held, .. } if held == id);
        if self.hands.iter().any(presses) {
            return;
        }
        self.hands[hand].hold = Hold::Panel { id, poked };
        self.panels.owner[id as usize] = Some(hand);
    }

    /// Takes a panel up.
    pub(super) fn carry(&mut self, hand: usize, id: PanelId) {
        let Some(sample) = self.hands[hand].sample else {
            return;
        };
        if id == PanelId::Wrist {
            // It goes where the other hand goes.
            return;
        }
        let away = self.panels.position(id) - sample.grip.position;
        self.hands[hand].hold = Hold::Carried {
            id,
            offset: sample.grip.orientation.inverse() * away,
        };
        self.pulse(hand, self.params.haptics.choose);
    }

    /// Puts the line of text beside the handle that a hand is at.
    pub(super) fn place_label(&mut self, head: Option<Pose>) {
        let says = self.says();
        self.panels.show(PanelId::Label, says.is_some());
        let head = head.unwrap_or(Pose {
            orientation: Quat::IDENTITY,
            position: self.stage.board_faces,
        });
        if let Some((_, at)) = says {
            self.panels.put_level(PanelId::Label, at, &head);
        }
    }

    /// Brings panels up to the hands of this frame: carried ones follow, pokes begin and end, and each panel's owner is decided.
    pub(super) fn follow_panels(&mut self, head: Option<Pose>) {
        self.panels.follow_wrist(&self.hands, head);
        for hand in 0..self.hands.len() {
            let Hand { sample, hold, .. } = self.hands[hand];
            match (hold, sample) {
                (Hold::Carried { id, offset }, Some(sample)) => {
                    let at = sample.grip.position + sample.grip.orientation * offset;
                    let faces = head.map_or(self.stage.board_faces, |head| head.position);
                    self.panels.put(id, at, faces);
                }
                (Hold::Panel { id, poked: true }, Some(sample))
                    if !self.panels.is_poked(id, sample.tip) =>
                {
                    self.hands[hand].hold = Hold::Nothing;
                }
                _ => {}
            }
        }
    }

    /// A tip that has come to a panel's face presses it, once.
    pub(super) fn poke(&mut self, hand: usize, before: Hover) {
        let Hand {
            sample: Some(sample),
            hold: Hold::Nothing,
            hover: Hover::Panel(OnPanel { id, .. }),
            ..
        } = self.hands[hand]
        else {
            return;
        };
        // It must have been seen on its way: a hand that comes from elsewhere, or through the back, does not press.
        let came = matches!(before, Hover::Panel(on) if on.id == id && !on.reached);
        if came && self.panels.is_touched(id, sample.tip) {
            self.press(hand, id, true);
        }
    }

    /// The pointer on a panel, if a hand has it.
    pub(super) fn pointer(&self, id: PanelId) -> Option<PanelPointer> {
        let hand = self.panels.owner[id as usize]?;
        let state = self.hands.get(hand)?;
        let sample = state.sample?;
        let pressed = matches!(state.hold, Hold::Panel { id: held, .. } if held == id);
        let at = match state.hold {
            Hold::Panel { poked: true, .. } if pressed => self.panels.on_plane(id, sample.tip),
            // Dragging goes on beyond the edge.
            Hold::Panel { .. } if pressed => self.panels.met(id, &pointer(&sample))?.0,
            _ => self.panels.pointed(id, &pointer(&sample))?.0,
        };
        Some(PanelPointer {
            hand,
            at,
            pressed,
            scroll: state.scroll,
        })
    }

    /// Decides which hand has each panel: the one that presses, else the one that came last.
    pub(super) fn own_panels(&mut self, before: [Hover; 2]) {
        let at = |hover: Hover| match hover {
            Hover::Panel(on) => Some(on.id),
            _ => None,
        };
        for id in PanelId::ALL {
            let on = |hand: usize| {
                let presses =
                    matches!(self.hands[hand].hold, Hold::Panel { id: held, .. } if held == id);
                presses || at(self.hands[hand].hover) == Some(id)
            };
            let presses = |hand: usize| matches!(self.hands[hand].hold, Hold::Panel { id: held, .. } if held == id);
            let came = [0, 1]
                .into_iter()
                .find(|&hand| on(hand) && at(before[hand]) != Some(id));
            let owner = self.panels.owner[id as usize].filter(|&hand| on(hand));
            self.panels.owner[id as usize] = match owner {
                Some(hand) if presses(hand) => Some(hand),
                _ => came
                    .or(owner)
                    .or_else(|| [0, 1].into_iter().find(|&hand| on(hand))),
            };
        }
    }
}
