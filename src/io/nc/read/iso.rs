//! Words of Fanuc, Haas and LinuxCNC: a letter and a number each, comments in parentheses.

use super::words::{FORWARDS, NcFault, NcWord, UNKNOWN, fault, leading_number, no_letter, whole};
use crate::geometry::Vector;
use crate::io::nc::post::Dialect;
use crate::machine::turned;

/// A letter with its number.
type Letter = (char, f64);

/// Reads one line.
pub(super) fn words(dialect: Dialect, line: &str, out: &mut Vec<NcWord>) -> Result<(), NcFault> {
    let mut letters: Vec<Letter> = Vec::with_capacity(12);
    let mut rest = line.trim();
    if rest.starts_with('%') || dialect == Dialect::LinuxCnc && is_frame_of_sub(rest) {
        out.push(if rest.starts_with('%') { NcWord::Nothing } else { NcWord::IsCalled });
        return Ok(());
    }
    while let Some(first) = rest.chars().next() {
        if first == '(' {
            let Some((comment, after)) = rest.get(1..).and_then(|r| r.split_once(')')) else {
                return fault("the comment is not closed", "close it with `)`");
            };
            out.push(NcWord::Comment(comment.trim().to_owned()));
            rest = after.trim_start();
        } else if first == ';' && dialect == Dialect::LinuxCnc {
            out.push(NcWord::Comment(rest.get(1..).unwrap_or_default().trim().to_owned()));
            rest = "";
        } else if first.is_ascii_alphabetic() {
            let (x, after) = leading_number(rest.get(1..).unwrap_or_default().trim_start(), false)?;
            letters.push((first.to_ascii_uppercase(), x));
            rest = after.trim_start();
        } else {
            return no_letter(rest);
        }
    }
    for (index, (letter, _)) in letters.iter().enumerate() {
        let again = letters.iter().skip(index + 1).any(|(other, _)| other == letter);
        if again && !"GM".contains(*letter) {
            return fault(format!("{letter} stands twice in the block"), "split the block");
        }
    }
    let codes: Vec<i64> =
        letters.iter().filter(|l| l.0 == 'G').map(|l| (l.1 * 10.0).round() as i64).collect();
    let vectors = codes.contains(&435);
    if codes.contains(&682) {
        out.push(NcWord::Plane(euler_plane(&letters)?));
        return Ok(());
    }
    for (letter, x) in letters {
        match letter {
            'N' | 'O' | 'P' | 'E' | 'Q' => {}
            'G' => g_code(dialect, x, out)?,
            'M' => m_code(dialect, x, out)?,
            'X' => out.push(NcWord::Linear(0, x)),
            'Y' => out.push(NcWord::Linear(1, x)),
            'Z' => out.push(NcWord::Linear(2, x)),
            'A' | 'B' | 'C' => out.push(NcWord::Rotary(letter, x)),
            'I' if !vectors => out.push(NcWord::Direction(0, x)),
            'J' if !vectors => out.push(NcWord::Direction(1, x)),
            'K' if !vectors => out.push(NcWord::Direction(2, x)),
            'F' => out.push(NcWord::Rate(x)),
            'H' => out.push(NcWord::LengthOffset(x)),
            'S' => out.push(NcWord::Speed(x)),
            'T' => out.push(NcWord::Tool(whole(x)?)),
            _ => return fault(format!("the word {letter}{x} is not read"), UNKNOWN),
        }
    }
    Ok(())
}

/// Whether a line begins or ends a subprogram of LinuxCNC: `O<name> SUB`, `O<name> ENDSUB`.
fn is_frame_of_sub(line: &str) -> bool {
    let named = line.strip_prefix(['O', 'o']).and_then(|rest| rest.strip_prefix('<')?.split_once('>'));
    named.is_some_and(|(_, word)| {
        ["SUB", "ENDSUB"].iter().any(|known| word.trim().eq_ignore_ascii_case(known))
    })
}

/// `G68.2 X Y Z I J K`: turned about Z by I, about the new X by J, about the new Z by K.
fn euler_plane(letters: &[Letter]) -> Result<[Vector; 3], NcFault> {
    let value = |name: char| letters.iter().find(|l| l.0 == name).map(|l| l.1);
    if ['X', 'Y', 'Z'].iter().any(|name| value(*name).unwrap_or(0.0) != 0.0) {
        return fault("the plane of G68.2 has an origin of its own", UNKNOWN);
    }
    let (Some(i), Some(j), Some(k)) = (value('I'), value('J'), value('K')) else {
        return fault("G68.2 needs I, J and K", "give all three");
    };
    let turn = |v: Vector| {
        let v = turned(&Vector::z(), k.to_radians(), &v);
        let v = turned(&Vector::x(), j.to_radians(), &v);
        turned(&Vector::z(), i.to_radians(), &v)
    };
    Ok([turn(Vector::x()), turn(Vector::y()), turn(Vector::z())])
}

fn g_code(dialect: Dialect, x: f64, out: &mut Vec<NcWord>) -> Result<(), NcFault> {
    use Dialect::{Fanuc, Haas, LinuxCnc};
    let code = (x * 10.0).round() as i64;
    out.push(match (dialect, code) {
        (_, 0) => NcWord::Rapid,
        (_, 10) => NcWord::Feed,
        (Fanuc | Haas, 280) => NcWord::HomeOver,
        (_, 530) => NcWord::Home,
        (_, 430) => NcWord::Length(true),
        (_, 490) if dialect == LinuxCnc => NcWord::Length(false),
        (_, 490) => NcWord::TipOff,
        (Fanuc, 434) | (Haas, 2340) => NcWord::TipByAngles,
        (Fanuc, 435) => NcWord::TipByVector,
        (Fanuc, 690) => NcWord::PlaneOff,
        (_, 900) => NcWord::Incremental(false),
        (_, 910) => NcWord::Incremental(true),
        (_, 930) => NcWord::InverseTime(true),
        (_, 940) => NcWord::InverseTime(false),
        (Fanuc, 531) => NcWord::Swivel,
        (_, 210) => NcWord::Millimetres,
        (_, 540..=599) => NcWord::Offset(Some(x)),
        (_, 170 | 400 | 800) => NcWord::Nothing,
        (LinuxCnc, 610 | 640) | (Haas, 1870) | (Fanuc, 51) => NcWord::Nothing,
        (_, 200) => return fault("the program is in inches", "give a program in mm, G21"),
        (_, 20 | 30) => return fault("arcs are not read", "give straight moves, G1"),
        _ => return fault(format!("G{x} is not read"), UNKNOWN),
    });
    Ok(())
}

fn m_code(dialect: Dialect, x: f64, out: &mut Vec<NcWord>) -> Result<(), NcFault> {
    out.push(match x as i64 {
        3 => NcWord::Spindle(true),
        4 => return fault("the spindle turns backwards", FORWARDS),
        5 => NcWord::Spindle(false),
        6 => NcWord::Change,
        7..=9 | 0 | 1 | 10..=13 => NcWord::Nothing,
        2 | 30 => NcWord::MainEnd,
        99 if dialect != Dialect::LinuxCnc => NcWord::Return,
        428 if dialect == Dialect::LinuxCnc => NcWord::TipByAngles,
        429 if dialect == Dialect::LinuxCnc => NcWord::TipOff,
        _ => return fault(format!("M{x} is not read"), UNKNOWN),
    });
    Ok(())
}
