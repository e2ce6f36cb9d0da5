//! Whether there is memory for a model before it is taken.
//!
//! A system that grants more than it has ends the program once the memory is used: no allocation fails. So what is needed is
//! compared with what the system says is left.

use super::FiniteElementError;

/// Refuses work that takes `bytes` where the system says that it has less left; one that does not say takes all.
///
/// # Errors
/// [`FiniteElementError::Memory`].
pub(super) fn check(bytes: usize) -> Result<(), FiniteElementError> {
    let state = std::fs::read_to_string("/proc/meminfo").unwrap_or_default();
    match available(&state) {
        Some(available) if bytes > available => Err(FiniteElementError::Memory {
            needed_gb: 1e-9 * bytes as f64,
            available_gb: 1e-9 * available as f64,
        }),
        _ => Ok(()),
    }
}

/// Bytes that Linux's `/proc/meminfo` says new work can take without swapping.
fn available(meminfo: &str) -> Option<usize> {
    let mut lines = meminfo.lines();
    let rest = lines.find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kilobytes = rest.trim().strip_suffix("kB")?.trim();
    kilobytes.parse::<usize>().ok()?.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_linux_has_left_is_read() {
        let state = "MemTotal:       24576000 kB\nMemFree:  1 kB\nMemAvailable:   20480000 kB\n";
        assert_eq!(available(state), Some(20_971_520_000));
        assert_eq!(available(""), None);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn more_than_there_is_is_refused_and_a_little_is_not() {
        check(1 << 20).unwrap();
        let error = check(1 << 60).unwrap_err().to_string();
        assert!(
            error.contains("1152921504.6 GB") && error.contains("are available"),
            "{error}"
        );
    }
}
