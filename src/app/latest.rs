//! A background computation of which only the latest request counts: a newer request supersedes the running
//! one, and the last answer stays until the next arrives.

use std::convert::Infallible;

use crate::job::worker::{Outcome, Worker};

/// The worker thread with the latest request and answer.
pub(super) struct Latest<Q, A> {
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
    pub(super) fn new(
        name: &str,
        ctx: &egui::Context,
        answer: impl Fn(&Q) -> A + Send + Sync + 'static,
    ) -> Self {
        let ctx = ctx.clone();
        let work = move |question: &Q, _: &crate::monitor::Monitor| Ok((question.clone(), answer(question)));
        let worker = Worker::new(name, work, move || ctx.request_repaint());
        Self { worker, asked: None, answer: None }
    }

    /// Submits `wanted` unless it was submitted already, and collects a finished answer. `None` clears the
    /// answer.
    pub(super) fn request(&mut self, wanted: Option<Q>) {
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

    /// The latest answer with its request, which may be older than the last request.
    pub(super) fn answer(&self) -> Option<&(Q, A)> {
        self.answer.as_ref()
    }

    /// Whether a request is being answered.
    pub(super) fn is_busy(&self) -> bool {
        self.worker.is_busy()
    }
}
