//! SWC files read into trees, and [lines] joined into one; anything at all may stand in such a file.
//!
//! Lines of `id type x y z radius parent` in any order: forward references, ids from anywhere in i64, several roots (each
//! becomes a root of the tree), comments in any encoding. Refused with the line's number: what is no number or not finite, an
//! id used twice, a parent that does not exist, circles. Memory stays in proportion to the file: some 150 bytes for each node,
//! and no node takes less than 14 bytes of text.

mod lines;

use std::collections::HashMap;

use glam::Vec3;

pub use self::lines::lines;
use super::{NO_PARENT, Node, Tree, TreeError};

/// Longest line read, in bytes; a node needs about 60.
const LONGEST_LINE: usize = 4096;

/// Most nodes read: a larger file is more likely wrong than a tree.
const MOST_NODES: usize = 10_000_000;

/// Largest structure type; readers of SWC know 0 to 7, Ramus writes 5 plus a letter's index.
const LARGEST_TYPE: u32 = u16::MAX as u32;

/// Largest coordinate or radius: beyond it differences and squares of coordinates leave f32.
const LARGEST_COORDINATE: f32 = 1e15;

/// Most different structure types in one file.
const MOST_TYPES: usize = 1024;

/// One line of the file.
struct Sample {
    id: i64,
    kind: u32,
    position: Vec3,
    radius: f32,
    parent: i64,
    line: usize,
}

/// Reads an SWC file. Lengths are taken as they stand: what the file's unit is, its header may say, and the caller knows.
///
/// The nodes keep the file's order wherever a parent stands before its children already. Letters are named after the structure
/// types that occur. Branching order grows by one at each lateral, where the axis is the child with the longest way to a tip.
///
/// # Errors
/// The first line that cannot be understood, and why.
pub fn swc(bytes: &[u8]) -> Result<Tree, TreeError> {
    let samples = read_samples(bytes)?;
    let parents = resolve_parents(&samples)?;
    let order = parents_first(&samples, &parents)?;

    let mut tree = Tree::with_capacity(samples.len());
    let mut letters = HashMap::new();
    let mut place = vec![NO_PARENT; samples.len()];
    for sample_index in order {
        let sample = &samples[sample_index as usize];
        let parent = parents[sample_index as usize];
        if letters.len() >= MOST_TYPES && !letters.contains_key(&sample.kind) {
            return Err(problem(
                sample.line,
                format!(
                    "uses one structure type more than the {MOST_TYPES} that can be told apart: use fewer"
                ),
            ));
        }
        let letter = *letters.entry(sample.kind).or_insert_with(|| {
            tree.letters.push(type_name(sample.kind));
            u16::try_from(tree.letters.len() - 1).unwrap_or(u16::MAX)
        });
        place[sample_index as usize] = tree.push(Node {
            parent: if parent == NO_PARENT {
                NO_PARENT
            } else {
                place[parent as usize]
            },
            position: sample.position,
            radius: sample.radius,
            letter,
            order: 0,
            birth: 0,
        });
    }
    number_orders(&mut tree);
    tree.validate()?;
    Ok(tree)
}

fn problem(line: usize, problem: impl Into<String>) -> TreeError {
    TreeError::Swc {
        line,
        problem: problem.into(),
    }
}

fn read_samples(bytes: &[u8]) -> Result<Vec<Sample>, TreeError> {
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let mut samples = Vec::new();
    for (line, text) in (1..).zip(bytes.split(|&byte| byte == b'\n')) {
        let text = text.trim_ascii();
        if text.is_empty() || text.starts_with(b"#") {
            continue;
        }
        if text.len() > LONGEST_LINE {
            return Err(problem(
                line,
                format!("is longer than {LONGEST_LINE} bytes: put each node on a line of its own"),
            ));
        }
        if samples.len() >= MOST_NODES {
            return Err(problem(
                line,
                format!("is one node more than the {MOST_NODES} that are read: split the file"),
            ));
        }
        let text = str::from_utf8(text)
            .map_err(|_| problem(line, "is not text: save the file as plain ASCII"))?;
        samples.push(read_sample(line, text)?);
    }
    if samples.is_empty() {
        Err(TreeError::SwcEmpty)
    } else {
        Ok(samples)
    }
}

fn read_sample(line: usize, text: &str) -> Result<Sample, TreeError> {
    // Further columns, which some programs add, are passed over; so is a comment behind the node.
    let mut fields = text
        .split('#')
        .next()
        .unwrap_or_default()
        .split_ascii_whitespace();
    let mut field = |name: &str| {
        fields.next().ok_or_else(|| {
            problem(
                line,
                format!("ends before the {name}: a node is `id type x y z radius parent`"),
            )
        })
    };
    let id = whole_number(line, "id", field("id")?)?;
    let kind = whole_number(line, "type", field("type")?)?;
    let kind = u32::try_from(kind)
        .ok()
        .filter(|&kind| kind <= LARGEST_TYPE)
        .ok_or_else(|| {
            problem(
                line,
                format!("has the type {kind}: types run from 0 to {LARGEST_TYPE}"),
            )
        })?;
    let x = number(line, "x", field("x")?)?;
    let y = number(line, "y", field("y")?)?;
    let z = number(line, "z", field("z")?)?;
    let radius = number(line, "radius", field("radius")?)?;
    if radius < 0.0 {
        return Err(problem(
            line,
            format!("has the radius {radius}: give 0 or more"),
        ));
    }
    let parent = whole_number(line, "parent", field("parent")?)?;
    if id < 0 {
        return Err(problem(
            line,
            format!("has the id {id}: ids are 0 or more, −1 means no parent"),
        ));
    }
    Ok(Sample {
        id,
        kind,
        position: Vec3::new(x, y, z),
        radius,
        parent,
        line,
    })
}

fn whole_number(line: usize, name: &str, text: &str) -> Result<i64, TreeError> {
    text.parse().map_err(|_| {
        problem(
            line,
            format!(
                "has the {name} `{}`: it must be a whole number",
                shown(text)
            ),
        )
    })
}

fn number(line: usize, name: &str, text: &str) -> Result<f32, TreeError> {
    text.parse()
        .ok()
        .filter(|value: &f32| value.abs() <= LARGEST_COORDINATE)
        .ok_or_else(|| {
            problem(
                line,
                format!(
                    "has the {name} `{}`: it must be a number up to ±{LARGEST_COORDINATE:e}",
                    shown(text)
                ),
            )
        })
}

/// The start of a field, fit for a message.
fn shown(text: &str) -> String {
    text.chars()
        .take(24)
        .map(|c| if c.is_control() { '?' } else { c })
        .collect()
}

/// The index of each sample's parent, or [`NO_PARENT`].
fn resolve_parents(samples: &[Sample]) -> Result<Vec<u32>, TreeError> {
    let mut index_of = HashMap::with_capacity(samples.len());
    for (index, sample) in (0_u32..).zip(samples) {
        if let Some(first) = index_of.insert(sample.id, index) {
            let first = samples[first as usize].line;
            return Err(problem(
                sample.line,
                format!(
                    "uses the id {} of line {first} again: give each node an id of its own",
                    sample.id
                ),
            ));
        }
    }
    let parent_of = |sample: &Sample| {
        match sample.parent {
        -1 => Ok(NO_PARENT),
        parent => index_of
            .get(&parent)
            .copied()
            .ok_or_else(|| problem(sample.line, format!("names the parent {parent}, which the file does not hold: add it, or give −1 for a root"))),
    }
    };
    samples.iter().map(parent_of).collect()
}

/// All samples, each after its parent and otherwise in the order of the file.
fn parents_first(samples: &[Sample], parents: &[u32]) -> Result<Vec<u32>, TreeError> {
    #[derive(Clone, Copy, PartialEq)]
    enum State {
        Unseen,
        Waiting,
        Placed,
    }
    let mut state = vec![State::Unseen; samples.len()];
    let mut order = Vec::with_capacity(samples.len());
    let mut waiting = Vec::new();
    for start in (0_u32..).take(samples.len()) {
        // Climb down to what is placed already, then place the way back up. Each sample is climbed over once.
        let mut node = start;
        while node != NO_PARENT && state[node as usize] != State::Placed {
            if state[node as usize] == State::Waiting {
                let sample = &samples[node as usize];
                return Err(problem(
                    sample.line,
                    format!(
                        "is its own ancestor (id {}): break the circle by giving one node the parent −1",
                        sample.id
                    ),
                ));
            }
            state[node as usize] = State::Waiting;
            waiting.push(node);
            node = parents[node as usize];
        }
        while let Some(node) = waiting.pop() {
            state[node as usize] = State::Placed;
            order.push(node);
        }
    }
    Ok(order)
}

/// Sets branching orders: the axis goes on to the child with the longest way to a tip, other children are one order higher.
fn number_orders(tree: &mut Tree) {
    let nodes = tree.len();
    let mut way = vec![0.0_f64; nodes];
    let mut axis = vec![None; nodes];
    // Children stand after their parents: going backward every way is complete when it is used. `>=` lets the first child win.
    for node in (0..nodes).rev() {
        let parent = tree.parent[node];
        if parent == NO_PARENT {
            continue;
        }
        let below = parent as usize;
        let [from, to] = [below, node].map(|node| tree.position[node].as_dvec3());
        let whole = way[node] + from.distance(to);
        if axis[below].is_none() || whole >= way[below] {
            way[below] = whole;
            axis[below] = Some(node);
        }
    }
    for node in 0..nodes {
        let parent = tree.parent[node];
        if parent != NO_PARENT {
            let order = tree.order[parent as usize];
            let is_axis = axis[parent as usize] == Some(node);
            tree.order[node] = if is_axis {
                order
            } else {
                order.saturating_add(1)
            };
        }
    }
}

/// The letter's name for a structure type (<https://swc-specification.readthedocs.io>).
fn type_name(kind: u32) -> String {
    match kind {
        0 => "undefined".into(),
        1 => "soma".into(),
        2 => "axon".into(),
        3 => "basal".into(),
        4 => "apical".into(),
        kind => format!("type{kind}"),
    }
}
