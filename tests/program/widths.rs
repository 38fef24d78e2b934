//! Plain grammars of the literature, which draw lines and mean no width, are neither hairlines nor one solid patch.

use std::fs;

use image::GrayImage;

use super::{can_draw, folder, ramus, succeed};

/// Name, grammar, and how much of the picture of 256 × 256 pixels its lines cover, in thousandths.
const PLAIN: [(&str, &str, std::ops::RangeInclusive<usize>); 4] = [
    (
        "the quadratic Koch island, ABOP Fig. 1.6",
        "steps 2\nangle 90\naxiom F-F-F-F\nF -> F-F+F+FF-F-F+F\n",
        20..=200,
    ),
    (
        "a plant, ABOP Fig. 1.24f",
        "steps 5\nangle 22.5\naxiom X\nX -> F-[[X]+X]+F[+FX]-X\nF -> FF\n",
        20..=300,
    ),
    (
        "Hogeweg and Hesper, ABOP Fig. 1.31a",
        "steps 30\nangle 22.5\nignore + - F\naxiom F1F1F1\n0 < 0 > 0 -> 0\n0 < 0 > 1 -> 1[+F1F1]\n0 < 1 > 0 -> 1\n\
         0 < 1 > 1 -> 1\n1 < 0 > 0 -> 0\n1 < 0 > 1 -> 1F1\n1 < 1 > 0 -> 0\n1 < 1 > 1 -> 0\n+ -> -\n- -> +\n",
        10..=300,
    ),
    (
        "the row of trees, ABOP Fig. 1.10",
        "const c = 1, p = 0.3, q = 0.7, h = 0.458\nsteps 6\nangle 86\naxiom F(1)\n\
         F(x) -> F(x*p) + F(x*h) - - F(x*h) + F(x*q)\n",
        5..=120,
    ),
];

#[test]
fn plain_lines_can_be_seen_and_told_apart() {
    if !can_draw() {
        return;
    }
    let folder = folder();
    let draw = |grammar: &str, widths: &str| -> GrayImage {
        let [file, png] = ["plain.lsys", "plain.png"].map(|name| folder.path().join(name));
        fs::write(&file, grammar).unwrap();
        succeed(
            ramus()
                .arg("derive")
                .arg(&file)
                .args(["--size", "256", "--widths", widths, "--png"])
                .arg(&png),
        );
        image::open(png).unwrap().into_luma8()
    };
    for (name, grammar, expected) in PLAIN {
        let drawn = draw(grammar, "auto");
        // Lines without a width are not drawn, so what stands there is the background.
        let bare = draw(&grammar.replace("axiom ", "axiom !(0) "), "metres");
        let covered = drawn
            .pixels()
            .zip(bare.pixels())
            .filter(|(a, b)| a.0[0].abs_diff(b.0[0]) > 30)
            .count();
        let thousandths = covered * 1000 / (256 * 256);
        assert!(
            expected.contains(&thousandths),
            "{name}: {thousandths} of 1000 pixels"
        );
    }
}
