//! The room `sketch`.
