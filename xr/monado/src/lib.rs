//! The real-runtime test stage.
