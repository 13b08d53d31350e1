//! The stock as a solid at the timeline's position, computed in the background: coarse at once, then fine.

use std::sync::{Arc, Mutex, PoisonError};

use crate::drawing::solid::solid_mesh;
use crate::gpu::mesh::{Mesh, Paint};
use crate::io::gltf::GltfScene;
use crate::io::stl::write_stl;
use crate::job::worker::{Outcome, Worker};
use crate::monitor::{Cancelled, Monitor};
use crate::palette::{self, Rgb, category};
use crate::part::{Impeller, Workpiece};
use crate::plunge::{Condition, PlungePlan, Position};
use crate::setup::Setup;
use crate::stock::excess::Excess;
use crate::stock::solid::{
    COARSE_RAYS, Contact, FINE_RAYS, SolidBlank, SolidError, SolidProgram, SolidStock, SpanEnd, StockPlayer,
    StockSurface,
};
use crate::toolpath::ClProgram;

use super::Repaint;
use crate::app::model::solid::{PlannedSolid, SolidColours, SolidRequest, SolidSource, StockMoment};

/// The solid to draw.
#[derive(Clone, Debug)]
pub struct SolidPicture {
    /// What it shows.
    pub request: SolidRequest,
    /// Its triangles.
    pub mesh: Arc<Mesh>,
    /// Fewer triangles of the same solid, for pictures in motion.
    pub draft: Option<Arc<Mesh>>,
    /// Distance of its rays, mm.
    pub spacing: f64,
    /// Volume, mm³.
    pub volume: f64,
    /// Number of collisions of core, shank, holder or a rapid with stock so far.
    pub collisions: usize,
    /// Names of the colours, where they are no scale.
    pub names: Vec<(Rgb, String)>,
    /// Whether a finer one follows.
    pub is_coarse: bool,
}

impl PlannedSolid {
    /// The plunge plan of its channels.
    fn plan(&self) -> PlungePlan {
        let (outcome, result) = (&self.planned.outcome, self.planned.result(self.policy));
        // A newer request waits until this one has begun.
        let plan = outcome.plan_of_channels(result, self.channels, &Monitor::default());
        plan.unwrap_or_else(|Cancelled| result.plan.clone())
    }

    /// The moves of `plan`, its plunge plan, and of the flank plan, as the exported programs have them.
    fn program(&self, plan: &PlungePlan) -> ClProgram {
        let name = &self.planned.outcome.workpiece.part.name;
        let mut program = ClProgram::of_plan(name, plan);
        if let Some(flank) = &self.flank {
            let after = ClProgram::of_flank(name, &flank.outcome.plan.tool, flank.moves());
            let first = program.tools.len();
            program.tools.extend(after.tools);
            program.moves.extend(after.moves.into_iter().map(|mut step| {
                step.tool = step.tool.map(|tool| tool + first);
                step
            }));
        }
        program
    }
}

/// What is simulated, as a program: with the plunge plan that it begins with, where it is one of plans.
struct SolidCuts {
    plan: Option<PlungePlan>,
    program: ClProgram,
}

impl SolidSource {
    fn workpiece(&self) -> &Workpiece {
        match self {
            Self::Plans(plans) => &plans.planned.outcome.workpiece,
            Self::Program(checked) => &checked.workpiece,
        }
    }

    fn part(&self) -> &Impeller {
        &self.workpiece().part
    }

    fn setup(&self) -> &Setup {
        match self {
            Self::Plans(plans) => &plans.planned.outcome.setup,
            Self::Program(checked) => &checked.request.setup,
        }
    }

    /// The moves of a checked program that have a fault, in order.
    fn faulty_moves(&self) -> Vec<usize> {
        let Self::Program(checked) = self else { return Vec::new() };
        let mut moves: Vec<usize> =
            checked.findings.iter().filter_map(|finding| finding.first_move).collect();
        moves.sort_unstable();
        moves
    }

    /// Whether more than the first channel may be cut.
    fn cuts_several_channels(&self) -> bool {
        match self {
            Self::Plans(plans) => plans.channels > 1,
            Self::Program(_) => true,
        }
    }

    fn cuts(&self) -> SolidCuts {
        match self {
            Self::Plans(plans) => {
                let plan = plans.plan();
                let program = plans.program(&plan);
                SolidCuts { plan: Some(plan), program }
            }
            Self::Program(checked) => SolidCuts { plan: None, program: checked.program.clone() },
        }
    }

    /// Number of moves of `cuts` that are made.
    fn moves_until(&self, moment: StockMoment, cuts: &SolidCuts) -> usize {
        let all = cuts.program.moves.len();
        match (moment, self) {
            (StockMoment::End, _) => all,
            (StockMoment::Moves(made), _) => made.min(all),
            (StockMoment::Plunges(cut), _) => {
                let Some(plan) = &cuts.plan else { return all };
                // A plunge without a tool has no moves.
                let has_tool = |position: &&Position| plan.sections.get(position.section).is_some();
                let plunges = plan.positions.iter().take(cut).filter(has_tool).count();
                cuts.program.plunge_starts().get(plunges).copied().unwrap_or(all)
            }
            (StockMoment::FlankMoves(made), Self::Plans(PlannedSolid { flank: Some(flank), .. })) => {
                all - flank.moves().len().saturating_sub(made)
            }
            (StockMoment::FlankMoves(_), _) => all,
        }
    }

    /// The blank with rays at a spacing.
    fn blank(&self, rays: f64) -> Result<(SolidStock, f64), SolidError> {
        let blank = SolidBlank::from_part(self.part(), &self.workpiece().blank);
        let spacing = blank.default_spacing() * 800.0 / rays;
        Ok((SolidStock::new(&blank, spacing)?, spacing))
    }
}

/// The players of one source, which keep what was simulated.
struct Bench {
    source: SolidSource,
    cuts: SolidCuts,
    coarse: (StockPlayer, f64),
    fine: Option<(StockPlayer, f64)>,
}

impl Bench {
    fn new(source: &SolidSource) -> Result<Self, String> {
        let cuts = source.cuts();
        let coarse = player(source, &cuts.program, COARSE_RAYS)?;
        Ok(Self { source: source.clone(), cuts, coarse, fine: None })
    }
}

fn player(source: &SolidSource, program: &ClProgram, rays: f64) -> Result<(StockPlayer, f64), String> {
    let moves = SolidProgram::new(program, source.setup()).map_err(|e| e.to_string())?;
    let (blank, spacing) = source.blank(rays).map_err(|e| e.to_string())?;
    Ok((StockPlayer::new(moves, blank), spacing))
}

/// Slot for the coarse solid while the fine one is computed.
type CoarseSlot = Arc<Mutex<Option<SolidPicture>>>;

/// Computes the solid in the background.
pub(in crate::app) struct SolidWork {
    worker: Worker<SolidRequest, SolidPicture, String>,
    slot: CoarseSlot,
    bench: Arc<Mutex<Option<Bench>>>,
    asked: Option<SolidRequest>,
    /// Whether the coarse solid of the request is still to come.
    awaits_coarse: bool,
    /// The latest solid; it may be older than the request.
    shown: Option<Arc<SolidPicture>>,
}

impl SolidWork {
    /// Starts the thread; it repaints the window after each solid.
    pub(in crate::app) fn new(repaint: &Repaint) -> Self {
        let slot = CoarseSlot::default();
        let bench: Arc<Mutex<Option<Bench>>> = Arc::default();
        let work = {
            let (slot, bench, repaint) = (Arc::clone(&slot), Arc::clone(&bench), Arc::clone(repaint));
            move |request: &SolidRequest, monitor: &Monitor| {
                let mut bench = bench.lock().unwrap_or_else(PoisonError::into_inner);
                let listen = |picture: SolidPicture| {
                    *slot.lock().unwrap_or_else(PoisonError::into_inner) = Some(picture);
                    repaint();
                };
                simulate(&mut bench, request, monitor, listen)
            }
        };
        let repaint = Arc::clone(repaint);
        let worker = Worker::new("solid", work, move || repaint());
        Self { worker, slot, bench, asked: None, awaits_coarse: false, shown: None }
    }

    /// Requests the solid that the window shows now, and collects finished ones. Returns why the last request
    /// failed, once.
    pub(in crate::app) fn follow(&mut self, wanted: Option<SolidRequest>) -> Option<String> {
        let mut fault = None;
        let coarse = self.slot.lock().unwrap_or_else(PoisonError::into_inner).take();
        let mut take = |picture: SolidPicture| {
            // Of another plan, or before the layer was hidden.
            if self.asked.as_ref().is_some_and(|asked| asked.source == picture.request.source) {
                self.shown = Some(Arc::new(picture));
            }
        };
        let outcome = self.worker.take_outcome();
        if coarse.is_some() || outcome.is_some() {
            self.awaits_coarse = false;
        }
        if let Some(picture) = coarse {
            take(picture);
        }
        match outcome {
            Some((_, Outcome::Done(picture))) => take(picture),
            Some((_, Outcome::Failed(error))) if !error.is_empty() => fault = Some(error),
            Some((_, Outcome::Panicked(what))) => fault = Some(format!("failed unexpectedly ({what})")),
            _ => {}
        }
        let same_source =
            self.asked.as_ref().map(|asked| &asked.source) == wanted.as_ref().map(|w| &w.source);
        // While the timeline moves, let each coarse solid arrive: restarting at every step would show none.
        let worth_waiting = same_source && wanted.is_some() && self.awaits_coarse && self.worker.is_busy();
        if wanted != self.asked && !worth_waiting {
            self.awaits_coarse = wanted.is_some();
            match &wanted {
                Some(request) => {
                    if self.shown.as_ref().is_some_and(|shown| shown.request.source != request.source) {
                        self.shown = None;
                    }
                    self.worker.submit(request.clone());
                }
                None => {
                    self.worker.cancel();
                    self.shown = None;
                }
            }
            self.asked = wanted;
        }
        // Hidden, the layer takes no memory.
        if self.asked.is_none()
            && let Ok(mut bench) = self.bench.try_lock()
        {
            *bench = None;
        }
        fault
    }

    /// The latest solid, which may be of an earlier request for the same plan.
    pub(in crate::app) fn shown(&self) -> Option<&Arc<SolidPicture>> {
        self.shown.as_ref()
    }

    /// Whether a solid is being computed.
    pub(in crate::app) fn is_busy(&self) -> bool {
        self.worker.is_busy()
    }
}

/// Simulates a request, coarse first. An empty error means that it was cancelled.
fn simulate(
    bench: &mut Option<Bench>,
    request: &SolidRequest,
    monitor: &Monitor,
    listen: impl FnOnce(SolidPicture),
) -> Result<SolidPicture, String> {
    let known = bench.take().filter(|bench| bench.source == request.source);
    let bench = match known {
        Some(known) => bench.insert(known),
        None => bench.insert(Bench::new(&request.source)?),
    };
    let count = request.source.moves_until(request.moment, &bench.cuts);
    let picture = |(player, spacing): &mut (StockPlayer, f64), is_coarse| {
        let (stock, contacts) = player.at(count, monitor).map_err(|error| match error {
            SolidError::Cancelled(_) => String::new(),
            other => other.to_string(),
        })?;
        let surface = StockSurface::from_stock(stock);
        monitor.check().map_err(|_| String::new())?;
        let (mesh, names) = painted(request, &bench.cuts, contacts, &surface, *spacing, monitor)?;
        Ok::<_, String>(SolidPicture {
            request: request.clone(),
            mesh: Arc::new(mesh),
            draft: None,
            spacing: *spacing,
            volume: surface.volume(),
            collisions: contacts.len(),
            names,
            is_coarse,
        })
    };
    let coarse = picture(&mut bench.coarse, true)?;
    let draft = Some(Arc::clone(&coarse.mesh));
    listen(coarse);
    if bench.fine.is_none() {
        bench.fine = Some(player(&request.source, &bench.cuts.program, FINE_RAYS)?);
    }
    let Some(fine) = &mut bench.fine else { return Err(String::new()) };
    Ok(SolidPicture { draft, ..picture(fine, false)? })
}

/// The triangles of a surface in the colours of a request, and the names of the colours.
fn painted(
    request: &SolidRequest,
    cuts: &SolidCuts,
    contacts: &[Contact],
    surface: &StockSurface,
    spacing: f64,
    monitor: &Monitor,
) -> Result<(Mesh, Vec<(Rgb, String)>), String> {
    let painter = Painter::new(request, cuts, contacts);
    let excess = (request.colours == SolidColours::Distance).then(|| {
        let excess = Excess::new(request.source.workpiece());
        if request.source.cuts_several_channels() { excess.in_all_channels() } else { excess }
    });
    let paint = |cut_by: u32| painter.paint(cut_by);
    // Cancelled by a newer request.
    let mesh = solid_mesh(surface, spacing, excess.as_ref(), paint, monitor).map_err(|_| String::new())?;
    Ok((mesh, painter.names))
}

/// Colours of moves.
struct Painter {
    colours: SolidColours,
    /// Colour of each move that cuts, where it does not depend on the distance.
    moves: Vec<Rgb>,
    names: Vec<(Rgb, String)>,
}

impl Painter {
    fn new(request: &SolidRequest, cuts: &SolidCuts, contacts: &[Contact]) -> Self {
        let SolidCuts { plan, program } = cuts;
        let mut names: Vec<(Rgb, String)> = Vec::new();
        let mut note = |colour: Rgb, name: String| {
            if !names.iter().any(|(_, known)| *known == name) {
                names.push((colour, name));
            }
            colour
        };
        let starts = program.plunge_starts();
        // The plunges that have moves, in their order.
        let sections = plan.as_ref().map_or(0, |plan| plan.sections.len());
        let positions = plan.iter().flat_map(|plan| &plan.positions).filter(|p| p.section < sections);
        let positions: Vec<_> = positions.collect();
        let position =
            |number: usize| positions.get(starts.partition_point(|start| *start <= number).saturating_sub(1));
        let section = |number: usize| match plan {
            Some(_) => position(number).map(|p| p.section),
            None => program
                .rows
                .partition_point(|row| row.first_move <= number)
                .checked_sub(1)
                .map(|row| program.rows[row].section),
        };
        let faulty = request.source.faulty_moves();
        let collides =
            |number: usize| contacts.binary_search_by_key(&number, |contact| contact.number as usize).is_ok();
        let colour = |(number, step): (usize, &crate::toolpath::Move)| match request.colours {
            SolidColours::Distance => [0.0; 3],
            SolidColours::Tool => {
                let index = step.tool.unwrap_or_default();
                let name = program
                    .tools
                    .get(index)
                    .map_or_else(String::new, |tool| format!("T{} D{}", tool.number, tool.diameter));
                note(category(index), name)
            }
            SolidColours::Section => match section(number) {
                Some(section) => note(category(section), format!("Section {}", section + 1)),
                None if plan.is_some() => note(category(sections), "Flank".to_owned()),
                None => note(category(0), "No section".to_owned()),
            },
            SolidColours::Fault => {
                match position(number).map_or(Condition::Sound, |position| position.condition()) {
                    Condition::Interfering => note(palette::INTERFERING, "Interfering".to_owned()),
                    _ if faulty.binary_search(&number).is_ok() => {
                        note(palette::INTERFERING, "Fault".to_owned())
                    }
                    _ if collides(number) => note(palette::INTERFERING, "Interfering".to_owned()),
                    Condition::Blocked => note(palette::BLOCKED, "Blocked".to_owned()),
                    Condition::Sound => note(palette::SOUND, "Sound".to_owned()),
                }
            }
        };
        let moves = program.moves.iter().enumerate().map(colour).collect();
        if request.colours == SolidColours::Distance {
            names.clear();
        }
        Self { colours: request.colours, moves, names }
    }

    fn paint(&self, cut_by: u32) -> Paint {
        match self.moves.get(cut_by as usize) {
            _ if cut_by == SpanEnd::BLANK => Paint::UNCUT,
            Some(colour) if self.colours != SolidColours::Distance => Paint::colour(*colour),
            _ => Paint::BY_VALUE,
        }
    }
}

/// Rays across the wheel in an exported solid.
const EXPORTED: f64 = 800.0;

/// The stock as a file: glTF if `is_scene`, else STL.
///
/// # Errors
/// One line on why it cannot be simulated.
pub(in crate::app) fn solid_bytes(
    source: &SolidSource,
    moment: StockMoment,
    is_scene: bool,
) -> Result<Vec<u8>, String> {
    let cuts = source.cuts();
    let (mut player, _) = player(source, &cuts.program, EXPORTED)?;
    let count = source.moves_until(moment, &cuts);
    let (stock, _) = player.at(count, &Monitor::default()).map_err(|error| error.to_string())?;
    let surface = StockSurface::from_stock(stock);
    let name = &source.part().name;
    Ok(if is_scene {
        GltfScene::of_stock(name, &surface, surface.volume()).glb()
    } else {
        write_stl(&surface.points, &surface.triangles, name)
    })
}
