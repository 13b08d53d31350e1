//! Stage 3 by our own rule: the least residual layer with no contact of the core (DESIGN sections 2.3 and 3).
//!
//! What decides is whether the core meets stock, so that is the constraint and the layer left on the hub the
//! objective. A row is a path through the candidates of its positions: dynamic programming over the feed tilt. A
//! step costs the layer its position leaves; where the core would meet stock the plunge
//! stops short of it, and the layer that leaves is paid for as well, so that
//! the search leans, waits or goes around as is cheapest. Single plunges are added where the rows left the most.

mod candidate;
mod crossing;
mod extras;
mod floor;
mod path;
mod section;
mod touch_up;

pub use candidate::CandidateMaker;
pub use crossing::Crossing;
pub use extras::ExtraSearch;
pub use floor::Floor;
pub use path::PathSearch;
pub use section::MOST_LIFT;
