//! Numbers of cores and bytes of memory available on this machine.

use std::thread::available_parallelism;

/// Assumed free memory if the system does not report it, bytes.
const UNKNOWN: u64 = 4 << 30;

/// Returns the number of cores that this process may use.
pub fn cores() -> u32 {
    available_parallelism().map_or(1, |cores| cores.get() as u32)
}

/// Returns the memory available to commands, bytes: the free memory, or less if this process's control group limits it.
pub fn free_bytes() -> u64 {
    let meminfo = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
    let free = available(&meminfo).unwrap_or(UNKNOWN);
    let group = |name: &str| {
        let text = std::fs::read_to_string(format!("/sys/fs/cgroup/{name}")).ok()?;
        text.trim().parse::<u64>().ok()
    };
    let left = group("memory.max").map(|most| most.saturating_sub(group("memory.current").unwrap_or(0)));
    left.map_or(free, |left| left.min(free))
}

/// Parses `MemAvailable` from the text of /proc/meminfo.
fn available(meminfo: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    Some(line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()? << 10)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn available_memory_is_parsed_from_meminfo() {
        assert_eq!(available("MemTotal: 9 kB\nMemAvailable:    2048 kB\n"), Some(2 << 20));
        assert_eq!(available(""), None);
        assert!(free_bytes() > 1 << 20 && cores() >= 1);
    }
}
