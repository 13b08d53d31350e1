//! Judges an APT program of any CAM system against a part:
//! `cargo run --release --example judge_program -- PART.toml PROGRAM.apt`. It ends with exit code 1 when the
//! program has faults.

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use vanecut::io::apt::read_apt;
use vanecut::io::part_file::read_part;
use vanecut::monitor::Monitor;
use vanecut::part::Impeller;
use vanecut::setup::Setup;
use vanecut::verify::{VerifyError, verify, verify_flank};

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(part), Some(path)) = (arguments.next(), arguments.next()) else {
        return Err("usage: judge_program PART.toml PROGRAM.apt".into());
    };
    let part = Impeller::build(&read_part(Path::new(&part))?)?;
    let setup = Setup::for_part(&part);
    let workpiece = setup.allowances.workpiece_of(part);
    let program = read_apt(Path::new(&path))?;
    // Plunges and flank milling are judged by rules of their own; the moves of the program tell which it is.
    let monitor = Monitor::default();
    let judged = match program.mills_along_curves() {
        true => verify_flank(&workpiece, &setup, &program, &monitor).map(|verdict| verdict.faults),
        false => verify(&workpiece, &setup, &program, &monitor).map(|verdict| verdict.faults),
    };
    let faults = match judged {
        Err(VerifyError::Program(fault)) => vec![fault],
        judged => judged?,
    };
    for fault in &faults {
        println!("{path}:{}: {fault}", fault.line);
    }
    println!("{} faults", faults.len());
    Ok(if faults.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
