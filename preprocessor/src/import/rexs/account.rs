//! Where the fields of an imported pair file come from.

/// Where a line of the account belongs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Head {
    Taken,
    Derived,
    Assumed,
    Left,
    Warning,
    Note,
}

/// Where the fields come from: each line once.
#[derive(Default)]
pub(super) struct Account(Vec<(Head, String)>);

impl Account {
    pub(super) fn add(&mut self, head: Head, line: impl Into<String>) {
        let line = (head, line.into());
        if !self.0.contains(&line) {
            self.0.push(line);
        }
    }

    pub(super) fn lines(mut self) -> Vec<String> {
        self.0.sort_by_key(|(head, _)| *head);
        let lines = self.0.into_iter().map(|(head, line)| {
            let head = format!("{head:?}").to_lowercase();
            format!("{head}: {line}\n")
        });
        lines.collect()
    }
}
