//! Parameters to begin with, where there is no model.

use super::params::Params;
use crate::mesh::unit::Unit;

/// Parameters with a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Preset {
    /// What it is called.
    pub name: &'static str,
    /// What its lengths count.
    pub unit: Unit,
    /// The parameters.
    pub params: Params,
}

/// A sapling by the source's defaults (van Nielen, Verbeek and Cao, Table 2), with forks more likely and turned about so that it looks like one, and trees with the source's
/// published tables of a duct and an artery: what `ramus abstract` finds for these, to four digits. The source states no unit.
pub fn presets() -> [Preset; 3] {
    let of = |name, unit, params| Preset { name, unit, params };
    [
        of("sapling", Unit::Metres, sapling()),
        of("duct", Unit::Micrometres, duct()),
        of("artery", Unit::Micrometres, artery()),
    ]
}

fn sapling() -> Params {
    Params {
        bifurcation_probability: 0.8,
        iterations: 9.0,
        stem_length: 2,
        bifurcation_angle: 24.0,
        length_ratio: 0.9,
        radius_ratio: 0.75,
        around: true,
        seed: 1,
        ..Params::default()
    }
}

fn duct() -> Params {
    Params {
        segment_radius: 19.03,
        radial_increment: 0.0,
        bifurcation_probability: 0.697_68,
        trifurcation_probability: 0.114_95,
        iterations: 22.3,
        iterations_std: 13.14,
        side_life: 0.043_59,
        segment_length: 105.5,
        segment_length_std: 11.26,
        length_ratio: 0.8168,
        radius_ratio: 0.8695,
        upwards_angle: 0.0,
        upwards_angle_std: 8.822,
        bifurcation_angle: 33.96,
        bifurcation_angle_std: 11.99,
        stem_length: 2,
        roll_range: 20,
        around: true,
        seed: 2_249_087_597,
        ..Params::default()
    }
}

fn artery() -> Params {
    Params {
        segment_radius: 18.63,
        radial_increment: 0.0,
        bifurcation_probability: 0.484_08,
        trifurcation_probability: 0.202_54,
        iterations: 11.85,
        iterations_std: 1.247,
        side_life: 0.4066,
        segment_length: 28.36,
        segment_length_std: 21.56,
        length_ratio: 0.8228,
        radius_ratio: 0.6639,
        upwards_angle: 0.0,
        upwards_angle_std: 11.93,
        bifurcation_angle: 16.86,
        bifurcation_angle_std: 30.5,
        stem_length: 2,
        roll_range: 20,
        around: true,
        seed: 6_827_083,
        ..Params::default()
    }
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use std::sync::atomic::AtomicBool;

    use super::super::{Table, differences, grow};
    use super::*;
    use crate::lsystem::Limits;
    use crate::tree::measure::Measures;

    #[test]
    fn presets_are_within_limits_and_have_the_published_tables() {
        let never = AtomicBool::new(false);
        let [sapling, duct, artery] = presets();
        assert!(sapling.params.check().is_ok());
        let grown = grow(&sapling.params, &Limits::default(), &never).unwrap();
        assert!(grown.tips().len() > 8);
        let tables = [
            include_str!("../../tests/data/tables/duct.json"),
            include_str!("../../tests/data/tables/artery.json"),
        ];
        for (preset, text) in [duct, artery].into_iter().zip(tables) {
            let tree = grow(&preset.params, &Limits::default(), &never).unwrap();
            let table = Table::of(&Measures::whole(&tree));
            for one in differences(&Table::read(text).unwrap(), &table) {
                assert!(one.matches(), "{}: {one:?}", preset.name);
            }
        }
    }
}
