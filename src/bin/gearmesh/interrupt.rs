//! Ctrl-C: the command stops at once, but never in the middle of a file.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Exit status of a command that was stopped by the interrupt signal, as shells give it: 128 + SIGINT.
const STOPPED: i32 = 130;

/// Held while a file is written under a temporary name and renamed.
static WRITING: Mutex<()> = Mutex::new(());

fn hold() -> MutexGuard<'static, ()> {
    // A writer that panicked has left nothing to protect.
    WRITING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// From now on the signals to interrupt and to terminate end the process after the file that is being written.
///
/// # Errors
/// The system takes no handler.
pub fn handle() -> Result<(), crate::Error> {
    ctrlc::set_handler(|| {
        let _whole = hold();
        eprintln!("gearmesh: stopped; no unfinished file is left");
        std::process::exit(STOPPED);
    })
    .map_err(|e| format!("cannot watch for Ctrl-C: {e}").into())
}

/// Runs `write`, which no signal ends half-way.
pub fn uninterrupted<T>(write: impl FnOnce() -> T) -> T {
    let _whole = hold();
    write()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::sync::mpsc::channel;

    #[test]
    fn a_signal_waits_for_the_file_that_is_being_written() {
        let whole = AtomicBool::new(false);
        let (begun, wait) = channel();
        std::thread::scope(|scope| {
            scope.spawn(|| {
                uninterrupted(|| {
                    begun.send(()).unwrap();
                    std::thread::sleep(std::time::Duration::from_millis(50));
                    whole.store(true, Ordering::SeqCst);
                });
            });
            wait.recv().unwrap();
            // What the handler does before it ends the process.
            drop(hold());
            assert!(whole.load(Ordering::SeqCst));
        });
    }
}
