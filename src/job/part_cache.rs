//! Cache of what a job computed for the last part.

use std::sync::{Arc, Mutex, PoisonError};

use crate::part::Impeller;

/// What was computed for a part.
#[derive(Debug)]
struct CachedPart<T> {
    part: Arc<Impeller>,
    cache: T,
}

/// Cache of the last part that a job worked on; one job at a time uses it.
#[derive(Debug)]
pub(super) struct PartCache<T>(Mutex<Option<CachedPart<T>>>);

impl<T> Default for PartCache<T> {
    fn default() -> Self {
        Self(Mutex::new(None))
    }
}

impl<T: Default> PartCache<T> {
    /// Runs `work` with the cache of `part`, which is empty if the last part was another one.
    pub(super) fn with<R>(&self, part: &Arc<Impeller>, work: impl FnOnce(&mut T) -> R) -> R {
        let mut last = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let known = last.take().filter(|known| Arc::ptr_eq(&known.part, part));
        let mut cache = known.map(|known| known.cache).unwrap_or_default();
        let result = work(&mut cache);
        *last = Some(CachedPart { part: Arc::clone(part), cache });
        result
    }
}
