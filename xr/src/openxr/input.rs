//! Hands: actions, their bindings, their state, and vibrations.

use std::ptr;

use ::openxr as xr;
use glam::Vec2;

use super::call::{Called as _, check};
use super::space::{Stage, locate};
use crate::bindings::{Action, HANDS};
use crate::directions::{Directions, Said};
use crate::frame::{Hand, Pulse};
use crate::headset::HeadsetError;
use crate::profiles::Profile;

/// Most vibrations that wait for the end of a frame; more in one frame are one too many to feel.
const MAX_PULSES: usize = 8;

/// Longest vibration in seconds: whatever asks for more is wrong.
const LONGEST_PULSE: f32 = 2.0;

/// The pose that XR_EXT_palm_pose gives to every profile.
const PALM: &str = "/input/palm_ext/pose";

/// Everything that the hands do.
pub(super) struct Input {
    set: xr::ActionSet,
    draw: xr::Action<f32>,
    grab: xr::Action<f32>,
    stick: xr::Action<xr::Vector2f>,
    lower: xr::Action<bool>,
    upper: xr::Action<bool>,
    step: xr::Action<f32>,
    press: xr::Action<bool>,
    haptic: xr::Action<xr::Haptic>,
    /// Aim and grip of each hand.
    spaces: [[xr::Space; 2]; 2],
    /// The palm of each hand, where the runtime has poses there.
    palms: Option<[xr::Space; 2]>,
    hands: [xr::Path; 2],
    directions: [Directions; 2],
    pulses: Vec<Pulse>,
}

impl Input {
    /// Makes the actions, suggests the bindings for these profiles and attaches both to the session.
    pub(super) fn new(
        session: &xr::Session<xr::Vulkan>,
        profiles: &[&Profile],
        palms: bool,
    ) -> Result<Self, HeadsetError> {
        let instance = session.instance();
        let [left, right] =
            HANDS.map(|hand| instance.string_to_path(hand).called("xrStringToPath"));
        let hands = [left?, right?];
        let set = instance
            .create_action_set("ramus", "Ramus", 0)
            .called("xrCreateActionSet")?;
        let draw = create::<f32>(&set, Action::Draw, &hands)?;
        let grab = create::<f32>(&set, Action::Grab, &hands)?;
        let stick = create::<xr::Vector2f>(&set, Action::Stick, &hands)?;
        let lower = create::<bool>(&set, Action::Lower, &hands)?;
        let upper = create::<bool>(&set, Action::Upper, &hands)?;
        let step = create::<f32>(&set, Action::Step, &hands)?;
        let press = create::<bool>(&set, Action::Press, &hands)?;
        let aim = create::<xr::Posef>(&set, Action::Aim, &hands)?;
        let grip = create::<xr::Posef>(&set, Action::Grip, &hands)?;
        let haptic = create::<xr::Haptic>(&set, Action::Haptic, &hands)?;
        let bind = |action: Action, path| match action {
            Action::Draw => xr::Binding::new(&draw, path),
            Action::Grab => xr::Binding::new(&grab, path),
            Action::Stick => xr::Binding::new(&stick, path),
            Action::Lower => xr::Binding::new(&lower, path),
            Action::Upper => xr::Binding::new(&upper, path),
            Action::Step => xr::Binding::new(&step, path),
            Action::Press => xr::Binding::new(&press, path),
            Action::Aim => xr::Binding::new(&aim, path),
            Action::Grip => xr::Binding::new(&grip, path),
            Action::Haptic => xr::Binding::new(&haptic, path),
        };
        // Every profile has it with the extension, so it is in no table of ours.
        let palm = if palms {
            let action = set.create_action::<xr::Posef>("palm", "Palm", &hands);
            Some(action.called("xrCreateAction")?)
        } else {
            None
        };
        let mut taken = 0;
        for profile in profiles {
            let with_palm = suggest(instance, profile, bind, palm.as_ref());
            let suggested = match with_palm {
                // The profile without it is better than none.
                Err(_) if palm.is_some() => suggest(instance, profile, bind, None),
                suggested => suggested,
            };
            match suggested {
                Ok(()) => taken += 1,
                Err(code) => tracing::warn!(
                    "the runtime takes no bindings for the {} ({code:?})",
                    profile.title
                ),
            }
        }
        if taken == 0 {
            return Err(HeadsetError::Failed(String::from(
                "the runtime takes no controller bindings at all",
            )));
        }
        session
            .attach_action_sets(&[&set])
            .called("xrAttachSessionActionSets")?;
        let space = |action: &xr::Action<xr::Posef>, hand| {
            action
                .create_space(session, hand, xr::Posef::IDENTITY)
                .called("xrCreateActionSpace")
        };
        let spaces = [
            [space(&aim, hands[0])?, space(&grip, hands[0])?],
            [space(&aim, hands[1])?, space(&grip, hands[1])?],
        ];
        let palms = match &palm {
            Some(palm) => Some([space(palm, hands[0])?, space(palm, hands[1])?]),
            None => None,
        };
        Ok(Self {
            palms,
            set,
            draw,
            grab,
            stick,
            lower,
            upper,
            step,
            press,
            haptic,
            spaces,
            hands,
            directions: Default::default(),
            pulses: Vec::with_capacity(MAX_PULSES),
        })
    }

    /// Brings all states up to date: once a frame.
    pub(super) fn sync(&self, session: &xr::Session<xr::Vulkan>) -> Result<(), HeadsetError> {
        let active = xr::sys::ActiveActionSet {
            action_set: self.set.as_raw(),
            subaction_path: xr::Path::NULL,
        };
        let info = xr::sys::ActionsSyncInfo {
            ty: xr::sys::ActionsSyncInfo::TYPE,
            next: ptr::null(),
            count_active_action_sets: 1,
            active_action_sets: &active,
        };
        // SAFETY: session and set are alive, both structs are initialised and outlive the call.
        let code = unsafe { (session.instance().fp().sync_actions)(session.as_raw(), &info) };
        check("xrSyncActions", code).map(|_| ())
    }

    /// Both hands at `time`. A hand whose pointing pose is not known is absent.
    pub(super) fn hands(
        &mut self,
        session: &xr::Session<xr::Vulkan>,
        stage: &Stage,
        time: xr::Time,
    ) -> Result<[Hand; 2], HeadsetError> {
        Ok([
            self.hand(session, stage, time, 0)?,
            self.hand(session, stage, time, 1)?,
        ])
    }

    fn hand(
        &mut self,
        session: &xr::Session<xr::Vulkan>,
        stage: &Stage,
        time: xr::Time,
        side: usize,
    ) -> Result<Hand, HeadsetError> {
        let [aim, grip] = &self.spaces[side];
        let Some(aim) = locate(aim, stage, time)? else {
            self.directions[side] = Directions::default();
            return Ok(Hand::ABSENT);
        };
        let grip = match (locate(grip, stage, time)?, &self.palms) {
            (None, Some(palms)) => locate(&palms[side], stage, time)?,
            (grip, _) => grip,
        };
        let grip = grip.unwrap_or(aim);
        let path = self.hands[side];
        // An action that no button is bound to is not active; its value is then 0.
        let number = |action: &xr::Action<f32>, from| {
            let state = action
                .state(session, path)
                .called("xrGetActionStateFloat")?;
            let value = within(state.current_state, from);
            Ok::<_, HeadsetError>(state.is_active.then_some(value))
        };
        let button = |action: &xr::Action<bool>| {
            let state = action
                .state(session, path)
                .called("xrGetActionStateBoolean")?;
            Ok::<_, HeadsetError>(state.is_active.then_some(state.current_state))
        };
        let stick = self
            .stick
            .state(session, path)
            .called("xrGetActionStateVector2f")?
            .current_state;
        let said = Said {
            stick: Vec2::new(within(stick.x, -1.0), within(stick.y, -1.0)),
            step: number(&self.step, -1.0)?,
            press: button(&self.press)?,
        };
        let hand = Hand {
            tracked: true,
            aim,
            grip,
            trigger: number(&self.draw, 0.0)?.unwrap_or(0.0),
            squeeze: number(&self.grab, 0.0)?.unwrap_or(0.0),
            stick: Vec2::ZERO,
            lower: button(&self.lower)? == Some(true),
            upper: button(&self.upper)? == Some(true),
        };
        let meant = self.directions[side].meant(said);
        Ok(Hand {
            stick: meant.stick,
            lower: hand.lower || meant.lower,
            upper: hand.upper || meant.upper,
            ..hand
        })
    }

    /// Keeps a vibration for the end of the frame.
    pub(super) fn queue(&mut self, pulse: Pulse) {
        if self.pulses.len() < MAX_PULSES && pulse.duration > 0.0 && pulse.amplitude > 0.0 {
            self.pulses.push(pulse);
        }
    }

    /// Sends the vibrations, or forgets them where the input is not ours.
    pub(super) fn vibrate(
        &mut self,
        session: &xr::Session<xr::Vulkan>,
        focused: bool,
    ) -> Result<(), HeadsetError> {
        for pulse in self.pulses.drain(..) {
            let (true, Some(&hand)) = (focused, self.hands.get(pulse.hand)) else {
                continue;
            };
            let seconds = f64::from(pulse.duration.min(LONGEST_PULSE));
            let event = xr::HapticVibration::new()
                .duration(xr::Duration::from_nanos(nanoseconds(seconds)))
                .frequency(xr::FREQUENCY_UNSPECIFIED)
                .amplitude(within(pulse.amplitude, 0.0));
            self.haptic
                .apply_feedback(session, hand, &event)
                .called("xrApplyHapticFeedback")?;
        }
        Ok(())
    }
}

fn create<T: xr::ActionTy>(
    set: &xr::ActionSet,
    action: Action,
    hands: &[xr::Path],
) -> Result<xr::Action<T>, HeadsetError> {
    set.create_action(action.name(), action.title(), hands)
        .called("xrCreateAction")
}

/// Suggests one profile's bindings.
fn suggest<'a>(
    instance: &xr::Instance,
    profile: &Profile,
    bind: impl Fn(Action, xr::Path) -> xr::Binding<'a>,
    palm: Option<&'a xr::Action<xr::Posef>>,
) -> xr::Result<()> {
    let mut bindings = Vec::with_capacity(profile.bindings.len() * HANDS.len());
    for binding in profile.bindings {
        for (hand, path) in HANDS.iter().zip(binding.paths) {
            if let Some(path) = path {
                bindings.push(bind(
                    binding.action,
                    instance.string_to_path(&format!("{hand}{path}"))?,
                ));
            }
        }
    }
    if let Some(palm) = palm {
        for hand in HANDS {
            let path = instance.string_to_path(&format!("{hand}{PALM}"))?;
            bindings.push(xr::Binding::new(palm, path));
        }
    }
    instance.suggest_interaction_profile_bindings(instance.string_to_path(profile.path)?, &bindings)
}

/// A value between `from` and 1; 0 for what is no number.
fn within(value: f32, from: f32) -> f32 {
    if value.is_finite() {
        value.clamp(from, 1.0)
    } else {
        0.0
    }
}

#[allow(
    clippy::cast_possible_truncation,
    reason = "at most LONGEST_PULSE seconds; `as` saturates in any case"
)]
fn nanoseconds(seconds: f64) -> i64 {
    (seconds * 1e9) as i64
}
