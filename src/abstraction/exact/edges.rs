//! Edges that are all rewritten by one production, as often as that goes: `F(l) -> F(l) [ +(30) F(l) ] F(l) [ -(30) F(l) ] F(l)`.
//!
//! Such a tree is a coarser one with each segment replaced by a smaller tree, the template, at whose *end* it goes on; the coarser one is another such tree,
//! until nothing is left but what the axiom says (Prusinkiewicz and Lindenmayer 1990, 1.4.1). A tip of the coarser tree is the template and
//! nothing more, so templates are among the parts that are equal by hashing; each is tried with each of its nodes as the end, and undone
//! everywhere, from the root on, or not at all.

use std::sync::atomic::{AtomicBool, Ordering};

use super::Written;
use super::axiom::Axiom;
use super::level::{Kinds, Level, short};
use super::out::{Out, Size};
use super::plan::{Plan, Word};
use super::template::{SEGMENTS_MOST, Template};
use crate::tree::NO_PARENT;

/// Templates that are tried, the smallest first.
const TEMPLATES: usize = 24;

/// Nodes whose parts may be templates, one of each kind, the smallest first.
fn candidates(level: &Level, kinds: &Kinds) -> Vec<u32> {
    let segments = |node: &u32| kinds.segments[*node as usize];
    let fits = |node: &u32| {
        let own = segments(node);
        (2..=SEGMENTS_MOST).contains(&own) && level.segments().is_multiple_of(own)
    };
    let mut found: Vec<u32> = kinds.first.iter().copied().filter(fits).collect();
    found.sort_by_key(segments);
    found.truncate(TEMPLATES);
    found
}

/// The level of which another is made by replacing each segment, and for each of its segments those that replaced it; none where it is not so made.
fn undone(template: &Template, level: &Level, apart: f64) -> Option<(Level, Vec<u32>)> {
    let (mut parent, mut turn, mut length) = (vec![NO_PARENT], vec![[0.0; 2]], vec![0.0]);
    let mut made = Vec::with_capacity(level.segments());
    let mut open: Vec<(u32, u32)> = Vec::new();
    open.extend(level.children.of(0).iter().rev().map(|node| (*node, 0)));
    let mut rest = Vec::new();
    while let Some((first, before)) = open.pop() {
        let own = u32::try_from(parent.len()).ok()?;
        parent.push(before);
        turn.push(level.turn[first as usize]);
        length.push(level.length[first as usize]);
        let base = made.len();
        made.resize(base + template.len(), 0);
        made[base] = first;
        for place in 0..template.len() {
            let node = made[base + place];
            rest.clear();
            rest.extend_from_slice(level.children.of(node));
            for child in template.children(place) {
                let meant = template.stance[*child as usize];
                let is_it = |one: &u32| level.stance(*one, node).is_like(meant, apart);
                made[base + *child as usize] = rest.remove(rest.iter().position(is_it)?);
            }
            if Some(place) == template.end {
                open.extend(rest.drain(..).rev().map(|node| (node, own)));
            } else if !rest.is_empty() {
                return None;
            }
        }
    }
    Some((Level::new(parent, turn, length), made))
}

/// The smallest grammar of one production that rewrites all segments; none where no such draws the tree. Numbers are alike that are no farther `apart`,
/// radians and logarithms.
pub(super) fn rewritten(
    finest: &Level,
    kinds: &Kinds,
    width: f64,
    apart: f64,
    cancel: &AtomicBool,
) -> Option<Written> {
    let mut best: Option<Written> = None;
    for first in candidates(finest, kinds) {
        let Some(mut template) = Template::of(finest, first, |_| false) else {
            continue;
        };
        let stances = template.stance.clone();
        for end in 0..template.len() {
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
            (template.end, template.stance) = (Some(end), stances.clone());
            let Some((coarser, made)) = undone(&template, finest, apart) else {
                continue;
            };
            template.fitted(finest, &made);
            let mut levels = vec![(coarser, made)];
            while let Some(next) = undone(&template, &levels[levels.len() - 1].0, apart) {
                levels.push(next);
            }
            let (text, size) = written(
                &template,
                &levels[levels.len() - 1].0,
                levels.len(),
                width,
                apart,
            );
            let is_smaller = |best: &Written| size.symbols() < best.2.symbols();
            if best.as_ref().is_none_or(is_smaller) {
                let order = order(&template, &levels);
                best = Some((text, order, size));
            }
        }
    }
    best
}

/// The nodes of the finest level in the order in which they are drawn.
fn order(template: &Template, levels: &[(Level, Vec<u32>)]) -> Vec<u32> {
    let Some((coarsest, _)) = levels.last() else {
        return Vec::new();
    };
    let drawn: Vec<usize> = template.drawn().iter().map(|(place, ..)| *place).collect();
    let mut order: Vec<u32> = (1..).take(coarsest.segments()).collect();
    for (_, made) in levels.iter().rev() {
        let parts = order.iter().flat_map(|segment| {
            let base = (*segment as usize - 1) * template.len();
            drawn.iter().map(move |place| made[base + place])
        });
        order = parts.collect();
    }
    order.insert(0, 0);
    order
}

/// The grammar: an axiom for the coarsest level, and the production that makes the finest of it in so many steps.
fn written(
    template: &Template,
    axiom: &Level,
    steps: usize,
    width: f64,
    apart: f64,
) -> (String, Size) {
    let mut plan = Plan::default();
    plan.words.push(Word::Width(width));
    let mut open = vec![(0, false)];
    while let Some((node, closes)) = open.pop() {
        if closes {
            plan.words.push(Word::Pop);
            continue;
        }
        let children = axiom.children.of(node);
        if node != 0 {
            let ([yaw, pitch], length) = short(axiom.placed(node), apart);
            let siblings = axiom.children.of(axiom.parent[node as usize]);
            if siblings.last() != Some(&node) {
                plan.words.push(Word::Push);
            }
            plan.words.push(Word::Segment { yaw, pitch, length });
        }
        for child in children.iter().rev() {
            if children.last() != Some(child) {
                open.push((*child, true));
            }
            open.push((*child, false));
        }
    }
    let mut out = Out::default();
    let steps = u32::try_from(steps).unwrap_or(u32::MAX);
    Axiom::new(&plan, false, false).write(&mut out, steps, 0, &mut |_, _, _, _| {});
    out.head("F", &["l"], None);
    template.write(&mut out, "F", apart);
    out.finish()
}
