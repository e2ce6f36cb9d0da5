//! What a call has to say: its status and the text for the host's log.

use super::variables::LOG_CATEGORIES;

/// Status of a call that did not just succeed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    /// fmi2Warning.
    Warning,
    /// fmi2Discard: not available, state unchanged.
    Discard,
    /// fmi2Error.
    Error,
    /// fmi2Fatal.
    Fatal,
}

/// A call that is refused, with the reason.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct Refusal {
    /// Status to return.
    pub severity: Severity,
    /// Names the field, the value and the remedy.
    pub message: String,
}

impl Refusal {
    /// fmi2Error with `message`.
    pub fn error(message: impl Into<String>) -> Self {
        Self {
            severity: Severity::Error,
            message: message.into(),
        }
    }

    /// fmi2Discard with `message`.
    pub fn discard(message: impl Into<String>) -> Self {
        Self {
            severity: Severity::Discard,
            message: message.into(),
        }
    }
}

/// Where the element has no outputs, the host may try elsewhere.
pub(super) fn refuse(error: crate::element::ElementError) -> Refusal {
    Refusal::discard(error.to_string())
}

/// What a call has to say beside its status.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Event {
    /// For those who want events.
    Told(String),
    /// What comes out may not be trusted from here on; the call itself did what it should.
    Warned(String),
}

/// Log category of events.
pub const EVENTS: &str = "logEvents";

impl Severity {
    /// Its log category, one of [`LOG_CATEGORIES`].
    pub const fn category(self) -> &'static str {
        match self {
            Severity::Warning => "logStatusWarning",
            Severity::Discard => "logStatusDiscard",
            Severity::Error => "logStatusError",
            Severity::Fatal => "logStatusFatal",
        }
    }
}

/// Which categories the host hears.
///
/// `loggingOn` of fmi2Instantiate and fmi2SetDebugLogging without categories speak of debug logging:
/// here, of events. Why a call was refused is no debug output. It reaches the logger until the host
/// switches the category off by its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Wanted([bool; LOG_CATEGORIES.len()]);

impl Wanted {
    /// Reports of refused calls and, if `debug`, events.
    pub fn new(debug: bool) -> Self {
        Self(LOG_CATEGORIES.map(|category| debug || category != EVENTS))
    }

    /// Whether `category` is wanted.
    pub fn contains(&self, category: &str) -> bool {
        LOG_CATEGORIES
            .iter()
            .position(|c| *c == category)
            .is_some_and(|i| self.0[i])
    }

    /// fmi2SetDebugLogging: switches `categories`; without any, all of them on, or debug logging off.
    ///
    /// # Errors
    /// A category that modelDescription.xml does not declare; nothing is changed.
    pub fn switch(&mut self, on: bool, categories: &[&str]) -> Result<(), Refusal> {
        let all = if on { &LOG_CATEGORIES[..] } else { &[EVENTS] };
        let mut wanted = *self;
        for category in if categories.is_empty() {
            all
        } else {
            categories
        } {
            let i = LOG_CATEGORIES
                .iter()
                .position(|c| c == category)
                .ok_or_else(|| {
                    let known = LOG_CATEGORIES.join(", ");
                    Refusal::error(format!("log category '{category}' is none of {known}"))
                })?;
            wanted.0[i] = on;
        }
        *self = wanted;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_category_in_use_is_declared() {
        use Severity::*;
        for category in [Warning, Discard, Error, Fatal].map(Severity::category) {
            assert!(LOG_CATEGORIES.contains(&category), "{category}");
        }
        assert!(LOG_CATEGORIES.contains(&EVENTS));
    }

    #[test]
    fn an_undeclared_category_changes_nothing() {
        let mut wanted = Wanted::new(false);
        let error = wanted
            .switch(true, &["logEvents", "logNonsense"])
            .unwrap_err();
        assert!(error.message.contains("logNonsense"));
        assert_eq!(wanted, Wanted::new(false));
        wanted.switch(true, &["logEvents"]).unwrap();
        assert!(wanted.contains("logEvents"));
    }

    #[test]
    fn refusals_are_heard_until_they_are_switched_off_by_name() {
        let mut wanted = Wanted::new(false);
        assert!(wanted.contains("logStatusError") && !wanted.contains("logEvents"));
        wanted.switch(true, &[]).unwrap();
        assert!(wanted.contains("logEvents"));
        wanted.switch(false, &[]).unwrap();
        assert!(wanted.contains("logStatusError") && !wanted.contains("logEvents"));
        wanted.switch(false, &["logStatusError"]).unwrap();
        assert!(!wanted.contains("logStatusError") && wanted.contains("logStatusFatal"));
        wanted.switch(false, &[]).unwrap();
        assert!(!wanted.contains("logStatusError"));
    }
}
