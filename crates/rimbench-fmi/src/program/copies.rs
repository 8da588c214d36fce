//! Copies of a program's state: of all but the present one it has given its state away, and gets it back when its turn comes.

use super::conversation::Conversation;
use super::messages::{Request, wanted};
use serde_json::value::RawValue;

/// A conversation about several copies of one state, the first of which is 0.
pub(super) struct Copies {
    conversation: Conversation,
    /// Of each copy that somebody has, the state while another is the present one.
    kept: Vec<Option<Box<RawValue>>>,
    used: Vec<bool>,
    present: usize,
}

impl Copies {
    pub(super) fn new(conversation: Conversation) -> Self {
        Copies { conversation, kept: vec![None], used: vec![true], present: 0 }
    }

    /// The conversation, about one copy.
    pub(super) fn of(&mut self, copy: usize) -> Result<&mut Conversation, String> {
        if copy != self.present {
            if self.used[self.present] {
                self.kept[self.present] = Some(self.state()?);
            }
            if let Some(state) = self.kept[copy].take() {
                self.conversation.ask(&Request::Restore { state: &state }, |_| Ok(()))?;
            }
            self.present = copy;
        }
        Ok(&mut self.conversation)
    }

    fn state(&mut self) -> Result<Box<RawValue>, String> {
        self.conversation.ask(&Request::State, |reply| wanted(reply.state, "state"))
    }

    /// Makes a copy of a copy, and says which it is. Where the program fails at that the conversation is over, and whoever uses the copy
    /// is told why.
    pub(super) fn copy(&mut self, of: usize) -> usize {
        let given = self.of(of).map(|_| ()).and_then(|()| self.state());
        let state = given.ok();
        if let Some(free) = self.used.iter().position(|used| !used).filter(|free| *free != self.present) {
            (self.used[free], self.kept[free]) = (true, state);
            return free;
        }
        self.used.push(true);
        self.kept.push(state);
        self.used.len() - 1
    }

    /// Forgets a copy.
    pub(super) fn drop_copy(&mut self, copy: usize) {
        (self.used[copy], self.kept[copy]) = (false, None);
    }
}
