//! Bytes that show when they were cut or altered: 32 bytes that name a format and its version, SHA-256 of the contents, the
//! contents.

use sha2::{Digest, Sha256};

/// Bytes before the contents.
pub const HEAD: usize = 64;

/// `contents` of the format `magic`.
pub fn seal(magic: &[u8; 32], contents: &[u8]) -> Vec<u8> {
    [magic, &Sha256::digest(contents)[..], contents].concat()
}

/// The contents that [`seal`] made `bytes` of.
///
/// # Errors
/// Another format or version, or bytes that were cut or altered, as text.
pub fn open<'a>(magic: &[u8; 32], bytes: &'a [u8]) -> Result<&'a [u8], &'static str> {
    let rest = bytes.strip_prefix(magic);
    let rest = rest.ok_or("it is not of this format and version")?;
    match rest.split_first_chunk::<{ HEAD - 32 }>() {
        Some((checksum, contents)) if Sha256::digest(contents)[..] == checksum[..] => Ok(contents),
        _ => Err("it was cut or altered"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_cut_altered_or_of_another_version_is_refused() {
        let [magic, other] = [
            b"gearmesh test of this file v001\n",
            b"gearmesh test of this file v002\n",
        ];
        let contents: Vec<u8> = (0..100).collect();
        let sealed = seal(magic, &contents);
        assert_eq!(sealed.len(), HEAD + contents.len());
        assert_eq!(open(magic, &sealed), Ok(&contents[..]));
        assert!(open(other, &sealed).unwrap_err().contains("version"));
        for i in 0..sealed.len() {
            let mut altered = sealed.clone();
            altered[i] ^= 1;
            assert!(open(magic, &altered).is_err(), "byte {i}");
            assert!(open(magic, &sealed[..i]).is_err(), "{i} bytes");
        }
        assert!(open(magic, &[&sealed[..], &[0]].concat()).is_err());
    }
}
