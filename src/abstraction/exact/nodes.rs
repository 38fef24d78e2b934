//! A module that makes segments and itself again, smaller or not: `A(l) -> F(l) [ +(40) A(l*0.6) ] [ +(-40) A(l*0.6) ] F(l) A(l*0.6)`.
//!
//! The whole tree is the template with a part of one kind at each of its buds; that part is the template with a part of another kind there, and so on
//! until nothing stands there any more (node rewriting, Prusinkiewicz and Lindenmayer 1990, 1.4.2). So the template is what is left of
//! the whole where all parts of one kind are cut off: each kind that is found near the root is tried.

use std::sync::atomic::{AtomicBool, Ordering};

use super::Written;
use super::level::{Kinds, Level, short, turn};
use super::out::{Out, Size};
use super::template::{SEGMENTS_MOST, Template};

/// The module.
const BUD: &str = "A";
/// No copy grows from a bud.
const NOTHING: u32 = u32::MAX;

/// The smallest grammar of one production that makes a module again; none where no such draws the tree. Numbers are alike that are no farther
/// `apart`, radians and logarithms.
pub(super) fn rewritten(
    level: &Level,
    kinds: &Kinds,
    width: f64,
    apart: f64,
    cancel: &AtomicBool,
) -> Option<Written> {
    let roots = level.children.of(0).to_vec();
    let first = *roots.first()?;
    let mut tried = vec![kinds.of[first as usize]];
    let mut near = vec![first];
    let mut at = 0;
    let mut best: Option<Written> = None;
    while let Some(node) = near.get(at).copied() {
        at += 1;
        if near.len() < 2 * SEGMENTS_MOST {
            near.extend_from_slice(level.children.of(node));
        }
        let kind = kinds.of[node as usize];
        if tried.contains(&kind) || cancel.load(Ordering::Relaxed) {
            continue;
        }
        tried.push(kind);
        let is_bud = |node: u32| kinds.of[node as usize] == kind;
        let Some(template) = Template::of(level, first, is_bud) else {
            continue;
        };
        let Some((copies, steps)) = copies(&template, level, &roots, apart) else {
            continue;
        };
        let (text, size) = written(&template, level, &roots, steps, width, apart);
        if best
            .as_ref()
            .is_none_or(|best| size.symbols() < best.2.symbols())
        {
            best = Some((text, order(&template, &copies, roots.len()), size));
        }
    }
    best
}

/// The nodes or, at buds, the copies that grow there, of each copy of a template that a tree is made of, the roots' first; and how many steps make
/// it. None where it is not so made.
fn copies(
    template: &Template,
    level: &Level,
    roots: &[u32],
    apart: f64,
) -> Option<(Vec<u32>, u32)> {
    let steps = depth(template, level, *roots.first()?, apart)?;
    let mut begins: Vec<(u32, u32)> = roots.iter().map(|root| (*root, steps)).collect();
    let mut copies = Vec::with_capacity(level.segments());
    let mut rest = Vec::new();
    let mut at = 0;
    while let Some((first, left)) = begins.get(at).copied() {
        at += 1;
        let base = copies.len();
        copies.resize(base + template.len(), NOTHING);
        copies[base] = first;
        for place in 0..template.len() {
            if template.is_bud[place] {
                continue;
            }
            let node = copies[base + place];
            rest.clear();
            rest.extend_from_slice(level.children.of(node));
            for child in template.children(place) {
                let child = *child as usize;
                if template.is_bud[child] && left == 1 {
                    continue;
                }
                let meant = template.stance[child];
                let is_it = |one: &u32| level.stance(*one, node).is_like(meant, apart);
                let found = rest.remove(rest.iter().position(is_it)?);
                copies[base + child] = found;
                if template.is_bud[child] {
                    copies[base + child] = u32::try_from(begins.len()).ok()?;
                    begins.push((found, left - 1));
                }
            }
            if !rest.is_empty() {
                return None;
            }
        }
    }
    Some((copies, steps))
}

/// How many copies grow from each other, by the first bud of each.
fn depth(template: &Template, level: &Level, first: u32, apart: f64) -> Option<u32> {
    let bud = template.is_bud.iter().position(|is_bud| *is_bud)?;
    let mut way = vec![bud];
    while let Some(before) = way.last().filter(|place| **place > 0) {
        way.push(template.parent[*before] as usize);
    }
    let mut at = first;
    let mut depth = 1;
    loop {
        for place in way.iter().rev().skip(1) {
            let meant = template.stance[*place];
            let is_it = |one: &&u32| level.stance(**one, at).is_like(meant, apart);
            match level.children.of(at).iter().find(is_it) {
                Some(child) => at = *child,
                // Within a template nothing may be missing, which is seen where copies are looked at.
                None => return Some(depth),
            }
        }
        depth += 1;
    }
}

/// The nodes in the order in which they are drawn.
fn order(template: &Template, copies: &[u32], roots: usize) -> Vec<u32> {
    let drawn: Vec<usize> = template.drawn().iter().map(|(place, ..)| *place).collect();
    let mut order = vec![0];
    let mut open: Vec<(usize, usize)> = (0..roots).rev().map(|copy| (copy, 0)).collect();
    while let Some((copy, at)) = open.pop() {
        let Some(place) = drawn.get(at) else { continue };
        open.push((copy, at + 1));
        match copies[copy * template.len() + place] {
            NOTHING => {}
            copy if template.is_bud[*place] => open.push((copy as usize, 0)),
            node => order.push(node),
        }
    }
    order
}

fn written(
    template: &Template,
    level: &Level,
    roots: &[u32],
    steps: u32,
    width: f64,
    apart: f64,
) -> (String, Size) {
    let mut out = Out::default();
    out.raw(&format!("steps {steps}\naxiom"));
    out.module("!", &[width.to_string()]);
    for root in roots {
        let is_last = roots.last() == Some(root);
        if !is_last {
            out.module("[", &[]);
        }
        let (degrees, length) = short(level.placed(*root), apart);
        turn(&mut out, degrees);
        out.module(BUD, &[length.to_string()]);
        if !is_last {
            out.module("]", &[]);
        }
    }
    out.head(BUD, &["l"], None);
    template.write(&mut out, BUD, apart);
    out.finish()
}
