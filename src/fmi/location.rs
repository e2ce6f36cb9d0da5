//! Where a host unpacked the resources: from its URI to a folder.

use std::path::PathBuf;

/// The folder a host means by `uri`, on this machine.
///
/// # Errors
/// What is wrong with the URI.
pub fn folder(uri: &str) -> Result<PathBuf, &'static str> {
    decode(uri, cfg!(windows)).map(PathBuf::from)
}

/// Path of a file URI (RFC 8089): `file:///p`, `file:/p`, `file://localhost/p`, percent-encoded
/// UTF-8, on Windows with a drive letter or a host. A plain absolute path is taken as it is, since
/// some hosts pass one.
fn decode(uri: &str, windows: bool) -> Result<String, &'static str> {
    let scheme = uri.get(..5).unwrap_or("");
    if !scheme.eq_ignore_ascii_case("file:") {
        let absolute = uri.starts_with('/') || (windows && is_drive(uri));
        return if absolute {
            Ok(uri.to_owned())
        } else {
            Err("it is neither a file URI nor an absolute path")
        };
    }
    let rest = &uri[5..];
    let (host, path) = match rest.strip_prefix("//") {
        Some(authority) => authority.split_at(authority.find('/').unwrap_or(authority.len())),
        None => ("", rest),
    };
    let path = percent_decode(path)?;
    if !host.is_empty() && !host.eq_ignore_ascii_case("localhost") {
        return if windows {
            Ok(format!("//{}{path}", percent_decode(host)?))
        } else {
            Err("it names another host")
        };
    }
    if !path.starts_with('/') {
        return Err("its path is not absolute");
    }
    if windows && is_drive(&path[1..]) {
        return Ok(path[1..].replacen('|', ":", 1));
    }
    Ok(path)
}

/// Whether `path` starts with a drive: `C:` or the old `C|`.
fn is_drive(path: &str) -> bool {
    let bytes = path.as_bytes();
    bytes.len() >= 2 && bytes[0].is_ascii_alphabetic() && matches!(bytes[1], b':' | b'|')
}

fn percent_decode(text: &str) -> Result<String, &'static str> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.bytes();
    while let Some(byte) = rest.next() {
        if byte != b'%' {
            bytes.push(byte);
            continue;
        }
        let mut digit = || rest.next().and_then(|b| char::from(b).to_digit(16));
        match (digit(), digit()) {
            (Some(high), Some(low)) => bytes.push((16 * high + low) as u8),
            _ => return Err("a % is not followed by two hexadecimal digits"),
        }
    }
    String::from_utf8(bytes).map_err(|_| "its percent-encoded bytes are not UTF-8")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_legal_file_uri_leads_to_its_folder() {
        for (uri, path) in [
            ("file:///tmp/fmu/resources", "/tmp/fmu/resources"),
            ("file:/tmp/fmu/resources", "/tmp/fmu/resources"),
            ("FILE://localhost/tmp/a", "/tmp/a"),
            ("file:///tmp/with%20space/a", "/tmp/with space/a"),
            ("file:///tmp/%C3%BCml%c3%a4ut", "/tmp/ümläut"),
            ("file:///tmp/ümläut", "/tmp/ümläut"),
            ("file:///tmp/100%25/a+b", "/tmp/100%/a+b"),
            ("/tmp/plain path", "/tmp/plain path"),
        ] {
            assert_eq!(decode(uri, false).as_deref(), Ok(path), "{uri}");
        }
        for (uri, path) in [
            ("file:///C:/a%20b/r", "C:/a b/r"),
            ("file:/C:/a/r", "C:/a/r"),
            ("file:///c|/a/r", "c:/a/r"),
            ("file://server/share/r", "//server/share/r"),
            ("C:\\a\\r", "C:\\a\\r"),
        ] {
            assert_eq!(decode(uri, true).as_deref(), Ok(path), "{uri}");
        }
    }

    #[test]
    fn a_location_that_is_no_local_folder_is_refused() {
        for uri in [
            "",
            "http://host/a",
            "relative/path",
            "file:relative",
            "file://server/share",
            "file:///a%2",
            "file:///a%zz",
            "file:///a%ff",
        ] {
            assert!(folder(uri).is_err(), "{uri}");
        }
    }
}
