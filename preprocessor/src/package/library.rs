//! The compiled library that goes into the archive.

use std::fs;
use std::path::{Path, PathBuf};

use super::error::PackageError;

/// File names of the library as cargo gives them on Linux, Windows and macOS.
const NAMES: [&str; 3] = ["libgearmesh.so", "gearmesh.dll", "libgearmesh.dylib"];

/// A compiled library of the FMU for one platform.
#[derive(Debug, Clone)]
pub struct Library {
    /// Name of the platform in the standard: `linux64`, `win64`, `darwin64`, ...
    pub platform: &'static str,
    /// Where it came from.
    pub path: PathBuf,
    pub(super) bytes: Vec<u8>,
}

impl Library {
    /// Reads the library at `path` and tells its platform from its header.
    ///
    /// # Errors
    /// A file that cannot be read, is no shared library of a platform of FMI 2.0, or has not the
    /// functions of the interface.
    pub fn read(path: &Path) -> Result<Self, PackageError> {
        let bytes = fs::read(path).map_err(|e| PackageError::file(path, e))?;
        let refused = |reason: &str| PackageError::contents(path, reason);
        let none =
            "no shared library for 64-bit Linux, Windows or macOS; give the one that cargo built";
        let platform = platform(&bytes).ok_or_else(|| refused(none))?;
        if !bytes.windows(11).any(|w| w == b"fmi2DoStep\0") {
            let other = "a library without fmi2DoStep; give the library gearmesh, built as cdylib";
            return Err(refused(other));
        }
        Ok(Self {
            platform,
            path: path.to_owned(),
            bytes,
        })
    }

    /// Its platform with the oldest glibc that loads it, in words.
    pub fn runs_on(&self) -> String {
        runs_on(self.platform, &self.bytes)
    }

    /// Extension of library files on this platform.
    pub(super) fn extension(&self) -> &'static str {
        match self.platform {
            "win64" => "dll",
            "darwin64" => "dylib",
            _ => "so",
        }
    }
}

/// The platform of the `library` with the oldest C library of Linux that loads it, in words.
pub(super) fn runs_on(platform: &str, library: &[u8]) -> String {
    match least_glibc(library) {
        Some([major, minor]) => format!("{platform} (glibc {major}.{minor} or later)"),
        None => platform.to_owned(),
    }
}

/// The newest version of glibc that `library` needs; None for a library of another platform. A linker names the versions as
/// strings of their own, `GLIBC_2.17`, and a symbol of an old one keeps its name in later ones.
fn least_glibc(library: &[u8]) -> Option<[u32; 2]> {
    if !library.starts_with(b"\x7fELF") {
        return None;
    }
    let strings = library.split(|byte| *byte == 0);
    let versions = strings.filter_map(|string| {
        let version = std::str::from_utf8(string.strip_prefix(b"GLIBC_")?).ok()?;
        let mut numbers = version.split('.').map(str::parse::<u32>);
        Some([numbers.next()?.ok()?, numbers.next()?.ok()?])
    });
    versions.max()
}

/// Platform name of a library by the first bytes of its file.
fn platform(bytes: &[u8]) -> Option<&'static str> {
    const X86_64_ELF: [u8; 2] = [62, 0];
    const X86_64_PE: [u8; 2] = [0x64, 0x86];
    if bytes.starts_with(b"\x7fELF\x02") && bytes.get(18..20)? == X86_64_ELF {
        return Some("linux64");
    }
    if bytes.starts_with(b"MZ") {
        let at = u32::from_le_bytes(bytes.get(60..64)?.try_into().ok()?) as usize;
        let header = bytes.get(at..at.checked_add(6)?)?;
        return (header[..4] == *b"PE\0\0" && header[4..] == X86_64_PE).then_some("win64");
    }
    let is_mach = bytes.starts_with(&[0xcf, 0xfa, 0xed, 0xfe]);
    is_mach.then_some("darwin64")
}

/// The libraries in the folder of the program `executable`: cargo leaves the one of its own platform there
/// (`target/release/libgearmesh.so`), a release has those of all its platforms.
///
/// # Errors
/// There is none, or one of them is not usable.
pub fn libraries_beside(executable: &Path) -> Result<Vec<Library>, PackageError> {
    let paths = NAMES.map(|name| executable.with_file_name(name));
    let found = paths.iter().filter(|path| path.exists());
    let found: Vec<Library> = found
        .map(|path| Library::read(path))
        .collect::<Result<_, _>>()?;
    if found.is_empty() {
        let reason = "no library of the FMU is there; build it with cargo build --release, or name one with --library";
        return Err(PackageError::contents(&paths[0], reason));
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Headers of libraries for Linux and Windows.
    fn headers() -> [Vec<u8>; 2] {
        let mut elf = vec![0u8; 64];
        elf[..5].copy_from_slice(b"\x7fELF\x02");
        elf[18] = 62;
        let mut pe = vec![0u8; 128];
        pe[..2].copy_from_slice(b"MZ");
        pe[60] = 64;
        pe[64..70].copy_from_slice(b"PE\0\0\x64\x86");
        [elf, pe]
    }

    #[test]
    fn the_header_gives_the_platform() {
        let [mut elf, mut pe] = headers();
        assert_eq!(platform(&elf), Some("linux64"));
        elf[18] = 183; // AArch64: FMI 2.0 has no name for it
        assert_eq!(platform(&elf), None);
        assert_eq!(platform(&pe), Some("win64"));
        pe[60..64].copy_from_slice(&u32::MAX.to_le_bytes());
        assert_eq!(platform(&pe), None);
        assert_eq!(platform(b"#!/bin/sh"), None);
        assert_eq!(platform(b""), None);
    }

    #[test]
    fn the_least_glibc_is_the_newest_that_a_library_asks_for() {
        let elf = b"\x7fELF\x02\0GLIBC_2.9\0GLIBC_PRIVATE\0GLIBC_2.2.5\0libc.so.6\0GLIBC_2.35\0xGLIBC_2.99\0";
        assert_eq!(runs_on("linux64", elf), "linux64 (glibc 2.35 or later)");
        assert_eq!(runs_on("win64", b"MZ\0GLIBC_2.35\0"), "win64");
    }

    #[test]
    fn every_library_beside_the_program_is_found_and_none_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let program = folder.path().join("gearmesh");
        let error = libraries_beside(&program).unwrap_err().to_string();
        assert!(
            error.contains("libgearmesh.so") && error.contains("--library"),
            "{error}"
        );
        let [elf, pe] = headers();
        for (name, mut bytes) in [("libgearmesh.so", elf), ("gearmesh.dll", pe)] {
            bytes.extend(b"fmi2DoStep\0");
            fs::write(folder.path().join(name), bytes).unwrap();
        }
        let found = libraries_beside(&program).unwrap();
        let platforms: Vec<_> = found.iter().map(|library| library.platform).collect();
        assert_eq!(platforms, ["linux64", "win64"]);
        // One that is no library is named rather than left out.
        fs::write(folder.path().join("gearmesh.dll"), "text").unwrap();
        let error = libraries_beside(&program).unwrap_err().to_string();
        let words = ["gearmesh.dll", "no shared library"];
        assert!(words.iter().all(|w| error.contains(w)), "{error}");
    }
}
