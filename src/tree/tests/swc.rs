//! SWC out and in: an independent checker of what we write, and everything that may stand in what we read.

use std::collections::HashSet;

use glam::Vec3;
use proptest::prelude::*;

use super::{any_tree, fork, node, tree_of};
use crate::tree::axes::axis_children;
use crate::tree::{NO_PARENT, Tree, TreeError, export, import};

/// What the specification asks of a file, checked on the text alone: seven fields, ids from 1 without a gap, parents before
/// children, one root.
fn check_standard(text: &str) {
    let mut seen = HashSet::new();
    let mut roots = 0;
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let fields: Vec<&str> = line.split(' ').collect();
        assert_eq!(fields.len(), 7, "{line}");
        let [id, kind, parent] = [0, 1, 6].map(|i| fields[i].parse::<i64>().unwrap());
        assert!(
            fields[2..6]
                .iter()
                .all(|f| f.parse::<f64>().unwrap().is_finite())
        );
        assert!(kind >= 5 && fields[5].parse::<f64>().unwrap() >= 0.0);
        assert_eq!(id, seen.len() as i64 + 1);
        if parent == -1 {
            roots += 1;
        } else {
            assert!(seen.contains(&parent), "{line}: the parent comes later");
        }
        seen.insert(id);
    }
    assert_eq!(roots, 1);
}

#[test]
fn a_fork_as_swc() {
    let mut tree = fork();
    tree.letters = vec!["A".into(), "C\n1 1 0 0 0 0 -1".into()];
    tree.letter[4] = 1;
    let text = String::from_utf8(export::swc(&tree).unwrap()).unwrap();
    check_standard(&text);
    let expected = format!(
        "# Ramus {}: 5 segments
# unit: metre (1 unit = 1 m = 1000000 micrometre); Y up
# type 5: letter A
# type 6: letter C 1 1 0 0 0 0 -1
# id type x y z radius parent
1 5 0 0 0 0.02 -1
2 5 0 1 0 0.02 1
3 5 0 2 0 0.01 2
4 5 0 3 0 0.01 3
5 6 0.8 1.1 0 0.01 2
6 5 1 1.9 0 0.01 5
",
        env!("CARGO_PKG_VERSION")
    );
    assert_eq!(text, expected);
}

#[test]
fn swc_wants_one_tree() {
    let bare = tree_of(&[node(NO_PARENT, Vec3::ZERO, 0.1, 0, 0)]);
    assert!(matches!(export::swc(&bare), Err(TreeError::Empty("SWC"))));
    assert!(matches!(
        export::swc(&Tree::default()),
        Err(TreeError::Empty("SWC"))
    ));
    let mut two = fork();
    two.push(node(NO_PARENT, Vec3::X, 0.1, 0, 0));
    assert!(matches!(export::swc(&two), Err(TreeError::ManyRoots(2))));
}

#[test]
fn nodes_in_any_order_become_a_tree() {
    let text = b"\xEF\xBB\xBF# caf\xE9, Latin-1\r\n\r\n  30 3 0 2 0 .5 20 # a tip\r\n20 3 0 1 0 1e0 7 extra columns 9\r\n\t7 1 0 0 0 2 -1\r\n8 4 5 5 5 0 -1\r\n41 3 3 1 0 +0.25 20";
    let tree = import::swc(text).unwrap();
    assert_eq!(tree.parent, [NO_PARENT, 0, 1, NO_PARENT, 1]);
    assert_eq!(tree.radius, [2.0, 1.0, 0.5, 0.0, 0.25]);
    assert_eq!(tree.letters, ["soma", "basal", "apical"]);
    assert_eq!(tree.letter, [0, 1, 1, 2, 1]);
    assert_eq!(
        tree.order,
        [0, 0, 1, 0, 0],
        "the longer way, to 41, is the axis"
    );
    assert_eq!(tree.position[4], Vec3::new(3.0, 1.0, 0.0));
}

#[test]
fn bad_files_are_refused_with_the_line() {
    let table: [(&[u8], &str); 24] = [
        (b"", "holds no node"),
        (b"# only a comment\n\n", "holds no node"),
        (
            b"1 1 0 0 0 1",
            "line 1 of the SWC file ends before the parent",
        ),
        (b"1", "ends before the type"),
        (
            b"#\n\none 1 0 0 0 1 -1",
            "line 3 of the SWC file has the id `one`",
        ),
        (b"1.0 1 0 0 0 1 -1", "has the id `1.0`"),
        (
            b"99999999999999999999 1 0 0 0 1 -1",
            "has the id `99999999999999999999`",
        ),
        (b"-5 1 0 0 0 1 -1", "has the id -5"),
        (b"1 -2 0 0 0 1 -1", "has the type -2"),
        (b"1 65536 0 0 0 1 -1", "has the type 65536"),
        (b"1 1 nan 0 0 1 -1", "has the x `nan`"),
        (b"1 1 0 inf 0 1 -1", "has the y `inf`"),
        (b"1 1 0 0 1e39 1 -1", "has the z `1e39`"),
        (b"1 1 0 0 1e16 1 -1", "has the z `1e16`"),
        (b"1 1 0 0 0 -1 -1", "has the radius -1"),
        (b"1 1 0 0 0 NaN -1", "has the radius `NaN`"),
        (
            b"1 1 0 0 0 1 2",
            "names the parent 2, which the file does not hold",
        ),
        (b"1 1 0 0 0 1 -7", "names the parent -7"),
        (
            b"1 1 0 0 0 1 1",
            "line 1 of the SWC file is its own ancestor (id 1)",
        ),
        (
            b"1 1 0 0 0 1 -1\n2 1 0 0 0 1 4\n3 1 0 0 0 1 2\n4 1 0 0 0 1 3",
            "is its own ancestor",
        ),
        (
            b"1 1 0 0 0 1 -1\n1 1 0 0 0 1 -1",
            "line 2 of the SWC file uses the id 1 of line 1 again",
        ),
        (
            b"1 1 0 0 0 1 -1\n\xFF\xFE 1 0",
            "line 2 of the SWC file is not text",
        ),
        (b"\0\0\0\0", "has the id `????`"),
        (b"1 1 0 0 0 1 \x1b[31mred", "has the parent `?[31mred`"),
    ];
    for (bytes, expected) in table {
        let message = import::swc(bytes).unwrap_err().to_string();
        assert!(
            message.contains(expected) && message.contains(':'),
            "{message}"
        );
    }
    let endless = vec![b'7'; 1 << 20];
    let message = import::swc(&endless).unwrap_err().to_string();
    assert!(
        message.contains("longer than") && message.len() < 200,
        "{message}"
    );
    let many_types: String = (0..1100).map(|i| format!("{i} {i} 0 0 0 1 -1\n")).collect();
    assert!(
        import::swc(many_types.as_bytes())
            .unwrap_err()
            .to_string()
            .contains("structure type")
    );
}

/// A chain written backwards and a deep comb: no recursion, and time in proportion to the file.
#[test]
fn deep_files_are_read() {
    let nodes = 200_000;
    let backward: String = (0..nodes)
        .rev()
        .map(|i| format!("{i} 2 0 {i} 0 1 {}\n", i - 1))
        .collect();
    let tree = import::swc(backward.as_bytes()).unwrap();
    assert_eq!(tree.len(), nodes as usize);
    assert!(tree.order.iter().all(|&order| order == 0));
    // Each node bears a long and a short child; the short one bears the next pair: orders rise to the end of u16.
    let mut comb = String::from("0 2 0 0 0 1 -1\n");
    for i in 0..70_000_i64 {
        let (parent, y, tip) = (2 * i, i % 2, 200_000 - 2 * i);
        comb += &format!(
            "{} 2 0 {y} 0 1 {parent}\n{} 2 {tip} {y} 0 1 {parent}\n",
            2 * i + 2,
            2 * i + 1
        );
    }
    let tree = import::swc(comb.as_bytes()).unwrap();
    assert_eq!(tree.order.iter().max(), Some(&u16::MAX));
}

proptest! {
    #[test]
    fn what_is_written_is_read_back(mut tree in any_tree()) {
        // One tree: later roots hang from the first.
        for parent in &mut tree.parent[1..] {
            if *parent == NO_PARENT {
                *parent = 0;
            }
        }
        prop_assume!(tree.segment_count() > 0);
        let bytes = export::swc(&tree).unwrap();
        check_standard(str::from_utf8(&bytes).unwrap());
        let back = import::swc(&bytes).unwrap();
        prop_assert_eq!(&back.parent, &tree.parent);
        prop_assert_eq!(&back.radius, &tree.radius);
        // −0 comes back as −0 and equals 0.
        prop_assert_eq!(&back.position, &tree.position);
        for node in 0..tree.len() {
            let name = &back.letters[usize::from(back.letter[node])];
            prop_assert_eq!(name, &format!("type{}", 5 + tree.letter[node]));
        }
    }

    /// Orders number the same axes that tubes follow, where one letter is used.
    #[test]
    fn orders_and_tubes_agree(mut tree in any_tree()) {
        for parent in &mut tree.parent[1..] {
            if *parent == NO_PARENT {
                *parent = 0;
            }
        }
        tree.letter.fill(0);
        tree.order.fill(0);
        prop_assume!(tree.segment_count() > 0);
        let back = import::swc(&export::swc(&tree).unwrap()).unwrap();
        for (parent, &axis) in axis_children(&back).iter().enumerate() {
            if axis != NO_PARENT {
                prop_assert_eq!(back.order[axis as usize], back.order[parent]);
            }
        }
    }

    /// Whatever the bytes, an answer comes; and what is accepted is valid.
    #[test]
    fn any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        if let Ok(tree) = import::swc(&bytes) {
            tree.validate().unwrap();
        }
    }

    #[test]
    fn almost_swc(lines in prop::collection::vec((0_i64..12, -1_i64..9, "[-0-9.e#nai ]{0,8}", -1_i64..12), 0..14)) {
        let text: String = lines.iter().map(|(id, kind, y, parent)| format!("{id} {kind} 0 {y} 0 1 {parent}\n")).collect();
        if let Ok(tree) = import::swc(text.as_bytes()) {
            tree.validate().unwrap();
        }
    }
}
