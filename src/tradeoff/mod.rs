//! Time against stock: which plunges of a finished plan are worth their time.
//!
//! `minimal` adds plunges as long as each removes something worth removing. From its plan plunges are left
//! out one by one, the one first that leaves the least stock per second saved (lazy greedy on a supermodular
//! cost). What is left out must not be missed: no core may meet stock, the floor stays cut, and the scallop
//! along walls stays within its limit. The order in which plunges go is the curve of time against stock, and
//! every point of it is a plan.
//!
//! | file | contents |
//! |---|---|
//! | `clock` | how long a plan takes |
//! | `floor` | the stock that plunges leave, and what each of them is worth |
//! | `limits` | how far a plan may be thinned |
//! | `cores` | which plunges make the way for the core of which |
//! | `neighbours` | the plunges beside one that are still in the plan |
//! | `walls` | the rows that keep the scallop along walls within its limit |
//! | `thinning` | the order in which plunges are left out |
//! | `curve` | points of the curve, and the one that a goal asks for |

mod clock;
mod cores;
mod curve;
mod floor;
mod limits;
mod neighbours;
mod thinning;
mod walls;

pub use clock::PlanClock;
pub use curve::{Tradeoff, TradeoffPoint};
pub use limits::ThinningLimits;
pub use thinning::{Thinning, ThinningInput};
