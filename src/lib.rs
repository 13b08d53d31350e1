//! Vanecut plans the rough milling of centrifugal impellers.
//!
//! Modules, innermost first; each depends only on modules listed before it (`tests/layering.rs`):
//!
//! | module | contents |
//! |---|---|
//! | [`palette`] | colours of pictures and window |
//! | [`geometry`] | curves, surfaces of revolution, blade sides, root finding, distances |
//! | [`part`] | impeller, channel, blank, tools, setup |
//! | [`mesh`] | triangle meshes of a part, and parts from triangle meshes |
//! | [`assess`] | machinability before any plan: twist, bow, depth, width, reach ([assessment paper]) |
//! | [`plunge`] | the plunge planner, one file per stage of the [plunge paper], and contact of the core |
//! | [`flank`] | the flank planner ([flank paper]): layers, regions, passes, and the cutter axes along them |
//! | [`residual`] | the heightfield of residual stock on the channel floor, and its CPU kernel |
//! | [`verify`] | checks any cutter-location program against a part |
//! | [`formats`] | readers and writers of part, setup, CL and plan files |
//! | [`job`] | planning jobs: request, progress, cancel, latest result |
//! | `gpu` | graphics device, compute kernel, renderer; independent of the window |
//! | `app`, [`cli`] | the front ends: the egui window and the command line |
//!
//! Lengths are mm, angles radians, times seconds, feed rates mm/min; files and user interfaces show degrees.
//! The axis of rotation is Z. `docs/REFERENCES.md` cites the papers.
#![forbid(unsafe_code)]
#![warn(missing_docs)]

#[cfg(feature = "window")]
pub mod app;
pub mod assess;
#[cfg(feature = "window")]
pub mod cli;
pub mod flank;
pub mod formats;
pub mod geometry;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod job;
pub mod mesh;
pub mod monitor;
pub mod palette;
pub mod part;
pub mod plunge;
pub mod residual;
pub mod verify;
