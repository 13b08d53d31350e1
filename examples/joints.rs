//! Machine coordinates of poses: `cargo run --example joints -- MACHINE.toml LENGTH < poses`, with poses as
//! lines of `x y z first second` (tip in program coordinates, mm; positions of both rotary axes, degrees) for
//! a tool of LENGTH mm. Prints X Y Z of the spindle nose, mm.

use std::io::BufRead as _;
use std::path::Path;
use std::process::ExitCode;

use vanecut::geometry::{Point, Vector};
use vanecut::io::machine_file::read_machine;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(what) => {
            eprintln!("{what}");
            ExitCode::from(2)
        }
    }
}

fn run() -> Result<(), String> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, length] = arguments.as_slice() else {
        return Err("usage: joints MACHINE LENGTH < poses".to_owned());
    };
    let machine = read_machine(Path::new(file)).map_err(|error| error.to_string())?;
    let length: f64 = length.parse().map_err(|_| format!("`{length}` is not a length"))?;
    for line in std::io::stdin().lock().lines() {
        let line = line.map_err(|error| error.to_string())?;
        let numbers: Result<Vec<f64>, _> = line.split_whitespace().map(str::parse).collect();
        let numbers = numbers.map_err(|_| format!("not numbers: {line}"))?;
        let [x, y, z, first, second] = numbers[..] else { return Err(format!("not five numbers: {line}")) };
        let tip = Point::from(Vector::new(x, y, z));
        let angles = [f64::to_radians(first), f64::to_radians(second)];
        let [x, y, z] = machine.joints(&tip, &angles, length);
        println!("{x:.15} {y:.15} {z:.15}");
    }
    Ok(())
}
