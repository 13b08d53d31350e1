//! A question answered in the background: a newer one supersedes it, and the latest answer stays until the next is
//! there.

use std::convert::Infallible;

use crate::job::worker::{End, Worker};

/// The thread with its latest answer.
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
    /// Starts the thread; it repaints the window when it has something.
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

    /// Asks, if this is not what was asked already, and takes in what has come. `None` forgets everything.
    pub(super) fn follow(&mut self, wanted: Option<Q>) {
        if let Some((_, End::Done(answer))) = self.worker.take_end() {
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

    /// The latest answer with its question; it may be older than what was asked last.
    pub(super) fn answer(&self) -> Option<&(Q, A)> {
        self.answer.as_ref()
    }

    /// Whether something is on its way.
    pub(super) fn is_busy(&self) -> bool {
        self.worker.is_busy()
    }
}
