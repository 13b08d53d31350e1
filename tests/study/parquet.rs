//! The table of a study as Parquet, read back.

use std::io::Write;

use parquet::basic::Type;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use vanecut::study::pareto::Table;
use vanecut::study::parquet::write_parquet;

#[test]
fn parquet_has_the_columns_and_values_of_the_table() {
    let csv = "id,part,status,plunge.step,axis,positions,residual_p95,error,program\n\
               0123456789012345,a.toml,done,2.5,minimal,10,1.25,,0.1\n\
               00000000000000e1,\"b, c.toml\",error,3,staircase,,,no plan,0.1\n";
    let table = Table::read_bytes("t.csv", csv.as_bytes()).unwrap();
    let bytes = write_parquet(&table).unwrap();
    assert_eq!(bytes, write_parquet(&table).unwrap());
    let mut written = tempfile::tempfile().unwrap();
    written.write_all(&bytes).unwrap();
    let file = SerializedFileReader::new(written).unwrap();
    let columns = file.metadata().file_metadata().schema_descr().columns().to_vec();
    let names: Vec<&str> = columns.iter().map(|column| column.name()).collect();
    assert_eq!(names, table.columns);
    let numbers: Vec<&str> = columns
        .iter()
        .filter(|column| column.physical_type() == Type::DOUBLE)
        .map(|column| column.name())
        .collect();
    assert_eq!(numbers, ["plunge.step", "positions", "residual_p95"]);
    for (row, expected) in file.get_row_iter(None).unwrap().zip(&table.rows) {
        for ((_, field), text) in row.unwrap().get_column_iter().zip(expected) {
            match field {
                Field::Null => assert!(text.is_empty(), "{text}"),
                Field::Double(number) => assert_eq!(text.parse(), Ok(*number)),
                Field::Str(shown) => assert_eq!(shown, text),
                other => panic!("{other:?} is no field of a table"),
            }
        }
    }
    assert_eq!(file.metadata().file_metadata().num_rows(), 2);
}
