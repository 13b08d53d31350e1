//! Vanecut plans the rough milling of centrifugal impellers.
//!
//! Rooms, innermost first; each may look only at those before it:
//!
//! | room | holds |
//! |---|---|
//! | [`palette`] | the colours, declared once |
//! | [`geometry`] | curves, surfaces of revolution, blade sides, root finding, distances |
//! | [`part`] | impeller, channel, blank, tools, setup |
//! | [`mesh`] | triangle meshes of a part, and parts from triangle meshes |
//! | [`assess`] | machinability before any plan: twist, bend, depth, width, reach |
//! | [`plunge`] | the plunge planner, one file per stage of paper A, and contact of the core |
//! | [`flank`] | the flank region planner: layers, regions, curves, and the cutters along them |
//! | [`residual`] | the heightfield of stock left on the hub, and its CPU kernel |
//! | [`verify`] | checks any cutter-location program against a part |
//! | [`formats`] | readers and writers of part, setup, CL and plan files |
//! | [`job`] | background work: request, progress, cancel, latest result |
//! | `gpu` | device, compute kernel, renderer; knows no window |
//! | `app`, [`cli`] | the two faces: the egui window and the command line |
//!
//! Lengths are mm, angles radians, times seconds, feeds mm/min; files and screens show degrees.
//! The axis of rotation is Z.
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
