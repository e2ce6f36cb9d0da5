//! What the report was measured on, read from the system.

use std::hint::black_box;
use std::time::Instant;

/// One paragraph: processor, clock, cores, load, compiler.
pub fn description() -> String {
    let read = |path: &str| std::fs::read_to_string(path).unwrap_or_default();
    let cpu_info = read("/proc/cpuinfo");
    let field = |name: &str| {
        cpu_info
            .lines()
            .find(|l| l.starts_with(name))
            .and_then(|l| l.split_once(':'))
            .map_or("unknown", |(_, v)| v.trim())
            .to_owned()
    };
    let processors = std::thread::available_parallelism().map_or(0, std::num::NonZero::get);
    let flags = field("flags");
    let has = |flag: &str| flags.split(' ').any(|f| f == flag);
    let vectors: Vec<&str> = ["avx", "fma", "avx2", "avx512f"]
        .into_iter()
        .filter(|f| has(f))
        .collect();
    let load = read("/proc/loadavg");
    let load = load.split(' ').next().unwrap_or("unknown").to_owned();
    let compiler = std::process::Command::new("rustc")
        .arg("--version")
        .output()
        .map_or_else(
            |_| "rustc of unknown version".to_owned(),
            |o| String::from_utf8_lossy(&o.stdout).trim().to_owned(),
        );
    format!(
        "Machine: {} (model {}, stepping {}), {} processors to this process, {:.2} GHz by a chain of \
         dependent multiplications during the run, vector instructions {}; the code is compiled for the \
         baseline of {} by {compiler}. Other work on the machine when the report was begun: load average \
         {load} over one minute.",
        field("model name"),
        field("model\t"),
        field("stepping"),
        processors,
        clock(),
        vectors.join(", "),
        std::env::consts::ARCH,
    )
}

/// Clock, GHz: a 64-bit multiplication takes three cycles on x86-64 since 2008 and on current ARM cores.
pub fn clock() -> f64 {
    const MULTIPLICATIONS: u32 = 300_000;
    (0..31)
        .map(|_| {
            let begin = Instant::now();
            let mut x = black_box(3_u64);
            let factor = black_box(0x9E37_79B9_7F4A_7C15);
            for _ in 0..MULTIPLICATIONS {
                x = black_box_register(x.wrapping_mul(factor));
            }
            black_box(x);
            3.0 * f64::from(MULTIPLICATIONS) / begin.elapsed().as_secs_f64() / 1e9
        })
        .fold(0.0, f64::max)
}

/// Keeps a chain of products from being folded into a power: the xor depends on the value itself.
#[inline(always)]
fn black_box_register(x: u64) -> u64 {
    x | 1
}
