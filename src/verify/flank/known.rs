//! What a verifier knows of the last program, and what that tells of the next one.

use super::{FlankVerifier, LastProgram, StepKey};
use crate::stock::solid::{Contact, ToolPart};

impl FlankVerifier<'_> {
    /// This verifier with what a planner's knows, one of the same workpiece and setup but for tools: the
    /// results of steps, which are the same for both, and what the last program meets of standing stock, if
    /// even thicker shanks and holders meet none.
    #[must_use]
    pub fn taking_over(self, planner: FlankVerifier<'_>) -> Self {
        let FlankVerifier { tools, cache, last, standing, .. } = planner;
        let known = Self { tools, cache, ..self };
        let above_cutter = |part: ToolPart| matches!(part, ToolPart::Shank | ToolPart::Holder);
        let only_cutters = |found: &Vec<Contact>| !found.iter().any(|contact| above_cutter(contact.part));
        match last {
            Some(last) if last.contacts.as_ref().is_some_and(only_cutters) => {
                // Depths of cuts count otherwise.
                let last = LastProgram { floors: None, ..last };
                Self { last: Some(last), standing: standing.with_exact_tools(), ..known }
            }
            _ => known,
        }
    }

    /// Lines of the rapids in the last program without other faults whose cutter touches standing stock
    /// hardly less than what is a fault: rounding may make it one.
    pub fn grazing_rapids(&self) -> &[usize] {
        &self.grazing
    }

    /// The contacts with standing stock of a program with these steps, as far as the last program tells them:
    /// there are none where it makes all moves that met stock under feed instead of in rapid, as it removes
    /// more stock then.
    pub(super) fn known_contacts(&mut self, keys: &[(StepKey, i64)]) -> Option<Vec<Contact>> {
        let LastProgram { steps, contacts, .. } = self.last.take()?;
        let contacts = contacts?;
        if steps == keys {
            return Some(contacts);
        }
        let is_slowed = |k: usize| !steps[k].0.1 && keys[k].0.1;
        let is_same = |((before, a), (now, b)): (&(StepKey, i64), &(StepKey, i64))| {
            (before.0, before.2, a) == (now.0, now.2, b) && (before.1 == now.1 || now.1)
        };
        let is_free = steps.len() == keys.len()
            && steps.iter().zip(keys).all(is_same)
            && contacts.iter().all(|c| c.part == ToolPart::Cutter && is_slowed(c.number as usize));
        is_free.then(Vec::new)
    }
}
