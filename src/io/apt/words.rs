//! Classification of APT words by their effect on the path of the cutter.

/// Effect of a statement that the reader does not apply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum WordEffect {
    /// It does not affect the path.
    Ignored,
    /// It moves the cutter or transforms what follows, and is not supported; with what to do.
    Unsupported(&'static str),
    /// It moves the cutter to a position that the program does not give.
    UnknownPosition,
    /// The word is unknown.
    Unknown,
}

const ARC: &str = "export the path as straight moves, GOTO alone";
const CYCLE: &str = "export drilling cycles as single moves";
const REPEAT: &str = "export the program with all repetitions written out";
const FRAME: &str = "export all positions in the coordinates of the part";
const CONTOUR: &str = "process the program first: only cutter locations are read";

/// Classifies a word that the reader does not apply; `list` has the words after its `/`.
pub(super) fn classify_word(word: &str, list: &[String]) -> WordEffect {
    let has = |name: &str| list.iter().any(|w| w == name);
    let off = has("OFF") || has("NOMORE");
    match word {
        "" | "MULTAX" | "COOLNT" | "TOOL PATH" | "MACHIN" | "INTOL" | "OUTTOL" | "TOLER" | "CLPRNT"
        | "NOPOST" | "STOP" | "OPSTOP" | "END" | "LOAD" | "SELECT" | "UNLOAD" | "DELAY" | "SEQNO"
        | "CHECK" | "DISPLY" | "PAINT" | "PRINT" | "AUTOPS" | "CLAMP" | "LEADER" | "REWIND" | "TITLES"
        | "CUTTER" | "PPFUN" | "SYN" | "CLEARP" | "MSYS" => WordEffect::Ignored,
        "CIRCLE" | "MOVARC" | "ARCSLP" | "ARCMOV" | "THREAD" | "SPLINE" | "NURBS" => {
            WordEffect::Unsupported(ARC)
        }
        "CYCLE" if off => WordEffect::Ignored,
        "CYCLE" | "POCKET" | "DRILL" => WordEffect::Unsupported(CYCLE),
        "COPY" | "INDEX" | "LOOPST" | "LOOPND" | "JUMPTO" | "CALL" | "MACRO" | "TERMAC" | "PATERN" => {
            WordEffect::Unsupported(REPEAT)
        }
        "CUTCOM" if off => WordEffect::Ignored,
        "MODE" | "SET" if !has("INCR") => WordEffect::Ignored,
        "REFSYS" | "MIRROR" | "SCALE" | "ROTABL" | "ROTATE" | "ROTHED" | "ORIGIN" | "CUTCOM" | "MODE"
        | "SET" => WordEffect::Unsupported(FRAME),
        "GO" | "GOFWD" | "GOBACK" | "GOLFT" | "GORGT" | "GOUP" | "GODOWN" | "INDIRV" | "INDIRP" | "PSIS"
        | "TLON" | "TLLFT" | "TLRGT" => WordEffect::Unsupported(CONTOUR),
        "GOHOME" | "RETRCT" => WordEffect::UnknownPosition,
        _ => WordEffect::Unknown,
    }
}
