//! Command-line arguments.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

use crate::error::{ErrorCode, UserError};
use crate::mesh::axis::Axis;
use crate::mesh::{LengthUnit, MeshOptions, Role};
use crate::part::Rotation;

/// Plans the rough milling of centrifugal impellers. Without a command it opens the window.
#[derive(Debug, Parser)]
#[command(name = "vanecut", version, args_conflicts_with_subcommands = true)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Option<CliCommand>,
    /// Part or setup to open in the window
    pub file: Option<PathBuf>,
}

/// Subcommands.
#[derive(Debug, Subcommand)]
pub enum CliCommand {
    /// Plunge plan of a part: plan.json and plunge.apt
    Plan(PlanArgs),
    /// Flank plan of a part, layer by layer: flank.json and flank.apt
    Flank(FlankArgs),
    /// Machinability of a part: twist, bow, depth, width, largest cutter, reach
    Assess(AssessArgs),
    /// Check any APT program against a part
    Verify(VerifyArgs),
    /// NC program of a plan or an APT program for a machine
    Post(PostArgs),
    /// The stock as a solid after any move of any program: .stl or .glb
    Stock(StockArgs),
    /// Picture of a part, a plan.json or a flank.json, without a window
    Render(RenderArgs),
    /// Convert a part to another format, STEP and STL too, or a part or plan to a glTF scene
    Convert(ConvertArgs),
    /// Many plans over parts and settings, resumable, for any scheduler
    Study(StudyArgs),
    /// Throughput of the kernels on this machine
    Bench(BenchArgs),
    /// What the code of an error means, and what to do
    Explain(ExplainArgs),
}

/// `vanecut explain`.
#[derive(Debug, Args)]
pub struct ExplainArgs {
    /// Code, such as unknown-key; absent: all codes. With VANECUT_ERROR_CODES=1 the line of an error ends
    /// with its code
    pub code: Option<String>,
}

/// `vanecut bench`.
#[derive(Debug, Args)]
pub struct BenchArgs {
    /// Approximate number of positions of the largest plan in the growth measurement; 100000 takes many
    /// minutes
    #[arg(long, value_name = "N", default_value_t = 4000)]
    pub positions: usize,
    /// Only the stock as a solid
    #[arg(long)]
    pub stock: bool,
}

/// Options for parts given as meshes.
#[derive(Debug, Args)]
#[command(next_help_heading = "Meshes")]
pub struct MeshArgs {
    /// Role of a node by its name: hub, shroud, blade, splitter or ignore; may be repeated
    #[arg(long = "role", value_name = "NODE=ROLE", value_parser = role)]
    pub roles: Vec<(String, Role)>,
    /// Unit of the file's lengths: mm, cm, m or in; absent: m for glTF, mm for STL; geomTurbo and STEP files
    /// tell theirs, that of geomTurbo can be overruled
    #[arg(long)]
    pub unit: Option<LengthUnit>,
    /// Axis of rotation in the file: x, y or z; absent: found from the hub
    #[arg(long, value_name = "AXIS")]
    pub rotation_axis: Option<Axis>,
    /// Sense of rotation seen from the inlet, cw or ccw; the leading side of a blade is its pressure side.
    /// Absent: from the file, or inferred from the wrap of the blades
    #[arg(long, value_name = "SENSE")]
    pub rotation: Option<Rotation>,
    /// Number of main blades, where the file holds only one
    #[arg(long, value_name = "N")]
    pub blades: Option<usize>,
}

impl MeshArgs {
    /// The options in the form that readers take.
    pub fn options(&self) -> MeshOptions {
        MeshOptions {
            roles: self.roles.clone(),
            unit: self.unit,
            axis: self.rotation_axis,
            blades: self.blades,
            rotation: self.rotation,
        }
    }
}

/// Parses `NODE=ROLE`; the node's name may contain `=`.
fn role(text: &str) -> Result<(String, Role), UserError> {
    let missing = || UserError::new(ErrorCode::Arguments, "give NODE=ROLE, such as Body3=hub", "");
    let (node, role) = text.rsplit_once('=').ok_or_else(missing)?;
    Ok((node.to_owned(), role.parse()?))
}

/// Options for programs of several channels.
#[derive(Debug, Args)]
pub struct ChannelArgs {
    /// Number of channels that the program cuts, or all
    #[arg(long, default_value = "1")]
    pub channels: String,
    /// What several channels are cut by: tool_by_tool or channel_by_channel; absent: from the setup
    #[arg(long, value_name = "ORDER")]
    pub channel_order: Option<String>,
    /// How channels follow each other: adjacent or opposite; absent: from the setup
    #[arg(long, value_name = "SEQUENCE")]
    pub channel_sequence: Option<String>,
}

/// `vanecut plan`.
#[derive(Debug, Args)]
pub struct PlanArgs {
    /// Part: .toml, .geomTurbo, TurboGrid .inf, .step, .stl, .glb or .gltf
    pub part: PathBuf,
    #[command(flatten)]
    pub mesh: MeshArgs,
    /// Setup file; `-` reads it from standard input
    #[arg(long)]
    pub setup: Option<PathBuf>,
    /// Axis policy: conventional, monotone, minimal or staircase; absent: from the setup
    #[arg(long)]
    pub axis: Option<String>,
    #[command(flatten)]
    pub several: ChannelArgs,
    /// Also print N plans between the least stock and the least time (8 without a number)
    #[arg(long, value_name = "N", num_args = 0..=1, default_missing_value = "8",
          value_parser = clap::value_parser!(u16).range(2..=100))]
    pub pareto: Option<u16>,
    /// Directory for plan.json and plunge.apt
    #[arg(short, long, default_value = ".")]
    pub output: PathBuf,
    /// Print one JSON object instead of a table
    #[arg(long)]
    pub json: bool,
    /// Also write report.html with pictures
    #[arg(long)]
    pub report: bool,
}

/// `vanecut flank`.
#[derive(Debug, Args)]
pub struct FlankArgs {
    /// Part: .toml, .geomTurbo, TurboGrid .inf, .step, .stl, .glb or .gltf
    pub part: PathBuf,
    #[command(flatten)]
    pub mesh: MeshArgs,
    /// Setup file; `-` reads it from standard input
    #[arg(long)]
    pub setup: Option<PathBuf>,
    /// Strategy: isoparametric, layers, regions or balanced; absent: from the setup
    #[arg(long)]
    pub scheme: Option<String>,
    #[command(flatten)]
    pub several: ChannelArgs,
    /// Directory for flank.json and flank.apt
    #[arg(short, long, default_value = ".")]
    pub output: PathBuf,
    /// Print one JSON object instead of a table
    #[arg(long)]
    pub json: bool,
    /// Also write report.html with pictures
    #[arg(long)]
    pub report: bool,
}

/// `vanecut assess`.
#[derive(Debug, Args)]
pub struct AssessArgs {
    /// Part: .toml, .geomTurbo, TurboGrid .inf, .step, .stl, .glb or .gltf
    pub part: PathBuf,
    #[command(flatten)]
    pub mesh: MeshArgs,
    /// Setup file with the tools whose reach is computed; `-` reads it from standard input
    #[arg(long)]
    pub setup: Option<PathBuf>,
    /// Print one JSON object instead of tables
    #[arg(long)]
    pub json: bool,
    /// Directory for pictures and charts; absent: none are written
    #[arg(short, long)]
    pub output: Option<PathBuf>,
}

/// `vanecut verify`.
#[derive(Debug, Args)]
pub struct VerifyArgs {
    /// Part: .toml, .geomTurbo, TurboGrid .inf, .step, .stl, .glb or .gltf
    pub part: PathBuf,
    #[command(flatten)]
    pub mesh: MeshArgs,
    /// APT program, or with --machine an NC program; `-` reads it from standard input
    pub program: PathBuf,
    /// Machine that an NC program is posted for: a name, or a machine file
    #[arg(long, value_name = "M")]
    pub machine: Option<PathBuf>,
    /// Control of the NC program: a name, or a post file; absent: that of the machine
    #[arg(long, value_name = "NAME", requires = "machine")]
    pub control: Option<String>,
    /// Setup file with the allowances and the insert widths
    #[arg(long)]
    pub setup: Option<PathBuf>,
    /// Print one JSON object instead of text
    #[arg(long)]
    pub json: bool,
}

/// `vanecut post`.
#[derive(Debug, Args)]
pub struct PostArgs {
    /// plan.json, flank.json or an APT program; `-` reads APT from standard input
    pub program: PathBuf,
    /// Machine: ac-trunnion, bc-trunnion, b-head-c-table, bc-head, nutating-table, or a machine file
    #[arg(long, value_name = "M")]
    pub machine: PathBuf,
    /// Control: heidenhain, siemens, fanuc, haas, linuxcnc, or a post file; absent: that of the machine
    #[arg(long, value_name = "NAME")]
    pub control: Option<String>,
    /// What the program gives the control: tcp-angles, tcp-vectors, plane or joints; absent: from the machine
    #[arg(long = "output", value_name = "KIND")]
    pub kind: Option<String>,
    /// Write a subprogram: it keeps the work offset of the program that calls it, and returns at its end
    #[arg(long)]
    pub subprogram: bool,
    /// Setup file with tools; what the program does not say of a tool is taken from it
    #[arg(long)]
    pub setup: Option<PathBuf>,
    /// NC program to write
    #[arg(short = 'o', value_name = "FILE")]
    pub file: PathBuf,
    /// Print one JSON object instead of text
    #[arg(long)]
    pub json: bool,
}

/// `vanecut stock`.
#[derive(Debug, Args)]
pub struct StockArgs {
    /// Part: .toml, .geomTurbo, TurboGrid .inf, .step, .stl, .glb or .gltf
    pub part: PathBuf,
    #[command(flatten)]
    pub mesh: MeshArgs,
    /// APT program, plan.json or flank.json; `-` reads an APT program from standard input
    pub program: PathBuf,
    /// Setup file with the insert widths and overhangs; absent: that of the plan, or defaults
    #[arg(long)]
    pub setup: Option<PathBuf>,
    /// State after this many moves of the program; absent: after the last
    #[arg(long, value_name = "K", allow_negative_numbers = true)]
    pub at: Option<usize>,
    /// Distance of the rays, mm; absent: the diameter of the blank / 800
    #[arg(long, value_name = "H", allow_negative_numbers = true)]
    pub spacing: Option<f64>,
    /// Blank: edges (enclosing the edges of the blades), turned (a cylinder), or a file: a closed .stl, or
    /// lines of `r z`; absent: that of the setup
    #[arg(long, value_name = "BLANK")]
    pub blank: Option<PathBuf>,
    /// File to write: .stl or .glb
    #[arg(short, long)]
    pub output: PathBuf,
    /// Print one JSON object instead of text
    #[arg(long)]
    pub json: bool,
}

/// `vanecut render`.
#[derive(Debug, Args)]
pub struct RenderArgs {
    /// Part, a plan.json, or a flank.json
    pub source: PathBuf,
    #[command(flatten)]
    pub mesh: MeshArgs,
    /// PNG file to write
    #[arg(short, long)]
    pub output: PathBuf,
    /// Width x height in pixels
    #[arg(long, default_value = "1280x800")]
    pub size: String,
    /// View: iso, front, top, channel or section:K
    #[arg(long, default_value = "iso")]
    pub view: String,
    /// Colours: residual, interference or plain, or solid: the stock as a solid; absent: residual for a plan,
    /// plain for a part. For a flank plan: layer, region, feed, walls or solid; absent: layer
    #[arg(long)]
    pub show: Option<String>,
    /// State after this many positions; for a flank plan with --show feed or solid, moves
    #[arg(long)]
    pub at: Option<usize>,
    /// Cutters: all, faulty or none; absent: chosen by --show
    #[arg(long)]
    pub cutters: Option<String>,
    /// Range of the colour scale of --show residual and solid, mm, as LOW:HIGH; absent: fitted to the plan
    #[arg(long)]
    pub range: Option<String>,
    /// Also draw the shroud
    #[arg(long)]
    pub shroud: bool,
    /// Dark background
    #[arg(long)]
    pub dark: bool,
    /// Transparent background
    #[arg(long)]
    pub transparent: bool,
    /// Also draw the colour scale
    #[arg(long)]
    pub legend: bool,
}

/// `vanecut convert`.
#[derive(Debug, Args)]
pub struct ConvertArgs {
    /// Part, a plan.json or flank.json, or a tool library (.toml, .json, .tools, .fctb, .fctl)
    pub input: PathBuf,
    #[command(flatten)]
    pub mesh: MeshArgs,
    /// File to write: .toml, .step, .stl, .glb or .gltf; of a tool library .toml or .json
    pub output: PathBuf,
    /// Chord error: largest distance of triangles from the surfaces, mm
    #[arg(long, default_value_t = 0.01)]
    pub chord_error: f64,
    /// One node per cutter, for viewers without EXT_mesh_gpu_instancing
    #[arg(long)]
    pub plain: bool,
}

/// `vanecut study`.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true)]
pub struct StudyArgs {
    #[command(subcommand)]
    pub action: Option<StudyAction>,
    /// Study file: parts, base setup, axes of variation
    pub study: Option<PathBuf>,
    /// List the runs and plan nothing; with -o, also which have results
    #[arg(long)]
    pub list: bool,
    /// Shard: I/N with I from 1 to N, or auto: from Slurm, Kubernetes or PBS; auto/N where these give no N
    #[arg(long, value_name = "I/N")]
    pub shard: Option<String>,
    /// Runs at a time; absent: one per core
    #[arg(long, value_name = "J")]
    pub jobs: Option<usize>,
    /// Folder of the results
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
}

/// What to do with the results of a study.
#[derive(Debug, Subcommand)]
pub enum StudyAction {
    /// Table of all results of a study
    Merge(MergeArgs),
    /// Plans of a table that no other plan beats
    Pareto(ParetoArgs),
}

/// `vanecut study merge`.
#[derive(Debug, Args)]
pub struct MergeArgs {
    /// Folder of the results
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Table to write: .csv, or .parquet where the program is built with that
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
}

/// `vanecut study pareto`.
#[derive(Debug, Args)]
pub struct ParetoArgs {
    /// Table that `study merge` wrote
    #[arg(value_name = "CSV")]
    pub table: PathBuf,
    /// Figures to compare, less is better, separated by commas; absent: residual_p95 and machine_time, or
    /// time_estimate where plans have no machine
    #[arg(long, value_name = "FIGURES", value_delimiter = ',')]
    pub over: Option<Vec<String>>,
    /// Print one JSON object instead of a table
    #[arg(long)]
    pub json: bool,
}
