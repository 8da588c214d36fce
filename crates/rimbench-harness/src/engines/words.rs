//! A command, word by word, and as a shell reads it.

use std::fmt::{Display, Formatter};

/// Program and arguments of a command.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Words(Vec<String>);

impl Words {
    /// Begins with the program.
    pub fn of(program: impl Display) -> Self {
        Words(vec![program.to_string()])
    }

    /// Adds words.
    pub fn extend(&mut self, words: impl IntoIterator<Item = String>) {
        self.0.extend(words);
    }

    /// Adds an option and its value, in two words.
    pub fn option(&mut self, name: &str, value: impl Display) {
        self.0.extend([name.to_owned(), value.to_string()]);
    }

    /// Adds an option and its value, in one word.
    pub(super) fn joined(&mut self, name: &str, value: impl Display) {
        self.0.push(format!("{name}={value}"));
    }

    /// Adds an option without a value.
    pub(super) fn flag(&mut self, name: &str) {
        self.0.push(name.to_owned());
    }

    /// Returns program and arguments.
    pub fn words(&self) -> &[String] {
        &self.0
    }
}

/// As a shell reads it: what is no plain word is quoted.
impl Display for Words {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        for (index, word) in self.0.iter().enumerate() {
            let between = if index == 0 { "" } else { " " };
            let plain = |c: char| c.is_ascii_alphanumeric() || "/._-=,:%+@".contains(c);
            if !word.is_empty() && word.chars().all(plain) {
                write!(f, "{between}{word}")?;
            } else {
                write!(f, "{between}'{}'", word.replace('\'', "'\\''"))?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(unix)]
    fn a_shell_reads_the_words_that_were_written() {
        for word in ["plain", "", "two words", "it's", "$HOME", "a\"b", "back\\slash", "{}", "*", "ö"] {
            let mut command = Words::of("printf");
            command.extend(["%s".to_owned(), word.to_owned()]);
            let output = std::process::Command::new("sh").args(["-c", &command.to_string()]).output().unwrap();
            assert_eq!(String::from_utf8_lossy(&output.stdout), word);
        }
    }
}
