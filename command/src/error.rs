//! Errors of the subcommands.

/// Any error of a subcommand.
pub type Error = Box<dyn std::error::Error>;

pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Ends a function with an error in these words.
macro_rules! refuse {
    ($($words:tt)*) => {
        return Err(format!($($words)*).into())
    };
}

/// An error and its causes; of several in one each has a line, from the second on indented. A cause whose text is there already is
/// left out.
pub fn chain(error: &dyn std::error::Error) -> String {
    let mut all = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        let text = error.to_string();
        if !all.contains(&text) {
            all.push_str(": ");
            all.push_str(&text);
        }
        cause = error.source();
    }
    let lines = all.lines().map(|line| {
        let words: Vec<&str> = line.split_whitespace().collect();
        words.join(" ")
    });
    let lines: Vec<String> = lines.filter(|line| !line.is_empty()).collect();
    lines.join("\n  ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io;

    #[test]
    fn a_chain_of_errors_says_nothing_twice_and_each_of_several_on_a_line() {
        let inner = io::Error::other("disk  full\n\nand slow\n");
        let line = chain(&io::Error::other(inner));
        assert_eq!(line, "disk full\n  and slow");
    }
}
