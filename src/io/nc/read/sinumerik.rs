//! Words of the Sinumerik: letters, addresses with `=`, names, calls of cycles; comments after `;`.

use super::words::{FORWARDS, NcFault, NcWord, UNKNOWN, fault, leading_number, no_letter, whole};
use crate::geometry::Vector;
use crate::io::source::quote_for_message;
use crate::machine::turned;

/// Reads one line.
pub(super) fn words(line: &str, out: &mut Vec<NcWord>) -> Result<(), NcFault> {
    let (code, comment) = line.split_once(';').map_or((line, None), |(code, comment)| (code, Some(comment)));
    if let Some(comment) = comment {
        out.push(NcWord::Comment(comment.trim().to_owned()));
    }
    let mut rest = code.trim();
    if rest.starts_with('%') {
        return Ok(());
    }
    while !rest.is_empty() {
        let name_end = rest.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(rest.len());
        let (name, after) = rest.split_at(name_end);
        rest = match name.to_ascii_uppercase().as_str() {
            "" => return no_letter(rest),
            "CYCLE" => cycle(after, out)?,
            "TRAORI" => say(out, NcWord::TipByAngles, after),
            "TRAFOOF" => say(out, NcWord::TipOff, after),
            "SUPA" => say(out, NcWord::Home, after),
            "ORIVECT" => {
                out.push(NcWord::TipByVector);
                say(out, NcWord::Interpolation, after)
            }
            "ORIAXES" => say(out, NcWord::Interpolation, after),
            "ORIWKS" => say(out, NcWord::Orientation, after),
            letter if letter.len() == 1 => word(letter.chars().next().unwrap_or(' '), after, out)?,
            other => return fault(format!("{} is not read", quote_for_message(other)), UNKNOWN),
        }
        .trim_start();
    }
    Ok(())
}

fn say<'a>(out: &mut Vec<NcWord>, word: NcWord, after: &'a str) -> &'a str {
    out.push(word);
    after
}

/// A word of one letter: `X10.5`, `X=10.5`, `A3=0.5`, `G1`.
fn word<'a>(letter: char, after: &'a str, out: &mut Vec<NcWord>) -> Result<&'a str, NcFault> {
    if let Some(after) = after.strip_prefix("3=") {
        let (x, rest) = leading_number(after, false)?;
        let index = match letter {
            'A' => 0,
            'B' => 1,
            'C' => 2,
            _ => return fault(format!("the address {letter}3 is not read"), UNKNOWN),
        };
        out.push(NcWord::Direction(index, x));
        return Ok(rest);
    }
    let (x, rest) = leading_number(after.strip_prefix('=').unwrap_or(after), false)?;
    match letter {
        'N' => {}
        'X' => out.push(NcWord::Linear(0, x)),
        'Y' => out.push(NcWord::Linear(1, x)),
        'Z' => out.push(NcWord::Linear(2, x)),
        'A' | 'B' | 'C' => out.push(NcWord::Rotary(letter, x)),
        'F' => out.push(NcWord::Rate(x)),
        'S' => out.push(NcWord::Speed(x)),
        'T' => out.push(NcWord::Tool(whole(x)?)),
        'D' => out.push(NcWord::Length(x > 0.0)),
        'G' => out.push(match x as i64 {
            0 => NcWord::Rapid,
            1 => NcWord::Feed,
            90 => NcWord::Incremental(false),
            91 => NcWord::Incremental(true),
            93 => NcWord::InverseTime(true),
            94 => NcWord::InverseTime(false),
            71 => NcWord::Millimetres,
            54..=57 | 505..=599 => NcWord::Offset(Some(x)),
            17 | 40 | 64 => NcWord::Nothing,
            70 => return fault("the program is in inches", "give a program in mm, G71"),
            _ => return fault(format!("G{x} is not read"), UNKNOWN),
        }),
        'M' => out.push(match x as i64 {
            3 => NcWord::Spindle(true),
            4 => return fault("the spindle turns backwards", FORWARDS),
            5 => NcWord::Spindle(false),
            6 => NcWord::Change,
            7..=9 | 0 | 1 => NcWord::Nothing,
            17 => NcWord::Return,
            2 | 30 => NcWord::MainEnd,
            _ => return fault(format!("M{x} is not read"), UNKNOWN),
        }),
        _ => return fault(format!("the word {letter}{x} is not read"), UNKNOWN),
    }
    Ok(rest)
}

/// `CYCLE800(…)`, the swivelled plane, and `CYCLE832(…)`, the tolerance; `after` begins with the number.
fn cycle<'a>(after: &'a str, out: &mut Vec<NcWord>) -> Result<&'a str, NcFault> {
    let (number, rest) = leading_number(after, false)?;
    let Some((list, rest)) = rest.strip_prefix('(').and_then(|r| r.split_once(')')) else {
        return fault("the call of the cycle has no closed parentheses", "close them");
    };
    match number as i64 {
        832 => {}
        800 if list.trim().is_empty() => out.push(NcWord::PlaneOff),
        800 => out.extend([NcWord::Plane(swivelled(list)?), NcWord::Swivel]),
        _ => return fault(format!("CYCLE{number} is not read"), UNKNOWN),
    }
    Ok(rest)
}

/// `_FR,_TC,_ST,_MODE,X0,Y0,Z0,A,B,C,X1,Y1,Z1,…` with mode 57: about X by A, the new Y by B, the new Z by C.
fn swivelled(list: &str) -> Result<[Vector; 3], NcFault> {
    let parameters: Vec<&str> = list.split(',').map(str::trim).collect();
    let value = |index: usize| -> Result<f64, NcFault> {
        match parameters.get(index) {
            None | Some(&"") => Ok(0.0),
            Some(text) => leading_number(text, false).map(|(x, _)| x),
        }
    };
    if value(3)? != 57.0 {
        return fault("CYCLE800 has another mode than 57", "swivel axis by axis, X, Y, Z: mode 57");
    }
    if value(2)? % 10.0 != 0.0 {
        return fault("the plane of CYCLE800 is turned from the one before", "give _ST 100000");
    }
    if value(13)?.abs() != 1.0 {
        return fault("CYCLE800 does not turn the axes", "give _DIR -1 or 1");
    }
    for index in [4, 5, 6, 10, 11, 12] {
        if value(index)? != 0.0 {
            return fault("the plane of CYCLE800 has an origin of its own", UNKNOWN);
        }
    }
    let (a, b, c) = (value(7)?.to_radians(), value(8)?.to_radians(), value(9)?.to_radians());
    let turn = |v: Vector| {
        let v = turned(&Vector::z(), c, &v);
        let v = turned(&Vector::y(), b, &v);
        turned(&Vector::x(), a, &v)
    };
    Ok([turn(Vector::x()), turn(Vector::y()), turn(Vector::z())])
}
