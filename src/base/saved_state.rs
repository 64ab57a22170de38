//! Serialisation of a simulation state: values are read back in the order in which they were written, bit for bit.

use crate::error::{Error, Result};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// Writer of a sequence of values.
#[derive(Debug, Clone, Default)]
pub struct StateWriter {
    bytes: Vec<u8>,
    /// Error of the first value that could not be written.
    failed: Option<postcard::Error>,
}

impl StateWriter {
    /// Writes `value`. After the first failure nothing more is written, and [`StateWriter::finish`] returns the
    /// error.
    pub fn write(&mut self, value: &impl Serialize) {
        if self.failed.is_none() {
            match postcard::to_stdvec(value) {
                Ok(bytes) => self.bytes.extend(bytes),
                Err(error) => self.failed = Some(error),
            }
        }
    }

    /// Returns the bytes of all values.
    ///
    /// # Errors
    /// Fails if a value could not be written: a sequence of unknown length, or a value whose serialisation fails.
    pub fn finish(self) -> Result<Vec<u8>> {
        match self.failed {
            None => Ok(self.bytes),
            Some(error) => Err(Error::Solver(format!("the state cannot be saved: {error}"))),
        }
    }
}

/// Reader of the bytes of a [`StateWriter`]; holds those not yet read.
#[derive(Debug, Clone, Copy)]
pub struct StateReader<'a>(pub &'a [u8]);

impl StateReader<'_> {
    /// Reads the next value.
    ///
    /// # Errors
    /// Fails if the bytes are truncated or do not encode a `T`.
    pub fn read<T: DeserializeOwned>(&mut self) -> Result<T> {
        let (value, rest) = postcard::take_from_bytes(self.0).map_err(|e| {
            Error::Start(format!(
                "the saved state cannot be read: {e}; it is truncated, damaged or from another version"
            ))
        })?;
        self.0 = rest;
        Ok(value)
    }

    /// Reads a sequence into `values`.
    ///
    /// # Errors
    /// Fails as [`StateReader::read`] does, and if the number of values differs.
    pub fn read_into<T: DeserializeOwned>(&mut self, values: &mut [T]) -> Result<()> {
        let read: Vec<T> = self.read()?;
        if read.len() != values.len() {
            return Err(Error::Start(format!(
                "the saved state has {} values instead of {}: it belongs to another scene",
                read.len(),
                values.len()
            )));
        }
        values.iter_mut().zip(read).for_each(|(value, read)| *value = read);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_back_bit_for_bit_and_a_cut_is_noticed() {
        let mut history = StateWriter::default();
        history.write(&vec![f64::INFINITY, -0.0, 1.0 / 3.0]);
        history.write(&(Some(7_u32), true));
        let bytes = history.finish().unwrap();
        let mut reader = StateReader(&bytes);
        let mut values = [0.0_f64; 3];
        reader.read_into(&mut values).unwrap();
        assert_eq!(values.map(f64::to_bits), [f64::INFINITY, -0.0, 1.0 / 3.0].map(f64::to_bits));
        assert_eq!(reader.read::<(Option<u32>, bool)>().unwrap(), (Some(7), true));
        assert!(reader.read::<u32>().is_err(), "nothing is left");
        assert!(StateReader(&bytes[..20]).read::<Vec<f64>>().is_err(), "cut off");
        assert!(StateReader(&bytes).read_into(&mut [0.0_f64; 2]).is_err(), "another length");
    }

    /// Value whose serialisation fails.
    struct Refuses;

    impl Serialize for Refuses {
        fn serialize<S: serde::Serializer>(&self, _: S) -> std::result::Result<S::Ok, S::Error> {
            Err(serde::ser::Error::custom("refused"))
        }
    }

    #[test]
    fn a_value_that_cannot_be_written_is_an_error_and_no_gap() {
        let mut history = StateWriter::default();
        history.write(&1_u32);
        history.write(&Refuses);
        history.write(&2_u32);
        assert!(history.finish().unwrap_err().to_string().contains("the state cannot be saved"));
    }
}
