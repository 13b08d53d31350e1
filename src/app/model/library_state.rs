//! A state of a tool library. Each frame compares states and undo keeps them, which must be cheap for large
//! libraries too: states share their tools, and are compared by revision number.

use std::ops::Deref;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::io::shop_tools::ToolLibrary;

/// Number of the state that was made last, of any library.
static LAST: AtomicU64 = AtomicU64::new(0);

fn next() -> u64 {
    LAST.fetch_add(1, Ordering::Relaxed) + 1
}

/// A state of a library. Two are equal if they have the same revision.
#[derive(Clone, Debug)]
pub struct LibraryState {
    revision: u64,
    content: Arc<ToolLibrary>,
}

impl PartialEq for LibraryState {
    fn eq(&self, other: &Self) -> bool {
        self.revision == other.revision
    }
}

impl Deref for LibraryState {
    type Target = ToolLibrary;

    fn deref(&self) -> &ToolLibrary {
        &self.content
    }
}

impl From<ToolLibrary> for LibraryState {
    fn from(content: ToolLibrary) -> Self {
        Self { revision: next(), content: Arc::new(content) }
    }
}

impl LibraryState {
    /// Changes the library. Where this makes it what one of the `known` states is, it is that one again: an
    /// edit that was taken back by hand is none.
    pub fn edit(&mut self, known: &[Option<&Self>], change: impl FnOnce(&mut ToolLibrary)) {
        // Clones pointers to the tools where another state has them too, and no tool.
        change(Arc::make_mut(&mut self.content));
        let same = known.iter().flatten().find(|state| state.content == self.content);
        self.revision = same.map_or_else(next, |state| state.revision);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_share_their_tools_and_a_taken_back_edit_is_none() {
        let tool = crate::io::tool_library::plunge_cutters()[0].clone();
        let entry = crate::io::shop_tools::LibraryTool { tool, notes: Vec::new() };
        let tools = std::iter::repeat_with(|| Arc::new(entry.clone())).take(3).collect();
        let first = LibraryState::from(ToolLibrary { tools, ..ToolLibrary::default() });
        let mut second = first.clone();
        assert!(first == second);
        second.edit(&[Some(&first)], |library| Arc::make_mut(&mut library.tools[1]).tool.number += 1);
        assert!(first != second);
        let shared = first.tools.iter().zip(&second.tools).filter(|(a, b)| Arc::ptr_eq(a, b)).count();
        assert_eq!(shared, 2, "all but the one that was edited");
        let third = second.clone();
        second.edit(&[None, Some(&first)], |library| Arc::make_mut(&mut library.tools[1]).tool.number -= 1);
        assert!(first == second && third != second);
    }
}
