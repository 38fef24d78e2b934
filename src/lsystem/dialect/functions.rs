//! Functions and named values of each program, said in ours.

use std::rc::Rc;

use super::Dialect;
use super::expression::{Binary, Expr, Kind, Node};
use super::text::Fault;

/// Degrees of a radian, and radians of a degree.
const DEGREES: &str = "57.29577951308232";
const RADIANS: &str = "0.017453292519943295";

/// Names that Python's `from math import *` brings, where a file gives them no other value.
pub(super) const PYTHON_CONSTANTS: [(&str, &str); 2] = [("pi", PI), ("e", E)];
const PI: &str = "3.141592653589793";
const E: &str = "2.718281828459045";

/// A function's value.
pub(super) fn call(dialect: Dialect, at: usize, name: &str, list: &[Expr]) -> Result<Expr, Fault> {
    let found = match dialect {
        Dialect::Lpy => python(at, name, list)?,
        Dialect::Cpfg => cpfg(at, name, list)?,
        Dialect::Houdini => houdini(at, name, list)?,
    };
    found.ok_or_else(|| {
        let name: String = name.chars().take(40).collect();
        let count = list.len();
        let s = if count == 1 { "" } else { "s" };
        Fault::new(
            at,
            format!("the function `{name}` with {count} argument{s} cannot be carried over"),
        )
    })
}

/// A named value: most names are the grammar's own.
pub(super) fn name(dialect: Dialect, at: usize, name: String) -> Result<Expr, Fault> {
    if dialect == Dialect::Lpy {
        let value = match name.as_str() {
            "True" => Some("1"),
            "False" => Some("0"),
            "math.pi" | "numpy.pi" | "np.pi" => Some(PI),
            "math.e" => Some(E),
            _ => None,
        };
        if let Some(value) = value {
            return Node::number(at, value);
        }
        if name.contains('.') || name == "None" {
            let name: String = name.chars().take(40).collect();
            return Err(Fault::new(
                at,
                format!("`{name}` is a Python object, which cannot be carried over"),
            ));
        }
    }
    // Our conditions begin with this word where they are weights.
    let name = if name == "weight" {
        "weight_".to_owned()
    } else {
        name
    };
    Node::make(at, Kind::Name(name))
}

/// `a % b`, which keeps the sign of `a` in our notation.
pub(super) fn remainder(dialect: Dialect, at: usize, a: &Expr, b: &Expr) -> Result<Expr, Fault> {
    match dialect {
        Dialect::Houdini => Node::binary(at, Binary::Remainder, a, b),
        // Of whole numbers only: what is behind the point is cut off first.
        Dialect::Cpfg => Node::binary(
            at,
            Binary::Remainder,
            &truncated(at, a)?,
            &truncated(at, b)?,
        ),
        // The sign of `b`.
        Dialect::Lpy => {
            let plain = Node::binary(at, Binary::Remainder, a, b)?;
            let zero = Node::number(at, "0")?;
            let turned = match positive(b) {
                true => Node::binary(at, Binary::Less, &plain, &zero)?,
                false => {
                    let product = Node::binary(at, Binary::Multiply, &plain, b)?;
                    Node::binary(at, Binary::Less, &product, &zero)?
                }
            };
            let more = Node::binary(at, Binary::Multiply, b, &turned)?;
            Node::binary(at, Binary::Add, &plain, &more)
        }
    }
}

fn positive(value: &Expr) -> bool {
    matches!(&value.kind, Kind::Number(text) if text.parse::<f64>().is_ok_and(|v| v > 0.0))
}

/// Without what is behind the point.
fn truncated(at: usize, value: &Expr) -> Result<Expr, Fault> {
    if let Kind::Number(text) = &value.kind
        && text.bytes().all(|b| b.is_ascii_digit())
    {
        return Ok(Rc::clone(value));
    }
    let size = Node::call(at, "abs", &[value])?;
    let floor = Node::call(at, "floor", &[&size])?;
    Node::binary(
        at,
        Binary::Multiply,
        &Node::call(at, "sign", &[value])?,
        &floor,
    )
}

/// Those that mean the same and have one argument.
fn same(name: &str) -> Option<&'static str> {
    ["sqrt", "exp", "log", "abs", "floor", "ceil"]
        .into_iter()
        .find(|known| *known == name)
}

fn python(at: usize, name: &str, list: &[Expr]) -> Result<Option<Expr>, Fault> {
    let name = ["math.", "random.", "numpy.", "np."]
        .iter()
        .find_map(|module| name.strip_prefix(module))
        .unwrap_or(name);
    let scaled =
        |value: &Expr, by: &str| Node::binary(at, Binary::Multiply, value, &Node::number(at, by)?);
    Ok(Some(match (name, list) {
        ("sin" | "cos" | "tan", [x]) => {
            let ours = match name {
                "sin" => "sin",
                "cos" => "cos",
                _ => "tan",
            };
            // sin(radians(x)) is our sin(x).
            match &x.kind {
                Kind::Binary(Binary::Multiply, inner, by) if matches!(&by.kind, Kind::Number(n) if n == RADIANS) => {
                    Node::call(at, ours, &[inner])?
                }
                _ => Node::call(at, ours, &[&scaled(x, DEGREES)?])?,
            }
        }
        ("asin", [x]) => scaled(&Node::call(at, "asin", &[x])?, RADIANS)?,
        ("acos", [x]) => scaled(&Node::call(at, "acos", &[x])?, RADIANS)?,
        ("atan", [x]) => scaled(&Node::call(at, "atan", &[x])?, RADIANS)?,
        ("atan2", [y, x]) => scaled(&Node::call(at, "atan2", &[y, x])?, RADIANS)?,
        ("radians", [x]) => scaled(x, RADIANS)?,
        ("degrees", [x]) => scaled(x, DEGREES)?,
        ("pow", [x, y]) => Node::binary(at, Binary::Power, x, y)?,
        ("fabs", [x]) => Node::call(at, "abs", &[x])?,
        ("int" | "trunc", [x]) => truncated(at, x)?,
        ("float", [x]) => Rc::clone(x),
        ("min" | "max", [first, rest @ ..]) if !rest.is_empty() => {
            let ours = if name == "min" { "min" } else { "max" };
            let mut value = Rc::clone(first);
            for next in rest {
                value = Node::call(at, ours, &[&value, next])?;
            }
            value
        }
        ("random", []) => Node::call(
            at,
            "uniform",
            &[&Node::number(at, "0")?, &Node::number(at, "1")?],
        )?,
        ("uniform", [a, b]) => Node::call(at, "uniform", &[a, b])?,
        ("randint", [a, b]) => Node::call(at, "integer", &[a, b])?,
        ("gauss" | "normalvariate", [m, s]) => Node::call(at, "normal", &[m, s])?,
        (_, [x]) => match same(name) {
            Some(ours) => Node::call(at, ours, &[x])?,
            None => return Ok(None),
        },
        _ => return Ok(None),
    }))
}

fn cpfg(at: usize, name: &str, list: &[Expr]) -> Result<Option<Expr>, Fault> {
    Ok(Some(match (name, list) {
        // cpfg computes in degrees too.
        ("sin", [x]) => Node::call(at, "sin", &[x])?,
        ("cos", [x]) => Node::call(at, "cos", &[x])?,
        ("tan", [x]) => Node::call(at, "tan", &[x])?,
        ("asin", [x]) => Node::call(at, "asin", &[x])?,
        ("acos", [x]) => Node::call(at, "acos", &[x])?,
        ("atan", [x]) => Node::call(at, "atan", &[x])?,
        ("sign", [x]) => Node::call(at, "sign", &[x])?,
        ("fabs", [x]) => Node::call(at, "abs", &[x])?,
        // It rounds, whatever its name says.
        ("trunc", [x]) => {
            let half = Node::number(at, "0.5")?;
            Node::call(at, "floor", &[&Node::binary(at, Binary::Add, x, &half)?])?
        }
        ("ran", [x]) => Node::call(at, "uniform", &[&Node::number(at, "0")?, x])?,
        ("nran", [m, s]) => Node::call(at, "normal", &[m, s])?,
        (_, [x]) if name != "abs" => match same(name) {
            Some(ours) => Node::call(at, ours, &[x])?,
            None => return Ok(None),
        },
        _ => return Ok(None),
    }))
}

fn houdini(at: usize, name: &str, list: &[Expr]) -> Result<Option<Expr>, Fault> {
    Ok(Some(match (name, list) {
        ("sin", [x]) => Node::call(at, "sin", &[x])?,
        ("cos", [x]) => Node::call(at, "cos", &[x])?,
        ("tan", [x]) => Node::call(at, "tan", &[x])?,
        ("asin", [x]) => Node::call(at, "asin", &[x])?,
        ("acos", [x]) => Node::call(at, "acos", &[x])?,
        ("atan", [x]) => Node::call(at, "atan", &[x])?,
        ("pow", [x, y]) => Node::binary(at, Binary::Power, x, y)?,
        ("min", [x, y]) => Node::call(at, "min", &[x, y])?,
        ("max", [x, y]) => Node::call(at, "max", &[x, y])?,
        ("int", [x]) => truncated(at, x)?,
        (_, [x]) => match same(name) {
            Some(ours) => Node::call(at, ours, &[x])?,
            None => return Ok(None),
        },
        _ => return Ok(None),
    }))
}
