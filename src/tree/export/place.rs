//! Where a tree stands in a file: its foot's place, a turn about the vertical and a size.

use glam::{Quat, Vec3};

/// A place of a tree in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Its name among the others.
    pub name: String,
    /// Where its own zero stands, metres.
    pub at: Vec3,
    /// Turn about +Y, degrees.
    pub yaw_deg: f64,
    /// Its size over that of the tree.
    pub size: f32,
}

impl Place {
    /// As the tree is, neither turned nor larger.
    #[must_use]
    pub fn at(name: String, at: Vec3) -> Self {
        Self {
            name,
            at,
            yaw_deg: 0.0,
            size: 1.0,
        }
    }

    /// The turn.
    pub(super) fn turn(&self) -> Quat {
        #[allow(clippy::cast_possible_truncation, reason = "an angle")]
        Quat::from_rotation_y(self.yaw_deg.to_radians() as f32)
    }

    /// A direction of the tree in the file.
    pub(super) fn turned(&self, [x, y, z]: [f32; 3]) -> [f32; 3] {
        if self.yaw_deg == 0.0 {
            return [x, y, z];
        }
        #[allow(clippy::cast_possible_truncation, reason = "parts of a unit vector")]
        let [sin, cos] = [
            self.yaw_deg.to_radians().sin(),
            self.yaw_deg.to_radians().cos(),
        ]
        .map(|part| part as f32);
        [x * cos + z * sin, y, z * cos - x * sin]
    }

    /// A position of the tree in the file.
    pub(super) fn placed(&self, position: [f32; 3]) -> [f32; 3] {
        let [x, y, z] = self.turned(position).map(|part| part * self.size);
        [x + self.at.x, y + self.at.y, z + self.at.z]
    }

    /// Whether the tree is neither turned nor larger there.
    pub(super) fn is_plain(&self) -> bool {
        self.yaw_deg == 0.0 && self.size == 1.0
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::missing_assert_message, reason = "the names say it")]
    use super::*;

    #[test]
    fn a_place_turns_sizes_and_moves_as_its_quaternion_says() {
        let place = Place {
            yaw_deg: 50.0,
            size: 1.5,
            ..Place::at("a".to_owned(), Vec3::new(1.0, 2.0, 3.0))
        };
        let point = Vec3::new(0.3, 0.7, -0.4);
        let expected = place.turn() * point * 1.5 + place.at;
        assert!(Vec3::from(place.placed(point.to_array())).distance(expected) < 1e-5);
        let plain = Place::at("b".to_owned(), Vec3::ZERO);
        assert!(plain.is_plain() && !place.is_plain());
        assert_eq!(plain.placed([0.1, 0.2, 0.3]), [0.1, 0.2, 0.3]);
    }
}
