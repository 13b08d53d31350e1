//! A background computation of which only the latest request counts: a newer request supersedes the running
//! one, and the last answer stays until the next arrives.

use std::convert::Infallible;
use std::sync::Arc;

use super::Repaint;
use crate::job::worker::{Outcome, Worker};

/// The worker thread with the latest request and answer.
pub(in crate::app) struct Latest<Q, A> {
    worker: Worker<Q, (Q, A), Infallible>,
    asked: Option<Q>,
    answer: Option<(Q, A)>,
}

impl<Q, A> Latest<Q, A>
where
    Q: Clone + PartialEq + Send + 'static,
    A: Send + 'static,
{
    /// Starts the thread; it repaints the window after each answer.
    pub(in crate::app) fn new(
        name: &str,
        repaint: &Repaint,
        answer: impl Fn(&Q) -> A + Send + Sync + 'static,
    ) -> Self {
        let repaint = Arc::clone(repaint);
        let work = move |question: &Q, _: &crate::monitor::Monitor| Ok((question.clone(), answer(question)));
        let worker = Worker::new(name, work, move || repaint());
        Self { worker, asked: None, answer: None }
    }

    /// Submits `wanted` unless it was submitted already, and collects a finished answer. `None` clears the
    /// answer.
    pub(in crate::app) fn request(&mut self, wanted: Option<Q>) {
        if let Some((_, Outcome::Done(answer))) = self.worker.take_outcome() {
            self.answer = Some(answer);
        }
        if wanted == self.asked {
            return;
        }
        match &wanted {
            Some(question) => {
                self.worker.submit(question.clone());
            }
            None => {
                self.worker.cancel();
                self.answer = None;
            }
        }
        self.asked = wanted;
    }

    /// The last request.
    pub(in crate::app) fn asked(&self) -> Option<&Q> {
        self.asked.as_ref()
    }

    /// The latest answer with its request, which may be older than the last request.
    pub(in crate::app) fn answer(&self) -> Option<&(Q, A)> {
        self.answer.as_ref()
    }

    /// Whether a request is being answered, or its answer is not collected yet.
    pub(in crate::app) fn is_busy(&self) -> bool {
        self.worker.is_busy() || self.worker.has_outcome()
    }
}
