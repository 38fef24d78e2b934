//! What the symbols of each program's turtle are in ours.
//!
//! Sources: cpfg's manual (section «Turtle interpretation of symbols») and the program's own turtle; L-Py's help card and the turtle of
//! PlantGL; the help page of Houdini's L-System node, «Turtle command reference».

use super::Dialect;

/// A parameter in what a symbol is drawn as.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Argument {
    /// The module's own parameter of this number, multiplied.
    Own(usize, f64),
    /// The quotient of 1 and the parameter.
    Inverse(usize),
    /// A draw between minus the parameter and the parameter, in degrees.
    Around(usize),
    /// A text that is an expression.
    Fixed(&'static str),
}

/// What a symbol is drawn as: our symbols with their parameters.
pub(super) type Drawn = &'static [(&'static str, &'static [Argument])];

/// What a symbol with a number of parameters is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Meaning {
    /// A module of the grammar's own that no turtle knows.
    Own,
    /// The same under the name of our notation.
    Same(&'static str),
    /// The same with the parameters in another order: for each of ours the number of theirs.
    Reordered(&'static str, &'static [usize]),
    /// A declared module that an interpretation draws. If the first name is there, the module keeps that name where each module is interpreted once.
    Drawn {
        symbol: Option<&'static str>,
        word: &'static str,
        drawn: Drawn,
    },
    /// A declared module that draws nothing; the text says what is missing then, if anything is.
    Nothing {
        word: &'static str,
        missing: Option<&'static str>,
    },
    /// It would change the string.
    Refused(&'static str),
}

use Argument::{Around, Fixed, Inverse, Own as P};
use Meaning::{Drawn as D, Nothing, Own, Refused, Reordered, Same};

pub(super) fn of(dialect: Dialect, key: &str, arity: usize) -> Meaning {
    match dialect {
        Dialect::Cpfg => cpfg(key, arity),
        Dialect::Lpy => lpy(key, arity),
        Dialect::Houdini => houdini(key, arity),
    }
}

const fn nothing(word: &'static str, missing: &'static str) -> Meaning {
    Nothing {
        word,
        missing: Some(missing),
    }
}

const fn drawn(word: &'static str, drawn: Drawn) -> Meaning {
    D {
        symbol: None,
        word,
        drawn,
    }
}

/// Symbols that all have in common.
fn common(key: &str) -> Option<&'static str> {
    [
        "F", "f", "+", "-", "&", "^", "|", "[", "]", "{", "}", ".", "%", "@Ge",
    ]
    .into_iter()
    .find(|known| *known == key)
}

/// Signs that no turtle of these programs knows.
fn unknown_sign(key: &str) -> Meaning {
    let word = match key {
        "'" => "Prime",
        "\"" => "Quote",
        "`" => "Backquote",
        "_" => "Underscore",
        "=" => "Equals",
        "@" => "At",
        "#" => "Hash",
        "$" => "Dollar",
        "~" => "Tilde",
        "?" => "Question",
        "*" => "Star",
        "," => "Comma",
        ";" => "Semicolon",
        "/" => "Slash",
        _ => return Own,
    };
    Nothing {
        word,
        missing: None,
    }
}

const COLOUR: Drawn = &[("'", &[P(0, 1.0)])];
const WIDTH: Drawn = &[("!", &[P(0, 1.0)])];
const WIDTH_OF_RADIUS: Drawn = &[("!", &[P(0, 2.0)])];

fn cpfg(key: &str, arity: usize) -> Meaning {
    match (key, arity) {
        ("%", 1..) => {
            Refused("a cut with parameters keeps the branch elsewhere in cpfg; expected `%` alone")
        }
        ("{" | "}" | ".", 1..) => match key {
            "{" => nothing(
                "SplineBegin",
                "surfaces and cylinders from splines, `{(n)`, are not drawn",
            ),
            "}" => nothing(
                "SplineEnd",
                "surfaces and cylinders from splines, `{(n)`, are not drawn",
            ),
            _ => nothing(
                "SplinePoint",
                "surfaces and cylinders from splines, `{(n)`, are not drawn",
            ),
        },
        ("!", 0) => nothing(
            "Narrow",
            "`!` without a parameter changes the width by the view file's `line width increment`; here it does nothing",
        ),
        ("#", 0) => nothing(
            "Widen",
            "`#` without a parameter changes the width by the view file's `line width increment`; here it does nothing",
        ),
        ("!", _) => Same("!"),
        ("#", _) => drawn("Widen", WIDTH),
        ("G" | "g" | "?P" | "?H" | "?L" | "@Gs", _) => Same(match key {
            "G" => "G",
            "g" => "g",
            "?P" => "?P",
            "?H" => "?H",
            "?L" => "?L",
            _ => "@Gs",
        }),
        // cpfg's frame is left-handed: its rolls are the other way.
        ("/", _) => Same("\\"),
        ("\\", _) => Same("/"),
        (";", _) => Same("'"),
        (",", _) => Same(","),
        ("@v", _) => Same("$"),
        // A diameter, where ours is a radius.
        ("@O", 1..) => D {
            symbol: Some("@O"),
            word: "Sphere",
            drawn: &[("@O", &[P(0, 0.5)])],
        },
        ("@O", 0) => Same("@O"),
        ("@Gc", _) => nothing(
            "ControlPoint",
            "`@Gc`: control points of generalized cylinders; the cylinder follows each segment",
        ),
        ("@c" | "@o" | "@bo" | "@bc", _) => nothing("Circle", "circles are not drawn"),
        ("@L", _) => nothing("Label", "labels are not drawn"),
        ("@S", _) => nothing("Shell", "commands to the system are not given"),
        ("@PS" | "@PC" | "@PD", _) => nothing("Patch", "surface patches are not drawn"),
        ("@Tx", _) => nothing("Texture", "textures are not drawn"),
        ("@Ti" | "@Td" | "@Ts" | "@Tp" | "@Tf", _) => nothing(
            "Tropism",
            "tropisms stand in the view file; state `tropism x y z` and use `T(e)`",
        ),
        ("@R", _) => nothing("SetHeading", "`@R`: the turtle keeps its own heading"),
        ("@M", _) => nothing("MoveTo", "`@M`: the turtle keeps its own position"),
        ("@mo" | "@Di" | "@Dd" | "@Ds", _) => {
            nothing("Object", "objects and scales, `@m` and `@D`, are not drawn")
        }
        ("@,", _) | ("@;", _) => nothing(
            "BackColour",
            "colours of the back of surfaces are not drawn",
        ),
        ("@mc", _) => Refused(
            "the conditional cut `@mc` cannot be carried over; expected a production that makes `%`",
        ),
        ("?" | "$", _) => {
            Refused("sub-L-systems cannot be carried over; expected one L-system in the file")
        }
        _ if key.starts_with('?') => {
            Refused("this query cannot be answered; expected `?P`, `?H` or `?L`")
        }
        _ => shared(key),
    }
}

fn lpy(key: &str, arity: usize) -> Meaning {
    match (key, arity) {
        ("F", 2..) => D {
            symbol: Some("F"),
            word: "Frustum",
            drawn: &[("!", &[P(1, 2.0)]), ("F", &[P(0, 1.0)])],
        },
        ("nF", 2) => drawn("nF", &[("F", &[P(0, 1.0)])]),
        ("nF", 3) => drawn("nF", &[("!", &[P(2, 2.0)]), ("F", &[P(0, 1.0)])]),
        ("nF", _) => nothing("nF", "paths of changing width, `nF`, are not drawn"),
        ("/", _) => Same("/"),
        ("\\", _) => Same("\\"),
        ("iRollL" | "iRollR", _) => nothing(
            "IntrinsicRoll",
            "`iRollL` and `iRollR` do not turn the turtle",
        ),
        ("@v", _) => Same("$"),
        // A radius, where ours is a diameter.
        ("!", 1..) => D {
            symbol: Some("!"),
            word: "DecWidth",
            drawn: WIDTH_OF_RADIUS,
        },
        ("_", 1..) => drawn("IncWidth", WIDTH_OF_RADIUS),
        ("SetWidth", 1..) => drawn("SetWidth", WIDTH_OF_RADIUS),
        ("!", 0) => nothing(
            "DecWidth",
            "`!` without a parameter takes L-Py's width increment off, a setting of its viewer; here it does nothing",
        ),
        ("_", 0) => nothing(
            "IncWidth",
            "`_` without a parameter adds L-Py's width increment, a setting of its viewer; here it does nothing",
        ),
        (";", _) => Same("'"),
        (",", _) => Same(","),
        ("SetColor", 1) => drawn("SetColor", COLOUR),
        ("SetColor" | "InterpolateColors", _) => nothing(
            "SetColor",
            "colours of red, green and blue are not carried over; use one of the numbered colours",
        ),
        ("@O", _) => Same("@O"),
        ("@Gc", _) => Same("@Gs"),
        // L-Py's axes x, y, z are our z, x, y, since it grows along z.
        ("?P", 3) => Reordered("?P", &[1, 2, 0]),
        ("?H", 3) => Reordered("?H", &[1, 2, 0]),
        ("?U", 3) => Reordered("?U", &[1, 2, 0]),
        ("?L", 3) => Reordered("?L", &[1, 2, 0]),
        ("@Ts", _) => nothing(
            "Elasticity",
            "L-Py's tropism; state `tropism x y z` and use `T(e)`",
        ),
        ("@Tp", _) => nothing(
            "Tropism",
            "L-Py's tropism; state `tropism x y z` and use `T(e)`",
        ),
        ("@D" | "@Dd" | "@Di", _) => {
            nothing("Scale", "the scale of what is drawn is left as it is")
        }
        (
            "@M" | "MoveRel" | "LineTo" | "OLineTo" | "LineRel" | "OLineRel" | "Pinpoint"
            | "PinpointRel" | "@R" | "EulerAngles",
            _,
        ) => nothing(
            "Place",
            "positions and directions in space: the turtle goes on from where it is",
        ),
        ("LeftReflection" | "UpReflection" | "HeadingReflection", _) => {
            nothing("Reflection", "reflections of the turtle's frame")
        }
        ("@o" | "@B" | "@b" | "@L" | "@g" | "Frame" | "surface" | "~", _) => nothing(
            "Draw",
            "circles, boxes, labels and PlantGL's geometry are not drawn",
        ),
        (
            "Sweep" | "SetContour" | "SectionResolution" | "SetGuide" | "EndGuide"
            | "PositionOnGuide",
            _,
        ) => nothing("Sweep", "sweeps, guides and cross-sections are not drawn"),
        (
            "TextureScale"
            | "TextureUScale"
            | "TextureVScale"
            | "TextureTranslation"
            | "TextureRotation"
            | "TextureTransformation",
            _,
        ) => nothing("Texture", "textures are not drawn"),
        ("@2D" | "@3D", _) => nothing("Screen", "drawing on the screen's plane"),
        ("new" | "*" | "x" | "or" | "?I" | "$" | "=]", _) => Refused(
            "L-Py's patterns and modules made by name cannot be carried over; expected modules by their names",
        ),
        _ if key.starts_with('?') => Refused(
            "this query cannot be answered; expected `?P`, `?H`, `?U` or `?L` with three parameters",
        ),
        _ => shared(key),
    }
}

fn houdini(key: &str, arity: usize) -> Meaning {
    match (key, arity) {
        // Houdini turns right with `+`.
        ("+", _) => Same("-"),
        ("-", _) => Same("+"),
        ("/", _) => Same("/"),
        ("\\", _) => Same("\\"),
        ("*", _) => drawn("Flip", &[("/", &[Fixed("180")])]),
        ("~", 0) => drawn(
            "Shake",
            &[
                ("&", &[Fixed("uniform(-180, 180)")]),
                ("/", &[Fixed("uniform(-180, 180)")]),
                ("-", &[Fixed("uniform(-180, 180)")]),
            ],
        ),
        ("~", _) => drawn(
            "Shake",
            &[
                ("&", &[Around(0)]),
                ("/", &[Around(0)]),
                ("-", &[Around(0)]),
            ],
        ),
        ("H", 0) => drawn(
            "Half",
            &[("@l", &[Fixed("0.5")]), ("F", &[]), ("@l", &[Fixed("2")])],
        ),
        ("H", _) => drawn("Half", &[("F", &[P(0, 0.5)])]),
        ("h", 0) => drawn(
            "Hop",
            &[("@l", &[Fixed("0.5")]), ("f", &[]), ("@l", &[Fixed("2")])],
        ),
        ("h", _) => drawn("Hop", &[("f", &[P(0, 0.5)])]),
        ("\"", 0) => drawn("Longer", &[("@l", &[Fixed("step_size_scale")])]),
        ("\"", _) => drawn("Longer", &[("@l", &[P(0, 1.0)])]),
        ("_", 0) => drawn("Shorter", &[("@l", &[Fixed("1/step_size_scale")])]),
        ("_", _) => drawn("Shorter", &[("@l", &[Inverse(0)])]),
        (";", 0) => drawn("Wider", &[("@a", &[Fixed("angle_scale")])]),
        (";", _) => drawn("Wider", &[("@a", &[P(0, 1.0)])]),
        ("@", 0) => drawn("Narrower", &[("@a", &[Fixed("1/angle_scale")])]),
        ("@", _) => drawn("Narrower", &[("@a", &[Inverse(0)])]),
        ("!", 0) => drawn("Thicker", &[("@w", &[Fixed("thickness_scale")])]),
        ("!", _) => drawn("Thicker", &[("@w", &[P(0, 1.0)])]),
        ("?", 0) => drawn("Thinner", &[("@w", &[Fixed("1/thickness_scale")])]),
        ("?", _) => drawn("Thinner", &[("@w", &[Inverse(0)])]),
        // Where the turtle starts, from the node's Values.
        ("step size", _) => drawn("StepSize", &[("@l", &[P(0, 1.0)])]),
        ("thickness", _) => drawn("Thickness", WIDTH),
        ("G", _) => Same("G"),
        ("J", _) => Same("~J"),
        ("K", _) => Same("~K"),
        ("M", _) => Same("~M"),
        ("$", 0) => Same("$"),
        ("$", _) => nothing(
            "PointAt",
            "`$(x,y,z)`: the turtle does not turn toward a point",
        ),
        ("T", _) => nothing(
            "Gravity",
            "gravity, `T(g)`, does not bend the turtle; state `tropism 0 -1 0` and use `T(e)`",
        ),
        ("g", _) => nothing("Group", "groups, `g(i)`: all is one tree"),
        ("a", _) => nothing("Attribute", "attributes of points, `a(…)`"),
        ("'" | "#", _) => nothing(
            "UvIncrement",
            "colours by texture coordinates, `'(u)` and `#(v)`",
        ),
        ("@Ge", _) => Own,
        _ => shared(key),
    }
}

fn shared(key: &str) -> Meaning {
    common(key).map_or_else(|| unknown_sign(key), Same)
}
