//! The archive: the compiled libraries that go into it, how it is written, reproducibly and whole or not at all, and what a
//! packed one holds.

use std::fs::File;
use std::io::{Cursor, Read, Write};
use std::path::{Path, PathBuf};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter};

use crate::storage::{self, write_whole};
use gearmesh::contact::ContactFile;
use gearmesh::fmi::resources::{
    CONTACT_FILE, LARGEST, TABLES_FILE, UNIT_FILE, UnitFile, parse_unit,
};

/// Why an FMU could not be packed or read: a file that cannot be read or written or is not what it should be, or start values
/// that no host could start with.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct PackageError(String);

impl PackageError {
    fn unread(path: &Path, source: std::io::Error) -> Self {
        let remedy = "name a file that exists and that you may read";
        PackageError::contents(path, format!("cannot be read: {source}; {remedy}"))
    }

    fn unwritten(path: &Path, source: std::io::Error) -> Self {
        let remedy = storage::remedy(&source);
        PackageError::contents(path, format!("cannot be written: {source}; {remedy}"))
    }

    fn archive(path: &Path, source: zip::result::ZipError) -> Self {
        let remedy = "name an FMU that `gearmesh pack` or `gearmesh build` wrote, or pack it again";
        PackageError::contents(path, format!("{source}; {remedy}"))
    }

    pub(super) fn contents(path: &Path, reason: impl std::fmt::Display) -> Self {
        PackageError(format!("{}: {reason}", path.display()))
    }

    pub(super) fn starts(reason: &str) -> Self {
        let problem = "the FMU does not start with these values";
        PackageError(format!("{problem}: {reason}"))
    }
}

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
        let mut bytes = Vec::new();
        let file = storage::open(path).map(|file| file.take(LONGEST_FILE));
        (file.and_then(|mut file| file.read_to_end(&mut bytes)))
            .map_err(|e| PackageError::unread(path, e))?;
        let none =
            "no shared library for 64-bit Linux, Windows or macOS; give the one that cargo built";
        let platform = platform(&bytes).ok_or_else(|| PackageError::contents(path, none))?;
        if !bytes.windows(11).any(|w| w == b"fmi2DoStep\0") {
            let other = "a library without fmi2DoStep; give the library gearmesh, built as cdylib";
            return Err(PackageError::contents(path, other));
        }
        Ok(Self {
            platform,
            path: path.to_owned(),
            bytes,
        })
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

/// Writes `files` (name with forward slashes, contents) in the order of their names to `out` and
/// returns the size. The same files give the same bytes.
pub(super) fn write(files: &[(String, Vec<u8>)], out: &Path) -> Result<u64, PackageError> {
    let broken = |error| PackageError::archive(out, error);
    let unwritten = |error| PackageError::unwritten(out, error);
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    // The time is the earliest that zip knows, so that it does not enter the bytes.
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Deflated)
        .last_modified_time(DateTime::default());
    let mut sorted: Vec<_> = files.iter().collect();
    sorted.sort();
    for (name, bytes) in sorted {
        let is_library = name.starts_with("binaries/");
        let options = options.unix_permissions(if is_library { 0o755 } else { 0o644 });
        archive.start_file(name.as_str(), options).map_err(broken)?;
        archive.write_all(bytes).map_err(unwritten)?;
    }
    let archive = archive.finish().map_err(broken)?.into_inner();
    write_whole(out, &archive).map_err(unwritten)?;
    Ok(archive.len() as u64)
}

/// Longest file that is read from an FMU, bytes: as much as its library reads.
const LONGEST_FILE: u64 = LARGEST;

/// Most bytes that are read from an FMU in all: libraries for all platforms and the largest tables.
const LONGEST_ARCHIVE: u64 = 1 << 30;

const DESCRIPTION: &str = "modelDescription.xml";

/// Most files of an FMU that is looked into; one of gearmesh has about a dozen.
const MOST_FILES: usize = 10_000;

/// The archive at `path`, if it is no larger than an FMU is.
fn opened(path: &Path) -> Result<ZipArchive<File>, PackageError> {
    let file = storage::open(path).map_err(|e| PackageError::unread(path, e))?;
    let archive = ZipArchive::new(file).map_err(|e| PackageError::archive(path, e))?;
    if archive.len() > MOST_FILES {
        let count = archive.len();
        let problem = format!("holds {count} files, and was not packed by gearmesh");
        return Err(PackageError::contents(path, problem));
    }
    Ok(archive)
}

/// The file `name` of the `archive` at `path`, if there is one; `read` counts the bytes of all that were read.
fn bytes(
    archive: &mut ZipArchive<File>,
    path: &Path,
    name: &str,
    read: &mut u64,
) -> Result<Option<Vec<u8>>, PackageError> {
    let entry = match archive.by_name(name) {
        Ok(entry) => entry,
        Err(zip::result::ZipError::FileNotFound) => return Ok(None),
        Err(e) => return Err(PackageError::archive(path, e)),
    };
    let mut bytes = Vec::new();
    // Few packed bytes may unfold into any number of them.
    let length = entry.take(LONGEST_FILE + 1).read_to_end(&mut bytes);
    let length = length.map_err(|e| PackageError::unread(path, e))? as u64;
    *read += length;
    let too_long = match (length > LONGEST_FILE, *read > LONGEST_ARCHIVE) {
        (true, _) => Some((name, LONGEST_FILE)),
        (_, true) => Some(("it", LONGEST_ARCHIVE)),
        _ => None,
    };
    if let Some((what, most)) = too_long {
        let most = most >> 20;
        let problem =
            format!("{what} unfolds into more than {most} MB, and was not packed by gearmesh");
        return Err(PackageError::contents(path, problem));
    }
    Ok(Some(bytes))
}

/// Contents of a packed FMU.
#[derive(Debug, Clone, PartialEq)]
pub struct Inspection {
    /// Name, GUID, pair and start values.
    pub unit: UnitFile,
    /// Text of the tables, if there are any.
    pub tables: Option<String>,
    /// Communication step of the default experiment, s.
    pub step_size: f64,
    /// The contact at run time, if it is there.
    pub contact: Option<ContactFile>,
    /// Platforms there are libraries for, in words, each with what its library needs.
    pub platforms: Vec<String>,
    /// Every file with its size in bytes.
    pub files: Vec<(String, u64)>,
}

/// Reads the FMU at `path`.
///
/// # Errors
/// A file that cannot be read or is no FMU that this program packed.
pub fn inspect(path: &Path) -> Result<Inspection, PackageError> {
    let mut archive = opened(path)?;
    let mut files = Vec::new();
    for i in 0..archive.len() {
        let entry = archive.by_index(i);
        let entry = entry.map_err(|e| PackageError::archive(path, e))?;
        files.push((entry.name().to_owned(), entry.size()));
    }
    let faulty =
        |name: &str, reason: &str| PackageError::contents(path, format!("{name}: {reason}"));
    let mut read = 0;
    let mut bytes = |name: &str| bytes(&mut archive, path, name, &mut read);
    let mut text = |name: &str| -> Result<Option<String>, PackageError> {
        let text = bytes(name)?.map(String::from_utf8).transpose();
        text.map_err(|_| faulty(name, "no text, and was not packed by gearmesh"))
    };
    let unit = format!("resources/{UNIT_FILE}");
    let found =
        text(&unit)?.ok_or_else(|| faulty(&unit, "is missing; it was not packed by gearmesh"))?;
    let unit = parse_unit(found.as_bytes()).map_err(|reason| faulty(&unit, &reason))?;
    let tables = text(&format!("resources/{TABLES_FILE}"))?;
    let description = text(DESCRIPTION)?.unwrap_or_default();
    let step_size = description.split_once("stepSize=\"");
    let step_size = step_size.and_then(|(_, rest)| rest.split('"').next()?.parse().ok());
    let contact = format!("resources/{CONTACT_FILE}");
    let found = bytes(&contact)?.as_deref().map(ContactFile::from_bytes);
    let contact = (found.transpose()).map_err(|reason| faulty(&contact, &reason))?;
    let mut platforms = Vec::new();
    for (name, _) in files.iter().filter(|(name, _)| !name.ends_with('/')) {
        if let ["binaries", platform, _, ..] = name.split('/').collect::<Vec<_>>()[..] {
            platforms.push(runs_on(platform, &bytes(name)?.unwrap_or_default()));
        }
    }
    platforms.sort();
    Ok(Inspection {
        unit,
        tables,
        step_size: step_size
            .ok_or_else(|| faulty(DESCRIPTION, "no stepSize in its default experiment"))?,
        contact,
        platforms,
        files,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

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

    /// Each of the libraries is short enough by itself.
    #[test]
    fn an_archive_that_unfolds_beyond_its_bound_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bomb.fmu");
        let mut archive = ZipWriter::new(File::create(&path).unwrap());
        let options = SimpleFileOptions::default().compression_level(Some(1));
        let block = vec![0; 1 << 20];
        for platform in 0..5 {
            let name = format!("binaries/{platform}/gearmesh.so");
            archive.start_file(name, options).unwrap();
            (0..250).for_each(|_| archive.write_all(&block).unwrap());
        }
        archive.finish().unwrap();
        let mut archive = opened(&path).unwrap();
        let (mut read, mut refused) = (0, None);
        for platform in 0..5 {
            let name = format!("binaries/{platform}/gearmesh.so");
            refused = refused.or(bytes(&mut archive, &path, &name, &mut read).err());
        }
        let error = refused.unwrap().to_string();
        assert!(
            error.contains("bomb.fmu: it unfolds into more than 1024 MB"),
            "{error}"
        );
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
        let words = ["libgearmesh.so", "--library"];
        assert!(words.iter().all(|w| error.contains(w)), "{error}");
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
