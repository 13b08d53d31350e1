//! The exchange structure of ISO 10303-21: header and instances by number.

mod parser;

pub use parser::parse;

/// A value of an instance.
#[derive(Clone, Debug, PartialEq)]
pub enum Value<'a> {
    /// A reference to an instance.
    Ref(u32),
    /// An integer or real number.
    Number(f64),
    /// A string, as it is between its apostrophes.
    Text(&'a [u8]),
    /// An enumeration or a logical value, without its dots.
    Enum(&'a str),
    /// A list.
    List(Vec<Self>),
    /// A typed value, such as a measure.
    Typed(Box<(&'a str, Vec<Self>)>),
    /// `$`, `*` or a binary string.
    Null,
}

impl<'a> Value<'a> {
    /// The number it refers to.
    pub fn reference(&self) -> Option<u32> {
        if let Value::Ref(id) = self { Some(*id) } else { None }
    }

    /// Its number; that of a measure, too.
    pub fn number(&self) -> Option<f64> {
        match self {
            Value::Number(x) => Some(*x),
            Value::Typed(typed) => typed.1.first()?.number(),
            _ => None,
        }
    }

    /// Its items.
    pub fn list(&self) -> Option<&[Self]> {
        if let Value::List(items) = self { Some(items) } else { None }
    }

    /// Its enumeration.
    pub fn word(&self) -> Option<&'a str> {
        if let Value::Enum(word) = self { Some(word) } else { None }
    }
}

/// A record: a keyword and its values.
#[derive(Clone, Debug)]
pub struct Record<'a> {
    /// The keyword.
    pub keyword: &'a str,
    /// The values.
    pub values: Vec<Value<'a>>,
}

/// An instance: one record, or several for a complex one.
#[derive(Clone, Debug)]
pub struct Instance<'a> {
    /// Its number.
    pub id: u32,
    /// Its records, at least one.
    pub records: Vec<Record<'a>>,
}

impl<'a> Instance<'a> {
    /// The values of the record with a keyword.
    pub fn record(&self, keyword: &str) -> Option<&[Value<'a>]> {
        self.records.iter().find(|r| r.keyword == keyword).map(|r| &*r.values)
    }

    /// The keyword of the only record, or of the first.
    pub fn keyword(&self) -> &'a str {
        self.records.first().map_or("", |r| r.keyword)
    }
}

/// The instances of a file, by increasing number.
#[derive(Clone, Debug, Default)]
pub struct Exchange<'a> {
    instances: Vec<Instance<'a>>,
}

impl<'a> Exchange<'a> {
    /// The instance with a number.
    pub fn get(&self, id: u32) -> Option<&Instance<'a>> {
        let at = self.instances.binary_search_by_key(&id, |i| i.id).ok()?;
        self.instances.get(at)
    }

    /// All instances, by increasing number.
    pub fn iter(&self) -> impl Iterator<Item = &Instance<'a>> {
        self.instances.iter()
    }
}

/// A string as text: doubled apostrophes and backslashes, and the codes `\X\`, `\X2\`, `\X4\` and `\S\`.
pub fn decoded(text: &[u8]) -> String {
    let text = String::from_utf8_lossy(text).replace("''", "'");
    let mut out = String::with_capacity(text.len());
    let mut rest = &*text;
    while let Some(at) = rest.find('\\') {
        out.push_str(&rest[..at]);
        rest = &rest[at..];
        let wide = [("\\X2\\", 4), ("\\X4\\", 8)].into_iter().find(|(code, _)| rest.starts_with(code));
        if let Some((code, width)) = wide {
            rest = &rest[code.len()..];
            let end = rest.find("\\X0\\").unwrap_or(rest.len());
            let units: Vec<u32> = rest.as_bytes()[..end]
                .chunks(width)
                .filter_map(|c| u32::from_str_radix(std::str::from_utf8(c).ok()?, 16).ok())
                .collect();
            out.extend(units.into_iter().filter_map(char::from_u32));
            rest = rest.get(end + 4..).unwrap_or_default();
        } else if let Some(code) = rest.strip_prefix("\\X\\").and_then(|r| r.get(..2)) {
            out.extend(u32::from_str_radix(code, 16).ok().and_then(char::from_u32));
            rest = &rest[5..];
        } else if let Some(next) = rest.strip_prefix("\\S\\").and_then(|r| r.chars().next()) {
            out.extend(char::from_u32(next as u32 + 128));
            rest = &rest[3 + next.len_utf8()..];
        } else {
            out.push('\\');
            rest = rest.strip_prefix("\\\\").unwrap_or(&rest[1..]);
        }
    }
    out.push_str(rest);
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::ErrorCode;

    fn file(data: &str) -> String {
        format!(
            "ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('AUTOMOTIVE_DESIGN {{ 1 0 10303 214 }}'));\nENDSEC;\n\
             DATA;\n{data}\nENDSEC;\nEND-ISO-10303-21;\n"
        )
    }

    #[test]
    fn all_kinds_of_values_are_read() {
        let text = file(
            "#2=B(#1,(1,-2.5E-1),'it''s; )',.T.,$,*,\"0F\",LENGTH_MEASURE(3.),());/* a; #9=( */\n\
             #1 = ( A ( 1. ) C_D ( ) ) ;",
        );
        let exchange = parse("a.step", text.as_bytes()).expect("sound");
        let b = exchange.get(2).expect("defined").record("B").expect("its keyword");
        assert_eq!(b[0], Value::Ref(1));
        assert_eq!(b[1], Value::List(vec![Value::Number(1.0), Value::Number(-0.25)]));
        assert_eq!(b[2], Value::Text(b"it''s; )"));
        assert_eq!((b[3].word(), &b[4], &b[5], &b[6]), (Some("T"), &Value::Null, &Value::Null, &Value::Null));
        assert_eq!((b[7].number(), b[8].list()), (Some(3.0), Some(&[][..])));
        assert_eq!(exchange.get(1).expect("complex").record("C_D"), Some(&[][..]));
        assert!(exchange.get(9).is_none(), "it is in a comment");
    }

    #[test]
    fn faults_name_line_and_instance() {
        let deep = format!("#7=A({}1{});", "(".repeat(5000), ")".repeat(5000));
        for (data, code, instance) in [
            ("#7=A(1,);", ErrorCode::StepFile, "#7: "),
            ("#7=A(1;", ErrorCode::StepFile, "#7: "),
            ("#7=A(1e999);", ErrorCode::StepFile, "#7: "),
            ("#7=A(#99999999999);", ErrorCode::StepFile, "#7: "),
            ("#7=A('x);", ErrorCode::FileCutOff, "#7: "),
            ("#7=A();\n#7=B();", ErrorCode::StepFile, "#7: "),
            (&*deep, ErrorCode::StepFile, "#7: "),
            ("what", ErrorCode::StepFile, ""),
        ] {
            let error = parse("a.step", file(data).as_bytes()).expect_err(data);
            assert_eq!(error.code, code, "{error}");
            assert!(error.message.starts_with(instance), "{error}");
            assert_eq!(error.to_string().lines().count(), 1);
        }
        let error = parse("a.step", file("#7=A(1,);").as_bytes()).expect_err("no value");
        assert_eq!(error.place(), "a.step:6");
        let other = file("").replace("AUTOMOTIVE_DESIGN", "IFC4");
        let error = parse("a.step", other.as_bytes()).expect_err("another schema");
        assert_eq!((error.code, error.place()), (ErrorCode::StepFile, "a.step:3".to_owned()));
        assert_eq!(error.help, "export it as AP203, AP214 or AP242", "the schemas that are read");
        assert!(parse("a.step", b"\x7fELF\0\0").is_err());
    }

    #[test]
    fn a_file_cut_off_anywhere_is_refused() {
        let whole = file("#1=A('b',(1.,2.));\n#2=(B(#1)C($));");
        let end = whole.find("END-ISO").expect("it ends") + "END-ISO-10303-21".len();
        for length in 0..end {
            assert!(parse("a.step", &whole.as_bytes()[..length]).is_err(), "{length} bytes");
        }
        assert!(parse("a.step", &whole.as_bytes()[..end]).is_ok());
    }

    #[test]
    fn strings_are_decoded() {
        assert_eq!(decoded(b"it''s C:\\\\a"), "it's C:\\a");
        assert_eq!(decoded(b"N\\X2\\00E4\\X0\\be \\X\\FC \\S\\d"), "Näbe ü ä");
        assert_eq!(decoded("\\X2\\zz\\X\\€".as_bytes()), "");
    }
}
