//! Compiles `shaders/*.wgsl` to SPIR-V, one file a pass, and writes them as Rust constants.
//!
//! naga validates everything here, so a shader that compiles is one that every
//! driver must take; an error stops the build and shows the line in its own file.
//! `#include "shared/light.wgsl"` pastes a file once, in place of the line.

use std::{env, fmt::Write as _, fs, path::Path, process::ExitCode};

use naga::{
    back::spv,
    front::wgsl,
    valid::{Capabilities, ValidationFlags, Validator},
};

/// A shader with its includes pasted in, and where each line came from.
struct Source {
    text: String,
    lines: Vec<(String, usize)>,
    included: Vec<String>,
}

impl Source {
    fn paste(&mut self, folder: &Path, name: &str) -> Result<(), String> {
        if self.included.iter().any(|seen| seen == name) {
            return Ok(());
        }
        self.included.push(name.to_owned());
        let path = folder.join(name);
        let text =
            fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        for (number, line) in text.lines().enumerate() {
            if let Some(rest) = line.trim().strip_prefix("#include") {
                let inner = rest.trim().trim_matches('"');
                self.paste(folder, inner)
                    .map_err(|error| format!("{error}\n  included by {name}:{}", number + 1))?;
            } else {
                self.text.push_str(line);
                self.text.push('\n');
                self.lines.push((name.to_owned(), number + 1));
            }
        }
        Ok(())
    }

    /// "shaders/tree.wgsl:12" for a line of the pasted text.
    fn origin(&self, line: Option<u32>) -> String {
        line.and_then(|line| self.lines.get(line as usize - 1))
            .map_or_else(
                || "shaders/".to_owned(),
                |(file, number)| format!("shaders/{file}:{number}"),
            )
    }
}

fn compile(folder: &Path, name: &str) -> Result<(Vec<u32>, Vec<String>), String> {
    let mut source = Source {
        text: String::new(),
        lines: Vec::new(),
        included: Vec::new(),
    };
    source.paste(folder, name)?;
    let module = wgsl::parse_str(&source.text).map_err(|error| {
        let at = source.origin(error.location(&source.text).map(|place| place.line_number));
        format!(
            "{at}: {}\n{}",
            error.message(),
            error.emit_to_string_with_path(&source.text, name)
        )
    })?;
    let capabilities = Capabilities::MULTIVIEW | Capabilities::IMMEDIATES;
    let info = Validator::new(ValidationFlags::all(), capabilities)
        .validate(&module)
        .map_err(|error| {
            let at = source.origin(error.location(&source.text).map(|place| place.line_number));
            format!(
                "{at}: {error}\n{}",
                error.emit_to_string_with_path(&source.text, name)
            )
        })?;
    // No ADJUST_COORDINATE_SPACE: our projection turns y over itself. SPIR-V 1.3 is Vulkan 1.1's.
    // No CLAMP_FRAG_DEPTH: nothing writes depth. No loop bounding: our loops have constant ends.
    let options = spv::Options {
        lang_version: (1, 3),
        flags: spv::WriterFlags::LABEL_VARYINGS | spv::WriterFlags::DEBUG,
        force_loop_bounding: false,
        zero_initialize_workgroup_memory: spv::ZeroInitializeWorkgroupMemoryMode::None,
        ..spv::Options::default()
    };
    let words = spv::write_vec(&module, &info, &options, None)
        .map_err(|error| format!("shaders/{name}: {error}"))?;
    Ok((
        words,
        module
            .entry_points
            .iter()
            .map(|entry| entry.name.clone())
            .collect(),
    ))
}

fn run() -> Result<(), String> {
    println!("cargo::rerun-if-changed=shaders");
    println!("cargo::rerun-if-changed=build.rs");
    let root = env::var("CARGO_MANIFEST_DIR").map_err(|error| error.to_string())?;
    let folder = Path::new(&root).join("shaders");
    let mut names: Vec<String> = fs::read_dir(&folder)
        .map_err(|error| format!("{}: {error}", folder.display()))?
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .filter(|name| name.ends_with(".wgsl"))
        .collect();
    names.sort();
    let mut code = String::from("// Made by build.rs from shaders/.\n");
    let mut errors = String::new();
    for name in &names {
        match compile(&folder, name) {
            Ok((words, entries)) => {
                let module = name.trim_end_matches(".wgsl");
                let _ = writeln!(code, "/// `shaders/{name}`.\npub(crate) mod {module} {{");
                let _ = writeln!(code, "    pub(crate) const SPIRV: &[u32] = &{words:?};");
                for entry in entries {
                    let _ = writeln!(
                        code,
                        "    pub(crate) const {}: &core::ffi::CStr = c\"{entry}\";",
                        entry.to_uppercase()
                    );
                }
                code.push_str("}\n");
            }
            Err(error) => {
                let _ = writeln!(errors, "{error}");
            }
        }
    }
    if !errors.is_empty() {
        return Err(errors);
    }
    let out = env::var("OUT_DIR").map_err(|error| error.to_string())?;
    fs::write(Path::new(&out).join("shaders.rs"), code).map_err(|error| error.to_string())
}

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
