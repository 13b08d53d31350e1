//! What connects model, tasks and views: commands, results of tasks, project, export, lost devices.

pub(in crate::app) mod background;
pub(in crate::app) mod check;
pub(in crate::app) mod commands;
pub(in crate::app) mod drops;
pub(in crate::app) mod export;
pub mod handover;
pub(in crate::app) mod machine;
pub(in crate::app) mod pictures;
pub(in crate::app) mod project;
pub(in crate::app) mod recovery;
pub(in crate::app) mod replaced;
pub(in crate::app) mod unsaved;
pub(in crate::app) mod windows;
