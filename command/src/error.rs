//! Errors of the subcommands.

/// Any error of a subcommand; its chain is printed on one line.
pub type Error = Box<dyn std::error::Error>;

pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Ends a function with an error in these words.
macro_rules! refuse {
    ($($words:tt)*) => {
        return Err(format!($($words)*).into())
    };
}

/// An error and its causes on one line. A cause whose text the line contains already is left out.
pub fn chain(error: &dyn std::error::Error) -> String {
    let mut line = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        let text = error.to_string();
        if !line.contains(&text) {
            line.push_str(": ");
            line.push_str(&text);
        }
        cause = error.source();
    }
    line.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io;

    #[test]
    fn a_chain_of_errors_is_one_line_and_says_nothing_twice() {
        let inner = io::Error::other("disk\nfull");
        let line = chain(&io::Error::other(inner));
        assert_eq!(line.matches("disk full").count(), 1, "{line}");
        assert!(!line.contains('\n'));
    }
}
