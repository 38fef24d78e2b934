//! Another program on the same runtime, that takes the focus away and gives it back.

use std::{
    io,
    process::{Child, Command, Stdio},
};

use crate::service::Service;

/// Khronos's sample `hello_xr`, as a second client of the runtime; killed when dropped.
#[derive(Debug)]
pub struct Rival(Child);

impl Rival {
    /// Its command. The validation layer's remarks about the sample are not ours to judge.
    pub fn command(service: &Service) -> Command {
        let mut command = service.command("hello_xr");
        command
            .args(["-g", "Vulkan2"])
            .env_remove("XR_ENABLE_API_LAYERS")
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::null());
        command
    }

    /// Starts it; it is a client of the runtime some frames later ([`Rival::is_there`]).
    ///
    /// # Errors
    /// Where the program cannot be started.
    pub fn start(service: &Service) -> io::Result<Self> {
        Self::command(service).spawn().map(Self)
    }

    /// Whether the runtime knows it.
    ///
    /// # Errors
    /// Where the runtime cannot be asked.
    pub fn is_there(service: &Service) -> io::Result<bool> {
        Ok(service.control(&[])?.contains("HelloXR"))
    }

    /// Brings it to the front. It is the runtime's second client, after the program under test.
    ///
    /// # Errors
    /// Where the runtime cannot be asked.
    pub fn take_focus(service: &Service) -> io::Result<()> {
        service.control(&["-f", "2"]).map(drop)
    }
}

impl Drop for Rival {
    fn drop(&mut self) {
        // Nothing is left to do where it has ended already.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
