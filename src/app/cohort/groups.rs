//! Which group each model is of: a table with the columns `model` and `group`.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, anyhow, bail, ensure};

use super::entries::text_of;

/// Groups at most: more fit into no picture, and their pairs are hundreds.
pub const GROUPS_MOST: usize = 24;
/// Longest name of a group, in bytes.
const NAME_MOST: usize = 200;

/// A table of groups as it was read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Groups {
    /// The groups, in the order in which the table has them first.
    pub names: Vec<String>,
    /// Line, name of the model, number of its group.
    rows: Vec<(u64, String, usize)>,
    file: PathBuf,
}

/// The groups of a cohort's models.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grouped {
    /// The group of each model.
    pub of: Vec<Option<usize>>,
    /// Names in the table that no model has.
    pub unknown: Vec<String>,
}

/// A model, as tables may call it.
#[derive(Clone, Copy, Debug)]
pub struct Named<'a> {
    /// What it is called in tables.
    pub label: &'a str,
    /// Its file.
    pub path: &'a Path,
}

impl Groups {
    /// Reads a table.
    ///
    /// # Errors
    /// What is wrong with it, and in which line.
    pub fn read(path: &Path) -> Result<Self> {
        let text = text_of(path, "table with the columns model and group")?;
        Self::from_text(&text, path).with_context(|| path.display().to_string())
    }

    /// Reads the text of a table.
    ///
    /// # Errors
    /// As [`Groups::read`].
    pub fn from_text(text: &str, path: &Path) -> Result<Self> {
        let mut table = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .comment(Some(b'#'))
            .from_reader(text.as_bytes());
        let header = table
            .headers()
            .map_err(|error| anyhow!("no table can be read there ({error})"))?
            .clone();
        let column = |name: &str| {
            let found = header
                .iter()
                .position(|other| other.eq_ignore_ascii_case(name));
            found.ok_or_else(|| {
                anyhow!("the column {name} is missing: its first line is to be `model,group`")
            })
        };
        let [model, group] = [column("model")?, column("group")?];
        let mut groups = Self {
            file: path.to_owned(),
            ..Self::default()
        };
        for row in table.records() {
            let row = row.map_err(|error| anyhow!("no table can be read there ({error})"))?;
            let line = row.position().map_or(0, csv::Position::line);
            let [model, group] = [model, group].map(|place| row.get(place).unwrap_or_default());
            if model.is_empty() && group.is_empty() {
                continue;
            }
            ensure!(!model.is_empty(), "line {line} has a group and no model");
            ensure!(
                group.len() <= NAME_MOST,
                "line {line} has a group of a name longer than {NAME_MOST} bytes: shorten it"
            );
            if group.is_empty() {
                continue; // Of no group, and so it is told.
            }
            let known = groups.names.iter().position(|name| name == group);
            let number = known.unwrap_or_else(|| {
                groups.names.push(group.to_owned());
                groups.names.len() - 1
            });
            ensure!(
                groups.names.len() <= GROUPS_MOST,
                "line {line} begins one group more than {GROUPS_MOST}: is it the right column?"
            );
            groups.rows.push((line, model.to_owned(), number));
        }
        ensure!(!groups.rows.is_empty(), "no model is of a group in it");
        Ok(groups)
    }

    /// Finds the models by what the table calls them: their name in tables, file or path, else their file's name without its ending.
    ///
    /// # Errors
    /// A name that stands for several models, a model of two groups, or no name that any model has.
    pub fn of(&self, models: &[Named<'_>]) -> Result<Grouped> {
        let file = self.file.display();
        let mut exact: HashMap<String, Vec<usize>> = HashMap::new();
        let mut stems: HashMap<String, Vec<usize>> = HashMap::new();
        for (place, model) in models.iter().enumerate() {
            let note = |names: &mut HashMap<String, Vec<usize>>, name: String| {
                let of_name = names.entry(name).or_default();
                if of_name.last() != Some(&place) {
                    of_name.push(place);
                }
            };
            let text = |part: Option<&std::ffi::OsStr>| {
                part.map_or_else(String::new, |part| part.to_string_lossy().into_owned())
            };
            note(&mut exact, model.label.to_owned());
            note(&mut exact, whole(model.path));
            note(&mut exact, text(model.path.file_name()));
            note(&mut stems, text(model.path.file_stem()));
        }
        let mut grouped = Grouped {
            of: vec![None; models.len()],
            unknown: Vec::new(),
        };
        for (line, name, group) in &self.rows {
            let found = exact
                .get(name)
                .or_else(|| exact.get(&whole(Path::new(name))));
            let place = match found.or_else(|| stems.get(name)).map(Vec::as_slice) {
                None => {
                    grouped.unknown.push(name.clone());
                    continue;
                }
                Some([place]) => *place,
                Some(several) => bail!(
                    "{file}, line {line}: {name} stands for {} models, {} and {} among them: write their whole names",
                    several.len(),
                    models[several[0]].label,
                    models[several[1]].label
                ),
            };
            match grouped.of[place] {
                Some(other) if other != *group => bail!(
                    "{file}, line {line}: {} is of two groups, {} and {}: leave one of them",
                    models[place].label,
                    self.names[other],
                    self.names[*group]
                ),
                _ => grouped.of[place] = Some(*group),
            }
        }
        ensure!(
            grouped.of.iter().any(Option::is_some),
            "{file} names none of the models: its column model has their files' names, such as {}",
            models.first().map_or("", |model| model.label)
        );
        Ok(grouped)
    }
}

fn whole(path: &Path) -> String {
    let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    whole.to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::unwrap_used,
        clippy::missing_assert_message,
        reason = "a test that fails shows the line"
    )]
    use super::*;
    use crate::app::sentence;

    fn groups(text: &str) -> Result<Groups, String> {
        Groups::from_text(text, Path::new("g.csv")).map_err(|error| sentence(&error))
    }

    fn found(text: &str, models: &[(&str, &str)]) -> Result<Grouped, String> {
        let models: Vec<Named<'_>> = models
            .iter()
            .map(|(label, path)| Named {
                label,
                path: Path::new(path),
            })
            .collect();
        groups(text)?.of(&models).map_err(|error| sentence(&error))
    }

    const MODELS: [(&str, &str); 3] = [
        ("1/a.obj", "/m/1/a.obj"),
        ("2/a.obj", "/m/2/a.obj"),
        ("2/b.swc", "/m/2/b.swc"),
    ];

    #[test]
    fn models_are_found_by_name_path_and_stem() {
        for name in ["2/b.swc", "/m/2/b.swc", "b.swc", "b"] {
            let text = format!(
                "group,Model,age\nyoung,{name},3\nold,c.obj,9\nold,1/a.obj,8\n,2/a.obj,1\n"
            );
            let grouped = found(&text, &MODELS).unwrap();
            assert_eq!(grouped.of, [Some(1), None, Some(0)], "{name}");
            assert_eq!(grouped.unknown, ["c.obj"]);
            assert_eq!(groups(&text).unwrap().names, ["young", "old"]);
        }
    }

    #[test]
    fn what_is_wrong_with_groups_is_told() {
        for (text, expected) in [
            ("a,b\n1,2\n", "the column model is missing"),
            ("model,kind\n1,2\n", "the column group is missing"),
            ("model,group\n", "no model is of a group"),
            ("model,group\n,x\n", "line 2 has a group and no model"),
            (
                "model,group\nb,x\na,y\n",
                "g.csv, line 3: a stands for 2 models, 1/a.obj and 2/a.obj",
            ),
            (
                "model,group\nb,x\nb.swc,y\n",
                "line 3: 2/b.swc is of two groups, x and y",
            ),
            ("model,group\nq,x\n", "names none of the models"),
            ("model,group\nb,x,y\n", "no table can be read"),
        ] {
            let told = found(text, &MODELS).unwrap_err();
            assert!(told.contains(expected), "{text}: {told}");
        }
        let many: String = (0..=GROUPS_MOST).map(|one| format!("m,{one}\n")).collect();
        let told = groups(&format!("model,group\n{many}")).unwrap_err();
        assert!(told.contains("one group more than 24"), "{told}");
    }
}
