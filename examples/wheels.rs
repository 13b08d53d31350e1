//! Writes made wheels as native part files: `cargo run --example wheels -- SEED COUNT DIR`.

#![expect(clippy::disallowed_methods, reason = "an example writes plainly")]

#[path = "../tests/wheels/make/mod.rs"]
mod make;

use std::path::Path;
use std::process::ExitCode;

use vanecut::io::native::write_native;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [seed, count, folder] = arguments.as_slice() else { return usage() };
    let (Ok(seed), Ok(count)) = (seed.parse::<u64>(), count.parse::<usize>()) else { return usage() };
    for index in 0..count {
        let wheel = make::wheel(seed, index);
        let name = &wheel.description.name;
        let path = Path::new(folder).join(format!("{name}.toml"));
        if let Err(error) = std::fs::write(&path, write_native(&wheel.description)) {
            eprintln!("{}: {error}", path.display());
            return ExitCode::FAILURE;
        }
        println!("{name}: {}", wheel.remarks);
    }
    ExitCode::SUCCESS
}

fn usage() -> ExitCode {
    eprintln!("usage: wheels SEED COUNT DIR");
    ExitCode::from(2)
}
