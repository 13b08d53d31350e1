//! What `verify` reports of a posted program: the figures of the program that it was posted from.
//!
//! Four figures may differ, for a reason, and are held to it here: the length in rapid and with it the time,
//! as links leave the part; the least clearance of links, of which some are others; and, where a program
//! mills along curves, the number of moves and the largest turn in one, as the post adds positions between
//! them.

use std::path::Path;
use std::sync::LazyLock;

use vanecut::io::nc::{NcProgram, Post, ReadContext, read_nc, read_post, write_nc};
use vanecut::io::part_file::read_part;
use vanecut::io::program_file::NcMachine;
use vanecut::io::setup_file::read_setup_with_defaults;
use vanecut::job::flank::{FlankJob, FlankOutcome, FlankRequest};
use vanecut::job::machine_run::MachineRun;
use vanecut::job::{PlanRequest, Summary, run};
use vanecut::machine::{
    BlankSize, MachineClock, MachineProgram, MachineTool, MotionOptions, OutputKind, PlacedPart, SectionTime,
    machine_program, section_times,
};
use vanecut::monitor::Monitor;
use vanecut::part::{Impeller, Workpiece};
use vanecut::report::sheet::flank::{FlankSheetInput, flank_sheet};
use vanecut::setup::{AxisPolicy, Setup};
use vanecut::toolpath::{ClProgram, Motion};
use vanecut::verify::{FaultKind, FlankVerdict, PlungeReport, PlungeVerdict, report_plunges, verify_flank};

use super::programs::{MACHINES, OUTPUTS, machine};

/// A part with a setup and a program of it.
pub struct Planned {
    pub workpiece: Workpiece,
    pub setup: Setup,
    pub program: ClProgram,
}

fn pump6() -> Impeller {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/parts/pump6.toml");
    Impeller::build(&read_part(&path).expect("readable")).expect("an impeller")
}

fn setup_of(part: &Impeller, text: &str) -> Setup {
    read_setup_with_defaults("setup.toml", text.as_bytes(), &Setup::for_part(part)).expect("a setup")
}

const PLUNGES: &str = "[plunge]\nstep = 12\nstepover = 14\n[[plunge.section]]\ntool = 52\nfrom = 1\nto = 0\n\
    [[tool]]\nnumber = 52\ndiameter = 12\ncorner_radius = 0.8\ninsert_width = 4\noverhang = 60\n";
/// Cells of the floor along s and λ.
pub const CELLS: usize = 96;
/// Number of plunges.
const COUNT: usize = 90;

/// Plunges that all machines reach, one of them 3 mm too deep: that has to be found in all programs.
pub static PLUNGED: LazyLock<Planned> = LazyLock::new(|| {
    let part = pump6();
    let setup = setup_of(&part, PLUNGES);
    let request = PlanRequest {
        part: part.clone().into(),
        setup: setup.clone(),
        policy: AxisPolicy::Monotone,
        compare: false,
        field_cells: 64,
    };
    let mut plan = run(&request, &Monitor::default()).expect("planned").after.plan;
    let out = part.out_of_inlet();
    plan.positions.retain(|position| position.axis.dot(&out) > 0.05);
    plan.positions.truncate(COUNT);
    let deep = &mut plan.positions[COUNT / 2];
    deep.tip -= deep.axis * 3.0;
    let program = ClProgram::of_plan(&part.name, &plan);
    Planned { workpiece: setup.allowances.workpiece_of(part), setup, program: numbered(program) }
});

/// What `verify` reports of their program.
pub static MEANT: LazyLock<PlungeReport> = LazyLock::new(|| PLUNGED.plunges(&PLUNGED.program));

/// Deep layers with wide passes, which are soon planned, with tilts that all machines reach.
static MILLED_PLAN: LazyLock<FlankOutcome> = LazyLock::new(|| {
    let part = pump6();
    let text =
        "[flank]\nlayer_depth = 20\nscheme = \"layers\"\nscallop_height = 1\n[machine]\nmax_axis_tilt = 89\n";
    let setup = setup_of(&part, text);
    let request = FlankRequest { part: part.into(), setup };
    FlankJob::default().run(&request, &Monitor::default()).expect("planned")
});

static MILLED: LazyLock<Planned> = LazyLock::new(|| {
    let (part, outcome) = (pump6(), &*MILLED_PLAN);
    let program = ClProgram::of_flank(&part.name, &outcome.plan.tool, &outcome.plan.moves);
    let setup = outcome.setup.clone();
    Planned { workpiece: setup.allowances.workpiece_of(part), setup, program: numbered(program) }
});

fn numbered(mut program: ClProgram) -> ClProgram {
    for (line, step) in (1..).zip(&mut program.moves) {
        step.line = line;
    }
    program
}

/// Time in joint space with tool changes, s, and travel of both rotary axes, rad.
fn machine_figures(machine: &MachineTool, program: &ClProgram, motion: &MachineProgram) -> (f64, [f64; 2]) {
    let times = section_times(machine, program, motion);
    (times.iter().map(SectionTime::total_s).sum(), motion.rotary_travel)
}

impl Planned {
    /// The program as it is written for a machine, and as that is read back. By the rotary positions that it
    /// names, the machine takes as long for what is read as for what was written.
    pub fn posted(&self, machine: &MachineTool, control: &str, output: OutputKind) -> (NcProgram, ClProgram) {
        let post: Post = read_post(control).unwrap();
        let placed = PlacedPart::from_placement(&machine.part, &self.workpiece.part);
        let options = MotionOptions::new(output, post.format.angle_decimals);
        let motion = machine_program(machine, &placed, &self.program, &options, &Monitor::default());
        let motion = motion.expect("it runs");
        let nc = write_nc(&self.program, machine, &motion, &post, output, &[]).unwrap();
        let context = ReadContext { machine, placed, tools: &self.setup.tools };
        let reading = read_nc("p.nc", nc.text.as_bytes(), post.dialect, &context).unwrap();
        assert_eq!(reading.overruns, []);
        let run = MachineRun::by_angles(&placed, &reading.program, &reading.angles);
        assert_eq!(run.is_some(), matches!(output, OutputKind::TcpAngles | OutputKind::Joints));
        if let Some(run) = run {
            let (time, travel) = machine_figures(machine, &self.program, &motion);
            let (read_time, read_travel) = machine_figures(machine, &reading.program, &run.motion);
            let case = format!("{} {control} {}", machine.name, output.name());
            // Feed rates are rounded.
            assert!((read_time - time).abs() < 1e-3 * time, "{case}: {time} s written, {read_time} s read");
            for (written, read) in travel.into_iter().zip(read_travel) {
                assert!(
                    (read - written).abs() < 1e-3 * written,
                    "{case}: {written} rad written, {read} read"
                );
            }
        }
        (nc, reading.program)
    }

    fn plunges(&self, program: &ClProgram) -> PlungeReport {
        report_plunges(&self.workpiece, &self.setup, program, CELLS, &Monitor::default()).expect("judged")
    }

    fn milling(&self, program: &ClProgram) -> FlankVerdict {
        verify_flank(&self.workpiece, &self.setup, program, &Monitor::default()).expect("judged")
    }
}

/// Figures by name, with the difference that the rounding of a program makes.
type Figures = Vec<(&'static str, f64, f64)>;

fn compare(case: &str, apt: &Figures, nc: &Figures) {
    for ((name, meant, tolerance), (_, read, _)) in apt.iter().zip(nc) {
        let same = meant.is_nan() && read.is_nan() || (meant - read).abs() <= *tolerance;
        assert!(same, "{case}, {name}: {meant} planned, {read} read back");
    }
}

pub fn figures_of(summary: &Summary) -> Figures {
    vec![
        ("positions", summary.positions as f64, 0.0),
        ("interfering", summary.interfering as f64, 0.0),
        ("contact", summary.max_contact_depth, 2e-3),
        ("residual mean", summary.residual_mean, 1e-3),
        ("residual 95 %", summary.residual_p95, 1e-3),
        ("uncut", summary.uncut_share, 1e-3),
        ("inaccessible", summary.inaccessible_share, 1e-3),
        ("hub", summary.min_hub_clearance, 2e-4),
        ("blades", summary.min_blade_clearance, 2e-4),
        ("axis change", summary.max_axis_change_rad, 1e-5),
        ("cut length", summary.cut_length, 1e-5 * summary.cut_length),
        ("time under feed", summary.feed_time, 1e-3 * summary.feed_time),
    ]
}

/// The kinds of the faults of a program.
pub fn kinds_of(verdict: &PlungeVerdict) -> Vec<FaultKind> {
    verdict.faults.iter().map(|fault| fault.kind).collect()
}

#[test]
fn figures_of_plunges_are_those_of_the_program() {
    let planned = &*PLUNGED;
    let apt = &*MEANT;
    assert!(kinds_of(&apt.verdict).contains(&FaultKind::HubAllowance), "{:?}", apt.verdict.faults);
    assert_eq!(apt.summary.positions, COUNT);
    // Each output of each control on one of the machines in turn; `scripts/read-back` does all on all.
    let outputs = |(control, outputs): (&'static str, &'static [OutputKind])| {
        outputs.iter().map(move |&output| (control, output))
    };
    for ((control, output), name) in OUTPUTS.into_iter().flat_map(outputs).zip(MACHINES.into_iter().cycle()) {
        let machine = machine(name);
        let case = format!("{name} {control} {}", output.name());
        let (nc, program) = planned.posted(&machine, control, output);
        let read = planned.plunges(&program);
        assert_eq!(kinds_of(&read.verdict), kinds_of(&apt.verdict), "{case}: {:?}", read.verdict.faults);
        compare(&case, &figures_of(&apt.summary), &figures_of(&read.summary));
        assert_eq!(nc.positions, COUNT, "{case}");
        let (meant, read) = (&apt.summary, &read.summary);
        // Links that leave the part go further from it, and are longer; all of the time is theirs.
        let links = [meant, read].map(|s| s.time_estimate - s.feed_time);
        assert!(links[1] >= links[0] && read.rapid_length >= meant.rapid_length, "{case}: {links:?}");
        // Less than that is a fault.
        let [clearance, planned] = [read, meant].map(|s| s.min_retract_clearance);
        assert!(clearance > planned - 1e-3, "{case}: {clearance} mm, {planned} mm planned");
    }
}

/// One rule for the window and `verify`: code that names rotary positions has these; for vectors they are
/// chosen without looking at what the machine file gives as output.
#[test]
fn the_axes_of_code_that_was_read() {
    let program = super::programs::plunges();
    for name in MACHINES {
        for output in [OutputKind::TcpAngles, OutputKind::TcpVectors] {
            let mut machine = machine(name);
            let nc = super::programs::posted(&machine, &program, "fanuc", output);
            let reading = super::programs::read_back(&machine, "fanuc", &nc.text).unwrap();
            let placed = super::programs::placed(&machine);
            let blank = BlankSize { radius: 120.0, z: (-80.0, 20.0) };
            let mut run = |kind: OutputKind| {
                machine.output = kind;
                let (machine, angles) = (machine.clone(), reading.angles.clone());
                let on_machine = NcMachine { machine, placed, angles };
                MachineRun::as_read(&on_machine, &reading.program, blank, &Monitor::default()).unwrap()
            };
            let (as_angles, as_joints) = (run(OutputKind::TcpAngles), run(OutputKind::Joints));
            assert_eq!(as_angles.poses, as_joints.poses, "{name} {}", output.name());
            assert!(as_angles.poses.iter().all(Option::is_some), "{name} {}", output.name());
            if output == OutputKind::TcpAngles {
                let named = as_angles.poses.iter().zip(&reading.angles);
                assert!(
                    named.into_iter().all(|(pose, angles)| pose.map(|pose| pose.angles) == angles.known())
                );
            }
        }
    }
}

fn figures_of_milling(verdict: &FlankVerdict) -> Figures {
    vec![
        ("channels", verdict.channels as f64, 0.0),
        ("faults", verdict.faults.len() as f64, 0.0),
        ("residual mean", verdict.layer.mean.into(), 1e-3),
        ("residual 95 %", verdict.layer.p95.into(), 5e-3),
        ("uncut", verdict.layer.uncut_share.into(), 1e-3),
        ("uncovered", verdict.uncovered.share(), 1e-3),
        ("overcut", verdict.max_overcut, 1e-3),
        ("undercut", verdict.max_undercut, 5e-3),
        ("not milled", verdict.unmilled_wall_share, 1e-3),
        ("hub", verdict.min_hub_clearance, 2e-3),
        ("blades", verdict.min_blade_clearance, 2e-3),
        // In deep layers the stock of a cell beside a wall is cut whole by the one or the next move.
        ("deepest cut", verdict.deepest_cut, 5e-3 * verdict.deepest_cut),
        ("cut length", verdict.cut_length, 1e-4 * verdict.cut_length),
    ]
}

/// On the machine and without one.
#[test]
fn times_of_the_layers_on_the_setup_sheet_are_that_of_the_program() {
    let mut outcome = MILLED_PLAN.clone();
    for name in [None, Some("ac-trunnion")] {
        let placed =
            name.map(|name| MachineClock::new(machine(name), &outcome.workpiece, &outcome.setup.allowances));
        outcome.machine_time = placed.as_ref().and_then(|clock| clock.time(&outcome.program()));
        outcome.clock = placed;
        let program = outcome.program_for_channels(1, &Monitor::default()).expect("judged");
        let sheet = FlankSheetInput { outcome: &outcome, program: &program, files: &[], remarks: &[] };
        let page = flank_sheet(&sheet, Vec::new()).page;
        let table =
            page.split("<h2>Layers</h2>").nth(1).and_then(|rest| rest.split("</table>").next()).unwrap();
        let minutes =
            table.split("</td></tr>").filter_map(|row| row.rsplit("<td>").next()?.parse::<f64>().ok());
        let minutes: Vec<f64> = minutes.collect();
        assert_eq!(minutes.len(), outcome.plan.layout.layers.len());
        let (sum, whole) = (minutes.iter().sum::<f64>(), outcome.time_s() / 60.0);
        assert!((sum - whole).abs() < 0.06 * minutes.len() as f64, "{name:?}: {sum} min, in all {whole}");
        assert!(!page.contains("Of one channel"), "as the program");
    }
}

#[test]
fn the_setup_sheet_of_several_channels_says_what_is_of_one() {
    let outcome = &*MILLED_PLAN;
    let program = outcome.program_for_channels(2, &Monitor::default()).expect("judged");
    let sheet = FlankSheetInput { outcome, program: &program, files: &[], remarks: &[] };
    let page = flank_sheet(&sheet, Vec::new()).page;
    for heading in ["<h2>Layers</h2>", "<h2>Before and after</h2>"] {
        let text = page.split_once(heading).and_then(|(_, rest)| rest.split_once("<table>")).unwrap().0;
        assert!(text.contains("<p>Of one channel.</p>"), "{heading}: {text}");
    }
    let minutes = |words: &str| -> f64 {
        let (before, _) = page.split_once(words).expect(words);
        before.rsplit(' ').next().and_then(|number| number.parse().ok()).expect("a number")
    };
    let (all, one) = (minutes(" min for the program, "), minutes(" min per channel"));
    assert!(all > 1.5 * one && all < 3.0 * one, "{all} min, {one} min per channel");
}

/// One control and output a machine: each is judged in two seconds.
const MILLED_ON: [(&str, &str, OutputKind); 5] = [
    ("ac-trunnion", "heidenhain", OutputKind::TcpAngles),
    ("bc-trunnion", "haas", OutputKind::Joints),
    ("b-head-c-table", "siemens", OutputKind::TcpVectors),
    ("bc-head", "fanuc", OutputKind::TcpAngles),
    ("nutating-table", "linuxcnc", OutputKind::Joints),
];

#[test]
fn figures_of_milling_are_those_of_the_program() {
    let planned = &*MILLED;
    let apt = planned.milling(&planned.program);
    assert!(planned.program.mills_along_curves() && apt.positions > 1000, "{}", apt.positions);
    let moving = planned.program.moves.windows(2).filter(|pair| {
        let is_cut = matches!(pair[1].motion, Motion::Feed(_));
        is_cut && (pair[0].tip, pair[0].axis) != (pair[1].tip, pair[1].axis)
    });
    let moving = moving.count();
    for (name, control, output) in MILLED_ON {
        let machine = machine(name);
        let case = format!("{name} {control} {}", output.name());
        let (nc, program) = planned.posted(&machine, control, output);
        let read = planned.milling(&program);
        compare(&case, &figures_of_milling(&apt), &figures_of_milling(&read));
        // What the post adds it counts.
        assert_eq!(read.positions, nc.positions, "{case}");
        match output {
            OutputKind::TcpVectors => assert_eq!(nc.positions, moving, "{case}: the control turns evenly"),
            _ => assert!(nc.positions > moving, "{case}: {} of {moving}", nc.positions),
        }
        assert!(read.max_axis_change_rad <= apt.max_axis_change_rad + 1e-5, "{case}");
        // An axis that cannot turn as fast as the program cuts is waited for, if the post knows.
        let slower = read.feed_time / apt.feed_time - 1.0;
        let most = if output == OutputKind::Joints { 0.02 } else { 1e-3 };
        assert!(slower > -1e-3 && slower < most, "{case}: {slower}");
        let links = [&apt, &read].map(|verdict| verdict.time_estimate - verdict.feed_time);
        assert!(links[1] >= links[0] && read.rapid_length >= apt.rapid_length, "{case}: {links:?}");
        assert!(read.min_retract_clearance > apt.min_retract_clearance - 0.05, "{case}");
    }
}
