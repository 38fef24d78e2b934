//! What a derivation takes from the machine at most, by an allocator that adds up: little more than its last two strings.

#![allow(clippy::unwrap_used, reason = "a test that fails shows the line")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use ramus::lsystem::{Grammar, Limits};

/// Bytes given out, and the most so far, on all threads.
static NOW: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

struct Adding;

fn more(bytes: usize) {
    let now = NOW.fetch_add(bytes, Ordering::Relaxed) + bytes;
    MOST.fetch_max(now, Ordering::Relaxed);
}

fn less(bytes: usize) {
    NOW.fetch_sub(bytes, Ordering::Relaxed);
}

// SAFETY: hands every call on to the system's allocator unchanged.
unsafe impl GlobalAlloc for Adding {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        more(layout.size());
        // SAFETY: the caller's promise is passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        more(layout.size());
        // SAFETY: the caller's promise is passed on.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        less(layout.size());
        // SAFETY: the caller's promise is passed on.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        more(size);
        less(layout.size());
        // SAFETY: the caller's promise is passed on.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Adding = Adding;

/// The systems of the benchmark, some a few steps shorter. Strings of up to a million modules of which most rests are an exception: the list of
/// active modules trades their memory for time. Contexts across branches (`hh`) are
/// another, and left out: their index is 8 bytes a module, four times what a string without parameters takes.
#[test]
fn a_derivation_takes_little_more_than_its_last_two_strings() {
    let signal = format!("axiom b{}\nb < a -> b\nb -> a\n", "a".repeat(1 << 20));
    let cells: String = (0..1_u32 << 16)
        .map(|i| format!("C({})", i.count_ones()))
        .collect();
    let diffuse = format!("axiom {cells}\nC(l) < C(x) > C(r) : x>=0 -> C(x+0.25*(l+r-2*x))\n");
    let honda = include_str!("../assets/grammars/honda.lsys");
    for (name, text, steps, most) in [
        ("algae", "axiom b\na -> ab\nb -> a\n", 30, 1.1),
        (
            "bush",
            "axiom A\nA -> [&FL!A]/////'[&FL!A]///////'[&FL!A]\nF -> S/////F\nS -> FL\nL -> ['''^^{-f+f+f-|-f+f+f}]\n",
            9,
            1.1,
        ),
        (
            "stoch",
            "axiom F\nF : weight 0.33 -> F[+F]F[-F]F\nF : weight 0.33 -> F[+F]F\nF : weight 0.34 -> F[-F]F\n",
            10,
            1.6,
        ),
        ("honda", honda, 15, 1.3),
        (
            "row",
            "axiom F(1,0)\nF(x,t) : t==0 -> F(x*0.3,2)+F(x*0.46,1)--F(x*0.46,1)+F(x*0.7,0)\nF(x,t) : t>0 -> F(x,t-1)\n",
            16,
            1.3,
        ),
        ("signal", &signal, 5, 2.2),
        ("diffuse", &diffuse, 3, 2.2),
    ] {
        let grammar = Grammar::parse(text, name).unwrap();
        let never = AtomicBool::new(false);
        let before = NOW.load(Ordering::Relaxed);
        MOST.store(before, Ordering::Relaxed);
        let string = grammar.derive(steps, &Limits::default(), &never).unwrap();
        let taken = MOST.load(Ordering::Relaxed) - before;
        let ratio = taken as f64 / string.bytes() as f64;
        assert!(
            ratio <= most,
            "{name}: {taken} bytes, {ratio} times its {} bytes",
            string.bytes()
        );
    }
}
