//! Where a host unpacked the resources: from its URI to a folder.

use std::path::{Path, PathBuf};
use url::Url;

/// The folder a host means by `location` on this machine: that of a file URI (RFC 8089), or an absolute path
/// as it is, since some hosts pass one.
///
/// # Errors
/// What is wrong with the location.
pub fn folder(location: &str) -> Result<PathBuf, &'static str> {
    // First: to a URL, the drive of a path on Windows is a scheme.
    if Path::new(location).is_absolute() {
        return Ok(location.into());
    }
    let url = Url::parse(location).map_err(|_| "it is neither a file URI nor an absolute path")?;
    if url.scheme() != "file" {
        return Err("it is not a file URI");
    }
    url.to_file_path()
        .or_else(|()| on_the_current_drive(&url))
        .map_err(|()| "it names no folder of this machine")
}

/// On Windows a path without a drive is one of the current drive, as a host in wine gives it.
fn on_the_current_drive(url: &Url) -> Result<PathBuf, ()> {
    if url.host().is_some() {
        return Err(());
    }
    let here = Url::from_directory_path(std::env::current_dir().map_err(drop)?)?;
    here.join(url.path()).map_err(drop)?.to_file_path()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn every_legal_file_uri_leads_to_its_folder() {
        for (uri, path) in [
            ("file:///tmp/fmu/resources", "/tmp/fmu/resources"),
            ("file:/tmp/fmu/resources", "/tmp/fmu/resources"),
            ("FILE://localhost/tmp/a", "/tmp/a"),
            ("file:///tmp/with%20space/a", "/tmp/with space/a"),
            ("file:///tmp/with space/a", "/tmp/with space/a"),
            ("file:///tmp/%C3%BCml%c3%a4ut", "/tmp/ümläut"),
            ("file:///tmp/ümläut", "/tmp/ümläut"),
            ("file:///tmp/100%25/a+b", "/tmp/100%/a+b"),
            ("/tmp/plain path", "/tmp/plain path"),
            ("/tmp/100%25", "/tmp/100%25"),
        ] {
            assert_eq!(folder(uri).as_deref(), Ok(Path::new(path)), "{uri}");
        }
    }

    #[cfg(windows)]
    #[test]
    fn every_legal_file_uri_leads_to_its_folder() {
        for (uri, path) in [
            ("file:///C:/a%20b/r", "C:\\a b\\r"),
            ("file:/C:/a/r", "C:\\a\\r"),
            ("file:///c|/a/r", "C:\\a\\r"),
            ("file://server/share/r", "\\\\server\\share\\r"),
            ("C:\\a\\r", "C:\\a\\r"),
        ] {
            assert_eq!(folder(uri).as_deref(), Ok(Path::new(path)), "{uri}");
        }
        let found = folder("file:///a%20b/r").unwrap();
        assert!(
            found.is_absolute() && found.ends_with("a b\\r"),
            "{found:?}"
        );
    }

    #[test]
    fn a_location_that_is_no_local_folder_is_refused() {
        for uri in ["", "http://host/a", "relative/path"] {
            assert!(folder(uri).is_err(), "{uri}");
        }
        #[cfg(unix)]
        assert!(folder("file://server/share").is_err());
    }
}
