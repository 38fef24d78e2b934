//! The runtime itself: `monado-service` with the null compositor and the remote driver, in folders of its own.

use std::{
    ffi::OsString,
    fs::{self, File, Permissions},
    io,
    net::TcpListener,
    os::unix::fs::PermissionsExt as _,
    path::{Path, PathBuf},
    process::{Child, Command, ExitStatus, Stdio},
    thread,
    time::{Duration, Instant},
};

use tempfile::TempDir;

use crate::verdict;

/// Where Debian and Ubuntu put Monado's manifest.
const MANIFEST: &str = "/usr/share/openxr/1/openxr_monado.json";

/// The socket that the service makes when it can be used.
const SOCKET: &str = "monado_comp_ipc";

/// How often a condition is looked at while waiting for it.
const LOOK_AGAIN: Duration = Duration::from_millis(20);

/// How the runtime is run.
#[derive(Clone, Debug)]
pub struct ServiceParams {
    /// How long the service may take to become usable (0.3–1.2 s on a quiet machine). A liveness guard.
    pub ready_within: Duration,
    /// How long it may take to end after it was asked to. A liveness guard.
    pub stopped_within: Duration,
    /// Environment of the service besides what [`Service::start`] sets, such as `XRT_LOG`.
    pub environment: Vec<(String, String)>,
}

impl Default for ServiceParams {
    fn default() -> Self {
        Self {
            ready_within: Duration::from_secs(30),
            stopped_within: Duration::from_secs(15),
            environment: Vec::new(),
        }
    }
}

/// Why the runtime cannot be used, or what was wrong with its run.
#[derive(Debug, thiserror::Error)]
pub enum ServiceError {
    /// A folder, file or port could not be had.
    #[error("cannot prepare a place for the runtime: {0}")]
    Place(#[from] io::Error),
    /// The program could not be started.
    #[error(
        "cannot start monado-service: {0}; run the test by xr/monado/enter.sh, where it is installed"
    )]
    Start(io::Error),
    /// It ended before it was ready.
    #[error("monado-service ended ({status}) before it was ready:\n{log}")]
    Ended {
        /// How it ended.
        status: ExitStatus,
        /// What it printed.
        log: String,
    },
    /// It did not become ready or did not end in time.
    #[error("monado-service did not {what} within {seconds} s:\n{log}")]
    Slow {
        /// What it should have done.
        what: &'static str,
        /// The time it had.
        seconds: u64,
        /// What it printed.
        log: String,
    },
    /// It, or a layer in it, found something wrong.
    #[error("the runtime complained:\n{complaints}")]
    Complaints {
        /// The lines.
        complaints: String,
    },
}

/// A running Monado; killed when dropped.
#[derive(Debug)]
pub struct Service {
    child: Child,
    folder: TempDir,
    port: u16,
    params: ServiceParams,
}

impl Service {
    /// Starts the runtime and waits until it can be used.
    ///
    /// # Errors
    /// [`ServiceError`] when it cannot be started or is not ready in time.
    pub fn start(params: ServiceParams) -> Result<Self, ServiceError> {
        let folder = tempfile::Builder::new().prefix("ramus-monado-").tempdir()?;
        let runtime = folder.path().join("runtime");
        fs::create_dir_all(&runtime)?;
        fs::set_permissions(&runtime, Permissions::from_mode(0o700))?;
        fs::create_dir_all(folder.path().join(CONFIG))?;
        let port = configure(folder.path())?;
        let child = spawn(folder.path(), &params)?;
        let mut service = Self {
            child,
            folder,
            port,
            params,
        };
        service.wait_until_ready()?;
        Ok(service)
    }

    fn wait_until_ready(&mut self) -> Result<(), ServiceError> {
        let socket = self.runtime_folder().join(SOCKET);
        let began = Instant::now();
        while !socket.exists() {
            if let Some(status) = self.child.try_wait()? {
                return Err(ServiceError::Ended {
                    status,
                    log: self.log(),
                });
            }
            self.in_time(began, self.params.ready_within, "become ready")?;
            thread::sleep(LOOK_AGAIN);
        }
        Ok(())
    }

    fn in_time(
        &self,
        began: Instant,
        limit: Duration,
        what: &'static str,
    ) -> Result<(), ServiceError> {
        if began.elapsed() < limit {
            return Ok(());
        }
        Err(ServiceError::Slow {
            what,
            seconds: limit.as_secs(),
            log: self.log(),
        })
    }

    /// The port of the remote driver on 127.0.0.1.
    pub fn port(&self) -> u16 {
        self.port
    }

    /// Everything that the service has printed so far.
    pub fn log(&self) -> String {
        fs::read(self.folder.path().join("service.log"))
            .map(|bytes| String::from_utf8_lossy(&bytes).into_owned())
            .unwrap_or_default()
    }

    fn runtime_folder(&self) -> PathBuf {
        self.folder.path().join("runtime")
    }

    /// The environment by which a program finds this runtime, with the OpenXR core-validation layer and the
    /// Vulkan validation that `ramus` offers switched on. The layer writes to [`Service::validation_log`].
    pub fn environment(&self) -> Vec<(&'static str, OsString)> {
        vec![
            ("XDG_RUNTIME_DIR", self.runtime_folder().into()),
            ("XDG_CONFIG_HOME", self.folder.path().join("config").into()),
            ("XR_RUNTIME_JSON", MANIFEST.into()),
            (
                "XR_ENABLE_API_LAYERS",
                "XR_APILAYER_LUNARG_core_validation".into(),
            ),
            ("XR_CORE_VALIDATION_EXPORT_TYPE", "text".into()),
            (
                "XR_CORE_VALIDATION_FILE_NAME",
                self.validation_file().into(),
            ),
            ("RAMUS_VALIDATION", "1".into()),
        ]
    }

    /// A command that finds this runtime.
    pub fn command(&self, program: impl AsRef<Path>) -> Command {
        let mut command = Command::new(program.as_ref());
        command.envs(self.environment());
        command
    }

    /// Gives the runtime an order by its own tool, or asks for its clients with none; gives what it says.
    ///
    /// # Errors
    /// Where the tool cannot be started.
    pub fn control(&self, arguments: &[&str]) -> io::Result<String> {
        let output = self
            .command("monado-ctl")
            .env_remove("XR_ENABLE_API_LAYERS")
            .args(arguments)
            .output()?;
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    }

    fn validation_file(&self) -> PathBuf {
        self.folder.path().join("validation.log")
    }

    /// What the core-validation layer has written of the programs run with [`Service::environment`].
    pub fn validation_log(&self) -> String {
        fs::read(self.validation_file())
            .map(|bytes| String::from_utf8_lossy(&bytes).into_owned())
            .unwrap_or_default()
    }

    /// Kills the runtime at once, as a crash would, and leaves the rest to the programs that use it.
    ///
    /// # Errors
    /// [`ServiceError::Place`] when the process cannot be killed.
    pub fn kill(&mut self) -> Result<(), ServiceError> {
        self.child.kill()?;
        self.child.wait()?;
        Ok(())
    }

    /// Starts the runtime again after it was killed, for the programs that found it where it was. Its remote driver has another
    /// port: the old one may not be free yet.
    ///
    /// # Errors
    /// As [`Service::start`].
    pub fn start_again(&mut self) -> Result<(), ServiceError> {
        self.kill()?;
        // What a killed service leaves behind says that it is ready.
        let _ = fs::remove_file(self.runtime_folder().join(SOCKET));
        self.port = configure(self.folder.path())?;
        self.child = spawn(self.folder.path(), &self.params)?;
        self.wait_until_ready()
    }

    /// Asks the runtime to end, as the system does when a person logs out, and waits until it has.
    ///
    /// # Errors
    /// [`ServiceError`] when it does not end.
    pub fn ask_to_end(&mut self) -> Result<(), ServiceError> {
        if self.child.try_wait()?.is_some() {
            return Ok(());
        }
        // The standard library sends SIGKILL only; the shell's own `kill` is everywhere.
        Command::new("sh")
            .args(["-c", "kill -TERM \"$0\"", &self.child.id().to_string()])
            .status()?;
        let began = Instant::now();
        while self.child.try_wait()?.is_none() {
            self.in_time(began, self.params.stopped_within, "end")?;
            thread::sleep(LOOK_AGAIN);
        }
        Ok(())
    }

    /// Asks the runtime to end, waits, and reads its log and the layer's: any complaint is an error.
    /// Returns the service's log.
    ///
    /// # Errors
    /// [`ServiceError`] when it does not end, or something was complained about.
    pub fn stop(mut self) -> Result<String, ServiceError> {
        self.ask_to_end()?;
        let log = self.log();
        let validation = self.validation_log();
        let complaints = [verdict::complaints(&log), verdict::complaints(&validation)]
            .concat()
            .join("\n");
        if complaints.is_empty() {
            Ok(log)
        } else {
            Err(ServiceError::Complaints { complaints })
        }
    }
}

/// The folder of the runtime's own settings.
const CONFIG: &str = "config/monado";

/// Writes the settings, with a port that is free; gives it.
fn configure(folder: &Path) -> io::Result<u16> {
    // The port stays free until the service takes it: inside the stage nobody else is on this network.
    let port = TcpListener::bind(("127.0.0.1", 0))?.local_addr()?.port();
    fs::write(
        folder.join(CONFIG).join("config_v0.json"),
        format!(r#"{{"active":"remote","remote":{{"version":0,"port":{port},"view_count":2}}}}"#),
    )?;
    Ok(port)
}

/// Starts the process; its output goes on in the log.
fn spawn(folder: &Path, params: &ServiceParams) -> Result<Child, ServiceError> {
    let log = File::options()
        .create(true)
        .append(true)
        .open(folder.join("service.log"))?;
    Command::new("monado-service")
        .env("XRT_NO_STDIN", "1")
        .env("XRT_COMPOSITOR_NULL", "1")
        .env("XDG_RUNTIME_DIR", folder.join("runtime"))
        .env("XDG_CONFIG_HOME", folder.join("config"))
        .envs(params.environment.iter().map(|(name, value)| (name, value)))
        .stdin(Stdio::null())
        .stdout(log.try_clone()?)
        .stderr(log)
        .spawn()
        .map_err(ServiceError::Start)
}

impl Drop for Service {
    fn drop(&mut self) {
        // Nothing is left to do where it has ended already.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
