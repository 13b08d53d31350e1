//! The table of a study as Apache Parquet: one row group, columns in the order of the table. Figures and keys
//! whose values are numbers are columns of numbers; what is empty in the table is null.

use std::sync::Arc;

use parquet::basic::{ConvertedType, LogicalType, Repetition, Type as PhysicalType};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{Type, TypePtr};

use super::merge::{HEAD, TAIL};
use super::pareto::Table;
use crate::error::{ErrorCode, UserError};

/// `table` as a Parquet file. The same table gives the same bytes.
///
/// # Errors
/// When it has no columns, or more than the format takes.
pub fn write_parquet(table: &Table) -> Result<Vec<u8>, UserError> {
    let unwritten = |error: ParquetError| {
        UserError::new(ErrorCode::StudyResults, format!("is no Parquet table: {error}"), "write a .csv file")
    };
    file_of(table).map_err(unwritten)
}

/// A column of the file: a value for each row that has one.
enum Column {
    Numbers(Vec<Option<f64>>),
    Texts(Vec<Option<ByteArray>>),
}

impl Column {
    /// Column `place` of `table`: of numbers where every value is one, and it is no name.
    fn of_table(table: &Table, place: usize) -> Self {
        let fields =
            || table.rows.iter().map(|row| Some(row[place].as_str()).filter(|text| !text.is_empty()));
        let name = table.columns[place].as_str();
        let is_name = HEAD.contains(&name) || TAIL.contains(&name);
        let numbers: Option<Vec<Option<f64>>> =
            fields().map(|field| field.map(str::parse).transpose().ok()).collect();
        match numbers.filter(|_| !is_name) {
            Some(numbers) => Self::Numbers(numbers),
            None => Self::Texts(fields().map(|field| field.map(ByteArray::from)).collect()),
        }
    }

    fn schema(&self, name: &str) -> Result<TypePtr, ParquetError> {
        let column = match self {
            Self::Numbers(_) => Type::primitive_type_builder(name, PhysicalType::DOUBLE),
            Self::Texts(_) => Type::primitive_type_builder(name, PhysicalType::BYTE_ARRAY)
                .with_logical_type(Some(LogicalType::String))
                .with_converted_type(ConvertedType::UTF8),
        };
        column.with_repetition(Repetition::OPTIONAL).build().map(Arc::new)
    }

    fn write(&self, group: &mut SerializedRowGroupWriter<'_, Vec<u8>>) -> Result<(), ParquetError> {
        let Some(mut column) = group.next_column()? else { return Ok(()) };
        match self {
            Self::Numbers(numbers) => {
                let (values, levels) = present(numbers);
                column.typed::<DoubleType>().write_batch(&values, Some(&levels), None)?;
            }
            Self::Texts(texts) => {
                let (values, levels) = present(texts);
                column.typed::<ByteArrayType>().write_batch(&values, Some(&levels), None)?;
            }
        }
        column.close()
    }
}

/// The values that are there, and for each row whether it has one (1) or not (0).
fn present<T: Clone>(values: &[Option<T>]) -> (Vec<T>, Vec<i16>) {
    (values.iter().flatten().cloned().collect(), values.iter().map(|value| value.is_some().into()).collect())
}

fn file_of(table: &Table) -> Result<Vec<u8>, ParquetError> {
    let columns: Vec<Column> = (0..table.columns.len()).map(|place| Column::of_table(table, place)).collect();
    let fields = columns.iter().zip(&table.columns).map(|(column, name)| column.schema(name));
    let fields = fields.collect::<Result<Vec<_>, _>>()?;
    let schema = Arc::new(Type::group_type_builder("study").with_fields(fields).build()?);
    let mut file = SerializedFileWriter::new(Vec::new(), schema, Arc::new(WriterProperties::default()))?;
    let mut group = file.next_row_group()?;
    columns.iter().try_for_each(|column| column.write(&mut group))?;
    group.close()?;
    file.into_inner()
}
