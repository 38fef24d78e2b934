//! Watches a window's session: tells the pointer what is on the stage, and does what keys ask for besides the tools.

use std::path::{Path, PathBuf};
use std::rc::Rc;

use anyhow::{Context as _, Result};
use glam::{Affine3A, Vec3};
use ramus_xr::{Acquired, Frame, Headset};

use super::camera::Camera;
use super::keys::HELP;
use super::pointer::Facts;
use super::{Files, Wire, Wishes};
use crate::app::picture::Picture;
use crate::app::session::Watcher;
use crate::app::workshop::Workshop;
use crate::app::{export, take_home};
use crate::world::Met;
use crate::world::scene::Scene;
use crate::world::stage::StageParams;

/// Most pictures in a row beside each other in a folder.
const MOST_PICTURES: u32 = 10_000;

/// See the module.
pub(super) struct Stagehand<'a> {
    wire: Rc<Wire>,
    files: Files,
    message: Option<String>,
    /// Whoever watches besides.
    inner: &'a mut dyn Watcher,
}

impl<'a> Stagehand<'a> {
    pub(super) fn new(wire: Rc<Wire>, files: Files, inner: &'a mut dyn Watcher) -> Self {
        Self {
            wire,
            files,
            message: None,
            inner,
        }
    }

    fn look(&self, workshop: &Workshop, picture: &Picture) {
        let world = workshop.world();
        let room = world.room();
        // The pointer's ray is the room's, as a headset's would be.
        let stage_from_room = world.stage_from_room();
        let room_from_stage = stage_from_room.inverse();
        let in_room = |place| room_from_stage.transform_point3(place);
        let met = self.wire.ray.get().and_then(|ray| {
            let origin = stage_from_room.transform_point3(ray.origin);
            world.met(origin, stage_from_room.transform_vector3(ray.direction))
        });
        self.wire.facts.set(Facts {
            selected: world.selected_position().map(in_room),
            met: met.map(|met| Met {
                place: in_room(met.place),
                ..met
            }),
            left_undoes: room.turning && room.left_handed,
        });
        self.wire.moving.set(
            world.is_growing()
                || workshop.is_busy()
                || workshop.is_reading()
                || picture.is_behind()
                || picture.blows(),
        );
    }

    /// Does what keys asked for. What fails is told on the board and ends nothing.
    fn serve(&mut self, workshop: &Workshop, picture: &Picture, acquired: Option<Acquired>) {
        let Wishes {
            picture: pictures,
            export: exports,
            help,
            tree,
        } = self.wire.wishes.take();
        let mut said = |outcome: Result<String>| {
            self.message = Some(outcome.unwrap_or_else(|error| format!("{error:#}.")));
        };
        if pictures {
            said(keep_picture(picture, acquired, &self.files.picture));
        }
        if exports {
            said(keep_tree(workshop, self.files.tree.as_deref()));
        }
        if tree {
            self.wire.eye.set(Some(before_tree(workshop)));
        }
        if help {
            said(Ok(HELP.to_owned()));
        }
    }
}

/// An eye that sees the whole tree, or where it will stand: in the room, as every eye, and that stands on the stage as the
/// person set it.
fn before_tree(workshop: &Workshop) -> Camera {
    let mut scene = Scene::default();
    workshop.world().scene(&mut scene);
    let tree = scene.tree.as_ref().and_then(|placed| {
        let (low, high) = placed.tree.bounds()?;
        Some(boxed([low, high], &placed.world_from_tree))
    });
    let place = StageParams::default().tree;
    let on_stage = tree.unwrap_or([place, place + Vec3::Y * 2.0]);
    let room_from_stage = workshop.world().stage_from_room().inverse();
    Camera::before(boxed(on_stage, &room_from_stage))
}

/// The box around a box that stands elsewhere, lowest and highest corner.
fn boxed(corners: [Vec3; 2], place: &Affine3A) -> [Vec3; 2] {
    let corner = |n: usize| {
        let [x, y, z] = [0, 1, 2].map(|axis| corners[n >> axis & 1][axis]);
        place.transform_point3(Vec3::new(x, y, z))
    };
    let first = [corner(0); 2];
    (1..8)
        .map(corner)
        .fold(first, |[low, high], at| [low.min(at), high.max(at)])
}

/// Writes what the window shows under the next free number.
fn keep_picture(picture: &Picture, acquired: Option<Acquired>, name: &Path) -> Result<String> {
    let [left, _] = picture.read(acquired)?;
    let path = free_name(name);
    if let Some(folder) = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty())
    {
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    }
    export::png(&left, &path)?;
    Ok(format!("The picture is in {}.", path.display()))
}

fn free_name(name: &Path) -> PathBuf {
    let numbered = |number: u32| {
        let mut name = name.as_os_str().to_owned();
        name.push(format!("-{number:02}.png"));
        PathBuf::from(name)
    };
    let free = (1..MOST_PICTURES).map(numbered).find(|path| !path.exists());
    free.unwrap_or_else(|| numbered(MOST_PICTURES))
}

fn keep_tree(workshop: &Workshop, tree: Option<&Path>) -> Result<String> {
    let Some(tree) = tree else {
        return Ok("A session that is played exports nothing by keys.".to_owned());
    };
    let world = workshop.world();
    if world.document().step == 0 {
        return Ok("Nothing to export yet: grow the tree first.".to_owned());
    }
    let grammar = tree.with_extension("lsys");
    take_home::export(world.document(), tree)?;
    take_home::grammar(world.document(), &grammar)?;
    Ok(format!(
        "The tree is in {}, its grammar in {}.",
        tree.display(),
        grammar.display()
    ))
}

impl Watcher for Stagehand<'_> {
    fn updated(&mut self, workshop: &Workshop) {
        let (wire, told) = (&self.wire, workshop.world().has_message());
        if wire.told.replace(told) != told || workshop.world().is_growing() {
            wire.moving.set(true);
        }
        self.inner.updated(workshop);
    }

    fn wants(&mut self, workshop: &Workshop, frame: &Frame) -> bool {
        self.inner.wants(workshop, frame)
    }

    fn drawn(
        &mut self,
        workshop: &Workshop,
        picture: &Picture,
        acquired: Option<Acquired>,
    ) -> Result<()> {
        self.serve(workshop, picture, acquired);
        self.look(workshop, picture);
        if self.message.is_some() {
            // It shows in the next frame.
            self.wire.moving.set(true);
        }
        self.inner.drawn(workshop, picture, acquired)
    }

    fn take_files(&mut self) -> Vec<PathBuf> {
        self.wire.dropped.take()
    }

    fn take_message(&mut self) -> Option<String> {
        self.message.take().or_else(|| self.inner.take_message())
    }

    fn ended(&mut self, headset: &mut dyn Headset) {
        self.inner.ended(headset);
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;
    use crate::world::{World, history::History};

    #[test]
    fn a_lifted_person_sees_the_tree_where_it_stands() {
        let mut workshop = Workshop::unsaved(World::new(History::default())).unwrap();
        let level = before_tree(&workshop).pose();
        let mut settings = workshop.settings();
        settings.room.lift = 0.5;
        workshop.set(settings);
        let lifted = before_tree(&workshop).pose();
        let on_stage = workshop
            .world()
            .stage_from_room()
            .transform_point3(lifted.position);
        assert!(on_stage.distance(level.position) < 1e-3, "{on_stage}");
        assert_eq!(lifted.orientation, level.orientation);
    }

    #[test]
    fn a_box_that_is_turned_is_within_its_box() {
        let quarter = Affine3A::from_rotation_y(std::f32::consts::FRAC_PI_2);
        let turned = boxed([Vec3::ZERO, Vec3::new(1.0, 2.0, 3.0)], &quarter);
        let expected = [Vec3::new(0.0, 0.0, -1.0), Vec3::new(3.0, 2.0, 0.0)];
        for (corner, expected) in turned.into_iter().zip(expected) {
            assert!(corner.distance(expected) < 1e-5, "{corner}");
        }
        assert_eq!(boxed(expected, &Affine3A::IDENTITY), expected);
    }
}
