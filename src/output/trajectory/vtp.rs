//! Writes VTK files of points, lines, polygons and grids with raw binary data for ParaView. The numbers are written
//! without rounding.
//!
//! File format: VTK File Formats, "XML file formats",
//! <https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html>.

use std::fmt::Write;

/// [byte] size of the buffer in which numbers are collected before they are appended to the file. It is a multiple of
/// the size of an array entry, which has 1, 3 or 6 numbers of at most 8 bytes.
const PIECE: usize = 6144;

/// VTK file under construction: a header in XML that describes the arrays, and the bytes of the arrays in the same
/// order.
pub(in crate::output) struct Vtp {
    /// Kind of the data set in VTK: `PolyData`, or `ImageData` for a grid.
    kind: &'static str,
    header: String,
    data: Vec<u8>,
    /// XML text that declares the arrays with values per point, for a file that joins several pieces.
    of_points: String,
}

/// Type of the numbers in an array of a VTK file.
pub(in crate::output) trait Number: Copy {
    /// Name of this type of number in VTK files.
    const NAME: &'static str;

    /// Writes the bytes of the number in little-endian order to `bytes`.
    fn put(self, bytes: &mut [u8]);
}

macro_rules! numbers {
    ($($kind:ty: $name:literal),+) => {
        $(impl Number for $kind {
            const NAME: &'static str = $name;

            fn put(self, bytes: &mut [u8]) {
                bytes.copy_from_slice(&self.to_le_bytes());
            }
        })+
    };
}

numbers!(f64: "Float64", i32: "Int32", u32: "UInt32", u16: "UInt16", u8: "UInt8");

impl Vtp {
    /// Begins a VTK file of the state at `time` [s] with the given numbers of points, vertex cells (cells that make
    /// points visible) and polygons. The bytes of `memory` are overwritten by the data, so that no new memory is
    /// needed.
    pub(super) fn begin(memory: Vec<u8>, time: f64, [points, vertices, polygons]: [usize; 3]) -> Self {
        let counts = format!("NumberOfPoints=\"{points}\" NumberOfVerts=\"{vertices}\" NumberOfPolys=\"{polygons}\"");
        Self::of_kind("PolyData", memory, time, ["", &counts])
    }

    /// VTK file of `lines` lines at the simulated time `time` [s]. `ends` has the two end points [m] of each line.
    /// `arrays` adds arrays with one value per line.
    pub(in crate::output) fn of_lines(
        time: f64,
        lines: usize,
        ends: impl Iterator<Item = [[f64; 3]; 2]>,
        arrays: impl FnOnce(&mut Self),
    ) -> Vec<u8> {
        let counts = format!("NumberOfPoints=\"{}\" NumberOfLines=\"{lines}\"", 2 * lines);
        let mut file = Self::of_kind("PolyData", Vec::new(), time, ["", &counts]);
        file.part("CellData", arrays);
        file.part("Points", |file| file.array::<f64, 3>("Points", ends.flatten()));
        file.part("Lines", |file| {
            file.array("connectivity", (0..2 * lines as i32).map(|point| [point]));
            file.array("offsets", (1..=lines as i32).map(|line| [2 * line]));
        });
        file.finish().concat()
    }

    /// VTK file of a grid at the simulated time `time` [s]. The grid has the given numbers of cells along x, y and z,
    /// with the edges `spacing` [m]. `arrays` adds arrays with one value per cell.
    pub(in crate::output) fn of_grid(
        time: f64,
        [x, y, z]: [usize; 3],
        spacing: [f64; 3],
        arrays: impl FnOnce(&mut Self),
    ) -> Vec<u8> {
        let extent = format!("0 {x} 0 {y} 0 {z}");
        let edges = spacing.map(|edge| format!("{edge:?}")).join(" ");
        let whole = format!(" WholeExtent=\"{extent}\" Origin=\"0 0 0\" Spacing=\"{edges}\"");
        let piece = format!("Extent=\"{extent}\"");
        let mut file = Self::of_kind("ImageData", Vec::new(), time, [&whole, &piece]);
        file.part("CellData", arrays);
        file.finish().concat()
    }

    /// Begins a VTK file with a data set of the kind `kind`, at the simulated time `time` [s]. `whole` and `piece` are
    /// the XML attributes of the data set and of its only piece.
    fn of_kind(kind: &'static str, mut memory: Vec<u8>, time: f64, [whole, piece]: [&str; 2]) -> Self {
        memory.clear();
        let mut header = format!(
            "<?xml version=\"1.0\"?>\n<!-- written by diptych -->\n\
             <VTKFile type=\"{kind}\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<{kind}{whole}>\n",
        );
        // writing to a string cannot fail
        let _ = writeln!(header, "{}<Piece {piece}>", time_value(time));
        Self { kind, header, data: memory, of_points: String::new() }
    }

    /// Adds a section of the file with the name `name`, such as `Points`. `arrays` adds the arrays of the section.
    pub(super) fn part(&mut self, name: &str, arrays: impl FnOnce(&mut Self)) {
        let before = self.of_points.len();
        let _ = writeln!(self.header, "<{name}>");
        let _ = writeln!(self.of_points, "<P{name}>");
        arrays(self);
        let _ = writeln!(self.header, "</{name}>");
        let _ = writeln!(self.of_points, "</P{name}>");
        if !matches!(name, "PointData" | "Points") {
            self.of_points.truncate(before);
        }
    }

    /// Adds an array with the name `name`. An entry belongs, for example, to a point or a cell, and has `C` numbers.
    pub(in crate::output) fn array<T: Number, const C: usize>(
        &mut self,
        name: &str,
        mut values: impl Iterator<Item = [T; C]>,
    ) {
        let _ = writeln!(
            self.header,
            "<DataArray type=\"{}\" Name=\"{name}\" NumberOfComponents=\"{C}\" format=\"appended\" offset=\"{}\"/>",
            T::NAME,
            self.data.len()
        );
        let (kind, points) = (T::NAME, &mut self.of_points);
        let _ = writeln!(points, "<PDataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{C}\"/>");
        let start = self.data.len();
        self.data.extend_from_slice(&[0; 8]);
        // the buffer is small enough for the processor cache; appending numbers one by one would take several times as
        // long
        let mut piece = [0; PIECE];
        loop {
            let mut used = 0;
            for (place, value) in piece.chunks_exact_mut(C * size_of::<T>()).zip(&mut values) {
                place.chunks_exact_mut(size_of::<T>()).zip(value).for_each(|(bytes, number)| number.put(bytes));
                used += C * size_of::<T>();
            }
            self.data.extend_from_slice(&piece[..used]);
            if used == 0 {
                break;
            }
        }
        let length = (self.data.len() - start - 8) as u64;
        self.data[start..start + 8].copy_from_slice(&length.to_le_bytes());
    }

    /// Text of a VTK file that joins several files (`pieces`) of the state at `time` [s]. The names of the pieces are
    /// relative to this file.
    pub(super) fn join(self, time: f64, pieces: impl Iterator<Item = String>) -> Vec<u8> {
        let mut text = String::from(
            "<?xml version=\"1.0\"?>\n<!-- written by diptych -->\n\
             <VTKFile type=\"PPolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<PPolyData GhostLevel=\"0\">\n",
        );
        // writing to a string cannot fail
        let _ = writeln!(text, "{}{}", time_value(time), self.of_points.trim_end());
        for piece in pieces {
            let _ = writeln!(text, "<Piece Source=\"{piece}\"/>");
        }
        text += "</PPolyData>\n</VTKFile>\n";
        text.into_bytes()
    }

    /// Finishes the file, and returns its header, data and end, to be written in this order.
    pub(super) fn finish(mut self) -> [Vec<u8>; 3] {
        let _ = write!(self.header, "</Piece>\n</{}>\n<AppendedData encoding=\"raw\">\n_", self.kind);
        [self.header.into_bytes(), self.data, b"\n</AppendedData>\n</VTKFile>\n".to_vec()]
    }
}

/// XML element with the time [s] of a file.
fn time_value(time: f64) -> String {
    format!(
        "<FieldData><DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{time:?}</DataArray>\
         </FieldData>\n"
    )
}
