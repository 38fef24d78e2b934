//! How much memory this process may still take: what the machine has, less where a limit is set for the process or its group.
//!
//! An allocation that fails ends a Rust program, and one that succeeds beyond the machine's memory ends in the system's killer. So large
//! work asks here first and stays below. Read from `/proc` and the control groups' files; where they say nothing, nothing is known.

use std::path::{Path, PathBuf};

/// What the system says, as text.
#[derive(Clone, Debug, Default)]
struct Said {
    /// `/proc/meminfo`.
    memory: String,
    /// `/proc/self/limits`.
    limits: String,
    /// `/proc/self/status`.
    status: String,
    /// Limit and use of each control group that this process is in.
    groups: Vec<(String, String)>,
}

/// Bytes that may still be taken, as far as the system tells.
///
/// The worker threads are started first: what they take for themselves is no longer free, and one that starts while memory runs out ends
/// the program (the C library has no other way to say that a thread's own storage cannot be had).
#[must_use]
pub fn room() -> Option<u64> {
    rayon::broadcast(|_| drop(std::hint::black_box(Vec::<u8>::with_capacity(64))));
    let read = |path: &str| std::fs::read_to_string(path).unwrap_or_default();
    Said {
        memory: read("/proc/meminfo"),
        limits: read("/proc/self/limits"),
        status: read("/proc/self/status"),
        groups: groups(&read("/proc/self/cgroup"), Path::new("/sys/fs/cgroup")),
    }
    .room()
}

impl Said {
    fn room(&self) -> Option<u64> {
        let kib = |text: &str, name: &str| {
            let line = text.lines().find_map(|line| line.strip_prefix(name))?;
            let number = line.trim().strip_suffix("kB")?.trim();
            number.parse::<u64>().ok()?.checked_mul(1024)
        };
        let machine = kib(&self.memory, "MemAvailable:")
            .map(|available| available + kib(&self.memory, "SwapFree:").unwrap_or(0));
        // `ulimit -v`: the first number is the limit that holds.
        let addresses = self
            .limits
            .lines()
            .find_map(|line| line.strip_prefix("Max address space"))
            .and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok())
            .map(|limit| limit.saturating_sub(kib(&self.status, "VmSize:").unwrap_or(0)));
        let groups = self.groups.iter().filter_map(|(limit, used)| {
            // "max" stands for none.
            let limit: u64 = limit.trim().parse().ok()?;
            Some(limit.saturating_sub(used.trim().parse().ok()?))
        });
        machine.into_iter().chain(addresses).chain(groups).min()
    }
}

/// The limits and uses of this process's groups and those around them, under versions 2 and 1; `text` is `/proc/self/cgroup`.
fn groups(text: &str, root: &Path) -> Vec<(String, String)> {
    let mut found = Vec::new();
    for line in text.lines() {
        let mut parts = line.splitn(3, ':').skip(1);
        let (Some(kinds), Some(path)) = (parts.next(), parts.next()) else {
            continue;
        };
        let (root, names) = match kinds {
            "" => (root.to_owned(), ["memory.max", "memory.current"]),
            _ if kinds.split(',').any(|kind| kind == "memory") => (
                root.join("memory"),
                ["memory.limit_in_bytes", "memory.usage_in_bytes"],
            ),
            _ => continue,
        };
        let group = PathBuf::from(path.trim_start_matches('/'));
        for group in group.ancestors() {
            let [limit, used] =
                names.map(|name| std::fs::read_to_string(root.join(group).join(name)));
            if let (Ok(limit), Ok(used)) = (limit, used) {
                found.push((limit, used));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    #![allow(
        clippy::missing_assert_message,
        clippy::unwrap_used,
        reason = "the table says it"
    )]
    use super::*;

    #[test]
    fn the_narrowest_of_machine_process_and_group_counts() {
        let memory = "MemTotal: 9000 kB\nMemAvailable:    4000 kB\nSwapFree:  1000 kB\n";
        let limits = |most: &str| {
            format!("Limit   Soft Limit\nMax address space   {most}   unlimited   bytes\n")
        };
        let group = |limit: &str, used: &str| vec![(format!("{limit}\n"), format!("{used}\n"))];
        let status = "Name: ramus\nVmSize:\t    100 kB\n";
        for (memory, limits, groups, expected) in [
            ("", String::new(), vec![], None),
            (memory, limits("unlimited"), vec![], Some(5000 << 10)),
            (memory, limits("2048000"), vec![], Some(1900 << 10)),
            (memory, limits("1000"), vec![], Some(0)),
            (memory, String::new(), group("max", "7"), Some(5000 << 10)),
            (memory, String::new(), group("3000", "1000"), Some(2000)),
            ("", limits("unlimited"), group("3000", "4000"), Some(0)),
            ("nonsense", "Max address space".into(), group("", ""), None),
        ] {
            let said = Said {
                memory: memory.to_owned(),
                limits,
                status: status.to_owned(),
                groups,
            };
            assert_eq!(said.room(), expected, "{said:?}");
        }
    }

    #[test]
    fn groups_around_the_own_one_count_too() {
        let root = tempfile::tempdir().unwrap();
        let write = |path: &str, text: &str| {
            let path = root.path().join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        };
        write("user/ramus/memory.max", "max");
        write("user/ramus/memory.current", "5");
        write("user/memory.max", "100");
        write("user/memory.current", "10");
        write("memory/job/memory.limit_in_bytes", "50");
        write("memory/job/memory.usage_in_bytes", "20");
        let found = groups("3:cpuset:/\n4:memory:/job\n0::/user/ramus\n", root.path());
        let expected = [("50", "20"), ("max", "5"), ("100", "10")];
        assert_eq!(
            found,
            expected.map(|(limit, used)| (limit.to_owned(), used.to_owned()))
        );
    }

    #[test]
    fn this_machine_has_room() {
        assert!(room().is_none_or(|room| room > 1 << 20));
    }
}
