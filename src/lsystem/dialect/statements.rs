//! The statements between cpfg's braces: assignments are carried over, other code is named.

use std::collections::HashMap;
use std::rc::Rc;

use super::cpfg::end_of;
use super::expression::{Expr, Node};
use super::model::{Model, Valued};
use super::reader::Reader;
use super::text::Fault;

/// Values of a production's own names.
pub(super) type Values = HashMap<String, Expr>;

pub(super) fn value_of(values: &Values, name: &str) -> Option<Expr> {
    values.get(name).map(Rc::clone)
}

pub(super) fn substitute(value: &Expr, values: &Values) -> Result<Expr, Fault> {
    Node::substitute(value, &|name| value_of(values, name))
}

/// What a statement is.
enum Statement {
    Assigned(usize, String, Expr),
    /// Prints, or reads and writes files.
    Printed,
}

fn statement(reader: &mut Reader<'_>, model: &mut Model) -> Result<Statement, Fault> {
    reader.skip_blank();
    let at = reader.pos();
    let code = || {
        Fault::new(
            at,
            "only assignments, `name = value;`, can be carried over; this is other code",
        )
    };
    let name = reader.word().ok_or_else(code)?.to_owned();
    if matches!(
        name.as_str(),
        "printf" | "fprintf" | "fopen" | "fclose" | "fflush" | "play" | "Display"
    ) {
        let rest = reader.rest();
        let length = rest.find([';', '\n']).unwrap_or(rest.len());
        reader.advance(length);
        reader.take(";");
        model.remark(at, "printing and files: nothing is printed");
        return Ok(Statement::Printed);
    }
    if !reader.take("=") || reader.rest().starts_with('=') {
        return Err(code());
    }
    let value = reader.expression()?;
    if !reader.take(";") {
        return Err(reader.expected("`;`"));
    }
    Ok(Statement::Assigned(at, name, value))
}

/// Assignments up to `}`, as values of names.
pub(super) fn assignments(
    reader: &mut Reader<'_>,
    model: &mut Model,
    values: &mut Values,
) -> Result<(), Fault> {
    while !reader.take("}") {
        if let Statement::Assigned(at, name, value) = statement(reader, model)? {
            if model.is_constant(&name) {
                return Err(Fault::new(
                    at,
                    format!(
                        "`{name}` is a variable of the whole grammar, and a production that changes it cannot be carried over"
                    ),
                ));
            }
            let value = substitute(&value, values)?;
            values.insert(name, value);
        }
    }
    Ok(())
}

pub(super) fn start_block(reader: &mut Reader<'_>, model: &mut Model) -> Result<(), Fault> {
    if !reader.take("{") {
        return Err(reader.expected("`{`"));
    }
    while !reader.take("}") {
        if let Statement::Assigned(at, name, value) = statement(reader, model)? {
            if model.is_constant(&name) {
                return Err(Fault::new(
                    at,
                    format!("`{name}` is given a value twice; expected a constant"),
                ));
            }
            model.constant(name, Valued { at, value });
        }
    }
    end_of(reader)
}

/// A block that may do nothing to the grammar.
pub(super) fn printing_block(
    reader: &mut Reader<'_>,
    at: usize,
    model: &mut Model,
) -> Result<(), Fault> {
    if !reader.take("{") {
        return Err(reader.expected("`{`"));
    }
    while !reader.take("}") {
        if let Statement::Assigned(..) = statement(reader, model)? {
            return Err(Fault::new(
                at,
                "variables that change from step to step cannot be carried over; hand them on as parameters of modules",
            ));
        }
    }
    end_of(reader)
}
