//! What the process has used, from /proc.

use std::collections::HashMap;
use std::fs;

/// Clock ticks per second in /proc/self/stat: USER_HZ, 100 on every Linux this runs on.
const TICKS_PER_S: f64 = 100.0;

/// Counts the processor seconds of all threads from its start on.
pub struct CpuClock {
    /// Nanoseconds of each thread that was there at the start.
    threads: HashMap<String, u64>,
    process_s: f64,
}

impl CpuClock {
    pub fn start() -> Self {
        Self { threads: thread_nanoseconds().collect(), process_s: cpu_seconds() }
    }

    /// User + system seconds since the start: to the nanosecond of the threads that are there now, where the kernel keeps
    /// count; else of the process, to 0.01 s. Render while all threads live, and read before they end.
    pub fn seconds(&self) -> f64 {
        let mut counted = false;
        let mut nanoseconds = 0;
        for (thread, now) in thread_nanoseconds() {
            counted |= now > 0;
            nanoseconds += now.saturating_sub(self.threads.get(&thread).copied().unwrap_or(0));
        }
        if counted { nanoseconds as f64 * 1e-9 } else { cpu_seconds() - self.process_s }
    }
}

/// The number of each thread of this process and the nanoseconds that it has run.
fn thread_nanoseconds() -> impl Iterator<Item = (String, u64)> {
    fs::read_dir("/proc/self/task").into_iter().flatten().flatten().filter_map(|thread| {
        let text = fs::read_to_string(thread.path().join("schedstat")).ok()?;
        let ran = text.split_whitespace().next()?.parse().ok()?;
        Some((thread.file_name().into_string().ok()?, ran))
    })
}

/// User + system seconds of this process so far (all threads, to 0.01 s); 0 where /proc is absent.
fn cpu_seconds() -> f64 {
    let Ok(stat) = fs::read_to_string("/proc/self/stat") else { return 0.0 };
    // The second field is a name in parentheses that may hold spaces; utime and stime are fields 14 and 15.
    let after_name = stat.rsplit(')').next().unwrap_or("");
    let ticks: f64 = after_name.split_whitespace().skip(11).take(2).filter_map(|t| t.parse::<f64>().ok()).sum();
    ticks / TICKS_PER_S
}

/// Bytes that can be allocated before the machine swaps or kills; no limit where /proc is absent.
pub fn available_memory() -> u64 {
    let Ok(info) = fs::read_to_string("/proc/meminfo") else { return u64::MAX };
    let line = info.lines().find_map(|line| line.strip_prefix("MemAvailable:"));
    let kib = line.and_then(|l| l.split_whitespace().next()).and_then(|n| n.parse::<u64>().ok());
    kib.map_or(u64::MAX, |kib| kib * 1024)
}

/// Largest resident memory so far, in MB (10^6 bytes); 0 where /proc is absent.
pub fn peak_rss_mb() -> f64 {
    let Ok(status) = fs::read_to_string("/proc/self/status") else { return 0.0 };
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kib = line.and_then(|l| l.split_whitespace().next()).and_then(|n| n.parse::<f64>().ok());
    kib.unwrap_or(0.0) * 1.024e-3
}
