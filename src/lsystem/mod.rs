//! The room `lsystem`.
