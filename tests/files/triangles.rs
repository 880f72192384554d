//! Files in the formats STL and OBJ.

use super::Expected::{self, Read, Refused};
use super::{combinations, judge, parts, read};
use diptych::experiment::{Experiment, Model};
use diptych::walls::{Geometry, Mesh, WallGeometry};
use nalgebra::Vector3;
use parts::{COMB, CUBE, Heap, binary, cube, text};

/// Case of a box of 40 mm with a bead in a corner, and with the file as a wall.
const CASE: &str = "domain = { size = [\"40 mm\", \"40 mm\", \"40 mm\"] }\nparticles = [{ diameter = \"1 mm\", density = \"2500 kg/m^3\", at = [AT] }]\n\
    walls = [{ mesh = { file = \"FILE\", unit = \"1 mm\", position = [\"20 mm\", \"20 mm\", \"20 mm\"]EXTRA }, restitution = 0.9 }]\n\
    contact = { restitution = 0.9 }\nrun = { duration = \"1 ms\" }\n";
const CORNER: &str = "{ position = [\"1 mm\", \"1 mm\", \"1 mm\"] }";

fn case(extra: &str, at: &str) -> String {
    CASE.replace("EXTRA", extra).replace("AT", at)
}

/// Mesh of the first wall.
fn mesh(experiment: &Experiment) -> &Mesh {
    let WallGeometry::Mesh(mesh) = &experiment.scene.walls[0].geometry else { panic!("no mesh") };
    mesh
}

/// Result of reading a file: the number of its triangles and the warnings, or the message of the error.
fn found(name: &str, bytes: &[u8]) -> Result<(usize, Vec<String>), String> {
    let read = read(name, bytes, &case("", CORNER), Model::Hard);
    read.map(|(experiment, told)| (mesh(&experiment).triangles().1.len(), told))
}

fn words(bytes: &[u8], from: &str, to: &str) -> Vec<u8> {
    String::from_utf8_lossy(bytes).replace(from, to).into_bytes()
}

/// File in text form, and its number of triangles.
type Text = (Vec<u8>, usize);

#[test]
fn text_stl_is_read_however_it_is_written() {
    let plain: Text = (text("cube", &cube(5.0)), 12);
    let oddities: [(&str, fn(Text) -> Text); 12] = [
        ("two solids", |(mut bytes, count)| {
            bytes.extend(text(
                "other",
                &cube(4.0).map(|triangle| triangle.map(|corner| corner + Vector3::repeat(12.0))),
            ));
            (bytes, count + 12)
        }),
        ("no name", |(bytes, count)| (words(&bytes, "solid cube", "solid"), count)),
        ("a name in Latin-1", |(bytes, count)| {
            let at = bytes.windows(5).position(|five| five == b"solid").map_or(0, |at| at + 5);
            ([&bytes[..at], b" W\xfcrfel facet ", &bytes[at..]].concat(), count)
        }),
        ("normals that are no numbers", |(bytes, count)| {
            (words(&bytes, "normal 0 0 0", "normal nan -nan(ind) 1,5"), count)
        }),
        ("without normals", |(bytes, count)| (words(&bytes, "facet normal 0 0 0", "facet"), count)),
        ("tabs and blanks", |(bytes, count)| (words(&bytes, " ", "\t  "), count)),
        ("no endsolid", |(bytes, count)| (words(&words(&bytes, "endsolid cube\n", ""), "endsolid other\n", ""), count)),
        ("capitals", |(bytes, count)| (bytes.to_ascii_uppercase(), count)),
        ("a blank before the first word", |(bytes, count)| ([b"\n  ", &bytes[..]].concat(), count)),
        ("CR LF", |(bytes, count)| {
            (bytes.iter().flat_map(|&b| if b == b'\n' { vec![b'\r', b'\n'] } else { vec![b] }).collect(), count)
        }),
        ("CR", |(bytes, count)| (bytes.iter().map(|&b| if b == b'\n' { b'\r' } else { b }).collect(), count)),
        ("byte order mark", |(bytes, count)| ([b"\xef\xbb\xbf", &bytes[..]].concat(), count)),
    ];
    let all = combinations(&plain, &oddities);
    assert_eq!(all.len(), 79);
    for (what, (bytes, count)) in all {
        judge(&what, &found("part.stl", &bytes), &Read(count, &[]));
    }
}

#[test]
fn binary_stl_is_told_by_its_length() {
    let whole = binary(b"made by hand", &cube(5.0));
    let with_count = |count: u32| {
        let mut bytes = whole.clone();
        bytes[80..84].copy_from_slice(&count.to_le_bytes());
        bytes
    };
    let with_corner = |bits: u32| {
        let mut bytes = whole.clone();
        bytes[84 + 50 * 6 + 12..][..4].copy_from_slice(&bits.to_le_bytes());
        bytes
    };
    let (none, many): (&[&str], _) = (&[], [&whole[..], &[7; 500]].concat());
    let rows: Vec<(&str, Vec<u8>, Expected)> = vec![
        ("plain", whole.clone(), Read(12, none)),
        ("a head as of a text", binary(b"solid cube\nfacet normal 0 0 0\n", &cube(5.0)), Read(12, none)),
        ("a head in capitals", binary(b"SOLID", &cube(5.0)), Read(12, none)),
        ("a few bytes more", [&whole[..], b"\r\n\0"].concat(), Read(12, &["3 bytes after the last of its 12 triangles, left aside"])),
        ("count too small", with_count(10), Refused(&["no binary STL file", "announces 10 triangles, 12 are there"])),
        ("count of none", with_count(0), Refused(&["announces 0 triangles, 12 are there"])),
        ("count too large", with_count(28), Refused(&["announces 28 triangles, 12 are there"])),
        ("count far too large", with_count(u32::MAX), Refused(&["announces 4294967295 triangles, 12 are there"])),
        ("cut short", whole[..whole.len() - 7].to_vec(), Refused(&["announces 12 triangles, 11 are there and 43 bytes of one more"])),
        ("cut short, a head as of a text", binary(b"solid", &cube(5.0))[..300].to_vec(), Refused(&["12 triangles, 4 are there"])),
        ("ten triangles more", many, Refused(&["announces 12 triangles, 22 are there"])),
        ("a corner that is no number", with_corner(0x7fc0_0000), Refused(&["no binary STL file", "triangle 7"])),
        ("a corner at no end", with_corner(0xff80_0000), Refused(&["no binary STL file", "triangle 7"])),
        ("a head alone", whole[..80].to_vec(), Refused(&["is no STL file"])),
        ("nothing", Vec::new(), Refused(&["is no STL file"])),
        ("another format", b"ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\nend_header\n".to_vec(), Refused(&["is no STL file"])),
    ];
    for (what, bytes, expected) in &rows {
        judge(what, &found("part.stl", bytes), expected);
    }
}

#[test]
fn text_stl_that_is_not_whole_is_refused_with_its_line() {
    let whole = text("cube", &cube(5.0));
    let lines =
        |count: usize| whole.split_inclusive(|byte| *byte == b'\n').take(count).flatten().copied().collect::<Vec<u8>>();
    let rows: Vec<(&str, Vec<u8>, Expected)> = vec![
        ("without the end", lines(1 + 7 * 12), Read(12, &[])),
        ("broken off at a corner", lines(1 + 7 + 4), Refused(&["no text STL file", "line 9", "ends in triangle 2"])),
        (
            "broken off between numbers",
            whole[..whole.len() - 36].to_vec(),
            Refused(&["no text STL file", "line 79", "triangle 12"]),
        ),
        ("before endfacet", lines(7), Refused(&["line 2", "ends in triangle 1"])),
        (
            "two corners",
            words(&whole, "  vertex -5 -5 5\n", ""),
            Refused(&["line 20", "`vertex` belongs, in triangle 3"]),
        ),
        (
            "four corners",
            words(&whole, " endloop", "  vertex 1 2 3\n endloop"),
            Refused(&["line 7", "\"vertex\" where `endloop` belongs"]),
        ),
        (
            "a decimal comma",
            words(&whole, "vertex -5", "vertex -5,0"),
            Refused(&["line 4", "\"-5,0\" is not a finite number"]),
        ),
        ("a corner that is no number", words(&whole, "vertex -5", "vertex nan"), Refused(&["line 4", "\"nan\""])),
        ("a corner at no end", words(&whole, "vertex -5", "vertex 1e999"), Refused(&["line 4", "\"1e999\""])),
        (
            "a word of another format",
            words(&whole, "endsolid", "color 1 0 0\nendsolid"),
            Refused(&["line 86", "\"color\""]),
        ),
        ("no loop", words(&whole, "outer loop", ""), Refused(&["line 2", "no `outer loop`"])),
        ("a name alone", b"solid".to_vec(), Refused(&["no triangles with an area"])),
    ];
    for (what, bytes, expected) in &rows {
        judge(what, &found("part.stl", bytes), expected);
    }
}

/// OBJ file with the corners of [`CUBE`] and the given faces.
fn obj(faces: &str) -> Vec<u8> {
    format!("{}{faces}\n", CUBE.split("f ").next().unwrap()).into_bytes()
}

#[test]
fn obj_is_read_however_it_is_written() {
    let plain: Text = (CUBE.into(), 12);
    let oddities: [(&str, fn(Text) -> Text); 10] = [
        ("negative numbers", |(bytes, count)| {
            let text = String::from_utf8(bytes).unwrap();
            let turned =
                |word: &str| word.parse::<i32>().map_or_else(|_| word.to_owned(), |number| (number - 9).to_string());
            let line = |line: &str| match line.strip_prefix("f ") {
                Some(face) => format!("f {}\n", face.split(' ').map(turned).collect::<Vec<_>>().join(" ")),
                None => format!("{line}\n"),
            };
            (text.lines().map(line).collect::<String>().into_bytes(), count)
        }),
        ("textures and normals", |(bytes, count)| {
            let text = words(&bytes, "f 1 ", "vt 0 0\nvn 0 0 1\nf 1/1/1 ");
            (words(&text, " 4\n", " 4//1\n"), count)
        }),
        ("a corner named twice", |(bytes, count)| (words(&bytes, "f 1 ", "f 1 1 "), count)),
        ("groups and materials", |(bytes, count)| {
            (words(&bytes, "f 1 ", "o cube\ng side\nusemtl steel\ns off\nl 1 2\nf 1 "), count)
        }),
        ("comments", |(bytes, count)| (words(&bytes, "\n", " # of the part\n#f 8 2 9\n"), count)),
        ("broken lines", |(bytes, count)| (words(&bytes, "f 1 ", "f 1 \\\n "), count)),
        ("a broken number", |(bytes, count)| (words(&bytes, "v -5 -5 ", "v -5\\\n -5 "), count)),
        ("CR LF", |(bytes, count)| (words(&bytes, "\n", "\r\n"), count)),
        ("CR", |(bytes, count)| (words(&bytes, "\n", "\r"), count)),
        ("byte order mark", |(bytes, count)| ([b"\xef\xbb\xbf", &bytes[..]].concat(), count)),
    ];
    for (what, (bytes, count)) in combinations(&plain, &oddities) {
        judge(&what, &found("part.obj", &bytes), &Read(count, &[]));
    }
    let rows: Vec<(&str, Vec<u8>, Expected)> = vec![
        (
            "a corner that is not there",
            obj("f 1 2 9"),
            Refused(&["no OBJ file", "line 9", "corner 9 is not there: the file has 8"]),
        ),
        ("a corner 0", obj("f 0 2 3"), Refused(&["line 9", "\"0\" is no corner"])),
        ("too far back", obj("f -1 -2 -9"), Refused(&["line 9", "corner -9 is not there: 8 corners stand before"])),
        ("the least number", obj("f -9223372036854775808 1 2"), Refused(&["line 9", "is not there"])),
        ("two corners", obj("f 1 2"), Refused(&["line 9", "three corners or more, 2 are there"])),
        ("two coordinates", b"v 1 2\nf 1 1 1\n".to_vec(), Refused(&["line 1", "three coordinates"])),
        ("no number", b"v 1 2 x\nf 1 1 1\n".to_vec(), Refused(&["line 1", "\"x\" is not a finite number"])),
        ("no faces", b"v 1 2 3\n".to_vec(), Refused(&["no OBJ file", "no faces"])),
        (
            "a curved surface",
            [CUBE.as_bytes(), b"cstype bezier\nsurf 0 1 0 1 1 2 3 4\n"].concat(),
            Read(12, &["2 statements", "\"cstype\" in line 15"]),
        ),
        ("crosses itself", obj("f 1 3 2 4"), Refused(&["line 9", "crosses itself"])),
        (
            "crosses itself, star",
            b"v 0 9 0\nv 5 -7 0\nv -8 3 0\nv 8 3 0\nv -5 -7 0\nf 1 2 3 4 5\n".to_vec(),
            Refused(&["line 6", "crosses itself"]),
        ),
        (
            "a face bent by a third",
            obj("f 1 2 3 8").to_vec(),
            Read(2, &["1 polygons that are not flat", "line 9", "not watertight"]),
        ),
    ];
    for (what, bytes, expected) in &rows {
        judge(what, &found("part.obj", bytes), expected);
    }
}

/// Volume [mm³] of a closed mesh; positive if its normals point outwards.
fn volume(mesh: &Mesh) -> f64 {
    let (points, triangles) = mesh.triangles();
    let each = triangles.map(|corners| {
        let [a, b, c] = corners.map(|corner| points[corner as usize] * 1e3);
        a.dot(&b.cross(&c)) / 6.0
    });
    each.sum()
}

/// Prisms over polygons that are not convex are closed, and have the volume of the outline, at any position and angle.
#[test]
fn polygons_that_are_not_convex_keep_their_volume() {
    let outlines: [(&str, Vec<[f64; 2]>); 5] = [
        ("an L", vec![[0., 0.], [4., 0.], [4., 1.], [1., 1.], [1., 3.], [0., 3.]]),
        ("an arrow that a fan would leave", vec![[0., 0.], [4., 0.], [1., 1.], [0., 4.]]),
        ("a comb", COMB.to_vec()),
        ("corners in straight edges", vec![[0., 0.], [1., 0.], [2., 0.], [2., 2.], [1., 2.], [0., 2.], [0., 1.]]),
        (
            "a hole with a way to it",
            vec![[0., 0.], [6., 0.], [6., 6.], [0., 6.], [0., 0.], [2., 2.], [2., 4.], [4., 4.], [4., 2.], [2., 2.]],
        ),
    ];
    for (name, outline) in &outlines {
        let doubled =
            outline.iter().zip(outline.iter().cycle().skip(1)).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>();
        for turn in 0..6 {
            let bytes = parts::prism(outline, 3.0, f64::from(turn) * 0.7);
            let (experiment, told) = read("part.obj", &bytes, &case("", CORNER), Model::Hard)
                .unwrap_or_else(|error| panic!("{name}: {error}"));
            let told: Vec<String> = told.into_iter().filter(|told| !told.contains("were made one")).collect();
            assert!(told.is_empty(), "{name}, {turn}: {told:#?}");
            let found = volume(mesh(&experiment));
            assert!((found - 1.5 * doubled).abs() < 1e-5 * doubled, "{name}, {turn}: {found} of {}", 1.5 * doubled);
        }
    }
}

/// Distance [mm] to the surface from points on the x axis [mm] relative to the middle of the box.
fn distances(experiment: &Experiment, along: &[f64]) -> Vec<f64> {
    let at = |x: &f64| mesh(experiment).nearest(&(Vector3::new(20.0 + x, 20.1, 20.2) * 1e-3)).distance * 1e3;
    along.iter().map(|x| at(x).round()).collect()
}

fn turned(heap: Heap) -> Heap {
    heap.into_iter().map(|[a, b, c]| [a, c, b]).collect()
}

#[test]
fn a_part_within_an_odd_number_of_others_faces_inwards() {
    let shell = |half: f64| cube(half).to_vec();
    let vessel = |inner: Heap| text("vessel", &[shell(15.0), inner].concat());
    let three = |inner: Heap| text("three", &[shell(15.0), inner, shell(5.0)].concat());
    // points in the middle, in the innermost of three shells, in the wall, and outside
    let along = [0.0, 7.0, 12.0, 17.0];
    let rows: Vec<(&str, Vec<u8>, &str, [f64; 4], &[&str])> = vec![
        (
            "drawn as a wall",
            vessel(turned(shell(10.0))),
            "",
            [10., 3., -2., 2.],
            &["1 cavities, closed parts within others: particles may be in them and outside"],
        ),
        ("drawn as two bodies", vessel(shell(10.0)), "", [10., 3., -2., 2.], &["1 cavities", "1 were drawn as bodies"]),
        (
            "all of it inside out",
            text("vessel", &[turned(shell(15.0)), shell(10.0)].concat()),
            "",
            [10., 3., -2., 2.],
            &["1 cavities", "pointed inwards, turned round"],
        ),
        ("a body in the cavity", three(turned(shell(10.0))), "", [-5., 2., -2., 2.], &["1 cavities"]),
        (
            "particles in the cavity",
            vessel(turned(shell(10.0))),
            ", inside = true",
            [10., 3., -2., -7.],
            &["particles are in them; 1 outer skins around them are left out"],
        ),
        (
            "particles about a body in the cavity",
            three(turned(shell(10.0))),
            ", inside = true",
            [-5., 2., -2., -7.],
            &["1 outer skins"],
        ),
        (
            "a body in a vessel",
            vessel(shell(10.0)),
            ", inside = true",
            [-10., -3., 2., -2.],
            &["1 closed parts within others: they are bodies in the vessel"],
        ),
        ("one skin", text("vessel", &shell(15.0)), ", inside = true", [15., 8., 3., -2.], &[]),
    ];
    for (what, bytes, extra, wanted, parts) in &rows {
        // the bead in the corner of the box is outside the mesh, which the key `inside` does not allow
        let at = if extra.is_empty() { CORNER } else { "" };
        let (experiment, told) =
            read("part.stl", bytes, &case(extra, at), Model::Hard).unwrap_or_else(|error| panic!("{what}: {error}"));
        assert_eq!(distances(&experiment, &along), wanted, "{what}: {told:#?}");
        let told = told.join("\n");
        assert_eq!(told.is_empty(), parts.is_empty(), "{what}: {told}");
        assert!(parts.iter().all(|part| told.contains(part)), "{what}: {told}");
        assert!(what.contains("inside out") || !told.contains("turned round"), "{what}: {told}");
    }
    // two shells that intersect, and two shells side by side, are solid bodies
    let beside = |by: f64| {
        [shell(5.0), shell(4.0).into_iter().map(|three| three.map(|corner| corner + Vector3::x() * by)).collect()]
            .concat()
    };
    judge(
        "crossing",
        &found("part.stl", &text("two", &beside(3.0))),
        &Read(24, &["2 closed parts that are partly within others"]),
    );
    judge("beside", &found("part.stl", &text("two", &beside(12.0))), &Read(24, &[]));
}

#[test]
fn no_bead_starts_in_the_wall_of_a_vessel() {
    let vessel = text("vessel", &[cube(15.0).to_vec(), turned(cube(10.0).to_vec())].concat());
    for (extra, least) in [("", 20), (", inside = true", 200)] {
        let text = case(extra, "").replace("at = []", "count = 200");
        let (experiment, _) = read("part.stl", &vessel, &text, Model::Hard).unwrap();
        let particles = diptych::placement::initial_state(&experiment).unwrap();
        let from_middle = |x: &Vector3<f64>| (x - Vector3::repeat(0.02)).amax() * 1e3;
        let away: Vec<f64> = particles.position.iter().map(from_middle).collect();
        assert!(away.iter().all(|away| *away < 9.5 || *away > 15.5), "{extra}");
        assert!(away.iter().filter(|away| **away < 9.5).count() >= least, "{extra}");
    }
    let middle = "{ position = [\"20 mm\", \"20 mm\", \"20 mm\"] }";
    read("part.stl", &vessel, &case("", middle), Model::Hard).unwrap();
    let metal = "{ position = [\"20 mm\", \"20 mm\", \"32.5 mm\"] }";
    assert!(read("part.stl", &vessel, &case("", metal), Model::Hard).is_err());
}

#[test]
fn corners_that_differ_by_rounding_are_one_wherever_the_part_is() {
    // each triangle has its own rounding of its corners, as in files of programs that compute corners one by one
    for (size, off, unit) in [(5.0, 0.0, 1.0), (5.0, 40.0, 1.0), (500.0, 0.0, 0.01), (5e-3, 0.1, 1e3)] {
        let heap: Heap = cube(size).iter().map(|three| three.map(|corner| corner + Vector3::repeat(off))).collect();
        let mut rough = binary(b"rough", &heap);
        for (k, triangle) in rough[84..].chunks_exact_mut(50).enumerate() {
            for (n, four) in triangle[12..48].chunks_exact_mut(4).enumerate() {
                let bits = u32::from_le_bytes([four[0], four[1], four[2], four[3]]);
                four.copy_from_slice(&(bits + ((k + n) % 3) as u32).to_le_bytes());
            }
        }
        let text = case("", CORNER).replace("\"1 mm\", pos", &format!("\"{unit} mm\", pos"));
        let text = text
            .replace("[\"20 mm\", \"20 mm\", \"20 mm\"]EXTRA", &format!("[{0}, {0}, {0}]", 0.02 - off * unit * 1e-3));
        let text = text.replace(
            "[\"20 mm\", \"20 mm\", \"20 mm\"]",
            &format!("[\"{0} mm\", \"{0} mm\", \"{0} mm\"]", 20.0 - off * unit),
        );
        let (experiment, told) =
            read("part.stl", &rough, &text, Model::Hard).unwrap_or_else(|error| panic!("{size}: {error}"));
        let told = told.join("\n");
        assert!(
            told.contains("corners that differ from others by the rounding") && !told.contains("watertight"),
            "{size}, {off}: {told}"
        );
        assert_eq!(mesh(&experiment).triangles().0.len(), 8, "{size}, {off}");
        assert!(mesh(&experiment).nearest(&Vector3::repeat(0.02)).distance < 0.0);
    }
    // a larger distance between corners is a slit
    let mut slit = cube(5.0);
    slit[0][0].x += 1e-4;
    judge("slit", &found("part.stl", &binary(b"slit", &slit)), &Read(12, &["not watertight"]));
    // six digits; the last digit differs
    let mut rough = text("rough", &cube(5.0).map(|three| three.map(|corner| corner * 0.246_914)));
    let at = rough.windows(7).rposition(|seven| seven == b"1.23457").unwrap();
    rough[at + 6] = b'6';
    judge("text", &found("part.stl", &rough), &Read(12, &["rounding of its numbers only"]));
}
