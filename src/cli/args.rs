//! What may be typed.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

use crate::mesh::axis::Axis;
use crate::mesh::{MeshOptions, Role, Unit};
use crate::part::Rotation;

/// Plans the rough milling of centrifugal impellers. Without a command it opens the window.
#[derive(Debug, Parser)]
#[command(name = "vanecut", version, args_conflicts_with_subcommands = true)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Option<Command>,
    /// Part or setup to open in the window
    pub file: Option<PathBuf>,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Plunge plan of a part: plan.json and plunge.apt
    Plan(PlanArgs),
    /// Flank plan of a part, layer by layer: flank.json and flank.apt
    Flank(FlankArgs),
    /// Machinability of a part: twist, bend, depth, width, largest cutter, reach
    Assess(AssessArgs),
    /// Check any APT program against a part
    Verify(VerifyArgs),
    /// Picture of a part or of a plan.json, without a window
    Render(RenderArgs),
    /// Parts from format to format; a part or a plan to a glTF scene
    Convert(ConvertArgs),
    /// Throughput of the kernels on this machine
    Bench(BenchArgs),
}

/// `vanecut bench`.
#[derive(Debug, Args)]
pub struct BenchArgs {
    /// About how many positions the largest plan has by which growth is measured; 100000 takes many minutes
    #[arg(long, value_name = "N", default_value_t = 4000)]
    pub positions: usize,
}

/// What to know of a part that is a mesh.
#[derive(Debug, Args)]
#[command(next_help_heading = "Meshes")]
pub struct MeshArgs {
    /// Role of a node by its name: hub, shroud, blade, splitter or ignore; may be repeated
    #[arg(long = "role", value_name = "NODE=ROLE", value_parser = role)]
    pub roles: Vec<(String, Role)>,
    /// Unit of the file's numbers: mm, cm, m or in; absent: metres
    #[arg(long)]
    pub unit: Option<Unit>,
    /// Axis of rotation in the file: x, y or z; absent: found from the hub
    #[arg(long, value_name = "AXIS")]
    pub rotation_axis: Option<Axis>,
    /// Sense of rotation seen from the inlet, cw or ccw: the side of the blades that leads is the pressure side; absent:
    /// what the file says, or told from the blades' wrap
    #[arg(long, value_name = "SENSE")]
    pub rotation: Option<Rotation>,
    /// Number of main blades, where the file holds only one
    #[arg(long, value_name = "N")]
    pub blades: Option<usize>,
}

impl MeshArgs {
    /// As a reader takes it.
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

/// `NODE=ROLE`; a node's name may hold `=` too.
fn role(text: &str) -> Result<(String, Role), String> {
    let (node, role) = text.rsplit_once('=').ok_or("give NODE=ROLE, such as Body3=hub")?;
    Ok((node.to_owned(), role.parse()?))
}

/// `vanecut plan`.
#[derive(Debug, Args)]
pub struct PlanArgs {
    /// Part: .toml, .geomTurbo, TurboGrid .inf, .glb or .gltf
    pub part: PathBuf,
    #[command(flatten)]
    pub mesh: MeshArgs,
    /// Setup file; `-` reads it from standard input
    #[arg(long)]
    pub setup: Option<PathBuf>,
    /// conventional, monotone, minimal or staircase; absent: what the setup says
    #[arg(long)]
    pub axis: Option<String>,
    /// How many channels the program cuts: a number, or all
    #[arg(long, default_value = "1")]
    pub channels: String,
    /// Folder for plan.json and plunge.apt
    #[arg(short, long, default_value = ".")]
    pub output: PathBuf,
    /// Print one JSON object instead of a table
    #[arg(long)]
    pub json: bool,
    /// Write report.html with pictures as well
    #[arg(long)]
    pub report: bool,
}

/// `vanecut flank`.
#[derive(Debug, Args)]
pub struct FlankArgs {
    /// Part: .toml, .geomTurbo, TurboGrid .inf, .glb or .gltf
    pub part: PathBuf,
    #[command(flatten)]
    pub mesh: MeshArgs,
    /// Setup file; `-` reads it from standard input
    #[arg(long)]
    pub setup: Option<PathBuf>,
    /// isoparametric, layers, regions or balanced; absent: what the setup says
    #[arg(long)]
    pub scheme: Option<String>,
    /// Folder for flank.json and flank.apt
    #[arg(short, long, default_value = ".")]
    pub output: PathBuf,
    /// Print one JSON object instead of a table
    #[arg(long)]
    pub json: bool,
}

/// `vanecut assess`.
#[derive(Debug, Args)]
pub struct AssessArgs {
    /// Part: .toml, .geomTurbo, TurboGrid .inf, .glb or .gltf
    pub part: PathBuf,
    #[command(flatten)]
    pub mesh: MeshArgs,
    /// Setup file with the tools whose reach is asked for; `-` reads it from standard input
    #[arg(long)]
    pub setup: Option<PathBuf>,
    /// Print one JSON object instead of tables
    #[arg(long)]
    pub json: bool,
    /// Folder for pictures and curves; absent: none are drawn
    #[arg(short, long)]
    pub output: Option<PathBuf>,
}

/// `vanecut verify`.
#[derive(Debug, Args)]
pub struct VerifyArgs {
    /// Part: .toml, .geomTurbo, TurboGrid .inf, .glb or .gltf
    pub part: PathBuf,
    #[command(flatten)]
    pub mesh: MeshArgs,
    /// APT program; `-` reads it from standard input
    pub program: PathBuf,
    /// Setup file with the allowances and the insert widths
    #[arg(long)]
    pub setup: Option<PathBuf>,
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
    /// PNG to write
    #[arg(short, long)]
    pub output: PathBuf,
    /// Width x height in pixels
    #[arg(long, default_value = "1280x800")]
    pub size: String,
    /// iso, front, top, channel or section:K
    #[arg(long, default_value = "iso")]
    pub view: String,
    /// residual, interference or plain; absent: residual for a plan, plain for a part. Of a flank plan: layer, region,
    /// feed or walls; absent: layer
    #[arg(long)]
    pub show: Option<String>,
    /// State after this many positions; of a flank plan with --show feed, moves
    #[arg(long)]
    pub at: Option<usize>,
    /// Cutters: all, faulty or none; absent: what suits --show
    #[arg(long)]
    pub cutters: Option<String>,
    /// Ends of the colour scale of --show residual, mm, as LOW:HIGH; absent: fitted to the plan
    #[arg(long)]
    pub range: Option<String>,
    /// Also draw the shroud
    #[arg(long)]
    pub shroud: bool,
    /// Dark background
    #[arg(long)]
    pub dark: bool,
    /// No background: transparent where nothing is
    #[arg(long)]
    pub transparent: bool,
    /// Also draw the colour scale
    #[arg(long)]
    pub legend: bool,
}

/// `vanecut convert`.
#[derive(Debug, Args)]
pub struct ConvertArgs {
    /// Part, a plan.json, or a flank.json
    pub input: PathBuf,
    #[command(flatten)]
    pub mesh: MeshArgs,
    /// File to write: .toml, .glb or .gltf
    pub output: PathBuf,
    /// Largest distance of triangles from the surfaces, mm
    #[arg(long, default_value_t = 0.01)]
    pub chord_error: f64,
    /// One node per cutter, for viewers without EXT_mesh_gpu_instancing
    #[arg(long)]
    pub plain: bool,
}
