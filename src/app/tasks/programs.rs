//! Programs as they leave the window: APT text and NC code.

use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use crate::app::model::exported::ProgramPlan;
use crate::app::model::figures::format_duration;
use crate::app::model::look::Operation;
use crate::app::model::planned::DisplayPlan;
use crate::app::model::post_target::PostTarget;
use crate::error::UserError;
use crate::io::InputError;
use crate::io::apt::{as_written, write_apt};
use crate::io::flank_file::stored_program;
use crate::io::machine_file::read_machine;
use crate::io::nc::read_post;
use crate::job::flank::FlankOutcome;
use crate::job::flank_channels::FlankProgram;
use crate::job::post::{PostFault, PostRequest, PostedProgram, post_program};
use crate::machine::{BlankSize, ChannelCalls, INSTEAD_OF_CALLS, INSTEAD_OF_PLANES};
use crate::monitor::{Cancelled, Monitor};
use crate::report::sheet::ProgramFile;
use crate::setup::{AxisPolicy, ChannelSetup, Tool};
use crate::toolpath::ClProgram;
use crate::verify::{Fault, VerifyError, verify};

/// What is to be done with options of the command line, and the same in the words of the dialog.
const IN_DIALOG: [(&str, &str); 2] = [
    (INSTEAD_OF_CALLS, "export all channels, without Subprogram"),
    (INSTEAD_OF_PLANES, "choose another Output, such as Rotary angles"),
];

/// Why a program or its setup sheet is not written.
pub(super) enum UnwrittenProgram {
    /// Cancelled while it was judged.
    Cancelled,
    /// It has these faults, which nobody was asked about.
    Faulty(Vec<Fault>),
    /// Machine or post cannot be read, or the machine cannot run it; the sheet cannot be drawn.
    Failed(InputError),
}

impl From<Cancelled> for UnwrittenProgram {
    fn from(Cancelled: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl From<InputError> for UnwrittenProgram {
    fn from(error: InputError) -> Self {
        Self::Failed(error)
    }
}

/// A plunge program to write.
pub struct PlungeSource {
    /// The plans.
    pub planned: Arc<DisplayPlan>,
    /// The policy whose plan is written.
    pub policy: AxisPolicy,
    /// Number of channels that it mills, from the first on.
    pub channels: usize,
    /// What is done with faults.
    pub on_faults: OnFaults,
}

impl PlungeSource {
    /// The plan of the program.
    pub(super) fn plan(&self) -> ProgramPlan {
        ProgramPlan::Plunges(Arc::downgrade(&self.planned), self.policy, self.channels)
    }

    /// Whether it is judged before it is written: shanks and holders are, of tools that have any.
    pub(super) fn is_judged(&self) -> bool {
        let has_any = |tool: &Tool| !tool.assembly.segments(tool.overhang).is_empty();
        self.on_faults == OnFaults::Ask && self.planned.outcome.setup.tools.iter().any(has_any)
    }

    /// The program, to be written: with a shank or holder in the way only once that is accepted. Other faults
    /// of a plunge plan are known from it.
    ///
    /// # Errors
    /// When `monitor` is cancelled, or nobody was asked about a fault.
    pub(super) fn accepted_program(&self, monitor: &Monitor) -> Result<ClProgram, UnwrittenProgram> {
        let faults = if self.is_judged() { self.assembly_faults(monitor)? } else { Vec::new() };
        if faults.is_empty() { Ok(plunge_program(self)) } else { Err(UnwrittenProgram::Faulty(faults)) }
    }

    /// What `verify` finds of shanks and holders in one channel: the others repeat it.
    fn assembly_faults(&self, monitor: &Monitor) -> Result<Vec<Fault>, UnwrittenProgram> {
        let outcome = &self.planned.outcome;
        let program = outcome.program_for_channels(self.planned.result(self.policy), 1, monitor)?;
        let written = as_written("the program", &program)?;
        match verify(&outcome.workpiece, &outcome.setup, &written, &monitor.silent()) {
            Ok(verdict) => {
                Ok(verdict.faults.into_iter().filter(|fault| fault.kind.is_of_assembly()).collect())
            }
            Err(VerifyError::Cancelled(cancelled)) => Err(cancelled.into()),
            Err(VerifyError::Program(fault)) => Ok(vec![fault]),
        }
    }
}

/// What is done where a program is found to have faults as it is written that are not known from its plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OnFaults {
    /// It is not written, and the faults are asked about.
    Ask,
    /// It is written: the user has accepted them.
    Write,
}

/// A flank program to write.
pub struct FlankSource {
    /// The plan.
    pub outcome: Arc<FlankOutcome>,
    /// Number of channels that it mills, from the first on.
    pub channels: usize,
    /// Their order.
    pub order: ChannelSetup,
    /// Where the judged program is kept.
    pub judged: Arc<JudgedFlank>,
    /// What is done with faults.
    pub on_faults: OnFaults,
}

impl FlankSource {
    /// The plan of the program.
    pub(super) fn plan(&self) -> ProgramPlan {
        ProgramPlan::Flank(Arc::downgrade(&self.outcome), self.channels)
    }

    /// The plan with the order of the channels.
    pub(super) fn ordered(&self) -> FlankOutcome {
        let mut outcome = (*self.outcome).clone();
        outcome.setup.channels = self.order;
        outcome
    }

    /// The program, judged as a whole where it is of several channels.
    ///
    /// # Errors
    /// When `monitor` is cancelled.
    fn program(&self, monitor: &Monitor) -> Result<Arc<FlankProgram>, Cancelled> {
        let channels = self.outcome.workpiece.part.channels_within(self.channels);
        // That of one is judged with its plan.
        if channels <= 1 {
            return Ok(Arc::new(self.ordered().program_for_channels(channels, monitor)?));
        }
        let (outcome, order) = (Arc::downgrade(&self.outcome), self.order);
        // Locked while it is judged: another file of the same program waits for it.
        let mut last = self.judged.lock();
        if let Some(last) = last.as_ref()
            && (last.channels, last.order) == (channels, order)
            && last.outcome.ptr_eq(&outcome)
        {
            return Ok(Arc::clone(&last.program));
        }
        let program = Arc::new(self.ordered().program_for_channels(channels, monitor)?);
        *last = Some(LastJudged { outcome, channels, order, program: Arc::clone(&program) });
        Ok(program)
    }

    /// The program, to be written: with faults only once they are accepted.
    ///
    /// # Errors
    /// When `monitor` is cancelled, or the program of several channels has faults that nobody was asked
    /// about: those of one channel are known before.
    pub(super) fn accepted_program(&self, monitor: &Monitor) -> Result<Arc<FlankProgram>, UnwrittenProgram> {
        let program = self.program(monitor)?;
        if program.channels > 1 && !program.faults.is_empty() && self.on_faults == OnFaults::Ask {
            return Err(UnwrittenProgram::Faulty(program.faults.clone()));
        }
        Ok(program)
    }
}

/// The flank program that was judged last. To judge one of several channels takes as long as to plan it, and
/// the same one is written as APT, as NC code and with its setup sheet.
#[derive(Default)]
pub struct JudgedFlank(Mutex<Option<LastJudged>>);

struct LastJudged {
    outcome: Weak<FlankOutcome>,
    channels: usize,
    order: ChannelSetup,
    program: Arc<FlankProgram>,
}

impl JudgedFlank {
    fn lock(&self) -> MutexGuard<'_, Option<LastJudged>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether there is one.
    pub fn is_kept(&self) -> bool {
        self.lock().is_some()
    }

    /// Drops the program once its plan has been replaced: it may hold the moves of a whole wheel.
    pub fn forget_replaced(&self) {
        // While a program is judged it is locked, and of the plan that was asked for.
        if let Ok(mut last) = self.0.try_lock() {
            last.take_if(|last| last.outcome.strong_count() == 0);
        }
    }
}

impl ProgramSource {
    /// The operation of the program.
    pub(super) fn operation(&self) -> Operation {
        match self {
            Self::Plunges(_) => Operation::Roughing,
            Self::Flank(_) => Operation::Flank,
        }
    }

    /// The plan of the program.
    pub(super) fn plan(&self) -> ProgramPlan {
        match self {
            Self::Plunges(source) => source.plan(),
            Self::Flank(source) => source.plan(),
        }
    }
}

impl NcTask {
    /// How often another program calls this one; `None`: not at all.
    fn calls(&self) -> Option<ChannelCalls> {
        let (channels, workpiece, sequence) = match &self.source {
            ProgramSource::Plunges(source) => {
                let outcome = &source.planned.outcome;
                (source.channels, &outcome.workpiece, outcome.setup.channels.sequence)
            }
            ProgramSource::Flank(source) => {
                (source.channels, &source.outcome.workpiece, source.order.sequence)
            }
        };
        let count = workpiece.part.blade_count;
        self.target.is_subprogram.then(|| ChannelCalls::for_channels(channels, count, sequence))
    }

    /// The program as a file of this `name`.
    fn file(&self, name: String, posted: &PostedProgram) -> ProgramFile {
        let PostTarget { machine, control, .. } = &self.target;
        let [machine, control] = [machine, control].map(|name| short_name(name));
        let calls = self.calls();
        let is_called_for_each_channel = matches!(calls, Some(ChannelCalls::EachChannel { .. }));
        let calls = calls.and_then(ChannelCalls::words);
        let calls = calls.map_or_else(String::new, |words| format!(", subprogram {words}"));
        let lies: String = posted.placed.comments().iter().map(|comment| format!(", {comment}")).collect();
        let about = format!("NC code for {machine}, control {control}{calls}{lies}");
        ProgramFile { name, about, time_s: Some(posted.time_s()), is_called_for_each_channel }
    }
}

/// A program to write as NC code.
pub enum ProgramSource {
    /// That of a plunge plan.
    Plunges(PlungeSource),
    /// That of the flank plan.
    Flank(FlankSource),
}

/// Content of an NC program.
pub struct NcTask {
    /// The program.
    pub source: ProgramSource,
    /// Where it is to run.
    pub target: PostTarget,
}

/// The program of a plunge plan, for its channels.
fn plunge_program(content: &PlungeSource) -> ClProgram {
    let outcome = &content.planned.outcome;
    let channels = outcome.workpiece.part.channels_within(content.channels);
    let result = content.planned.result(content.policy);
    // Nothing cancels a file that is being written.
    outcome
        .program_for_channels(result, channels, &Monitor::default())
        .unwrap_or_else(|Cancelled| ClProgram::default())
}

/// A plunge plan as it is exported, once that is accepted.
///
/// # Errors
/// When cancelled, or when the program has faults that nobody was asked about.
pub(super) fn plunge_text(source: &PlungeSource, monitor: &Monitor) -> Result<String, UnwrittenProgram> {
    Ok(write_apt(&source.accepted_program(monitor)?))
}

/// A program as NC code.
pub(super) struct NcText {
    /// Its text.
    pub text: String,
    /// What to say of it.
    pub about: String,
    /// Its file, as a setup sheet names it.
    pub file: ProgramFile,
}

/// NC code of a program for the file `path`.
///
/// # Errors
/// When machine or post cannot be read, the machine cannot run the program, or that has faults that nobody
/// was asked about; when cancelled.
pub(super) fn nc_text(path: &Path, content: &NcTask, monitor: &Monitor) -> Result<NcText, UnwrittenProgram> {
    let (posted, faults) = post(path, content, monitor)?;
    let (blocks, time) = (posted.written.block_words(), format_duration(posted.time_s()));
    let calls = content.calls().and_then(ChannelCalls::words);
    let calls = calls.map_or_else(String::new, |words| format!("; {words}"));
    let about = format!(": {blocks} for {}, {time}{calls}{faults}", short_name(&content.target.machine));
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let file = content.file(name, &posted);
    Ok(NcText { text: posted.written.text, about, file })
}

/// Posts a program, with what to say of its faults. Moves are named in messages by their numbers.
fn post(
    path: &Path,
    content: &NcTask,
    monitor: &Monitor,
) -> Result<(PostedProgram, String), UnwrittenProgram> {
    let PostTarget { machine, control, output, is_subprogram, .. } = &content.target;
    let mut faults = String::new();
    let (mut program, workpiece, setup) = match &content.source {
        ProgramSource::Plunges(source) => {
            let outcome = &source.planned.outcome;
            (source.accepted_program(monitor)?, &outcome.workpiece, &outcome.setup)
        }
        ProgramSource::Flank(source) => {
            let FlankOutcome { workpiece, setup, .. } = &*source.outcome;
            let (program, about) = posted_flank(source, monitor)?;
            faults = about;
            (program, workpiece, setup)
        }
    };
    for (number, step) in (1..).zip(&mut program.moves) {
        step.line = number;
    }
    let part = &workpiece.part;
    let fault = |move_number: usize, error: UserError| {
        let place = if move_number > 0 { format!("move {move_number}: ") } else { String::new() };
        let (message, machine) = (error.message, short_name(machine));
        let message = format!("the NC program is not written: {machine}: {place}{message}");
        let in_dialog = IN_DIALOG.iter().find(|(options, _)| error.help == *options);
        let help = in_dialog.map_or(error.help.as_str(), |(_, words)| *words).to_owned();
        InputError::new(error.code, &path.display().to_string(), 0, message, help)
    };
    let mut post = read_post(control)?;
    if *is_subprogram {
        post = post.into_subprogram().map_err(|error| fault(0, error))?;
    }
    let request = PostRequest {
        machine: read_machine(Path::new(machine))?,
        post,
        output: *output,
        inlet_up: part.out_of_inlet().z > 0.0,
        blank: Some(BlankSize::from_part(part, &setup.allowances)),
        calls: content.calls(),
    };
    let posted = post_program(&program, &request, &Monitor::default()).map_err(|refused| match refused {
        PostFault::Motion(motion) => fault(motion.line(), motion.explained()),
        PostFault::Words(error) => fault(0, error),
    });
    Ok((posted?, faults))
}

/// The name of a machine, or that of its file.
fn short_name(machine: &str) -> String {
    Path::new(machine).file_name().map_or_else(|| machine.to_owned(), |name| name.to_string_lossy().into())
}

/// The program of a flank plan as `vanecut post` reads it from a flank.json.
fn posted_flank(source: &FlankSource, monitor: &Monitor) -> Result<(ClProgram, String), UnwrittenProgram> {
    let judged = source.accepted_program(monitor)?;
    let outcome = source.ordered();
    let program =
        stored_program(&outcome.workpiece, &outcome.setup, &judged.plan, judged.channels, &monitor.silent())?;
    Ok((program, fault_words(&judged)))
}

/// What to say of the faults of a program of several channels; those of one are asked about before.
fn fault_words(program: &FlankProgram) -> String {
    match program.faults.len() {
        _ if program.channels == 1 => String::new(),
        0 => String::new(),
        1 => "; the program has one fault: check it".to_owned(),
        count => format!("; the program has {count} faults: check it"),
    }
}

/// A flank plan as it is exported, and what to say of the file.
///
/// # Errors
/// When cancelled, or when the program has faults that nobody was asked about.
pub(super) fn flank_text(
    source: &FlankSource,
    monitor: &Monitor,
) -> Result<(String, String), UnwrittenProgram> {
    let judged = source.accepted_program(monitor)?;
    Ok((write_apt(&judged.program), fault_words(&judged)))
}
